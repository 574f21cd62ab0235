//! From the bytes of a file to a compiled scene, with every problem located in the text.

use super::check::{check, settings_are_sound};
use super::compile::{CompileOptions, compile_from};
use super::description::{Accuracy, Description, Precision};
use super::limits::PROBLEMS_FOUND;
use super::locate::locate;
use super::nff::{self, NffOptions};
use super::pictures::{Files, NoFiles};
use super::problem::unless_cancelled;
use super::read::{self, Mended, Unreadable, read_json};
use super::{Problem, Problems, Scene};
use crate::control::milliseconds;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::convert::Infallible;
use std::time::Instant;

/// File formats of scenes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// Scene JSON version 1.
    Json,
    /// Neutral File Format, plain or gzip.
    Nff,
}

/// Settings of the command line or a query string that replace those of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Overrides {
    /// Pixels across.
    pub width: Option<u32>,
    /// Pixels down.
    pub height: Option<u32>,
    /// Longest chain of rays.
    pub max_depth: Option<u32>,
    /// Weight below which a ray is not followed.
    pub min_weight: Option<f64>,
    /// What ends the recursion.
    pub accuracy: Option<Accuracy>,
    /// Rays for each pixel.
    pub samples: Option<u32>,
    /// Whether uneven pixels get more samples.
    pub antialias: Option<bool>,
    /// Floating-point format.
    pub precision: Option<Precision>,
    /// Options of NFF files.
    #[serde(flatten)]
    pub nff: NffOptions,
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
pub fn load_with(bytes: &[u8], format: Format, overrides: &Overrides, files: &dyn Files) -> Result<Loaded, Problems> {
    let accept = |_: &Description| Ok::<_, Infallible>(());
    load_if(bytes, format, overrides, files, accept).map_err(|NotLoaded::Problems(problems)| problems)
}

/// Why a scene is not loaded.
#[derive(Debug)]
pub enum NotLoaded<E> {
    /// It has problems.
    Problems(Problems),
    /// It has none, but is not wanted.
    Refused(E),
}

impl<E> From<Problems> for NotLoaded<E> {
    fn from(problems: Problems) -> Self {
        Self::Problems(problems)
    }
}

/// [`load_with`], if `accept` wants the scene: it is asked when the scene has been read, before anything is built.
pub fn load_if<E>(
    bytes: &[u8],
    format: Format,
    overrides: &Overrides,
    files: &dyn Files,
    accept: impl FnOnce(&Description) -> Result<(), E>,
) -> Result<Loaded, NotLoaded<E>> {
    match format {
        Format::Json => load_json(read::strip_mark(bytes), overrides, files, accept),
        Format::Nff => {
            let start = Instant::now();
            let mut description = nff::read_nff(bytes, overrides.nff)?;
            overrides.apply(&mut description);
            compiled(description, overrides, files, start, accept)
        }
    }
}

fn load_json<E>(
    text: &[u8],
    overrides: &Overrides,
    files: &dyn Files,
    accept: impl FnOnce(&Description) -> Result<(), E>,
) -> Result<Loaded, NotLoaded<E>> {
    let start = Instant::now();
    match read_json(text) {
        Ok(mut description) => {
            // A mistake in the scene is reported even where an override replaces it.
            let overrides = if settings_are_sound(&description) { *overrides } else { Overrides::default() };
            overrides.apply(&mut description);
            let of_json = Overrides { nff: NffOptions::default(), ..overrides };
            match compiled(description, &of_json, files, start, accept) {
                Ok(mut loaded) => {
                    overrides.locate(text, &mut loaded.scene.warnings);
                    Ok(loaded)
                }
                Err(NotLoaded::Problems(Problems(mut problems))) => {
                    overrides.locate(text, &mut problems);
                    Err(Problems(problems).into())
                }
                Err(refused) => Err(refused),
            }
        }
        Err(Unreadable { problems, mended }) => {
            unless_cancelled()?;
            Err(NotLoaded::Problems(match mended {
                Some(mended) => with_rest(text, problems, *mended, overrides),
                None => problems,
            }))
        }
    }
}

fn compiled<E>(
    description: Description,
    overrides: &Overrides,
    files: &dyn Files,
    start: Instant,
    accept: impl FnOnce(&Description) -> Result<(), E>,
) -> Result<Loaded, NotLoaded<E>> {
    unless_cancelled()?;
    if let Err(refused) = accept(&description) {
        // Its author should learn of its problems first.
        check(&description)?;
        return Err(NotLoaded::Refused(refused));
    }
    let parse_ms = milliseconds(start);
    unless_cancelled()?;
    let start = Instant::now();
    let nff = overrides.nff;
    let options = CompileOptions { spd_counts: nff.spd_counts, ..CompileOptions::default() };
    let scene = compile_from(&description, options, files)?;
    let plan_ms = (milliseconds(start) - scene.bvh_ms).max(0.0);
    Ok(Loaded { description, scene, nff, parse_ms, plan_ms })
}

/// Adds the problems of content to those of shape.
fn with_rest(text: &[u8], shape: Problems, mut mended: Mended, overrides: &Overrides) -> Problems {
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
    /// Replaces the settings of a description.
    pub fn apply(&self, description: &mut Description) {
        let Description { image, render, .. } = description;
        image.width = self.width.unwrap_or(image.width);
        image.height = self.height.unwrap_or(image.height);
        render.max_depth = self.max_depth.or(render.max_depth);
        render.min_weight = self.min_weight.or(render.min_weight);
        render.accuracy = self.accuracy.or(render.accuracy);
        render.samples = self.samples.or(render.samples);
        render.antialias = self.antialias.unwrap_or(render.antialias);
        render.precision = self.precision.unwrap_or(render.precision);
    }

    /// Locates problems in the text. Overrides are not in the text.
    fn locate(&self, text: &[u8], problems: &mut [Problem]) {
        locate(text, problems);
        let overrides = serde_json::to_value(self).unwrap_or_default();
        for problem in problems {
            let pointer = &problem.pointer;
            let key = pointer.strip_prefix("/image/").or_else(|| pointer.strip_prefix("/render/"));
            if key.and_then(|key| overrides.get(key)).is_some_and(|value| !value.is_null()) {
                (problem.line, problem.column) = (None, None);
            }
        }
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
