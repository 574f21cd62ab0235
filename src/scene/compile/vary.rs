//! Changes the settings of a built scene, for comparing settings without building it again.

use super::camera::camera_of;
use super::{Precise, Scene};
use crate::camera::Basis;
use crate::lanes::Real;
use crate::scene::description;
use crate::scene::world::{ENDLESS, Pruning, World};

impl Scene {
    /// Sets what ends the recursion. What the scene calls for stays as it was built, so it must have been built with a
    /// `max_depth` of at least 2 if it is to have one.
    pub fn set_recursion(&mut self, max_depth: u32, min_weight: f64) {
        self.set_rules(max_depth, Pruning::Weight(min_weight));
    }

    /// Follows each pixel's rays until it is proved to be at most `max_codes` off.
    pub fn set_proved(&mut self, max_codes: u8) {
        let depth = self.ceiling().reach.max_depth.unwrap_or(ENDLESS);
        self.set_rules(depth, Pruning::Proved { max_codes });
    }

    fn set_rules(&mut self, max_depth: u32, pruning: Pruning) {
        fn set<R: Real>(world: &mut World<R>, max_depth: u32, pruning: Pruning) {
            (world.rules.max_depth, world.rules.pruning) = (max_depth, pruning);
        }
        match &mut self.world {
            Precise::Single(world) => set(world, max_depth, pruning),
            Precise::Double(world) => set(world, max_depth, pruning),
        }
    }

    /// Sets the size of the picture. `camera` is the one that the scene was built with. Both sides are at least 1 and within
    /// the limits.
    pub fn set_size(&mut self, camera: &description::Camera, width: u32, height: u32) {
        let Some(basis) = Basis::new(&camera.view()) else { return };
        (self.width, self.height) = (width, height);
        match &mut self.world {
            Precise::Single(world) => world.camera = camera_of(camera, &basis, width, height),
            Precise::Double(world) => world.camera = camera_of(camera, &basis, width, height),
        }
    }
}
