//! Angles of points, by operations that round alike on every machine.

use super::Lanes;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// atan(z) = z + z z^2 P(z^2) / Q(z^2) for |z| <= 0.66, off by at most two roundings of f64 (Moshier, Methods and Programs for
/// Mathematical Functions, 1989, as in Cephes). Highest power first; the first coefficient of Q is 1.
const P: [f64; 5] = [
    -8.750_608_600_031_904e-1,
    -1.615_753_718_733_365e1,
    -7.500_855_792_314_705e1,
    -1.228_866_684_490_136_2e2,
    -6.485_021_904_942_025e1,
];
const Q: [f64; 5] = [
    2.485_846_490_142_306_3e1,
    1.650_270_098_316_988_5e2,
    4.328_810_604_912_902_6e2,
    4.853_903_996_359_137e2,
    1.945_506_571_482_614e2,
];

/// The angle of (x, y) from the x axis, from -pi to pi; 0 of (0, 0). The sign of a zero does not count.
#[inline(always)]
pub fn angle<L: Lanes>(s: L::Simd, y: L, x: L) -> L {
    let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
    let (across, up) = (x.abs(), y.abs());
    let steep = across.lt(up);
    let (long, short) = (L::select(steep, up, across), L::select(steep, across, up));
    // atan(t) = pi/4 + atan((t - 1)/(t + 1)).
    let diagonal = (long * L::lit(s, 0.66)).lt(short);
    let z = L::select(diagonal, short - long, short)
        / L::select(diagonal, short + long, L::select(long.gt(zero), long, one));
    let zz = z * z;
    let (mut p, mut q) = (L::lit(s, P[0]), zz + L::lit(s, Q[0]));
    for k in 1..5 {
        (p, q) = (p * zz + L::lit(s, P[k]), q * zz + L::lit(s, Q[k]));
    }
    let small = z + z * (zz * p / q);
    let angle = L::select(diagonal, small + L::lit(s, FRAC_PI_4), small);
    let angle = L::select(steep, L::lit(s, FRAC_PI_2) - angle, angle);
    let angle = L::select(x.lt(zero), L::lit(s, PI) - angle, angle);
    L::select(y.lt(zero), -angle, angle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    #[test]
    fn angles_agree_with_libm() {
        let mut worst = 0.0f64;
        for i in 0..100_000 {
            let (sin, cos) = math::sin_cos(f64::from(i) * 2e-5 * PI - PI);
            for length in [1e-100, 0.3, 1.0, 7e120] {
                let (y, x) = (sin * length, cos * length);
                worst = worst.max((angle((), y, x) - math::atan2(y, x)).abs());
            }
        }
        assert!(worst < 5e-16, "{worst:e}");
    }

    #[test]
    fn axes_and_the_origin_are_exact() {
        let found = [(0.0, 0.0), (0.0, 2.0), (3.0, 0.0), (0.0, -1.0), (-5.0, 0.0), (1.0, 1.0), (-2.0, -2.0)]
            .map(|(y, x): (f64, f64)| angle((), y, x));
        assert_eq!(found, [0.0, 0.0, FRAC_PI_2, PI, -FRAC_PI_2, FRAC_PI_4, -3.0 * FRAC_PI_4]);
    }
}
