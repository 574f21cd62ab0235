//! A built scene with other settings, without building it again: what comparing settings takes.

use super::{Precise, Scene};
use crate::camera::{Basis, Camera};
use crate::lanes::Real;
use crate::scene::description;
use crate::scene::world::{Pruning, World};

impl Scene {
    /// Sets what ends the recursion. What the scene calls for stays as it was built, so it must have been built with a
    /// `max_depth` of at least 2 if it is to have one.
    pub fn set_recursion(&mut self, max_depth: u32, min_weight: f64) {
        fn set<R: Real>(world: &mut World<R>, max_depth: u32, min_weight: f64) {
            world.rules.max_depth = max_depth;
            world.rules.pruning = Pruning::Weight(min_weight);
        }
        match &mut self.world {
            Precise::Single(world) => set(world, max_depth, min_weight),
            Precise::Double(world) => set(world, max_depth, min_weight),
        }
    }

    /// Sets the size of the picture that its camera takes, which is the one it was built with. Both are at least 1 and
    /// within the limits.
    pub fn set_size(&mut self, camera: &description::Camera, width: u32, height: u32) {
        let Some(basis) = Basis::new(&camera.view()) else { return };
        (self.width, self.height) = (width, height);
        match &mut self.world {
            Precise::Single(world) => world.camera = Camera::new(camera, &basis, width, height),
            Precise::Double(world) => world.camera = Camera::new(camera, &basis, width, height),
        }
    }
}
