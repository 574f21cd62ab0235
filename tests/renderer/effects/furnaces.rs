//! White furnaces: in light of one color from everywhere a body that loses none is as bright as that, whatever it is made of.

use super::faithful::{ball, faithful, mean};
use super::*;

/// In surroundings of one color white sends on all light, whatever it is made of; light without rays says the same.
#[test]
fn a_furnace_keeps_its_light() {
    let one = || json!({ "background": 1, "environment": Value::Null });
    let coat = |amount: f64, roughness: f64| json!({ "clearcoat": amount, "clearcoat_roughness": roughness });
    for precision in ["single", "double"] {
        for (metallic, roughness, ior, coat) in [
            (0.0, 0.0, 1.5, coat(0.0, 0.0)),
            (0.0, 0.0, 2.4, coat(0.0, 0.0)),
            (0.0, 0.0, 1.0, coat(0.0, 0.0)),
            (0.0, 0.3, 1.0, coat(0.0, 0.0)),
            (0.0, 0.3, 1.5, coat(0.0, 0.0)),
            (0.0, 0.8, 1.5, coat(1.0, 0.3)),
            (0.0, 1.0, 1.5, coat(1.0, 1.0)),
            (1.0, 0.0, 1.5, coat(0.0, 0.0)),
            (1.0, 0.25, 1.5, coat(0.0, 0.0)),
            (1.0, 1.0, 1.5, coat(0.0, 0.0)),
            (0.5, 0.6, 1.5, coat(0.5, 0.3)),
            (0.5, 1.0, 1.5, coat(0.0, 0.0)),
        ] {
            let mut material = json!({ "metallic": metallic, "roughness": roughness, "ior": ior });
            material.as_object_mut().unwrap().extend(coat.as_object().unwrap().clone());
            let material = json!({ "pbr": material });
            let [got, ..] = mean(&pixels(ball(material.clone(), one(), faithful(4, 64)), precision));
            assert!((got - 1.0).abs() < 0.003, "{material}: {got}");
            let mut without = ball(material.clone(), one(), json!({}));
            without["ambient"] = json!(1);
            let [fast, ..] = mean(&pixels(without, precision));
            assert!((fast - 1.0).abs() < 0.005, "{material} without rays: {fast}");
        }
    }
}

/// A turned cube as a mesh, whose vertices have the normals of its faces.
fn cube_with_normals() -> Value {
    let turned = |[x, y, z]: [f64; 3]| [0.8 * x + 0.6 * z, y, 0.8 * z - 0.6 * x];
    let (mut vertices, mut normals, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let first = vertices.len();
            for (a, b) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
                // Counter-clockwise from outside.
                let mut corner = [0.5 * side; 3];
                (corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (a * side, b);
                let mut normal = [0.0; 3];
                normal[axis] = side;
                vertices.push(turned(corner));
                normals.push(turned(normal));
            }
            faces.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    json!({ "mesh": { "vertices": vertices, "normals": normals, "faces": faces, "material": "it" } })
}

/// A furnace that follows rays far into bodies.
fn furnace(material: &Value, samples: u32) -> Value {
    let mut render = faithful(200, samples);
    render["min_weight"] = json!(1e-4);
    ball(material.clone(), json!({ "background": 1, "environment": Value::Null }), render)
}

/// Also what lets a part of the light in: in a ball all that is scattered inside comes to its wall at the same angle again and again,
/// which reflects it totally. And what has no reflection of its own.
#[test]
fn bodies_that_are_partly_glass_keep_their_light() {
    for (transmission, roughness, metallic, more) in [
        (0.3, 0.0, 0.0, json!({})),
        (0.5, 0.0, 0.0, json!({})),
        (0.9, 0.4, 0.0, json!({})),
        (0.5, 0.0, 0.5, json!({})),
        (0.5, 0.0, 0.0, json!({ "clearcoat": 1 })),
        (1.0, 0.0, 0.0, json!({ "specular": 0 })),
        (1.0, 0.3, 0.0, json!({ "specular": 0.5 })),
        (1.0, 1.0, 0.0, json!({ "specular_color": [2, 2, 2] })),
        (0.5, 0.0, 0.0, json!({ "specular_color": [2, 2, 2] })),
        (0.8, 0.0, 0.0, json!({ "specular_color": [5, 5, 5] })),
        (0.5, 0.5, 0.0, json!({ "specular_color": [5, 5, 5] })),
        (1.0, 0.0, 0.0, json!({ "specular_color": [2, 2, 2] })),
    ] {
        let mut material = json!({ "metallic": metallic, "roughness": roughness, "transmission": transmission });
        material.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let [kept, ..] = mean(&pixels(furnace(&json!({ "pbr": material }), 256), "double"));
        assert!((kept - 1.0).abs() < 0.006, "{material}: {kept}");
    }
}

/// So does rough glass, in bodies and in sheets: what facets hide from each other is not lost.
#[test]
fn rough_glass_keeps_its_light() {
    for roughness in [0.2, 0.6, 1.0] {
        let material = json!({ "pbr": { "metallic": 0, "roughness": roughness, "transmission": 1 } });
        let [body, ..] = mean(&pixels(furnace(&material, 64), "double"));
        assert!((body - 1.0).abs() < 0.004, "a ball of roughness {roughness}: {body}");
        let mut scene = furnace(&material, 64);
        scene["objects"] = json!([cube_with_normals()]);
        let [cube, ..] = mean(&pixels(scene, "double"));
        assert!((cube - 1.0).abs() < 0.004, "a mesh of roughness {roughness}: {cube}");
        for place in [0.0, 10.0, 40.0] {
            let mut scene = furnace(&material, 64);
            scene["camera"] =
                json!({ "orthographic": { "eye": [place, 0, 10], "look_at": [0, 0, 0], "height": 0.01 } });
            scene["objects"] = json!([{ "quad": {
                "vertices": [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], "material": "it"
            } }]);
            let [sheet, ..] = mean(&pixels(scene, "double"));
            assert!((sheet - 1.0).abs() < 0.004, "a sheet of roughness {roughness} from {place}: {sheet}");
        }
    }
}

/// Total reflection takes what the clearcoat would mirror, too.
#[test]
fn lacquered_glass_keeps_its_light() {
    for clearcoat in [0.3, 1.0] {
        let material = json!({ "metallic": 0, "roughness": 0, "transmission": 1, "clearcoat": clearcoat });
        let scene = json!({
            "version": 1, "image": { "width": 24, "height": 24 }, "ambient": 0, "lights": [], "background": 1,
            "render": { "max_depth": 200, "min_weight": 1e-5 },
            "camera": { "orthographic": { "eye": [2, 3, 5], "look_at": [0, 0, 0], "height": 1.6 } },
            "materials": { "it": { "pbr": material } },
            "objects": [{ "box": { "min": [-0.5, -0.5, -0.5], "max": [0.5, 0.5, 0.5], "material": "it" } }]
        });
        for [kept, ..] in pixels(scene, "single") {
            assert!((kept - 1.0).abs() < 0.004, "clearcoat {clearcoat}: {kept}");
        }
    }
}
