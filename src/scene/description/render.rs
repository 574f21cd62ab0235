//! How to render.

use super::object::is_false;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How shadow rays treat bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shadows {
    /// Any body blocks.
    #[default]
    Opaque,
    /// Each surface crossed attenuates by its transmission, without bending the ray.
    Transmissive,
    /// No shadow rays at all.
    None,
}

/// Floating-point format of the whole trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// 32 bits.
    #[default]
    Single,
    /// 64 bits.
    Double,
}

/// What ends the recursion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Accuracy {
    /// `max_depth` and `min_weight`.
    Fixed(FixedAccuracy),
}

/// Parameters of the fixed mode: none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixedAccuracy {}

impl Default for Accuracy {
    fn default() -> Self {
        Self::Fixed(FixedAccuracy {})
    }
}

/// How to render.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RenderSettings {
    /// Longest chain of rays, 1 to 100000; the primary ray counts 1. Default 10.
    #[schemars(range(min = 1, max = 100_000))]
    pub max_depth: u32,
    /// A ray whose weight is below this in every channel is not followed, nor is a light asked for that could add less
    /// than a quarter of this share of itself, 0 to 1. Default 0.001.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_weight: f64,
    /// Rays for each pixel, 1 to 1024, spread evenly over it and over all choices the scene calls for. Default 1, and 64
    /// where it calls for choices: lights with an area, rough surfaces, a lens, motion, dispersion, color bleeding.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 1024))]
    pub samples: Option<u32>,
    /// Whether pixels that differ from a neighbour get 16 samples. Default true.
    pub antialias: bool,
    /// What casts shadows. Default `"opaque"`.
    pub shadows: Shadows,
    /// Whether surfaces are lit by the light that others scatter, once; it takes the place of ambient light where the eye
    /// looks, directly or in mirrors. Default false.
    #[serde(skip_serializing_if = "is_false")]
    pub color_bleeding: bool,
    /// Floating-point format. Default `"single"`.
    pub precision: Precision,
    /// What ends the recursion. Default `{"fixed": {}}`.
    pub accuracy: Accuracy,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            max_depth: 10,
            min_weight: 0.001,
            samples: None,
            antialias: true,
            shadows: Shadows::default(),
            color_bleeding: false,
            precision: Precision::default(),
            accuracy: Accuracy::default(),
        }
    }
}
