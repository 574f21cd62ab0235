//! What must never change a pixel does not, with all effects.

use fearless_simd::Level;
use strahl::film::{Film, Region};
use strahl::render::{Control, RenderOptions, render_with};
use strahl::scene::{Format, Loaded, Overrides, load};

/// Every scene of the catalogue, small, with few samples, in both precisions.
fn catalogue() -> Vec<(String, Loaded)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/effects");
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let mut scenes = Vec::new();
    for path in paths.iter().filter(|path| path.extension().is_some_and(|e| e == "json")) {
        let text = std::fs::read(path).unwrap();
        for precision in [strahl::scene::description::Precision::Single, strahl::scene::description::Precision::Double]
        {
            let size = (Some(56), Some(36));
            let overrides = Overrides {
                width: size.0,
                height: size.1,
                samples: Some(3),
                precision: Some(precision),
                ..Overrides::default()
            };
            let loaded = load(&text, Format::Json, &overrides).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            scenes.push((format!("{} {precision:?}", path.file_stem().unwrap().display()), loaded));
        }
    }
    assert!(scenes.len() >= 12);
    scenes
}

fn film(loaded: &Loaded, region: Region, cut: RenderOptions) -> Film {
    render_with(&loaded.scene, region, &Control::default(), cut).unwrap().film
}

fn assert_same(name: &str, a: &Film, b: &Film) {
    let bits = |film: &Film| film.pixels.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>();
    let (a, b) = (bits(a), bits(b));
    let differing = a.iter().zip(&b).filter(|(a, b)| a != b).count();
    assert_eq!(differing, 0, "{name}");
}

#[test]
fn threads_tiles_instructions_and_kernels_do_not_change_a_byte() {
    let best = Level::new();
    let lower = [best.as_sse2().map(Level::Sse2), best.as_avx2().map(Level::Avx2)];
    for (name, loaded) in catalogue() {
        let whole = Region::whole(loaded.scene.width, loaded.scene.height);
        let expected = film(&loaded, whole, RenderOptions::default());
        assert!(expected.pixels.iter().flatten().all(|x| x.is_finite() && *x >= 0.0), "{name}");
        for tile in [1, 7, 64] {
            assert_same(&name, &expected, &film(&loaded, whole, RenderOptions { tile, ..RenderOptions::default() }));
        }
        for level in lower.into_iter().flatten() {
            assert_same(&name, &expected, &film(&loaded, whole, RenderOptions { level, ..RenderOptions::default() }));
        }
        assert_same(
            &name,
            &expected,
            &film(&loaded, whole, RenderOptions { specialised: false, ..RenderOptions::default() }),
        );
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert_same(&name, &expected, &pool.install(|| film(&loaded, whole, RenderOptions::default())));
        }
        let region = Region { x: 13, y: 5, width: 21, height: 17 };
        let part = film(&loaded, region, RenderOptions::default());
        for (pixel, [x, y]) in part.pixels.iter().zip(region.iter()) {
            assert_eq!(pixel, &expected.pixels[(y * whole.width + x) as usize], "{name} {x} {y}");
        }
    }
}
