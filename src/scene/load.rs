//! From the bytes of a file to a compiled scene, with every problem located in the text.

use super::assets;
use super::check::{check, settings_are_sound, warnings};
use super::compile::{CompileOptions, Original, build_from, checked};
use super::description::Description;
use super::files::{Files, NoFiles};
use super::limits::PROBLEMS_FOUND;
use super::model::{self, Views, read_models};
use super::nff::{self, NffOptions};
use super::overrides::Overrides;
use super::pictures::{Pictures, named};
use super::problem::unless_cancelled;
use super::read::{self, Mended, Unreadable, read_json};
use super::recognise::{Recognised, recognise, recognise_start};
use super::{Problem, Problems, Scene};
use crate::control::milliseconds;
use crate::models::ModelFormat;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Instant;

/// File formats of scenes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// Scene JSON version 1.
    Json,
    /// Neutral File Format, plain or gzip.
    Nff,
    /// glTF 2.0, binary or JSON.
    Gltf,
    /// Wavefront OBJ.
    Obj,
    /// STL.
    Stl,
    /// PLY.
    Ply,
    /// A model in several parts, as a `multipart/form-data` body.
    Parts,
}

impl Format {
    /// Whether it is one of models, in one file or in several parts.
    pub fn is_model(self) -> bool {
        self.model().is_some() || self == Self::Parts
    }

    /// The format of a model in one file.
    pub fn model(self) -> Option<ModelFormat> {
        match self {
            Self::Gltf => Some(ModelFormat::Gltf),
            Self::Obj => Some(ModelFormat::Obj),
            Self::Stl => Some(ModelFormat::Stl),
            Self::Ply => Some(ModelFormat::Ply),
            Self::Json | Self::Nff | Self::Parts => None,
        }
    }
}

/// A loaded scene, and how long loading took.
#[derive(Debug)]
pub struct Loaded {
    /// What the file said, with the overrides.
    pub description: Description,
    /// The scene.
    pub scene: Scene,
    /// The options that an NFF file was read with.
    pub nff: NffOptions,
    /// How a model is seen again.
    pub views: Option<Arc<Views>>,
    /// Milliseconds spent reading.
    pub parse_ms: f64,
    /// Milliseconds spent checking and compiling, without building hierarchies.
    pub plan_ms: f64,
}

/// Reads, checks and compiles a scene; all problems are reported at once. Files that it names are not read.
pub fn load(bytes: &[u8], format: Format, overrides: &Overrides) -> Result<Loaded, Problems> {
    load_with(bytes, format, overrides, &NoFiles)
}

/// [`load`], with the files that a scene may name.
pub fn load_with(
    text: impl AsRef<[u8]>,
    format: Format,
    overrides: &Overrides,
    files: &dyn Files,
) -> Result<Loaded, Problems> {
    load_if(text, format, overrides, files, &|_| Ok::<_, Infallible>(()))
        .map_err(|NotLoaded::Problems(problems)| problems)
}

/// Why a scene is not loaded.
#[derive(Debug)]
pub enum NotLoaded<E> {
    /// It has problems.
    Problems(Problems),
    /// It has none, but is not wanted.
    Refused(E),
}

impl<E> NotLoaded<E> {
    /// The same with other problems.
    fn with(self, change: impl FnOnce(Problems) -> Problems) -> Self {
        match self {
            Self::Problems(problems) => Self::Problems(change(problems)),
            refused => refused,
        }
    }
}

impl<E> From<Problems> for NotLoaded<E> {
    fn from(problems: Problems) -> Self {
        Self::Problems(problems)
    }
}

/// Refuses a scene that was read and is not built yet.
pub type Accept<'a, E> = &'a dyn Fn(&Description) -> Result<(), E>;

/// A text that may be dropped while its scene is built.
type Text<'a> = Box<dyn AsRef<[u8]> + 'a>;

/// [`load_with`], if `accept` wants the scene: it is asked when the scene has been read, before anything is built. A text that is
/// given away is dropped by then, if nothing can be wrong with the scene any more.
pub fn load_if<E>(
    text: impl AsRef<[u8]>,
    format: Format,
    overrides: &Overrides,
    files: &dyn Files,
    accept: Accept<'_, E>,
) -> Result<Loaded, NotLoaded<E>> {
    load_text(Box::new(text), format, overrides, files, accept)
}

