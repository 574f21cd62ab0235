//! Errors in 8-bit codes, which is what a PNG holds.

use super::{Image8, Spread};
use schemars::JsonSchema;
use serde::Serialize;

/// How two pictures of 8-bit codes differ. A pixel's error is that of its worst channel. Where there is alpha, colors are those over
/// black, and each channel is off by at least as much as alpha.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "CodeErrors")]
pub struct CodeErrors {
    /// Errors in codes.
    pub error: Spread,
    /// Share of pixels that are the same in all channels.
    pub identical: f64,
    /// 10 log10(255^2 / mean square error) over all channels, in decibels; none for the same picture.
    pub psnr: Option<f64>,
}

/// Compares two pictures of one size.
pub fn code_errors(a: &Image8, b: &Image8) -> CodeErrors {
    let differences = a.differences(b);
    let errors: Vec<f64> = differences.iter().map(|off| f64::from(off.iter().copied().max().unwrap_or(0))).collect();
    let count = errors.len().max(1) as f64;
    let identical = errors.iter().filter(|error| **error == 0.0).count() as f64 / count;
    let squares: f64 = differences.as_flattened().iter().map(|off| f64::from(*off).powi(2)).sum();
    let mean = squares / (3.0 * count);
    let psnr = (mean > 0.0).then(|| 10.0 * libm::log10(255.0 * 255.0 / mean));
    CodeErrors { error: Spread::of(errors), identical, psnr }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    #[test]
    fn the_same_picture_has_no_error_and_one_channel_counts() {
        let a = Image8::opaque(2, vec![[10, 20, 30], [0, 0, 0]]);
        let same = code_errors(&a, &a);
        assert_eq!((same.error.max, same.identical, same.psnr), (0.0, 1.0, None));
        let b = Image8::opaque(2, vec![[10, 23, 30], [0, 0, 0]]);
        let other = code_errors(&a, &b);
        assert_eq!((other.error.max, other.error.mean, other.identical), (3.0, 1.5, 0.5));
        let clear = Image8 { alpha: vec![255, 200], ..a.clone() };
        let of_alpha = code_errors(&a, &clear);
        assert_eq!((of_alpha.error.max, of_alpha.identical), (55.0, 0.5));
        assert!((other.psnr.unwrap() - 10.0 * math::log2(65025.0 / 1.5) / math::log2(10.0)).abs() < 1e-12);
    }
}
