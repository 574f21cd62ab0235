//! Fog.

use super::Color;
use crate::math::Rgb;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Fog around all closed bodies that transmit light: over a length d it lets exp(-density d) of the light pass and adds the
/// rest of its own colour. Rays that hit nothing pass through all of it: even fog hides the background. It fades what
/// is seen, directly, mirrored or through glass; the way from lights to surfaces it leaves alone.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fog {
    /// Radiance of fog that nothing is seen through. Default 0.8 grey.
    #[serde(default = "default_color")]
    pub color: Color,
    /// Optical depth of one scene unit, at least 0; 0 is no fog.
    #[schemars(range(min = 0.0))]
    pub density: f64,
    /// How it thins out with height. Default: not at all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<FogHeight>,
}

fn default_color() -> Color {
    Color(Rgb::splat(0.8))
}

/// Fog that thins out upwards: its density is whole up to y = base, and density exp(-(y - base)/falloff) above.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FogHeight {
    /// y in scene units from which on it thins out. Default 0.
    #[serde(default)]
    pub base: f64,
    /// Height in scene units in which it thins out to 1/e, above 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub falloff: f64,
}
