//! A picture on a surface, and its lookup for a ray.

use super::mipmap::{Mipmap, Wrap};
use super::uv::{Face, TexCoord, UvMapping};
use glam::DVec3;
use std::sync::Arc;

/// A picture on a surface.
#[derive(Debug, Clone)]
pub struct ImageTexture {
    /// Its texels.
    pub mipmap: Arc<Mipmap>,
    /// How it is laid on the surface.
    pub mapping: UvMapping,
    /// What lies beyond its edges, across and along.
    pub wrap: [Wrap; 2],
}

/// The point of a surface that a ray hits, and its footprint there.
#[derive(Debug, Clone, Copy)]
pub struct Lookup {
    /// The point in object space.
    pub point: DVec3,
    /// Axes of the ray's footprint in object space, from side to side, the longer one first.
    pub footprint: [DVec3; 2],
    /// The face of a mesh with texture coordinates.
    pub face: Option<Face>,
}

impl Lookup {
    /// Width of the footprint, where it is widest.
    pub fn width(&self) -> f64 {
        self.footprint[0].length()
    }
}

impl ImageTexture {
    /// Texture coordinates of a lookup.
    pub fn coord(&self, lookup: &Lookup) -> TexCoord {
        self.mapping.at(lookup.point, lookup.face.as_ref())
    }

    /// The mean colour over the footprint.
    pub(super) fn at(&self, lookup: &Lookup) -> [f64; 3] {
        let coord = self.coord(lookup);
        self.mipmap.average(coord.uv, coord.axes(lookup), self.wrap)
    }
}

impl TexCoord {
    /// A footprint in texture space.
    pub fn axes(&self, lookup: &Lookup) -> [[f64; 2]; 2] {
        lookup.footprint.map(|axis| self.gradients.map(|gradient| gradient.dot(axis)))
    }
}
