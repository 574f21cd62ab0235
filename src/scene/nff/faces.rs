//! Polygons and patches as triangles over shared vertices.

use super::tokens::Place;
use crate::scene::description::{Mesh, Vec3};
use crate::scene::problem::{Code, Problem};
use crate::shape::ear_clipping::{has_no_area, newell_normal, triangulate};
use glam::DVec3;
use hashbrown::hash_table::Entry;
use hashbrown::{DefaultHashBuilder, HashTable};
use std::hash::BuildHasher;

/// Cuts a polygon into triangles with the same front. May reverse the order of its vertices (and normals).
pub(super) fn triangles(place: Place, vertices: &mut [Vec3], normals: &mut [Vec3]) -> Result<Vec<[u32; 3]>, Problem> {
    if has_no_area(vertices) {
        return Err(place.problem(Code::Degenerate, no_area(vertices)));
    }
    if faces_backwards(vertices) {
        vertices.reverse();
        normals.reverse();
    }
    triangulate(vertices).ok_or_else(|| place.problem(Code::Degenerate, "edges of the polygon cross each other"))
}

fn no_area(vertices: &[Vec3]) -> String {
    let count = vertices.len();
    let twin = (0..count).find(|&i| vertices[i] == vertices[(i + 1) % count]);
    let reason = twin.map_or_else(
        || "its vertices lie on a line".to_owned(),
        |i| format!("its vertices {} and {} are the same", i + 1, (i + 1) % count + 1),
    );
    format!("the polygon has no area: {reason}")
}

/// NFF's normal is (v1 - v0) x (v2 - v1): the first corner has to be convex, and decides the front. Where it is concave, the
/// front is the side opposite to the order of the vertices. Where it is straight but for rounding (files have six digits),
/// the order decides.
fn faces_backwards(vertices: &[Vec3]) -> bool {
    const STRAIGHT: f64 = 1e-3;
    let [v0, v1, v2] = [0, 1, 2].map(|i: usize| DVec3::from_array(vertices[i]));
    let corner = (v1 - v0).normalize_or_zero().cross((v2 - v1).normalize_or_zero());
    corner.dot(newell_normal(vertices).normalize_or_zero()) < -STRAIGHT
}

/// Triangles with equal vertices merged: those with the same position and, if there are normals, the same normal.
#[derive(Debug, Default)]
pub(super) struct Faces {
    vertices: Vec<Vec3>,
    /// One for each vertex, or none at all.
    normals: Vec<Vec3>,
    faces: Vec<[u32; 3]>,
    /// Indices of the vertices, to be found by what is at them.
    known: HashTable<u32>,
    hasher: DefaultHashBuilder,
}

impl Faces {
    pub(super) fn len(&self) -> usize {
        self.faces.len()
    }

    /// Adds a polygon's triangles. `normals` is empty for flat faces.
    pub(super) fn add(&mut self, vertices: &[Vec3], normals: &[Vec3], triangles: &[[u32; 3]]) {
        let indices: Vec<u32> = (0..vertices.len()).map(|i| self.index(vertices[i], normals.get(i).copied())).collect();
        self.faces.extend(triangles.iter().map(|triangle| triangle.map(|i| indices[i as usize])));
    }

    fn index(&mut self, vertex: Vec3, normal: Option<Vec3>) -> u32 {
        let Self { vertices, normals, known, hasher, .. } = self;
        // -0 + 0 is 0: files have both
        let bits = |vector: Vec3| vector.map(|number| (number + 0.0).to_bits());
        let hash =
            |vertex: Vec3, normal: Option<Vec3>| hasher.hash_one([bits(vertex), bits(normal.unwrap_or_default())]);
        let at = |index: u32| (vertices[index as usize], normals.get(index as usize).copied());
        let of = |index: &u32| {
            let (vertex, normal) = at(*index);
            hash(vertex, normal)
        };
        match known.entry(hash(vertex, normal), |index| at(*index) == (vertex, normal), of) {
            Entry::Occupied(entry) => *entry.get(),
            Entry::Vacant(entry) => {
                let index = vertices.len() as u32;
                entry.insert(index);
                vertices.push(vertex);
                normals.extend(normal);
                index
            }
        }
    }

    pub(super) fn into_mesh(self, material: Option<String>) -> Mesh {
        let normals = (!self.normals.is_empty()).then_some(self.normals);
        let Self { vertices, mut faces, .. } = self;
        faces.shrink_to_fit();
        Mesh {
            vertices,
            faces: faces.into(),
            normals,
            uvs: None,
            uvs1: None,
            tangents: None,
            colors: None,
            material,
            name: None,
            hollow: false,
        }
    }

    pub(super) fn into_triangles(self) -> impl Iterator<Item = [Vec3; 3]> {
        self.faces.into_iter().map(move |face| face.map(|i| self.vertices[i as usize]))
    }
}
