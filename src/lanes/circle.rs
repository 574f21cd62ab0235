//! Points of the unit circle, by polynomials of operations that round alike on every machine.

use super::{Lanes, Real};
use std::f64::consts::TAU;

/// Cosine and sine of a number of turns in [0, 1].
#[inline(always)]
pub fn circle<L: Lanes>(s: L::Simd, turns: L) -> [L; 2] {
    // Whole quarters of a turn, and a rest of at most an eighth.
    let quarter = (turns * L::lit(s, 4.0) + L::lit(s, 0.5)).floor();
    let angle = (turns - quarter * L::lit(s, 0.25)) * L::lit(s, TAU);
    let square = angle * angle;
    // The next terms are below a rounding: 0.785^n / n!.
    let terms = if L::Real::ROUNDOFF > 1e-10 { 5 } else { 9 };
    let (mut sin, mut cos) = (L::lit(s, 1.0), L::lit(s, 1.0));
    for k in (1..terms).rev() {
        let k = f64::from(2 * k);
        sin = L::lit(s, 1.0) - square * sin * L::lit(s, 1.0 / (k * (k + 1.0)));
        cos = L::lit(s, 1.0) - square * cos * L::lit(s, 1.0 / (k * (k - 1.0)));
    }
    sin = sin * angle;
    let is = |k: f64| quarter.eq(L::lit(s, k));
    let (one, two, three) = (is(1.0), is(2.0), is(3.0));
    let (x, y) = (L::select(one | three, sin, cos), L::select(one | three, cos, sin));
    [L::select(one | two, -x, x), L::select(two | three, -y, y)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    #[test]
    fn circle_agrees_with_libm() {
        for i in 0..=4096 {
            let turns = f64::from(i) / 4096.0;
            let (sin, cos) = math::sin_cos(turns * TAU);
            let [x, y] = circle((), turns);
            // The angle that libm is given is itself rounded, by up to 4.4e-16.
            assert!((x - cos).abs() < 1e-15 && (y - sin).abs() < 1e-15, "{turns}: {x} {y}");
            let [x, y] = circle((), turns as f32);
            assert!((f64::from(x) - cos).abs() < 2e-7 && (f64::from(y) - sin).abs() < 2e-7, "{turns}: {x} {y}");
        }
    }
}
