//! Normals for triangles that have none: smooth over faces that meet at a small angle, and apart at creases, as modelling programs
//! shade them.

use super::budget::worked;
use super::fault::Fault;
use super::geometry::Geometry;
use crate::math;
use glam::DVec3;
use hashbrown::HashMap;

/// Cosine of the largest angle between faces that are one smooth surface: 40 degrees. The sides of an octagon keep their edges.
const SMOOTH: f64 = 0.766_044_443_118_978;
/// Cosine of the angle between normals from which on a corner is not flat.
const FLAT: f64 = 1.0 - 1e-9;
/// Most faces around a point of which each is held against all others; more stay flat.
const FACES: usize = 64;

impl Geometry {
    /// Gives each corner of a face the mean of the normals around it that are no crease away, weighted by the angles of faces at the
    /// corner, which no cut of a polygon into triangles changes. Points at creases become several. Without any smooth corner nothing
    /// changes, and the answer is false.
    pub(super) fn smooth(&mut self) -> Result<bool, Fault> {
        let unit: Vec<DVec3> = self.triangles.iter().map(|triangle| self.facing(*triangle)).collect();
        // Points that differ in texture coordinates alone are one point of the surface.
        let mut around: HashMap<[u64; 3], Vec<(u32, f64)>> = HashMap::new();
        for (face, triangle) in (0..).zip(&self.triangles) {
            let [a, b, c] = *triangle;
            for [corner, next, last] in [[a, b, c], [b, c, a], [c, a, b]] {
                around.entry(self.key(corner)).or_default().push((face, self.angle(corner, next, last)));
            }
        }
        let mut points: HashMap<(u32, [u64; 3]), u32> = HashMap::new();
        let (mut sources, mut normals) = (Vec::new(), Vec::new());
        let (mut triangles, mut any) = (self.triangles.clone(), false);
        for (face, triangle) in triangles.iter_mut().enumerate() {
            if face % 4_096 == 0 {
                worked(4_096 * 64)?;
            }
            for corner in triangle {
                let faces = &around[&self.key(*corner)];
                let meets = |(other, _): &&(u32, f64)| unit[*other as usize].dot(unit[face]) >= SMOOTH;
                let sum: DVec3 = match faces.len() {
                    0..=FACES => faces.iter().filter(meets).map(|(other, angle)| unit[*other as usize] * *angle).sum(),
                    _ => unit[face],
                };
                let normal = sum.try_normalize().unwrap_or(unit[face]);
                any |= unit[face] != DVec3::ZERO && normal.dot(unit[face]) < FLAT;
                let normal = if normal == DVec3::ZERO { DVec3::Y } else { normal }.to_array();
                let point = points.entry((*corner, normal.map(f64::to_bits))).or_insert_with(|| {
                    sources.push(*corner as usize);
                    normals.push(normal);
                    sources.len() as u32 - 1
                });
                *corner = *point;
            }
        }
        if !any {
            return Ok(false);
        }
        self.triangles = triangles;
        self.positions = sources.iter().map(|i| self.positions[*i]).collect();
        for uvs in self.uvs.iter_mut().flatten() {
            *uvs = sources.iter().map(|i| uvs[*i]).collect();
        }
        if let Some(colors) = &mut self.colors {
            *colors = sources.iter().map(|i| colors[*i]).collect();
        }
        self.normals = Some(normals);
        Ok(true)
    }

    /// The unit normal of a triangle, 0 if it has no area.
    fn facing(&self, triangle: [u32; 3]) -> DVec3 {
        let [a, b, c] = triangle.map(|i| DVec3::from_array(self.positions[i as usize]));
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// The angle of a triangle at its first corner.
    fn angle(&self, corner: u32, next: u32, last: u32) -> f64 {
        let [a, b, c] = [corner, next, last].map(|i| DVec3::from_array(self.positions[i as usize]));
        math::atan2((b - a).cross(c - a).length(), (b - a).dot(c - a))
    }

    /// Equal for equal points; -0 is 0.
    fn key(&self, point: u32) -> [u64; 3] {
        self.positions[point as usize].map(|x| (x + 0.0).to_bits())
    }
}
