//! Linear light to 8-bit sRGB codes (IEC 61966-2-1), exact and by table.
//!
//! The 8-bit code of x is `floor(255 oetf(clamp(x, 0, 1)) + 0.5)`. A power function for each channel would take
//! longer than tracing a simple pixel. So the 255 thresholds where the code changes are computed once, and a table over
//! the leading bits of x names the only threshold that can lie near x.

use crate::math;
use std::sync::OnceLock;

/// Everything below has code 0: the first threshold is near 1.5e-4.
const FLOOR: f32 = 1.0 / 8192.0;
/// The largest value below 1; it has code 255.
const CEILING: f32 = 1.0 - f32::EPSILON / 2.0;
/// Mantissa bits that select a bucket: 128 buckets for each power of two, which is the least that keeps two
/// thresholds out of one bucket.
const BUCKET_BITS: u32 = 7;
const SHIFT: u32 = f32::MANTISSA_DIGITS - 1 - BUCKET_BITS;

/// Values that are looked up at a time.
const BLOCK: usize = 32;

/// The table behind [`code8`].
#[derive(Debug)]
pub struct Codes8 {
    /// One number for each bucket of values whose bits agree down to [`SHIFT`]. Its upper bits are the code of the bucket's
    /// first value. Its lower bits are chosen so that adding a value's lower bits carries into the code from the threshold
    /// on.
    steps: Vec<u32>,
    /// The smallest value that has each code.
    least: Vec<f32>,
}

impl Codes8 {
    /// The table, built on first use.
    pub fn get() -> &'static Self {
        static TABLE: OnceLock<Codes8> = OnceLock::new();
        TABLE.get_or_init(Self::build)
    }

    fn build() -> Self {
        let first = FLOOR.to_bits() >> SHIFT;
        let last = CEILING.to_bits() >> SHIFT;
        let steps = (first..=last).map(|bucket| {
            let start = bucket << SHIFT;
            let code = formula8(f32::from_bits(start));
            // Bisection over the bits, which are in the order of the values.
            let (mut low, mut high) = (start, start + (1 << SHIFT));
            while high - low > 1 {
                let middle = low + (high - low) / 2;
                if formula8(f32::from_bits(middle)) > code {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            // A bucket without a threshold has its `high` at its end, so nothing carries.
            (code << SHIFT) + (start + (1 << SHIFT) - high)
        });
        let mut table = Self { steps: steps.collect(), least: Vec::new() };
        table.least = (0..=u8::MAX).map(|code| table.search_least(code)).collect();
        table
    }

    /// The 8-bit code of a linear value; NaN has code 0.
    #[inline]
    pub fn code(&self, linear: f32) -> u8 {
        self.look_up(place(linear))
    }

    /// The codes of a value and of one a little below it, in most cases with one lookup.
    #[inline]
    pub(crate) fn code_and_lower(&self, linear: f32, lower: f32) -> [u8; 2] {
        let (place, lower) = (place(linear), place(lower));
        let step = self.steps[(place >> SHIFT) as usize];
        let code = |step: u32, place: u32| ((step + (place & ((1 << SHIFT) - 1))) >> SHIFT) as u8;
        let same = place >> SHIFT == lower >> SHIFT;
        [code(step, place), if same { code(step, lower) } else { self.look_up(lower) }]
    }

    /// The smallest value that has a code.
    #[inline]
    pub fn least(&self, code: u8) -> f32 {
        self.least[usize::from(code)]
    }

    fn search_least(&self, code: u8) -> f32 {
        if code == 0 {
            return 0.0;
        }
        let (mut low, mut high) = (FLOOR.to_bits(), CEILING.to_bits());
        if self.code(FLOOR) >= code {
            return FLOOR;
        }
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if self.code(f32::from_bits(middle)) >= code { high = middle } else { low = middle }
        }
        f32::from_bits(high)
    }

    /// The codes of many values. The indices of a block are computed first, which the compiler vectorises, and only the table
    /// is read one by one: half the time of one by one altogether.
    pub fn codes(&self, linear: &[f32], codes: &mut [u8]) {
        let (blocks, rest) = linear.as_chunks::<BLOCK>();
        let (codes_of_blocks, codes_of_rest) = codes.as_chunks_mut::<BLOCK>();
        for (block, codes) in blocks.iter().zip(codes_of_blocks) {
            for (place, code) in block.map(place).into_iter().zip(codes) {
                *code = self.look_up(place);
            }
        }
        for (&linear, code) in rest.iter().zip(codes_of_rest) {
            *code = self.code(linear);
        }
    }

    #[inline]
    fn look_up(&self, place: u32) -> u8 {
        ((self.steps[(place >> SHIFT) as usize] + (place & ((1 << SHIFT) - 1))) >> SHIFT) as u8
    }
}

