//! The surface under each ray of a packet.

use super::placement::Placement;
use crate::lanes::{Lanes, Real, V3};
use crate::ray::{Intersection, gamma, leave};

/// A surface under each ray.
#[derive(Debug, Clone, Copy)]
pub struct Surface<L: Lanes> {
    /// The point, on the surface as exactly as the format allows.
    pub point: V3<L>,
    /// From the point to where next rays leave, away from edges.
    pub inwards: V3<L>,
    /// Bound on the error of each coordinate of both points.
    pub error: V3<L>,
    /// Geometric normal: unit, pointing out of the body's material.
    pub ng: V3<L>,
    /// Shading normal: unit, on the same side as `ng`.
    pub ns: V3<L>,
    /// From the point to the curved surface that interpolated normals suggest, on the side the ray comes from.
    pub lift: V3<L>,
    /// The point in the coordinates in which the body is written.
    pub local: V3<L>,
    /// Lanes whose ray hits the body; the others hold no surface.
    pub hit: L::Mask,
}

/// Unit vector of any vector but 0, without overflow or underflow in its square.
#[inline(always)]
fn unit<L: Lanes>(s: L::Simd, v: V3<L>) -> V3<L> {
    let a = v.abs();
    let exponent = a.x.max(a.y).max(a.z).exponent();
    (v * (-exponent.min(L::lit(s, L::Real::LOWEST))).power_of_two()).normalized(s)
}

impl<L: Lanes> Surface<L> {
    /// The surface at an intersection, in the body's coordinates. `outward` is -1 for bodies turned inside out.
    #[inline(always)]
    pub(super) fn flat(s: L::Simd, intersection: &Intersection<L>, outward: L, dir: V3<L>) -> Self {
        // The tip of a cone has no normal: it is set against the ray.
        let ng = if intersection.normalized {
            intersection.normal * outward
        } else {
            let size = intersection.normal.abs();
            let measurable = (size.x + size.y + size.z).gt(L::lit(s, 0.0));
            unit(s, V3::select(measurable, intersection.normal * outward, -dir))
        };
        let lift = V3::splat(s, [L::Real::from_f64(0.0); 3]);
        let Intersection { point, met, error, hit, .. } = *intersection;
        Self { point: met, inwards: point - met, error, ng, ns: ng, lift, local: met, hit: hit.lanes }
    }

    /// Origin of a ray that leaves the surface on the side that the unit normal `side` points to.
    #[inline(always)]
    pub fn leave(&self, side: V3<L>) -> V3<L> {
        leave(self.point + self.inwards, self.error, side)
    }

    /// `a` where the mask is true, `b` elsewhere.
    #[inline(always)]
    pub fn select(mask: L::Mask, a: Self, b: Self) -> Self {
        Self {
            point: V3::select(mask, a.point, b.point),
            inwards: V3::select(mask, a.inwards, b.inwards),
            error: V3::select(mask, a.error, b.error),
            ng: V3::select(mask, a.ng, b.ng),
            ns: V3::select(mask, a.ns, b.ns),
            lift: V3::select(mask, a.lift, b.lift),
            local: V3::select(mask, a.local, b.local),
            hit: (mask & a.hit) | (!mask & b.hit),
        }
    }

    /// The surface in the coordinates outside of a placed geometry. The error grows by the roundings of this map, and by
    /// those of mapping the origin of the next ray back (bounds of Wächter and Binder, and of NVIDIA, with
    /// gamma(3)(|M||p| + |t|) in each direction).
    #[inline(always)]
    pub(super) fn placed(
        self,
        s: L::Simd,
        to_world: &Placement<L::Real>,
        to_local: &Placement<L::Real>,
        smooth: bool,
    ) -> Self {
        let point = to_world.point(s, self.point);
        let step = L::lit(s, gamma::<L::Real>(4.0));
        let moved = to_world.spread(s, self.point.abs()) + V3::<L>::splat(s, to_world.translation).abs();
        let returned = to_local.spread(s, point.abs()) + V3::<L>::splat(s, to_local.translation).abs();
        let ng = unit(s, to_local.transposed(s, self.ng));
        Self {
            point,
            inwards: to_world.vector(s, self.inwards),
            error: to_world.spread(s, self.error + returned * step) + moved * step,
            ng,
            ns: if smooth { unit(s, to_local.transposed(s, self.ns)) } else { ng },
            lift: if smooth { to_world.vector(s, self.lift) } else { self.lift },
            local: self.local,
            hit: self.hit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_survives_extremes() {
        for size in [1e-38f32, 1e-20, 1.0, 1e20, 1e38] {
            let v = unit((), V3 { x: size, y: 0.0, z: -size });
            assert!((v.dot(v) - 1.0).abs() < 1e-6, "{size}");
        }
    }
}
