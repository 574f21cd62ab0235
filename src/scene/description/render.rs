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

/// How accurate a picture is to be, or how much it may cost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Accuracy {
    /// Rays are followed to `max_depth` and down to `min_weight`.
    Fixed(Fixed),
    /// Each pixel's rays are followed until it is proved how far it can be from recursion without end.
    Proved(Proved),
    /// The best picture in a time. It depends on the machine; the report names the rays that make it again.
    Time(Time),
    /// The best picture for so many rays: the same bytes on every machine.
    Rays(Rays),
    /// Each pixel gets samples until it is likely, by their spread, that more would not change it by more than a width.
    /// Recursion is proved as with `max_codes` 1; `samples` and `antialias` do not matter.
    Statistical(Statistical),
}

/// Parameters of the fixed mode: none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fixed {}

/// Parameters of the proved mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Proved {
    /// How many 8-bit codes each channel may be off, 0 to 2. 0 gives the PNG of recursion without end.
    #[schemars(range(min = 0, max = 2))]
    pub max_codes: u8,
}

/// Parameters of the time mode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// Milliseconds of wall time, from the scene's bytes to the picture's, 1 to 3600000.
    #[schemars(range(min = 1.0, max = 3_600_000.0))]
    pub ms: f64,
}

/// Parameters of the rays mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rays {
    /// Rays of all kinds, 1 to 2^53. The parcel of pixels that reaches the number is finished.
    #[schemars(range(min = 1, max = 9_007_199_254_740_992_u64))]
    pub count: u64,
}

/// Parameters of the statistical mode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Statistical {
    /// 8-bit codes that each channel of a pixel may be off, 0.25 to 64. A pixel ends at 4096 samples in any case.
    #[schemars(range(min = 0.25, max = 64.0))]
    pub half_width: f64,
    /// How likely it is that it is not further off, 0.5 to 0.999.
    #[serde(default = "confidence")]
    #[schemars(range(min = 0.5, max = 0.999))]
    pub confidence: f64,
}

fn confidence() -> f64 {
    0.95
}

/// Longest chain of rays where a scene names none and nothing else ends it.
pub const DEFAULT_MAX_DEPTH: u32 = 10;
/// Smallest weight followed in the fixed mode where a scene names none.
const DEFAULT_MIN_WEIGHT: f64 = 0.001;

/// How to render.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RenderSettings {
    /// Longest chain of rays, 1 to 100000; the primary ray counts 1. Default 10 in the fixed mode; in the others none, so
    /// that pictures are held against recursion without end. With `max_depth` they are held against recursion to there.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 100_000))]
    pub max_depth: Option<u32>,
    /// Only in the fixed mode: a ray whose weight is below this in every channel is not followed, nor is a light asked for
    /// that could add less than a quarter of this share of itself, 0 to 1. Default 0.001.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_weight: Option<f64>,
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
    /// What ends the recursion. Default `{"proved": {"max_codes": 1}}`, and `{"fixed": {}}` where `max_depth` or `min_weight`
    /// is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            max_depth: None,
            min_weight: None,
            samples: None,
            antialias: true,
            shadows: Shadows::default(),
            color_bleeding: false,
            precision: Precision::default(),
            accuracy: None,
        }
    }
}

impl RenderSettings {
    /// What ends the recursion, also where the scene does not say.
    pub fn accuracy(&self) -> Accuracy {
        match self.accuracy {
            Some(accuracy) => accuracy,
            None if self.max_depth.is_some() || self.min_weight.is_some() => Accuracy::Fixed(Fixed {}),
            None => Accuracy::Proved(Proved { max_codes: 1 }),
        }
    }

    /// The same settings, with what they leave open written down.
    #[must_use]
    pub fn resolved(self) -> Self {
        let accuracy = self.accuracy();
        let fixed = matches!(accuracy, Accuracy::Fixed(_));
        Self {
            accuracy: Some(accuracy),
            max_depth: if fixed { Some(self.fixed_depth()) } else { self.max_depth },
            min_weight: fixed.then(|| self.fixed_weight()),
            ..self
        }
    }

    /// The longest chain of rays that the fixed mode follows.
    pub fn fixed_depth(&self) -> u32 {
        self.max_depth.unwrap_or(DEFAULT_MAX_DEPTH)
    }

    /// The smallest weight that the fixed mode follows.
    pub fn fixed_weight(&self) -> f64 {
        self.min_weight.unwrap_or(DEFAULT_MIN_WEIGHT)
    }
}
