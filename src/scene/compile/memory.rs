//! How much memory a scene takes.

use super::{Precise, Scene, with_world};
use crate::accel::{ALLOCATION, Geometry};
use crate::lanes::Real;
use crate::scene::Problem;
use crate::scene::effects::{Effect, Entry};
use crate::scene::pictures;
use crate::scene::world::{Pruning, World};
use crate::shading::texture::pattern::Textures;
use std::collections::HashMap;
use std::iter;
use std::sync::Arc;

/// Bytes of the rays that the samples of a batch defer, for each ray that one sample may defer: 16 samples with 356 bytes each in
/// single precision, and with 392 in double.
const DEFERRED: u64 = 16 * 392;
/// Bytes of the lists of media of a packet's rays, as long as few of them are needed at a time.
const MEDIA: u64 = 4 << 20;

impl Scene {
    /// Bytes that the rays of one thread take at most while it renders: each ray of a chain may leave another one behind, to
    /// be followed later, and the pixels of a packet may defer rays.
    pub fn stack_bytes(&self) -> u64 {
        fn of_world<R: Real>(world: &World<R>) -> u64 {
            let followed = world.reflects || world.transmits || world.angular || gathers(world);
            let deferred = match world.rules.pruning {
                Pruning::Proved { .. } if followed => DEFERRED * u64::from(Pruning::MOST_DEFERRED),
                _ => 0,
            };
            1_024 * u64::from(world.rules.max_depth) + if followed { MEDIA + deferred } else { 0 }
        }
        with_world!(&self.world, |world| of_world(world))
    }

    /// Bytes of memory it takes; almost exact.
    pub fn bytes(&self) -> usize {
        fn of_world<R: Real>(world: &World<R>) -> usize {
            // Meshes in several materials share what they are.
            let mut first: HashMap<usize, &Geometry<R>> = HashMap::new();
            let mut bytes = 0;
            for geometry in world.geometries.iter() {
                bytes += match first.get(&geometry.place()) {
                    Some(known) => geometry.bytes_beside(known),
                    None => geometry.bytes(),
                };
                first.entry(geometry.place()).or_insert(geometry);
            }
            bytes
        }
        let geometries = with_world!(&self.world, |world| of_world(world));
        geometries + self.bytes_around()
    }

    /// Bytes of what it does not share with the scene that it is a variation of.
    pub fn bytes_beside(&self, original: &Self) -> usize {
        fn of_world<R: Real>(world: &World<R>, known: &World<R>) -> usize {
            if Arc::ptr_eq(&world.geometries, &known.geometries) {
                return 0;
            }
            let known = known.geometries.iter().map(Some).chain(iter::repeat(None));
            let own = |(geometry, known): (&Geometry<R>, Option<&Geometry<R>>)| {
                known.map_or_else(|| geometry.bytes(), |known| geometry.bytes_beside(known))
            };
            world.geometries.iter().zip(known).map(own).sum()
        }
        let around = self.bytes_around() - self.picture_bytes + pictures::bytes_of(&self.pictures, &original.pictures);
        match (&self.world, &original.world) {
            (Precise::Single(world), Precise::Single(known)) => around + of_world(world, known),
            (Precise::Double(world), Precise::Double(known)) => around + of_world(world, known),
            _ => self.bytes(),
        }
    }

    /// Bytes of all but its geometries.
    fn bytes_around(&self) -> usize {
        fn of_world<R: Real>(world: &World<R>) -> usize {
            let textures = world.materials.iter().filter(|material| material.textures.is_some()).count();
            let channels = world.materials.iter().filter_map(|material| material.pbr.as_deref());
            size_of_val(&world.materials[..])
                + channels.map(|pbr| 2 * ALLOCATION + pbr.bytes()).sum::<usize>()
                + size_of_val(&world.usage.materials[..])
                + textures * (ALLOCATION + size_of::<Textures>())
                + size_of_val(&world.lights[..])
                + world.surroundings.as_ref().map_or(0, |surroundings| surroundings.bytes())
                + world.bright_directions.as_ref().map_or(0, |bright| bright.bytes())
                + world.emitters.as_ref().map_or(0, |emitters| emitters.bytes())
                + world.light_cells.as_ref().map_or(0, |cells| cells.bytes())
        }
        let world = with_world!(&self.world, |world| of_world(world));
        let texts = |texts: &[String]| texts.iter().map(|text| ALLOCATION + text.len()).sum::<usize>();
        let entry = |entry: &Entry| size_of::<Entry>() + entry.reason.len() + texts(&entry.because);
        let effects: usize = self.effects.iter().map(entry).sum();
        let warning =
            |warning: &Problem| size_of::<Problem>() + 2 * ALLOCATION + warning.pointer.len() + warning.detail.len();
        let warnings: usize = self.warnings.iter().map(warning).sum();
        size_of::<Self>() + world + self.picture_bytes + self.sources.bytes() + effects + warnings
    }
}

/// Whether surfaces send rays for what they scatter.
fn gathers<R: Real>(world: &World<R>) -> bool {
    world.effects.has(Effect::ColorBleeding) || world.effects.has(Effect::GlobalIllumination)
}