/// The same for texts of all kinds.
fn load_text<E>(
    text: Text<'_>,
    format: Format,
    overrides: &Overrides,
    files: &dyn Files,
    accept: Accept<'_, E>,
) -> Result<Loaded, NotLoaded<E>> {
    if matches!(format, Format::Json | Format::Nff) {
        overrides.refuse_model_options((*text).as_ref())?;
    }
    match format {
        Format::Gltf | Format::Obj | Format::Stl | Format::Ply | Format::Parts => {
            load_model(text, format.model(), overrides, files, accept)
        }
        Format::Json => match recognise_start((*text).as_ref()).refused_as(format) {
            Some(problem) => Err(Problems::one(problem).into()),
            None => load_json(text, overrides, files, accept),
        },
        Format::Nff => {
            let start = Instant::now();
            let mut description = nff::read_nff((*text).as_ref(), overrides.nff)?;
            drop(text);
            overrides.apply(&mut description);
            let steps = Steps::read(start);
            let (pictures, warnings) = steps.checked(&description, files, accept, None)?;
            let scene = steps.build(&description, overrides.nff, pictures, warnings, None)?;
            Ok(steps.loaded(description, scene, overrides.nff, Vec::new()))
        }
    }
}

/// Loads a model; without a kind it is in several parts.
fn load_model<E>(
    bytes: Text<'_>,
    kind: Option<ModelFormat>,
    overrides: &Overrides,
    files: &dyn Files,
    accept: Accept<'_, E>,
) -> Result<Loaded, NotLoaded<E>> {
    let start = Instant::now();
    let imported = match kind {
        Some(kind) => model::import(kind, (*bytes).as_ref(), overrides, files)?,
        None => model::import_parts((*bytes).as_ref(), overrides, files)?,
    };
    let model::Imported { mut description, from_files, views, pictures: names } = imported;
    overrides.apply(&mut description);
    let steps = Steps::read(start);
    let checked = steps.checked(&description, files, accept, None);
    let in_file = |problems| model::located(kind, (*bytes).as_ref(), named(&description, &names, problems, false));
    let (mut pictures, warnings) = checked.map_err(|error| error.with(in_file))?;
    drop(bytes);
    pictures.from_files |= from_files;
    let scene = steps.build(&description, NffOptions::default(), pictures, warnings, None)?;
    let loaded = steps.loaded(description, scene, NffOptions::default(), Vec::new());
    Ok(Loaded { views: Some(views.into()), ..loaded })
}

/// Reads the models that a scene places. Returns the SHA-256 of each asset that it names.
pub(super) fn prepare(description: &mut Description, files: &dyn Files) -> Result<Vec<String>, Problems> {
    let found = assets::found(description, files).and_then(|found| {
        read_models(description, files)?;
        Ok(found)
    });
    found.map_err(|Problems(mut problems)| {
        if let Err(Problems(mut more)) = check(description) {
            problems.append(&mut more);
            problems.truncate(PROBLEMS_FOUND);
        }
        Problems(problems)
    })
}

/// An error with pointers into the text of the scene, which has models.
pub(super) fn meant<E>(description: &Description, error: NotLoaded<E>) -> NotLoaded<E> {
    let Some(models) = description.models.get() else { return error };
    error.with(|problems| {
        let Problems(mut problems) = named(&description.whole(), &models.pictures, problems, true);
        for problem in &mut problems {
            models.place(&mut problem.pointer);
            models.remove_prefixes(&mut problem.detail);
        }
        Problems(problems).each_once()
    })
}

