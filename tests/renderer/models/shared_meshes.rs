//! A large mesh in many materials is one hierarchy, and the picture is the same.

use super::default_look::{imported, matte, overrides};
use data_encoding::BASE64;
use serde_json::{Value, json};
use strahl::film::Region;
use strahl::models::ModelFormat;
use strahl::render::{Control, Picture, render};
use strahl::scene::compile::Precise;
use strahl::scene::description::{Description, Object};
use strahl::scene::model::import;
use strahl::scene::{Format, NoFiles, Overrides, Scene, compile, load};

/// Columns and rows of squares of a sheet: 4,608 triangles.
const SIDE: u16 = 48;
/// Nodes with it: 106,000 triangles are saved.
const NODES: usize = 24;

/// A glTF with a bumpy sheet in each of some materials, each at a place of its own.
fn sheets(materials: &[Value]) -> Vec<u8> {
    let points = (0..=SIDE).flat_map(|y| (0..=SIDE).map(move |x| [x, y].map(|c| f32::from(c) / f32::from(SIDE))));
    let points: Vec<u8> =
        points.flat_map(|[x, y]| [x, y, 0.25 * x * y * (1.0 - x)]).flat_map(|c: f32| c.to_le_bytes()).collect();
    let square = |at: u16| {
        let a = at / SIDE * (SIDE + 1) + at % SIDE;
        [a, a + 1, a + SIDE + 2, a, a + SIDE + 2, a + SIDE + 1]
    };
    let indices: Vec<u8> = (0..SIDE * SIDE).flat_map(square).flat_map(u16::to_le_bytes).collect();
    let (corners, faces) = (u32::from(SIDE + 1).pow(2), u32::from(SIDE).pow(2));
    let (all, split) = ([&indices[..], &points].concat(), indices.len());
    let each = 0..materials.len();
    let mesh = |material: usize| json!({ "primitives": [{ "attributes": { "POSITION": 1 }, "indices": 0, "material": material }] });
    let node = |at: usize| json!({ "mesh": at, "translation": [at % 6, at / 6, 0.25 * (at % 3) as f64] });
    let document = json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": all.len(), "uri": format!("data:application/octet-stream;base64,{}", BASE64.encode(&all)) }],
        "bufferViews": [
            { "buffer": 0, "byteLength": split }, { "buffer": 0, "byteOffset": split, "byteLength": points.len() }
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5123, "count": 6 * faces, "type": "SCALAR" },
            { "bufferView": 1, "componentType": 5126, "count": corners, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0.0625] }
        ],
        "meshes": each.clone().map(mesh).collect::<Vec<_>>(), "nodes": each.clone().map(node).collect::<Vec<_>>(),
        "scenes": [{ "nodes": each.collect::<Vec<_>>() }], "scene": 0, "materials": materials
    });
    document.to_string().into_bytes()
}

fn colored() -> Vec<Value> {
    (0..NODES).map(|at| matte([0.1 + 0.03 * at as f64, 0.9 - 0.03 * at as f64, 0.5])).collect()
}

/// How many hierarchies its geometries have.
fn hierarchies(scene: &Scene) -> usize {
    let Precise::Single(world) = &scene.world else { panic!("models are in single precision") };
    let all = &world.geometries;
    (0..all.len()).filter(|at| !all[..*at].iter().any(|before| all[*at].has_hierarchy_of(before))).count()
}

fn described(bytes: &[u8]) -> Description {
    imported(bytes, ModelFormat::Gltf, &overrides("three_quarter")).description
}

fn picture(scene: &Scene) -> Picture {
    render(scene, Region::whole(scene.width, scene.height), &Control::default()).unwrap()
}

#[test]
fn a_large_mesh_in_many_materials_is_one_hierarchy() {
    let description = described(&sheets(&colored()));
    let instances = description.objects.iter().filter(|object| matches!(object, Object::Instance(_)));
    assert_eq!((instances.count(), description.definitions.len()), (NODES, NODES));
    let shared = compile::compile(&description).unwrap();
    // Its own, and that of the scene.
    assert_eq!(hierarchies(&shared), 2);
    // Written as JSON, each is a mesh of its own.
    let json = serde_json::to_vec(&description).unwrap();
    let apart = load(&json, Format::Json, &Overrides::default()).unwrap().scene;
    assert_eq!(hierarchies(&apart), NODES + 1);
    assert!(4 * shared.bytes() < apart.bytes(), "{} and {} bytes", shared.bytes(), apart.bytes());
    let [shared, apart] = [&shared, &apart].map(picture);
    assert_eq!((shared.film, shared.rays), (apart.film, apart.rays));
}

/// Hierarchies know from which side their triangles can be hit.
#[test]
fn meshes_with_one_side_share_a_hierarchy_among_themselves() {
    let mut materials = colored();
    materials.iter_mut().skip(NODES / 2).for_each(|material| material["doubleSided"] = json!(false));
    let scene = compile::compile(&described(&sheets(&materials))).unwrap();
    assert_eq!(hierarchies(&scene), 3);
}

#[test]
fn small_meshes_and_few_of_them_are_triangles_of_the_scene() {
    let description = described(&sheets(&colored()[..4]));
    assert!(!description.objects.iter().any(|object| matches!(object, Object::Instance(_))));
}

/// Of a file of 1 MB they would be 23 million triangles, each of them checked before any is refused.
#[test]
fn a_mesh_in_too_many_materials_is_refused_before_it_is_copied() {
    let bytes = sheets(&vec![matte([0.5; 3]); 5_000]);
    let refused = import(ModelFormat::Gltf, &bytes, &Overrides::default(), &NoFiles).unwrap_err();
    let [problem] = refused.0.as_slice() else { panic!("{refused}") };
    assert_eq!(problem.detail, "23040000 triangles are over the limit of 20000000 (triangles)");
}
