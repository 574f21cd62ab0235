//! Directional lights with an angle, on lobes, where light is traced. A point of the disc finds wide lobes, and a ray of a narrow
//! lobe finds the disc: each counts its share of what both may find, by the balance heuristic (`sampled_light.rs`). A highlight
//! on a clearcoat would be speckled by points of the disc alone.

use super::hits::Hits;
use super::kernel::Tracer;
use super::observer::Observer;
use super::ray_packet::{RayKind, RayPacket};
use super::sampled_light::balance_heuristic;
use super::variants::Variant;
use crate::lanes::{Lanes, Mask, V3};
use crate::scene::effects::Effect;
use crate::scene::world::World;
use crate::shading::light::{Arrival, Light, Place};
use crate::shading::lobes::{Lobes, limited};
use std::f64::consts::PI;

/// The density of rays that a mirror sends into their only direction: nothing else may find what they do.
pub(super) const CERTAIN: f64 = 1e30;

/// Whether rays of lobes look for the light themselves.
pub(super) fn is_seen<L: Lanes>(world: &World<L::Real>, light: &Light<L::Real>) -> bool {
    world.effects.has(Effect::GlobalIllumination) && world.rules.shadows.is_some() && light.sky_disc().is_some()
}

/// What surfaces reflect of a place of a light, of which all is `radiance`, without the share that the rays of lobes find. These see
/// no light through bodies, so where not all of it has `passed`, all of it counts.
#[inline(never)]
pub(super) fn mis_weighted<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    light: &Light<L::Real>,
    place: &Place<L>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    [diffuse, radiance, passed]: [V3<L>; 3],
    lobes: &Lobes<L>,
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
            let one = L::lit(s, 1.0);
            // Rounding may leave a place of the rim beside the disc: then no ray finds it, and 0/0 would be its share.
            let mut found_by_both = L::mask(s, lobes.lanes) & density.gt(L::lit(s, 0.0));
            if world.transmits && !world.effects.has(Effect::Opacity) {
                found_by_both = found_by_both & passed.x.ge(one) & passed.y.ge(one) & passed.z.ge(one);
            }
            V3::select(found_by_both, shared, radiance)
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
