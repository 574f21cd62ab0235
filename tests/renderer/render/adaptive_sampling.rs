//! Pixels that get as many samples as they ask for.

use crate::common::{Random, load_scene};
use serde_json::{Value, json};
use strahl::film::Region;
use strahl::inspect::maps::{Map, MapKind};
use strahl::inspect::tree::trace_pixel;
use strahl::render::{Control, Picture, Sampling, render, render_measured};
use strahl::scene::description::{Accuracy, Statistical};
use strahl::scene::{Format, Overrides, Scene, load};

fn whole(scene: &Scene) -> Picture {
    render(scene, Region::whole(scene.width, scene.height), &Control::default()).unwrap()
}

const SCENES: [&str; 4] = ["effects/soft_shadows", "effects/gloss", "effects/dispersion", "effects/motion_blur"];

#[test]
fn a_part_is_the_crop_of_the_whole() {
    let mut random = Random::new(18);
    for name in SCENES {
        let scene = load_scene(name, 56, Overrides::default()).scene;
        let picture = whole(&scene);
        for _ in 0..6 {
            let [x, y] = [scene.width, scene.height].map(|most| random.below(most as usize - 1) as u32);
            let [width, height] =
                [scene.width - x, scene.height - y].map(|most| 1 + random.below(most as usize) as u32);
            let region = Region { x, y, width, height };
            let part = render(&scene, region, &Control::default()).unwrap();
            let crop: Vec<[f32; 3]> =
                region.iter().map(|at| picture.film.pixels[picture.film.region.index(at)]).collect();
            assert!(part.film.pixels == crop, "{name} {region:?}");
            assert_eq!(part.sampling.widths.pixels(), region.pixels());
        }
    }
}

/// What is said of a pixel depends on its neighbours, and not on the part that it is rendered in.
#[test]
fn parts_say_of_their_pixels_what_the_whole_says() {
    for name in SCENES {
        let scene = load_scene(name, 56, Overrides::default()).scene;
        let mut parts = Sampling::default();
        for region in Region::whole(scene.width, scene.height).tiles(9) {
            parts += &render(&scene, region, &Control::default()).unwrap().sampling;
        }
        assert_eq!(parts, whole(&scene).sampling, "{name}");
    }
}

/// The samples of the tree are those of the map, and their mean is the pixel.
#[test]
fn a_tree_is_its_pixel() {
    for name in SCENES {
        let scene = load_scene(name, 40, Overrides::default()).scene;
        let (picture, region) = (whole(&scene), Region::whole(scene.width, scene.height));
        let measured = render_measured(&scene, 1, false, &Control::default()).unwrap();
        let map = Map::of(MapKind::Samples, &measured).film();
        let coarse = Map::of(MapKind::Samples, &render_measured(&scene, 8, false, &Control::default()).unwrap());
        let coarse = coarse.enlarged(8, region).film();
        let mut seen = Vec::new();
        for [x, y] in region.iter().filter(|[x, y]| x % 8 == 4 && y % 8 == 4) {
            let (tree, index) = (trace_pixel(&scene, x, y), region.index([x, y]));
            assert_eq!(tree.value.map(|channel| channel as f32), picture.film.pixels[index], "{name} {x} {y}");
            assert_eq!([tree.samples as f32; 2], [map.pixels[index][0], coarse.pixels[index][0]], "{name} {x} {y}");
            seen.push(tree.samples);
        }
        seen.sort_unstable();
        assert!(seen[0] < seen[seen.len() - 1], "{name} {seen:?}");
    }
}

/// Batches are rounded before their mean is taken, so the last bits differ.
#[test]
fn a_tree_is_its_pixel_in_the_statistical_mode() {
    let accuracy = Some(Accuracy::Statistical(Statistical { half_width: 4.0, confidence: 0.95 }));
    for name in SCENES {
        let scene = load_scene(name, 24, Overrides { accuracy, ..Overrides::default() }).scene;
        let (picture, region) = (whole(&scene), Region::whole(scene.width, scene.height));
        let map = Map::of(MapKind::Samples, &render_measured(&scene, 1, false, &Control::default()).unwrap()).film();
        for [x, y] in region.iter().filter(|[x, y]| x % 8 == 4 && y % 8 == 4) {
            let (tree, index) = (trace_pixel(&scene, x, y), region.index([x, y]));
            assert_eq!(tree.samples as f32, map.pixels[index][0], "{name} {x} {y}");
            for (of_tree, of_picture) in tree.value.into_iter().zip(picture.film.pixels[index]) {
                let off = (of_tree - f64::from(of_picture)).abs();
                assert!(off <= 1e-6 * of_tree.max(1.0), "{name} {x} {y}: {of_tree} {of_picture}");
            }
        }
    }
}

