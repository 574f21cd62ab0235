//! Textures that are looked up for one ray at a time: gradients, noise and images.

use super::bump::BumpMap;
use super::image::{ImageTexture, Lookup};
use super::mipmap::mix;
use super::noise::Fractal;
use glam::DVec3;

/// The textures of a material.
#[derive(Debug, Clone, Default)]
pub struct Textures {
    /// k_a, if it is a pattern.
    pub ambient: Option<Pattern>,
    /// k_d, if it is a pattern.
    pub diffuse: Option<Pattern>,
    /// Whether k_a is not simply k_d.
    pub own_ambient: bool,
    /// Bumps.
    pub bump: Option<BumpMap>,
}

impl Textures {
    /// Whether there is none.
    pub fn is_plain(&self) -> bool {
        self.ambient.is_none() && self.diffuse.is_none() && self.bump.is_none()
    }
}

/// A pattern in object space.
#[derive(Debug, Clone)]
pub enum Pattern {
    /// From `a` to `b`, by t = along . (p - from).
    Gradient {
        /// Where t is 0.
        from: DVec3,
        /// Gradient of t.
        along: DVec3,
        /// Colours at t = 0 and 1.
        colors: [[f64; 3]; 2],
    },
    /// From `a` to `b`, by noise.
    Noise {
        /// The noise.
        fractal: Fractal,
        /// Colours where it is 0 and 1.
        colors: [[f64; 3]; 2],
    },
    /// A picture.
    Image(ImageTexture),
}

impl Pattern {
    /// The colour of a place.
    pub fn at(&self, lookup: &Lookup) -> [f64; 3] {
        match self {
            Self::Gradient { from, along, colors: [a, b] } => {
                mix(*a, *b, along.dot(lookup.point - *from).clamp(0.0, 1.0))
            }
            Self::Noise { fractal, colors: [a, b] } => mix(*a, *b, fractal.at(lookup.point, lookup.width()).0),
            Self::Image(picture) => picture.at(lookup),
        }
    }
}
