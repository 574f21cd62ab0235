//! Materials and their patterns.

use super::{Bump, Color, Diffuse, ImageMap, Mapping, NormalMap, Relief};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a surface answers light: `L = L_Phong + r_s L_s + r_t L_t` with
/// `L_Phong = k_a I_a + sum over lights (k_d (N.L) + k_s (R.V)^m) I`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// k_a, factor on the scene's ambient light. Default: the diffuse colour.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ambient: Option<Diffuse>,
    /// k_d, a colour or a texture. Default 0.8 grey.
    #[serde(default)]
    pub diffuse: Diffuse,
    /// k_s, strength of the Phong highlight. Default 0.
    #[serde(default)]
    pub specular: Color,
    /// m, the Phong exponent, 0 to 1e6. Default 32.
    #[serde(default = "default_shininess")]
    #[schemars(range(min = 0.0, max = 1e6))]
    pub shininess: f64,
    /// r_s, factor on what the reflected ray brings. Default 0.
    #[serde(default)]
    pub reflection: Color,
    /// r_t, factor on what the transmitted ray brings. Default 0.
    #[serde(default)]
    pub transmission: Color,
    /// Index of refraction, 0.01 to 100. Default 1.5.
    #[serde(default = "default_ior")]
    #[schemars(range(min = 0.01, max = 100.0))]
    pub ior: f64,
    /// Whether the surface exists only for rays that come from its front. Default false.
    #[serde(default)]
    pub one_sided: bool,
    /// Bumps on the surface. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bump: Option<Bump>,
    /// Normals from a picture; not together with `bump`. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal_map: Option<NormalMap>,
}

fn default_shininess() -> f64 {
    32.0
}

fn default_ior() -> f64 {
    1.5
}

impl Material {
    /// All pictures on the surface.
    pub fn images(&self) -> impl Iterator<Item = &ImageMap> {
        let relief = self.bump.as_ref().and_then(|bump| match &bump.texture {
            Relief::Image(image) => Some(image),
            Relief::Noise(_) => None,
        });
        let normals = self.normal_map.as_ref().map(|normals| &normals.image);
        [self.ambient.as_ref().and_then(Diffuse::image), self.diffuse.image(), relief, normals].into_iter().flatten()
    }

    /// Whether a picture lies on the surface by texture coordinates, which only meshes have.
    pub fn needs_uvs(&self) -> bool {
        self.images().any(|image| image.mapping == Mapping::Uv)
    }
}

impl Default for Material {
    fn default() -> Self {
        Self {
            ambient: None,
            diffuse: Diffuse::default(),
            specular: Color::BLACK,
            shininess: default_shininess(),
            reflection: Color::BLACK,
            transmission: Color::BLACK,
            ior: default_ior(),
            one_sided: false,
            bump: None,
            normal_map: None,
        }
    }
}

/// Checkerboard: tile `a` where the sum of floor(p / size) over the named axes is even, in object space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Checker {
    /// Colour of the even tiles.
    pub a: Color,
    /// Colour of the odd tiles.
    pub b: Color,
    /// Edge of a tile in scene units, above 0. Default 1.
    #[serde(default = "default_checker_size")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub size: f64,
    /// The axes that count. Default `"xz"`, a floor.
    #[serde(default)]
    pub axes: Axes,
}

fn default_checker_size() -> f64 {
    1.0
}

/// A set of axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum Axes {
    X,
    Y,
    Z,
    Xy,
    #[default]
    Xz,
    Yz,
    Xyz,
}

impl Axes {
    /// Whether x, y and z count.
    pub fn flags(self) -> [bool; 3] {
        match self {
            Self::X => [true, false, false],
            Self::Y => [false, true, false],
            Self::Z => [false, false, true],
            Self::Xy => [true, true, false],
            Self::Xz => [true, false, true],
            Self::Yz => [false, true, true],
            Self::Xyz => [true, true, true],
        }
    }
}
