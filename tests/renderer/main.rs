//! Tests of the renderer as a library: `cargo test --release --test renderer`. Folders are named as those of `src/`.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail loudly and say what it measured")]
#![allow(unreachable_pub, reason = "a test program has no outside")]

mod common;

mod analytic;
mod effects;
mod ground_truth;
mod hard_cases;

mod accel {
    mod leaves;
    mod watertight;
}
mod camera {
    mod projection;
    mod windows;
}
mod metrics {
    mod image_metrics;
}
mod models {
    mod bounds;
    mod default_look;
    mod exporters;
    mod files;
    mod forbidden;
    mod materials;
    mod pictures;
    mod placed;
    mod refusals;
    mod rigs;
    mod scenes;
    mod shared_meshes;
    mod shells;
    mod sizes;
}
mod plan {
    mod depth;
    mod estimates;
    mod savings;
}
mod project {
    mod examples;
    mod house_rules;
    mod layers;
    mod machine_code;
}
mod reference {
    mod agreement;
    mod random_scenes;
}
mod render {
    mod adaptive_sampling;
    mod confidence;
    mod golden;
    mod layers;
    mod measured;
    mod progressive;
    mod properties;
}
mod scene {
    mod effects;
    mod mutations;
    mod nff_files;
    mod spd;
    mod variations;
    mod warnings;
}
mod sequence {
    mod frames;
}
mod shading {
    mod terminator;
}
mod shape {
    mod distances;
    mod points;
}
mod trace {
    mod bounds;
    mod light_cells;
    mod nested_media;
    mod proof_costs;
    mod random_scenes;
    mod secondary_rays;
    mod stopping;
}
