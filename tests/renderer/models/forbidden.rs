//! What the specifications forbid: told where it can be mended, else refused with a place in the file.

use super::default_look::{FRONT, imported, matte, overrides, quads, seen};
use serde_json::{Value, json};
use strahl::models::ModelFormat;
use strahl::scene::{Format, Overrides, Problem, load};

/// A square, with more keys in its file.
fn square(more: Value) -> Vec<u8> {
    quads(&[(FRONT, matte([0.5; 3]))], more)
}

fn warned(format: ModelFormat, bytes: &[u8], overrides: &Overrides) -> Vec<String> {
    let warnings = imported(bytes, format, overrides).description.import_warnings;
    warnings.into_iter().map(|warning| warning.detail).collect()
}

fn refused(format: Format, bytes: &[u8], overrides: &Overrides) -> Problem {
    let problem = load(bytes, format, overrides).unwrap_err().0.remove(0);
    assert!(problem.line.is_some() || problem.offset.is_some(), "{problem:?}");
    problem
}

fn through(camera: u32) -> Overrides {
    let mut overrides = overrides("front");
    (overrides.model.camera, overrides.model.view) = (Some(camera), None);
    overrides
}

#[test]
fn numbers_out_of_range_are_the_nearest_in_range() {
    let material = |pbr: Value| {
        let mut material = matte([0.5; 3]);
        material["pbrMetallicRoughness"].as_object_mut().unwrap().extend(pbr.as_object().unwrap().clone());
        quads(&[(FRONT, material)], json!({}))
    };
    let (wrong, right) = (material(json!({ "roughnessFactor": 3 })), material(json!({ "roughnessFactor": 1 })));
    let view = overrides("front");
    let told = warned(ModelFormat::Gltf, &wrong, &view);
    assert!(told.iter().any(|it| it.contains("/materials/0/pbrMetallicRoughness/roughnessFactor is 3 and taken as 1")));
    assert!(!warned(ModelFormat::Gltf, &right, &view).iter().any(|it| it.contains("ranges")));
    assert!(seen(&wrong, Format::Gltf, &view).codes == seen(&right, Format::Gltf, &view).codes);
}

/// serde would take a list as an object with its values in the order of our fields.
#[test]
fn a_list_is_no_object() {
    for (key, value) in [
        ("materials", json!([["m", [[1, 0, 0, 1]]]])),
        ("nodes", json!([["name", [], 0]])),
        ("scenes", json!([["name", [0]]])),
        ("asset", json!(["2.0"])),
        ("extensions", json!([[["point"]]])),
    ] {
        let problem = refused(Format::Gltf, &square(json!({ key: value })), &overrides("front"));
        assert!(problem.pointer.starts_with(&format!("/{key}")), "{problem:?}");
        assert!(problem.detail.ends_with("expected an object"), "{problem:?}");
    }
}

#[test]
fn copies_in_one_place_are_one() {
    let nodes = |count: usize| {
        let nodes: Vec<Value> = (0..count).map(|_| json!({ "mesh": 0 })).collect();
        square(json!({ "nodes": nodes, "scenes": [{ "nodes": (0..count).collect::<Vec<_>>() }] }))
    };
    let view = overrides("front");
    let (one, many) = (nodes(1), nodes(50_000));
    assert!(warned(ModelFormat::Gltf, &many, &view).iter().any(|it| it.contains("copies in one place")));
    assert!(seen(&one, Format::Gltf, &view).codes == seen(&many, Format::Gltf, &view).codes);
    // A root that a scene names twice is there once, without a word: nothing is left out.
    let twice = square(json!({ "scenes": [{ "nodes": [0, 0] }] }));
    assert_eq!(warned(ModelFormat::Gltf, &twice, &view), warned(ModelFormat::Gltf, &one, &view));
}

/// 65,000 nodes of a mesh with 20,000 targets are more pairs than anybody waits for, and all of them say the same.
#[test]
fn many_nodes_of_a_mesh_with_many_targets_are_read() {
    let nodes: Vec<Value> = (0..65_000).map(|i| json!({ "mesh": 0, "translation": [i, 0, 0] })).collect();
    let target = json!({ "POSITION": 1 });
    let file = square(json!({
        "nodes": nodes, "scenes": [{ "nodes": (0..65_000).collect::<Vec<_>>() }],
        "meshes": [{
            "primitives": [{ "attributes": { "POSITION": 1 }, "indices": 0, "targets": vec![target; 20_000] }],
            "weights": vec![0; 20_000]
        }]
    }));
    let read = strahl::models::read(ModelFormat::Gltf, &file, &|_| Err("none".into()), Default::default());
    assert_eq!(read.unwrap().placements[0].transforms.len(), 65_000);
}

