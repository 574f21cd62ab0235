//! Extents of bounded things: boxes and balls around them.

use super::bounds::Bounds;
use crate::lanes::{Lanes, Real, V3};
use crate::ray::Rays;
use glam::DVec3;

/// A box and a ball around something. With rotations, a box around a box grows at each level of nesting; a ball around a
/// ball does not.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    /// The box.
    pub bounds: Bounds,
    /// Centre of the ball.
    pub center: DVec3,
    /// Radius of the ball; negative if there is nothing inside.
    pub radius: f64,
}

impl Extent {
    /// The extent of nothing.
    pub const EMPTY: Self = Self { bounds: Bounds::EMPTY, center: DVec3::ZERO, radius: -1.0 };

    /// The extent of something inside a box.
    pub fn of_box(bounds: Bounds) -> Self {
        Self { bounds, center: bounds.center(), radius: 0.5 * (bounds.max - bounds.min).length() }
    }

    /// The box around the intersection of box and ball.
    pub(super) fn tight_box(&self) -> Bounds {
        let ball = Bounds::around([self.center]).grown(self.radius);
        Bounds { min: self.bounds.min.max(ball.min), max: self.bounds.max.min(ball.max) }
    }
}

/// A ball around something.
#[derive(Debug, Clone, Copy)]
pub struct Ball<R> {
    /// Centre.
    pub center: [R; 3],
    /// Radius.
    pub radius: R,
}

impl<R: Real> Ball<R> {
    /// The ball of an extent, enlarged by the roundings of its own numbers.
    pub fn new(extent: &Extent) -> Self {
        let size = extent.center.abs().max_element() + extent.radius;
        Self {
            center: extent.center.to_array().map(R::from_f64),
            radius: R::from_f64(extent.radius + 4.0 * R::ROUNDOFF * size),
        }
    }

    /// The lanes whose line passes the ball: |(o - c) x d| <= r |d|, where each side may be off by roundings of |o - c|.
    #[inline(always)]
    pub(super) fn near<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>) -> L::Mask {
        let f = rays.origin - V3::splat(s, self.center);
        let across = f.cross(rays.dir);
        let reach = L::splat(s, self.radius) + f.length() * L::lit(s, 16.0 * R::ROUNDOFF);
        across.dot(across).le(reach * reach * rays.dir.dot(rays.dir))
    }
}
