//! A scene that can be rendered.

use super::{Precise, Sources, effects, with_world};
use crate::bound::ceiling::Ceiling;
use crate::film::Display;
use crate::scene::Problem;
use crate::scene::description::{ModelBodies, Statistical};
use crate::scene::effects::Entry;
use crate::scene::problem::Problems;
use crate::scene::world::Pruning;
use crate::shading::texture::mipmap::Mipmap;
use std::sync::Arc;

/// A scene that can be rendered: immutable, finite, all references resolved.
#[derive(Debug)]
pub struct Scene {
    /// Width of the picture in pixels.
    pub width: u32,
    /// Height of the picture in pixels.
    pub height: u32,
    /// Samples of each pixel.
    pub samples: u32,
    /// The number of them that its description names.
    pub(super) named_samples: Option<u32>,
    /// Whether uneven pixels get more samples.
    pub antialias: bool,
    /// Whether each pixel gets as many samples as it asks for, [`samples`](Self::samples) being what most need at most.
    pub adaptive: bool,
    /// The target that decides the samples of each pixel instead, in the statistical mode.
    pub statistical: Option<Statistical>,
    /// The world in the precision asked for.
    pub world: Precise,
    /// Where each item comes from.
    pub sources: Arc<Sources>,
    /// Its effects: which are simulated, and why.
    pub effects: Vec<Entry>,
    /// Warnings for the author.
    pub warnings: Vec<Problem>,
    /// Primitives after all instances are expanded, which never happens in memory.
    pub expanded_primitives: u64,
    /// Most primitives that lie around one point (`accel::overlap`).
    pub overlap: f64,
    /// Bytes of the pictures on its surfaces and around it.
    pub picture_bytes: usize,
    /// The pictures, in the order in which its description names them.
    pub(in crate::scene) pictures: Vec<Arc<Mipmap>>,
    /// The SHA-256 of each asset that it names.
    pub assets: Vec<String>,
    /// Whether any of them came from a file: then the same text may be another scene next time.
    pub from_files: bool,
    /// Milliseconds spent building bounding volume hierarchies and what they hold.
    pub bvh_ms: f64,
}

impl Scene {
    /// Whether pixels that differ from a neighbour get more samples.
    pub fn refines(&self) -> bool {
        effects::refines(self.antialias, self.samples, self.statistical.is_some())
    }

    /// The radiance ceiling.
    pub fn ceiling(&self) -> &Ceiling {
        with_world!(&self.world, |world| &world.ceiling)
    }

    /// Whether some rays stand for others that are not followed, at random.
    pub fn plays_roulette(&self) -> bool {
        with_world!(&self.world, |world| world.branches)
    }

    /// How light becomes colors.
    pub fn display(&self) -> &Display {
        with_world!(&self.world, |world| &world.display)
    }

    /// Whether pictures have an alpha channel.
    pub fn is_transparent(&self) -> bool {
        with_world!(&self.world, |world| world.transparent)
    }

    /// What ends its chains of rays besides their length.
    pub fn pruning(&self) -> Pruning {
        with_world!(&self.world, |world| world.rules.pruning)
    }

    /// Turns pointers into what was built into those of the text, which has models in place of instances.
    pub(in crate::scene) fn place(&mut self, models: &ModelBodies) {
        if let Some(sources) = Arc::get_mut(&mut self.sources) {
            sources.models = sources.lists.iter_mut().map(|pointer| models.place(pointer)).collect();
            for pointer in &mut sources.materials {
                match models.replaceable.get(pointer) {
                    Some(place) => pointer.clone_from(place),
                    None => _ = models.place(pointer),
                }
            }
        }
        let reach = with_world!(&mut self.world, |world| &mut world.ceiling.reach);
        let because = self.effects.iter_mut().flat_map(|entry| &mut entry.because).chain(&mut reach.because);
        because.for_each(|pointer| _ = models.place(pointer));
        for entry in &mut self.effects {
            entry.because.dedup();
            models.remove_prefixes(entry.reason.to_mut());
        }
        for warning in &mut self.warnings {
            models.place(&mut warning.pointer);
            models.remove_prefixes(&mut warning.detail);
        }
        // Many materials of a model are one place of the text.
        self.warnings = Problems(std::mem::take(&mut self.warnings)).each_once().0;
    }
}
