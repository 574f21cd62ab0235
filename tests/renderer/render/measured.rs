//! What each pixel takes, as maps show it.

use crate::common::load_scene;
use strahl::film::Region;
use strahl::inspect::maps::{Map, MapKind};
use strahl::render::{Control, render, render_measured};
use strahl::scene::Overrides;
use strahl::scene::description::{Accuracy, Precision, Proved, Statistical};

/// The pixels of a packet share what it takes. Each pixel traced alone is the slow twin.
#[test]
fn each_pixel_takes_what_it_takes_alone() {
    let proved = |max_codes| Some(Accuracy::Proved(Proved { max_codes }));
    let statistical = Some(Accuracy::Statistical(Statistical { half_width: 4.0, confidence: 0.95 }));
    let cases = [
        ("whitted/whitted", None, None),
        ("mirrors/hall", None, Some(Precision::Double)),
        ("refraction/glass_of_water", proved(0), None),
        ("shapes/all", None, None),
        ("effects/gloss", statistical, None),
        ("effects/color_bleeding", None, None),
        ("cameras/fisheye", None, None),
    ];
    for (name, accuracy, precision) in cases {
        // Pixels that ask for samples ask their neighbours, too.
        let samples = (accuracy.is_none() && name.starts_with("effects")).then_some(64);
        let overrides = Overrides { antialias: Some(false), accuracy, precision, samples, ..Overrides::default() };
        let scene = load_scene(name, 24, overrides).scene;
        let region = Region::whole(scene.width, scene.height);
        let measured = render_measured(&scene, 1, true, &Control::default()).unwrap();
        let plain = render(&scene, region, &Control::default()).unwrap();
        assert_eq!((&measured.film.pixels, measured.rays), (&plain.film.pixels, plain.rays), "{name}");
        let [rays, depth, time] =
            [MapKind::Rays, MapKind::Depth, MapKind::Time].map(|kind| Map::of(kind, &measured).film().pixels);
        for (index, [x, y]) in region.iter().enumerate() {
            let alone = render(&scene, Region { x, y, width: 1, height: 1 }, &Control::default()).unwrap().rays;
            assert_eq!(rays[index][0], alone.total() as f32, "{name} {x} {y}");
            // Beyond the circle of a dome there are no rays.
            let deepest = if alone.total() == 0 { 0 } else { alone.deepest };
            assert_eq!(depth[index][0], deepest as f32, "{name} {x} {y}");
        }
        assert!(time.iter().zip(&rays).all(|(time, rays)| (rays[0] > 0.0) == (time[0] > 0.0)), "{name}");
    }
}

#[test]
fn refined_pixels_take_their_base_samples_and_the_others() {
    let overrides = Overrides { antialias: Some(true), ..Overrides::default() };
    let scene = load_scene("whitted/whitted", 64, overrides).scene;
    let measured = render_measured(&scene, 1, false, &Control::default()).unwrap();
    let all: f64 = Map::of(MapKind::Rays, &measured).film().pixels.iter().map(|pixel| f64::from(pixel[0])).sum();
    assert_eq!(all, measured.rays.total() as f64);
}

#[test]
fn a_coarse_map_shows_blocks() {
    let scene = load_scene("whitted/whitted", 37, Overrides::default()).scene;
    let step = 8;
    let [across, down] = [scene.width.div_ceil(step), scene.height.div_ceil(step)];
    let small = render_measured(&scene, step, false, &Control::default()).unwrap();
    assert_eq!([small.film.region.width, small.film.region.height], [across, down]);
    let (few, whole) = (Map::of(MapKind::Rays, &small), Region::whole(scene.width, scene.height));
    let values = few.film().pixels;
    let film = few.enlarged(step, whole).film();
    assert_eq!((film.region, film.pixels.len()), (whole, whole.pixels() as usize));
    for ([x, y], pixel) in whole.iter().zip(&film.pixels) {
        assert_eq!(*pixel, values[(y / step * across + x / step) as usize]);
    }
}

/// Pixels that are far from each other are no neighbours: antialiasing refines those that it refines in the picture.
#[test]
fn coarse_maps_have_the_numbers_of_fine_ones() {
    let cases = [("whitted/whitted", 90, Some(true)), ("mirrors/hall", 60, None), ("effects/gloss", 40, Some(false))];
    for (name, width, antialias) in cases {
        let scene = load_scene(name, width, Overrides { antialias, ..Overrides::default() }).scene;
        let whole = Region::whole(scene.width, scene.height);
        let fine = render_measured(&scene, 1, false, &Control::default()).unwrap();
        for step in [2, 3, 4, 8, 16] {
            let coarse = render_measured(&scene, step, false, &Control::default()).unwrap();
            for kind in [MapKind::Rays, MapKind::Depth, MapKind::Proved] {
                let [coarse, fine] = [&coarse, &fine].map(|picture| Map::of(kind, picture).film());
                for ([x, y], pixel) in coarse.region.iter().zip(&coarse.pixels) {
                    let middle = [x, y].map(|at| at * step + step / 2);
                    let middle = [middle[0].min(scene.width - 1), middle[1].min(scene.height - 1)];
                    assert_eq!(*pixel, fine.pixels[whole.index(middle)], "{name}, {kind:?}, step {step}, {x} {y}");
                }
            }
        }
    }
}
