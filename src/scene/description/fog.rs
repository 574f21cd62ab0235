//! Fog.

use super::Color;
use crate::math::Rgb;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Fog outside of all closed bodies that transmit light. Over a length d it lets exp(-density d) of the light pass and replaces
/// the rest by its own color. Rays that hit nothing pass through all of it, so fog without falloff hides the background. Fog
/// affects camera, reflected and transmitted rays, but not the light from lights to surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fog {
    /// Radiance of dense fog. Default 0.8 grey.
    #[serde(default = "default_color")]
    pub color: Color,
    /// Optical depth of one scene unit, at least 0. 0 is no fog.
    #[schemars(range(min = 0.0))]
    pub density: f64,
    /// Falloff with height. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<FogHeight>,
}

fn default_color() -> Color {
    Color(Rgb::splat(0.8))
}

/// Fog that thins out with height: the density is constant up to y = base, and density exp(-(y - base)/falloff) above.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FogHeight {
    /// y in scene units above which it thins out. Default 0.
    #[serde(default)]
    pub base: f64,
    /// Height in scene units over which the density falls to 1/e, above 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub falloff: f64,
}
