//! What moves the points and the cameras of glTF files: skins, morph targets, nodes.

use super::default_look::{FRONT, Seen, imported, matte, overrides, quads, seen};
use data_encoding::BASE64;
use serde_json::{Value, json};
use strahl::models::ModelFormat;
use strahl::scene::description::Camera;
use strahl::scene::model::import;
use strahl::scene::{Format, NoFiles};

/// A triangle that faces the front and has a skin of one joint, and the nodes: 0 is the triangle's, 1 the joint.
fn rigged(nodes: &Value, roots: &[usize], double_sided: bool) -> Vec<u8> {
    let points: Vec<u8> = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let joints = [0_u8; 12];
    let weights: Vec<u8> = [[1.0_f32, 0.0, 0.0, 0.0]; 3].iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let bytes = [points, joints.to_vec(), weights].concat();
    let accessor = |view: usize, kind: u32, shape: &str| json!({ "bufferView": view, "componentType": kind, "count": 3, "type": shape });
    let mut position = accessor(0, 5126, "VEC3");
    (position["min"], position["max"]) = (json!([0, 0, 0]), json!([1, 1, 0]));
    let file = json!({
        "asset": { "version": "2.0" }, "scenes": [{ "nodes": roots }], "nodes": nodes,
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2 }, "material": 0,
            "targets": [{ "POSITION": 0, "COLOR_0": 2 }]
        }] }],
        "skins": [{ "joints": [1] }], "materials": [{ "doubleSided": double_sided }],
        "accessors": [position, accessor(1, 5121, "VEC4"), accessor(2, 5126, "VEC4")],
        "bufferViews": [
            { "buffer": 0, "byteLength": 36 }, { "buffer": 0, "byteOffset": 36, "byteLength": 12 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 48 }
        ],
        "buffers": [{ "byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{}", BASE64.encode(&bytes)) }]
    });
    file.to_string().into_bytes()
}

fn shown(bytes: &[u8], view: &str) -> usize {
    let Seen { codes, .. } = seen(bytes, Format::Gltf, &overrides(view));
    codes.iter().filter(|codes| **codes != [0; 3]).count()
}

fn warned(bytes: &[u8]) -> String {
    let warnings = imported(bytes, ModelFormat::Gltf, &overrides("front")).description.import_warnings;
    warnings.into_iter().map(|warning| warning.detail + "\n").collect()
}

/// A node with a negative determinant turns the order of its triangles around (glTF 2.0, section 3.7.4), also by joints.
#[test]
fn mirrored_rigs_show_their_outside() {
    for scale in [[1, 1, 1], [-1, 1, 1], [1, -1, 1]] {
        let nodes = json!([{ "mesh": 0, "skin": 0 }, {}, { "children": [0, 1], "scale": scale }]);
        let file = rigged(&nodes, &[2], false);
        assert!(shown(&file, "front") > 100 && shown(&file, "back") == 0, "{scale:?}");
    }
    let turned = rigged(&json!([{ "mesh": 0, "skin": 0 }, { "scale": [1, 1, -1] }]), &[0, 1], false);
    assert!(shown(&turned, "front") == 0 && shown(&turned, "back") > 100);
}

#[test]
fn what_is_left_out_of_rigs_is_said() {
    let plain = json!([{ "mesh": 0, "skin": 0 }, {}]);
    assert_eq!(warned(&rigged(&plain, &[0, 1], true)), "");
    let mut morphed = plain.clone();
    morphed[0]["weights"] = json!([0.5]);
    assert!(warned(&rigged(&morphed, &[0, 1], true)).starts_with("skipped: morph-targets: "));
    let mut instanced = plain;
    instanced[0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 0 } } });
    assert!(warned(&rigged(&instanced, &[0, 1], true)).starts_with("skipped: instances: "));
}

/// The number of a camera is that in the file, whichever node comes first.
#[test]
fn cameras_are_those_of_their_numbers() {
    let camera = |angle: f64| json!({ "type": "perspective", "perspective": { "yfov": angle, "znear": 0.1 } });
    let more = json!({
        "cameras": [camera(0.5), camera(1.0), camera(1.5)],
        "nodes": [{ "mesh": 0 }, { "camera": 2, "translation": [0, 0, 5] }, { "camera": 0, "translation": [0, 0, 5] }],
        "scenes": [{ "nodes": [0, 1, 2] }]
    });
    let bytes = quads(&[(FRONT, matte([0.8; 3]))], more);
    let of = |number: u32| {
        let mut overrides = overrides("front");
        (overrides.model.view, overrides.model.camera) = (None, Some(number));
        import(ModelFormat::Gltf, &bytes, &overrides, &NoFiles)
    };
    for (number, angle) in [(0, 0.5_f64), (2, 1.5)] {
        let Camera::Pinhole(pinhole) = of(number).unwrap().description.camera else { panic!("a pinhole camera") };
        assert!((pinhole.vfov_deg - angle.to_degrees()).abs() < 1e-9, "{number}: {pinhole:?}");
    }
    let refused = of(1).unwrap_err().to_string();
    assert!(refused.contains("/cameras") && refused.contains("there is no camera 1 in the scene"), "{refused}");
}

#[test]
fn nothing_is_seen_of_what_no_opacity_is_enough_for() {
    let opaque = |cutoff: f64| {
        let mut material = matte([0.8; 3]);
        (material["alphaMode"], material["alphaCutoff"]) = (json!("MASK"), json!(cutoff));
        seen(&quads(&[(FRONT, material)], json!({})), Format::Gltf, &overrides("front")).opaque()
    };
    assert!(opaque(1.0) > 100 && opaque(0.5) == opaque(1.0));
    assert_eq!(opaque(1.5), 0);
}

#[test]
fn nodes_beyond_all_numbers_are_named() {
    for node in [json!({ "mesh": 0, "translation": [1e308, 0, 0] }), json!({ "mesh": 0, "scale": [1e200, 1, 1] })] {
        let bytes = quads(&[(FRONT, matte([0.8; 3]))], json!({ "nodes": [node] }));
        let problems = import(ModelFormat::Gltf, &bytes, &overrides("front"), &NoFiles).map(drop).unwrap_err();
        assert_eq!((problems.0.len(), problems.0[0].pointer.as_str()), (1, "/nodes/0"), "{problems}");
    }
}
