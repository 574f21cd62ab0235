//! From a description to a [`Scene`].

pub(crate) mod bodies;
pub(crate) mod build;
mod camera;
mod ceiling;
mod contact;
mod effects;
mod emitters;
mod enclosure;
mod equal_meshes;
mod extent;
mod geometries;
mod known;
mod lights;
mod materials;
mod occluded;
mod pbr;
mod prune;
mod scene_edits;
mod shared_eye;
mod surroundings;
mod textures;

pub use camera::camera_of;
pub use known::Original;
pub(crate) use scene_edits::LEAST_SHARE;

use super::check::{check, check_around_bodies, keep_true, warnings};
use super::description::{Accuracy, Description, ModelBodies, Precision, Statistical};
use super::effects::{Effect, Entry};
use super::files::{Files, NoFiles};
use super::pictures::{self, Pictures};
use super::problem::{Problems, unless_cancelled};
use super::world::{Pruning, World};
use super::{Problem, limits};
use crate::accel::{ALLOCATION, BvhKind, Geometry, overlap};
use crate::bound::ceiling::Ceiling;
use crate::control::milliseconds;
use crate::film::Display;
use crate::lanes::Real;
use crate::shading::texture::mipmap::Mipmap;
use crate::shading::texture::pattern::Textures;
use std::collections::HashMap;
use std::iter;
use std::sync::Arc;
use std::time::Instant;

/// Bytes of the rays that the samples of a batch defer, for each ray that one sample may defer: 16 samples with 356 bytes each in
/// single precision, and with 392 in double.
const DEFERRED: u64 = 16 * 392;
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
    /// Most primitives that lie around one point ([`overlap`]).
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
    /// Which of them are in the file of a model, and have the pointer of that. Empty: none.
    models: Vec<bool>,
    entries: Vec<Source>,
    /// JSON pointers of the materials.
    materials: Vec<String>,
}

#[derive(Debug)]
struct Source {
    list: u32,
    index: u32,
    name: Option<Box<str>>,
}

impl Scene {
    /// Whether pixels that differ from a neighbour get more samples.
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

    /// Whether some rays stand for others that are not followed, at random.
    pub fn plays_roulette(&self) -> bool {
        match &self.world {
            Precise::Single(world) => world.branches,
            Precise::Double(world) => world.branches,
        }
    }

    /// How light becomes colors.
    pub fn display(&self) -> &Display {
        match &self.world {
            Precise::Single(world) => &world.display,
            Precise::Double(world) => &world.display,
        }
    }

    /// Whether pictures have an alpha channel.
    pub fn is_transparent(&self) -> bool {
        match &self.world {
            Precise::Single(world) => world.transparent,
            Precise::Double(world) => world.transparent,
        }
    }

    /// What ends its chains of rays besides their length.
    pub fn pruning(&self) -> Pruning {
        match &self.world {
            Precise::Single(world) => world.rules.pruning,
            Precise::Double(world) => world.rules.pruning,
        }
    }

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
        match &self.world {
            Precise::Single(world) => of_world(world),
            Precise::Double(world) => of_world(world),
        }
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
        let geometries = match &self.world {
            Precise::Single(world) => of_world(world),
            Precise::Double(world) => of_world(world),
        };
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

/// Whether surfaces send rays for what they scatter.
fn gathers<R: Real>(world: &World<R>) -> bool {
    world.effects.has(Effect::ColorBleeding) || world.effects.has(Effect::GlobalIllumination)
}

/// What is said about a world.
struct SceneFacts {
    overlap: f64,
    samples: u32,
    adaptive: bool,
    effects: Vec<Entry>,
    warnings: Vec<Problem>,
}

/// Whether a scene leaves the number of samples to its pixels.
fn adapts<R: Real>(named: Option<u32>, is_statistical: bool, world: &World<R>) -> bool {
    named.is_none() && !is_statistical && world.effects.needs_sampling()
}

fn scene_facts<R: Real>(
    description: &Description,
    world: &World<R>,
    built: &build::Built,
    mut warnings: Vec<Problem>,
    original: Option<Original<'_>>,
) -> SceneFacts {
    let samples = world.effects.samples(description.render.samples);
    let is_statistical = matches!(description.render.accuracy(), Accuracy::Statistical(_));
    let adaptive = adapts(description.render.samples, is_statistical, world);
    let source = |item| built.sources.pointer(item);
    let facts = effects::Facts { description, world, pointers: &built.pointers, source: &source, samples, adaptive };
    let known = original.filter(|original| original.description.render.precision == description.render.precision);
    let overlap = known.map_or_else(|| overlap(&world.geometries, world.root), |known| known.scene.overlap);
    keep_true(&mut warnings, description, world);
    SceneFacts { overlap, samples, adaptive, effects: effects::table(&facts), warnings }
}

impl Scene {
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
        let reach = match &mut self.world {
            Precise::Single(world) => &mut world.ceiling.reach,
            Precise::Double(world) => &mut world.ceiling.reach,
        };
        let because = self.effects.iter_mut().flat_map(|entry| &mut entry.because).chain(&mut reach.because);
        because.for_each(|pointer| _ = models.place(pointer));
        for entry in &mut self.effects {
            entry.because.dedup();
        }
        self.warnings.iter_mut().for_each(|warning| _ = models.place(&mut warning.pointer));
        // Many materials of a model are one place of the text.
        self.warnings = Problems(std::mem::take(&mut self.warnings)).each_once().0;
    }
}

