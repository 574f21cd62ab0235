//! From scene text to a compiled scene, hierarchies included: `cargo bench --bench accel`.
#![allow(clippy::unwrap_used, missing_docs, reason = "a bench may fail loudly, and criterion's macros make items")]

use criterion::{Criterion, criterion_group, criterion_main};
use strahl::scene::compile::compile;
use strahl::scene::{Format, Overrides, load};

fn scenes(criterion: &mut Criterion) {
    for name in ["meshes/knot", "spheres/flake_9"] {
        let path = format!("{}/scenes/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read(path).unwrap();
        let description = load(&text, Format::Json, &Overrides::default()).unwrap().description;
        criterion.bench_function(&format!("compile {name}"), |bencher| bencher.iter(|| compile(&description)));
        criterion.bench_function(&format!("load {name}"), |bencher| {
            bencher.iter(|| load(&text, Format::Json, &Overrides::default()));
        });
    }
}

criterion_group!(benches, scenes);
criterion_main!(benches);
