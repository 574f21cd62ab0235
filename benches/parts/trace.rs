//! The tracing kernel on whole pictures: `cargo bench --bench trace`.
#![allow(clippy::unwrap_used, missing_docs, reason = "a bench may fail loudly, and criterion's macros make items")]

use criterion::{Criterion, criterion_group, criterion_main};
use strahl::film::Region;
use strahl::render::{Control, render};
use strahl::scene::description::Precision;
use strahl::scene::{Format, Overrides, load};

fn pictures(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("trace");
    group.sample_size(20);
    let one_sample = Overrides { antialias: Some(false), ..Overrides::default() };
    for (name, overrides) in [
        ("whitted/whitted", one_sample),
        ("whitted/whitted", Overrides { precision: Some(Precision::Double), ..one_sample }),
        ("mirrors/hall", one_sample),
        ("meshes/knot", one_sample),
        ("spheres/flake_4", Overrides { width: Some(256), height: Some(256), ..one_sample }),
        ("spheres/flake_9", Overrides { width: Some(128), height: Some(128), ..one_sample }),
    ] {
        let path = format!("{}/scenes/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let scene = load(&std::fs::read(path).unwrap(), Format::Json, &overrides).unwrap().scene;
        let precision = if overrides.precision.is_some() { "double" } else { "single" };
        group.bench_function(format!("{name}, {precision}"), |bencher| {
            bencher.iter(|| render(&scene, Region::whole(scene.width, scene.height), &Control::default()));
        });
    }
    group.finish();
}

criterion_group!(benches, pictures);
criterion_main!(benches);
