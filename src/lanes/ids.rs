//! Identifiers of primitives, bodies, materials and lists of media, one for each lane.

use super::Mask;
use fearless_simd::{Simd, SimdBase, mask32x16, mask64x8, prelude::*, u32x16, u64x8};
use std::fmt::Debug;

/// A 64-bit identifier in each lane: compared and selected, never computed with.
pub trait Ids: Copy + Debug {
    /// Proof that the processor has the instructions.
    type Simd: Copy;
    /// What a comparison gives.
    type Mask: Mask;

    /// The same identifier in all lanes.
    fn splat(s: Self::Simd, id: u64) -> Self;
    /// Lane i gets `f(i)`.
    fn from_fn(s: Self::Simd, f: impl FnMut(usize) -> u64) -> Self;
    /// The identifier in lane `i`.
    fn lane(self, i: usize) -> u64;
    /// Where both are the same.
    fn eq(self, other: Self) -> Self::Mask;
    /// Where this one is not below the other.
    fn ge(self, other: Self) -> Self::Mask;
    /// `a` where the mask is true, `b` elsewhere.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;

    /// The identifier of the lowest lane of `among`, and the lanes of `among` that have it.
    #[inline(always)]
    fn same_as_first(self, s: Self::Simd, among: u32) -> (u64, u32) {
        let id = self.lane(among.trailing_zeros() as usize);
        (id, self.eq(Self::splat(s, id)).bits() & among)
    }
}

/// For lanes of 32-bit numbers: the lower and the upper halves.
#[derive(Debug, Clone, Copy)]
pub struct Narrow<S: Simd> {
    low: u32x16<S>,
    high: u32x16<S>,
}

impl<S: Simd> Ids for Narrow<S> {
    type Simd = S;
    type Mask = mask32x16<S>;

    #[inline(always)]
    fn splat(s: S, id: u64) -> Self {
        Self { low: SimdBase::splat(s, id as u32), high: SimdBase::splat(s, (id >> 32) as u32) }
    }
    #[inline(always)]
    fn from_fn(s: S, mut f: impl FnMut(usize) -> u64) -> Self {
        let (mut low, mut high) = ([0; 16], [0; 16]);
        for lane in 0..16 {
            let id = f(lane);
            (low[lane], high[lane]) = (id as u32, (id >> 32) as u32);
        }
        Self { low: SimdBase::from_slice(s, &low), high: SimdBase::from_slice(s, &high) }
    }
    #[inline(always)]
    fn lane(self, i: usize) -> u64 {
        u64::from(self.high.as_slice()[i]) << 32 | u64::from(self.low.as_slice()[i])
    }
    #[inline(always)]
    fn eq(self, other: Self) -> mask32x16<S> {
        self.low.simd_eq(other.low) & self.high.simd_eq(other.high)
    }
    #[inline(always)]
    fn ge(self, other: Self) -> mask32x16<S> {
        self.high.simd_gt(other.high) | (self.high.simd_eq(other.high) & self.low.simd_ge(other.low))
    }
    #[inline(always)]
    fn select(mask: mask32x16<S>, a: Self, b: Self) -> Self {
        Self { low: mask.select(a.low, b.low), high: mask.select(a.high, b.high) }
    }
}

/// For lanes of 64-bit numbers.
#[derive(Debug, Clone, Copy)]
pub struct Wide<S: Simd>(pub(super) u64x8<S>);

impl<S: Simd> Ids for Wide<S> {
    type Simd = S;
    type Mask = mask64x8<S>;

    #[inline(always)]
    fn splat(s: S, id: u64) -> Self {
        Self(SimdBase::splat(s, id))
    }
    #[inline(always)]
    fn from_fn(s: S, f: impl FnMut(usize) -> u64) -> Self {
        Self(SimdBase::from_fn(s, f))
    }
    #[inline(always)]
    fn lane(self, i: usize) -> u64 {
        self.0.as_slice()[i]
    }
    #[inline(always)]
    fn eq(self, other: Self) -> mask64x8<S> {
        self.0.simd_eq(other.0)
    }
    #[inline(always)]
    fn ge(self, other: Self) -> mask64x8<S> {
        self.0.simd_ge(other.0)
    }
    #[inline(always)]
    fn select(mask: mask64x8<S>, a: Self, b: Self) -> Self {
        Self(mask.select(a.0, b.0))
    }
}

impl Ids for u64 {
    type Simd = ();
    type Mask = bool;

    #[inline(always)]
    fn splat((): (), id: u64) -> Self {
        id
    }
    #[inline(always)]
    fn from_fn((): (), mut f: impl FnMut(usize) -> Self) -> Self {
        f(0)
    }
    #[inline(always)]
    fn lane(self, _: usize) -> u64 {
        self
    }
    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }
    #[inline(always)]
    fn ge(self, other: Self) -> bool {
        self >= other
    }
    #[inline(always)]
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }
}
