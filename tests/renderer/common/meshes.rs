//! Closed meshes for the tests of robustness.

use glam::DVec3;
use std::collections::{HashMap, HashSet};

/// A closed triangle mesh, faces counter-clockwise from outside.
#[derive(Clone)]
pub struct Closed {
    pub vertices: Vec<DVec3>,
    pub faces: Vec<[usize; 3]>,
}

impl Closed {
    /// A sphere of radius 1 around 0: an icosahedron whose faces are cut in four `levels` times.
    pub fn icosphere(levels: u32) -> Self {
        let g = (1.0 + 5f64.sqrt()) / 2.0;
        let mut vertices = Vec::new();
        for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
            vertices.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
        }
        let vertices: Vec<DVec3> = vertices.into_iter().map(DVec3::normalize).collect();
        // Faces are the triples of neighbours, turned outwards.
        let near = |a: usize, b: usize| a != b && vertices[a].distance(vertices[b]) < 1.1;
        let mut faces = Vec::new();
        for a in 0..12 {
            for b in a + 1..12 {
                for c in b + 1..12 {
                    if near(a, b) && near(b, c) && near(c, a) {
                        let [p, q, r] = [a, b, c].map(|i| vertices[i]);
                        faces.push(if (q - p).cross(r - p).dot(p) > 0.0 { [a, b, c] } else { [a, c, b] });
                    }
                }
            }
        }
        let mut mesh = Self { vertices, faces };
        for _ in 0..levels {
            mesh = mesh.subdivided();
        }
        mesh
    }

    fn subdivided(mut self) -> Self {
        let mut middles = HashMap::new();
        let mut faces = Vec::new();
        for [a, b, c] in self.faces {
            let mut middle = |i: usize, j: usize| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    self.vertices.push((self.vertices[i] + self.vertices[j]).normalize());
                    self.vertices.len() - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            faces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        Self { vertices: self.vertices, faces }
    }

    /// The cube [-1, 1]^3, two triangles for each side.
    pub fn cube() -> Self {
        let side = |bits: usize, bit: usize| if bits & bit == 0 { -1.0 } else { 1.0 };
        let vertices = (0..8).map(|i| DVec3::new(side(i, 1), side(i, 2), side(i, 4))).collect();
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        Self { vertices, faces: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect() }
    }

    /// The trefoil knot among the scenes.
    pub fn knot() -> Self {
        let scene: serde_json::Value = serde_json::from_slice(&super::read("scenes/meshes/knot.json")).unwrap();
        let objects = scene["objects"].as_array().unwrap();
        let mesh = objects.iter().find_map(|object| object.get("mesh")).unwrap();
        let list = |key: &str| mesh[key].as_array().unwrap().iter();
        let vertices = list("vertices").map(|v| DVec3::from_array(std::array::from_fn(|i| v[i].as_f64().unwrap())));
        let faces = list("faces").map(|f| [0, 1, 2].map(|i| f[i].as_u64().unwrap() as usize));
        Self { vertices: vertices.collect(), faces: faces.collect() }
    }

    /// The mesh, scaled and then moved.
    pub fn placed(&self, scale: f64, translation: DVec3) -> Self {
        let vertices = self.vertices.iter().map(|v| *v * scale + translation).collect();
        Self { vertices, faces: self.faces.clone() }
    }

    /// The edges, once each.
    pub fn edges(&self) -> Vec<[usize; 2]> {
        let both = self.faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let edges: HashSet<[usize; 2]> = both.map(|[a, b]| [a.min(b), a.max(b)]).collect();
        let mut edges: Vec<_> = edges.into_iter().collect();
        edges.sort_unstable();
        edges
    }

    /// The object of a scene.
    pub fn json(&self, material: &str) -> serde_json::Value {
        let vertices: Vec<[f64; 3]> = self.vertices.iter().map(|v| v.to_array()).collect();
        serde_json::json!({ "mesh": { "vertices": vertices, "faces": self.faces, "material": material } })
    }
}
