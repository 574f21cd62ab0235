//! Powers, by polynomials of operations that round alike on every machine.

use super::{Lanes, Real};
use std::f64::consts::{LN_2, LOG2_E, SQRT_2};

/// `base^exponent` for bases in [0, 1] and exponents of at least 0; 0^0 is 1, and results below the smallest normal number
/// are 0.
///
/// 2^(exponent log2(base)), whose relative error is a few roundings times the logarithm of the result.
#[inline(always)]
pub fn power<L: Lanes>(s: L::Simd, base: L, exponent: f64) -> L {
    if exponent == 0.0 {
        return L::lit(s, 1.0);
    }
    let smallest = L::lit(s, L::Real::SMALLEST);
    let y = log2(s, base.max(smallest)) * L::lit(s, exponent);
    let normal = y.gt(L::lit(s, -L::Real::LOWEST)) & base.ge(smallest);
    L::select(normal, exp2(s, y.max(L::lit(s, -L::Real::LOWEST))), L::lit(s, 0.0))
}

pub(crate) fn is_single<L: Lanes>() -> bool {
    L::Real::ROUNDOFF > 1e-10
}

/// Logarithm of normal numbers above 0: e + log2(m) for x = 2^e m with m around 1, where
/// ln(m) = 2 artanh(z) = 2 (z + z^3/3 + z^5/5 + ...) with z = (m - 1)/(m + 1), which is at most 0.172.
#[inline(always)]
pub fn log2<L: Lanes>(s: L::Simd, x: L) -> L {
    let one = L::lit(s, 1.0);
    let upper = x.significand().gt(L::lit(s, SQRT_2));
    let e = x.exponent() + L::select(upper, one, L::lit(s, 0.0));
    let m = x.significand() * L::select(upper, L::lit(s, 0.5), one);
    let z = (m - one) / (m + one);
    let zz = z * z;
    // The next term is below a rounding of the sum: 0.0295^n / (2 n + 1).
    let terms = if is_single::<L>() { 5 } else { 10 };
    let mut sum = L::lit(s, 1.0 / f64::from(2 * terms + 1));
    for k in (0..terms).rev() {
        sum = sum * zz + L::lit(s, 1.0 / f64::from(2 * k + 1));
    }
    e + z * sum * L::lit(s, 2.0 * LOG2_E)
}

/// 2^y for results that are normal numbers: 2^n e^(f ln 2) with f in [-1/2, 1/2].
#[inline(always)]
pub(super) fn exp2<L: Lanes>(s: L::Simd, y: L) -> L {
    let n = (y + L::lit(s, 0.5)).floor();
    let f = (y - n) * L::lit(s, LN_2);
    // The next term is below a rounding of the sum: 0.347^n / n!.
    let terms = if is_single::<L>() { 8 } else { 14 };
    let mut sum = L::lit(s, 1.0);
    for k in (1..terms).rev() {
        sum = sum * f * L::lit(s, 1.0 / f64::from(k)) + L::lit(s, 1.0);
    }
    sum * n.power_of_two()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    #[test]
    fn powers_agree_with_libm() {
        for exponent in [0.0, 0.001, 0.5, 1.0, 2.7, 3.0827, 101.148, 1024.5, 100_000.0, 1e6] {
            for i in 0..=1000 {
                let base = if i < 900 { f64::from(i) / 900.0 } else { 1.0 - 0.5f64.powi(i - 900) };
                let expected = math::pow(base, exponent);
                let got = power((), base, exponent);
                // Some roundings of a logarithm of at most 1022; of a few, where anything is to be seen.
                let part = if expected > 1e-3 { 1e-14 } else { 1e-12 };
                assert!((got - expected).abs() <= part * expected + 1e-300, "{base}^{exponent}: {got} {expected}");
                let narrow = base as f32;
                let expected = math::pow(f64::from(narrow), exponent);
                let got = f64::from(power((), narrow, exponent));
                // Some roundings of a logarithm of at most 126.
                assert!((got - expected).abs() <= 6e-5 * expected + 1e-37, "{narrow}^{exponent}: {got} {expected}");
                if expected > 1e-3 {
                    assert!((got - expected).abs() <= 5e-6 * expected, "{narrow}^{exponent}: {got} {expected}");
                }
            }
        }
    }

    #[test]
    fn zero_and_one_stay() {
        for exponent in [0.5, 3.0827, 1e6] {
            assert_eq!((power((), 0.0f32, exponent), power((), 0.0f64, exponent)), (0.0, 0.0));
            assert_eq!((power((), 1.0f32, exponent), power((), 1.0f64, exponent)), (1.0, 1.0));
        }
        assert_eq!((power((), 0.0f32, 0.0), power((), 1e-40f32, 0.5)), (1.0, 0.0));
    }
}
