//! The slow, independent tracer that tests compare the fast one with: Whitted's method (CACM 23(6), 1980) straight from
//! the [`Description`], in f64, by recursion, one ray at a time.
//!
//! It shares no intersection, traversal or shading code with the fast tracer, and prefers plain formulas to fast ones. The
//! description must be valid: [`check`](crate::scene::check::check) says whether it is.

mod camera;
mod flat;
mod mesh;
mod optics;
mod phong;
mod ray;
mod round;
mod shape;
mod torus;
mod transform;
mod way;
mod whitted;
mod world;

#[cfg(test)]
mod tests;

use crate::math::Rgb;
use crate::scene::description::{self, Accuracy, Description, Diffuse, Fog, Light, Object, RenderSettings};
use camera::Camera;
use ray::Ray;
use world::World;

/// A scene ready to be traced.
#[derive(Debug)]
pub struct Reference {
    camera: Camera,
    width: u32,
    height: u32,
    world: World,
    lights: Vec<Light>,
    ambient: Rgb,
    background: Rgb,
    fog: Option<Fog>,
    settings: RenderSettings,
    max_depth: u32,
    min_weight: f64,
}

/// Depth and weight at which it ends recursion without end. Rays beyond them change no code of a picture.
const DEEP: u32 = 60;
const LIGHT: f64 = 1e-6;

/// The first thing a ray meets.
#[derive(Debug, Clone, PartialEq)]
pub struct Hit {
    /// Where on the ray, in units of its direction.
    pub t: f64,
    /// The point.
    pub point: [f64; 3],
    /// Unit geometric normal out of the body's material: into the cavity of a hollow body.
    pub normal: [f64; 3],
    /// JSON pointer of the object in the scene's `objects`.
    pub object: String,
}

/// Whether any of some objects is a model, whose file it does not read.
fn has_models(objects: &[Object]) -> bool {
    objects.iter().any(|object| match object {
        Object::Group(group) => has_models(&group.objects),
        Object::Model(_) => true,
        _ => false,
    })
}

/// Whether any of some objects moves.
fn moves(objects: &[Object]) -> bool {
    objects.iter().any(|object| match object {
        Object::Group(group) => group.motion.is_some() || moves(&group.objects),
        Object::Instance(instance) => instance.motion.is_some(),
        _ => false,
    })
}

impl Reference {
    /// Whether it can trace a description: it has no pictures, noise and bumps, which would be no use to compare unless
    /// they were filtered and hashed in the same way, and makes no choices.
    pub fn knows(description: &Description) -> bool {
        let plain = |diffuse: &Diffuse| !matches!(diffuse, Diffuse::Image(_) | Diffuse::Noise(_));
        let mut materials = description.materials.iter().map(|(_, material)| material);
        let chooses = description.render.color_bleeding
            || matches!(description.camera, description::Camera::Pinhole(c) if c.aperture > 0.0)
            || description.lights.iter().any(|light| match light {
                Light::Point(l) => l.area.is_some(),
                Light::Spot(l) => l.area.is_some(),
                Light::Directional(l) => l.area.is_some(),
            })
            || moves(&description.objects)
            || description.definitions.iter().any(|(_, objects)| moves(objects));
        let has_models =
            has_models(&description.objects) || description.definitions.iter().any(|(_, objects)| has_models(objects));
        description.environment.is_none()
            && !chooses
            && !has_models
            && materials.all(|m| {
                let smooth = m.bump.is_none() && m.normal_map.is_none();
                let sharp = m.roughness == 0.0 && m.dispersion == 0.0 && m.pbr.is_none();
                plain(&m.diffuse) && m.ambient.as_ref().is_none_or(plain) && smooth && sharp
            })
    }

    /// Prepares a valid description that it [knows](Self::knows).
    pub fn new(description: &Description) -> Self {
        let render = &description.render;
        let (max_depth, min_weight) = match render.accuracy() {
            Accuracy::Fixed(_) => (render.fixed_depth(), render.fixed_weight()),
            _ => (render.max_depth.unwrap_or(DEEP), LIGHT),
        };
        Self {
            camera: Camera::new(description),
            width: description.image.width,
            height: description.image.height,
            world: World::new(description),
            lights: description.lights.clone(),
            ambient: description.ambient.0,
            background: description.background.0,
            fog: description.fog,
            settings: description.render,
            max_depth,
            min_weight,
        }
    }

    /// The radiance at a point of the picture, in pixels from its upper left corner; pixel centres lie at + 0.5.
    pub fn radiance_at(&self, x: f64, y: f64) -> [f64; 3] {
        let radiance = match self.camera.primary_ray(x, y) {
            Some(ray) => whitted::primary_radiance(self, ray),
            None => Rgb::ZERO,
        };
        radiance.to_array()
    }

    /// The first hit with t > `t_min`. The direction is taken as it is.
    pub fn closest_hit(&self, origin: [f64; 3], dir: [f64; 3], t_min: f64) -> Option<Hit> {
        let ray = Ray { origin: origin.into(), dir: dir.into() };
        self.world.closest_hit(&ray, t_min).map(|hit| Hit {
            t: hit.t,
            point: ray.at(hit.t).to_array(),
            normal: hit.ng.to_array(),
            object: format!("/objects/{}", hit.path[0]),
        })
    }

    /// The whole picture, rows from the top, one sample in the centre of each pixel.
    pub fn render(&self) -> Vec<[f64; 3]> {
        let centers = |n: u32| (0..n).map(|i| f64::from(i) + 0.5);
        centers(self.height)
            .flat_map(|y| centers(self.width).map(move |x| (x, y)))
            .map(|(x, y)| self.radiance_at(x, y))
            .collect()
    }
}
