//! From a description to a [`Scene`].

pub(crate) mod bodies;
pub(crate) mod build;
mod camera;
mod ceiling;
mod contact;
mod effects;
mod extent;
mod lights;
mod shared_eye;
mod textures;
mod vary;

pub use camera::camera_of;

use super::check::{check, warnings};
use super::description::{Accuracy, Description, Precision, Statistical};
use super::effects::{Effect, Entry};
use super::pictures::{Files, NoFiles, Pictures};
use super::problem::{Problems, unless_cancelled};
use super::world::{Pruning, World};
use super::{Problem, limits};
use crate::accel::{ALLOCATION, BvhKind, overlap};
use crate::bound::ceiling::Ceiling;
use crate::control::milliseconds;
use crate::lanes::Real;
use crate::shading::texture::pattern::Textures;
use std::sync::Arc;
use std::time::Instant;

/// Bytes of the rays that the pixels of a packet defer, for each ray that one pixel may defer: 16 pixels with 352 bytes each in
/// single precision, 8 with 384 in double.
const DEFERRED: u64 = 16 * 352;
/// Bytes of the lists of media of a packet's rays, as long as few of them are needed at a time.
const MEDIA: u64 = 4 << 20;

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
    named_samples: Option<u32>,
    /// Whether uneven pixels get more samples.
    pub antialias: bool,
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
    /// Most primitives that lie around one point ([`overlap`]).
    pub overlap: f64,
    /// Bytes of the pictures on its surfaces and around it.
    pub picture_bytes: usize,
    /// Whether any of them came from a file: then the same text may be another scene next time.
    pub from_files: bool,
    /// Milliseconds spent building bounding volume hierarchies and what they hold.
    pub bvh_ms: f64,
}

/// A world in either precision.
#[derive(Debug, Clone)]
pub enum Precise {
    /// 32 bits.
    Single(World<f32>),
    /// 64 bits.
    Double(World<f64>),
}

/// The objects of the JSON that items come from.
#[derive(Debug, Default)]
pub struct Sources {
    lists: Vec<String>,
    entries: Vec<Source>,
}

#[derive(Debug)]
struct Source {
    list: u32,
    index: u32,
    name: Option<Box<str>>,
}

impl Scene {
    /// Whether pixels that differ from a neighbour get [`REFINED_SAMPLES`](super::effects::REFINED_SAMPLES).
    pub fn refines(&self) -> bool {
        effects::refines(self.antialias, self.samples, self.statistical.is_some())
    }

    /// The radiance ceiling.
    pub fn ceiling(&self) -> &Ceiling {
        match &self.world {
            Precise::Single(world) => &world.ceiling,
            Precise::Double(world) => &world.ceiling,
        }
    }

    /// Whether each pixel's rays are followed until it is proved.
    pub(crate) fn proves(&self) -> bool {
        let pruning = match &self.world {
            Precise::Single(world) => world.rules.pruning,
            Precise::Double(world) => world.rules.pruning,
        };
        matches!(pruning, Pruning::Proved { .. })
    }

    /// Bytes that the rays of one thread take at most while it renders: each ray of a chain may leave another one behind, to
    /// be followed later, and the pixels of a packet may defer rays.
    pub fn stack_bytes(&self) -> u64 {
        fn of_world<R: Real>(world: &World<R>, samples: u32) -> u64 {
            let followed =
                world.reflects || world.transmits || world.angular || world.effects.has(Effect::ColorBleeding);
            let deferred = match world.rules.pruning {
                Pruning::Proved { .. } if followed => DEFERRED * u64::from(Pruning::most_deferred(samples)),
                _ => 0,
            };
            1_024 * u64::from(world.rules.max_depth) + if followed { MEDIA + deferred } else { 0 }
        }
        match &self.world {
            Precise::Single(world) => of_world(world, self.samples),
            Precise::Double(world) => of_world(world, self.samples),
        }
    }

    /// Bytes of memory it takes; almost exact.
    pub fn bytes(&self) -> usize {
        fn of_world<R: Real>(world: &World<R>) -> usize {
            let geometries: usize = world.geometries.iter().map(crate::accel::Geometry::bytes).sum();
            let textures = world.materials.iter().filter(|material| material.textures.is_some()).count();
            geometries
                + size_of_val(&world.materials[..])
                + size_of_val(&world.usage.materials[..])
                + textures * (ALLOCATION + size_of::<Textures>())
                + size_of_val(&world.lights[..])
        }
        let world = match &self.world {
            Precise::Single(world) => of_world(world),
            Precise::Double(world) => of_world(world),
        };
        let texts = |texts: &[String]| texts.iter().map(|text| ALLOCATION + text.len()).sum::<usize>();
        let entry = |entry: &Entry| size_of::<Entry>() + entry.reason.len() + texts(&entry.because);
        let effects: usize = self.effects.iter().map(entry).sum();
        let warning =
            |warning: &Problem| size_of::<Problem>() + 2 * ALLOCATION + warning.pointer.len() + warning.detail.len();
        let warnings: usize = self.warnings.iter().map(warning).sum();
        size_of::<Self>() + world + self.picture_bytes + self.sources.bytes() + effects + warnings
    }
}

