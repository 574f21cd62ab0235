//! Models of all sizes are the same picture, though scenes have smallest lengths and largest numbers.

use super::default_look::{CUBE, FRONT, Seen, imported, matte, overrides, quads, seen};
use data_encoding::BASE64;
use serde_json::{Value, json};
use strahl::models::ModelFormat;
use strahl::scene::description::Camera;
use strahl::scene::model::ModelOptions;
use strahl::scene::{Format, Overrides};

/// An OBJ file that is 2^`power` times as large as the cube.
fn cube(power: i32) -> Vec<u8> {
    let text = std::str::from_utf8(CUBE).unwrap();
    let scaled = |line: &str| match line.strip_prefix("v ") {
        Some(numbers) => {
            let numbers = numbers.split(' ').map(|x| (x.parse::<f64>().unwrap() * 2.0_f64.powi(power)).to_string());
            format!("v {}\n", numbers.collect::<Vec<_>>().join(" "))
        }
        None => format!("{line}\n"),
    };
    text.lines().map(scaled).collect::<String>().into_bytes()
}

/// A square with a lamp before it, and one that is placed twice, 2^`power` times as large and as bright as it has to be.
fn lit_squares(power: i32) -> Vec<u8> {
    let scale = 2.0_f64.powi(power);
    let corners = FRONT.map(|corner| corner.map(|x| x * scale as f32));
    let lamp = json!({ "type": "point", "intensity": 40.0 * scale * scale, "range": 20.0 * scale });
    let more = json!({
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [lamp] } },
        "nodes": [
            { "mesh": 0 },
            { "mesh": 0, "translation": [scale, scale, -scale] },
            { "translation": [0, scale, 2.0 * scale], "extensions": { "KHR_lights_punctual": { "light": 0 } } }
        ],
        "scenes": [{ "nodes": [0, 1, 2] }]
    });
    quads(&[(corners, matte([0.8, 0.4, 0.2]))], more)
}

