//! Models of other programs as scenes: [`crate::models`] reads them, and what they leave open is decided here and written into the
//! [`Description`], so that every default can be seen and changed.

mod bodies;
mod copy_budget;
mod flat;
mod framing;
mod lamps;
mod materials;
mod origin;
mod placed;
mod placed_meshes;
mod problems;
mod scale;
mod shells;
mod studio;
mod view;
mod views;

pub(super) use placed::read_models;
pub use view::View;
pub use views::Views;

pub use super::description::UpAxis;
use super::description::{Description, PictureNames};
use super::problem::{Code, Problem, unless_cancelled};
use super::{Files, Overrides, Problems};
use crate::models::parts::Part;
use crate::models::{
    self, Choice, Model, ModelFormat, NAME_BYTES, NameOrIndex, Subject, Up, Warning, parts, shortened,
};
use copy_budget::CopyBudget;
use glam::DMat4;
use placed_meshes::Placed;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;

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
    pub animation: Option<NameOrIndex>,
    /// Seconds since the start of the animation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub t: Option<f64>,
    /// Which of its variants of materials.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub variant: Option<NameOrIndex>,
    /// Which lights shine on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light: Option<LightChoice>,
    /// Whether what cannot be simulated is refused, where the file requires it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strict: Option<bool>,
    /// Whether the camera goes around it: then it stands where all of the model is inside of the picture from each side.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub around: Option<bool>,
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
        around: None,
    };

    /// Whether an animation has such a time.
    pub fn is_time(t: f64) -> bool {
        t.is_finite() && t >= 0.0
    }

    fn choice(&self) -> Choice {
        Choice {
            scene: self.scene,
            animation: self.animation.or(self.t.map(|_| NameOrIndex::Index(0))),
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
    /// Whether it has parts that were files, whose content may change.
    pub from_files: bool,
    /// How it is seen again.
    pub views: Views,
    /// What it calls its pictures.
    pub(super) pictures: PictureNames,
}

/// Reads a model, and a body of parts that holds one.
pub fn import(
    format: ModelFormat,
    bytes: &[u8],
    overrides: &Overrides,
    files: &dyn Files,
) -> Result<Imported, Problems> {
    let beside = |name: &str| parts::exact_or_plain(name, |name| files.read(name));
    let model = read_upright(format, bytes, &beside, &overrides.model)?;
    described(model, overrides, files).map_err(|problems| problems::placed(format, bytes, problems))
}

/// The same of a `multipart/form-data` body.
pub fn import_parts(bytes: &[u8], overrides: &Overrides, files: &dyn Files) -> Result<Imported, Problems> {
    let wrong = |why: String| Problems::one(Problem::new("", Code::InvalidModel, why));
    let all = parts::split(bytes).map_err(wrong)?;
    let (file, format) = model_among(&all).map_err(wrong)?;
    let named = parts::Named::new(&all);
    let mut model = read_upright(format, file.bytes, &|name: &str| named.read(name), &overrides.model)?;
    if let Some(field) = parts::field_of(&all, &file) {
        let name = super::problem::quoted(field);
        let detail = format!("{name} is no file of the model; settings are part of the address, as in ?width=512");
        let (subject, what, pointer) = (Subject::Skipped, "form-fields", String::new());
        model.warnings.push(Warning { subject, what, detail, pointer });
    }
    let is_unused = |part: &&Part<'_>| part.is_file && part.name != file.name && !named.has_read(part.name);
    let unused: Vec<String> = all.iter().filter(is_unused).map(|part| super::problem::quoted(part.name)).collect();
    if let Some(first) = unused.first() {
        let more = if unused.len() == 1 { String::new() } else { format!(" and {} more", unused.len() - 1) };
        let detail = format!(
            "{first}{more}: the model does not name it; a scene that places models is JSON alone, and names assets"
        );
        let (subject, what, pointer) = (Subject::Skipped, "parts", String::new());
        model.warnings.push(Warning { subject, what, detail, pointer });
    }
    let imported = described(model, overrides, files);
    let imported = imported.map_err(|problems| problems::placed(format, file.bytes, problems))?;
    // The parts are of this request, and never change.
    Ok(Imported { from_files: false, ..imported })
}

/// The model among the parts of a body.
fn model_among<'a>(all: &[Part<'a>]) -> Result<(Part<'a>, ModelFormat), String> {
    let file = parts::model_of(all)?;
    let format = super::recognise::model_format(file.bytes, Some(file.name)).ok_or_else(|| {
        format!("the part {} is no model: name one .gltf, .glb, .obj, .stl or .ply", super::problem::quoted(file.name))
    })?;
    Ok((file, format))
}

/// Problems of the scene of a model, at their places in its file as far as they are known there. Without a format the file is in
/// several parts.
pub(super) fn located(format: Option<ModelFormat>, bytes: &[u8], problems: Problems) -> Problems {
    if let Some(format) = format {
        return problems::placed(format, bytes, problems);
    }
    let all = parts::split(bytes).unwrap_or_default();
    match model_among(&all) {
        Ok((file, format)) => problems::placed(format, file.bytes, problems),
        Err(_) => problems,
    }
}

/// Reads a model, and turns it so that y is up.
fn read_upright(
    format: ModelFormat,
    bytes: &[u8],
    parts: &models::Parts<'_>,
    options: &ModelOptions,
) -> Result<Model, Problems> {
    let model = models::read(format, bytes, parts, options.choice());
    let mut model = model.map_err(|faults| problems::located(format, bytes, faults))?;
    unless_cancelled()?;
    flat::set_apart(&mut model);
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
    Ok(model)
}

/// The scene of a model.
fn described(mut model: Model, overrides: &Overrides, files: &dyn Files) -> Result<Imported, Problems> {
    CopyBudget::default().take_model(&model, files, "")?;
    origin::recenter_with_warning(&mut model);
    scale::scaled_to_units(&mut model)?;
    lamps::drop_far(&mut model);
    let is_unlit = materials::is_unlit(&model);
    let read = std::mem::take(&mut model.warnings);
    let (mut of_look, of_fast) = (Vec::new(), materials::without_rays(&model));
    let (materials, names, pictures) = materials::materials(&mut model, "", &HashSet::new(), &mut of_look);
    let (definitions, objects) = bodies::objects(&mut model, &names, "");
    let bounds = Placed::of(&objects, &definitions, &materials).bounds();
    let views = Views {
        name: model.name.map(|name| shortened(&name, NAME_BYTES)),
        bodies: objects.len(),
        bounds,
        cameras: model.cameras,
        lamps: model.lamps,
        is_unlit,
        warnings: [read, of_look, of_fast],
    };
    let seen = views.seen(&objects, &definitions, &materials, overrides)?;
    let description = views.described(seen, definitions, objects, materials);
    Ok(Imported { description, from_files: model.has_parts, views, pictures })
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