fn load_json<E>(
    text: Text<'_>,
    overrides: &Overrides,
    files: &dyn Files,
    accept: Accept<'_, E>,
) -> Result<Loaded, NotLoaded<E>> {
    let start = Instant::now();
    let json = read::strip_mark((*text).as_ref());
    match read_json(json) {
        Ok(mut description) => {
            // A mistake in the scene is reported even where an override replaces it.
            let overrides = if settings_are_sound(&description) { *overrides } else { Overrides::default() };
            overrides.apply(&mut description);
            let steps = Steps::read(start);
            let known = if description.lacks_models() { files.known(&description) } else { None };
            let known = known.as_ref().and_then(|known| known.kept());
            let known = known.filter(|(known, _)| description.takes_objects_of(known));
            let prepared = prepare(&mut description, files);
            let assets = prepared.map_err(|problems| overrides.located(json, NotLoaded::Problems(problems)))?;
            let whole = description.whole();
            let own = known.map(|(known, scene)| (known.whole(), scene));
            let known = own.as_ref().map(|(description, scene)| Original { description, scene });
            let checked = steps.checked(&whole, files, accept, known);
            let checked = checked.map_err(|error| overrides.located(json, meant(&description, error)));
            let (pictures, mut warnings) = checked?;
            overrides.locate(json, &mut warnings);
            warnings.splice(0..0, description.warnings_of_models());
            // Only definitions can still become too large, when they are expanded.
            let text = (!whole.definitions.is_empty()).then_some(text);
            let built = steps.build(&whole, NffOptions::default(), pictures, warnings, known);
            let scene = built.map_err(|problems| {
                let json = text.as_ref().map_or(&[][..], |text| read::strip_mark((**text).as_ref()));
                overrides.located(json, meant(&description, NotLoaded::Problems(problems)))
            })?;
            drop(whole);
            Ok(steps.loaded(description, scene, NffOptions::default(), assets))
        }
        Err(Unreadable { problems, mended }) => {
            unless_cancelled()?;
            // Only what is no scene is looked through for glTF.
            match recognise(json) {
                Recognised::Gltf => return load_model(text, Some(ModelFormat::Gltf), overrides, files, accept),
                other => {
                    if let Some(problem) = other.refused_as(Format::Json) {
                        return Err(Problems::one(problem).into());
                    }
                }
            }
            Err(NotLoaded::Problems(match mended {
                Some(mended) => with_rest(json, problems, *mended, overrides),
                None => problems,
            }))
        }
    }
}

/// The steps from a description to a scene, and when they began.
pub(in crate::scene) struct Steps {
    parse_ms: f64,
    start: Instant,
}

impl Steps {
    /// A description was read, which began at `start`.
    pub(in crate::scene) fn read(start: Instant) -> Self {
        Self { parse_ms: milliseconds(start), start: Instant::now() }
    }

    /// Checks a description, and reads the pictures that it names. Returns them, and warnings. What has the bodies of
    /// `original` is checked around them.
    pub(in crate::scene) fn checked<'a, E>(
        &self,
        description: &'a Description,
        files: &dyn Files,
        accept: Accept<'_, E>,
        original: Option<Original<'a>>,
    ) -> Result<(Pictures, Vec<Problem>), NotLoaded<E>> {
        unless_cancelled()?;
        if let Err(refused) = accept(description) {
            // Its author should learn of its problems first.
            check(description)?;
            return Err(NotLoaded::Refused(refused));
        }
        let same_bodies = original.filter(|original| original.has_bodies_of(description));
        let pictures = checked(description, files, original)?;
        Ok((pictures, warnings(description, same_bodies.map(|original| &original.scene.warnings[..]))))
    }

    /// Builds the scene of a checked description, in the geometry of `original` if it has its objects.
    pub(in crate::scene) fn build(
        &self,
        description: &Description,
        nff: NffOptions,
        pictures: Pictures,
        warnings: Vec<Problem>,
        original: Option<Original<'_>>,
    ) -> Result<Scene, Problems> {
        let original = original.filter(|original| original.has_objects_of(description));
        let options = CompileOptions { spd_counts: nff.spd_counts, ..CompileOptions::default() };
        build_from(description, options, &pictures, warnings, original)
    }

    /// A scene that was built of what `description` says, with the assets that it names.
    pub(in crate::scene) fn loaded(
        &self,
        description: Description,
        mut scene: Scene,
        nff: NffOptions,
        assets: Vec<String>,
    ) -> Loaded {
        if let Some(models) = description.models.get() {
            scene.place(models);
            scene.from_files |= models.from_files;
        }
        scene.assets = assets;
        let plan_ms = (milliseconds(self.start) - scene.bvh_ms).max(0.0);
        Loaded { description, scene, nff, views: None, parse_ms: self.parse_ms, plan_ms }
    }
}

