//! The meshes of a model where they are placed: how far they reach, and whether anything of them is seen.

use crate::control;
use crate::scene::description::{Material, Mesh, Object};
use crate::scene::named::Named;
use glam::{DMat4, DVec3};
use std::collections::HashMap;

/// Sine of the angle below which a triangle is seen from its edge, or is a line.
const FLAT: f64 = 1e-9;
/// Vertices, as they are placed, that are looked at one by one; of more the boxes around them are.
const VERTICES: u64 = 50_000_000;

/// The meshes of a model, and where they are.
pub(super) struct Placed<'a>(Vec<PlacedMesh<'a>>);

/// A mesh with the matrices that place it.
struct PlacedMesh<'a> {
    points: &'a [[f64; 3]],
    faces: &'a [[u32; 3]],
    /// Whether it is seen from its front alone.
    one_sided: bool,
    matrices: Vec<DMat4>,
}

/// What of a model is seen from a point, whatever is in front of it.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Sight {
    /// Some triangles, or there are too many to know.
    Something,
    /// None: all are lines, or the model is flat and seen from its edge.
    Edges,
    /// None: all that have an area turn their backs, which are not seen.
    Backs,
}

impl<'a> Placed<'a> {
    /// Those of the objects of a model: meshes, and instances of meshes.
    pub(super) fn of(objects: &'a [Object], definitions: &'a Named<Vec<Object>>, materials: &Named<Material>) -> Self {
        let placed_at = |mesh: &'a Mesh, matrices: Vec<DMat4>| {
            let material = mesh.material.as_ref().and_then(|name| materials.get(name));
            let one_sided = material.is_some_and(|material| material.one_sided);
            PlacedMesh { points: &mesh.vertices, faces: &mesh.faces, one_sided, matrices }
        };
        let (mut placed, mut places) = (Vec::new(), HashMap::new());
        for object in objects {
            match object {
                Object::Mesh(mesh) => placed.push(placed_at(mesh, vec![DMat4::IDENTITY])),
                Object::Instance(instance) => {
                    let matrix = instance.transform.matrix.map_or(DMat4::IDENTITY, |it| DMat4::from_cols_array(&it));
                    places.entry(instance.of.as_str()).or_insert_with(Vec::new).push(matrix);
                }
                _ => {}
            }
        }
        for (name, objects) in definitions {
            let Some(matrices) = places.remove(name.as_str()) else { continue };
            for object in objects {
                if let Object::Mesh(mesh) = object {
                    placed.push(placed_at(mesh, matrices.clone()));
                }
            }
        }
        Self(placed)
    }

    /// Points where they are.
    #[cfg(test)]
    pub(super) fn points(points: &'a [[f64; 3]]) -> Self {
        Self(vec![PlacedMesh { points, faces: &[], one_sided: false, matrices: vec![DMat4::IDENTITY] }])
    }

    /// The corners of the box around all of it, if there is any.
    pub(super) fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for PlacedMesh { points, matrices, .. } in &self.0 {
            // Of what stands in few places each vertex counts, of what stands in many the box around it.
            let boxed = (matrices.len() > 16).then(|| corners(points));
            let points = boxed.as_deref().unwrap_or(points);
            for matrix in matrices {
                for point in points {
                    let placed = matrix.transform_point3(DVec3::from_array(*point));
                    (low, high) = (low.min(placed), high.max(placed));
                }
            }
        }
        let extent = (high - low).max_element();
        (extent.is_finite() && extent > 0.0).then_some((low, high))
    }

    /// What is seen of it from a point.
    pub(super) fn sight_from(&self, eye: DVec3) -> Sight {
        let (mut left, mut has_backs) = (VERTICES, false);
        for PlacedMesh { points, faces, one_sided, matrices } in &self.0 {
            for matrix in matrices {
                // It would only be a warning.
                let Some(rest) = left.checked_sub(faces.len() as u64) else { return Sight::Something };
                left = rest;
                if control::step(faces.len() as u32 / 64 + 1) {
                    return Sight::Something;
                }
                // The fronts of a mirrored mesh stay outside.
                let outside = if matrix.determinant() < 0.0 { -1.0 } else { 1.0 };
                for face in *faces {
                    let [a, b, c] = face.map(|i| matrix.transform_point3(DVec3::from_array(points[i as usize])) - eye);
                    let (normal, edges) = ((b - a).cross(c - a), (b - a).length() * (c - a).length());
                    let away = a.dot(normal) * outside;
                    if normal.length() <= FLAT * edges || away.abs() <= FLAT * a.length() * normal.length() {
                        continue;
                    }
                    if !one_sided || away < 0.0 {
                        return Sight::Something;
                    }
                    has_backs = true;
                }
            }
        }
        if has_backs { Sight::Backs } else { Sight::Edges }
    }
}

/// The largest values of some linear functions over all vertices, as seen from an origin: what is far from that of the
/// coordinates is as large as what is near.
pub(super) struct Extremes<const N: usize> {
    origin: DVec3,
    directions: [DVec3; N],
    pub(super) most: [f64; N],
}

impl<const N: usize> Extremes<N> {
    /// `times`: how often that is asked.
    pub(super) fn of(Placed(placed): &Placed<'_>, origin: DVec3, directions: [DVec3; N], times: u64) -> Self {
        let mut extremes = Self { origin, directions, most: [f64::NEG_INFINITY; N] };
        let vertices: u64 =
            placed.iter().map(|mesh| mesh.points.len() as u64 * mesh.matrices.len() as u64 * times).sum();
        for PlacedMesh { points, matrices, .. } in placed {
            let boxed = (vertices > VERTICES).then(|| corners(points));
            let points = boxed.as_deref().unwrap_or(points);
            for matrix in matrices {
                extremes.add(points, matrix);
            }
        }
        extremes
    }

    fn add(&mut self, points: &[[f64; 3]], matrix: &DMat4) {
        // A plane in the model is one in the geometry.
        let inside = self.directions.map(|direction| matrix.transpose().transform_vector3(direction));
        let mut farthest = [f64::NEG_INFINITY; N];
        for point in points {
            let point = DVec3::from_array(*point);
            for (farthest, inside) in farthest.iter_mut().zip(&inside) {
                *farthest = farthest.max(inside.dot(point));
            }
        }
        for ((direction, farthest), most) in self.directions.iter().zip(farthest).zip(&mut self.most) {
            let shift = direction.dot(matrix.w_axis.truncate() - self.origin);
            *most = most.max(farthest + shift);
        }
    }
}

/// The box around points.
pub(super) fn box_of(points: &[[f64; 3]]) -> (DVec3, DVec3) {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    points.iter().map(|point| DVec3::from_array(*point)).fold(none, |(low, high), p| (low.min(p), high.max(p)))
}

/// Its corners.
fn corners(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let (low, high) = box_of(points);
    (0..8_usize).map(|i| [0, 1, 2].map(|c| if i >> c & 1 == 0 { low[c] } else { high[c] })).collect()
}
