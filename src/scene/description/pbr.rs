//! Materials as glTF 2.0 has them: metallic-roughness, and the extensions of it that surfaces need.

use super::channel::{Channel, Textured, UvTransform};
use super::object::is_false;
use super::{Color, is_default, is_zero, number};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A material of metal, plastic, glass or lacquer, as glTF 2.0 describes it in appendix B. Names, defaults and meanings are those
/// of glTF. It replaces all other keys of a material but `one_sided`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Pbr {
    /// Color of what is scattered, or of a metal's reflection, 0 to 1 in each channel. The `colors` of a mesh multiply it.
    /// Default white.
    #[serde(skip_serializing_if = "is_white")]
    pub base_color: Channel<Color>,
    /// 1 for metals, 0 for all else. Default 1.
    #[serde(skip_serializing_if = "is_one")]
    pub metallic: Channel<f64>,
    /// Roughness, 0 to 1: the square root of the width alpha of the GGX distribution of facets. Default 1.
    #[serde(skip_serializing_if = "is_one")]
    pub roughness: Channel<f64>,
    /// Normals from a picture, as in `normal_map`; `factor` multiplies x and y. Default: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<Box<Textured<f64>>>,
    /// The share of the light from all around that reaches the surface: 1 + factor (texel - 1). It does not dim lights.
    /// Default: all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub occlusion: Option<Box<Textured<f64>>>,
    /// Radiance that the surface emits. It lights no other surface. Default 0.
    #[serde(skip_serializing_if = "is_black")]
    pub emissive: Channel<Color>,
    /// How much of the surface is there; light goes straight through the rest, and so do shadow rays. Default: all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opacity: Option<Box<Opacity>>,
    /// The share of what a dielectric does not mirror that passes through it, colored by `base_color`; the rest is scattered.
    /// Default 0.
    #[serde(skip_serializing_if = "is_nothing")]
    pub transmission: Channel<f64>,
    /// Whether the surface is a thin sheet that does not bend light, also if its mesh is closed. Default false.
    #[serde(skip_serializing_if = "is_false")]
    pub thin: bool,
    /// Index of refraction, 1 to 100. Default 1.5.
    #[schemars(range(min = 1.0, max = 100.0))]
    pub ior: f64,
    /// Strength of a dielectric's reflection, 0 to 1. Default 1.
    #[serde(skip_serializing_if = "is_one")]
    pub specular: Channel<f64>,
    /// Color of a dielectric's reflection at normal incidence, on which it is a factor: above 1 more is reflected than `ior` says,
    /// at most all. Default white.
    #[serde(skip_serializing_if = "is_white")]
    pub specular_color: Channel<Color>,
    /// What a closed body absorbs. Default: nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attenuation: Option<Attenuation>,
    /// 20 over the Abbe number. What follows, a mean dispersion of (ior - 1)/20 times this, is limited to 0.2. Default 0: none.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0))]
    pub dispersion: f64,
    /// Strength of a layer of lacquer over all, 0 to 1. Default 0.
    #[serde(skip_serializing_if = "is_nothing")]
    pub clearcoat: Channel<f64>,
    /// Roughness of the lacquer, 0 to 1. Default 0.
    #[serde(skip_serializing_if = "is_nothing")]
    pub clearcoat_roughness: Channel<f64>,
    /// Normals of the lacquer from a picture, as in `normal`. Default: none; the lacquer is even, also over a surface with `normal`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearcoat_normal: Option<Box<Textured<f64>>>,
    /// Whether the surface shows `base_color` whatever the light is, and nothing else. A film with `"khronos_pbr_neutral"` shows it as
    /// it is, also if it is exposed, up to the code 226; brighter colors fade with all others. Default false.
    #[serde(skip_serializing_if = "is_false")]
    pub unlit: bool,
    /// Whether the surface shows shadows alone: light goes straight on through it, but for the share of all light that bodies hide
    /// from it. No other key but `edge_fade` counts; the fourth number of a mesh's `colors` is how much of the shadows is seen. Default false.
    #[serde(skip_serializing_if = "is_false")]
    pub shadow_catcher: bool,
    /// With `shadow_catcher`: the border of the picture in which shadows fade, as a share of its width and height, 0 to 0.5, so that
    /// none ends as if cut off at an edge. Pinhole and orthographic cameras only. Default 0.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 0.5))]
    pub edge_fade: f64,
}

/// How much of a surface is there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Opacity {
    /// The share of the surface that is there, 0 to 1. The fourth number of a mesh's `colors` multiplies it. Default 1.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub alpha: Channel<f64>,
    /// What `alpha` means. Default `"blend"`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub mode: AlphaMode,
    /// With `"mask"`: the least alpha at which the surface is there, 0 to 1. Default 0.5.
    #[serde(default = "half")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub cutoff: f64,
}

