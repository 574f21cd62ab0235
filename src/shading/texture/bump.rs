//! Bumps: shading normals that tell of a surface which is not there (Blinn 1978), as surface gradients (Mikkelsen, Surface
//! Gradient-Based Bump Mapping Framework, JCGT 9(3), 2020).
//!
//! A height h over a surface with normal n turns the normal to n - grad h, grad h without its part along n. So neither a
//! tangent frame nor handedness has to be carried along, and a mirrored picture gives mirrored bumps.

use super::noise::Fractal;
use super::pattern::{Picture, Spot};
use glam::DVec3;

/// Bumps in object space.
#[derive(Debug, Clone)]
pub enum Relief {
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
        picture: Picture,
        /// Height of 1.
        height: f64,
    },
    /// A picture of normals, z away from the surface.
    Normals(Picture),
}

/// Smallest z of a normal: steeper slopes are cut off.
const STEEPEST: f64 = 1.0 / 128.0;

impl Relief {
    /// The unit normal of a raised place on a surface with a unit normal in object space; the same one where it is flat.
    pub fn tilt(&self, spot: &Spot, normal: DVec3) -> DVec3 {
        let gradient = match self {
            Self::Noise { fractal, height } => fractal.at(spot.point, spot.width()).1 * *height,
            Self::Heights { picture, height } => picture.height_gradient(spot) * *height,
            Self::Normals(picture) => picture.normal_gradient(spot, normal),
        };
        let along = gradient - normal * normal.dot(gradient);
        if along == DVec3::ZERO || !along.is_finite() {
            return normal;
        }
        (normal - along).try_normalize().unwrap_or(normal)
    }
}

impl Picture {
    /// dh/du grad u + dh/dv grad v, with differences over one texel of the level seen: linear between texels, where a
    /// bilinear height itself has creases.
    fn height_gradient(&self, spot: &Spot) -> DVec3 {
        let charted = self.chart(spot);
        let [[a, b], [c, d]] = charted.axes(spot);
        let [width, height] = self.pyramid.size();
        // What is seen in one direction only would alias in the other.
        let square = |u: f64, v: f64| (u * width).powi(2) + (v * height).powi(2);
        let texels = square(a, b).max(square(c, d)).sqrt();
        let level = self.pyramid.level(texels);
        let step = texels.max(1.0);
        let at = |u: f64, v: f64| self.pyramid.at([charted.uv[0] + u, charted.uv[1] + v], level, self.edges)[0];
        let (across, up) = (0.5 * step / width, 0.5 * step / height);
        let by_u = (at(across, 0.0) - at(-across, 0.0)) / (2.0 * across);
        let by_v = (at(0.0, up) - at(0.0, -up)) / (2.0 * up);
        charted.gradients[0] * by_u + charted.gradients[1] * by_v
    }

    /// The slopes -x/z and -y/z of a normal map along the unit vectors of its tangent frame: the direction in which only
    /// u grows, and the one across it, on the side where v grows.
    fn normal_gradient(&self, spot: &Spot, normal: DVec3) -> DVec3 {
        let charted = self.chart(spot);
        let [x, y, z] = self.pyramid.over(charted.uv, charted.axes(spot), self.edges);
        let [of_u, of_v] = charted.gradients;
        let turn = normal.dot(of_u.cross(of_v));
        let Some(tangent) = (of_v.cross(normal) * turn.signum()).try_normalize() else { return DVec3::ZERO };
        let bitangent = normal.cross(tangent) * turn.signum();
        let z = z.max(STEEPEST);
        tangent * (-x / z) + bitangent * (-y / z)
    }
}
