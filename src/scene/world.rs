//! A scene in the kernel's format. The kernel reads it and never changes it.

use crate::accel::{Blockers, Geometry, Owner};
use crate::bound::ceiling::{Ceiling, Reach};
use crate::camera::Camera;
use crate::lanes::Real;
use crate::scene::called::Called;
use crate::scene::description::{Accuracy, Proved, RenderSettings};
use crate::shading::fog::Fog;
use crate::shading::light::Light;
use crate::shading::material::Material;
use crate::shading::spectrum::Spectrum;
use crate::shading::texture::environment::Environment;

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
    /// The environment map, which replaces the background, if there is one.
    pub environment: Option<Environment>,
    /// The camera.
    pub camera: Camera<R>,
    /// The rules of the recursion.
    pub rules: Rules,
    /// How bright anything can be.
    pub ceiling: Ceiling,
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

/// What ends chains of rays before `max_depth`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pruning {
    /// A ray whose weight is below this in every channel is not followed.
    Weight(f64),
    /// Rays are followed until the pixel is proved to be at most `max_codes` 8-bit codes off.
    Proved {
        /// 0 to 2.
        max_codes: u8,
    },
}

/// Longest chain of recursion without end: light that keeps 0.99 of itself on each ray is far below every code by then.
pub const ENDLESS: u32 = 1_000;

impl Pruning {
    /// The pruning for an accuracy.
    pub fn of(accuracy: Accuracy, min_weight: f64) -> Self {
        match accuracy {
            Accuracy::Fixed(_) => Self::Weight(min_weight),
            Accuracy::Proved(Proved { max_codes }) => Self::Proved { max_codes },
            Accuracy::Time(_) | Accuracy::Rays(_) | Accuracy::Statistical(_) => Self::Proved { max_codes: 1 },
        }
    }
}

/// The rules of the recursion.
#[derive(Debug, Clone, Copy)]
pub struct Rules {
    /// Longest chain of rays; the primary ray counts 1.
    pub max_depth: u32,
    /// What else ends it.
    pub pruning: Pruning,
    /// What shadow rays meet; `None` for no shadows.
    pub shadows: Option<Blockers>,
    /// Trace all rays that the Standard Procedural Databases count, also those that add nothing: a reflected ray from every
    /// transmitting surface, and a shadow ray wherever the geometric normal faces the light (SPD Readme, "Testing
    /// Procedures").
    pub spd_counts: bool,
}

impl Rules {
    /// Sets the rules that depend on the ceiling.
    pub(crate) fn finish(&mut self, render: &RenderSettings, reach: &Reach) {
        if self.pruning == Pruning::Weight(render.fixed_weight()) {
            return;
        }
        if reach.ceiling == Some([0.0; 3]) {
            // In a black scene every ray would be pruned; ray trees should still show some.
            self.pruning = Pruning::Weight(render.fixed_weight());
        } else if reach.max_depth.is_none() && render.max_depth.is_none() {
            self.max_depth = ENDLESS;
        }
    }
}

impl<R: Real> World<R> {
    /// The body with a primitive's expanded index.
    pub fn owner(&self, expanded: u64) -> Owner<'_, R> {
        Owner::find(&self.geometries, self.root, expanded)
    }
}
