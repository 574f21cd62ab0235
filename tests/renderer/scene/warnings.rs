//! Scenes that render, and likely not as they were meant.

use serde_json::{Value, json};
use strahl::scene::{Format, Overrides, load};

/// Pointers of the warnings of a lit ball.
fn warned(diffuse: Value, background: Value) -> Vec<String> {
    let scene = json!({
        "version": 1,
        "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
        "background": background,
        "lights": [{ "point": { "position": [3, 3, 3] } }],
        "materials": { "red": { "diffuse": diffuse } },
        "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "red" } }]
    });
    let loaded = load(scene.to_string().as_bytes(), Format::Json, &Overrides::default()).unwrap();
    loaded.scene.warnings.into_iter().map(|warning| warning.pointer).collect()
}

#[test]
fn codes_in_the_place_of_colors_are_noticed() {
    for color in [json!([1, 0, 0]), json!("#ff0000"), json!(0.5), json!({ "checker": { "a": 1, "b": 0 } })] {
        assert!(warned(color, json!(40)).is_empty());
    }
    assert_eq!(warned(json!([255, 0, 0]), json!([10, 20, 255])), ["/materials/red/diffuse", "/background"]);
}

fn of(scene: &Value) -> Vec<String> {
    let loaded = load(scene.to_string().as_bytes(), Format::Json, &Overrides::default()).unwrap();
    loaded.scene.warnings.into_iter().map(|warning| warning.pointer).collect()
}

#[test]
fn what_glows_and_is_found_by_chance_is_named() {
    let scene = |fidelity: &str, lamp: Value| {
        json!({
            "version": 1,
            "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 1, 0] } },
            "materials": { "lamp": { "emission": 5 }, "never": { "emission": 5 } },
            "objects": [{ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0] } }, lamp],
            "render": { "fidelity": fidelity }
        })
    };
    let disc = json!({ "disc": { "center": [0, 2, 0], "normal": [0, -1, 0], "radius": 0.1, "material": "lamp" } });
    let torus =
        json!({ "torus": { "center": [0, 2, 0], "major_radius": 0.2, "minor_radius": 0.1, "material": "lamp" } });
    assert!(of(&scene("faithful", disc)).is_empty());
    assert!(of(&scene("fast", torus.clone())).is_empty());
    assert_eq!(of(&scene("faithful", torus)), ["/materials/lamp"]);
}

#[test]
fn bodies_far_from_the_origin_ask_for_double_precision() {
    let at = |x: f64, precision: &str| {
        of(&json!({
            "version": 1,
            "camera": { "pinhole": { "eye": [x, 0, 5], "look_at": [x, 0, 0] } },
            "lights": [{ "directional": { "direction": [0, -1, -1] } }],
            "objects": [{ "sphere": { "center": [x, 0, 0], "radius": 1 } }, { "plane": { "point": [0, -1, 0], "normal": [0, 1, 0] } }],
            "render": { "precision": precision }
        }))
    };
    assert!(at(100.0, "single").is_empty() && at(1e6, "double").is_empty());
    assert_eq!(at(6e3, "single"), ["/render/precision"]);
}

#[test]
fn meshes_too_small_for_single_precision_ask_for_double() {
    let of_size = |size: f64, precision: &str| {
        of(&json!({
            "version": 1,
            "camera": { "pinhole": { "eye": [0, 0, 3.0 * size], "look_at": [0, 0, 0] } },
            "lights": [{ "directional": { "direction": [0, -1, -1] } }],
            "objects": [{ "triangle": { "vertices": [[0, 0, 0], [size, 0, 0], [0, size, 0]] } }],
            "render": { "precision": precision }
        }))
    };
    assert!(of_size(1e-15, "single").is_empty() && of_size(1e-20, "double").is_empty());
    assert_eq!(of_size(1e-20, "single"), ["/render/precision"]);
}