#[test]
fn cameras_that_cannot_be_are_refused_where_they_stand() {
    let camera = |projection: Value, z: f64| {
        square(json!({
            "cameras": [projection],
            "nodes": [{ "mesh": 0 }, { "camera": 0, "translation": [0, 0, z] }], "scenes": [{ "nodes": [0, 1] }]
        }))
    };
    let orthographic = |ymag: f64| json!({ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": ymag, "zfar": 1, "znear": 0 } });
    for ymag in [0.0, 1e300] {
        let file = camera(orthographic(ymag), 3.0);
        assert_eq!(refused(Format::Gltf, &file, &through(0)).pointer, "/cameras/0/orthographic/ymag", "{ymag}");
        // Who does not look through it does not need it.
        imported(&file, ModelFormat::Gltf, &overrides("front"));
    }
    assert_eq!(refused(Format::Gltf, &camera(orthographic(1.0), 1e16), &through(0)).pointer, "/cameras/0");
    let perspective = |yfov: f64| json!({ "type": "perspective", "perspective": { "yfov": yfov, "znear": 0.1 } });
    for (yfov, told) in [(0.000_3, true), (4.0, true), (-1.0, true), (1.0, false)] {
        let warned = warned(ModelFormat::Gltf, &camera(perspective(yfov), 3.0), &through(0));
        assert_eq!(warned.iter().any(|it| it.contains("angle-of-view")), told, "{yfov}: {warned:?}");
    }
}

#[test]
fn lamps_out_of_reach_are_left_out() {
    let view = overrides("front");
    // A sun has no place.
    for (kind, is_left_out) in [("point", true), ("directional", false)] {
        let lamp = json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } }, "translation": [0, 0, 1e16] });
        let file = square(json!({
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": { "KHR_lights_punctual": { "lights": [{ "type": kind }] } },
            "nodes": [{ "mesh": 0 }, lamp], "scenes": [{ "nodes": [0, 1] }]
        }));
        let warned = warned(ModelFormat::Gltf, &file, &view);
        assert_eq!(warned.iter().any(|it| it.contains("far-lamps")), is_left_out, "{kind}");
        assert!(seen(&file, Format::Gltf, &view).middle() != [0; 3], "{kind}");
    }
}

/// What the scene of a model cannot be has a place in the file, too.
#[test]
fn each_refusal_has_a_place() {
    let view = overrides("front");
    let broken = json!({ "images": [{ "uri": "data:image/png;base64,iVBORw0KGgo=" }], "textures": [{ "source": 0 }] });
    let mut textured = matte([1.0; 3]);
    textured["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
    let picture = refused(Format::Gltf, &quads(&[(FRONT, textured)], broken), &view);
    assert_eq!(picture.pointer, "/images/0");
    // Of a square in the plane of x and y nothing is left without y.
    let flat = json!({ "nodes": [{ "mesh": 0, "matrix": [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }] });
    assert!(refused(Format::Gltf, &square(flat), &view).detail.contains("nothing to see"));
    let huge = json!({ "nodes": [{ "mesh": 0, "scale": [1e90, 1e90, 1e90] }] });
    assert!(refused(Format::Gltf, &square(huge), &view).detail.contains("units large"));
    refused(Format::Obj, b"v 0 0 0\nv 1 0 0\n", &view);
    refused(Format::Stl, b"solid nothing\nendsolid\n", &view);
    refused(Format::Ply, b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n", &view);
}

#[test]
fn other_formats_tell_what_they_leave_out() {
    let view = overrides("front");
    let vertices = "0 0 0\n1 0 0\n0 1 0\n";
    let ply = |vertex: &str, face: &str, numbers: &str| {
        format!("ply\nformat ascii 1.0\n{vertex}{face}end_header\n{vertices}{numbers}").into_bytes()
    };
    let xyz = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let faces = "element face 2\nproperty list uchar int vertex_indices\n";
    let few =
        warned(ModelFormat::Ply, &ply(&format!("comment TextureFile a.png\n{xyz}"), faces, "3 0 1 2\n2 0 1\n"), &view);
    assert!(
        few.iter().any(|it| it.contains("less than three corners")) && few.iter().any(|it| it.contains("TextureFile"))
    );
    for (vertex, face, place) in [
        (xyz.replace("float y", "float x"), faces.to_owned(), Some(3)),
        (xyz.replace("float y", "list uchar float y"), faces.to_owned(), Some(3)),
        (format!("{xyz}{xyz}"), faces.to_owned(), Some(7)),
        (xyz.to_owned(), faces.replace("vertex_indices", "vertex_idx"), Some(7)),
    ] {
        let problem = refused(Format::Ply, &ply(&vertex, &face, "3 0 1 2\n3 0 1 2\n"), &view);
        assert_eq!(problem.line, place, "{problem:?}");
    }
    let stl = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    imported(stl.as_bytes(), ModelFormat::Stl, &view);
    let cut = stl.split_once("endloop").unwrap().0.to_owned();
    let one_end = stl.replace("endloop\nendfacet\n", "");
    for (wrong, line) in
        [(stl.replace("endloop\n", ""), 7), (stl.replace("outer loop\n", ""), 3), (cut, 7), (one_end, 7)]
    {
        assert_eq!(refused(Format::Stl, wrong.as_bytes(), &view).line, Some(line), "{wrong}");
    }
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\ncall other.obj\n";
    assert!(warned(ModelFormat::Obj, obj.as_bytes(), &view).iter().any(|it| it.contains("call")));
}
