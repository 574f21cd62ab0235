//! Plane, written with `p - o` so that a plane far from the origin does not lose digits.

use super::Sides;
use crate::lanes::{Lanes, Real, V3};
use crate::ray::{Intersection, Rays, gamma};

/// All points p with n.(p - point) = 0.
#[derive(Debug, Clone, Copy)]
pub struct Plane<R> {
    /// A point of the plane.
    pub point: [R; 3],
    /// Unit normal.
    pub normal: [R; 3],
}

impl<R: Real> Plane<R> {
    /// Intersection in range: t = n.(p - o) / n.d. A ray parallel to the plane, or in it, misses.
    #[inline(always)]
    pub fn intersect<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>, sides: Sides) -> Intersection<L> {
        let p = V3::<L>::splat(s, self.point);
        let n = V3::<L>::splat(s, self.normal);
        let cosine = n.dot(rays.dir);
        let t = n.dot(p - rays.origin) / cosine;

        let zero = L::lit(s, 0.0);
        let seen = sides.outside::<L>(s, cosine.lt(zero)) | sides.inside::<L>(s, cosine.gt(zero));
        let hit = rays.active & rays.in_range(t) & seen;

        // o + t d is off the plane by the roundings of t d; one projection corrects it. What remains are the roundings of
        // n.(q - p), where distances along the plane do not count if the plane is parallel to an axis.
        let q = rays.at(t);
        let point = q - n * n.dot(q - p);
        let off = n.abs().dot((point - p).abs()) * L::lit(s, gamma::<R>(8.0));
        let own = (point.abs() + p.abs()) * L::lit(s, gamma::<R>(4.0));
        let error = own + V3 { x: off, y: off, z: off };
        Intersection { normalized: true, ..Intersection::at(t, hit, point, error, n) }
    }
}
