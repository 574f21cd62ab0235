//! Surfaces that show shadows alone: light goes straight on through them, but for the share of all light that other bodies hide.
//! So a picture without a background has shadows in its alpha.

use super::hits::Hits;
use super::kernel::Tracer;
use super::lighting::{shadow_rays, shadow_transmittance};
use super::observer::Observer;
use super::ray_packet::RayPacket;
use super::sampling::Choice;
use super::variants::Variant;
use crate::lanes::{Ids, Lanes, Mask, Real, V3};
use crate::scene::effects::Effect;
use crate::scene::world::World;

/// How much of each surface is there: of those that catch shadows `shown` times the hidden share of the light, of others `opacity`.
#[inline(never)]
pub(super) fn shadow_catcher_opacity<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    opacity: L,
    shown: L,
) -> L {
    L::vectorize(
        tracer.s,
        #[inline(always)]
        || caught_in(tracer, rays, hits, opacity, shown),
    )
}

#[inline(always)]
fn caught_in<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    opacity: L,
    shown: L,
) -> L {
    let (s, world) = (tracer.s, tracer.world);
    let lanes = catchers(s, world, hits);
    let Some(blockers) = world.rules.shadows.filter(|_| lanes != 0) else { return opacity };
    let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
    let from = hits.surface.leave(hits.ng);
    // Light from around is hidden from no surface, so it brightens shadows.
    let sum = |light: V3<L>| light.x + light.y + light.z;
    let mut all = sum(V3::splat(s, world.ambient_of_catchers));
    if let Some(surroundings) = &world.surroundings {
        all = all + sum(surroundings.scattered(s, hits.ng));
    }
    let mut arrived = all;
    for (index, light) in world.lights.iter().enumerate() {
        let mut place = light.middle(s);
        if let Some(area) = &light.area {
            let chosen = tracer.sampler.square(s, rays.path, Choice::Light(index));
            place = light.place(s, area, hits.surface.point, chosen);
        }
        let arrival = light.arrive(s, hits.surface.point, &place);
        let cosine = hits.ng.dot(arrival.to_light);
        let lit = L::mask(s, lanes) & cosine.gt(zero) & arrival.strength.gt(zero);
        if !lit.any() {
            continue;
        }
        tracer.count_shadow_rays(lit.bits());
        let shadow = shadow_rays(s, &place, from, lit);
        let left = shadow_transmittance(tracer, blockers, shadow, rays, hits);
        let [red, green, blue] = light.color.map(Real::to_f64);
        let brightness = cosine * arrival.strength * L::lit(s, red + green + blue);
        let seen = sum(left) * L::lit(s, 1.0 / 3.0);
        all = L::select(lit, all + brightness, all);
        arrived = L::select(lit, arrived + brightness * seen, arrived);
    }
    let hidden = L::select(all.gt(zero), one - arrived / all, zero).max(zero).min(one);
    L::select(L::mask(s, lanes), hidden * shown * edge_fade(s, world, hits, lanes), opacity)
}

/// How much the borders of the picture, in which shadows fade, leave of them.
#[inline(always)]
fn edge_fade<L: Lanes>(s: L::Simd, world: &World<L::Real>, hits: &Hits<L>, lanes: u32) -> L {
    let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
    let Some(edges) = &world.edges else { return one };
    let inside = edges.inside(s, hits.surface.point);
    let (mut left, mut shown) = (lanes, one);
    while left != 0 {
        let (id, same) = hits.material.same_as_first(s, left);
        left &= !same;
        let Some(border) = world.materials[id as usize].pbr.as_ref().map(|pbr| 2.0 * pbr.edge_fade) else { continue };
        if border > 0.0 {
            let part = (inside / L::lit(s, border)).max(zero).min(one);
            // Slow at both ends, so that no line shows where it begins.
            let smooth = part * part * (L::lit(s, 3.0) - (part + part));
            shown = L::select(L::mask(s, same), smooth, shown);
        }
    }
    shown
}

/// The lanes that have hit what catches shadows.
#[inline(always)]
fn catchers<L: Lanes>(s: L::Simd, world: &World<L::Real>, hits: &Hits<L>) -> u32 {
    debug_assert!(world.effects.has(Effect::ShadowCatcher));
    let (mut left, mut catching) = (hits.found, 0);
    while left != 0 {
        let (id, same) = hits.material.same_as_first(s, left);
        left &= !same;
        if world.materials[id as usize].catches_shadows() {
            catching |= same;
        }
    }
    catching
}