/// A lit floor and what stands on it, with some effects that choose.
fn random_scene(random: &mut Random) -> Value {
    let mut below = |most: usize| random.below(most) as f64;
    let effects = 1 + below(31) as u32;
    let ball =
        |x: f64, material: &str| json!({ "sphere": { "center": [x, 0.8, 0], "radius": 0.8, "material": material } });
    let mut scene = json!({
        "version": 1, "image": { "width": 24, "height": 18 }, "ambient": 0.2, "background": [0.3, 0.5, 0.8],
        "camera": { "pinhole": { "eye": [below(4) - 2.0, 1.0 + 0.5 * below(5), 6], "look_at": [0, 0.7, 0] } },
        "lights": [{ "point": { "position": [4, 6, 3] } }],
        "materials": {
            "floor": { "diffuse": { "checker": { "a": 0.8, "b": [0.2, 0.1 * below(9), 0.3] } } },
            "satin": { "diffuse": 0.2, "reflection": 0.7, "roughness": 0.05 + 0.05 * below(8) },
            "matt": { "diffuse": [0.8, 0.3, 0.2] }
        },
        "objects": [
            { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor" } },
            ball(-1.5 + 0.1 * below(10), if effects & 1 == 1 { "satin" } else { "matt" }),
            { "group": { "objects": [ball(0.5 + 0.1 * below(10), "matt")], "motion": { "translate": [0.1 * below(5), 0.2, 0] } } }
        ],
        "render": { "color_bleeding": effects >> 4 & 1 == 1 }
    });
    if effects >> 1 & 1 == 1 {
        let size = 0.3 + 0.3 * below(5);
        scene["lights"][0]["point"]["area"] = json!({ "parallelogram": { "u": [size, 0, 0], "v": [0, 0, size] } });
    }
    if effects >> 2 & 1 == 1 {
        scene["camera"]["pinhole"]["aperture"] = json!(0.05 * (1.0 + below(6)));
    }
    if effects >> 3 & 1 == 0 {
        let still = scene["objects"][2]["group"]["objects"][0].clone();
        scene["objects"][2] = still;
    }
    scene
}

/// How far pixels are off, from 512 samples, in scenes that nobody has looked at.
#[test]
fn estimates_hold_in_random_scenes() {
    let mut random = Random::new(2_026);
    let (mut pixels, mut within, mut settled, mut near) = (0u64, 0u64, 0u64, 0u64);
    for number in 0..100 {
        let text = serde_json::to_vec(&random_scene(&mut random)).unwrap();
        let scene = |samples| {
            let overrides = Overrides { samples, ..Overrides::default() };
            load(&text, Format::Json, &overrides).unwrap_or_else(|problems| panic!("{number}: {problems}")).scene
        };
        let mine = scene(None);
        if !mine.adaptive {
            continue;
        }
        let (picture, exact) = (whole(&mine), whole(&scene(Some(512))));
        let code = |linear: f32| 255.0 * strahl::math::linear_to_srgb(f64::from(linear).clamp(0.0, 1.0));
        let half_width = f64::from(picture.sampling.widths.at_share(0.95).unwrap()) / 2.0;
        for (a, b) in picture.film.pixels.iter().zip(&exact.film.pixels) {
            let off = (0..3).map(|c| (code(a[c]) - code(b[c])).abs()).fold(0.0, f64::max);
            // Recursion may change both by a code.
            within += u64::from(off <= half_width + 1.0);
            near += u64::from(off <= 2.5);
        }
        pixels += picture.sampling.reached.pixels;
        settled += picture.sampling.reached.sure;
    }
    let share = |count: u64| count as f64 / pixels as f64;
    println!("{pixels} pixels: {} within, {} settled, {} near", share(within), share(settled), share(near));
    assert!(pixels > 80 * 24 * 18, "{pixels}");
    assert!(share(within) >= 0.95 && share(settled) > 0.9 && share(near) >= 0.8);
}

/// What does not choose takes few samples.
#[test]
fn plain_parts_take_the_fewest_samples() {
    let scene = load_scene("effects/soft_shadows", 320, Overrides::default()).scene;
    let reached = whole(&scene).sampling.reached;
    let mean = reached.samples as f64 / reached.pixels as f64;
    assert!(mean < 16.0 && reached.most_samples > 64, "{mean} {reached:?}");
}

/// All first samples of pixels 415, 272 and of two beside it miss the lamp: they were up to 50 codes off.
#[test]
fn pixels_beside_another_color_look_again() {
    let scene = |samples: Option<u32>| {
        let text = serde_json::to_vec(&json!({
            "version": 1, "image": { "width": 640, "height": 360 },
            "camera": { "pinhole": { "eye": [0, 2.2, 7], "look_at": [0, 1, 0], "vfov_deg": 40 } },
            "background": [0.078, 0.361, 0.753], "ambient": 0.0625,
            "lights": [{ "point": {
                "position": [3, 6, 4], "area": { "parallelogram": { "u": [2, 0, 0], "v": [0, 0, 2] } }
            } }],
            "materials": { "floor": { "diffuse": 0.7 }, "ball": { "diffuse": [0.24, 0.4, 0.64] } },
            "objects": [
                { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor" } },
                { "sphere": { "center": [1.9, 0.7, 1.9], "radius": 0.7, "material": "ball" } }
            ],
            "render": { "max_depth": 5 }
        }))
        .unwrap();
        load(&text, Format::Json, &Overrides { samples, ..Overrides::default() }).unwrap().scene
    };
    let part = Region { x: 390, y: 255, width: 50, height: 45 };
    let [shown, truth] = [None, Some(1_024)].map(|samples| {
        let scene = scene(samples);
        render(&scene, part, &Control::default())
            .unwrap()
            .film
            .pixels
            .iter()
            .map(|p| scene.display().codes(*p))
            .collect::<Vec<_>>()
    });
    let off = shown.iter().flatten().zip(truth.iter().flatten()).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
    assert!(off <= 20, "{off} codes");
}
