//! The table of effects: what it says is on is what the kernels read, what it says is removed leaves no trace, and what it
//! takes out of a built scene is what a description without it would not have.

mod alone;
mod kernel_flags;
mod light_traps;
mod pairs;
mod random_scene;
mod switched_off;

use crate::common::{on_own_threads, read, scene_names};
use random_scene::random_scene;
use rayon::prelude::*;
use serde_json::{Value, json};
use strahl::film::Region;
use strahl::render::{Control, render};
use strahl::scene::effects::{Effect, State};
use strahl::scene::{Format, Loaded, Overrides, Scene, load};

fn loaded(description: &Value) -> Loaded {
    load(description.to_string().as_bytes(), Format::Json, &Overrides::default())
        .unwrap_or_else(|problems| panic!("{problems}\n{description:#}"))
}

fn pixels(scene: &Scene) -> Vec<[f32; 3]> {
    let region = Region::whole(scene.width, scene.height);
    render(scene, region, &Control::default()).unwrap().film.pixels
}

/// Every scene of the repository, small, as it is and as it looks with other settings.
fn small_scenes() -> Vec<(String, Value)> {
    let mut scenes = Vec::new();
    for name in scene_names().into_iter().filter(|name| !name.starts_with("spheres/flake_9")) {
        let mut scene: Value = serde_json::from_slice(&read(&format!("scenes/{name}.json"))).unwrap();
        scene["image"] = json!({ "width": 32, "height": 20 });
        scenes.push((name.clone(), scene.clone()));
        scene["render"]["max_depth"] = json!(1);
        scenes.push((format!("{name}, one ray deep"), scene.clone()));
        scene["render"] = json!({ "min_weight": 1, "shadows": "transmissive" });
        scene["lights"] = json!([]);
        scenes.push((format!("{name}, in the dark"), scene));
    }
    scenes
}

/// The scenes of the tests below. Some random ones are refused.
fn all_scenes(count: usize) -> Vec<(String, Value)> {
    let random = (0..)
        .map(|seed| (format!("seed {seed}"), random_scene(seed)))
        .filter(|(_, scene)| load(scene.to_string().as_bytes(), Format::Json, &Overrides::default()).is_ok());
    small_scenes().into_iter().chain(random.take(count)).collect()
}

/// What is wrong with which scenes.
fn judge(scenes: Vec<(String, Value)>, wrong: impl Fn(&Value) -> Vec<String> + Sync) {
    let found: Vec<String> = on_own_threads(|| {
        let each = |(name, scene): &(String, Value)| -> Vec<String> {
            wrong(scene).into_iter().map(|what| format!("{name}: {what}")).collect()
        };
        scenes.par_iter().flat_map_iter(each).collect()
    });
    assert!(found.is_empty(), "{} of {}:\n{}", found.len(), scenes.len(), found[..found.len().min(20)].join("\n"));
}

/// What cannot show beside an effect that does changes neither the picture nor its rays.
#[test]
fn what_cannot_show_changes_no_byte_and_no_ray_of_the_rest() {
    let scene = |changes: &[(&str, Value)]| {
        let mut scene = json!({
            "version": 1, "image": { "width": 40, "height": 30 },
            "camera": { "pinhole": { "eye": [0, 2, 6], "look_at": [0, 0.5, 0] } }, "lights": [],
            "materials": {
                "lamp": { "pbr": { "base_color": 0, "metallic": 0, "emissive": 5 } },
                "mirror": { "diffuse": 0.2, "reflection": 0.8 }
            },
            "objects": [
                { "triangle": { "vertices": [[-0.2, 2, 0], [0.2, 2, 0], [0, 2, 0.3]], "material": "lamp" } },
                { "sphere": { "center": [0, 1, 0], "radius": 0.7, "material": "mirror" } },
                { "sphere": { "center": [1.6, 1, 0], "radius": 0.7, "material": "mirror" } },
                { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0] } }
            ]
        });
        for (pointer, value) in changes {
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            scene.pointer_mut(parent).unwrap()[key] = value.clone();
        }
        let scene = loaded(&scene).scene;
        let picture = render(&scene, Region::whole(40, 30), &Control::default()).unwrap();
        (picture.film.pixels, picture.rays)
    };
    let rays = ("/render", json!({ "fidelity": "faithful", "samples": 4, "antialias": false }));
    let plain = scene(std::slice::from_ref(&rays));
    for opacity in [json!({ "alpha": 1 }), json!({ "mode": "mask", "alpha": 0.8 })] {
        let lamp = ("/materials/lamp/pbr/opacity", opacity.clone());
        assert!(scene(&[rays.clone(), lamp]) == plain, "a lamp of which all is there: {opacity}");
    }
    let sky = ("/environment", json!({ "sky": {} }));
    let plain = scene(std::slice::from_ref(&sky));
    assert!(scene(&[sky, ("/background", json!(50))]) == plain, "a background behind the environment");
}

