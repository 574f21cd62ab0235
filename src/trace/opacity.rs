//! Surfaces that are only partly there: light goes straight on through the rest, rays and shadow rays alike. So layers of them
//! need no order.

use super::hits::{Hits, MAX_CROSSINGS};
use super::kernel::Tracer;
use super::observer::{NotFollowed, Observer};
use super::pbr::passage;
use super::ray_packet::{RayKind, RayPacket};
use super::sampling::child;
use super::variants::Variant;
use crate::accel::{Blockers, Coherence, transmittance};
use crate::lanes::{Lanes, Mask, V3};
use crate::ray::{Rays, gamma};
use crate::scene::effects::Effect;
use crate::scene::world::World;

/// Most of a ray's length that is leapt over behind a surface, where it only grazes it.
const LONGEST_STEP: f64 = 1.0 / 1_024.0;

/// Stacks the rays that go on where surfaces are only partly there, and forgets the hits where nothing is there.
#[inline(never)]
pub(super) fn continue_through<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &mut Hits<L>,
    opacity: L,
    lanes: u32,
    number: u32,
) {
    L::vectorize(
        tracer.s,
        #[inline(always)]
        || {
            let s = tracer.s;
            let one = L::lit(s, 1.0);
            let open = opacity.lt(one).bits() & lanes & hits.found;
            if open == 0 {
                return;
            }
            let weight = rays.weight * (one - opacity);
            // One that a lobe has sent still looks for lights.
            let kind = if rays.kind == RayKind::Reflected { rays.kind } else { RayKind::Transmitted };
            if rays.depth >= tracer.world.rules.max_depth {
                tracer.omit_children(open, weight, rays.depth + 1, rays.straight);
                if O::WATCHING {
                    tracer.observer.not_followed(number, kind, weight, NotFollowed::Depth);
                }
            } else {
                let next = tracer.cones.next;
                tracer.cones.go_on();
                // The ray itself, from where it has got to: it has its own place among the rays that leave from here.
                let on = RayPacket {
                    t_min: behind(s, hits, rays.dir),
                    weight,
                    active: open,
                    depth: rays.depth + 1,
                    kind,
                    path: child(rays.path, RayKind::Camera),
                    parent: number,
                    ..*rays
                };
                tracer.send(on);
                tracer.cones.next = next;
            }
            hits.found &= !(opacity.le(L::lit(s, 0.0)).bits() & open);
        },
    );
}

/// Where straight rays go on: beyond the errors of the place where they have met a surface. At an edge that two triangles share, the
/// other one is met at the same place but for roundings, and would be there twice.
#[inline(always)]
pub(super) fn behind<L: Lanes>(s: L::Simd, hits: &Hits<L>, dir: V3<L>) -> L {
    // The distance has the roundings of the whole way.
    let way = (dir * hits.t).abs() * L::lit(s, gamma::<L::Real>(8.0));
    let error = hits.ng.abs().dot(hits.surface.error + way);
    let step = (error + error) / hits.ng.dot(dir).abs();
    hits.t + step.min(hits.t * L::lit(s, LONGEST_STEP))
}

/// The share of each channel that arrives along shadow rays, of which surfaces that are only partly there let some through.
#[inline(always)]
pub(super) fn transmittance_with_holes<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    blockers: Blockers,
    shadow: Rays<L>,
    coherence: Coherence,
    time: Option<L>,
) -> V3<L> {
    let left = transmittance(s, &world.geometries, world.root, blockers, shadow, coherence, time.as_ref());
    if !world.effects.has(Effect::Opacity) {
        return left;
    }
    let active = shadow.active & left.x.max(left.y).max(left.z).gt(L::lit(s, 0.0));
    left.times(cutout_transmittance(s, world, blockers, Rays { active, ..shadow }, time))
}

/// The share of each channel that passes the surfaces along shadow rays which are only partly there. The rays end at `t_max`
/// and have directions of any length; what blocks them has been looked for.
#[inline(never)]
fn cutout_transmittance<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    blockers: Blockers,
    rays: Rays<L>,
    time: Option<L>,
) -> V3<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || walk(s, world, blockers, rays, time),
    )
}

#[inline(always)]
fn walk<L: Lanes>(s: L::Simd, world: &World<L::Real>, blockers: Blockers, mut rays: Rays<L>, time: Option<L>) -> V3<L> {
    let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
    let mut left = V3 { x: one, y: one, z: one };
    let mut hits = Hits { time, ..Hits::none(s) };
    // Light passes what is behind the last of them.
    for _ in 0..MAX_CROSSINGS {
        if !rays.any() {
            break;
        }
        hits.find(s, world, &mut rays, Coherence::Incoherent);
        if hits.found == 0 {
            break;
        }
        // What surfaces without holes let pass has been taken into account.
        let (lanes, opacity, passed) = passage(s, world, rays.dir, &hits);
        let open = one - opacity;
        let mut through = V3 { x: open, y: open, z: open };
        if blockers == Blockers::Transmissive {
            through = through + passed * opacity;
        }
        left = V3::select(L::mask(s, lanes), left.times(through), left);
        let found = L::mask(s, hits.found);
        rays.t_min = L::select(found, behind(s, &hits, rays.dir), rays.t_min);
        rays.active = found & left.x.max(left.y).max(left.z).gt(zero);
    }
    left
}
