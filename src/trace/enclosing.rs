//! Which bodies a point lies in: the media a ray starts in when the eye is inside glass.

use super::hits::find;
use super::kernel::first;
use crate::lanes::{Lanes, Real, V3};
use crate::ray::{Rays, leave};
use crate::scene::world::World;

/// Most surfaces crossed in one direction; more than that many bodies around an eye are not told apart.
const MAX_CROSSINGS: usize = 1000;

/// An odd direction, which no scene's faces and edges are aligned with.
const DIRECTION: [f64; 3] = [0.436_435_780_471_985, 0.598_076_211_353_316, 0.672_186_343_420_581];

/// Transmitting bodies around a point and the index of refraction inside each, innermost first.
///
/// From the point one walks straight on through every surface. A body whose first surface is one of leaving it contains
/// the point, and of two such bodies the one left sooner is the inner one. Two opposite walks meet unbounded bodies, too.
pub fn media_at<L: Lanes>(s: L::Simd, world: &World<L::Real>, point: [L::Real; 3]) -> Vec<(u64, L::Real)> {
    let mut around = Vec::new();
    for sign in [1.0, -1.0] {
        walk::<L>(s, world, point, sign, &mut around);
    }
    around.sort_by(|a: &Around<L::Real>, b| a.exit.total_cmp(&b.exit));
    let mut seen = Vec::new();
    around.retain(|entry| {
        let new = !seen.contains(&entry.body);
        seen.push(entry.body);
        new
    });
    around.into_iter().map(|entry| (entry.body, entry.ior)).collect()
}

/// A body around the point, and how far away the walk left it.
struct Around<R> {
    exit: f64,
    body: u64,
    ior: R,
}

fn walk<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    point: [L::Real; 3],
    sign: f64,
    around: &mut Vec<Around<L::Real>>,
) {
    let dir = V3::<L>::splat(s, DIRECTION.map(|x| L::Real::from_f64(x * sign)));
    let mut origin = V3::splat(s, point);
    let mut met = Vec::new();
    let mut distance = 0.0;
    for _ in 0..MAX_CROSSINGS {
        let (t_min, t_max) = (L::lit(s, 0.0), L::lit(s, f64::INFINITY));
        let hits = find(s, world, &Rays { origin, dir, t_min, t_max, active: L::mask(s, 1) });
        if hits.found == 0 {
            return;
        }
        distance += first(hits.t);
        let body = hits.body[0];
        if hits.closed != 0 && hits.transmits(world, 0) && !met.contains(&body) {
            met.push(body);
            let entering = hits.entering != 0;
            let hollow = hits.hollow != 0;
            // Leaving the region: out of the material, or for a hollow body out of the cavity into the material.
            if entering == hollow {
                let ior = if hollow { L::Real::from_f64(1.0) } else { world.materials[hits.material[0] as usize].ior };
                around.push(Around { exit: distance, body, ior });
            }
        }
        origin = leave(hits.surface.point, hits.surface.error, -hits.ng);
    }
}
