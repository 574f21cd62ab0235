//! Triangles: alone, in quads and in meshes, tested one after the other.

use super::ray::{Ball, Crossing, Ray};
use super::shape::Shape;
use crate::math;
use glam::DVec3;
use std::f64::consts::PI;

/// Triangles over shared vertices, their fronts counter-clockwise.
#[derive(Debug)]
pub(super) struct Mesh {
    vertices: Vec<DVec3>,
    faces: Vec<[usize; 3]>,
    normals: Option<Vec<DVec3>>,
    ball: Ball,
    /// None if it encloses nothing.
    volume: Option<f64>,
}

impl Mesh {
    /// By the divergence theorem: a third of the sum over the faces of a corner times the area vector.
    fn enclosed(&self) -> f64 {
        let middle = self.vertices.iter().sum::<DVec3>() / self.vertices.len() as f64;
        let third = |[a, b, c]: [usize; 3]| {
            let [a, b, c] = [a, b, c].map(|i| self.vertices[i] - middle);
            a.dot((b - a).cross(c - a)) / 6.0
        };
        self.faces.iter().copied().map(third).sum::<f64>().abs()
    }

    pub(super) fn open(vertices: Vec<DVec3>, faces: Vec<[usize; 3]>) -> Self {
        let ball = Ball::around_points(&vertices);
        Self { vertices, faces, normals: None, ball, volume: None }
    }

    pub(super) fn closed(vertices: Vec<DVec3>, faces: Vec<[usize; 3]>, normals: Option<Vec<DVec3>>) -> Self {
        let mesh = Self { normals, ..Self::open(vertices, faces) };
        Self { volume: Some(mesh.enclosed()), ..mesh }
    }

    /// The line passes inside if the volumes it spans with the edges (Pluecker) have one sign.
    ///
    /// The tolerance is the rounding error of a volume, so no line slips between neighbours or through a vertex; one through
    /// an edge may cross both neighbours at the same t.
    fn face_crossing(&self, face: [usize; 3], middle: f64, line: &Ray) -> Option<Crossing> {
        let [a, b, c] = face.map(|i| self.vertices[i] - self.ball.center);
        let normal = (b - a).cross(c - a);
        let longest_edge = (b - a).length().max((c - b).length()).max((a - c).length());
        let (a, b, c) = (a - line.origin, b - line.origin, c - line.origin);
        let farthest = a.length().max(b.length()).max(c.length());
        let rounding = 8.0 * f64::EPSILON * line.dir.length() * farthest * longest_edge;
        let volume = |p: DVec3, q: DVec3| line.dir.dot(p.cross(q - p));
        let (u, v, w) = (volume(b, c), volume(c, a), volume(a, b));
        let sum = u + v + w;
        // A triangle seen edge-on shows only its edges, which belong to its neighbours too.
        if (u.min(v).min(w) < -rounding && u.max(v).max(w) > rounding) || sum.abs() <= 1e3 * rounding {
            return None;
        }
        let s = normal.dot(a) / normal.dot(line.dir);
        let point = self.ball.center + line.at(s);
        let mut crossing = Crossing::flat(middle + s, point, normal);
        if let Some(normals) = &self.normals {
            let normals = face.map(|i| normals[i].normalize());
            let ns = (normals[0] * u + normals[1] * v + normals[2] * w) / sum;
            let outward = ns.dot(normal);
            if outward != 0.0 {
                crossing.shading = Some(ns);
                let turn = outward.signum() * -normal.dot(line.dir).signum();
                crossing.lift = self.lift(face, normals.map(|n| n * turn), [u, v, w].map(|x| x / sum), point);
            }
        }
        Some(crossing)
    }

    /// From a point of a facet to where the tangent planes at its corners, mixed, would have it; never inwards (Hanika,
    /// Hacking the Shadow Terminator, Ray Tracing Gems II, ch. 4).
    fn lift(&self, face: [usize; 3], normals: [DVec3; 3], weights: [f64; 3], point: DVec3) -> DVec3 {
        let corner = |k: usize| self.vertices[face[k]];
        (0..3).map(|k| normals[k] * (weights[k] * normals[k].dot(corner(k) - point).max(0.0))).sum()
    }
}

impl Shape for Mesh {
    fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let (middle, line) = ray.around(self.ball.center);
        self.faces.iter().filter_map(|&face| self.face_crossing(face, middle, &line)).collect()
    }

    /// Whether the faces surround the point: the solid angles they subtend there (Van Oosterom and Strackee 1983) add
    /// up to a full sphere, seen from their backs.
    fn contains(&self, point: DVec3) -> bool {
        let solid_angle = |&face: &[usize; 3]| {
            let [a, b, c] = face.map(|i| self.vertices[i] - point);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let volume = a.dot(b.cross(c));
            let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            let size = math::hypot(volume, denominator);
            if size == 0.0 { 0.0 } else { 2.0 * math::acos((denominator / size).clamp(-1.0, 1.0)).copysign(volume) }
        };
        self.faces.iter().map(solid_angle).sum::<f64>() > 2.0 * PI
    }

    fn ball(&self) -> Option<Ball> {
        Some(self.ball)
    }

    fn volume(&self) -> Option<f64> {
        self.volume
    }
}
