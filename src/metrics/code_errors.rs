//! Errors in 8-bit codes, which is what a PNG holds.

use super::{Image8, Spread};
use schemars::JsonSchema;
use serde::Serialize;

/// How two pictures of 8-bit codes differ. A pixel's error is that of its worst channel.
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
    let worst = |(a, b): (&[u8; 3], &[u8; 3])| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
    let errors: Vec<f64> = a.pixels.iter().zip(&b.pixels).map(|pair| f64::from(worst(pair))).collect();
    let count = errors.len().max(1) as f64;
    let identical = errors.iter().filter(|error| **error == 0.0).count() as f64 / count;
    let channels = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let squares: f64 = channels.map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum();
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
        let a = Image8 { width: 2, pixels: vec![[10, 20, 30], [0, 0, 0]] };
        let same = code_errors(&a, &a);
        assert_eq!((same.error.max, same.identical, same.psnr), (0.0, 1.0, None));
        let b = Image8 { width: 2, pixels: vec![[10, 23, 30], [0, 0, 0]] };
        let other = code_errors(&a, &b);
        assert_eq!((other.error.max, other.error.mean, other.identical), (3.0, 1.5, 0.5));
        assert!((other.psnr.unwrap() - 10.0 * math::log2(65025.0 / 1.5) / math::log2(10.0)).abs() < 1e-12);
    }
}
