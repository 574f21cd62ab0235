//! Checkerboards are averaged over what each ray covers of them.

use super::*;
use crate::common::Random;

/// A board up to the horizon, with something that shows it.
fn board(objects: Value) -> Value {
    let mut all = vec![json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "board" } })];
    all.extend(objects.as_array().unwrap().iter().cloned());
    json!({
        "version": 1, "image": { "width": 64, "height": 48 }, "background": [0.5, 0.7, 1], "lights": [], "ambient": 1,
        "camera": { "pinhole": { "eye": [0.3, 1.5, 6.1], "look_at": [0.2, 0.8, 0], "vfov_deg": 50 } },
        "materials": {
            "board": { "diffuse": { "checker": { "a": [0.9, 0.1, 0.3], "b": [0.2, 0.8, 0.3], "size": 0.5 } } },
            "mirror": { "diffuse": 0, "reflection": 0.9 },
            "glass": { "diffuse": 0, "transmission": 0.9, "ior": 1.5 }
        },
        "objects": all,
        "render": { "antialias": false, "accuracy": { "fixed": {} }, "max_depth": 8 }
    })
}

/// Root of the mean square difference from the picture of very many samples, over the pixels that a test is about.
fn error(description: &Value, filtered: bool, precision: &str, truth: &[[f32; 3]], of: impl Fn(usize) -> bool) -> f64 {
    let mut description = description.clone();
    description["render"]["filter_checkers"] = json!(filtered);
    let found = pixels(description, precision);
    let squares = found
        .iter()
        .zip(truth)
        .enumerate()
        .filter(|(i, _)| of(*i))
        .flat_map(|(_, (a, b))| a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).collect::<Vec<_>>());
    let squares: Vec<f64> = squares.collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

fn truth(description: &Value) -> Vec<[f32; 3]> {
    truth_in("single", description)
}

fn truth_in(precision: &str, description: &Value) -> Vec<[f32; 3]> {
    let mut description = description.clone();
    description["render"]["filter_checkers"] = json!(false);
    description["render"]["samples"] = json!(1024);
    pixels(description, precision)
}

/// Cubes on the grid are what people write first.
#[test]
fn sides_that_lie_on_borders_of_tiles_have_tiles() {
    let quad = json!({ "quad": { "vertices": [[-2, 0, -2], [2, 0, -2], [2, 0, 2], [-2, 0, 2]], "material": "board" } });
    let mesh = json!({ "mesh": {
        "vertices": [[-2, 0, -2], [2, 0, -2], [2, 0, 2], [-2, 0, 2]], "faces": [[0, 2, 1], [0, 3, 2]], "material": "board"
    } });
    let cube = json!({ "box": { "min": [-1, 0, -1], "max": [1, 1, 1], "material": "board" } });
    let plane = |y: f64| json!({ "plane": { "point": [0, y, 0], "normal": [0, 1, 0], "material": "board" } });
    for (object, size) in [(quad, 0.392), (mesh, 0.392), (cube, 0.5), (plane(0.0), 0.5), (plane(0.25), 0.125)] {
        let mut description = board(json!([]));
        description["objects"] = json!([object]);
        description["camera"]["pinhole"]["eye"] = json!([0.3, 3.5, 3.1]);
        description["camera"]["pinhole"]["look_at"] = json!([0.1, 0.0, 0.1]);
        description["materials"]["board"]["diffuse"]["checker"]["size"] = json!(size);
        description["materials"]["board"]["diffuse"]["checker"]["axes"] = json!("xyz");
        // Unfiltered in single precision, roundings choose the tile.
        let truth = truth_in("double", &description);
        for precision in ["single", "double"] {
            let error = error(&description, true, precision, &truth, |_| true);
            assert!(error < 0.05, "{object} {precision}: {error}");
        }
    }
}

#[test]
fn far_boards_are_grey_without_more_samples() {
    let description = board(json!([]));
    let truth = truth(&description);
    for precision in ["single", "double"] {
        // From just below the horizon to the nearest tiles.
        let error = |filtered| error(&description, filtered, precision, &truth, |i| i / 64 > 16);
        let (filtered, points) = (error(true), error(false));
        println!("{precision}: {filtered:.4} instead of {points:.4}");
        assert!(filtered < 0.3 * points, "{filtered} {points}");
    }
}

