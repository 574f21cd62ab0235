//! A scene in the kernel's format: what the tracing kernel reads and never changes.

use crate::accel::{Blockers, Geometry, Owner};
use crate::camera::Camera;
use crate::lanes::Real;
use crate::scene::called::Called;
use crate::shading::environment::Environment;
use crate::shading::fog::Fog;
use crate::shading::light::Light;
use crate::shading::material::Material;
use crate::shading::spectrum::Spectrum;

/// Everything the kernel needs, in one precision.
#[derive(Debug)]
pub struct World<R> {
    /// The graph of geometries.
    pub geometries: Vec<Geometry<R>>,
    /// Index of the scene itself.
    pub root: usize,
    /// Largest coordinate of anything bounded.
    pub size: R,
    /// Materials.
    pub materials: Vec<Material<R>>,
    /// Lights.
    pub lights: Vec<Light<R>>,
    /// I_a.
    pub ambient: [R; 3],
    /// Radiance of rays that hit nothing.
    pub background: [R; 3],
    /// Fog, if there is any.
    pub fog: Option<Fog<R>>,
    /// What they see instead, if there are surroundings.
    pub environment: Option<Environment>,
    /// The camera.
    pub camera: Camera<R>,
    /// What ends the recursion, and what counts.
    pub rules: Rules<R>,
    /// Whether any body transmits light.
    pub transmits: bool,
    /// Whether all camera rays start in the same media.
    pub shared_eye: bool,
    /// Whether any body mirrors.
    pub reflects: bool,
    /// Effects beyond the lecture's model.
    pub called: Called,
    /// Wavelengths, if anything disperses light.
    pub spectrum: Option<Box<Spectrum<R>>>,
}

/// The rules of the recursion.
#[derive(Debug, Clone, Copy)]
pub struct Rules<R> {
    /// Longest chain of rays; the primary ray counts 1.
    pub max_depth: u32,
    /// A ray whose weight is below this in every channel is not followed.
    pub min_weight: R,
    /// What shadow rays meet; `None` for no shadows.
    pub shadows: Option<Blockers>,
    /// Trace what the Standard Procedural Databases count, needed or not: a reflected ray from every transmitting
    /// surface, and a shadow ray wherever the geometric normal faces the light (SPD Readme, "Testing Procedures").
    pub spd_counts: bool,
}

impl<R: Real> World<R> {
    /// The body with a primitive's expanded index.
    pub fn owner(&self, expanded: u64) -> Owner<'_, R> {
        Owner::find(&self.geometries, self.root, expanded)
    }
}
