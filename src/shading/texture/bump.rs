//! Bump maps: shading normals of a surface with heights that its geometry does not have (Blinn 1978), as surface gradients
//! (Mikkelsen, Surface Gradient-Based Bump Mapping Framework, JCGT 9(3), 2020).
//!
//! A height h over a surface with normal n turns the normal to n - grad h, grad h without its part along n. This needs no
//! tangent frame and no handedness, and a mirrored picture gives mirrored bumps.

use super::image::{ImageTexture, Lookup};
use super::noise::Fractal;
use glam::DVec3;

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
    Normals(ImageTexture),
}

/// Smallest z of a normal: steeper slopes are cut off.
const STEEPEST: f64 = 1.0 / 128.0;

impl BumpMap {
    /// The unit normal with bumps of a surface with a unit normal, in object space; the same normal where the bumps are flat.
    pub fn tilt(&self, lookup: &Lookup, normal: DVec3) -> DVec3 {
        let gradient = match self {
            Self::Noise { fractal, height } => fractal.at(lookup.point, lookup.width()).1 * *height,
            Self::Heights { picture, height } => picture.height_gradient(lookup) * *height,
            Self::Normals(picture) => picture.normal_gradient(lookup, normal),
        };
        let along = gradient - normal * normal.dot(gradient);
        if along == DVec3::ZERO || !along.is_finite() {
            return normal;
        }
        (normal - along).try_normalize().unwrap_or(normal)
    }
}

impl ImageTexture {
    /// dh/du grad u + dh/dv grad v, with differences over one texel of the mipmap level: they are linear between texels, where
    /// the slope of a bilinear height jumps.
    fn height_gradient(&self, lookup: &Lookup) -> DVec3 {
        let coord = self.coord(lookup);
        let [[a, b], [c, d]] = coord.axes(lookup);
        let [width, height] = self.mipmap.size();
        // The longer axis of the footprint decides the level, or the other one would alias.
        let square = |u: f64, v: f64| (u * width).powi(2) + (v * height).powi(2);
        let texels = square(a, b).max(square(c, d)).sqrt();
        let level = self.mipmap.level(texels);
        let step = texels.max(1.0);
        let at = |u: f64, v: f64| self.mipmap.at([coord.uv[0] + u, coord.uv[1] + v], level, self.wrap)[0];
        let (across, up) = (0.5 * step / width, 0.5 * step / height);
        let by_u = (at(across, 0.0) - at(-across, 0.0)) / (2.0 * across);
        let by_v = (at(0.0, up) - at(0.0, -up)) / (2.0 * up);
        coord.gradients[0] * by_u + coord.gradients[1] * by_v
    }

    /// The slopes -x/z and -y/z of a normal map along the unit vectors of its tangent frame: the direction in which only
    /// u grows, and the one across it, on the side where v grows.
    fn normal_gradient(&self, lookup: &Lookup, normal: DVec3) -> DVec3 {
        let coord = self.coord(lookup);
        let [x, y, z] = self.mipmap.average(coord.uv, coord.axes(lookup), self.wrap);
        let [of_u, of_v] = coord.gradients;
        let turn = normal.dot(of_u.cross(of_v));
        let Some(tangent) = (of_v.cross(normal) * turn.signum()).try_normalize() else { return DVec3::ZERO };
        let bitangent = normal.cross(tangent) * turn.signum();
        let z = z.max(STEEPEST);
        tangent * (-x / z) + bitangent * (-y / z)
    }
}