/// What alpha means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum AlphaMode {
    /// The share of the surface that is there.
    #[default]
    Blend,
    /// The surface is there where alpha is at least `cutoff`. Of several texels in a ray's footprint the share of those counts.
    Mask,
}

/// What a body absorbs: it lets `color` pass over a length of `distance`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Attenuation {
    /// The share of light that passes, above 0 to 1 in each channel.
    pub color: Color,
    /// The length, in scene units, above 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub distance: f64,
}

impl Pbr {
    /// Channels that are colors, by their keys.
    pub fn colors(&self) -> [(&'static str, &Channel<Color>); 3] {
        [("base_color", &self.base_color), ("emissive", &self.emissive), ("specular_color", &self.specular_color)]
    }

    /// Whether any channel but the normals has a picture.
    pub fn has_pictures(&self) -> bool {
        let alpha = self.opacity.as_ref().is_some_and(|opacity| opacity.alpha.textured().is_some());
        self.colors().iter().any(|(_, channel)| channel.textured().is_some())
            || self.numbers().iter().any(|(_, channel)| channel.textured().is_some())
            || self.occlusion.is_some()
            || alpha
    }

    /// Which texture coordinates its pictures lie by.
    pub fn uv_sets(&self) -> [bool; 2] {
        let mut sets = [false; 2];
        let colors = self.colors().into_iter().filter_map(|(_, channel)| Some(channel.textured()?.uv));
        let numbers = self.numbers().into_iter().filter_map(|(_, channel)| Some(channel.textured()?.uv));
        let alpha = self.opacity.iter().filter_map(|opacity| Some(opacity.alpha.textured()?.uv));
        let normals = self.normals().into_iter().filter_map(|(_, map)| Some(map?.uv));
        let occlusion = self.occlusion.iter().map(|map| map.uv);
        colors
            .chain(numbers)
            .chain(alpha)
            .chain(normals)
            .chain(occlusion)
            .for_each(|uv| sets[usize::from(uv > 0)] = true);
        sets
    }

    /// Pictures of normals, by their keys.
    pub fn normals(&self) -> [(&'static str, Option<&Textured<f64>>); 2] {
        [("normal", self.normal.as_deref()), ("clearcoat_normal", self.clearcoat_normal.as_deref())]
    }

    /// Whether the tangents of a mesh are those of a picture of normals. They are made for one set of texture coordinates, that of
    /// `normal`, and not for a picture that is turned or mirrored.
    pub fn takes_tangents(&self, normals: &Textured<f64>) -> bool {
        let made_for = self.normal.as_ref().map_or(normals.uv, |normal| normal.uv);
        let UvTransform { rotate_deg, scale, .. } = normals.transform;
        normals.uv == made_for && rotate_deg == 0.0 && scale.iter().all(|scale| *scale > 0.0)
    }

    /// Channels that are numbers from 0 to 1, by their keys; alpha is one of `opacity`.
    pub fn numbers(&self) -> [(&'static str, &Channel<f64>); 6] {
        [
            ("metallic", &self.metallic),
            ("roughness", &self.roughness),
            ("transmission", &self.transmission),
            ("specular", &self.specular),
            ("clearcoat", &self.clearcoat),
            ("clearcoat_roughness", &self.clearcoat_roughness),
        ]
    }
}

impl Default for Pbr {
    fn default() -> Self {
        let value = |x: f64| Channel::Value(x);
        Self {
            base_color: Channel::Value(Color::WHITE),
            metallic: value(1.0),
            roughness: value(1.0),
            normal: None,
            occlusion: None,
            emissive: Channel::Value(Color::BLACK),
            opacity: None,
            transmission: value(0.0),
            thin: false,
            ior: 1.5,
            specular: value(1.0),
            specular_color: Channel::Value(Color::WHITE),
            attenuation: None,
            dispersion: 0.0,
            clearcoat: value(0.0),
            clearcoat_roughness: value(0.0),
            clearcoat_normal: None,
            unlit: false,
            shadow_catcher: false,
            edge_fade: 0.0,
        }
    }
}

fn one() -> Channel<f64> {
    Channel::Value(number::<1>())
}

fn half() -> f64 {
    0.5
}

fn is_one(channel: &Channel<f64>) -> bool {
    *channel == Channel::Value(1.0)
}

fn is_nothing(channel: &Channel<f64>) -> bool {
    *channel == Channel::Value(0.0)
}

fn is_white(channel: &Channel<Color>) -> bool {
    *channel == Channel::Value(Color::WHITE)
}

fn is_black(channel: &Channel<Color>) -> bool {
    *channel == Channel::Value(Color::BLACK)
}
