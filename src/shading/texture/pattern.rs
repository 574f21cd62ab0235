//! Textures that are looked up in double precision: gradients, noise and images.

use super::bump::BumpMap;
use super::image::{ImageTexture, Lookup};
use super::noise::Fractal;
use crate::lanes::{Double, V3};
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
    /// Those of the clearcoat over it.
    pub clearcoat: Option<BumpMap>,
}

impl Textures {
    /// Whether there is none.
    pub fn is_plain(&self) -> bool {
        self.ambient.is_none() && self.diffuse.is_none() && self.bump.is_none() && self.clearcoat.is_none()
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
        /// Colors at t = 0 and 1.
        colors: [[f64; 3]; 2],
    },
    /// From `a` to `b`, by noise.
    Noise {
        /// The noise.
        fractal: Fractal,
        /// Colors where it is 0 and 1.
        colors: [[f64; 3]; 2],
    },
    /// A picture.
    Image(ImageTexture),
}

impl Pattern {
    /// The colors of places.
    #[inline(always)]
    pub fn at<W: Double>(&self, s: W::Simd, lookup: &Lookup<W>) -> V3<W> {
        match self {
            Self::Gradient { from, along, colors } => {
                let from_start = lookup.point - V3::splat(s, from.to_array());
                let part = V3::splat(s, along.to_array()).dot(from_start);
                between(s, *colors, part.max(W::lit(s, 0.0)).min(W::lit(s, 1.0)))
            }
            Self::Noise { fractal, colors } => between(s, *colors, fractal.at(s, lookup.point, lookup.width()).0),
            Self::Image(picture) => picture.at(s, lookup),
        }
    }
}

/// From the first to the second.
#[inline(always)]
fn between<W: Double>(s: W::Simd, [a, b]: [[f64; 3]; 2], part: W) -> V3<W> {
    V3::splat(s, a) * (W::lit(s, 1.0) - part) + V3::splat(s, b) * part
}
