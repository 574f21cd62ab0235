//! A variation of a scene is the scene: pixels, plans and warnings, whatever the patch, whether its geometry was built again or
//! not.

use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::convert::Infallible;
use std::sync::Arc;
use strahl::film::Region;
use strahl::plan::Plan;
use strahl::render::{Control, render};
use strahl::scene::compile::{Original, Precise};
use strahl::scene::variation::vary_if;
use strahl::scene::{Format, Loaded, NoFiles, NotLoaded, Overrides, Problem, Problems, Scene, load};

/// Every kind of body, some of them placed twice, under several lights.
fn scene() -> Value {
    let triangle = json!({ "triangle": { "vertices": [[-3, 0, 1], [-2, 0, 1], [-2.5, 1, 1]], "material": "red" } });
    let mesh = json!({ "mesh": {
        "vertices": [[0, 0, 0], [1, 0, 0], [0.5, 0, 0.9], [0.5, 1, 0.4]],
        "faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        "uvs": [[0, 0], [1, 0], [0, 1], [1, 1]],
        "material": "shell" } });
    json!({
        "version": 1,
        "name": "bodies",
        "image": { "width": 40, "height": 24 },
        "camera": { "pinhole": { "eye": [0, 1.5, 6], "look_at": [0, 0.5, 0] } },
        "background": [0.3, 0.5, 0.8],
        "lights": [
            { "point": { "position": [2, 4, 3], "color": [1, 1, 1], "falloff": "inverse_square", "intensity": 20 } },
            { "directional": { "direction": [1, -2, -1] } },
        ],
        "materials": {
            "glass": { "diffuse": 0.05, "transmission": 0.9, "reflection": 0.1, "ior": 1.5 },
            "shell": { "diffuse": 0.1, "transmission": 0.8, "ior": 1.3 },
            "red": { "diffuse": [0.8, 0.2, 0.1], "specular": 0.5, "reflection": 0.2 },
            "floor": { "diffuse": { "checker": { "a": 0.8, "b": 0.2, "size": 1 } } },
        },
        "definitions": { "pair": [mesh, { "sphere": { "center": [0.5, 1.5, 0.4], "radius": 0.4, "material": "red" } }] },
        "objects": [
            { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor" } },
            { "sphere": { "center": [-1.2, 0.7, 0], "radius": 0.7, "material": "glass" } },
            triangle,
            { "instance": { "of": "pair", "transform": { "translate": [0.5, 0.01, 0] } } },
            { "group": { "transform": { "translate": [1, 0, -2] }, "objects": [
                { "instance": { "of": "pair" } },
                { "torus": { "center": [1, 1, 0], "axis": [0, 1, 1], "major_radius": 0.6, "minor_radius": 0.2 } },
            ] } },
        ],
        "render": { "max_depth": 5 },
    })
}

fn loaded(text: &Value, overrides: &Overrides) -> Result<Loaded, Problems> {
    load(text.to_string().as_bytes(), Format::Json, overrides)
}

fn varied(original: &Loaded, patch: &Value, overrides: &Overrides) -> Result<Loaded, Problems> {
    let known = Original { description: &original.description, scene: &original.scene };
    let accept = |_: &_| Ok::<_, Infallible>(());
    vary_if(known, patch.to_string().as_bytes(), overrides, &NoFiles, &accept)
        .map_err(|NotLoaded::Problems(problems)| problems)
}

/// RFC 7396, once more.
fn merged(target: &Value, patch: &Value) -> Value {
    let Value::Object(changes) = patch else { return patch.clone() };
    let mut result = target.as_object().cloned().unwrap_or_default();
    for (key, change) in changes {
        match change {
            Value::Null => drop(result.remove(key)),
            change => {
                let was = result.get(key).cloned().unwrap_or(Value::Null);
                result.insert(key.clone(), merged(&was, change));
            }
        }
    }
    result.into()
}

/// All that is seen and said of a scene, but for times and places in a text.
fn told(mut loaded: Loaded) -> (Vec<u32>, Value) {
    let scene = &loaded.scene;
    let picture = render(scene, Region::whole(scene.width, scene.height), &Control::default()).unwrap();
    let pixels = picture.film.pixels.iter().flatten().map(|channel| channel.to_bits()).collect();
    let mut plan = serde_json::to_value(Plan::new(&mut loaded.description, scene)).unwrap();
    plan["explain_ms"] = Value::Null;
    for warning in plan["warnings"].as_array_mut().unwrap() {
        (warning["line"], warning["column"]) = (Value::Null, Value::Null);
    }
    let rays = format!("{:?}", picture.rays);
    let facts = json!([plan, rays, scene.samples, scene.expanded_primitives, scene.picture_bytes]);
    (pixels, facts)
}

fn geometry_is_shared(a: &Scene, b: &Scene) -> bool {
    match (&a.world, &b.world) {
        (Precise::Single(a), Precise::Single(b)) => Arc::ptr_eq(&a.geometries, &b.geometries),
        (Precise::Double(a), Precise::Double(b)) => Arc::ptr_eq(&a.geometries, &b.geometries),
        _ => false,
    }
}

const PNG: &str = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAIAAAD91JpzAAAAFElEQVR4nGP4z8DAAMIM////ZwAAHu8E/KPItPcAAAAASUVORK5CYII=";

fn patches() -> Vec<(Value, bool)> {
    let keeps = |patch: Value| (patch, true);
    let builds = |patch: Value| (patch, false);
    vec![
        keeps(json!({})),
        keeps(json!({ "camera": { "pinhole": { "eye": [3, 2, 4] } } })),
        keeps(json!({ "camera": { "pinhole": { "eye": [-1.2, 0.7, 0.1], "aperture": 0.5, "focus_distance": 3 } } })),
        keeps(
            json!({ "camera": { "pinhole": null, "orthographic": { "eye": [3, 2, 4], "look_at": [0, 0, 0], "height": 4 } } }),
        ),
        keeps(
            json!({ "lights": [{ "point": { "position": [0, 3, 0], "falloff": "inverse_square", "intensity": 9 } }] }),
        ),
        keeps(json!({ "lights": [] })),
        keeps(json!({ "background": [1, 0, 0], "ambient": 0, "name": null, "fog": { "density": 0.1, "color": 0.5 } })),
        keeps(json!({ "environment": { "sky": {} }, "film": { "exposure": 1, "background": "transparent" } })),
        keeps(json!({ "render": { "max_depth": 2, "samples": 2, "shadows": "none" }, "image": { "width": 17 } })),
        keeps(json!({ "render": { "accuracy": { "fixed": {} }, "antialias": false } })),
        keeps(json!({ "materials": { "red": { "diffuse": [0, 0, 1], "specular": 0 } } })),
        builds(json!({ "materials": { "glass": { "transmission": 0 } } })),
        builds(json!({ "materials": { "glass": { "transmission": 0.2, "dispersion": 0.05 } } })),
        builds(json!({ "materials": { "red": { "one_sided": true }, "floor": { "one_sided": true } } })),
        builds(json!({ "materials": { "blue": { "diffuse": [0, 0, 1] } } })),
        builds(
            json!({ "materials": { "shell": { "diffuse": { "image": { "source": PNG, "mapping": "uv" } }, "transmission": 0 } } }),
        ),
        builds(json!({ "render": { "precision": "double" } })),
        builds(json!({ "definitions": { "pair": [{ "sphere": { "center": [0, 1, 0], "radius": 0.5 } }] } })),
        builds(json!({ "objects": [{ "instance": { "of": "pair" } }] })),
        builds(json!({ "definitions": { "other": [] } })),
    ]
}

#[test]
fn a_variation_is_the_scene_that_results() {
    let text = scene();
    let original = loaded(&text, &Overrides::default()).unwrap();
    for (patch, keeps_geometry) in patches() {
        for overrides in
            [Overrides::default(), Overrides { width: Some(20), max_depth: Some(3), ..Overrides::default() }]
        {
            let whole = loaded(&merged(&text, &patch), &overrides).unwrap_or_else(|e| panic!("{patch}: {e}"));
            let part = varied(&original, &patch, &overrides).unwrap_or_else(|e| panic!("{patch}: {e}"));
            assert_eq!(part.description, whole.description, "{patch}");
            assert_eq!(geometry_is_shared(&part.scene, &original.scene), keeps_geometry, "{patch}");
            assert!(part.scene.bytes_beside(&original.scene) <= part.scene.bytes(), "{patch}");
            let ((pixels, facts), (all_pixels, all_facts)) = (told(part), told(whole));
            assert!(pixels == all_pixels, "{patch} has other pixels");
            assert_eq!(facts, all_facts, "{patch}");
        }
    }
}

/// Where bodies overlap the smaller one decides, and a sheet encloses nothing.
#[test]
fn a_sheet_that_becomes_a_body_encloses_as_much_as_any() {
    let glass =
        |thin: bool, ior: f64| json!({ "pbr": { "base_color": 1, "transmission": 1, "thin": thin, "ior": ior } });
    let ball = |x: f64, radius: f64, material: &str| json!({ "sphere": { "center": [x, 0, 0], "radius": radius, "material": material } });
    let text = json!({
        "version": 1,
        "image": { "width": 40, "height": 24 },
        "camera": { "pinhole": { "eye": [0, 0, 6], "look_at": [0, 0, 0] } },
        "environment": { "sky": {} },
        "materials": { "sheet": glass(true, 1.2), "body": glass(false, 2.0) },
        "objects": [ball(-0.4, 1.2, "sheet"), ball(0.4, 0.9, "body")],
    });
    let patch = json!({ "materials": { "sheet": { "pbr": { "thin": false } } } });
    let original = loaded(&text, &Overrides::default()).unwrap();
    let part = varied(&original, &patch, &Overrides::default()).unwrap();
    let whole = loaded(&merged(&text, &patch), &Overrides::default()).unwrap();
    assert!(told(part) == told(whole), "the variation is another scene");
}

/// Several changes at once, of variations of variations.
#[test]
fn variations_of_variations_are_scenes() {
    let all = patches();
    let mut state = 7_u64;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for _ in 0..24 {
        let mut text = scene();
        let mut last = loaded(&text, &Overrides::default()).unwrap();
        for _ in 0..3 {
            let (a, b) = (&all[next(all.len())].0, &all[next(all.len())].0);
            // A patch of a patch keeps nulls, which remove.
            let mut patch = a.clone();
            for (key, value) in b.as_object().unwrap() {
                patch[key] = value.clone();
            }
            text = merged(&text, &patch);
            let (whole, part) = (loaded(&text, &Overrides::default()), varied(&last, &patch, &Overrides::default()));
            match (whole, part) {
                (Ok(whole), Ok(part)) => {
                    assert_eq!(part.description, whole.description, "{text}");
                    last = varied(&last, &patch, &Overrides::default()).unwrap();
                    assert!(told(part) == told(whole), "{text}");
                }
                (Err(Problems(mut whole)), Err(Problems(part))) => {
                    whole.iter_mut().for_each(|problem| (problem.line, problem.column) = (None, None));
                    assert_eq!(part, whole, "{text}");
                    break;
                }
                (whole, part) => panic!("{text}: {:?}, {:?}", whole.err(), part.err()),
            }
        }
    }
}

#[test]
fn problems_are_those_of_the_result() {
    let original = loaded(&scene(), &Overrides::default()).unwrap();
    for (patch, pointer, part) in [
        (json!({ "camera": null }), "", "camera"),
        (json!({ "camera": { "pinhole": { "vfov_deg": 900 } } }), "/camera/pinhole/vfov_deg", ""),
        (json!({ "camera": { "pinhole": { "vfov": 40 } } }), "/camera/pinhole/vfov", "vfov_deg"),
        (
            json!({ "camera": { "orthographic": { "eye": [0, 0, 1], "look_at": [0, 0, 0], "height": 1 } } }),
            "/camera",
            "",
        ),
        (json!({ "materials": { "glass": null } }), "/objects/1/sphere/material", "glass"),
        (json!({ "materials": null }), "/objects/0/plane/material", "floor"),
        (json!({ "definitions": { "pair": null } }), "/objects/3/instance/of", "pair"),
        (json!({ "objects": null }), "", "objects"),
        (json!({ "objects": [] }), "/objects", ""),
        (json!({ "version": 2 }), "/version", ""),
        (json!({ "lihgts": [] }), "/lihgts", "lights"),
        (json!([]), "", "patch"),
        (json!("a"), "", "patch"),
    ] {
        let Problems(problems) = varied(&original, &patch, &Overrides::default()).map(drop).unwrap_err();
        let found = problems.iter().find(|problem| problem.pointer == pointer);
        let found = found.unwrap_or_else(|| panic!("{patch}: {problems:?}"));
        assert!(found.detail.contains(part), "{patch}: {found:?}");
        let whole =
            if patch.is_object() { loaded(&merged(&scene(), &patch), &Overrides::default()).map(drop) } else { Ok(()) };
        if let Err(Problems(whole)) = whole {
            let said = |problem: &Problem| (problem.pointer.clone(), problem.detail.clone());
            assert_eq!(problems.iter().map(said).collect::<BTreeSet<_>>(), whole.iter().map(said).collect(), "{patch}");
        }
        assert!(problems.iter().all(|problem| problem.line.is_none() && problem.column.is_none()), "{problems:?}");
    }
    let deep = format!("{}0{}", "{\"fog\":".repeat(5_000), "}".repeat(5_000));
    let known = Original { description: &original.description, scene: &original.scene };
    let refused = vary_if(known, deep.as_bytes(), &Overrides::default(), &NoFiles, &|_| Ok::<_, Infallible>(()));
    let Err(NotLoaded::Problems(problems)) = refused else { panic!("it is too deep") };
    assert!(problems.to_string().contains("recursion"), "{problems}");
}

/// The id of a picture does not depend on the order of materials, so nothing that its file says may.
#[test]
fn the_order_of_materials_changes_nothing_that_is_proved() {
    let because = |materials: &str| {
        let text = format!(
            r#"{{"version": 1, "camera": {{"pinhole": {{"eye": [0, 0, 9], "look_at": [0, 0, 0]}}}}, "materials": {{{materials}}},
                "lights": [{{"directional": {{"direction": [0, -1, -1]}}}}],
                "objects": [{{"sphere": {{"center": [-1, 0, 0], "radius": 1, "material": "a"}}}},
                            {{"sphere": {{"center": [1, 0, 0], "radius": 1, "material": "b"}}}}]}}"#
        );
        let loaded = load(text.as_bytes(), Format::Json, &Overrides::default()).unwrap();
        loaded.scene.ceiling().reach.because.clone()
    };
    let [a, b] = ["a", "b"].map(|name| format!(r#""{name}": {{"reflection": 1, "diffuse": 0.5}}"#));
    assert_eq!(because(&format!("{a}, {b}")), ["/materials/a"]);
    assert_eq!(because(&format!("{b}, {a}")), ["/materials/a"]);
}
