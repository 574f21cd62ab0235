//! One lane: f32 and f64 as bundles of themselves.

use super::{Lanes, Mask, Real};

/// How a format lays out its numbers (IEEE 754).
pub(super) struct Layout<R>(std::marker::PhantomData<R>);

impl Layout<f32> {
    /// Bits below the exponent.
    pub(super) const SHIFT: u32 = 23;
    /// The least number whose last bit counts 1.
    pub(super) const WHOLE: f32 = 8_388_608.0;
    /// The exponent field of 1.
    pub(super) const BIAS: f32 = 127.0;
}

impl Layout<f64> {
    pub(super) const SHIFT: u32 = 52;
    pub(super) const WHOLE: f64 = 4_503_599_627_370_496.0;
    pub(super) const BIAS: f64 = 1023.0;
}

impl Mask for bool {
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }
}

macro_rules! scalar {
    ($type:ident, $lanes:expr, $roundoff:expr, $narrow:expr) => {
        impl Real for $type {
            const LANES: usize = $lanes;
            const ROUNDOFF: f64 = $roundoff;
            const SMALLEST: f64 = $type::MIN_POSITIVE as f64;
            const LOWEST: f64 = 1.0 - $type::MIN_EXP as f64;
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                $narrow(x)
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn nearest_of_16(self) -> usize {
                // Where numbers are whole, the last bits count them. A cast would also look for overflow and NaN.
                (self + 1.0 / $type::EPSILON).to_bits() as usize % 16
            }
        }

        impl Lanes for $type {
            type Real = $type;
            type Mask = bool;
            type Ids = u64;
            type Simd = ();
            type Double = f64;
            const COUNT: usize = 1;

            // What is a function of its own over sixteen lanes is one here, too.
            #[inline(never)]
            fn vectorize<T>((): (), f: impl FnOnce() -> T) -> T {
                f()
            }
            #[inline(always)]
            fn splat((): (), x: $type) -> Self {
                x
            }
            #[inline(always)]
            fn from_fn((): (), mut f: impl FnMut(usize) -> $type) -> Self {
                f(0)
            }
            #[inline(always)]
            fn load((): (), from: &[$type]) -> Self {
                from[0]
            }
            #[inline(always)]
            fn store(self, to: &mut [$type]) {
                to[0] = self;
            }
            #[inline(always)]
            fn mask((): (), bits: u32) -> bool {
                bits & 1 != 0
            }
            #[inline(always)]
            fn lane(self, _: usize) -> $type {
                self
            }
            #[inline(always)]
            fn smallest(self) -> $type {
                self
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                <$type>::sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$type>::abs(self)
            }
            #[inline(always)]
            fn floor(self) -> Self {
                <$type>::floor(self)
            }
            #[inline(always)]
            fn exponent(self) -> Self {
                let bits = (self.to_bits() >> Layout::<$type>::SHIFT) | Layout::<$type>::WHOLE.to_bits();
                $type::from_bits(bits) - (Layout::<$type>::WHOLE + Layout::<$type>::BIAS)
            }
            #[inline(always)]
            fn significand(self) -> Self {
                let bits = self.to_bits() & ((1 << Layout::<$type>::SHIFT) - 1);
                $type::from_bits(bits | $type::to_bits(1.0))
            }
            #[inline(always)]
            fn power_of_two(self) -> Self {
                let whole = self + (Layout::<$type>::WHOLE + Layout::<$type>::BIAS);
                $type::from_bits(whole.to_bits() << Layout::<$type>::SHIFT)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn le(self, other: Self) -> bool {
                self <= other
            }
            #[inline(always)]
            fn eq(self, other: Self) -> bool {
                self == other
            }
            #[inline(always)]
            fn select(mask: bool, a: Self, b: Self) -> Self {
                if mask { a } else { b }
            }
        }
    };
}

scalar!(f32, 16, 1.0 / 16_777_216.0, |x: f64| x as f32);
scalar!(f64, 8, 1.0 / 9_007_199_254_740_992.0, |x: f64| x);
