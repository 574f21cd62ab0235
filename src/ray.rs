//! Rays, their hits, and how a new ray starts on a surface without hitting it again.

use crate::lanes::{Lanes, Mask, Real, V3};

/// One ray in each lane. The direction is unit unless stated; `t` counts in its units.
#[derive(Debug, Clone, Copy)]
pub struct Rays<L: Lanes> {
    /// Start.
    pub origin: V3<L>,
    /// Direction.
    pub dir: V3<L>,
    /// Hits must lie above this t.
    pub t_min: L,
    /// Hits must lie below this t.
    pub t_max: L,
    /// The lanes that hold a ray. Others may hold anything, NaN included.
    pub active: L::Mask,
}

/// The hit of a ray on one shape. Traversal needs no more than this, and the surface can be computed from it.
#[derive(Debug, Clone, Copy)]
pub struct Hit<L: Lanes> {
    /// Ray parameter.
    pub t: L,
    /// The lanes whose ray hits the shape inside (t_min, t_max).
    pub lanes: L::Mask,
    /// Barycentric weights of the vertices, for triangles.
    pub weights: [L; 3],
}

impl<L: Lanes> Hit<L> {
    /// A hit on a shape that has no barycentric weights.
    #[inline(always)]
    pub fn at(t: L, lanes: L::Mask) -> Self {
        Self { t, lanes, weights: [t, t, t] }
    }

    /// No hit in any lane.
    #[inline(always)]
    pub fn none(s: L::Simd) -> Self {
        Self::at(L::lit(s, 0.0), L::mask(s, 0))
    }
}

/// The intersection of a ray with one shape, with its surface, in the shape's own space.
#[derive(Debug, Clone, Copy)]
pub struct Intersection<L: Lanes> {
    /// Its distance.
    pub hit: Hit<L>,
    /// The point, as near to the surface as the format allows.
    pub met: V3<L>,
    /// The same, but away from edges: where next rays leave.
    pub point: V3<L>,
    /// Bound on the error of each coordinate of `point`, with the rounding of moving it onto the surface.
    pub error: V3<L>,
    /// Outward geometric normal, any length but 0.
    pub normal: V3<L>,
    /// Whether that length is 1.
    pub normalized: bool,
}

impl<L: Lanes> Intersection<L> {
    /// An intersection with shapes that have no barycentric weights.
    #[inline(always)]
    pub fn at(t: L, lanes: L::Mask, point: V3<L>, error: V3<L>, normal: V3<L>) -> Self {
        Self { hit: Hit::at(t, lanes), point, met: point, error, normal, normalized: false }
    }

    /// No intersection in any lane.
    #[inline(always)]
    pub fn none(s: L::Simd, rays: &Rays<L>) -> Self {
        let zero = L::lit(s, 0.0);
        Self::at(zero, L::mask(s, 0), rays.origin, V3 { x: zero, y: zero, z: zero }, -rays.dir)
    }
}

/// `gamma(n) = n u / (1 - n u)`, the bound on n accumulated roundings (Higham, Accuracy and Stability, lemma 3.1).
pub fn gamma<R: Real>(n: f64) -> f64 {
    n * R::ROUNDOFF / (1.0 - n * R::ROUNDOFF)
}

/// Error bound of `point` on a body around `center`: the vector from the centre to it has `own` roundings; adding that
/// vector to the centre and moving the point along the normal have one each.
#[inline(always)]
pub fn error_around<L: Lanes>(s: L::Simd, point: V3<L>, center: V3<L>, own: f64, from_center: V3<L>) -> V3<L> {
    let own = L::lit(s, gamma::<L::Real>(own));
    let sum = L::lit(s, gamma::<L::Real>(2.0));
    from_center.abs() * own + (point.abs() + center.abs()) * sum
}

/// Origin of a ray that leaves the surface at `point` on the side that the unit normal `side` points to. The point moves
/// along the normal by the extent of its error box, `delta = |n| . error` (Pharr et al., PBRT 4, section 6.8.6).
#[inline(always)]
pub fn leave<L: Lanes>(point: V3<L>, error: V3<L>, side: V3<L>) -> V3<L> {
    point + side * side.abs().dot(error)
}

impl<L: Lanes> Rays<L> {
    /// The point at `t`.
    #[inline(always)]
    pub fn at(&self, t: L) -> V3<L> {
        self.origin + self.dir * t
    }

    /// The lanes in which `t` lies inside the ray's range. False for NaN.
    #[inline(always)]
    pub fn in_range(&self, t: L) -> L::Mask {
        t.gt(self.t_min) & t.lt(self.t_max)
    }

    /// One lane's ray, in the lanes `active`.
    #[inline(always)]
    pub fn alone(&self, s: L::Simd, lane: usize, active: u32) -> Self {
        Self {
            origin: V3::splat(s, self.origin.lane(lane)),
            dir: V3::splat(s, self.dir.lane(lane)),
            t_min: L::splat(s, self.t_min.lane(lane)),
            t_max: L::splat(s, self.t_max.lane(lane)),
            active: L::mask(s, active),
        }
    }

    /// Whether any lane holds a ray.
    #[inline(always)]
    pub fn any(&self) -> bool {
        self.active.any()
    }
}
