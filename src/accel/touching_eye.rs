//! Whether an eye is exactly on a body. A ray from there has t = 0 at the surface, which is no hit, but rounding may make more of it.

use super::item::{Mesh, Shape};
use super::owner::Owner;
use crate::lanes::Real;
use crate::shape::Frustum;
use glam::DVec3;

/// Roundings of double precision in the height of a point above a triangle.
const ROUNDINGS: f64 = 32.0 * f64::EPSILON;

impl<R: Real> Owner<'_, R> {
    /// Whether a point of the scene is on the triangle `expanded` of this body, or on the frustum that it is. Other shapes are met at
    /// t = 0 exactly, and bodies that move are nowhere exactly.
    pub fn touches(&self, expanded: u64, point: DVec3) -> bool {
        let Some(local) = self.point_into_object(point) else { return false };
        match &self.item.shape {
            Shape::Mesh(mesh) => is_on_triangle(mesh, (expanded - self.body) as usize, local),
            Shape::Frustum(frustum) => is_on_frustum(frustum, local),
            _ => false,
        }
    }
}

/// |n (p - a)| is at most some roundings of its terms. The differences of numbers of this precision are exact, or nearly so.
fn is_on_triangle<R: Real>(mesh: &Mesh<R>, face: usize, p: DVec3) -> bool {
    let [a, b, c] = mesh.points(face);
    let (normal, from) = ((b - a).cross(c - a), p - a);
    normal.dot(from).abs() <= ROUNDINGS * normal.abs().dot(from.abs())
}

/// On its side or on the plane of an end, within roundings of its axis, which is of this precision.
fn is_on_frustum<R: Real>(frustum: &Frustum<R>, p: DVec3) -> bool {
    let [across, z] = frustum.frame.cylindrical(p);
    let [height, radius, slope] = [frustum.height, frustum.base_radius, frustum.slope].map(Real::to_f64);
    let side = radius + slope * z;
    let slack = 8.0 * R::ROUNDOFF * (across + z.abs() + radius + height);
    [across - side, z, z - height].iter().any(|off| off.abs() <= slack)
}