/// How many floats a value lies above [`FLOOR`], a power of two: its bucket, and its lower bits.
#[inline]
fn place(linear: f32) -> u32 {
    clamp(linear, FLOOR, CEILING).to_bits() - FLOOR.to_bits()
}

/// The 8-bit code of one linear value. For many values, call [`Codes8::get`] once.
pub fn code8(linear: f32) -> u8 {
    Codes8::get().code(linear)
}

/// The 16-bit code of a linear value, by the formula; NaN has code 0. For many values there is
/// [`Codes16`](super::srgb16::Codes16).
pub fn code16(linear: f32) -> u16 {
    formula(linear, 65535.0) as u16
}

/// Unlike `f32::clamp` this takes NaN to `low`.
#[inline]
pub(super) fn clamp(x: f32, low: f32, high: f32) -> f32 {
    let x = if x > low { x } else { low };
    if x < high { x } else { high }
}

fn formula8(linear: f32) -> u32 {
    formula(linear, 255.0)
}

fn formula(linear: f32, codes: f64) -> u32 {
    let clamped = f64::from(clamp(linear, 0.0, 1.0));
    (codes * math::linear_to_srgb(clamped) + 0.5).floor() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The code of each bucket's first value, and the bits of its threshold or of the next bucket.
    fn buckets() -> Vec<(u32, u32)> {
        let of = |(i, step): (u32, &u32)| (step >> SHIFT, FLOOR.to_bits() + ((i + 1) << SHIFT) - (step & 0xffff));
        (0..).zip(&Codes8::get().steps).map(of).collect()
    }

    #[test]
    fn no_bucket_holds_two_thresholds() {
        let buckets = buckets();
        for pair in buckets.windows(2) {
            assert!(pair[1].0 - pair[0].0 <= 1, "{pair:?}");
        }
        assert_eq!((buckets[0].0, buckets[buckets.len() - 1].0), (0, 255));
    }

    #[test]
    fn table_is_the_formula_around_every_threshold() {
        for (_, threshold) in buckets() {
            for bits in threshold - 40..threshold + 40 {
                let x = f32::from_bits(bits);
                assert_eq!(u32::from(code8(x)), formula8(x), "{x:e}");
            }
        }
    }

    #[test]
    fn two_values_have_the_codes_of_each() {
        for (_, threshold) in buckets() {
            for (above, below) in [(0, 1), (40, 0), (0, 1 << 15), (7, 1 << 20)] {
                let [x, lower] = [threshold + above, threshold.saturating_sub(below)].map(f32::from_bits);
                assert_eq!(Codes8::get().code_and_lower(x, lower), [x, lower].map(code8), "{x:e} {lower:e}");
            }
        }
    }

    #[test]
    fn many_values_have_the_codes_of_each() {
        let x: Vec<f32> =
            (0..1_000).map(|i| [i as f32 / 900.0 - 0.05, f32::NAN, 2.0][usize::from(i % 97 == 0)]).collect();
        for length in [0, 1, BLOCK - 1, BLOCK, BLOCK + 1, 1_000] {
            let mut codes = vec![0; length];
            Codes8::get().codes(&x[..length], &mut codes);
            let each: Vec<u8> = x[..length].iter().map(|&x| code8(x)).collect();
            assert_eq!(codes, each);
        }
    }

    #[test]
    fn table_is_the_formula_and_monotone_everywhere() {
        let mut before = 0;
        // Every 641st float from 0 to beyond 2: about 1.7 million values.
        for bits in (0..0x4010_0000_u32).step_by(641) {
            let x = f32::from_bits(bits);
            let code = code8(x);
            assert_eq!(u32::from(code), formula8(x), "{x:e}");
            assert!(code >= before, "{x:e}");
            before = code;
        }
    }

    #[test]
    fn ends_and_odd_values() {
        for x in [f32::NAN, -f32::NAN, f32::NEG_INFINITY, -1.0, -0.0, 0.0, f32::MIN_POSITIVE] {
            assert_eq!((code8(x), code16(x)), (0, 0), "{x}");
        }
        for x in [1.0, CEILING, 1.5, f32::MAX, f32::INFINITY] {
            assert_eq!(code8(x), 255, "{x}");
        }
        assert_eq!((code16(1.0), code16(f32::INFINITY)), (65535, 65535));
        assert_eq!((code8(0.5), code8(0.214_041_14)), (188, 128));
        // Every code comes back from the light it stands for.
        for code in 0..=255_u8 {
            assert_eq!(code8(math::srgb_to_linear(f64::from(code) / 255.0) as f32), code);
        }
    }
}
