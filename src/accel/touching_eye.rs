//! Whether an eye is exactly on the surface that its ray hits. Such a ray has t = 0 there, which is no hit, but rounding may make more of
//! it. What is placed or tilted is exactly there only as far as the precision of the scene can say so.

use super::item::{Mesh, Shape};
use super::owner::Owner;
use crate::lanes::Real;
use crate::shape::Frustum;
use glam::DVec3;

/// Roundings of double precision in the height of a point above a triangle.
const ROUNDINGS: f64 = 32.0 * f64::EPSILON;

impl<R: Real> Owner<'_, R> {
    /// Whether a ray `origin + t dir` of the scene starts on what it hits: the triangle `expanded` of this body, or the frustum that
    /// it is. Other shapes are met at t = 0 exactly, and bodies that move are nowhere exactly.
    pub fn touches(&self, expanded: u64, origin: DVec3, dir: DVec3, t: f64) -> bool {
        let Some(local) = self.point_into_object(origin) else { return false };
        match &self.item.shape {
            Shape::Mesh(mesh) => is_on_triangle(mesh, (expanded - self.body) as usize, local),
            Shape::Frustum(frustum) => is_on_frustum(frustum, local, self.direction_into_object(dir), t),
            _ => false,
        }
    }
}

/// |n (p - a)| is at most some roundings of its terms. The differences of numbers of this precision are exact, or nearly so. A plane is
/// met once, so the hit is where the ray starts.
fn is_on_triangle<R: Real>(mesh: &Mesh<R>, face: usize, p: DVec3) -> bool {
    let [a, b, c] = mesh.points(face);
    let (normal, from) = ((b - a).cross(c - a), p - a);
    normal.dot(from).abs() <= ROUNDINGS * normal.abs().dot(from.abs())
}

/// Within roundings of the frustum's numbers the ray starts on its side, and the hit is nearer to there than to where the side is met
/// again; or it starts on the plane of an end, and hits that.
fn is_on_frustum<R: Real>(frustum: &Frustum<R>, origin: DVec3, dir: DVec3, t: f64) -> bool {
    let (o, d) = frustum.frame.ray_in(origin, dir);
    let [height, radius, slope] = [frustum.height, frustum.base_radius, frustum.slope].map(Real::to_f64);
    let side = |p: DVec3| radius + slope * p.z;
    // Of x^2 + y^2 - side^2, how far p is from the side.
    let off = |p: DVec3| (p.truncate().length() - side(p)).abs();
    let slack = 8.0 * R::ROUNDOFF * (o.truncate().length() + o.z.abs() + radius + height);
    let hit = o + d * t;
    if off(hit) > slack {
        let is_end = |end: f64| (o.z - end).abs() <= slack && (hit.z - end).abs() <= slack;
        return frustum.capped && [0.0, height].into_iter().any(is_end);
    }
    // (o + t d) is on the side where A t^2 + 2 B t = 0.
    let a = d.truncate().length_squared() - (slope * d.z).powi(2);
    let b = o.truncate().dot(d.truncate()) - side(o) * slope * d.z;
    let again = -2.0 * b / a;
    off(o) <= slack && !(again > 0.0 && t >= 0.5 * again)
}