#[test]
fn curved_mirrors_and_lenses_widen_what_rays_cover() {
    for (what, object, most) in [
        ("ball", json!({ "sphere": { "center": [0, 1, 0], "radius": 1, "material": "mirror" } }), 0.6),
        ("lens", json!({ "sphere": { "center": [0, 1, 0], "radius": 1, "material": "glass" } }), 0.75),
        (
            "tube",
            json!({ "cylinder": { "base": [-2, 1, 0], "top": [2, 1, 0], "radius": 1, "material": "mirror" } }),
            0.8,
        ),
    ] {
        let description = board(json!([object.clone()]));
        let truth = truth(&description);
        let mut alone = description.clone();
        alone["materials"]["mirror"] = json!({ "ambient": 0, "diffuse": 0 });
        alone["materials"]["glass"] = json!({ "ambient": 0, "diffuse": 0 });
        let body: Vec<bool> = pixels(alone, "double").iter().map(|pixel| *pixel == [0.0; 3]).collect();
        assert!(body.iter().filter(|body| **body).count() > 200);
        let error = |filtered| error(&description, filtered, "double", &truth, |i| body[i]);
        let (filtered, points) = (error(true), error(false));
        println!("{what}: {filtered:.4} instead of {points:.4}");
        assert!(filtered < most * points, "{what}: {filtered} {points}");
    }
}

#[test]
fn means_lie_between_the_two_colors() {
    let mut random = Random::new(5);
    for precision in ["single", "double"] {
        for _ in 0..20 {
            let mut description = board(json!([]));
            let checker = &mut description["materials"]["board"]["diffuse"]["checker"];
            checker["size"] = json!(10f64.powf(random.between(-12.0, 3.0)));
            checker["axes"] = json!(["x", "xz", "xyz"][random.below(3)]);
            description["background"] = json!([0.5, 0.5, 0.3]);
            for pixel in pixels(description, precision) {
                let [r, g, b] = pixel.map(f64::from);
                assert!((0.2 - 1e-6..=0.9 + 1e-6).contains(&r) && (0.1 - 1e-6..=0.8 + 1e-6).contains(&g), "{pixel:?}");
                assert!((b - 0.3).abs() < 1e-6, "{pixel:?}");
            }
        }
    }
}

#[test]
fn placed_boards_are_filtered_as_those_that_are_written_there() {
    let plain = board(json!([]));
    let mut placed = plain.clone();
    placed["materials"]["board"]["diffuse"]["checker"]["size"] = json!(0.125);
    placed["objects"] = json!([{ "group": { "transform": { "scale": 4 }, "objects": placed["objects"] } }]);
    for precision in ["single", "double"] {
        let [a, b] = [&plain, &placed].map(|description| pixels(description.clone(), precision));
        let far = a.iter().zip(&b).filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 2e-3)).count();
        assert!(far <= 3, "{precision}: {far}");
    }
}

#[test]
fn tiles_of_filtered_boards_are_crops() {
    let description = board(json!([
        { "sphere": { "center": [-1.1, 1, 0], "radius": 1, "material": "mirror" } },
        { "sphere": { "center": [1.1, 1, 0], "radius": 1, "material": "glass" } }
    ]));
    for precision in ["single", "double"] {
        for antialias in [false, true] {
            let mut description = description.clone();
            description["render"]["antialias"] = json!(antialias);
            description["render"]["accuracy"] = json!({ "proved": { "max_codes": 0 } });
            let scene = scene(description, precision);
            let whole = picture(&scene).film;
            for region in whole.region.tiles(19) {
                let tile = render(&scene, region, &Control::default()).unwrap().film;
                let crop: Vec<_> = region.iter().map(|at| whole.pixels[whole.region.index(at)]).collect();
                assert_eq!(tile.pixels, crop, "{precision} {antialias} {region:?}");
            }
        }
    }
}
