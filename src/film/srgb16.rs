//! Linear light to 16-bit sRGB codes: exact, and eight times as fast as a power function for each channel.
//!
//! With 65,536 codes, several thresholds share a bucket of any table that fits into the caches. So linear interpolation in
//! a coarse table gives the code or a neighbour of it, and the thresholds around it decide.

use super::srgb::{clamp, code16};
use crate::math;
use std::sync::OnceLock;

/// Everything below has code 0: the first threshold is near 5.9e-7.
const FLOOR: f32 = 1.0 / 2_097_152.0;
/// Mantissa bits that select a point of the curve: with 128 for each power of two, the chord leaves the curve by at
/// most an eighth of a code.
const CURVE_BITS: u32 = 7;
const SHIFT: u32 = f32::MANTISSA_DIGITS - 1 - CURVE_BITS;

/// The table behind [`code16`], for many values.
#[derive(Debug)]
pub struct Codes16 {
    /// 65535 oetf(x) + 0.5 at the floats whose lower bits are 0, from [`FLOOR`] to beyond 1.
    curve: Vec<f32>,
    /// The least value of each code, and infinity behind the last.
    thresholds: Vec<f32>,
}

impl Codes16 {
    /// The table, built on first use, which takes some 10 ms.
    pub fn get() -> &'static Self {
        static TABLE: OnceLock<Codes16> = OnceLock::new();
        TABLE.get_or_init(Self::build)
    }

    fn build() -> Self {
        let points = FLOOR.to_bits() >> SHIFT..=(1.0_f32.to_bits() >> SHIFT) + 1;
        let curve = points.map(|i| {
            let x = f64::from(f32::from_bits(i << SHIFT));
            (65535.0 * math::linear_to_srgb(x) + 0.5) as f32
        });
        let thresholds = (1..=u16::MAX).map(threshold);
        Self {
            curve: curve.collect(),
            thresholds: std::iter::once(f32::NEG_INFINITY).chain(thresholds).chain([f32::INFINITY]).collect(),
        }
    }

    /// The 16-bit code of a linear value; NaN has code 0.
    #[inline]
    pub fn code(&self, linear: f32) -> u16 {
        let x = clamp(linear, FLOOR, 1.0);
        let bits = x.to_bits() - FLOOR.to_bits();
        let (point, beyond) = ((bits >> SHIFT) as usize, bits & ((1 << SHIFT) - 1));
        let [before, after] = [self.curve[point], self.curve[point + 1]];
        let guess = (before + (after - before) * (beyond as f32 / (1 << SHIFT) as f32)) as usize;
        let above = usize::from(x >= self.thresholds[guess + 1]);
        let below = usize::from(x < self.thresholds[guess]);
        (guess + above - below) as u16
    }
}

/// The least value of a code above 0: the inverse of the formula, and a few floats up or down by the formula itself.
fn threshold(code: u16) -> f32 {
    let mut x = math::srgb_to_linear((f64::from(code) - 0.5) / 65535.0) as f32;
    while code16(x) >= code {
        x = x.next_down();
    }
    while code16(x) < code {
        x = x.next_up();
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_is_the_formula_around_every_threshold() {
        let table = Codes16::get();
        for (code, &threshold) in table.thresholds.iter().enumerate().skip(1).take(65535) {
            assert_eq!(usize::from(table.code(threshold)), code);
            assert_eq!(usize::from(table.code(threshold.next_down())), code - 1);
        }
    }

    #[test]
    fn table_is_the_formula_everywhere() {
        let table = Codes16::get();
        // Every 641st float from 0 to beyond 2: about 1.7 million values.
        for bits in (0..0x4010_0000_u32).step_by(641) {
            let x = f32::from_bits(bits);
            assert_eq!(table.code(x), code16(x), "{x:e}");
        }
    }

    #[test]
    fn ends_and_odd_values() {
        let table = Codes16::get();
        for x in [f32::NAN, f32::NEG_INFINITY, -1.0, -0.0, 0.0, f32::MIN_POSITIVE] {
            assert_eq!(table.code(x), 0, "{x}");
        }
        for x in [1.0, 1.0_f32.next_up(), 1.5, f32::MAX, f32::INFINITY] {
            assert_eq!(table.code(x), 65535, "{x}");
        }
    }
}
