//! Directional lights with an angle, on lobes, with global illumination. A point of the disc finds wide lobes, and a ray of a narrow
//! lobe finds the disc: each counts its share of what both may find, by the balance heuristic (`sampled_light.rs`). A highlight
//! on a clearcoat would be speckled by points of the disc alone.

use super::hits::Hits;
use super::kernel::Tracer;
use super::observer::Observer;
use super::opacity::transmittance_with_holes;
use super::ray_packet::{RayKind, RayPacket};
use super::sampled_light::balance_heuristic;
use super::variants::Variant;
use crate::accel::Blockers;
use crate::lanes::{Lanes, Mask, V3};
use crate::ray::Rays;
use crate::scene::effects::Effect;
use crate::scene::world::World;
use crate::shading::light::{Arrival, Light, Place};
use crate::shading::lobe_highlights::limited;
use crate::shading::lobes::Lobes;
use std::f64::consts::PI;

/// The density of rays that a mirror sends into their only direction: nothing else may find what they do.
pub(super) const CERTAIN: f64 = 1e30;

/// Whether rays of lobes look for the light themselves. Fog would hide it from them, and does not from surfaces.
pub(super) fn is_seen<L: Lanes>(world: &World<L::Real>, light: &Light<L::Real>) -> bool {
    let is_traced = world.effects.has(Effect::GlobalIllumination) && world.rules.shadows.is_some();
    is_traced && world.fog.is_none() && light.sky_disc().is_some()
}

/// The share of the light that a ray of a lobe would see where shadow rays go, of the share that has `passed`: such rays see nothing through
/// bodies, clear as they may be, but for their holes.
#[inline(never)]
pub(super) fn lobe_ray_transmittance<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    shadow: Rays<L>,
    passed: V3<L>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
) -> V3<L> {
    L::vectorize(
        tracer.s,
        #[inline(always)]
        || {
            let (s, world) = (tracer.s, tracer.world);
            if !world.transmits || world.rules.shadows != Some(Blockers::Transmissive) {
                return passed;
            }
            let zero = L::lit(s, 0.0);
            let active = shadow.active & passed.x.max(passed.y).max(passed.z).gt(zero);
            tracer.count_shadow_rays(active.bits());
            let shadow = Rays { active, ..shadow };
            let left = transmittance_with_holes(s, world, Blockers::Holed, shadow, rays.coherence(), hits.time);
            V3::select(active, left, passed)
        },
    )
}

/// What surfaces reflect of a place of a light, of which all is `radiance`, without the share that the rays of lobes find. Of what has
/// `transmittance` they see the part that is `seen_by_lobes`; the rest counts in full.
#[inline(never)]
pub(super) fn mis_weighted<L: Lanes>(
    s: L::Simd,
    light: &Light<L::Real>,
    place: &Place<L>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    [diffuse, radiance]: [V3<L>; 2],
    lobes: &Lobes<L>,
    [transmittance, seen_by_lobes]: [V3<L>; 2],
) -> V3<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || {
            let Arrival { to_light, strength } = light.arrive(s, hits.surface.point, place);
            let (cosine, _) = lobes.faces(s, to_light, hits.ns.dot(to_light));
            let density = light.disc_pdf(s, to_light);
            let [own, over] = lobes.sampled_lobes(s, hits.ns, to_light, -rays.dir, cosine);
            let own = own.reflected * balance_heuristic(density, own.density);
            let over = over.reflected * balance_heuristic(density, over.density);
            let all = diffuse * cosine.max(L::lit(s, 0.0)) + own + over;
            let all = if rays.kind == RayKind::Camera { all } else { limited(s, all) };
            let shared = all.times(V3::splat(s, light.color)) * strength;
            // Rounding may leave a place of the rim beside the disc: then no ray finds it, and 0/0 would be its share.
            let found_by_both = L::mask(s, lobes.lanes) & density.gt(L::lit(s, 0.0));
            let (hidden, zero) = (transmittance - seen_by_lobes, L::lit(s, 0.0));
            let hidden = V3 { x: hidden.x.max(zero), y: hidden.y.max(zero), z: hidden.z.max(zero) };
            let of_both = shared.times(seen_by_lobes) + radiance.times(hidden);
            V3::select(found_by_both, of_both, radiance.times(transmittance))
        },
    )
}

impl<L: Lanes, O: Observer<L>, V: Variant> Tracer<'_, L, O, V> {
    /// Radiance of the lights that rays of lobes see, of some lanes that hit nothing.
    #[inline(never)]
    pub(super) fn distant_lights_seen(&self, rays: &RayPacket<L>, missed: u32) -> V3<L> {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                let (s, zero) = (self.s, L::lit(self.s, 0.0));
                let mut seen = V3 { x: zero, y: zero, z: zero };
                let densities = self.cones.densities();
                let chosen = densities.gt(zero) & L::mask(s, missed);
                if rays.kind != RayKind::Reflected || !chosen.any() {
                    return seen;
                }
                for light in self.world.lights.iter().filter(|light| is_seen::<L>(self.world, light)) {
                    let density = light.disc_pdf(s, rays.dir);
                    let part =
                        L::select(chosen & density.gt(zero), density * balance_heuristic(densities, density), zero);
                    // White scatters 1/pi of what arrives, and shows the color of the light.
                    seen = seen + V3::splat(s, light.color) * (part * L::lit(s, PI));
                }
                seen
            },
        )
    }
}
