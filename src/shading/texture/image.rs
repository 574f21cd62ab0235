//! Pictures on surfaces, and their lookup for rays.

use super::lookup::Sampler;
use super::mipmap::Mipmap;
use super::uv::{Face, TexCoord, UvMapping};
use crate::lanes::{Double, V3};
use std::sync::Arc;

/// A picture on a surface.
#[derive(Debug, Clone)]
pub struct ImageTexture {
    /// Its texels.
    pub mipmap: Arc<Mipmap>,
    /// How it is laid on the surface.
    pub mapping: UvMapping,
    /// How it is looked up.
    pub sampler: Sampler,
}

/// The points of a surface that rays hit, and their footprints there.
#[derive(Debug, Clone, Copy)]
pub struct Lookup<W> {
    /// The lanes that are asked for; others may hold anything.
    pub lanes: u32,
    /// The points in object space.
    pub point: V3<W>,
    /// Axes of the rays' footprints in object space, from side to side, the longer one first.
    pub footprint: [V3<W>; 2],
    /// The faces of a mesh with texture coordinates.
    pub face: Option<Face<W>>,
}

impl<W: Double> Lookup<W> {
    /// Widths of the footprints, where they are widest.
    #[inline(always)]
    pub fn width(&self) -> W {
        self.footprint[0].length()
    }
}

impl ImageTexture {
    /// Texture coordinates of a lookup.
    #[inline(always)]
    pub fn coord<W: Double>(&self, s: W::Simd, lookup: &Lookup<W>) -> TexCoord<W> {
        self.mapping.at(s, lookup.point, lookup.face.as_ref())
    }

    /// Lanes whose footprints are longer than a texel.
    #[inline(always)]
    pub fn sees_several<W: Double>(&self, s: W::Simd, lookup: &Lookup<W>) -> W::Mask {
        let [a, b] = self.coord(s, lookup).axes(lookup);
        self.mipmap.texels_along(s, a).max(self.mipmap.texels_along(s, b)).gt(W::lit(s, 1.0))
    }

    /// The mean colors over the footprints.
    pub fn at<W: Double>(&self, s: W::Simd, lookup: &Lookup<W>) -> V3<W> {
        W::vectorize(
            s,
            #[inline(always)]
            || {
                let coord = self.coord(s, lookup);
                self.mipmap.average(s, coord.uv, coord.axes(lookup), self.sampler, lookup.lanes)
            },
        )
    }
}

impl<W: Double> TexCoord<W> {
    /// The footprints in texture space.
    #[inline(always)]
    pub fn axes(&self, lookup: &Lookup<W>) -> [[W; 2]; 2] {
        let ([u, v], [long, short]) = (self.gradients, lookup.footprint);
        [[u.dot(long), v.dot(long)], [u.dot(short), v.dot(short)]]
    }
}
