//! Color bleeding: the light that surfaces scatter onto each other, once.
//!
//! In place of the ambient light a surface gets the mean of what it sees, one direction for each sample, chosen by the
//! cosine: L = k_d (1/pi) integral L_i cos = k_d E[L_i]. What the directions meet has ambient light again.

use super::hits::Hits;
use super::kernel::{Followed, RayKind, Tracer};
use super::observer::Observer;
use super::sampling::{Choice, child};
use crate::lanes::{Lanes, Mask, circle};
use crate::ray::leave;
use crate::shading::material::Coefficients;
use crate::trace::variants::Effects;

/// Stacks the rays that bring what diffuse surfaces see.
#[inline(never)]
pub(super) fn gather<L: Lanes, O: Observer<L>, E: Effects>(
    tracer: &mut Tracer<'_, L, O, E>,
    rays: &Followed<L>,
    hits: &Hits<L>,
    coefficients: &Coefficients<L>,
    number: u32,
) {
    L::vectorize(
        tracer.s,
        #[inline(always)]
        || gather_in(tracer, rays, hits, coefficients, number),
    );
}

#[inline(always)]
fn gather_in<L: Lanes, O: Observer<L>, E: Effects>(
    tracer: &mut Tracer<'_, L, O, E>,
    rays: &Followed<L>,
    hits: &Hits<L>,
    coefficients: &Coefficients<L>,
    number: u32,
) {
    let s = tracer.s;
    let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
    let kd = coefficients.diffuse;
    let diffuse = kd.x.max(kd.y).max(kd.z).gt(zero).bits() & hits.found;
    if diffuse == 0 {
        return;
    }
    if rays.depth >= tracer.world.rules.max_depth {
        tracer.record_omitted_rays(diffuse, rays.weight.times(kd), rays.depth + 1);
        return;
    }
    let [a, b]: [L; 2] = tracer.sampler.square(s, rays.path, Choice::Gather);
    let [x, y] = circle(s, a);
    let reach = b.sqrt();
    let [right, up] = hits.ns.across(s);
    let dir = right * (x * reach) + up * (y * reach) + hits.ns * (one - b).max(zero).sqrt();
    let above = dir.dot(hits.ng).gt(zero).bits();
    tracer.push(Followed {
        origin: leave(hits.surface.point, hits.surface.error, hits.ng),
        dir: dir.normalized(s),
        t_min: zero,
        weight: rays.weight.times(kd),
        active: diffuse & above,
        media: rays.media,
        depth: rays.depth + 1,
        kind: RayKind::Gathered,
        path: child(rays.path, RayKind::Gathered),
        dispersed: rays.dispersed,
        parent: number,
    });
}
