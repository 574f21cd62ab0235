//! Any part of a picture at any size: what a window shows is what a picture of that size would, and a tile is a crop of it.

use crate::common::{read, render_whole, scene_names};
use std::collections::HashSet;
use strahl::camera::Window;
use strahl::film::{Film, Region};
use strahl::render::{Control, render, render_window};
use strahl::scene::compile::Precise;
use strahl::scene::description::Precision;
use strahl::scene::{Format, Loaded, Overrides, load};
use strahl::trace::variants::KernelVariant;

const WIDTH: u32 = 24;
const HEIGHT: u32 = 16;

/// The scene of the repository in a picture of 2^-level times 24 x 16 pixels.
fn scene(name: &str, precision: Precision, level: i32) -> Loaded {
    let Window { width, height, .. } = Window::level(WIDTH, HEIGHT, level).unwrap();
    let overrides =
        Overrides { width: Some(width), height: Some(height), precision: Some(precision), ..Overrides::default() };
    load(&read(&format!("scenes/{name}.json")), Format::Json, &overrides).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn kernel(loaded: &Loaded) -> KernelVariant {
    match &loaded.scene.world {
        Precise::Single(world) => KernelVariant::of(world),
        Precise::Double(world) => KernelVariant::of(world),
    }
}

fn window(loaded: &Loaded, window: &Window, region: Region) -> Film {
    render_window(&loaded.scene, window, region, &Control::default()).unwrap().film
}

fn bits(film: &Film) -> Vec<[u32; 3]> {
    film.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

/// The bits of a part of a film.
fn crop(film: &Film, part: Region) -> Vec<[u32; 3]> {
    part.iter().map(|[x, y]| film.pixels[(y * film.full_width + x) as usize].map(f32::to_bits)).collect()
}

#[test]
fn levels_are_pictures_of_that_size_and_tiles_are_crops_of_them() {
    let mut kernels = HashSet::new();
    for name in scene_names() {
        for precision in [Precision::Single, Precision::Double] {
            let loaded = scene(&name, precision, 0);
            kernels.insert(format!("{:?}", kernel(&loaded)));
            for level in [-1, 0, 1, 2] {
                let what = format!("{name}, {precision:?}, level {level}");
                let shown = Window::level(WIDTH, HEIGHT, level).unwrap();
                let Window { width, height, .. } = shown;
                let whole = window(&loaded, &shown, Region::whole(width, height));
                assert_eq!((whole.full_width, whole.full_height), (width, height));
                assert_eq!(bits(&whole), bits(&render_whole(&scene(&name, precision, level))), "{what}");
                let tile = Region { x: width / 3, y: height / 4, width: width / 2, height: height / 2 };
                assert_eq!(bits(&window(&loaded, &shown, tile)), crop(&whole, tile), "{what}");
            }
        }
    }
    assert_eq!(kernels.len(), 4, "not every kernel is among the scenes: {kernels:?}");
}

#[test]
fn levels_that_do_not_divide_the_picture_reach_beyond_it() {
    let loaded = scene("whitted/whitted", Precision::Single, 0);
    let shown = Window::level(WIDTH, HEIGHT, 3).unwrap();
    assert_eq!((shown.width, shown.height), (3, 2));
    let shown = Window::level(WIDTH - 1, HEIGHT - 1, 3).unwrap();
    let film = window(&loaded, &shown, Region::whole(3, 2));
    assert_eq!(bits(&film), bits(&window(&loaded, &Window::level(WIDTH, HEIGHT, 3).unwrap(), Region::whole(3, 2))));
}

#[test]
fn parts_of_any_size_show_what_lies_there() {
    // Colors that change slowly, so that a resampled picture is near.
    let sky = r#"{ "version": 1, "image": { "width": 64, "height": 64 },
        "camera": { "CAMERA": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
        "materials": { "slow": { "ambient": 0, "diffuse": 0.8 } },
        "objects": [ { "sphere": { "center": [0, 0, -30], "radius": 30, "material": "slow" } } ],
        "render": { "antialias": false } }"#;
    for camera in ["pinhole", "orthographic", "panorama", "cylinder"] {
        let text = sky.replace("CAMERA", camera);
        let text =
            if camera == "orthographic" { text.replace("[0, 0, 0] }", "[0, 0, 0], \"height\": 4 }") } else { text };
        let loaded = load(text.as_bytes(), Format::Json, &Overrides::default()).unwrap_or_else(|e| panic!("{e}"));
        let whole = render(&loaded.scene, Region::whole(64, 64), &Control::default()).unwrap().film;
        // 30 x 20 pixels from (20, 24) on, squeezed into 10 x 4: centers lie at 20 + 3 (x + 1/2), 24 + 5 (y + 1/2).
        let part = Window::part([20.0, 24.0], [30.0, 20.0], 10, 4);
        let film = window(&loaded, &part, Region::whole(10, 4));
        for [x, y] in film.region.iter() {
            let seen = film.pixels[(y * 10 + x) as usize];
            let there = whole.pixels[((24 + 5 * y + 2) * 64 + 20 + 3 * x + 1) as usize];
            let far = seen.iter().zip(there).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(far < 1e-5, "{camera} {x},{y}: {seen:?} {there:?}");
        }
    }
}
