//! Surfaces that show shadows alone.

use super::*;
use crate::common::Random;
use std::f64::consts::TAU;

/// A floor that catches shadows is nowhere but where a lamp is hidden, in colors and in alpha.
#[test]
fn a_shadow_catcher_shows_shadows_alone() {
    let sunny = |ambient: f64, light: Value, film: Value| {
        json!({
            "version": 1, "image": { "width": 3, "height": 1 },
            "camera": { "orthographic": { "eye": [0, 9, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "height": 2 } },
            "background": 0.5, "ambient": ambient, "lights": [light], "film": film,
            "materials": { "floor": { "pbr": { "shadow_catcher": true } } },
            "objects": [
                { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor" } },
                { "box": { "min": [-4, 4, -1], "max": [-3, 5, 1] } }
            ],
            "render": { "antialias": false }
        })
    };
    let scene = |light: Value, film: Value| sunny(0.0, light, film);
    // Light that comes from the left hides the middle, 4.5 below and beside the box.
    let sun = json!({ "directional": { "direction": [3.5, -4.5, 0] } });
    for precision in ["single", "double"] {
        let seen = pixels(scene(sun.clone(), json!({})), precision);
        assert_eq!(seen, [[0.5; 3], [0.0; 3], [0.5; 3]], "{precision}");
        let film = picture(&super::scene(scene(sun.clone(), json!({ "background": "transparent" })), precision)).film;
        assert_eq!((film.pixels, film.alpha), (vec![[0.0; 3]; 3], vec![0.0, 1.0, 0.0]), "{precision}");
    }
    // Ambient light as bright as the sun on the floor brightens the shadow, in alpha too.
    let height = 4.5 / f64::hypot(3.5, 4.5);
    let film =
        picture(&super::scene(sunny(height, sun.clone(), json!({ "background": "transparent" })), "double")).film;
    assert!((film.alpha[1] - 0.5).abs() < 1e-6 && film.alpha[0] == 0.0, "{:?}", film.alpha);
    assert!(effects(&scene(sun.clone(), json!({}))).has(Effect::ShadowCatcher));
    // The fourth number of a mesh's colors is how much of it is seen.
    let mut faded = scene(sun.clone(), json!({ "background": "transparent" }));
    faded["objects"][0] = json!({ "mesh": {
        "vertices": [[-9, 0, 9], [9, 0, 9], [0, 0, -18]], "faces": [[0, 1, 2]], "material": "floor",
        "colors": [[1, 1, 1, 0.25], [1, 1, 1, 0.25], [1, 1, 1, 0.25]]
    } });
    let film = picture(&super::scene(faded, "double")).film;
    assert!((film.alpha[1] - 0.25).abs() < 1e-6 && film.alpha[0] == 0.0, "{:?}", film.alpha);
    // Without a lamp there is nothing to be seen of it.
    let mut dark = scene(sun, json!({}));
    dark["lights"] = json!([]);
    assert!(!effects(&dark).has(Effect::ShadowCatcher));
    assert_eq!(pixels(dark, "single"), [[0.5; 3]; 3]);
}

/// A ray that meets two triangles at the edge that they share passes one surface. Vertices are where rays go through edges often.
#[test]
fn surfaces_that_are_partly_there_have_no_seams() {
    for (seed, precision) in (0..24).zip(["single", "double"].into_iter().cycle()) {
        let mut random = Random::new(seed);
        let [x, z] = [0, 1].map(|_| random.between(-7.0, 7.0));
        let corner = |i: u32| {
            let (sin, cos) = (TAU * f64::from(i) / 8.0).sin_cos();
            [x + 4.0 * cos, 0.0, z + 4.0 * sin]
        };
        let vertices: Vec<_> = std::iter::once([x, 0.0, z]).chain((0..8).map(corner)).collect();
        let faces: Vec<_> = (0..8).map(|i| [0, 1 + (i + 1) % 8, 1 + i]).collect();
        let scene = json!({
            "version": 1, "image": { "width": 41, "height": 41 },
            "camera": { "pinhole": { "eye": [x, 9, z], "look_at": [x, 0, z], "up": [0, 0, -1], "vfov_deg": 30 } },
            "ambient": 1, "lights": [], "film": { "background": "transparent" },
            "materials": { "veil": { "pbr": { "base_color": 0.5, "opacity": { "alpha": 0.25 } } } },
            "objects": [{ "mesh": { "vertices": vertices, "faces": faces, "material": "veil" } }],
            "render": { "antialias": false }
        });
        let film = picture(&super::scene(scene, precision)).film;
        let off = film.alpha.iter().filter(|alpha| (**alpha - 0.25).abs() > 1e-6).count();
        assert_eq!(off, 0, "{seed} {precision}: {:?}", film.alpha);
    }
}

/// A floor of which all lies in the shadow of a ceiling behind the camera.
fn below_a_ceiling(camera: &Value, width: u32) -> Value {
    json!({
        "version": 1, "image": { "width": width, "height": 10 }, "camera": camera,
        "ambient": 0, "film": { "background": "transparent" },
        "lights": [{ "directional": { "direction": [0, -1, 0] } }],
        "materials": { "floor": { "pbr": { "shadow_catcher": true, "edge_fade": 0.2 } } },
        "objects": [
            { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor" } },
            { "box": { "min": [-99, 50, -99], "max": [99, 51, 99] } }
        ],
        "render": { "antialias": false }
    })
}

/// Shadows fade in the border of the picture, by the same share in each window of it, whatever the camera.
#[test]
fn shadows_fade_at_the_edges_of_the_whole_picture() {
    let cameras = [
        json!({ "pinhole": { "eye": [0, 9, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "vfov_deg": 90 } }),
        json!({ "orthographic": { "eye": [0, 9, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "height": 2 } }),
    ];
    for (camera, precision) in cameras.iter().flat_map(|camera| ["single", "double"].map(|p| (camera, p))) {
        let built = scene(below_a_ceiling(camera, 20), precision);
        let alpha = picture(&built).film.alpha;
        for (at, alpha) in alpha.iter().enumerate() {
            let [x, y] = [at % 20, at / 20].map(|i| i as f64 + 0.5);
            // The share of the way through the nearest border, then 3 t^2 - 2 t^3.
            let nearest = [x / 20.0, 1.0 - x / 20.0, y / 10.0, 1.0 - y / 10.0].into_iter().fold(1.0, f64::min);
            let t = (nearest / 0.2).min(1.0);
            let expected = t * t * (3.0 - 2.0 * t);
            assert!((f64::from(*alpha) - expected).abs() < 1e-5, "{camera} {precision} {x} {y}: {alpha} {expected}");
        }
        // The upper right quarter as a picture of its own.
        let window = Window { origin: [10.0, 0.0], step: [1.0; 2], width: 10, height: 5 };
        let quarter = picture(&built.through(&window)).film.alpha;
        let cut: Vec<f32> = (0..5).flat_map(|y| alpha[20 * y + 10..20 * y + 20].to_vec()).collect();
        assert_eq!(quarter, cut, "{camera} {precision}");
    }
    let mut wide = below_a_ceiling(&cameras[0], 20);
    wide["materials"]["floor"]["pbr"]["edge_fade"] = json!(0.6);
    assert_eq!(problems(&wide), ["/materials/floor/pbr/edge_fade"]);
}

/// In faithful scenes, where light from around is traced and not ambient, shadows are still a share of all light.
#[test]
fn light_from_around_brightens_shadows_of_faithful_scenes_too() {
    // Light from above, and a floor that lies in the shadow of a ceiling behind the camera.
    let scene = |fidelity: &str| {
        json!({
            "version": 1, "image": { "width": 3, "height": 1 }, "background": 0.6, "ambient": 0.6,
            "camera": { "orthographic": { "eye": [0, 9, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "height": 2 } },
            "film": { "background": "transparent" },
            "lights": [{ "directional": { "direction": [0, -1, 0], "intensity": 0.2 } }],
            "materials": { "floor": { "pbr": { "shadow_catcher": true } } },
            "objects": [
                { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor" } },
                { "box": { "min": [-9, 50, -9], "max": [9, 51, 9] } }
            ],
            "render": { "fidelity": fidelity, "antialias": false }
        })
    };
    for (fidelity, precision) in ["fast", "faithful"].iter().flat_map(|f| ["single", "double"].map(|p| (*f, p))) {
        let alpha = picture(&super::scene(scene(fidelity), precision)).film.alpha;
        let right = alpha.iter().all(|alpha| (f64::from(*alpha) - 0.2 / 0.8).abs() < 1e-6);
        assert!(right, "{fidelity} {precision}: {alpha:?}");
    }
}

/// Bottles of colored glass cast shadows as they do on other floors: by what is left of the light on its way through them.
#[test]
fn what_absorbs_casts_a_shadow() {
    let scene = |glass: Value, floor: Value, film: Value| {
        json!({
            "version": 1, "image": { "width": 3, "height": 1 }, "background": 0, "ambient": 0,
            "camera": { "orthographic": { "eye": [0, 9, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "height": 2 } },
            "film": film,
            "lights": [{ "directional": { "direction": [0, -1, 0] } }],
            "materials": { "floor": floor, "glass": glass },
            "objects": [
                { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor" } },
                { "box": { "min": [-9, 50, -9], "max": [9, 52, 9], "material": "glass" } }
            ],
            "render": { "shadows": "transmissive", "antialias": false }
        })
    };
    let catcher = json!({ "pbr": { "shadow_catcher": true } });
    let white = json!({ "diffuse": 1 });
    let glasses = [
        json!({ "diffuse": 0, "transmission": 1, "ior": 1.5, "absorption": [0.1, 0.5, 1] }),
        json!({ "diffuse": 0, "transmission": [0.9, 0.5, 0.7], "ior": 1.5, "absorption": 0.3 }),
        json!({ "pbr": { "metallic": 0, "transmission": 1, "attenuation": { "color": [0.2, 0.8, 0.5], "distance": 1 } } }),
    ];
    for (glass, precision) in glasses.iter().flat_map(|glass| ["single", "double"].map(|p| (glass, p))) {
        let of = |floor: &Value, film: Value| {
            picture(&super::scene(scene(glass.clone(), floor.clone(), film), precision)).film
        };
        let alpha = of(&catcher, json!({ "background": "transparent" })).alpha[1];
        // Its light is 1 where nothing hides the sun.
        let left = of(&white, json!({})).pixels[1].iter().sum::<f32>() / 3.0;
        assert!(left < 0.9 && (1.0 - left - alpha).abs() < 1e-6, "{glass} {precision}: {alpha} {left}");
    }
}

/// The borders are those of the size that is rendered, also if a view is built for another one.
#[test]
fn shadows_fade_in_another_size_as_in_a_scene_of_that_size() {
    let camera = json!({ "orthographic": { "eye": [0, 9, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "height": 2 } });
    let [mut resized, expected] = [20, 30].map(|width| scene(below_a_ceiling(&camera, width), "double"));
    resized.set_size(&serde_json::from_value(camera).unwrap(), 30, 10);
    let [resized, expected] = [resized, expected].map(|scene| picture(&scene).film.alpha);
    assert_eq!(resized, expected);
}
