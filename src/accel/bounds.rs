//! Axis-aligned bounding boxes, and the conservative slab test.

use crate::lanes::{Lanes, Mask, Real, V3};
use crate::ray::{Rays, gamma};
use glam::DVec3;

/// An axis-aligned box in f64; empty if min > max.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(missing_docs, reason = "the names say it")]
pub struct Bounds {
    pub min: DVec3,
    pub max: DVec3,
}

impl Bounds {
    /// The box without points.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The smallest box around points.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// The smallest box around two boxes.
    pub fn union(self, o: Self) -> Self {
        Self { min: self.min.min(o.min), max: self.max.max(o.max) }
    }

    /// The middle.
    pub fn center(self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// Larger by `amount` on all sides.
    pub fn grown(self, amount: f64) -> Self {
        Self { min: self.min - amount, max: self.max + amount }
    }

    /// The eight corners.
    pub fn corners(self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, low: f64, high: f64| if i & bit == 0 { low } else { high };
            DVec3::new(
                pick(1, self.min.x, self.max.x),
                pick(2, self.min.y, self.max.y),
                pick(4, self.min.z, self.max.z),
            )
        })
    }

    /// The box in another format, rounded outwards.
    pub(super) fn narrowed<R: Real>(self) -> Slab<R> {
        // Rounding to nearest moves a coordinate by at most u of itself; twice that outwards covers it. The same share of
        // the box's width is added for a ray that runs in a side at coordinate 0, where u of the coordinate is nothing.
        let width = (self.max - self.min).max(DVec3::ZERO);
        let room = (self.min.abs().max(self.max.abs()) + width) * (2.0 * R::ROUNDOFF) + f64::MIN_POSITIVE;
        Slab { min: (self.min - room).to_array().map(R::from_f64), max: (self.max + room).to_array().map(R::from_f64) }
    }
}

/// A box in the kernel's format.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slab<R> {
    pub(super) min: [R; 3],
    pub(super) max: [R; 3],
}

impl<R: Real> Slab<R> {
    /// The same box in 64 bits.
    pub(super) fn widened(&self) -> Bounds {
        let corner = |corner: [R; 3]| DVec3::from_array(corner.map(Real::to_f64));
        Bounds { min: corner(self.min), max: corner(self.max) }
    }

    /// Half the surface area.
    pub(super) fn half_area(&self) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.max[axis].to_f64() - self.min[axis].to_f64());
        x * y + y * z + z * x
    }
}

/// Roundings of a slab test and of a primitive's own t together.
pub(super) const SLACK: f64 = 16.0;

/// What the slab test needs of a ray: 1/d, with zero components replaced so that nothing is 0/0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reciprocal<L> {
    pub(super) inverse: V3<L>,
    /// Whether some ray may hit behind its origin. There t is negative, and a larger factor makes it smaller.
    pub(super) backwards: bool,
}

impl<L: Lanes> Reciprocal<L> {
    #[inline(always)]
    pub(super) fn new(s: L::Simd, rays: &Rays<L>) -> Self {
        // A ray parallel to a slab is always or never in it. With a tiny d instead of 0, (b - o)/d is huge with the right
        // sign, and 0 where o lies on the boundary, which belongs to the box. The smallest normal number has a finite
        // reciprocal, and it is small enough for boxes at any distance.
        let tiny = L::lit(s, L::Real::SMALLEST);
        let zero = L::lit(s, 0.0);
        let one = L::lit(s, 1.0);
        let mut dir = rays.dir;
        let size = dir.abs();
        if (rays.active & size.x.min(size.y).min(size.z).lt(tiny)).any() {
            dir.x = L::select(size.x.lt(tiny), L::select(dir.x.lt(zero), -tiny, tiny), dir.x);
            dir.y = L::select(size.y.lt(tiny), L::select(dir.y.lt(zero), -tiny, tiny), dir.y);
            dir.z = L::select(size.z.lt(tiny), L::select(dir.z.lt(zero), -tiny, tiny), dir.z);
        }
        Self {
            inverse: V3 { x: one / dir.x, y: one / dir.y, z: one / dir.z },
            backwards: (rays.active & rays.t_min.lt(zero)).any(),
        }
    }

    /// That of one lane's ray, in all lanes.
    #[inline(always)]
    pub(super) fn alone(&self, s: L::Simd, lane: usize) -> Self {
        Self { inverse: V3::splat(s, self.inverse.lane(lane)), backwards: self.backwards }
    }

    /// The lanes whose ray passes its box inside its range, and where it enters. Conservative: never false for a ray that hits
    /// something in the box.
    #[inline(always)]
    pub(super) fn crosses_boxes(&self, s: L::Simd, min: V3<L>, max: V3<L>, rays: &Rays<L>) -> (L::Mask, L) {
        let (low, high) = (min - rays.origin, max - rays.origin);
        let (a, b) = (low.times(self.inverse), high.times(self.inverse));
        let enter = a.x.min(b.x).max(a.y.min(b.y)).max(a.z.min(b.z));
        let exit = a.x.max(b.x).min(a.y.max(b.y)).min(a.z.max(b.z));
        // (b - o) * (1/d) has three roundings, so each bound may be off by gamma(3) and the primitive's t by as much
        // again; the far side gets all of it (after Ize, JCGT 2(2) 2013).
        let exit = self.widened(s, exit.min(rays.t_max));
        (rays.active & enter.max(rays.t_min).le(exit), enter)
    }

    /// The lanes whose range reaches beyond `enter`.
    #[inline(always)]
    pub(super) fn reaches(&self, s: L::Simd, enter: L, t_max: L) -> L::Mask {
        enter.le(self.widened(s, t_max))
    }

    /// A bound on t, enlarged by all roundings.
    #[inline(always)]
    fn widened(&self, s: L::Simd, t: L) -> L {
        let widen = L::lit(s, 1.0 + gamma::<L::Real>(SLACK));
        if self.backwards { L::select(t.gt(L::lit(s, 0.0)), t * widen, t / widen) } else { t * widen }
    }
}
