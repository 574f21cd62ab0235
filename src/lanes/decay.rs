//! Exponential decay, by polynomials of operations that round alike on every machine.

use super::power::{exp2, is_single};
use super::{Lanes, Real};
use std::f64::consts::LOG2_E;

/// e^-x of numbers of at least 0, infinity included; results below the smallest normal number are 0.
///
/// 2^(-x log2(e)), whose relative error is a few roundings times 1 + x, and whose absolute error is a few roundings.
#[inline(always)]
pub fn exp_minus<L: Lanes>(s: L::Simd, x: L) -> L {
    let lowest = L::lit(s, -L::Real::LOWEST);
    let y = x * L::lit(s, -LOG2_E);
    L::select(y.gt(lowest), exp2(s, y.max(lowest)), L::lit(s, 0.0))
}

/// (1 - e^-x)/x of numbers of at least 0: the mean of e^-u over [0, x]; 1 at 0 and 0 at infinity.
#[inline(always)]
pub fn mean_decay<L: Lanes>(s: L::Simd, x: L) -> L {
    let one = L::lit(s, 1.0);
    L::select(x.lt(one), mean_to_one(s, x.min(one)), (one - exp_minus(s, x)) / x)
}

/// 1 - e^-x of numbers of at least 0, infinity included: the light that a medium of optical depth x absorbs.
#[inline(always)]
pub fn opacity<L: Lanes>(s: L::Simd, x: L) -> L {
    let one = L::lit(s, 1.0);
    let low = x.min(one);
    L::select(x.lt(one), low * mean_to_one(s, low), one - exp_minus(s, x))
}

/// (1 - e^-x)/x = 1 - x/2 (1 - x/3 (1 - x/4 ...)) over [0, 1], where the difference would cancel.
#[inline(always)]
fn mean_to_one<L: Lanes>(s: L::Simd, x: L) -> L {
    let one = L::lit(s, 1.0);
    // The next term is below a rounding of the sum: 1 / (n + 1)!.
    let terms = if is_single::<L>() { 10 } else { 18 };
    let mut sum = one;
    for k in (2..=terms).rev() {
        sum = one - x * L::lit(s, 1.0 / f64::from(k)) * sum;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From 2^-60 to 2^12, and 0.
    fn numbers() -> impl Iterator<Item = f64> {
        (-600..120).map(|i| libm::exp2(f64::from(i) / 10.0)).chain([0.0])
    }

    #[test]
    fn decay_agrees_with_libm() {
        for x in numbers() {
            let (got, expected) = (exp_minus((), x), libm::exp(-x));
            assert!((got - expected).abs() <= 4e-16 * (1.0 + x) * expected + 1e-300, "{x}: {got} {expected}");
            let narrow = x as f32;
            let (got, expected) = (f64::from(exp_minus((), narrow)), libm::exp(-f64::from(narrow)));
            assert!((got - expected).abs() <= 2e-7 * (1.0 + x) * expected + 1e-37, "{narrow}: {got} {expected}");
        }
        assert_eq!((exp_minus((), 0.0f32), exp_minus((), 0.0f64)), (1.0, 1.0));
        assert_eq!((exp_minus((), f32::INFINITY), exp_minus((), f64::INFINITY)), (0.0, 0.0));
    }

    #[test]
    fn mean_decay_keeps_its_digits() {
        for x in numbers() {
            let expected = if x == 0.0 { 1.0 } else { -libm::expm1(-x) / x };
            let got = mean_decay((), x);
            assert!((got - expected).abs() <= 1e-15 * expected, "{x}: {got} {expected}");
            let (got, expected) = (opacity((), x), -libm::expm1(-x));
            assert!((got - expected).abs() <= 1e-15 * expected, "{x}: {got} {expected}");
            let narrow = x as f32;
            let expected = if x == 0.0 { 1.0 } else { -libm::expm1(-f64::from(narrow)) / f64::from(narrow) };
            let got = f64::from(mean_decay((), narrow));
            assert!((got - expected).abs() <= 5e-7 * expected, "{narrow}: {got} {expected}");
        }
        assert_eq!((opacity((), f32::INFINITY), opacity((), f64::INFINITY)), (1.0, 1.0));
        assert_eq!((mean_decay((), f32::INFINITY), mean_decay((), f64::INFINITY)), (0.0, 0.0));
    }
}
