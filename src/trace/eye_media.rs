//! The media around a point: where a ray starts when the eye is inside glass.

use super::hits::{Hits, MAX_CROSSINGS, Touch};
use crate::accel::Coherence;
use crate::lanes::{Lanes, Real, V3};
use crate::ray::Rays;
use crate::scene::world::World;
use crate::shading::media::Medium;
use std::collections::HashSet;

/// A direction that is unlikely to be parallel to faces and edges.
const DIRECTION: [f64; 3] = [0.436_435_780_471_985, 0.598_076_211_353_316, 0.672_186_343_420_581];

/// The media of the bodies around a point that transmit or absorb light, at a time if anything moves.
///
/// A straight line goes from the point through all surfaces. If the first surface of a body is an exit, the body contains
/// the point. Two opposite lines find unbounded bodies, too.
pub(crate) fn media_at<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    point: [L::Real; 3],
    time: Option<L::Real>,
) -> Vec<Medium<L::Real>> {
    L::vectorize(
        s,
        #[inline(always)]
        || media_around::<L>(s, world, point, time),
    )
}

#[inline(always)]
fn media_around<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    point: [L::Real; 3],
    time: Option<L::Real>,
) -> Vec<Medium<L::Real>> {
    let mut around: Vec<Medium<L::Real>> = Vec::new();
    for sign in [1.0, -1.0] {
        for medium in walk::<L>(s, world, point, sign, time) {
            if around.iter().all(|known| known.body != medium.body) {
                around.push(medium);
            }
        }
    }
    around
}

/// The media that a line leaves before it enters them.
#[inline(always)]
fn walk<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    point: [L::Real; 3],
    sign: f64,
    time: Option<L::Real>,
) -> Vec<Medium<L::Real>> {
    let dir = V3::<L>::splat(s, DIRECTION.map(|x| L::Real::from_f64(x * sign)));
    let mut origin = V3::splat(s, point);
    let mut met = HashSet::new();
    let mut left = Vec::new();
    let time = time.map(|time| L::splat(s, time));
    let mut hits = Hits { time, ..Hits::none(s) };
    for _ in 0..MAX_CROSSINGS {
        let (t_min, t_max) = (L::lit(s, 0.0), L::lit(s, f64::INFINITY));
        hits.find(s, world, &mut Rays { origin, dir, t_min, t_max, active: L::mask(s, 1) }, Coherence::Incoherent);
        if hits.found == 0 {
            break;
        }
        let own = (hits.closed & hits.transmissive != 0 || hits.absorbs(world, 0)).then(|| Touch {
            lane: 0,
            goes_in: hits.goes_in(0),
            medium: hits.medium(world, 0),
        });
        for touch in own.iter().chain(&hits.touching) {
            if met.insert(touch.medium.body) && !touch.goes_in {
                left.push(touch.medium);
            }
        }
        origin = hits.surface.leave(-hits.ng);
    }
    left
}
