//! What views of a model differ in: camera, lights, floor and film. Its bodies and materials are the same in each, so a second
//! view is a variation of the first.

use super::framing;
use super::placed_meshes::{Placed, Sight};
use super::{ModelOptions, SIDE, lamps, materials, problems, studio};
use crate::film::ToneMapping;
use crate::models::{Lamp, ModelCamera, Projection, Subject, Warning};
use crate::scene::Overrides;
use crate::scene::description::{
    self as d, Camera, Description, Environment, Fidelity, FilmBackground, ImageSize, ImportWarning, Light, Material,
    Object,
};
use crate::scene::limits::{IMPORT_WARNINGS, MAGNITUDE, SMALLEST_LENGTH};
use crate::scene::named::Named;
use crate::scene::problem::{Code, Problem, Problems};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;

/// What is kept of a model beside its bodies and materials, so that it can be seen again.
#[derive(Debug)]
pub struct Views {
    pub(super) name: Option<String>,
    /// How many of the objects are the model's. The floor is no part of it.
    pub(in crate::scene) bodies: usize,
    /// The box around it.
    pub(super) bounds: Option<(DVec3, DVec3)>,
    pub(super) cameras: Vec<ModelCamera>,
    pub(super) lamps: Vec<Lamp>,
    /// Whether nothing of it is lit, so that its colors are shown as they are.
    pub(super) is_unlit: bool,
    /// What was said when it was read, what of its materials scenes cannot say, and what of them only rays bring.
    pub(super) warnings: [Vec<Warning>; 3],
}

/// A view.
pub(in crate::scene) struct Seen {
    camera: Camera,
    image: ImageSize,
    lights: Vec<Light>,
    environment: Option<Environment>,
    exposure: f64,
    pub(in crate::scene) has_floor: bool,
    warnings: Vec<ImportWarning>,
}

impl Views {
    /// A view of the model's bodies.
    pub(in crate::scene) fn seen(
        &self,
        objects: &[Object],
        definitions: &Named<Vec<Object>>,
        materials: &Named<Material>,
        overrides: &Overrides,
    ) -> Result<Seen, Problems> {
        let options = &overrides.model;
        let image = self.size(overrides);
        let shown = overrides.size(image);
        let placed = Placed::of(&objects[..self.bodies.min(objects.len())], definitions, materials);
        let camera = self.camera(&placed, options, shown)?;
        let [mut warnings, of_look, of_fast] = self.warnings.clone();
        if let Camera::Pinhole(camera) = &camera {
            warnings.extend(warning_of_sight(placed.sight_from(DVec3::from_array(camera.eye))));
        }
        let of_file = options.camera.and_then(|number| self.camera_of(number));
        warnings.extend(of_file.and_then(warning_of_angle));
        let fidelity = overrides.fidelity.unwrap_or_default();
        let lit_by = lamps::lights(&self.lamps, options, &camera, fidelity, &mut warnings);
        if overrides.exposure.is_none() {
            lit_by.warn_of_exposure(&mut warnings);
        }
        warnings.extend(of_look);
        let warnings = warnings.iter().map(|warning| problems::of_warning(warning, None));
        let of_fast = of_fast.iter().map(|warning| problems::of_warning(warning, Some(Fidelity::Fast)));
        // From below it would be between the camera and the model.
        let is_above = camera.view().eye[1] > camera.view().look_at[1];
        Ok(Seen {
            camera,
            image,
            lights: lit_by.lights,
            environment: lit_by.surroundings,
            exposure: lit_by.exposure,
            has_floor: self.bounds.is_some() && lit_by.is_studio && is_above,
            warnings: warnings.chain(of_fast).take(IMPORT_WARNINGS.max as usize).collect(),
        })
    }

    /// Pixels across and down: what is not asked for follows the shape of the file's camera, if one of them is used, else of a square.
    fn size(&self, overrides: &Overrides) -> ImageSize {
        let camera = overrides.model.camera.and_then(|number| self.camera_of(number));
        // A strip is no picture.
        let aspect = camera.and_then(|camera| camera.aspect).map_or(1.0, |aspect| aspect.clamp(1.0 / 16.0, 16.0));
        let scaled = |side: u32, by: f64| (f64::from(side) * by).round().max(1.0) as u32;
        let (width, height) = match (overrides.width, overrides.height) {
            (None, None) => (scaled(SIDE, aspect.min(1.0)), scaled(SIDE, (1.0 / aspect).min(1.0))),
            (Some(width), None) => (width, scaled(width, 1.0 / aspect)),
            (None, Some(height)) => (scaled(height, aspect), height),
            (Some(width), Some(height)) => (width, height),
        };
        ImageSize { width, height }
    }

    /// The first camera of the scene that has a number in the file.
    fn camera_of(&self, number: u32) -> Option<&ModelCamera> {
        self.cameras.iter().find(|camera| camera.number == number as usize)
    }

