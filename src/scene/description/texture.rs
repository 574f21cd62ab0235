//! Textures: colors, heights and normals that depend on the place, and the pictures behind them.

use super::{Color, Vec3, default_up, is_default, number};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A color that changes evenly from one point of object space to another, and is constant beyond them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gradient {
    /// Where the color is `a`.
    pub from: Vec3,
    /// Where the color is `b`; not `from`.
    pub to: Vec3,
    /// Color at `from`.
    pub a: Color,
    /// Color at `to`.
    pub b: Color,
}

/// Clouds between two colors: Perlin's gradient noise (2002) in object space. Each octave has half the size and half the
/// strength of the one before.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Noise {
    /// Color where the noise is lowest.
    pub a: Color,
    /// Color where the noise is highest.
    pub b: Color,
    /// Size of the coarsest features in scene units, above 0. Default 1.
    #[serde(default = "number::<1>")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub size: f64,
    /// Octaves, 1 to 12. Default 4.
    #[serde(default = "default_octaves")]
    #[schemars(range(min = 1, max = 12))]
    pub octaves: u32,
}

/// Noise as a height, from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grain {
    /// Size of the coarsest features in scene units, above 0. Default 1.
    #[serde(default = "number::<1>")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub size: f64,
    /// Octaves, 1 to 12. Default 4.
    #[serde(default = "default_octaves")]
    #[schemars(range(min = 1, max = 12))]
    pub octaves: u32,
}

/// A picture on a surface. Its middle is at (1/2, 1/2), u goes to the right and v up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImageMap {
    /// PNG, JPEG, WebP or KTX 2.0 (Basis Universal): `"data:image/png;base64,..."`, or the name of a file beside the scene, where
    /// files may be read.
    /// Transparency is ignored. Decoders of JPEG may round differently on other processors; those of PNG do not.
    pub source: String,
    /// Mapping of the picture to the surface. Default `"uv"`.
    #[serde(default)]
    pub mapping: Mapping,
    /// The texture beyond the edges of the picture. Default `"repeat"`.
    #[serde(default)]
    pub wrap: Wrap,
}

/// Mapping of a picture to a surface.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Mapping {
    /// The `uvs` of a mesh.
    #[default]
    Uv,
    /// Projection along an axis of object space.
    Planar(Planar),
    /// Projection from a point of object space, as on a globe.
    Spherical(Spherical),
}

/// A picture projected along an axis. Its lower left corner lies at the origin of object space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Planar {
    /// The plane it lies in. Default `"xz"`, a floor.
    #[serde(default)]
    pub axes: PlanarAxes,
    /// Width of the picture in scene units, above 0; its height follows from its shape. Default 1.
    #[serde(default = "number::<1>")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub size: f64,
}

/// A plane of object space. Seen from the positive side of the third axis, the picture is not mirrored: its right and up
/// are x and y, x and -z, or -z and y.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum PlanarAxes {
    Xy,
    #[default]
    Xz,
    Yz,
}

/// A picture as a globe: longitude across, latitude up. Its middle faces +z, or -y where the axis is z.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spherical {
    /// Centre of the globe. Default: the origin of object space.
    #[serde(default)]
    pub center: Vec3,
    /// Direction of the north pole, any length but 0. Default [0, 1, 0].
    #[serde(default = "default_up")]
    pub axis: Vec3,
}

/// The texture beyond the edges of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Wrap {
    /// The picture repeats.
    #[default]
    Repeat,
    /// The colors of the edges continue.
    Clamp,
    /// The picture repeats, every other time mirrored.
    Mirror,
}

/// Bumps: the surface is shaded as if it were raised along its normal, but its outline stays.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bump {
    /// Height of white above black, in units of object space, at least 0.
    #[schemars(range(min = 0.0))]
    pub height: f64,
    /// The heights.
    pub texture: Relief,
}

/// Heights from 0 to 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Relief {
    /// Noise.
    Noise(Grain),
    /// The codes of a grey picture without gamma, or the mean of the three channels.
    Image(ImageMap),
}

/// Normals from a picture: red, green and blue from 0 to 255 are x, y and z from -1 to 1, where x is the direction in which u
/// grows, y that of v (up in the picture, as in OpenGL), and z the normal; 128 is 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NormalMap {
    /// The picture.
    pub image: ImageMap,
}

/// Environment: the radiance of rays that hit nothing, by their direction, in place of `background`. One of `image`, `sky` and `studio`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Environment {
    /// Equirectangular PNG, JPEG, WebP, Radiance HDR or OpenEXR, as `panorama` cameras make it: `"data:image/png;base64,..."`, or the
    /// name of a file beside the scene. Its middle is seen in direction -z, its upper edge in direction +y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<String>,
    /// A clear sky over dull ground: `{}` for its colors by day.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky: Option<Sky>,
    /// A photographer's studio with bright walls and soft panels of light: `{}`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub studio: Option<Studio>,
    /// Turns it around the y axis, in degrees, counter-clockwise seen from above, -360 to 360. Default 0.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub rotate_deg: f64,
    /// Factor on its colors, at least 0. Default 1.
    #[serde(default = "number::<1>")]
    #[schemars(range(min = 0.0))]
    pub intensity: f64,
    /// Whether it lights surfaces. Default `"none"`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub light: EnvironmentLight,
}

/// What an environment does to surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum EnvironmentLight {
    /// Rays see it, and that is all.
    #[default]
    None,
    /// Surfaces scatter its light and rough `pbr` materials reflect it, blurred. It takes no sample, and nothing in the scene hides
    /// it from them. With `fidelity` `"faithful"` rays bring it whatever is said here.
    Fast,
}

/// A studio, the same for all: its front is in direction +z, its key light comes from the upper left there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Studio {}

/// A sky: its color changes from the horizon to the zenith. Below the horizon is ground of one color.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sky {
    /// Radiance straight above. Default `"#3f7fbf"`.
    #[serde(default = "default_zenith")]
    pub zenith: Color,
    /// Radiance at the horizon. Default `"#dce9f5"`.
    #[serde(default = "default_horizon")]
    pub horizon: Color,
    /// Radiance below the horizon. Default `"#8c8780"`.
    #[serde(default = "default_ground")]
    pub ground: Color,
}

fn default_zenith() -> Color {
    srgb("#3f7fbf")
}

fn default_horizon() -> Color {
    srgb("#dce9f5")
}

fn default_ground() -> Color {
    srgb("#8c8780")
}

fn srgb(hex: &str) -> Color {
    Color::from_hex(hex).unwrap_or_else(|| unreachable!("a color of this file"))
}

fn default_octaves() -> u32 {
    4
}
