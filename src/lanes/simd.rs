//! 16 lanes of f32 and 8 lanes of f64, on `fearless_simd`.
//!
//! The width is fixed, not the processor's: 16 lanes are one AVX-512 register, two of AVX2 and four of SSE or NEON,
//! so a packet of rays has the same shape everywhere.

use super::ids::{Narrow, Wide};
use super::scalar::Layout;
use super::{Lanes, Mask};
use fearless_simd::{Simd, f32x16, f64x8, mask32x16, mask64x8, prelude::*, u32x16, u64x8};

macro_rules! simd {
    ($vector:ident, $mask:ident, $real:ident, $bits:ident, $ids:ident, $count:expr) => {
        impl<S: Simd> Mask for $mask<S> {
            #[inline(always)]
            fn any(self) -> bool {
                self.any_true()
            }
            #[inline(always)]
            fn bits(self) -> u32 {
                self.to_bitmask() as u32
            }
        }

        impl<S: Simd> Lanes for $vector<S> {
            type Real = $real;
            type Mask = $mask<S>;
            type Ids = $ids<S>;
            type Simd = S;
            type Double = f64x8<S>;
            const COUNT: usize = $count;

            #[inline(always)]
            fn vectorize<T>(s: S, f: impl FnOnce() -> T) -> T {
                s.vectorize(f)
            }
            #[inline(always)]
            fn splat(s: S, x: $real) -> Self {
                SimdBase::splat(s, x)
            }
            #[inline(always)]
            fn from_fn(s: S, f: impl FnMut(usize) -> $real) -> Self {
                SimdBase::from_fn(s, f)
            }
            #[inline(always)]
            fn load(s: S, from: &[$real]) -> Self {
                SimdBase::from_slice(s, &from[..$count])
            }
            #[inline(always)]
            fn store(self, to: &mut [$real]) {
                to[..$count].copy_from_slice(self.as_slice());
            }
            #[inline(always)]
            fn mask(s: S, bits: u32) -> Self::Mask {
                SimdMask::from_bitmask(s, u64::from(bits))
            }
            #[inline(always)]
            fn lane(self, i: usize) -> $real {
                self.as_slice()[i]
            }
            #[inline(always)]
            fn smallest(self) -> $real {
                self.reduce_min()
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                SimdFloat::sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                SimdBase::abs(self)
            }
            #[inline(always)]
            fn floor(self) -> Self {
                SimdFloat::floor(self)
            }
            #[inline(always)]
            fn exponent(self) -> Self {
                // As the last bits of a number whose last bit counts 1.
                let bits = (self.bitcast::<$bits<S>>() >> Layout::<$real>::SHIFT) | Layout::<$real>::WHOLE.to_bits();
                bits.bitcast::<Self>() - (Layout::<$real>::WHOLE + Layout::<$real>::BIAS)
            }
            #[inline(always)]
            fn significand(self) -> Self {
                let bits = self.bitcast::<$bits<S>>() & ((1 << Layout::<$real>::SHIFT) - 1);
                (bits | $real::to_bits(1.0)).bitcast()
            }
            #[inline(always)]
            fn power_of_two(self) -> Self {
                let whole = self + (Layout::<$real>::WHOLE + Layout::<$real>::BIAS);
                (whole.bitcast::<$bits<S>>() << Layout::<$real>::SHIFT).bitcast()
            }
            #[inline(always)]
            fn lt(self, other: Self) -> Self::Mask {
                self.simd_lt(other)
            }
            #[inline(always)]
            fn le(self, other: Self) -> Self::Mask {
                self.simd_le(other)
            }
            #[inline(always)]
            fn eq(self, other: Self) -> Self::Mask {
                self.simd_eq(other)
            }
            #[inline(always)]
            fn select(mask: Self::Mask, a: Self, b: Self) -> Self {
                mask.select(a, b)
            }
            // One instruction instead of two. On x86 it keeps the second operand unless the first is less (or greater), as
            // the comparison does; other machines treat NaN otherwise.
            #[cfg(target_arch = "x86_64")]
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                SimdBase::min(self, other)
            }
            #[cfg(target_arch = "x86_64")]
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                SimdBase::max(self, other)
            }
        }
    };
}

simd!(f32x16, mask32x16, f32, u32x16, Narrow, 16);
simd!(f64x8, mask64x8, f64, u64x8, Wide, 8);

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::Level;

    /// Every pair of these in some lane: the answer must be that of one lane, to the bit.
    const EDGES: [f32; 8] = [0.0, -0.0, 1.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MIN_POSITIVE];

    #[inline(always)]
    fn compare<S: Simd>(s: S) {
        for shift in 0..8 {
            let at = |i: usize| (EDGES[i % 8], EDGES[(i + shift) % 8]);
            let (a, b) = (<f32x16<S> as Lanes>::from_fn(s, |i| at(i).0), <f32x16<S> as Lanes>::from_fn(s, |i| at(i).1));
            let (low, high) = (Lanes::min(a, b), Lanes::max(a, b));
            let wide = |f: fn((f32, f32)) -> f32| <f64x8<S> as Lanes>::from_fn(s, |i| f64::from(f(at(i))));
            let (c, d) = (wide(|pair| pair.0), wide(|pair| pair.1));
            let (low_64, high_64) = (Lanes::min(c, d), Lanes::max(c, d));
            for i in 0..8 {
                let (x, y) = at(i);
                let expected = [Lanes::min(x, y), Lanes::max(x, y)];
                assert_eq!([low.lane(i), high.lane(i)].map(f32::to_bits), expected.map(f32::to_bits), "{x} {y}");
                let expected = [Lanes::min(f64::from(x), f64::from(y)), Lanes::max(f64::from(x), f64::from(y))];
                assert_eq!([low_64.lane(i), high_64.lane(i)].map(f64::to_bits), expected.map(f64::to_bits), "{x} {y}");
            }
        }
    }

    #[test]
    fn smaller_and_larger_are_those_of_one_lane_with_nan_and_zeros() {
        let best = Level::new();
        fearless_simd::dispatch!(best, s => compare(s));
        #[cfg(target_arch = "x86_64")]
        {
            let lower =
                [best.as_sse2().map(Level::Sse2), best.as_sse4_2().map(Level::Sse4_2), best.as_avx2().map(Level::Avx2)];
            for level in lower.into_iter().flatten() {
                fearless_simd::dispatch!(level, s => compare(s));
            }
        }
    }
}
