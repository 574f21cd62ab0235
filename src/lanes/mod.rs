//! SIMD lanes: the numbers that the tracing kernel is written over.
//!
//! Camera, intersection, shading and the loop over rays exist once, generic over [`Lanes`]. Instances are 16 lanes of
//! f32 (`single`), 8 lanes of f64 (`double`) on [`fearless_simd`], and one lane, where a bare `f32` or `f64` is its
//! own bundle. Every operation rounds once and nothing is fused, so that all of them compute the same bits, whatever
//! the instruction set.
//!
//! **Every function over lanes must be `#[inline(always)]`**, or run inside [`Lanes::vectorize`]: otherwise it is
//! compiled for the baseline instruction set and the program becomes 3 to 19 times slower, while its results stay
//! correct.

mod angle;
mod circle;
mod columns;
mod decay;
mod dispatch;
mod double;
mod ids;
mod level;
mod power;
mod scalar;
mod simd;
mod vector;

pub use angle::angle;
pub use circle::circle;
pub(crate) use columns::{Column, Columns, parts};
pub use decay::{exp_minus, mean_decay, opacity};
pub(crate) use dispatch::dispatch;
pub use double::Double;
pub use ids::Ids;
pub use level::instructions;
pub(crate) use power::is_single;
pub use power::{log2, power};
pub use vector::V3;

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Most lanes of any bundle. Arrays with one entry for each lane have this length.
pub const MAX_LANES: usize = 16;

/// f32 or f64.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialOrd
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// Lanes of the widest bundle of this format.
    const LANES: usize;
    /// Unit roundoff u: half the distance from 1 to the next number.
    const ROUNDOFF: f64;
    /// The smallest normal number, 2^-LOWEST.
    const SMALLEST: f64;
    /// Its exponent, negated.
    const LOWEST: f64;
    /// The nearest number of this format.
    fn from_f64(x: f64) -> Self;
    /// The same value in 64 bits.
    fn to_f64(self) -> f64;
    /// The nearest whole number, if that is from 0 to 15; of other numbers any of these.
    fn nearest_of_16(self) -> usize;
}

/// One truth value for each lane.
pub trait Mask: Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Whether it is true in any lane.
    fn any(self) -> bool;
    /// Bit i is lane i.
    fn bits(self) -> u32;
}

/// A bundle of reals.
pub trait Lanes:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// The number in each lane.
    type Real: Real;
    /// The result of a comparison.
    type Mask: Mask;
    /// An identifier in each lane.
    type Ids: Ids<Simd = Self::Simd, Mask = Self::Mask>;
    /// Proof that the processor has the instructions.
    type Simd: Copy;
    /// Lanes of f64 on the same instructions, as many or half as many.
    type Double: Double<Simd = Self::Simd>;
    /// Number of lanes.
    const COUNT: usize;
    /// All lanes, a bit for each.
    const ALL: u32 = ((1u64 << Self::COUNT) - 1) as u32;

    /// Runs `f`, which must be `#[inline(always)]`, compiled for the instruction set of `s`.
    fn vectorize<T>(s: Self::Simd, f: impl FnOnce() -> T) -> T;
    /// The same number in all lanes.
    fn splat(s: Self::Simd, x: Self::Real) -> Self;
    /// Lane i gets `f(i)`.
    fn from_fn(s: Self::Simd, f: impl FnMut(usize) -> Self::Real) -> Self;
    /// The first [`Self::COUNT`] numbers of a slice.
    fn load(s: Self::Simd, from: &[Self::Real]) -> Self;
    /// True in the lanes whose bits are set.
    fn mask(s: Self::Simd, bits: u32) -> Self::Mask;
    /// Writes the lanes to the first [`Self::COUNT`] places of a slice.
    fn store(self, to: &mut [Self::Real]);
    /// The number in lane `i`.
    fn lane(self, i: usize) -> Self::Real;
    /// The smallest number in any lane; no lane may hold NaN.
    fn smallest(self) -> Self::Real;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Largest integer not above.
    fn floor(self) -> Self;
    /// The whole number e with 2^e <= x < 2^(e+1), of normal numbers above 0; one below the lowest of others.
    fn exponent(self) -> Self;
    /// x / 2^e in [1, 2), of normal numbers above 0.
    fn significand(self) -> Self;
    /// 2^x of whole numbers for which that is a normal number.
    fn power_of_two(self) -> Self;
    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self == other`.
    fn eq(self, other: Self) -> Self::Mask;
    /// `a` where the mask is true, `b` elsewhere.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;

    /// `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// `self >= other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// The smaller one; `other` if either is NaN, on every machine.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.lt(other), self, other)
    }
    /// The larger one; `other` if either is NaN, on every machine.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.lt(self), self, other)
    }
    /// A constant in all lanes.
    #[inline(always)]
    fn lit(s: Self::Simd, x: f64) -> Self {
        Self::splat(s, Self::Real::from_f64(x))
    }
}

/// The lanes of a set of bits, lowest first.
#[inline(always)]
pub fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let lane = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            lane
        })
    })
}
