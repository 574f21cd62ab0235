//! How far one picture is from another, by every metric.

use super::{CodeErrors, Image8, Spread, ciede2000, code_errors, flip};
use crate::math;
use schemars::JsonSchema;
use serde::Serialize;

/// How far a picture is from its reference, by every measure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Difference {
    /// In 8-bit codes of the worst channel.
    pub codes: CodeErrors,
    /// Square root of the mean square over all channels, in codes.
    pub rms_codes: f64,
    /// FLIP, 0 to 1.
    pub flip: Spread,
    /// CIEDE2000; 1 is just visible.
    pub ciede2000: Spread,
}

impl Difference {
    /// Compares two pictures of one size.
    pub fn of(reference: &Image8, test: &Image8) -> Self {
        let codes = code_errors(reference, test);
        let rms_codes = codes.psnr.map_or(0.0, |psnr| 255.0 / math::pow(10.0, psnr / 20.0));
        Self { codes, rms_codes, flip: flip(reference, test), ciede2000: ciede2000(reference, test) }
    }
}
