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
mod light_from_around;
mod lights;
mod materials;
mod memory;
mod occluded;
mod pbr;
mod precise;
mod prune;
mod scene;
mod scene_edits;
mod shared_eye;
mod sources;
mod surroundings;
mod textures;

pub use camera::camera_of;
pub use known::Original;
pub use precise::Precise;
pub(crate) use precise::with_world;
pub use scene::Scene;
pub(crate) use scene_edits::LEAST_SHARE;
use sources::Source;
pub use sources::Sources;

use super::check::{check, check_around_bodies, keep_true, warnings};
use super::description::{Accuracy, Description, Precision};
use super::effects::Entry;
use super::files::{Files, NoFiles};
use super::pictures::{self, Pictures};
use super::problem::{Problems, unless_cancelled};
use super::world::World;
use super::{Problem, limits};
use crate::accel::{BvhKind, overlap};
use crate::control::milliseconds;
use crate::lanes::Real;
use std::time::Instant;

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
    let facts = with_world!(&world, |world| scene_facts(description, world, &built, warnings, original));
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
