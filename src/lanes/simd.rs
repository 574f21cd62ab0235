//! 16 lanes of f32 and 8 lanes of f64, on `fearless_simd`.
//!
//! The width is fixed, not the processor's: 16 lanes are one AVX-512 register, two of AVX2 and four of SSE or NEON,
//! so a packet of rays has the same shape everywhere.

use super::{Lanes, Mask};
use fearless_simd::{Simd, f32x16, f64x8, mask32x16, mask64x8, prelude::*};

macro_rules! simd {
    ($vector:ident, $mask:ident, $real:ident, $count:expr) => {
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
            type Simd = S;
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
            fn mask(s: S, bits: u32) -> Self::Mask {
                SimdMask::from_bitmask(s, u64::from(bits))
            }
            #[inline(always)]
            fn lane(self, i: usize) -> $real {
                self.as_slice()[i]
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
        }
    };
}

simd!(f32x16, mask32x16, f32, 16);
simd!(f64x8, mask64x8, f64, 8);
