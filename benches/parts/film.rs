//! Encoding a 1920 x 1080 picture: `cargo bench --bench film`.
#![allow(missing_docs, reason = "criterion's macros make items")]

use criterion::{Criterion, criterion_group, criterion_main};
use strahl::film::{FileFormat, Film, Region, encode};

fn formats(criterion: &mut Criterion) {
    let (width, height) = (1920, 1080);
    let pixel = |[x, y]: [u32; 2]| {
        let tile = if (x / 40 + y / 40) % 2 == 0 { 0.8 } else { 0.2 };
        [tile, x as f32 / width as f32, y as f32 / height as f32 * tile]
    };
    let region = Region::whole(width, height);
    let film = Film { region, full_width: width, full_height: height, pixels: region.iter().map(pixel).collect() };
    let mut group = criterion.benchmark_group("encode");
    group.sample_size(20);
    for format in
        [FileFormat::Png8, FileFormat::Png16, FileFormat::Jpeg(90), FileFormat::WebP, FileFormat::Exr, FileFormat::Pfm]
    {
        group.bench_function(format!("{format:?}"), |bencher| bencher.iter(|| encode(&film, format)));
    }
    group.finish();
}

criterion_group!(benches, formats);
criterion_main!(benches);
