//! Collects entities into a scene, and checks NFF's order: view, background and lights before the first object.

use super::NffOptions;
use super::bodies::Bodies;
use super::camera::{camera, counting_camera};
use super::entity::{Entity, Kind, Light, View};
use super::tokens::Place;
use crate::math::Rgb;
use crate::scene::Description;
use crate::scene::description::{self, Camera, Color, Falloff, ImageSize, PointLight, RenderSettings};
use crate::scene::limits::LIGHTS;
use crate::scene::problem::{Code, Problem};

const NO_VIEW: &str = "there is no view \"v\" before the first object, so nothing says where the eye is; \
                       NFF has no default for it";

/// The scene so far.
#[derive(Debug)]
pub(super) struct SceneBuilder {
    options: NffOptions,
    /// Where the first view starts, right or wrong.
    view: Option<Place>,
    frame: Option<(Camera, ImageSize)>,
    background: Option<(Place, Color)>,
    lights: Vec<Light>,
    first_object: Option<Place>,
    bodies: Bodies,
}

impl SceneBuilder {
    pub(super) fn new(options: NffOptions) -> Self {
        Self {
            options,
            view: None,
            frame: None,
            background: None,
            lights: Vec::new(),
            first_object: None,
            bodies: Bodies::new(options.two_sided),
        }
    }

    /// Adds what starts at `place`.
    pub(super) fn add(&mut self, place: Place, entity: Entity) -> Result<(), Problem> {
        let is_object = !matches!(entity, Entity::View(_) | Entity::Background(_) | Entity::Light(_) | Entity::Fill(_));
        if is_object {
            self.first_object.get_or_insert(place);
        }
        match entity {
            Entity::View(view) => self.view(place, &view),
            Entity::Background(color) => self.background(place, Color(Rgb::from_array(color))),
            Entity::Light(light) => self.light(place, light),
            Entity::Fill(fill) => {
                self.bodies.fill(fill);
                Ok(())
            }
            Entity::Cone(cone) => self.bodies.cone(place, &cone),
            Entity::Sphere(sphere) => self.bodies.sphere(place, sphere),
            Entity::Polygon(vertices) => self.bodies.polygon(place, vertices),
            Entity::Patch(patch) => self.bodies.patch(place, patch),
        }
    }

    /// Notes an entity that could not be read.
    pub(super) fn skip(&mut self, place: Place, kind: Kind) {
        if kind == Kind::View {
            self.view.get_or_insert(place);
        }
    }

    /// The scene; missing entities are added to `problems`.
    pub(super) fn finish(self, end: Place, problems: &mut Vec<Problem>) -> Option<Description> {
        if self.view.is_none() {
            let place = self.first_object.unwrap_or(end);
            problems.push(place.problem(Code::InvalidNff, NO_VIEW));
        }
        if self.first_object.is_none() && problems.is_empty() {
            problems.push(end.problem(Code::InvalidNff, "the file has no objects; c, s, p and pp are objects"));
        }
        let (camera, image) = self.frame.filter(|_| problems.is_empty())?;
        let (materials, objects) = self.bodies.finish();
        // SPD Readme, "Testing Procedures"
        let count = self.lights.len().max(1) as f64;
        let intensity = count.sqrt() / (2.0 * count);
        let light = |light: Light| {
            description::Light::Point(PointLight {
                position: light.position,
                color: light.color.map_or(Color::WHITE, |color| Color(Rgb::from_array(color))),
                intensity,
                falloff: Falloff::None,
                area: None,
            })
        };
        Some(Description {
            image,
            background: self.background.map_or(Color::BLACK, |(_, color)| color),
            ambient: Color(Rgb::splat(intensity)),
            lights: self.lights.into_iter().map(light).collect(),
            materials,
            render: if self.options.spd_counts { counting() } else { RenderSettings::default() },
            ..Description::new(camera, objects)
        })
    }

    fn view(&mut self, place: Place, view: &View) -> Result<(), Problem> {
        let first = *self.view.get_or_insert(place);
        self.before_objects(place, "the view \"v\"")?;
        if first != place {
            return Err(second(place, "view \"v\"", first));
        }
        let frame = if self.options.spd_counts { counting_camera(place, view) } else { camera(place, view) };
        self.frame = Some(frame?);
        Ok(())
    }

    fn background(&mut self, place: Place, color: Color) -> Result<(), Problem> {
        self.before_objects(place, "the background \"b\"")?;
        if let Some((first, _)) = self.background {
            return Err(second(place, "background \"b\"", first));
        }
        self.background = Some((place, color));
        Ok(())
    }

    fn light(&mut self, place: Place, light: Light) -> Result<(), Problem> {
        self.before_objects(place, "lights \"l\"")?;
        if self.lights.len() as u64 >= LIGHTS.max {
            let detail = format!("there are more lights than the limit {} of {}", LIGHTS.name, LIGHTS.max);
            return Err(place.problem(Code::Limit, detail));
        }
        self.lights.push(light);
        Ok(())
    }

    fn before_objects(&self, place: Place, what: &str) -> Result<(), Problem> {
        let Some(object) = self.first_object else { return Ok(()) };
        let detail = format!("{what} must come before the first object, which is on line {}", object.line);
        Err(place.problem(Code::InvalidNff, detail))
    }
}

fn second(place: Place, what: &str, first: Place) -> Problem {
    place.problem(Code::InvalidNff, format!("this is a second {what}; the first is on line {}", first.line))
}

/// SPD Readme, "Testing Procedures": depth 5, no pruning by weight, one ray through each corner.
fn counting() -> RenderSettings {
    RenderSettings {
        max_depth: Some(5),
        min_weight: Some(0.0),
        samples: Some(1),
        antialias: false,
        ..RenderSettings::default()
    }
}