/// A lone plane, a lone ball: no shadow rays, and the same picture as with them.
#[test]
fn shadow_rays_are_left_out_only_where_nothing_can_hide_a_light() {
    let scene = |object: Value, light: Value| {
        json!({
            "version": 1, "image": { "width": 32, "height": 20 },
            "camera": { "pinhole": { "eye": [0, 2, 5], "look_at": [0, 0, 0] } },
            "lights": [light], "objects": [object]
        })
    };
    let plane = json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0] } });
    let tilted = json!({ "plane": { "point": [0, 0, 0], "normal": [0.1, 1, 0] } });
    let ball = json!({ "sphere": { "center": [0, 0, 0], "radius": 1 } });
    let around = json!({ "sphere": { "center": [0, 0, 0], "radius": 30 } });
    let block = json!({ "box": { "min": [-1, -1, -1], "max": [1, 1, 1] } });
    let disc = json!({ "disc": { "center": [0, 0, 0], "normal": [1, 2, 3], "radius": 1 } });
    let ring = json!({ "torus": { "center": [0, 0, 0], "major_radius": 1, "minor_radius": 0.3 } });
    let sheet = json!({ "quad": { "vertices": [[-1, 0, 1], [1, 0, 1], [1, 1, -1], [-1, 0, -1]] } });
    let placed = json!({ "group": { "objects": [ball], "transform": { "scale": 2 } } });
    let sun = json!({ "directional": { "direction": [1, -2, -1.5] } });
    let lamp = json!({ "point": { "position": [3, 4, 3], "area": { "disc": { "radius": 0.5 } } } });
    let edge = json!({ "point": { "position": [3, 1.00001, 3] } });
    for (object, light, shadows) in [
        (&plane, &sun, false),
        (&plane, &lamp, false),
        (&tilted, &sun, false),
        (&tilted, &lamp, true),
        (&ball, &sun, false),
        (&ball, &lamp, false),
        (&around, &lamp, true),
        (&block, &sun, false),
        (&block, &lamp, false),
        (&block, &edge, true),
        (&disc, &lamp, false),
        (&ring, &sun, true),
        (&sheet, &sun, true),
        (&placed, &sun, true),
    ] {
        let description = scene(object.clone(), light.clone());
        let built = loaded(&description);
        let region = Region::whole(32, 20);
        let picture = render(&built.scene, region, &Control::default()).unwrap();
        let state = built.scene.effects.iter().find(|entry| entry.effect == Effect::Shadows).unwrap();
        let expected = if shadows { State::On } else { State::Removed };
        assert_eq!((state.state, picture.rays.shadow > 0), (expected, shadows), "{description}: {}", state.reason);
        // A body that hides nothing, far away, brings the shadow rays back.
        let mut with = description.clone();
        with["objects"] = json!([object, { "sphere": { "center": [0, 0, 1e6], "radius": 1 } }]);
        let built = loaded(&with);
        let with = render(&built.scene, region, &Control::default()).unwrap();
        let state = built.scene.effects.iter().find(|entry| entry.effect == Effect::Shadows).unwrap();
        assert_eq!(state.state, State::On);
        // Cells of space know where all of an area is free.
        let is_area = light.to_string().contains("area");
        assert!(with.rays.shadow > 0 || is_area);
        assert_eq!(with.film.pixels, picture.film.pixels, "{description}");
    }
}

/// The two cases in which plans and kernels once disagreed.
#[test]
fn black_lights_and_rays_that_weigh_too_little_ask_for_no_samples() {
    let ball = json!([{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "m" } }]);
    let mut description = json!({
        "version": 1, "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
        "lights": [
            { "point": { "position": [3, 4, 3], "color": 0, "area": { "disc": { "radius": 1 } } } },
            { "point": { "position": [3, 4, 3] } }
        ],
        "materials": { "m": { "reflection": 0.5 } }, "objects": ball
    });
    let state = |description: &Value, effect: Effect| {
        let entry = loaded(description).scene.effects.into_iter().find(|entry| entry.effect == effect).unwrap();
        (entry.state, entry.because)
    };
    assert_eq!(state(&description, Effect::SoftShadows), (State::Removed, vec!["/lights/0".into()]));
    assert_eq!(state(&description, Effect::Antialiasing).0, State::On);
    assert_eq!(loaded(&description).scene.samples, 1);
    description["materials"]["m"]["roughness"] = json!(0.5);
    assert_eq!(loaded(&description).scene.samples, 64);
    description["render"] = json!({ "min_weight": 1 });
    assert_eq!(state(&description, Effect::Gloss), (State::Removed, vec!["/render/min_weight".into()]));
    assert_eq!(loaded(&description).scene.samples, 1);
    // A perfect mirror is heavy enough.
    description["materials"]["m"]["reflection"] = json!(1);
    assert_eq!(state(&description, Effect::Gloss).0, State::On);
}
