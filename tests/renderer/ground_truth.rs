//! Hard cases with exact answers, asked in both precisions. See `tests/ground_truth/README.md`.

use crate::common::questions::{FILES, ask};
use strahl::scene::description::Precision;

/// Queries that strahl is known to answer wrongly: file, query and precision. Each must still fail.
const KNOWN_GAPS: &[(&str, &str, Precision)] = &[];

fn ask_all(file: &str) {
    assert!(FILES.contains(&file), "{file} is not in the list of files");
    let mut wrong = Vec::new();
    for precision in [Precision::Single, Precision::Double] {
        for outcome in ask(file, precision) {
            let name = outcome.name;
            let known = KNOWN_GAPS.contains(&(file, &name, precision));
            match outcome.check {
                Err(why) if !known => wrong.push(format!("{name} in {precision:?}: {why}")),
                Ok(()) if known => wrong.push(format!("{name} in {precision:?} is answered now: it is no gap")),
                _ => {}
            }
        }
    }
    assert!(wrong.is_empty(), "{file}:\n{}", wrong.join("\n"));
}

macro_rules! ask {
    ($($file:ident)*) => {
        $(
            #[test]
            fn $file() {
                ask_all(stringify!($file));
            }
        )*
    };
}

ask! {
    sphere_far sphere_grazing sphere_origin_on_surface camera_far plane_far plane_grazing disc_rim torus_quartic
    cylinder_parallel_axis aabb_slab_nan normalize_extreme tri_degenerate tri_shared_edge tri_vertex_fan tri_tiny
    instance_normals glass_sphere_deviation refract_slab refract_critical fermat_plane fisheye_directions
    mirror_corridor phong_exponent
}