impl Sources {
    fn bytes(&self) -> usize {
        let texts = self.lists.iter().chain(&self.materials);
        let lists: usize = texts.map(|list| ALLOCATION + size_of::<String>() + list.len()).sum();
        let names = self.entries.iter().filter_map(|entry| entry.name.as_deref());
        let names: usize = names.map(|name| ALLOCATION + name.len()).sum();
        lists + size_of_val(&self.entries[..]) + names
    }

    /// JSON pointer of an item's object.
    pub fn pointer(&self, source: u32) -> String {
        let entry = &self.entries[source as usize];
        if self.models.get(entry.list as usize) == Some(&true) {
            return self.lists[entry.list as usize].clone();
        }
        format!("{}/{}", self.lists[entry.list as usize], entry.index)
    }

    /// Index in `objects` of what an item of the scene itself is, or is in: 3 of `/objects/3/group/objects/0`.
    pub fn top(&self, source: u32) -> u32 {
        let entry = &self.entries[source as usize];
        let inside = self.lists[entry.list as usize].strip_prefix("/objects/");
        let index = inside.and_then(|rest| rest.split('/').next()?.parse().ok());
        index.unwrap_or(entry.index)
    }

    /// How many `objects` the scene has.
    pub fn objects(&self) -> u32 {
        // The scene's own list is the first.
        self.entries.iter().filter(|entry| entry.list == 0).count() as u32
    }

    /// JSON pointer of a material; `default` for that of bodies which name none.
    pub fn material(&self, material: u32) -> &str {
        self.materials.get(material as usize).map_or("default", String::as_str)
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
    if description.lacks_models() {
        let detail = "the scene places models, which have to be read before";
        return Err(Problems::one(Problem::new("/objects", super::problem::Code::Unsupported, detail)));
    }
    let whole = description.whole();
    let read = checked(&whole, files, None)?;
    build_from(&whole, options, &read, warnings(&whole, None), None)
}

/// Checks a description completely, but for objects of `original`, which are known to be sound, and reads the pictures that it
/// names and that are not known.
pub(super) fn checked<'a>(
    description: &'a Description,
    files: &dyn Files,
    original: Option<Original<'a>>,
) -> Result<Pictures, Problems> {
    let has_sound_bodies = original.is_some_and(|original| original.has_bodies_of(description));
    let checked = if has_sound_bodies { check_around_bodies(description) } else { check(description) };
    unless_cancelled()?;
    let known = original.map(|original| pictures::known(original.description, &original.scene.pictures));
    match (checked, Pictures::read(description, files, known.unwrap_or_default())) {
        (Ok(()), Ok(pictures)) => Ok(pictures),
        (Err(problems), Ok(_)) | (Ok(()), Err(problems)) => Err(problems),
        (Err(Problems(mut problems)), Err(Problems(mut more))) => {
            problems.append(&mut more);
            problems.truncate(limits::PROBLEMS_FOUND);
            Err(Problems(problems))
        }
    }
}

/// Builds the scene of a checked description. Of its warnings those stay that hold for what was built. `original` is a scene
/// of the same objects.
pub(super) fn build_from(
    description: &Description,
    options: CompileOptions,
    pictures: &Pictures,
    warnings: Vec<Problem>,
    original: Option<Original<'_>>,
) -> Result<Scene, Problems> {
    let start = Instant::now();
    let precision = description.render.precision;
    let (world, built) = match precision {
        Precision::Single => {
            let known = original.and_then(|original| original.single(precision));
            let (world, built) = build::build(description, options, pictures, known);
            (Precise::Single(world), built)
        }
        Precision::Double => {
            let known = original.and_then(|original| original.double(precision));
            let (world, built) = build::build(description, options, pictures, known);
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
    let facts = match &world {
        Precise::Single(world) => scene_facts(description, world, &built, warnings, original),
        Precise::Double(world) => scene_facts(description, world, &built, warnings, original),
    };
    Ok(Scene {
        width: description.image.width,
        height: description.image.height,
        samples: facts.samples,
        adaptive: facts.adaptive,
        named_samples: description.render.samples,
        effects: facts.effects,
        antialias: description.render.antialias,
        statistical: match description.render.accuracy() {
            Accuracy::Statistical(statistical) => Some(statistical),
            _ => None,
        },
        world,
        sources: built.sources.into(),
        warnings: facts.warnings,
        expanded_primitives: built.expanded as u64,
        overlap: facts.overlap,
        picture_bytes: pictures::bytes_of(pictures.all(), &[]),
        pictures: pictures.all().to_vec(),
        assets: Vec::new(),
        from_files: pictures.from_files,
        bvh_ms,
    })
}
