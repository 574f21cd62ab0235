//! Disc: the part of a plane within a radius.

use super::{Plane, Sides};
use crate::lanes::{Lanes, Real, V3};
use crate::ray::{Intersection, Rays};

/// All points of a plane at most `radius` from its `point`.
#[derive(Debug, Clone, Copy)]
pub struct Disc<R> {
    /// The plane; its point is the disc's centre.
    pub plane: Plane<R>,
    /// Radius, above 0; the rim belongs to the disc.
    pub radius: R,
}

impl<R: Real> Disc<R> {
    /// Intersection in range.
    #[inline(always)]
    pub fn intersect<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>, sides: Sides) -> Intersection<L> {
        let mut intersection = self.plane.intersect(s, rays, sides);
        let from_center = intersection.point - V3::splat(s, self.plane.point);
        let radius = L::splat(s, self.radius);
        intersection.hit.lanes = intersection.hit.lanes & from_center.dot(from_center).le(radius * radius);
        intersection
    }
}
