//! Changes the settings of a built scene, for comparing settings without building it again.

use super::camera::camera_of;
use super::effects::{remove, settle};
use super::{Precise, Scene};
use crate::camera::Basis;
use crate::lanes::Real;
use crate::scene::description;
use crate::scene::effects::Effect;
use crate::scene::world::{ENDLESS, Pruning, World};
use std::sync::Arc;

impl Scene {
    /// Sets what ends the recursion. A scene that was built with `max_depth` 1 has no wavelengths, and no bound on what its
    /// surfaces gather: it is to be built with 2 if it is to be rendered with more.
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
            // Effects of rays that leave surfaces are on only where such rays are followed.
            settle(world);
        }
        match &mut self.world {
            Precise::Single(world) => set(world, max_depth, pruning),
            Precise::Double(world) => set(world, max_depth, pruning),
        }
    }

    /// The scene without one of its effects, to see what it costs, with as many samples as it then asks for. None where the
    /// effect cannot be taken out of a built scene. Its geometry is shared, and its table of effects and its bounds stay as
    /// they were.
    pub fn without(&self, effect: Effect) -> Option<Self> {
        fn take<R: Real>(world: &World<R>, effect: Effect, named: Option<u32>) -> Option<(World<R>, u32)> {
            let mut world = world.clone();
            let samples = remove(effect, &mut world).then(|| world.effects.samples(named))?;
            Some((world, samples))
        }
        if effect == Effect::Antialiasing {
            return self.refines().then(|| Self { antialias: false, ..self.share(self.world.clone()) });
        }
        let (world, samples) = match &self.world {
            Precise::Single(world) => {
                take(world, effect, self.named_samples).map(|(world, n)| (Precise::Single(world), n))
            }
            Precise::Double(world) => {
                take(world, effect, self.named_samples).map(|(world, n)| (Precise::Double(world), n))
            }
        }?;
        Some(Self { samples, ..self.share(world) })
    }

    /// The same scene around another world.
    fn share(&self, world: Precise) -> Self {
        Self {
            world,
            sources: Arc::clone(&self.sources),
            effects: self.effects.clone(),
            warnings: self.warnings.clone(),
            ..*self
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
