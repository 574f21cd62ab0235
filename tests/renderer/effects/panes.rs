//! Light that passes glass: none is lost, and none made.

use super::faithful::{ball, faithful, mean};
use super::*;

/// Without rays rough glass lets in what its wide lobe does not reflect, so it is not seen in a furnace.
#[test]
fn frosted_glass_keeps_the_light_of_a_furnace() {
    for precision in ["single", "double"] {
        for (ior, roughness, thin) in [
            (1.5, 0.05, false),
            (1.5, 0.11, false),
            (1.5, 0.6, false),
            (1.5, 1.0, true),
            (1.0, 0.15, true),
            (1.0, 0.15, false),
            (2.5, 0.3, false),
        ] {
            let glass = json!({ "metallic": 0, "roughness": roughness, "transmission": 1, "ior": ior, "thin": thin });
            let mut scene =
                ball(json!({ "pbr": glass }), json!({ "background": 1, "environment": Value::Null }), json!({}));
            scene["ambient"] = json!(1);
            for [red, ..] in pixels(scene, precision) {
                assert!((red - 1.0).abs() < 0.01, "{ior} {roughness} {thin}: {red}");
            }
        }
    }
}

/// What is clear hides no light: shadow rays to what glows end at a pane, and rays of lobes pass it.
#[test]
fn a_clear_pane_takes_no_light_of_what_glows() {
    let quad = |height: f64, size: f64, material: &str| {
        let [a, b] = [-size, size];
        json!({ "quad": {
            "vertices": [[a, height, b], [b, height, b], [b, height, a], [a, height, a]], "material": material
        } })
    };
    let floor = |pane: Option<Value>, lamp: Value, environment: Value| {
        let mut objects = vec![quad(0.0, 9.0, "floor"), lamp];
        objects.extend(pane.is_some().then(|| quad(1.0, 9.0, "pane")));
        let scene = json!({
            "version": 1, "image": { "width": 4, "height": 4 },
            "camera": { "pinhole": { "eye": [0, 0.5, 3], "look_at": [0, 0, 0], "vfov_deg": 2 } },
            "ambient": 0, "lights": [], "environment": environment,
            "materials": {
                "floor": { "diffuse": 0.8 }, "lamp": { "diffuse": 0, "emission": 3 },
                "pane": pane.unwrap_or_else(|| json!({ "diffuse": 0 }))
            },
            "objects": objects, "render": faithful(10, 1024)
        });
        mean(&pixels(scene, "single"))[0]
    };
    let ball = json!({ "sphere": { "center": [0, 3, 0], "radius": 1, "material": "lamp" } });
    for lamp in [quad(3.0, 1.0, "lamp"), ball] {
        let open = floor(None, lamp.clone(), Value::Null);
        assert!(open > 0.05, "{lamp}: {open}");
        for pane in [
            json!({ "diffuse": 0, "transmission": 1, "ior": 1.5 }),
            json!({ "diffuse": 0, "fresnel": "dielectric", "reflection": 0, "transmission": 1, "ior": 1 }),
            json!({ "diffuse": 0, "transmission": 0.999, "ior": 1.5 }),
        ] {
            let behind = floor(Some(pane.clone()), lamp.clone(), Value::Null);
            assert!((behind / open - 1.0).abs() < 0.1, "{lamp} {pane}: {behind} of {open}");
        }
    }
}