/// The largest difference in codes.
fn differ(a: &Seen, b: &Seen) -> u8 {
    let pairs = a.codes.as_flattened().iter().zip(b.codes.as_flattened());
    pairs.map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

#[test]
fn models_of_all_sizes_look_the_same() {
    let usual = seen(&cube(0), Format::Obj, &overrides("three_quarter"));
    assert!(usual.opaque() > 1_000);
    for power in [-190, -100, -46, -30, -19, 19, 30, 46, 100, 190] {
        let other = seen(&cube(power), Format::Obj, &overrides("three_quarter"));
        assert_eq!(usual.opaque(), other.opaque(), "2^{power}");
        assert!(differ(&usual, &other) <= 1, "2^{power}: {}", differ(&usual, &other));
    }
}

#[test]
fn lamps_of_models_of_all_sizes_shine_on_them() {
    let usual = seen(&lit_squares(0), Format::Gltf, &overrides("front"));
    assert!(usual.middle()[0] > 100, "{:?}", usual.middle());
    // The numbers of a glTF file are of single precision.
    for power in [-60, -46, -30, -18, 18, 30, 46, 60] {
        let other = seen(&lit_squares(power), Format::Gltf, &overrides("front"));
        assert_eq!(usual.opaque(), other.opaque(), "2^{power}");
        assert!(differ(&usual, &other) <= 1, "2^{power}: {}", differ(&usual, &other));
    }
}

/// Squares before a camera and a lamp of the file, all of which an animation makes ten times as large in ten seconds.
fn growing_squares() -> Vec<u8> {
    let mut file: Value = serde_json::from_slice(&lit_squares(18)).unwrap();
    let data: Vec<u8> = [0.0_f32, 10.0, 1.0, 1.0, 1.0, 10.0, 10.0, 10.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let uri = format!("data:application/octet-stream;base64,{}", BASE64.encode(&data));
    let mut add = |list: &str, element: Value| {
        let list = file[list].as_array_mut().unwrap();
        list.push(element);
        list.len() - 1
    };
    let buffer = add("buffers", json!({ "byteLength": data.len(), "uri": uri }));
    let times = add("bufferViews", json!({ "buffer": buffer, "byteLength": 8 }));
    let sizes = add("bufferViews", json!({ "buffer": buffer, "byteOffset": 8, "byteLength": 24 }));
    let of = |view: usize, kind: &str| json!({ "bufferView": view, "componentType": 5126, "count": 2, "type": kind });
    let (input, output) = (add("accessors", of(times, "SCALAR")), add("accessors", of(sizes, "VEC3")));
    let camera = add("nodes", json!({ "translation": [0, 0, 1 << 20], "camera": 0 }));
    let all = add("nodes", json!({ "children": [0, 1, 2, camera] }));
    file["scenes"] = json!([{ "nodes": [all] }]);
    file["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 1 } }]);
    file["animations"] = json!([{
        "channels": [{ "sampler": 0, "target": { "node": all, "path": "scale" } }],
        "samplers": [{ "input": input, "output": output }]
    }]);
    file.to_string().into_bytes()
}

/// While a model grows it passes the size from which it is scaled, and is scaled otherwise each time that it is twice as large.
#[test]
fn growing_models_do_not_jump_when_they_are_scaled() {
    let bytes = growing_squares();
    let at = |t: f64| {
        let model = ModelOptions { camera: Some(0), t: Some(t), ..overrides("front").model };
        let overrides = Overrides { model, ..overrides("front") };
        let description = imported(&bytes, ModelFormat::Gltf, &overrides).description;
        let Camera::Pinhole(camera) = description.camera else { panic!("a pinhole camera") };
        (seen(&bytes, Format::Gltf, &overrides), camera.eye[2])
    };
    let frames: Vec<_> = (0..=100).map(|i| at(f64::from(i) / 10.0)).collect();
    let falls = frames.windows(2).filter(|pair| pair[1].1 < 0.75 * pair[0].1).count();
    assert!(falls >= 2, "the scale changes {falls} times");
    for (i, pair) in frames.windows(2).enumerate() {
        let [(a, _), (b, _)] = pair else { panic!("two frames") };
        assert!(a.opaque() > 1_000 && a.opaque() == b.opaque(), "frame {i}: {} {}", a.opaque(), b.opaque());
        // The lamp does not grow with all else, so it pales.
        assert!(differ(a, b) <= 12, "frame {i}: {}", differ(a, b));
    }
}

/// Lamps as they are in the world, on a model of nanometres: more stops than the film has.
#[test]
fn lamps_that_are_too_bright_for_a_film_do_not_blind_it() {
    let lamp = json!({ "type": "point", "intensity": 1e30 });
    let more = json!({
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [lamp] } },
        "nodes": [{ "mesh": 0 }, { "translation": [0, 0, 2], "extensions": { "KHR_lights_punctual": { "light": 0 } } }],
        "scenes": [{ "nodes": [0, 1] }]
    });
    let bytes = quads(&[(FRONT, matte([0.8; 3]))], more);
    let [red, ..] = seen(&bytes, Format::Gltf, &overrides("front")).middle();
    assert!((150..254).contains(&red), "{red}");
}

/// A huge model and a tiny one become one scene: instances, a camera, a lamp and the depth of color of a body, too.
#[test]
fn all_lengths_of_a_model_are_scaled() {
    let description = |power: i32| {
        let scale = 2.0_f64.powi(power);
        let corners = FRONT.map(|corner| corner.map(|x| x * scale as f32));
        let mut material = matte([0.8, 0.4, 0.2]);
        material["extensions"] = json!({
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_volume": { "thicknessFactor": scale, "attenuationDistance": 3.0 * scale, "attenuationColor": [0.5, 1, 1] }
        });
        let lamp = json!({ "type": "point", "intensity": 40.0 * scale * scale, "range": 20.0 * scale });
        let camera = json!({ "type": "orthographic", "orthographic": {
            "xmag": 1.5 * scale, "ymag": 1.5 * scale, "znear": 0.1 * scale, "zfar": 100.0 * scale
        } });
        let more = json!({
            "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_transmission", "KHR_materials_volume"],
            "extensions": { "KHR_lights_punctual": { "lights": [lamp] } },
            "cameras": [camera],
            "nodes": [
                { "mesh": 0 },
                { "mesh": 0, "translation": [scale, scale, -scale], "rotation": [0, 0.6, 0, 0.8] },
                { "translation": [0, scale, 2.0 * scale], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
                { "translation": [0, 0, 4.0 * scale], "camera": 0 }
            ],
            "scenes": [{ "nodes": [0, 1, 2, 3] }]
        });
        let mut overrides = overrides("front");
        overrides.model.camera = Some(0);
        let mut description = imported(&quads(&[(corners, material)], more), ModelFormat::Gltf, &overrides).description;
        assert!(description.import_warnings.iter().any(|it| it.detail.starts_with("assumed: scale")));
        description.import_warnings.clear();
        description
    };
    let (huge, tiny) = (description(30), description(-30));
    let pbr = huge.materials.iter().find_map(|(_, material)| material.pbr.as_ref()?.attenuation);
    assert!(pbr.is_some() && huge.lights.len() == 1 && huge.definitions.len() == 1, "something is left out");
    assert_eq!(huge, tiny);
}

#[test]
fn what_is_scaled_is_said() {
    for (power, is_scaled) in [(0, false), (-19, false), (19, false), (-21, true), (21, true)] {
        let imported = imported(&cube(power), ModelFormat::Obj, &overrides("front"));
        let warned = imported.description.import_warnings.iter().any(|it| it.detail.starts_with("assumed: scale"));
        assert_eq!(warned, is_scaled, "2^{power}");
    }
}
