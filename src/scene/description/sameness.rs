//! Whether lists of objects are the same. Meshes may have millions of vertices, so it is asked on the way whether anybody still waits.

use super::object::{Mesh, Object};
use crate::control;
use crate::scene::named::Named;

/// Elements of a list that are compared in some microseconds.
const CHUNK: usize = 256;

/// Whether objects are the same, in the same order. Once the work is cancelled they are not.
pub(super) fn are_same(a: &[Object], b: &[Object]) -> bool {
    let same = |(a, b): (&Object, &Object)| match (a, b) {
        _ if control::step(1) => false,
        (Object::Mesh(a), Object::Mesh(b)) => is_same_mesh(a, b),
        (Object::Group(a), Object::Group(b)) => {
            are_same(&a.objects, &b.objects) && (a.transform, a.motion, &a.name) == (b.transform, b.motion, &b.name)
        }
        (a, b) => a == b,
    };
    a.len() == b.len() && a.iter().zip(b).all(same)
}

/// The same of definitions, in any order.
pub(super) fn are_same_definitions(a: &Named<Vec<Object>>, b: &Named<Vec<Object>>) -> bool {
    a.len() == b.len() && a.iter().all(|(name, a)| b.get(name).is_some_and(|b| are_same(a, b)))
}

fn is_same_mesh(a: &Mesh, b: &Mesh) -> bool {
    let Mesh { vertices, faces, normals, uvs, uvs1, tangents, colors, material, name, hollow } = a;
    (material, name, hollow) == (&b.material, &b.name, &b.hollow)
        && is_same_list(faces, &b.faces)
        && is_same_list(vertices, &b.vertices)
        && is_same_option(normals, &b.normals)
        && is_same_option(uvs, &b.uvs)
        && is_same_option(uvs1, &b.uvs1)
        && is_same_option(tangents, &b.tangents)
        && is_same_option(colors, &b.colors)
}

fn is_same_option<T: PartialEq>(a: &Option<Vec<T>>, b: &Option<Vec<T>>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => is_same_list(a, b),
        (None, None) => true,
        _ => false,
    }
}

fn is_same_list<T: PartialEq>(a: &[T], b: &[T]) -> bool {
    a.len() == b.len() && a.chunks(CHUNK).zip(b.chunks(CHUNK)).all(|(a, b)| !control::step(1) && a == b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Control;
    use serde_json::{Value, json};

    fn list(objects: Value) -> Vec<Object> {
        serde_json::from_value(objects).unwrap()
    }

    #[test]
    fn every_key_of_a_mesh_counts() {
        let mesh = json!({
            "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]], "normals": [[0, 0, 1], [0, 0, 1], [0, 0, 1]],
            "uvs": [[0, 0], [1, 0], [0, 1]], "uvs1": [[0, 0], [1, 0], [0, 1]], "colors": [[1, 1, 1, 1], [1, 1, 1, 1], [1, 1, 1, 1]],
            "tangents": [[1, 0, 0, 1], [1, 0, 0, 1], [1, 0, 0, 1]], "material": "a", "name": "b", "hollow": true
        });
        let group =
            |mesh: &Value, name: &str| list(json!([{ "group": { "objects": [{ "mesh": mesh }], "name": name } }]));
        let (whole, sphere) = (group(&mesh, "c"), list(json!([{ "sphere": { "center": [0, 0, 0], "radius": 1 } }])));
        assert!(are_same(&whole, &group(&mesh, "c")) && are_same(&sphere, &sphere));
        assert!(!are_same(&whole, &group(&mesh, "d")) && !are_same(&whole, &sphere) && !are_same(&whole, &[]));
        for key in mesh.as_object().unwrap().keys() {
            let mut other = mesh.clone();
            other[key] = match &mesh[key] {
                Value::Array(list) => list.iter().rev().cloned().collect(),
                Value::String(name) => format!("{name}2").into(),
                _ => false.into(),
            };
            // Equal elements are the same backwards.
            if key == "faces" {
                other[key] = json!([[2, 1, 0]]);
            } else if matches!(key.as_str(), "normals" | "colors" | "tangents") {
                other[key][1][0] = json!(0.5);
            }
            assert!(!are_same(&whole, &group(&other, "c")), "{key}");
        }
    }

    #[test]
    fn the_comparison_of_a_large_mesh_can_be_cancelled() {
        let mut objects = list(json!([{ "mesh": { "vertices": [[0, 0, 0]], "faces": [[0, 0, 0]] } }]));
        let Object::Mesh(mesh) = &mut objects[0] else { panic!("a mesh") };
        mesh.vertices = vec![[0.0; 3]; 1 << 20];
        let same = objects.clone();
        assert!(are_same(&objects, &same));
        let control = Control::default();
        control.cancel();
        let _entered = control.enter();
        assert!(!are_same(&objects, &same));
    }
}
