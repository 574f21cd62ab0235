//! Materials and their patterns.

use super::{Bump, Color, Diffuse, ImageMap, Mapping, NormalMap, Pbr, Relief, is_zero, number};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a surface reflects and transmits light: `L = L_Phong + r_s L_s + r_t L_t` with
/// `L_Phong = k_a I_a + sum over lights (k_d (N.L) + k_s (R.V)^m) I`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Material {
    /// k_a, factor on the scene's ambient light. Default: the diffuse color.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ambient: Option<Diffuse>,
    /// k_d, a color or a texture. Default 0.8 grey.
    pub diffuse: Diffuse,
    /// k_s, strength of the Phong highlight. Default 0.
    pub specular: Color,
    /// m, the Phong exponent, 0 to 1e6. Default 32.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub shininess: f64,
    /// r_s, factor on the light of the reflected ray. Default 0.
    pub reflection: Color,
    /// r_t, factor on the light of the transmitted ray. Default 0.
    pub transmission: Color,
    /// Index of refraction, 0.01 to 100. Default 1.5.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub ior: f64,
    /// Roughness for reflected and transmitted rays, 0 to 1: the square root of the width alpha of the GGX distribution of
    /// facets. Default 0, a perfect mirror.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roughness: f64,
    /// Mean dispersion n_F - n_C, the difference of the indices of blue (486.1 nm) and red light (656.3 nm), 0 to 0.2; `ior`
    /// is that of yellow light (587.6 nm). Crown glass has 0.008, flint 0.026, diamond 0.025. Default 0.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 0.2))]
    pub dispersion: f64,
    /// How reflection and transmission depend on the angle of incidence. Default `"none"`. For shadow rays only `transmission`
    /// counts.
    #[serde(skip_serializing_if = "Fresnel::is_none")]
    pub fresnel: Fresnel,
    /// sigma of the law of Beer and Lambert, per scene unit: over a length d inside, a closed body lets exp(-sigma d) of the
    /// light pass. Lengths are in world space, so a larger instance is darker. Where bodies overlap the smaller one decides.
    /// Shadow rays are absorbed if `render.shadows` is `"transmissive"`. Default 0.
    #[serde(skip_serializing_if = "Color::is_black")]
    pub absorption: Color,
    /// Radiance that the surface emits on both sides. It is visible, but not a light source: it does not light other surfaces,
    /// except by `render.color_bleeding`. Default 0.
    #[serde(skip_serializing_if = "Color::is_black")]
    pub emission: Color,
    /// Whether rays hit the surface only from its front. Default false.
    pub one_sided: bool,
    /// Bumps on the surface. Default: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bump: Option<Bump>,
    /// Normals from a picture, not together with `bump`. Default: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_map: Option<NormalMap>,
    /// A material as in glTF, in place of all keys above but `one_sided`. Default: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pbr: Option<Box<Pbr>>,
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

    /// Which texture coordinates pictures lie on the surface by; only meshes have any.
    pub fn uv_sets(&self) -> [bool; 2] {
        if let Some(pbr) = &self.pbr {
            return pbr.uv_sets();
        }
        [self.images().any(|image| image.mapping == Mapping::Uv), false]
    }
}

impl Default for Material {
    fn default() -> Self {
        Self {
            ambient: None,
            diffuse: Diffuse::default(),
            specular: Color::BLACK,
            shininess: 32.0,
            reflection: Color::BLACK,
            transmission: Color::BLACK,
            ior: 1.5,
            roughness: 0.0,
            dispersion: 0.0,
            fresnel: Fresnel::None,
            absorption: Color::BLACK,
            emission: Color::BLACK,
            one_sided: false,
            bump: None,
            normal_map: None,
            pbr: None,
        }
    }
}

/// How reflection and transmission depend on the angle of incidence theta.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Fresnel {
    /// r_s and r_t at every angle. Under total internal reflection r_t is added to r_s.
    #[default]
    None,
    /// F r_s and (1 - F) r_t, where F is the exact unpolarised reflectance for `ior` and the surrounding media, 1 under total
    /// internal reflection. Clear glass has reflection 1 and transmission 1. Opaque bodies and sheets, which do not bend light,
    /// reflect like a varnish with their `ior`.
    Dielectric,
    /// r_s + (1 - r_s) (1 - cos theta)^5 in each channel (Schlick 1994), for metals. r_s is their color at normal incidence.
    /// r_t is multiplied by 1 - (1 - cos theta)^5.
    Conductor,
}

impl Fresnel {
    /// Whether the angle does not matter.
    pub fn is_none(&self) -> bool {
        *self == Self::None
    }
}

/// Checkerboard: tile `a` where the sum of floor(p / size) over the named axes is even, in object space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Checker {
    /// Color of the even tiles.
    pub a: Color,
    /// Color of the odd tiles.
    pub b: Color,
    /// Edge of a tile in scene units, above 0. Default 1.
    #[serde(default = "number::<1>")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub size: f64,
    /// The axes that count. Default `"xz"`, a floor.
    #[serde(default)]
    pub axes: Axes,
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
