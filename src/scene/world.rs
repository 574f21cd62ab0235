//! A scene in the kernel's format. The kernel reads it and never changes it.

use crate::accel::{Blockers, Geometry, Owner};
use crate::bound::ceiling::{Ceiling, Reach};
use crate::camera::{Camera, PictureEdges};
use crate::film::Display;
use crate::lanes::Real;
use crate::scene::description::{Accuracy, Proved, RenderSettings};
use crate::scene::effects::{Effect, SceneEffects};
use crate::scene::light_cells::LightCells;
use crate::scene::usage::{Usage, Used};
use crate::shading::bright_directions::BrightDirections;
use crate::shading::emitters::Emitters;
use crate::shading::fog::Fog;
use crate::shading::light::Light;
use crate::shading::material::Material;
use crate::shading::spectrum::Spectrum;
use crate::shading::surroundings::Surroundings;
use crate::shading::texture::environment::Environment;
use std::sync::Arc;

/// Everything the kernel needs, in one precision.
#[derive(Debug, Clone)]
pub struct World<R> {
    /// The graph of geometries.
    pub geometries: Arc<[Geometry<R>]>,
    /// Index of the scene itself.
    pub root: usize,
    /// Largest coordinate of anything bounded.
    pub size: R,
    /// Materials.
    pub materials: Vec<Material<R>>,
    /// Lights.
    pub lights: Vec<Light<R>>,
    /// Whether more were left out since an opaque body hides them from all that is seen. Without shadows they would light it.
    pub hides_lights: bool,
    /// I_a.
    pub ambient: [R; 3],
    /// The same for what catches shadows, which light from all around reaches without rays, also with global illumination.
    pub ambient_of_catchers: [R; 3],
    /// Radiance of rays that hit nothing.
    pub background: [R; 3],
    /// Fog, if there is any.
    pub fog: Option<Fog<R>>,
    /// Whether the camera sees nothing where nothing is, directly or through bodies, in place of the background.
    pub transparent: bool,
    /// The radiance of the color behind a transparent background, if one is known.
    pub behind: Option<[R; 3]>,
    /// How light becomes colors.
    pub display: Display,
    /// The environment map, which replaces the background, if there is one.
    pub environment: Option<Environment>,
    /// What the environment does to surfaces, if it lights them without rays.
    pub surroundings: Option<Arc<Surroundings>>,
    /// The choice of bright directions of the environment, with global illumination.
    pub bright_directions: Option<Arc<BrightDirections>>,
    /// What glows, with global illumination.
    pub emitters: Option<Arc<Emitters>>,
    /// The camera.
    pub camera: Camera<R>,
    /// The edges of the whole picture, if shadows fade there.
    pub edges: Option<PictureEdges<R>>,
    /// The rules of the recursion.
    pub rules: Rules,
    /// How bright anything can be.
    pub ceiling: Ceiling,
    /// What its bodies have.
    pub usage: Usage,
    /// Whether all camera rays start in the same media.
    pub shared_eye: bool,
    /// Wavelengths, if anything disperses light.
    pub spectrum: Option<Box<Spectrum<R>>>,
    /// Whether any body transmits light; follows from the rest, as all below does.
    pub transmits: bool,
    /// Whether any body mirrors.
    pub reflects: bool,
    /// Whether it has to be asked at which angle rays hit, to trace them or to say what they may lack.
    pub angular: bool,
    /// Whether surfaces both scatter light and mirror or transmit it under global illumination, so that rays have several children.
    pub branches: bool,
    /// The effects that are on.
    pub effects: SceneEffects,
    /// What is known of its lights with an area, if shadow rays are asked for and nothing else changes their light.
    pub light_cells: Option<Arc<LightCells>>,
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

    /// How many rays a sample may defer until it needs them.
    pub const MOST_DEFERRED: u32 = 4_096;

    /// How many rays a group of samples may have until its proof is given up. Of the groups that are proved at all, one in
    /// thousands needs as many. Every format holds the number.
    pub const fn most_rays(samples: u32) -> u32 {
        let rays = 1_500 * (1 + samples);
        // A chain of mirrors is one sample's.
        if rays < 7_000 { 7_000 } else { rays }
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
    /// Whether bodies that absorb light color the shadows of [`Blockers::Transmissive`].
    pub colors_shadows: bool,
    /// Whether surfaces gather what others scatter, if rays that leave them are followed.
    pub color_bleeding: bool,
    /// Whether rays bring all light that surfaces scatter and reflect, if rays that leave them are followed.
    pub global_illumination: bool,
    /// Whether checkers are averaged over the footprints of rays.
    pub filter_checkers: bool,
    /// Trace all rays that the Standard Procedural Databases count, also those that add nothing: a reflected ray from every
    /// transmitting surface, and a shadow ray wherever the geometric normal faces the light (SPD Readme, "Testing
    /// Procedures").
    pub spd_counts: bool,
}

impl Rules {
    /// Whether surfaces gather what others scatter.
    pub fn gathers(&self) -> bool {
        self.color_bleeding && self.max_depth > 1
    }

    /// Whether rays bring all light that surfaces scatter and reflect.
    pub fn has_global_illumination(&self) -> bool {
        self.global_illumination && self.max_depth > 1
    }

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
    /// Whether bodies have a material of a kind.
    pub(super) fn has_material(&self, kind: impl Fn(&Material<R>, Used) -> bool) -> bool {
        self.materials.iter().zip(&self.usage.materials).any(|(material, used)| used.anywhere && kind(material, *used))
    }

    /// Whether rays may be in other media than empty space.
    pub(crate) fn has_media(&self) -> bool {
        self.transmits || self.effects.has(Effect::Absorption)
    }

    /// Whether colors are averaged over the footprints of rays beyond what textures do themselves.
    #[inline(always)]
    pub(crate) fn filters_checkers(&self) -> bool {
        self.rules.filter_checkers && self.effects.has(Effect::CheckerTexture)
    }

    /// Whether anything is averaged over the footprints of rays.
    #[inline(always)]
    pub(crate) fn has_footprints(&self) -> bool {
        self.filters_checkers() || self.effects.has_textures() || self.environment.is_some()
    }

    /// Whether any light shines.
    pub(super) fn is_lit(&self) -> bool {
        self.lights.iter().any(|light| shows(light.color))
    }

    /// The body with a primitive's expanded index.
    pub fn owner(&self, expanded: u64) -> Owner<'_, R> {
        Owner::find(&self.geometries, self.root, expanded)
    }
}

/// Whether a color is more than black.
pub(super) fn shows<R: Real>(color: [R; 3]) -> bool {
    color.iter().any(|channel| *channel > R::from_f64(0.0))
}
