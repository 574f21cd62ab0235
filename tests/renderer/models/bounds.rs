//! Small files that would be much in memory, or work without end.

use super::default_look::{FRONT, imported, matte, overrides, quads, seen};
use data_encoding::BASE64;
use serde_json::json;
use std::time::{Duration, Instant};
use strahl::models::{Choice, ModelFormat, read};
use strahl::render::Control;
use strahl::scene::model::import;
use strahl::scene::problem::Code;
use strahl::scene::{Format, NoFiles, Overrides, Problems};

fn refused(bytes: &[u8]) -> Problems {
    import(ModelFormat::Gltf, bytes, &Overrides::default(), &NoFiles).unwrap_err()
}

/// A picture is written into the scene wherever a material names it.
#[test]
fn a_picture_in_too_many_materials_is_refused_before_it_is_copied() {
    let picture = [b"\x89PNG\r\n\x1a\n".as_slice(), &[0; 1 << 20]].concat();
    let material = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } });
    let materials: Vec<_> = (0..1_000).map(|_| (FRONT, material.clone())).collect();
    let more = json!({
        "images": [{ "uri": format!("data:image/png;base64,{}", BASE64.encode(&picture)) }], "textures": [{ "source": 0 }]
    });
    let Problems(problems) = refused(&quads(&materials, more));
    assert!(problems[0].code == Code::Limit && problems[0].detail.contains("decoded_bytes"), "{problems:?}");
}

#[test]
fn long_names_are_cut_before_they_are_copied() {
    let name = "\u{e9}".repeat(100_000);
    let more = json!({
        "cameras": [{ "name": name, "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }],
        "nodes": [{ "mesh": 0, "name": name, "camera": 0, "translation": [0, 0, 3] }]
    });
    let model =
        read(ModelFormat::Gltf, &quads(&[(FRONT, matte([0.5; 3]))], more), &|_| Err(String::new()), Choice::default());
    let model = model.unwrap();
    assert_eq!(model.cameras[0].name.as_ref().map(String::len), Some(256));
    assert_eq!(model.placements[0].name.as_ref().map(String::len), Some(256));
}

/// A glTF of some nodes with the same mesh of so many primitives of points.
fn pairs(nodes: usize, primitives: usize) -> Vec<u8> {
    let primitive = json!({ "attributes": { "POSITION": 1 }, "mode": 0 });
    let more = json!({
        "meshes": [{ "primitives": vec![primitive; primitives] }],
        "nodes": vec![json!({ "mesh": 0 }); nodes], "scenes": [{ "nodes": (0..nodes).collect::<Vec<_>>() }]
    });
    quads(&[(FRONT, matte([0.5; 3]))], more)
}

/// Few bytes of nodes and primitives are billions of pairs: whoever waits no longer is not worked for.
#[test]
fn nodes_with_many_primitives_can_be_cancelled() {
    let bytes = pairs(60_000, 20_000);
    let control = Control::default();
    let started = Instant::now();
    let cancelled = std::thread::scope(|scope| {
        let other = control.clone();
        scope.spawn(move || {
            std::thread::sleep(Duration::from_millis(500));
            other.cancel();
        });
        let _entered = control.enter();
        refused(&bytes)
    });
    assert_eq!(cancelled.0[0].code, Code::Cancelled, "{cancelled} after {:?}", started.elapsed());
}

/// Names that are taken one after the other: each free one was looked for from the first.
#[test]
fn names_that_are_taken_are_passed_over() {
    let named = |name: String| {
        let mut material = matte([0.5; 3]);
        material["name"] = json!(name);
        (FRONT, material)
    };
    let count = 3_000;
    let taken = (count..2 * count).map(|at| named(format!("a {at}")));
    let all: Vec<_> = taken.chain((0..count).map(|_| named("a".to_owned()))).collect();
    let model = imported(&quads(&all, json!({})), ModelFormat::Gltf, &overrides("front"));
    assert!(model.description.materials.len() >= 2 * count);
}

/// Programs write the largest number for lamps that shine without end.
#[test]
fn lamps_of_any_range_are_taken() {
    let bright = |range: f32| {
        let more = json!({
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 40, "range": range }] } },
            "nodes": [{ "mesh": 0 }, { "translation": [0, 1, 2], "extensions": { "KHR_lights_punctual": { "light": 0 } } }],
            "scenes": [{ "nodes": [0, 1] }]
        });
        seen(&quads(&[(FRONT, matte([0.5; 3]))], more), Format::Gltf, &overrides("front")).middle()
    };
    let [endless, far, tiny] = [f32::MAX, 1e6, 1e-30].map(bright);
    assert_eq!(endless, far);
    assert!(tiny < far, "{tiny:?} {far:?}");
}

/// A file without any vertex in it may still have millions of them, each material of a mesh its own.
#[test]
fn vertices_in_too_many_materials_are_refused_before_they_are_copied() {
    let count = 1_500_000;
    let data =
        [[0_u8, 1, 2, 0].as_slice(), &[0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes).concat()];
    let data = data.concat();
    let sparse = json!({
        "count": 3, "indices": { "bufferView": 0, "componentType": 5121 }, "values": { "bufferView": 1 }
    });
    let mut document = json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": 40, "uri": format!("data:application/octet-stream;base64,{}", BASE64.encode(&data)) }],
        "bufferViews": [{ "buffer": 0, "byteLength": 3 }, { "buffer": 0, "byteOffset": 4, "byteLength": 36 }],
        "accessors": [
            { "componentType": 5126, "count": count, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0], "sparse": sparse },
            { "componentType": 5126, "count": count, "type": "VEC4" }
        ],
        "nodes": [{ "mesh": 0 }], "scenes": [{ "nodes": [0] }]
    });
    let primitive = |material: usize| json!({ "attributes": { "POSITION": 0, "COLOR_0": 1 }, "material": material });
    document["meshes"] = json!([{ "primitives": (0..16).map(primitive).collect::<Vec<_>>() }]);
    document["materials"] = json!(vec![matte([0.5; 3]); 16]);
    let Problems(problems) = refused(document.to_string().as_bytes());
    assert!(problems[0].code == Code::Limit && problems[0].detail.contains("decoded_bytes"), "{problems:?}");
}
