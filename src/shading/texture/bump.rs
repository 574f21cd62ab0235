//! Bump maps: shading normals of a surface with heights that its geometry does not have (Blinn 1978), as surface gradients
//! (Mikkelsen, Surface Gradient-Based Bump Mapping Framework, JCGT 9(3), 2020).
//!
//! A height h over a surface with normal n turns the normal to n - grad h, grad h without its part along n. This needs no
//! tangent frame and no handedness, and a mirrored picture gives mirrored bumps.

use super::image::{ImageTexture, Lookup};
use super::noise::Fractal;
use crate::lanes::{Double, V3};

/// Bumps in object space.
#[derive(Debug, Clone)]
pub enum BumpMap {
    /// Noise, times a height.
    Noise {
        /// From 0 to 1.
        fractal: Fractal,
        /// Height of 1.
        height: f64,
    },
    /// A picture of heights in its first channel.
    Heights {
        /// From 0 to 1.
        picture: ImageTexture,
        /// Height of 1.
        height: f64,
    },
    /// A picture of normals, z away from the surface.
    Normals {
        /// From -1 to 1.
        picture: ImageTexture,
        /// Factor on x and y.
        strength: f64,
        /// Whether x and y are along the tangents of the mesh, if it has any.
        by_tangents: bool,
        /// Whether the tangent frame of a stretched surface is orthonormal again, as in glTF. Otherwise relief is stretched with it.
        reframed: bool,
    },
}

/// Smallest z of a normal: steeper slopes are cut off.
const STEEPEST: f64 = 1.0 / 128.0;

impl BumpMap {
    /// The unit normals with bumps of a surface with unit normals, in object space; the same normals where the bumps are flat.
    #[inline(always)]
    pub fn tilt<W: Double>(&self, s: W::Simd, lookup: &Lookup<W>, normal: V3<W>) -> V3<W> {
        let gradient = match self {
            Self::Noise { fractal, height } => fractal.at(s, lookup.point, lookup.width()).1 * W::lit(s, *height),
            Self::Heights { picture, height } => picture.height_gradient(s, lookup) * W::lit(s, *height),
            Self::Normals { picture, strength, by_tangents, .. } => {
                picture.slopes(s, lookup, normal, *strength, *by_tangents).gradient()
            }
        };
        tilted(s, normal, gradient)
    }
}

/// Unit normals leaned against a gradient; the same normals where that is flat.
#[inline(always)]
fn tilted<W: Double>(s: W::Simd, normal: V3<W>, gradient: V3<W>) -> V3<W> {
    let along = gradient - normal * normal.dot(gradient);
    let flat = along.eq(V3::splat(s, [0.0; 3])) | !along.is_finite(s);
    V3::select(flat, normal, (normal - along).unit_or(s, normal))
}

/// What a normal map says of some surfaces: slopes along the unit vectors of its tangent frame. Without a direction it is flat.
#[derive(Debug, Clone, Copy)]
pub struct Slopes<W> {
    /// The direction in which only u grows, and the one across it, on the side where v grows.
    pub axes: [V3<W>; 2],
    /// Towards each.
    slopes: [W; 2],
}

impl<W: Double> Slopes<W> {
    #[inline(always)]
    fn gradient(&self) -> V3<W> {
        let ([tangent, bitangent], [by_u, by_v]) = (self.axes, self.slopes);
        tangent * by_u + bitangent * by_v
    }

    /// The unit normals of placed surfaces, given their normals and where the axes lead there. The frame is orthonormal again
    /// (glTF 2.0, section 3.7.2.1), so normals of what is stretched lean as far as those of the same mesh with moved vertices.
    #[inline(always)]
    pub fn tilt_placed(&self, s: W::Simd, normal: V3<W>, [of_u, of_v]: [V3<W>; 2]) -> V3<W> {
        let (zero, one) = (W::lit(s, 0.0), W::lit(s, 1.0));
        let none = V3 { x: zero, y: zero, z: zero };
        let tangent = (of_u - normal * normal.dot(of_u)).unit_or(s, none);
        let across = normal.cross(tangent);
        let bitangent = across * W::select(across.dot(of_v).lt(zero), -one, one);
        tilted(s, normal, Self { axes: [tangent, bitangent], slopes: self.slopes }.gradient())
    }
}

