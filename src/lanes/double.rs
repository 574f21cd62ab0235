//! Lanes of f64: what is looked up for single rays in full precision, and the hashes of its whole numbers.

use super::ids::Wide;
use super::{Lanes, MAX_LANES};
use fearless_simd::{Simd, SimdBase, f64x8, mask64x8, prelude::*, u64x8};

/// Lanes of f64 whose whole numbers can be hashed.
pub trait Double: Lanes<Real = f64> {
    /// Whole numbers as 64 bits with a sign; those beyond are the last ones.
    fn whole(self) -> Self::Ids;
    /// Whole numbers from 0 on, as indices.
    fn indices(self) -> [usize; MAX_LANES];
    /// A hash without collisions of `hash ^ number` (the finaliser of SplitMix64).
    fn hash(s: Self::Simd, hash: Self::Ids, number: Self::Ids) -> Self::Ids;
    /// Where a bit is set.
    fn bit(s: Self::Simd, of: Self::Ids, bit: u32) -> Self::Mask;
}

const STEP: u64 = 0x9e37_79b9_7f4a_7c15;
const FIRST: u64 = 0xbf58_476d_1ce4_e5b9;
const SECOND: u64 = 0x94d0_49bb_1331_11eb;

impl<S: Simd> Double for f64x8<S> {
    #[inline(always)]
    fn whole(self) -> Wide<S> {
        Wide(self.to_int_precise::<fearless_simd::i64x8<S>>().bitcast())
    }
    #[inline(always)]
    fn indices(self) -> [usize; MAX_LANES] {
        let whole = self.whole();
        let mut indices = [0; MAX_LANES];
        for lane in 0..Self::COUNT {
            indices[lane] = whole.0.as_slice()[lane] as usize;
        }
        indices
    }
    #[inline(always)]
    fn hash(s: S, hash: Wide<S>, number: Wide<S>) -> Wide<S> {
        let splat = |x: u64| <u64x8<S> as SimdBase<S>>::splat(s, x);
        let x = (hash.0 ^ number.0) + splat(STEP);
        let x = (x ^ (x >> 30)) * splat(FIRST);
        let x = (x ^ (x >> 27)) * splat(SECOND);
        Wide(x ^ (x >> 31))
    }
    #[inline(always)]
    fn bit(s: S, of: Wide<S>, bit: u32) -> mask64x8<S> {
        let bit = <u64x8<S> as SimdBase<S>>::splat(s, 1 << bit);
        (of.0 & bit).simd_eq(bit)
    }
}

impl Double for f64 {
    #[inline(always)]
    fn whole(self) -> u64 {
        (self as i64).cast_unsigned()
    }
    #[inline(always)]
    fn indices(self) -> [usize; MAX_LANES] {
        let mut indices = [0; MAX_LANES];
        indices[0] = self as usize;
        indices
    }
    #[inline(always)]
    fn hash((): (), hash: u64, number: u64) -> u64 {
        let x = (hash ^ number).wrapping_add(STEP);
        let x = (x ^ (x >> 30)).wrapping_mul(FIRST);
        let x = (x ^ (x >> 27)).wrapping_mul(SECOND);
        x ^ (x >> 31)
    }
    #[inline(always)]
    fn bit((): (), of: u64, bit: u32) -> bool {
        of >> bit & 1 != 0
    }
}
