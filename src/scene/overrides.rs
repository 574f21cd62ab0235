//! Settings that replace those of a scene: what a request or a command line says beside it.

use super::description::{
    Accuracy, Camera, Description, Fidelity, FilmBackground, ImageSize, PinholeCamera, Precision,
};
use super::locate::locate;
use super::model::ModelOptions;
use super::nff::NffOptions;
use super::problem::Code;
use super::recognise::{Recognised, recognise};
use super::{Problem, Problems};
use crate::film::ToneMapping;
use serde::{Deserialize, Serialize};

/// Settings of the command line or a query string that replace those of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Overrides {
    /// Pixels across.
    pub width: Option<u32>,
    /// Pixels down.
    pub height: Option<u32>,
    /// Pixels of the device for each pixel across and down, those of the scene if it has its own size.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dpr: Option<f64>,
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
    /// How light gets from everywhere to surfaces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fidelity: Option<Fidelity>,
    /// Floating-point format.
    pub precision: Option<Precision>,
    /// What the camera sees where nothing is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub background: Option<FilmBackground>,
    /// Exposure in stops.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure: Option<f64>,
    /// How light brighter than white is compressed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tone: Option<ToneMapping>,
    /// Eye and target of a pinhole camera in place of the scene's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seen_from: Option<[[f64; 3]; 2]>,
    /// Options of NFF files.
    #[serde(flatten)]
    pub nff: NffOptions,
    /// Options of models.
    #[serde(flatten)]
    pub model: ModelOptions,
}

impl Overrides {
    /// These, and those of `other` where these say nothing.
    pub fn over(self, other: &Self) -> Self {
        Self {
            width: self.width.or(other.width),
            height: self.height.or(other.height),
            dpr: self.dpr.or(other.dpr),
            max_depth: self.max_depth.or(other.max_depth),
            min_weight: self.min_weight.or(other.min_weight),
            accuracy: self.accuracy.or(other.accuracy),
            samples: self.samples.or(other.samples),
            antialias: self.antialias.or(other.antialias),
            fidelity: self.fidelity.or(other.fidelity),
            precision: self.precision.or(other.precision),
            background: self.background.or(other.background),
            exposure: self.exposure.or(other.exposure),
            tone: self.tone.or(other.tone),
            seen_from: self.seen_from.or(other.seen_from),
            nff: other.nff,
            model: other.model,
        }
    }

    /// What is left of them for variations of a scene that has them already, with this size: where the camera is may be varied, and
    /// pixels are multiplied once.
    pub fn again(self, image: ImageSize) -> Self {
        let size = self.dpr.map(|_| image);
        Self {
            width: size.map_or(self.width, |size| Some(size.width)),
            height: size.map_or(self.height, |size| Some(size.height)),
            dpr: None,
            seen_from: None,
            ..self
        }
    }

    /// The size of the picture of a scene that says `image`.
    pub(super) fn size(&self, image: ImageSize) -> ImageSize {
        let ImageSize { width, height } = image;
        let [width, height] = [self.width.unwrap_or(width), self.height.unwrap_or(height)].map(|pixels| {
            // None stays none, and what is beyond all numbers is the largest: both are refused.
            let least = f64::from(pixels.min(1));
            self.dpr.map_or(pixels, |dpr| (f64::from(pixels) * dpr).round().max(least) as u32)
        });
        ImageSize { width, height }
    }

    /// Refuses options of models for what is none; glTF in JSON is one.
    pub(super) fn refuse_model_options(&self, text: &[u8]) -> Result<(), Problems> {
        if self.model == ModelOptions::default() || recognise(text) == Recognised::Gltf {
            return Ok(());
        }
        let detail = "view, up, camera, scene, animation, t, variant, light and strict are for models; a scene says all of it itself";
        Err(Problems::one(Problem::new("", Code::Unsupported, detail)))
    }

    /// Replaces the settings of a description.
    pub fn apply(&self, description: &mut Description) {
        let Description { image, render, camera, film, .. } = description;
        if let Some([eye, look_at]) = self.seen_from {
            *camera = Camera::Pinhole(PinholeCamera::looking(eye, look_at));
        }
        *image = self.size(*image);
        render.max_depth = self.max_depth.or(render.max_depth);
        render.min_weight = self.min_weight.or(render.min_weight);
        render.accuracy = self.accuracy.or(render.accuracy);
        render.samples = self.samples.or(render.samples);
        render.antialias = self.antialias.unwrap_or(render.antialias);
        render.fidelity = self.fidelity.unwrap_or(render.fidelity);
        render.precision = self.precision.unwrap_or(render.precision);
        film.background = self.background.unwrap_or(film.background);
        film.exposure = self.exposure.unwrap_or(film.exposure);
        film.tone = self.tone.unwrap_or(film.tone);
    }

    /// Locates problems in the text. Overrides are not in the text.
    pub(super) fn locate(&self, text: &[u8], problems: &mut [Problem]) {
        locate(text, problems);
        let overrides = serde_json::to_value(self).unwrap_or_default();
        for problem in problems {
            let pointer = &problem.pointer;
            let key = ["/image/", "/render/", "/film/"].iter().find_map(|part| pointer.strip_prefix(part));
            let is_camera = self.seen_from.is_some() && pointer.starts_with("/camera/");
            let is_size = self.dpr.is_some() && pointer.starts_with("/image")
                || (self.width.is_some() || self.height.is_some()) && pointer == "/image";
            if is_camera || is_size || key.and_then(|key| overrides.get(key)).is_some_and(|value| !value.is_null()) {
                (problem.line, problem.column) = (None, None);
            }
        }
    }
}
