//! Colours that depend on the place: gradients, clouds and pictures. (Checkers are in `material`, in every kernel.)

use super::bump::Relief;
use super::mipmap::{Edge, Pyramid, mix};
use super::noise::Fractal;
use super::uv::{Chart, Charted, Face};
use glam::DVec3;
use std::sync::Arc;

/// What a material has beside numbers.
#[derive(Debug, Clone, Default)]
pub struct Paint {
    /// k_a, if it is a pattern.
    pub ambient: Option<Pattern>,
    /// k_d, if it is a pattern.
    pub diffuse: Option<Pattern>,
    /// Whether k_a is not simply k_d.
    pub own_ambient: bool,
    /// Bumps.
    pub relief: Option<Relief>,
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
    Image(Picture),
}

/// A picture on a surface.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Its texels.
    pub pyramid: Arc<Pyramid>,
    /// Where it lies.
    pub chart: Chart,
    /// What lies beyond its edges.
    pub edges: [Edge; 2],
}

/// The place on a surface that a ray sees.
#[derive(Debug, Clone, Copy)]
pub struct Spot {
    /// The point in object space.
    pub point: DVec3,
    /// Axes of the ray's footprint in object space, from side to side, the longer one first.
    pub footprint: [DVec3; 2],
    /// The face of a mesh with texture coordinates.
    pub face: Option<Face>,
}

impl Spot {
    /// Width of the footprint, where it is widest.
    pub fn width(&self) -> f64 {
        self.footprint[0].length()
    }
}

impl Pattern {
    /// The colour of a place.
    pub fn at(&self, spot: &Spot) -> [f64; 3] {
        match self {
            Self::Gradient { from, along, colors: [a, b] } => {
                mix(*a, *b, along.dot(spot.point - *from).clamp(0.0, 1.0))
            }
            Self::Noise { fractal, colors: [a, b] } => mix(*a, *b, fractal.at(spot.point, spot.width()).0),
            Self::Image(picture) => picture.at(spot),
        }
    }
}

impl Picture {
    /// Where a place lies in it.
    pub fn chart(&self, spot: &Spot) -> Charted {
        self.chart.at(spot.point, spot.face.as_ref())
    }

    /// The colour of a place, the mean over the footprint.
    fn at(&self, spot: &Spot) -> [f64; 3] {
        let charted = self.chart(spot);
        self.pyramid.over(charted.uv, charted.axes(spot), self.edges)
    }
}

impl Charted {
    /// A footprint in texture space.
    pub fn axes(&self, spot: &Spot) -> [[f64; 2]; 2] {
        spot.footprint.map(|axis| self.gradients.map(|gradient| gradient.dot(axis)))
    }
}
