//! Closed meshes for the cases.

use super::lab::Lab;
use glam::DVec3;
use serde_json::{Value, json};
use std::collections::HashMap;

/// A closed mesh of triangles.
#[derive(Clone)]
pub struct Mesh {
    pub vertices: Vec<DVec3>,
    pub faces: Vec<[usize; 3]>,
}

impl Mesh {
    /// An icosahedron, each face cut into 4 `levels` times, on the unit sphere.
    pub fn icosphere(levels: u32) -> Self {
        let g = f64::midpoint(1.0, 5f64.sqrt());
        let mut vertices = Vec::new();
        for (a, b) in [(1.0, g), (1.0, -g), (-1.0, g), (-1.0, -g)] {
            vertices.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
        }
        let near = |a: DVec3, b: DVec3| (a.distance(b) - 2.0).abs() < 1e-9;
        let mut faces = Vec::new();
        for i in 0..12 {
            for j in i + 1..12 {
                for k in j + 1..12 {
                    let [a, b, c] = [i, j, k].map(|x| vertices[x]);
                    if near(a, b) && near(b, c) && near(c, a) {
                        let outward = (b - a).cross(c - a).dot(a) > 0.0;
                        faces.push(if outward { [i, j, k] } else { [i, k, j] });
                    }
                }
            }
        }
        for _ in 0..levels {
            let mut halves = HashMap::new();
            let mut half = |a: usize, b: usize, vertices: &mut Vec<DVec3>| {
                *halves.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    vertices.push((vertices[a] + vertices[b]) / 2.0);
                    vertices.len() - 1
                })
            };
            let mut finer = Vec::new();
            for [a, b, c] in faces {
                let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(a, b)| half(a, b, &mut vertices));
                finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
            }
            faces = finer;
        }
        Self { vertices: vertices.into_iter().map(DVec3::normalize).collect(), faces }
    }

    /// Scaled, moved and rounded to the format.
    pub fn placed(&self, lab: &Lab, scale: f64, offset: DVec3) -> Self {
        let vertices = self.vertices.iter().map(|v| lab.round3(*v * scale + offset)).collect();
        Self { vertices, faces: self.faces.clone() }
    }

    /// As an object.
    pub fn json(&self, material: &str) -> Value {
        let vertices: Vec<[f64; 3]> = self.vertices.iter().map(|v| v.to_array()).collect();
        json!({ "mesh": { "vertices": vertices, "faces": self.faces, "material": material } })
    }

    /// The corners of each face.
    pub fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> {
        self.faces.iter().map(|face| face.map(|i| self.vertices[i]))
    }

    /// Middles of all edges, each twice.
    pub fn edges(&self, lab: &Lab) -> Vec<DVec3> {
        self.triangles().flat_map(|[a, b, c]| [a + b, b + c, c + a]).map(|sum| lab.round3(sum / 2.0)).collect()
    }
}

/// A cube of 12 triangles.
pub fn cube_mesh() -> Mesh {
    let vertices =
        (0..8).map(|i| DVec3::new([-1.0, 1.0][i & 1], [-1.0, 1.0][i >> 1 & 1], [-1.0, 1.0][i >> 2])).collect();
    let faces = [[0, 2, 1, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 6, 3, 7], [0, 4, 2, 6], [1, 3, 5, 7]];
    let faces = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *d], [*a, *d, *c]]).collect();
    Mesh { vertices, faces }
}
