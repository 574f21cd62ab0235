//! Surfaces that shine by themselves.

use super::*;

/// A wall across the view, of one pixel, under light of radiance 1 along the normal.
fn wall(material: Value) -> Value {
    json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "orthographic": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "height": 1 } },
        "ambient": 0.25,
        "lights": [{ "directional": { "direction": [0, 0, -1] } }],
        "materials": { "wall": material, "mirror": { "diffuse": 0, "reflection": [0.5, 0.25, 0.125] } },
        "objects": [{ "quad": { "vertices": [[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], "material": "wall" } }]
    })
}

#[test]
fn emission_is_added_to_all_other_light() {
    for precision in ["single", "double"] {
        let lit = wall(json!({ "diffuse": 0.5, "emission": [0.25, 2, 0] }));
        // k_a I_a + k_d = 0.5 (0.25 + 1).
        assert_eq!(pixels(lit, precision), [[0.875, 2.625, 0.625]]);
        let mut back = wall(json!({ "diffuse": 0, "emission": 3 }));
        back["camera"]["orthographic"]["eye"] = json!([0, 0, -5]);
        assert_eq!(pixels(back, precision), [[3.0; 3]], "both sides shine");
    }
}

#[test]
fn mirrors_show_it_and_it_lights_nothing() {
    for precision in ["single", "double"] {
        let mut scene = wall(json!({ "diffuse": 0, "emission": [1, 2, 4] }));
        scene["lights"] = json!([]);
        scene["ambient"] = json!(0);
        scene["objects"] = json!([
            { "plane": { "point": [0, 0, 0], "normal": [0, 0, 1], "material": "mirror" } },
            { "plane": { "point": [0, 0, 9], "normal": [0, 0, -1], "material": "wall" } }
        ]);
        assert_eq!(pixels(scene.clone(), precision), [[0.5; 3]]);
        scene["materials"]["mirror"] = json!({ "diffuse": 1 });
        assert_eq!(pixels(scene, precision), [[0.0; 3]]);
    }
}

#[test]
fn clear_bodies_that_shine_are_seen() {
    for precision in ["single", "double"] {
        let mut scene = wall(json!({ "diffuse": 0, "transmission": 1, "ior": 1, "emission": 0.5 }));
        scene["background"] = json!(0.25);
        scene["objects"] = json!([{ "box": { "min": [-9, -9, 0], "max": [9, 9, 1], "material": "wall" } }]);
        assert_eq!(pixels(scene, precision), [[1.25; 3]], "two surfaces and the sky");
    }
}

#[test]
fn emission_of_0_is_not_called_for() {
    for (emission, calls) in [(0.0, false), (0.5, true)] {
        let description = wall(json!({ "emission": emission }));
        assert_eq!(effects(&description).has(Effect::Emission), calls);
        let unused = json!({ "emission": 0.5 });
        let mut description = wall(json!({}));
        description["materials"]["unused"] = unused;
        assert!(!effects(&description).has_details());
    }
}

#[test]
fn broken_emission_is_refused() {
    assert_eq!(problems(&wall(json!({ "emission": -1 }))), ["/materials/wall/emission"]);
    assert_eq!(problems(&wall(json!({ "emission": [0, 1e16, 0] }))), ["/materials/wall/emission"]);
}