/// What is said about a world.
struct Told {
    overlap: f64,
    samples: u32,
    effects: Vec<Entry>,
    warnings: Vec<Problem>,
}

fn told<R: Real>(description: &Description, world: &World<R>, built: &build::Built) -> Told {
    let samples = world.effects.samples(description.render.samples);
    let source = |item| built.sources.pointer(item);
    let facts = effects::Facts { description, world, pointers: &built.pointers, source: &source, samples };
    let overlap = overlap(&world.geometries, world.root);
    Told { overlap, samples, effects: effects::table(&facts), warnings: warnings(description, world) }
}

impl Sources {
    fn bytes(&self) -> usize {
        let lists: usize = self.lists.iter().map(|list| ALLOCATION + size_of::<String>() + list.len()).sum();
        let names = self.entries.iter().filter_map(|entry| entry.name.as_deref());
        let names: usize = names.map(|name| ALLOCATION + name.len()).sum();
        lists + size_of_val(&self.entries[..]) + names
    }

    /// JSON pointer of an item's object.
    pub fn pointer(&self, source: u32) -> String {
        let entry = &self.entries[source as usize];
        format!("{}/{}", self.lists[entry.list as usize], entry.index)
    }

    /// Name of an item's object.
    pub fn name(&self, source: u32) -> Option<&str> {
        self.entries[source as usize].name.as_deref()
    }
}

/// Options that are not part of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CompileOptions {
    /// How hierarchies are built; pictures do not depend on it.
    pub bvh: BvhKind,
    /// Follow the SPD's counting rules ([`Rules::spd_counts`](super::world::Rules::spd_counts)).
    pub spd_counts: bool,
}

/// Checks a description completely and builds the scene.
pub fn compile(description: &Description) -> Result<Scene, Problems> {
    compile_with(description, CompileOptions::default())
}

/// [`compile`], with options.
pub fn compile_with(description: &Description, options: CompileOptions) -> Result<Scene, Problems> {
    compile_from(description, options, &NoFiles)
}

/// [`compile_with`], with the files that a scene may name.
pub fn compile_from(description: &Description, options: CompileOptions, files: &dyn Files) -> Result<Scene, Problems> {
    let checked = check(description);
    unless_cancelled()?;
    let pictures = match (checked, Pictures::read(description, files)) {
        (Ok(()), Ok(pictures)) => pictures,
        (Err(problems), Ok(_)) | (Ok(()), Err(problems)) => return Err(problems),
        (Err(Problems(mut problems)), Err(Problems(mut more))) => {
            problems.append(&mut more);
            problems.truncate(limits::PROBLEMS_FOUND);
            return Err(Problems(problems));
        }
    };
    let start = Instant::now();
    let (world, built) = match description.render.precision {
        Precision::Single => {
            let (world, built) = build::build(description, options, &pictures);
            (Precise::Single(world), built)
        }
        Precision::Double => {
            let (world, built) = build::build(description, options, &pictures);
            (Precise::Double(world), built)
        }
    };
    let bvh_ms = milliseconds(start);
    unless_cancelled()?;
    if built.expanded > u128::from(limits::EXPANDED_PRIMITIVES.max) {
        let limit = limits::EXPANDED_PRIMITIVES;
        let detail = format!(
            "{:e} primitives after expanding instances are over the limit of {} ({})",
            built.expanded as f64, limit.max, limit.name
        );
        return Err(Problems::one(Problem::new("/objects", super::problem::Code::Limit, detail)));
    }
    let told = match &world {
        Precise::Single(world) => told(description, world, &built),
        Precise::Double(world) => told(description, world, &built),
    };
    Ok(Scene {
        width: description.image.width,
        height: description.image.height,
        samples: told.samples,
        named_samples: description.render.samples,
        effects: told.effects,
        antialias: description.render.antialias,
        statistical: match description.render.accuracy() {
            Accuracy::Statistical(statistical) => Some(statistical),
            _ => None,
        },
        world,
        sources: built.sources.into(),
        warnings: told.warnings,
        expanded_primitives: built.expanded as u64,
        overlap: told.overlap,
        picture_bytes: pictures.bytes(),
        from_files: pictures.from_files,
        bvh_ms,
    })
}
