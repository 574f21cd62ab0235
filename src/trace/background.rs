//! What rays see that hit nothing.

use super::kernel::Tracer;
use super::observer::Observer;
use super::ray_cones::around;
use super::ray_packet::RayPacket;
use super::sampled_light::environment_mis_weight;
use super::variants::Variant;
use crate::lanes::{Lanes, V3};
use crate::scene::effects::Effect;

impl<L: Lanes, O: Observer<L>, V: Variant> Tracer<'_, L, O, V> {
    /// What rays bring that hit nothing, with their own light.
    #[inline(always)]
    pub(super) fn background(&mut self, rays: &RayPacket<L>, missed: u32, own: V3<L>) -> V3<L> {
        let background = if rays.straight && self.is_transparent() {
            self.see_through(missed, rays.weight)
        } else {
            rays.weight.times(self.surroundings(rays, missed))
        };
        let background = self.bounded(if V::DETAILS { own + background } else { background });
        if V::DETAILS && self.world.effects.has(Effect::GlobalIllumination) {
            return self.bounded(background + rays.weight.times(self.distant_lights_seen(rays, missed)));
        }
        background
    }

    /// Radiance of the surroundings, for rays of some lanes that hit nothing.
    #[inline(always)]
    fn surroundings(&self, rays: &RayPacket<L>, missed: u32) -> V3<L> {
        if V::DETAILS
            && let Some(environment) = &self.world.environment
        {
            let seen = around(self.s, environment, rays.dir, missed, self.cones.spreads());
            if self.world.effects.has(Effect::EnvironmentSampling)
                && let Some(bright) = &self.world.bright_directions
            {
                let densities = self.cones.densities();
                return seen * environment_mis_weight(self.s, bright, rays.dir, densities, missed);
            }
            return seen;
        }
        V3::splat(self.s, self.world.background)
    }
}
