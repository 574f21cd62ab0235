//! Surfaces in the same place: water that fills a glass to its wall, a glass block on a floor.
//!
//! A ray that leaves a surface starts at a small distance from it, so that rounding does not make it hit the surface again.
//! It would miss other surfaces within that distance. So where light may pass, the segment between the two starting points,
//! in front of and behind the surface, is searched. An opaque surface there hides the one that was hit; transmitting bodies
//! are entered or left together with it. So touching bodies share one interface, and the result does not depend on rounding.

use super::hits::{Hits, Touch};
use crate::accel::{Coherence, Nearest, Skipped};
use crate::lanes::{Ids, Lanes, MAX_LANES, Mask, V3, lanes_of};
use crate::ray::{Rays, gamma, leave};
use crate::scene::world::World;

/// Upper bound on the error of any surface, in roundings of the scene's size.
const SEARCHED: f64 = 24.0;

/// Most bodies that touch in one place; further ones are ignored.
const MAX_TOUCHING: usize = 8;

/// Finds the surfaces that touch the transmitting ones that rays have hit.
pub(super) fn find<L: Lanes>(s: L::Simd, world: &World<L::Real>, rays: &Rays<L>, hits: &mut Hits<L>) {
    let clear = hits.may_touch & hits.transmissive;
    L::vectorize(
        s,
        #[inline(always)]
        || search(s, world, rays, hits, clear),
    );
}

#[inline(always)]
fn search<L: Lanes>(s: L::Simd, world: &World<L::Real>, rays: &Rays<L>, hits: &mut Hits<L>, clear: u32) {
    // The error of a surface depends on its own size, so other surfaces may be less exact than the one that was hit. The
    // search covers the largest possible error, and then each surface is tested with its own.
    let far = V3::splat(s, [world.size; 3]) + hits.surface.point.abs();
    let reach = hits.surface.error + far * L::lit(s, gamma::<L::Real>(SEARCHED));
    let point = hits.surface.point + hits.surface.inwards;
    let front = leave(point, reach, hits.ng);
    let behind = leave(point, reach, -hits.ng);
    let mut stretch = Rays {
        origin: front,
        dir: behind - front,
        t_min: L::lit(s, 0.0),
        t_max: L::lit(s, 1.0),
        active: L::mask(s, clear),
    };
    let body = |hits: &Hits<L>, lane: usize| {
        let owner = world.owner(hits.expanded.lane(lane));
        (owner.body, owner.item.expanded)
    };
    let mut passed = Skipped { first: [(0, 0); MAX_LANES], more: Vec::new() };
    for lane in lanes_of(clear) {
        passed.first[lane] = body(hits, lane);
    }
    let own_error = hits.surface.error;
    let mut other = Hits { time: hits.time, ..Hits::none(s) };
    for _ in 0..MAX_TOUCHING {
        other.find_nearest(s, world, &mut stretch, &Nearest::without(s, &passed), Coherence::Incoherent);
        if other.found == 0 {
            return;
        }
        let gap = (other.surface.point - hits.surface.point).dot(hits.ng).abs();
        let errors = own_error + other.surface.error;
        let touch = gap.le(errors.dot(hits.ng.abs())).bits() & other.found;
        let mut opaque = 0;
        for lane in lanes_of(other.found) {
            let (start, count) = body(&other, lane);
            passed.more.push((lane, start..start + count));
            if touch & (1 << lane) == 0 {
                continue;
            }
            if other.transmissive & (1 << lane) == 0 {
                opaque |= 1 << lane;
            } else if other.closed & (1 << lane) != 0 {
                hits.touching.push(Touch { lane, goes_in: other.goes_in(lane), medium: other.medium(world, lane) });
            }
        }
        // Rays start beyond both surfaces.
        let both = errors + V3 { x: gap, y: gap, z: gap };
        hits.surface.error = V3::select(L::mask(s, touch & !opaque), both, hits.surface.error);
        hide(s, world, rays, hits, &other, opaque);
        stretch.active = L::mask(s, other.found & !opaque);
    }
}

/// Replaces the hits of lanes by the opaque surface in the same place, if their rays hit it.
#[inline(always)]
fn hide<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    rays: &Rays<L>,
    hits: &mut Hits<L>,
    opaque: &Hits<L>,
    lanes: u32,
) {
    if lanes == 0 {
        return;
    }
    let mut instead = Hits { expanded: opaque.expanded, ..hits.clone() };
    instead.forget(lanes);
    instead.resolve(s, world, rays, lanes, None);
    let met = instead.surface.hit.bits() & lanes;
    instead.expanded = L::Ids::select(L::mask(s, met), opaque.expanded, hits.expanded);
    instead.forget(lanes & !met);
    instead.resolve(s, world, rays, lanes & !met, None);
    let keep = L::mask(s, !met);
    instead.surface.error = V3::select(keep, hits.surface.error, instead.surface.error);
    instead.touching.retain(|touch| met & (1 << touch.lane) == 0);
    *hits = instead;
}
