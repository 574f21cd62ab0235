//! Phong's model (CACM 18(6), 1975): k_d (N.L) + k_s (R.V)^m.

use super::optics::reflect;
use crate::lanes::{self, Lanes, Mask, Real, V3};

/// Largest exponent computed by repeated squaring; the error grows like m u, as that of any power of a rounded base does.
const MAX_SQUARED: f64 = 1024.0;

/// cos of the angle between the mirrored light direction and the viewer, at least 0. All vectors are unit; `to_light`
/// and `to_eye` point away from the surface.
#[inline(always)]
pub fn highlight_cosine<L: Lanes>(s: L::Simd, ns: V3<L>, to_light: V3<L>, to_eye: V3<L>) -> L {
    // Mirroring the direction towards the light gives the direction of incidence of its reflection.
    let mirrored = -reflect(s, to_light, ns);
    mirrored.dot(to_eye).max(L::lit(s, 0.0)).min(L::lit(s, 1.0))
}

/// `base^exponents`, lane by lane, for bases in [0, 1] and exponents of at least 0. 0^0 is 1.
#[inline(always)]
pub fn power<L: Lanes>(s: L::Simd, base: L, exponents: L, active: L::Mask) -> L {
    let mut result = L::lit(s, 0.0);
    let mut left = active.bits();
    while left != 0 {
        let exponent = exponents.lane(left.trailing_zeros() as usize);
        let same = exponents.eq(L::splat(s, exponent));
        left &= !same.bits();
        result = L::select(same, uniform_power(s, base, exponent.to_f64()), result);
    }
    result
}

#[inline(always)]
fn uniform_power<L: Lanes>(s: L::Simd, base: L, exponent: f64) -> L {
    if exponent <= MAX_SQUARED && exponent.fract() == 0.0 {
        let mut rest = exponent as u32;
        let mut square = base;
        let mut product = L::lit(s, 1.0);
        while rest != 0 {
            if rest & 1 != 0 {
                product = product * square;
            }
            square = square * square;
            rest >>= 1;
        }
        return product;
    }
    lanes::power(s, base, exponent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    #[test]
    fn powers_agree_with_libm() {
        for exponent in [0.0, 1.0, 3.0827, 20.0, 64.0, 101.148, 1024.0, 100_000.0, 1e6] {
            for base in [0.0, 0.3, 0.9, 0.999_999, 1.0] {
                let got = power((), base, exponent, true);
                let expected = math::pow(base, exponent);
                assert!((got - expected).abs() <= 1e-12 * (1.0 + expected), "{base}^{exponent}: {got} {expected}");
            }
        }
    }

    #[test]
    fn highlight_is_brightest_in_the_mirror_direction_and_never_above_one() {
        let n = V3 { x: 0.0, y: 1.0, z: 0.0 };
        let l = V3 { x: -0.6, y: 0.8, z: 0.0 };
        assert_eq!(highlight_cosine((), n, l, V3 { x: 0.6, y: 0.8, z: 0.0 }), 1.0);
        assert_eq!(highlight_cosine((), n, l, V3 { x: -1.0, y: 0.0, z: 0.0 }), 0.0);
        let long = V3 { x: 0.6 * (1.0 + 1e-15), y: 0.8 * (1.0 + 1e-15), z: 0.0 };
        assert!(highlight_cosine((), n, l, long) <= 1.0);
    }
}