/// Adds the problems of content to those of shape.
pub(super) fn with_rest(text: &[u8], shape: Problems, mut mended: Mended, overrides: &Overrides) -> Problems {
    let Problems(mut problems) = shape;
    if problems.len() >= PROBLEMS_FOUND {
        return Problems(problems);
    }
    overrides.apply(&mut mended.description);
    if let Err(Problems(mut rest)) = check(&mended.description) {
        rest.retain(|problem| {
            !mended.is_ours(problem) && problems.iter().all(|known| known.pointer != problem.pointer)
        });
        overrides.locate(text, &mut rest);
        problems.append(&mut rest);
        problems.sort_by_key(|problem| (problem.line, problem.column));
        problems.truncate(PROBLEMS_FOUND);
    }
    Problems(problems)
}

impl Overrides {
    /// The same with its problems located in the text.
    fn located<E>(&self, text: &[u8], error: NotLoaded<E>) -> NotLoaded<E> {
        error.with(|Problems(mut problems)| {
            self.locate(text, &mut problems);
            Problems(problems)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::problem::Code;
    use super::*;

    const SCENE: &str = r#"{
  "version": 1,
  "image": { "width": 0 },
  "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
  "materials": { "red": { "diffus": 1 }, "blue": { "ior": true } },
  "objects": [
    { "sphere": { "center": [0, 0, 0] } },
    { "sphere": { "center": [0, 0, 0], "radius": 1, "material": "green" } }
  ]
}"#;

    fn mended() -> Mended {
        *read_json(SCENE.as_bytes()).unwrap_err().mended.unwrap()
    }

    #[test]
    fn mistakes_count_even_where_they_are_overridden() {
        let camera = r#"{ "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } }"#;
        let ball = r#"{ "sphere": { "center": [0, 0, 0], "radius": 1 } }"#;
        let text =
            format!(r#"{{ "version": 1, "camera": {camera}, "objects": [{ball}], "render": {{ "samples": 0 }} }}"#);
        let overrides = Overrides { samples: Some(4), ..Overrides::default() };
        let Problems(problems) = load(text.as_bytes(), Format::Json, &overrides).unwrap_err();
        assert_eq!((problems[0].pointer.as_str(), problems[0].line), ("/render/samples", Some(1)));
    }

    #[test]
    fn broken_parts_keep_their_places() {
        let Mended { description, .. } = mended();
        assert_eq!(description.objects.len(), 2);
        assert_eq!(description.materials.len(), 2);
        assert_eq!(description.image.width, 0);
    }

    #[test]
    fn what_stands_in_is_not_reported() {
        let mended = mended();
        let problem = |pointer: &str| Problem::new(pointer, Code::OutOfRange, "");
        assert!(mended.is_ours(&problem("/objects/0/sphere/radius")));
        assert!(mended.is_ours(&problem("/materials/blue")));
        assert!(!mended.is_ours(&problem("/objects/1/sphere/material")));
        // Only the unknown key went.
        assert!(!mended.is_ours(&problem("/materials/red")));
        assert!(!mended.is_ours(&problem("/materials/blue2")));
    }

    #[test]
    fn overridden_keys_have_no_line() {
        let overrides = Overrides { width: Some(0), ..Overrides::default() };
        let mut problems =
            [Problem::new("/image/width", Code::OutOfRange, ""), Problem::new("/image/height", Code::OutOfRange, "")];
        overrides.locate(SCENE.as_bytes(), &mut problems);
        assert_eq!(problems[0].line, None);
        assert_eq!((problems[1].line, problems[1].column), (Some(3), Some(12)));
    }

    #[test]
    fn problems_come_in_the_order_of_the_text() {
        let Problems(problems) = load(SCENE.as_bytes(), Format::Json, &Overrides::default()).unwrap_err();
        let shape: Vec<_> = problems.iter().filter(|p| p.code != Code::UnknownReference).collect();
        let pointers: Vec<_> = shape.iter().map(|p| p.pointer.as_str()).collect();
        assert_eq!(pointers, ["/image/width", "/materials/red/diffus", "/materials/blue/ior", "/objects/0/sphere"]);
        assert!(problems.is_sorted_by_key(|p| (p.line, p.column)));
    }
}
