//! Models of other programs as scenes: [`crate::models`] reads them, and what they leave open is decided here and written into the
//! [`Description`], so that every default can be seen and changed.

mod bodies;
mod framing;
mod lamps;
mod look;
mod problems;
mod studio;
mod view;

pub use view::View;

use super::description::{self as d, Camera, Description, FilmBackground, ImageSize};
use super::problem::{Code, Problem, unless_cancelled};
use super::{Files, Overrides, Problems};
use crate::film::ToneMapping;
use crate::models::{self, Choice, Model, ModelFormat, Up, parts};
use glam::DMat4;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Pixels across and down where a request does not say.
const SIDE: u32 = 512;

/// What a request says about a model.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ModelOptions {
    /// From where it is seen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<View>,
    /// Which axis of it is up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<UpAxis>,
    /// Which of its cameras sees it, in place of `view`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<u32>,
    /// Which of its scenes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scene: Option<u32>,
    /// Which of its animations is played.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub animation: Option<u32>,
    /// Seconds since the start of the animation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub t: Option<f64>,
    /// Which of its variants of materials.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub variant: Option<u32>,
    /// Which lights shine on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light: Option<LightChoice>,
    /// Whether what cannot be simulated is refused, where the file requires it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strict: Option<bool>,
}

/// An axis that is up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum UpAxis {
    Y,
    Z,
}

/// Lights on a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum LightChoice {
    /// Those of the file if it has any, else the studio's.
    #[default]
    Auto,
    /// The studio's.
    Studio,
    /// Those of the file only.
    File,
}

impl ModelOptions {
    /// Nothing.
    pub const NONE: Self = Self {
        view: None,
        up: None,
        camera: None,
        scene: None,
        animation: None,
        t: None,
        variant: None,
        light: None,
        strict: None,
    };

    fn choice(&self) -> Choice {
        Choice {
            scene: self.scene,
            animation: self.animation.or(self.t.map(|_| 0)),
            seconds: self.t.unwrap_or(0.0),
            variant: self.variant,
            strict: self.strict.unwrap_or(false),
        }
    }
}

/// A model as a scene.
#[derive(Debug)]
pub struct Imported {
    /// The scene.
    pub description: Description,
    /// What of the model is approximated or left out.
    pub warnings: Vec<Problem>,
    /// Whether it has parts that were files, whose content may change.
    pub from_files: bool,
}

/// Reads a model, and a body of parts that holds one.
pub fn import(
    format: ModelFormat,
    bytes: &[u8],
    overrides: &Overrides,
    files: &dyn Files,
) -> Result<Imported, Problems> {
    let from_files = |name: &str| files.read(name);
    let model = read(format, bytes, &from_files, &overrides.model)?;
    let imported = described(model, overrides)?;
    Ok(imported)
}

/// The same of a `multipart/form-data` body.
pub fn import_parts(bytes: &[u8], overrides: &Overrides) -> Result<Imported, Problems> {
    let wrong = |why: String| Problems::one(Problem::new("", Code::InvalidModel, why));
    let all = parts::split(bytes).map_err(wrong)?;
    let file = parts::model_of(&all).ok_or_else(|| wrong("the body has no parts".into()))?;
    let format = super::recognise::model_format(file.bytes, Some(file.name)).ok_or_else(|| {
        wrong(format!(
            "the part {:?} is no model: name one .gltf, .glb, .obj, .stl or .ply",
            super::problem::quoted(file.name)
        ))
    })?;
    let from_parts = |name: &str| {
        let part = all.iter().find(|part| part.name == name);
        part.map(|part| part.bytes.to_vec()).ok_or_else(|| "is none of the parts of the request".to_owned())
    };
    let model = read(format, file.bytes, &from_parts, &overrides.model)?;
    let imported = described(model, overrides)?;
    // The parts are of this request, and never change.
    Ok(Imported { from_files: false, ..imported })
}

fn read(
    format: ModelFormat,
    bytes: &[u8],
    parts: &models::Parts<'_>,
    options: &ModelOptions,
) -> Result<Model, Problems> {
    let model = models::read(format, bytes, parts, options.choice());
    let model = model.map_err(|faults| problems::located(format, bytes, faults))?;
    unless_cancelled()?;
    Ok(model)
}

/// The scene of a model.
fn described(mut model: Model, overrides: &Overrides) -> Result<Imported, Problems> {
    let options = &overrides.model;
    let is_z_up = match options.up {
        Some(up) => {
            model.warnings.retain(|warning| !warning.what.starts_with("up-"));
            up == UpAxis::Z
        }
        None => model.up == Up::Z,
    };
    if is_z_up {
        turn_up(&mut model);
    }
    let image = ImageSize { width: overrides.width.unwrap_or(SIDE), height: overrides.height.unwrap_or(SIDE) };
    let aspect = f64::from(image.width.max(1)) / f64::from(image.height.max(1));
    let camera = camera(&model, options, aspect)?;
    let floor = studio::floor(&model);
    let fidelity = overrides.fidelity.unwrap_or_default();
    let lit_by = lamps::lights(&mut model, options, &camera, fidelity);
    let mut warnings = std::mem::take(&mut model.warnings);
    let (mut materials, names) = look::materials(&mut model, fidelity, &mut warnings);
    let (definitions, mut objects) = bodies::objects(&mut model, &names);
    // From below it would be between the camera and the model.
    if let Some(floor) = floor.filter(|_| lit_by.is_studio && camera.view().eye[1] > camera.view().look_at[1]) {
        let name = look::free_name(&materials, "floor");
        materials.insert(name.clone(), studio::catcher());
        objects.push(floor(name));
    }
    let mut description = Description::new(camera, objects);
    description.name = model.name.map(|name| bodies::shortened(&name));
    description.image = image;
    description.materials = materials;
    description.definitions = definitions.into();
    description.environment = lit_by.surroundings;
    // The surroundings are all the light there is from all around.
    description.ambient = d::Color::BLACK;
    description.lights = lit_by.lights;
    description.film = d::Film {
        exposure: lit_by.exposure,
        tone: ToneMapping::KhronosPbrNeutral,
        background: FilmBackground::Transparent,
    };
    let warnings = warnings.into_iter().map(problems::of_warning).collect();
    Ok(Imported { description, warnings, from_files: model.has_parts })
}

/// Turns z up into y up; what faces -y then faces the front.
fn turn_up(model: &mut Model) {
    let turn =
        DMat4::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let placed = model.placements.iter_mut().flat_map(|placement| &mut placement.transforms);
    let cameras = model.cameras.iter_mut().map(|camera| &mut camera.placed);
    let lamps = model.lamps.iter_mut().map(|lamp| &mut lamp.placed);
    placed.chain(cameras).chain(lamps).for_each(|matrix| *matrix = turn * *matrix);
}

/// The camera that is asked for, or one that sees all of the model.
fn camera(model: &Model, options: &ModelOptions, aspect: f64) -> Result<Camera, Problems> {
    let Some(index) = options.camera else {
        return Ok(framing::framed(model, options.view.unwrap_or_default(), aspect));
    };
    match model.cameras.get(index as usize) {
        Some(camera) => Ok(framing::of_file(camera, model)),
        None => {
            let detail = format!(
                "there is no camera {index}: the file has {}, counted from 0; without camera= the whole model is seen",
                model.cameras.len()
            );
            Err(Problems::one(Problem::new("/cameras", Code::UnknownReference, detail)))
        }
    }
}