    /// The camera that is asked for, or one that sees all of the model.
    fn camera(&self, model: &Placed<'_>, options: &ModelOptions, shown: ImageSize) -> Result<Camera, Problems> {
        let width = f64::from(shown.width.max(1));
        let aspect = width / f64::from(shown.height.max(1));
        let middle = self.bounds.map_or(DVec3::ZERO, |(low, high)| (low + high) / 2.0);
        let Some(index) = options.camera else {
            let view = options.view.unwrap_or_default();
            return Ok(match self.bounds.filter(|_| options.around == Some(true)) {
                Some(bounds) => framing::framed_around(model, bounds, view, aspect),
                None => {
                    let aside = if shown.width.is_multiple_of(2) { 1.0 / width } else { 0.0 };
                    framing::framed(model, middle, view, aspect, aside)
                }
            });
        };
        match self.camera_of(index) {
            Some(camera) => {
                check(camera)?;
                Ok(framing::of_file(camera, model, middle))
            }
            None => {
                let mut numbers: Vec<usize> = self.cameras.iter().map(|camera| camera.number).collect();
                numbers.sort_unstable();
                numbers.dedup();
                let numbers: Vec<String> = numbers.iter().take(20).map(usize::to_string).collect();
                let there = if numbers.is_empty() { "none".to_owned() } else { numbers.join(", ") };
                let detail = format!(
                    "there is no camera {index} in the scene, of those in /cameras it has {there}; without camera= the whole model is seen"
                );
                Err(Problems::one(Problem::new("/cameras", Code::UnknownReference, detail)))
            }
        }
    }

    /// The model in that view, with its materials.
    pub(super) fn described(
        &self,
        seen: Seen,
        definitions: Named<Vec<Object>>,
        mut objects: Vec<Object>,
        mut materials: Named<Material>,
    ) -> Description {
        if let Some(bounds) = self.bounds.filter(|_| seen.has_floor) {
            let name = materials::free_name(&materials, "floor");
            materials.insert(name.clone(), studio::catcher());
            objects.push(studio::floor(bounds, name));
        }
        self.around(seen, Arc::new(definitions), Arc::new(objects), materials)
    }

    /// The same with objects and materials of another view.
    pub(in crate::scene) fn around(
        &self,
        seen: Seen,
        definitions: Arc<Named<Vec<Object>>>,
        objects: Arc<Vec<Object>>,
        materials: Named<Material>,
    ) -> Description {
        let mut description = Description::new(seen.camera, Vec::new());
        (description.definitions, description.objects, description.materials) = (definitions, objects, materials);
        description.name.clone_from(&self.name);
        description.image = seen.image;
        description.environment = seen.environment;
        // The surroundings are all the light there is from all around.
        description.ambient = d::Color::BLACK;
        description.lights = seen.lights;
        let (exposure, tone) =
            if self.is_unlit { (0.0, ToneMapping::None) } else { (seen.exposure, ToneMapping::KhronosPbrNeutral) };
        description.film = d::Film { exposure, tone, background: FilmBackground::Transparent };
        description.import_warnings = seen.warnings;
        description
    }

    /// Whether a view of the model has a floor.
    pub fn has_floor(&self, view: &Description) -> bool {
        view.objects.len() > self.bodies
    }
}

/// Refuses a camera that scenes cannot have.
fn check(camera: &ModelCamera) -> Result<(), Problems> {
    let wrong = |key: &str, detail: String| {
        let pointer = format!("/cameras/{}{key}", camera.number);
        Err(Problems::one(Problem::new(pointer, Code::OutOfRange, detail)))
    };
    match camera.projection {
        Projection::Orthographic { height } if !(SMALLEST_LENGTH..=MAGNITUDE).contains(&height) => {
            let detail = format!(
                "the camera sees a height of {height:e}: it has to be from {SMALLEST_LENGTH:e} to {MAGNITUDE:e}"
            );
            return wrong("/orthographic/ymag", detail);
        }
        _ => {}
    }
    let far = camera.placed.w_axis.truncate().abs().max_element();
    if far > MAGNITUDE {
        let detail = format!("its nodes put the camera {far:e} from the model: at most {MAGNITUDE:e} can be rendered");
        return wrong("", detail);
    }
    Ok(())
}

/// Says that a camera sees less or more than its file says.
fn warning_of_angle(camera: &ModelCamera) -> Option<Warning> {
    let Projection::Perspective { vertical } = camera.projection else { return None };
    let (says, taken) = (vertical * 180.0 / PI, framing::degrees(vertical));
    let detail = format!("the camera's angle of view of {says:.4} degrees is taken as {taken}");
    let pointer = format!("/cameras/{}/perspective/yfov", camera.number);
    let warning = Warning { subject: Subject::Approximated, what: "angle-of-view", detail, pointer };
    (says != taken).then_some(warning)
}

/// Says why nothing is seen.
fn warning_of_sight(sight: Sight) -> Option<Warning> {
    let (what, detail) = match sight {
        Sight::Something => return None,
        Sight::Edges => (
            "edges",
            "all triangles are lines from where the camera is, so nothing is seen: a flat model shows in another view",
        ),
        Sight::Backs => (
            "backs",
            "all triangles turn their backs to the camera, and the materials show fronts only, so nothing is seen: look from \
             the other side, or set doubleSided in the file",
        ),
    };
    Some(Warning { subject: Subject::Skipped, what, detail: detail.to_owned(), pointer: String::new() })
}
