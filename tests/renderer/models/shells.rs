//! Glass in several closed surfaces looks the same as one mesh and as several.

use super::default_look::{overrides, seen};
use data_encoding::BASE64;
use serde_json::{Value, json};
use strahl::scene::{Format, Overrides, load};

/// A box by its lowest and its highest corner.
type Cuboid = [[f32; 3]; 2];

/// A slab; other boxes stand on it, in it, beside it.
const SLAB: Cuboid = [[-1.0, 0.0, -0.35], [1.0, 0.5, 0.35]];

fn triangles([low, high]: Cuboid) -> Vec<[[f32; 3]; 3]> {
    let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] });
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).map(|it| it.map(corner)).collect()
}

/// A glTF of glass with a mesh of each of these.
fn glass(meshes: &[Vec<Cuboid>]) -> Vec<u8> {
    let (mut data, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    for boxes in meshes {
        let points: Vec<[f32; 3]> = boxes.iter().flat_map(|it| triangles(*it)).flatten().collect();
        let edge = |pick: fn(f32, f32) -> f32| [0, 1, 2].map(|c| points.iter().map(|p| p[c]).reduce(pick).unwrap());
        views.push(json!({ "buffer": 0, "byteOffset": data.len(), "byteLength": 12 * points.len() }));
        accessors.push(json!({
            "bufferView": accessors.len(), "componentType": 5126, "count": points.len(), "type": "VEC3",
            "min": edge(f32::min), "max": edge(f32::max)
        }));
        data.extend(points.iter().flatten().flat_map(|x| x.to_le_bytes()));
    }
    let each = |of: fn(usize) -> Value| (0..meshes.len()).map(of).collect::<Vec<_>>();
    json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": data.len(), "uri": format!("data:application/octet-stream;base64,{}", BASE64.encode(&data)) }],
        "bufferViews": views, "accessors": accessors,
        "meshes": each(|i| json!({ "primitives": [{ "attributes": { "POSITION": i }, "material": 0 }] })),
        "nodes": each(|i| json!({ "mesh": i })), "scenes": [{ "nodes": each(|i| json!(i)) }], "scene": 0,
        "materials": [{
            "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0 },
            "extensions": {
                "KHR_materials_transmission": { "transmissionFactor": 1 },
                "KHR_materials_volume": { "thicknessFactor": 1 }
            }
        }]
    })
    .to_string()
    .into_bytes()
}

fn bodies(model: &[u8]) -> usize {
    load(model, Format::Gltf, &Overrides::default()).unwrap().description.objects.len()
}

/// A column on the slab or in it. As one body, light that left one of both left both: columns that stand a little in it were black.
#[test]
fn shells_of_a_mesh_are_as_meshes_of_their_own() {
    let view = overrides("20,60");
    for bottom in [0.5, 0.4999, 0.49, 0.2] {
        let column = [[-0.25, bottom, -0.25], [0.25, 1.5, 0.25]];
        let (one, two) = (glass(&[vec![SLAB, column]]), glass(&[vec![SLAB], vec![column]]));
        assert_eq!(bodies(&one), bodies(&two));
        let [one, two] = [one, two].map(|model| seen(&model, Format::Gltf, &view));
        assert!(one.codes == two.codes, "from {bottom}");
    }
}

#[test]
fn shells_that_are_apart_are_one_body() {
    let column = [[-0.25, 0.6, -0.25], [0.25, 1.5, 0.25]];
    let [one, two] = [glass(&[vec![SLAB, column]]), glass(&[vec![SLAB], vec![column]])];
    assert_eq!(bodies(&one) + 1, bodies(&two));
    let view = overrides("20,60");
    assert!(seen(&one, Format::Gltf, &view).codes == seen(&two, Format::Gltf, &view).codes);
}
