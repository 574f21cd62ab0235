//! What camera rays meet first, as pictures see it: with the same rays, surfaces, textures and bumps.

use super::hits::Hits;
use super::kernel::Tracer;
use super::observer::Observer;
use super::opacity::behind;
use super::pbr::lobes_of;
use super::ray_packet::RayPacket;
use super::texturing::apply_textures;
use super::variants::Variant;
use crate::accel::{Coherence, Nearest};
use crate::lanes::{Lanes, Mask};
use crate::ray::Rays;
use crate::scene::effects::Effect;
use crate::shading::material::Coefficients;

impl<L: Lanes, O: Observer<L>, V: Variant> Tracer<'_, L, O, V> {
    /// Makes `rays` those through the points (x, y) of the picture and the middle of the lens, in the middle of the exposure.
    #[inline(always)]
    pub(crate) fn middle_rays(&mut self, x: L, y: L, active: u32, rays: &mut RayPacket<L>, hits: &mut Hits<L>) {
        let s = self.s;
        let primary = self.camera.primary(s, x, y);
        let seen = primary.seen.bits() & active;
        *rays = RayPacket { origin: primary.origin, dir: primary.dir, active: seen, depth: 1, ..RayPacket::none(s) };
        self.counts.camera += u64::from(seen.count_ones());
        hits.time = self.world.effects.has(Effect::MotionBlur).then(|| L::lit(s, 0.5));
        if V::FOOTPRINTS {
            self.cones.restart(s, 1.0);
        }
    }

    /// Finds what the rays meet next; false if all miss.
    #[inline(always)]
    pub(crate) fn first_hits(&mut self, rays: &RayPacket<L>, hits: &mut Hits<L>) -> bool {
        let s = self.s;
        hits.found = 0;
        if rays.active == 0 {
            return false;
        }
        let mut cast = Rays {
            origin: rays.origin,
            dir: rays.dir,
            t_min: rays.t_min,
            t_max: L::lit(s, f64::INFINITY),
            active: L::mask(s, rays.active),
        };
        hits.find_nearest(s, self.world, &mut cast, &Nearest::none(s), Coherence::Coherent);
        if rays.depth == 1 {
            if self.world.usage.rounded {
                hits.leave_eye(s, self.world, &cast, Coherence::Coherent);
            }
            self.counts.camera_hits += u64::from(hits.found.count_ones());
        }
        hits.found != 0
    }

    /// Lets the rays of some lanes go straight on behind what they have met, as those of pictures do.
    #[inline(always)]
    pub(crate) fn pass_on(&mut self, lanes: u32, rays: &mut RayPacket<L>, hits: &Hits<L>) {
        rays.t_min = behind(self.s, hits, rays.dir);
        rays.active = if rays.depth < self.world.rules.max_depth { lanes } else { 0 };
        rays.depth += 1;
        self.counts.transmitted += u64::from(rays.active.count_ones());
    }

    /// The coefficients of what the rays have met, and how much of it is there. Bumps tilt its normals.
    #[inline(always)]
    pub(crate) fn first_coefficients(&mut self, rays: &RayPacket<L>, hits: &mut Hits<L>) -> (Coefficients<L>, L) {
        let (s, mut coefficients, mut clearcoat) = (self.s, self.coefficients(rays, hits), hits.ns);
        let mut opacity = L::lit(s, 1.0);
        if V::DETAILS && self.world.effects.has_textures() {
            apply_textures(s, self.world, rays, self.cones.widths(), hits, &mut coefficients, &mut clearcoat);
        }
        if V::DETAILS && self.world.effects.has(Effect::MetallicRoughness) {
            let lobes = lobes_of(s, self.world, rays, self.cones.widths(), clearcoat, hits, &mut coefficients);
            if let Some(lobes) = lobes {
                opacity = L::select(L::mask(s, lobes.lanes), lobes.opacity, opacity);
            }
        }
        (coefficients, opacity)
    }
}
