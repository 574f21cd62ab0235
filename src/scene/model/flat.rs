//! What a scale of 0 along an axis flattens. An instance has an inverse, so what stands flat in one of several places is a mesh of its own.

use crate::models::{Model, Placement, Subject, Warning};
use glam::{DMat3, DMat4};

/// Triangles of such meshes. More are left out, since each is a copy.
const TRIANGLES: usize = 1 << 20;

/// Gives what stands flat a placement of its own.
pub(super) fn set_apart(model: &mut Model) {
    let (mut flat, mut left) = (Vec::new(), TRIANGLES);
    let mut left_out = 0_u64;
    for placement in model.placements.iter_mut().filter(|placement| placement.transforms.len() > 1) {
        let count = model.geometries[placement.geometry].triangles.len();
        for matrix in placement.transforms.extract_if(.., |matrix| is_flat(matrix)) {
            match left.checked_sub(count) {
                Some(rest) => {
                    left = rest;
                    let (geometry, material, name) = (placement.geometry, placement.material, placement.name.clone());
                    flat.push(Placement { geometry, material, name, transforms: vec![matrix] });
                }
                None => left_out += 1,
            }
        }
    }
    model.placements.retain(|placement| !placement.transforms.is_empty());
    model.placements.append(&mut flat);
    if left_out > 0 {
        let detail =
            format!("{left_out} instances that a scale of 0 flattens are left out: together they are too large");
        model.warnings.push(Warning { subject: Subject::Skipped, what: "flat", detail, pointer: String::new() });
    }
}

/// Whether scenes take the matrix as one without an inverse: its volume beside the lengths of its columns says so, at any scale.
pub(super) fn is_flat(matrix: &DMat4) -> bool {
    let columns = DMat3::from_mat4(*matrix).to_cols_array();
    let largest = columns.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let m = DMat3::from_cols_array(&columns.map(|x| x / largest));
    m.determinant().abs() <= 1e-11 * (m.x_axis.length() * m.y_axis.length() * m.z_axis.length())
}