impl ImageTexture {
    /// dh/du grad u + dh/dv grad v, with differences over one texel of the mipmap level: they are linear between texels, where
    /// the slope of a bilinear height jumps.
    fn height_gradient<W: Double>(&self, s: W::Simd, lookup: &Lookup<W>) -> V3<W> {
        W::vectorize(
            s,
            #[inline(always)]
            || self.height_gradient_in(s, lookup),
        )
    }

    #[inline(always)]
    fn height_gradient_in<W: Double>(&self, s: W::Simd, lookup: &Lookup<W>) -> V3<W> {
        let coord = self.coord(s, lookup);
        let [long, short] = coord.axes(lookup);
        let [width, height] = self.mipmap.size();
        let (width, height) = (W::lit(s, width), W::lit(s, height));
        // The longer axis of the footprint decides the level, or the other one would alias.
        let texels = self.mipmap.texels_along(s, long).max(self.mipmap.texels_along(s, short));
        let level = self.mipmap.levels(s, texels);
        let step = texels.max(W::lit(s, 1.0));
        let (half, two) = (W::lit(s, 0.5), W::lit(s, 2.0));
        let (across, up) = (half * step / width, half * step / height);
        let [u, v] = coord.uv;
        let places = [[u + across, v], [u - across, v], [u, v + up], [u, v - up]];
        let [right, left, above, below] = self.mipmap.at_each(s, places, level, self.sampler, lookup.lanes);
        let by_u = (right.x - left.x) / (two * across);
        let by_v = (above.x - below.x) / (two * up);
        coord.gradients[0] * by_u + coord.gradients[1] * by_v
    }

    /// The slopes -x/z and -y/z of a normal map, in object space. A mesh may say what the axes are (glTF 2.0, section 3.7.2.1).
    pub fn slopes<W: Double>(
        &self,
        s: W::Simd,
        lookup: &Lookup<W>,
        normal: V3<W>,
        strength: f64,
        by_tangents: bool,
    ) -> Slopes<W> {
        W::vectorize(
            s,
            #[inline(always)]
            || self.slopes_in(s, lookup, normal, strength, by_tangents),
        )
    }

    #[inline(always)]
    fn slopes_in<W: Double>(
        &self,
        s: W::Simd,
        lookup: &Lookup<W>,
        normal: V3<W>,
        strength: f64,
        by_tangents: bool,
    ) -> Slopes<W> {
        let coord = self.coord(s, lookup);
        let V3 { x, y, z } = self.mipmap.average(s, coord.uv, coord.axes(lookup), self.sampler, lookup.lanes);
        let (zero, one) = (W::lit(s, 0.0), W::lit(s, 1.0));
        let none = V3 { x: zero, y: zero, z: zero };
        let told = match &lookup.face {
            Some(face) if by_tangents => face.tangents(s, lookup.point),
            _ => None,
        };
        let (tangent, turn) = match told {
            Some((tangent, hand)) => (tangent - normal * normal.dot(tangent), hand),
            None => {
                let [of_u, of_v] = coord.gradients;
                let turn = normal.dot(of_u.cross(of_v));
                (of_v.cross(normal) * W::select(turn.lt(zero), -one, one), turn)
            }
        };
        let sign = W::select(turn.lt(zero), -one, one);
        let tangent = tangent.unit_or(s, none);
        let bitangent = normal.cross(tangent) * sign;
        let z = z.max(W::lit(s, STEEPEST));
        let (x, y) = (x * W::lit(s, strength), y * W::lit(s, strength));
        let lost = tangent.eq(none);
        let slope = |x: W| W::select(lost, zero, -x / z);
        Slopes { axes: [tangent, bitangent], slopes: [slope(x), slope(y)] }
    }
}
