//! All rays of a packet against all children of a node at once: bounds on where the first ray may enter a box and the last
//! one leave it (Boulos, Wald, Shirley, Geometric and Arithmetic Culling Methods for Entire Ray Packets, 2006).

use super::bounds::{Reciprocal, SLACK};
use super::wide_bvh::WideNode;
use crate::lanes::{Lanes, Mask, Real};
use crate::ray::{Rays, gamma};

/// Bounds on rays whose directions have the same signs.
#[derive(Debug, Clone, Copy)]
pub(super) struct PacketBounds<R> {
    axes: [Axis<R>; 3],
    t_min: R,
}

#[derive(Debug, Clone, Copy)]
struct Axis<R> {
    /// Whether coordinates grow along the rays.
    forward: bool,
    /// The origin furthest along the rays, and the one furthest back.
    ahead: R,
    back: R,
    /// The smallest and the largest 1/d.
    inverse: [R; 2],
}

impl<R: Real> PacketBounds<R> {
    /// The bounds of the active rays, if their directions have the same signs.
    #[inline(always)]
    pub(super) fn new<L: Lanes<Real = R>>(s: L::Simd, rays: &Rays<L>, reciprocal: &Reciprocal<L>) -> Option<Self> {
        if reciprocal.backwards {
            return None;
        }
        let inverse = reciprocal.inverse;
        Some(Self {
            axes: [
                Axis::new(s, rays.active, rays.origin.x, inverse.x)?,
                Axis::new(s, rays.active, rays.origin.y, inverse.y)?,
                Axis::new(s, rays.active, rays.origin.z, inverse.z)?,
            ],
            t_min: least(s, rays.active, rays.t_min),
        })
    }

    /// The children that some ray of the packet may pass, and a lower bound on where it enters.
    ///
    /// Rounding is monotone: with the origin and the reciprocal that make each difference and product smallest, the result is
    /// not above that of any ray. So every box that [`Reciprocal::crosses_boxes`] accepts is accepted here.
    #[inline(always)]
    pub(super) fn crosses<L: Lanes<Real = R>>(&self, s: L::Simd, node: &WideNode<R>) -> (L::Mask, L) {
        let (x_in, x_out) = self.axes[0].span::<L>(s, &node.min[0], &node.max[0]);
        let (y_in, y_out) = self.axes[1].span::<L>(s, &node.min[1], &node.max[1]);
        let (z_in, z_out) = self.axes[2].span::<L>(s, &node.min[2], &node.max[2]);
        let enter = x_in.max(y_in).max(z_in).max(L::splat(s, self.t_min));
        let exit = x_out.min(y_out).min(z_out) * L::lit(s, 1.0 + gamma::<R>(SLACK));
        (enter.le(exit), enter)
    }
}

impl<R: Real> Axis<R> {
    #[inline(always)]
    fn new<L: Lanes<Real = R>>(s: L::Simd, active: L::Mask, origin: L, inverse: L) -> Option<Self> {
        let on = active.bits();
        let negative = inverse.lt(L::lit(s, 0.0)).bits() & on;
        if negative != 0 && negative != on {
            return None;
        }
        let (low, high) = (least(s, active, origin), -least(s, active, -origin));
        let forward = negative == 0;
        let (ahead, back) = if forward { (high, low) } else { (low, high) };
        let inverse = [least(s, active, inverse), -least(s, active, -inverse)];
        Some(Self { forward, ahead, back, inverse })
    }

    /// Bounds on where rays enter and leave each slab.
    #[inline(always)]
    fn span<L: Lanes<Real = R>>(&self, s: L::Simd, min: &[R], max: &[R]) -> (L, L) {
        let (near, far) = if self.forward { (min, max) } else { (max, min) };
        let low = L::load(s, near) - L::splat(s, self.ahead);
        let high = L::load(s, far) - L::splat(s, self.back);
        let [small, large] = self.inverse;
        let (small, large) = (L::splat(s, small), L::splat(s, large));
        ((low * small).min(low * large), (high * small).max(high * large))
    }
}

/// The smallest number in the lanes of a mask.
#[inline(always)]
fn least<L: Lanes>(s: L::Simd, mask: L::Mask, x: L) -> L::Real {
    L::select(mask, x, L::lit(s, f64::INFINITY)).smallest()
}
