//! How to render.

use super::is_default;
use super::object::{is_false, is_true};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How shadow rays treat bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shadows {
    /// All bodies block light.
    #[default]
    Opaque,
    /// Each surface lets its transmission of the light pass, without bending the ray.
    Transmissive,
    /// No shadow rays at all.
    None,
}

/// How light gets from everywhere to surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Fidelity {
    /// Without rays: ambient light, or the surroundings, scattered and blurred, which nothing in the scene hides. No sample is
    /// needed.
    #[default]
    Fast,
    /// By rays: surfaces scatter and reflect what other surfaces, what glows and the surroundings send them, again and again, and
    /// bodies hide it. Each sample chooses a direction for each lobe.
    Faithful,
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

/// How accurate a picture must be, or how much it may cost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Accuracy {
    /// Rays are followed to `max_depth` and down to `min_weight`.
    Fixed(Fixed),
    /// Each pixel's rays are followed until a bound on its distance from recursion without end is proved.
    Proved(Proved),
    /// The best picture within a time. It depends on the machine. The report gives the number of rays that repeats it.
    Time(Time),
    /// The best picture for a number of rays: the same bytes on every machine.
    Rays(Rays),
    /// Each pixel gets samples until their spread shows that more would probably change it by no more than a half width.
    /// Recursion is proved as with `max_codes` 1. `samples` and `antialias` are ignored.
    Statistical(Statistical),
}

impl Accuracy {
    /// Whether a time or a number of rays ends it, for the whole picture and not for each pixel.
    pub fn is_budget(self) -> bool {
        matches!(self, Self::Time(_) | Self::Rays(_))
    }
}

/// Parameters of the fixed mode: none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fixed {}

/// Parameters of the proved mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Proved {
    /// Largest error of each channel in 8-bit codes, 0 to 2. 0 gives the PNG of recursion without end.
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
    /// Rays of all kinds, 1 to 2^53. The block of pixels that reaches the number is finished, and each pixel of a grid 32 pixels
    /// wide is traced in any case.
    #[schemars(range(min = 1, max = 9_007_199_254_740_992_u64))]
    pub count: u64,
}

/// Parameters of the statistical mode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Statistical {
    /// Largest error of each channel in 8-bit codes, 0.25 to 64. No pixel gets more than 4096 samples.
    #[schemars(range(min = 0.25, max = 64.0))]
    pub half_width: f64,
    /// Probability that the error is no larger, 0.5 to 0.999.
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
    /// Longest chain of rays, 1 to 100000. The camera ray counts 1. Default 10 in the mode `fixed`, and where nothing bounds the
    /// light that rays bring. In other modes the default is none, and pictures are compared with recursion without end; with `max_depth` they
    /// are compared with recursion to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 100_000))]
    pub max_depth: Option<u32>,
    /// Only in the mode `fixed`: rays whose weight is below this in every channel are not followed, and no shadow ray is traced
    /// for light that could add less than a quarter of it, 0 to 1. Default 0.001.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_weight: Option<f64>,
    /// Samples of each pixel, 1 to 1024. Default 1. In scenes with effects that choose at random (lights with an area, rough
    /// surfaces, a lens, motion, dispersion, color bleeding, global illumination) each pixel then gets 8 to 256, until it is likely within 1.5 codes
    /// of the mean of all.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 1024))]
    pub samples: Option<u32>,
    /// Whether pixels that differ from a neighbour get 4 to 16 samples, the more they differ. Default true.
    pub antialias: bool,
    /// What casts shadows. Default `"opaque"`.
    pub shadows: Shadows,
    /// Whether surfaces are lit by light that other surfaces scatter once. It replaces ambient light on surfaces that are seen
    /// directly, in mirrors or through glass. Default false.
    #[serde(skip_serializing_if = "is_false")]
    pub color_bleeding: bool,
    /// How light gets from everywhere to surfaces. `"faithful"` replaces ambient light, `color_bleeding` and `occlusion`, and what
    /// glows then lights other bodies. Default `"fast"`.
    #[serde(skip_serializing_if = "is_default")]
    pub fidelity: Fidelity,
    /// Whether a checkerboard is averaged over what each ray covers of it, so that it fades to grey far away. Images and noise
    /// always are. Default true.
    #[serde(skip_serializing_if = "is_true")]
    pub filter_checkers: bool,
    /// Floating-point format. Default `"single"`.
    pub precision: Precision,
    /// What ends the recursion. Default `{"proved": {"max_codes": 1}}`, or `{"fixed": {}}` if `max_depth` or `min_weight` is
    /// given.
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
            fidelity: Fidelity::default(),
            filter_checkers: true,
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
