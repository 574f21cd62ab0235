//! Color bleeding: one bounce of diffuse light between surfaces, or, with global illumination, as many as rays follow.
//!
//! It replaces the ambient light of a surface by the mean of the incoming light. Each sample takes one direction, with a
//! density proportional to the cosine: L = k_d (1/pi) integral L_i cos = k_d E[L_i]. The surfaces in these directions have
//! ambient light again, also those that are met by way of mirrors and through glass.

use super::hits::Hits;
use super::kernel::Tracer;
use super::observer::{NotFollowed, Observer};
use super::ray_packet::{RayKind, RayPacket};
use super::sampling::{Choice, child};
use crate::lanes::{Lanes, Mask, circle};
use crate::scene::effects::Effect;
use crate::shading::material::Coefficients;
use crate::trace::variants::Variant;
use std::f64::consts::PI;

/// Stacks the rays for the light that reaches diffuse surfaces.
#[inline(never)]
pub(super) fn scatter_diffuse<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    coefficients: &Coefficients<L>,
    number: u32,
) {
    L::vectorize(
        tracer.s,
        #[inline(always)]
        || scatter_diffuse_in(tracer, rays, hits, coefficients, number),
    );
}

#[inline(always)]
fn scatter_diffuse_in<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
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
        let weight = rays.weight.times(kd);
        tracer.omit_children(diffuse, weight, rays.depth + 1, false);
        if O::WATCHING {
            tracer.observer.not_followed(number, RayKind::Gathered, weight, NotFollowed::Depth);
        }
        return;
    }
    let [a, b]: [L; 2] = tracer.sampler.square(s, rays.path, Choice::ColorBleeding);
    let [x, y] = circle(s, a);
    let reach = b.sqrt();
    let [right, up] = hits.ns.across(s);
    let cosine = (one - b).max(zero).sqrt();
    let dir = right * (x * reach) + up * (y * reach) + hits.ns * cosine;
    let above = dir.dot(hits.ng).gt(zero).bits();
    let global_illumination = tracer.world.effects.has(Effect::GlobalIllumination);
    if global_illumination {
        tracer.cones.chosen(cosine * L::lit(s, 1.0 / PI));
    }
    tracer.send(RayPacket {
        origin: hits.surface.leave(hits.ng),
        dir: dir.normalized(s),
        t_min: zero,
        weight: rays.weight.times(kd),
        active: diffuse & above,
        media: rays.media,
        depth: rays.depth + 1,
        kind: RayKind::Gathered,
        straight: false,
        gathered: !global_illumination,
        path: child(rays.path, RayKind::Gathered),
        dispersed: rays.dispersed,
        parent: number,
    });
}
