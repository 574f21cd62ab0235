//! Colored shadows: how much light absorbing bodies transmit along a straight line, e^(-sigma d) for each segment.
//!
//! The line is followed from surface to surface, as a camera ray without refraction. So its media follow the same rules, and
//! the body that decides in a segment absorbs there, independently of the order of objects.

use super::attenuation::{absorption, beer_lambert, depth};
use super::hits::{Hits, MAX_CROSSINGS};
use super::interface::interface;
use crate::accel::Coherence;
use crate::lanes::{Lanes, Mask, Real, V3};
use crate::ray::Rays;
use crate::scene::world::World;
use crate::shading::media::Media;

/// The share of each channel that the bodies along shadow rays transmit. The rays start in the media `lists`, end at `t_max`
/// and have directions of any length; `time` is their time, if anything moves.
pub(super) fn absorption_transmittance<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    media: &mut Media<L::Real>,
    rays: Rays<L>,
    lists: L::Ids,
    time: Option<L>,
) -> V3<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || {
            let mark = media.mark();
            let left = walk(s, world, media, rays, lists, time);
            media.forget(mark);
            left
        },
    )
}

#[inline(always)]
fn walk<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    media: &mut Media<L::Real>,
    mut rays: Rays<L>,
    mut lists: L::Ids,
    time: Option<L>,
) -> V3<L> {
    let ends = rays.t_max.lt(L::lit(s, f64::INFINITY));
    let (dir, end) = (rays.dir, rays.origin + rays.dir);
    let mut sum = V3::splat(s, [L::Real::from_f64(0.0); 3]);
    let mut hits = Hits { time, ..Hits::none(s) };
    // Behind the last of them nothing is absorbed.
    for _ in 0..MAX_CROSSINGS {
        let lanes = rays.active.bits();
        if lanes == 0 {
            break;
        }
        hits.find(s, world, &mut rays, Coherence::Incoherent);
        let sigma = absorption(s, world, media, lists, lanes);
        let passed = depth(s, sigma, hits.t * rays.dir.length());
        sum = V3::select(L::mask(s, lanes), sum + passed, sum);
        if hits.found == 0 {
            break;
        }
        let entered = hits.found & hits.closed & hits.transmissive;
        lists = interface(s, world, media, &hits, lists, entered).behind;
        rays.origin = hits.surface.leave(-hits.ng);
        rays.dir = V3::select(ends, end - rays.origin, dir);
        rays.active = L::mask(s, hits.found);
    }
    beer_lambert(s, sum)
}
