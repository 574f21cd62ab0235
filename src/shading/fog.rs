//! Fog: its optical depth along a ray, in closed form.

use crate::lanes::{Lanes, Real, exp_minus, mean_decay, opacity};

/// Fog in the kernel's format.
#[derive(Debug, Clone, Copy)]
pub struct Fog<R> {
    /// Radiance of infinitely deep fog.
    pub color: [R; 3],
    /// Optical depth of a unit of length, above 0.
    pub density: R,
    /// How it thins out with height; none if it is the same everywhere.
    pub height: Option<Height<R>>,
}

/// Fog that thins out upwards: full density up to y = `base`, and density e^(-(y - base)/falloff) above.
#[derive(Debug, Clone, Copy)]
pub struct Height<R> {
    /// Where it begins to thin out.
    pub base: R,
    /// Height over which it thins out to 1/e, above 0.
    pub falloff: R,
}

impl<R: Real> Fog<R> {
    /// Optical depth of rays that start at height `y`, rise by `slope` in a unit of length (at most 1) and end after
    /// `length`, which may be infinite: density times the integral of e^-max(0, (y - base)/falloff).
    #[inline(always)]
    pub fn optical_depth<L: Lanes<Real = R>>(&self, s: L::Simd, y: L, slope: L, length: L) -> L {
        let density = L::splat(s, self.density);
        match self.height {
            None => density * length,
            Some(height) => density * height.equivalent(s, y, slope, length),
        }
    }
}

impl<R: Real> Height<R> {
    /// The length in full density with the optical depth of the ray.
    ///
    /// With u = (y - base)/falloff, a ray runs a length B below the base and a length A above it. If the lowest point of the
    /// upper part has u = a, and u changes by w in a unit of length, that part has the depth e^-a (1 - e^-(w A))/w.
    #[inline(always)]
    fn equivalent<L: Lanes<Real = R>>(&self, s: L::Simd, y: L, slope: L, length: L) -> L {
        let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
        let thinning = one / L::splat(s, self.falloff);
        let u = (y - L::splat(s, self.base)) * thinning;
        let w = slope.abs() * thinning;
        let starts_above = u.ge(zero);
        let falls = slope.lt(zero);
        let crosses = (starts_above & falls) | (!starts_above & slope.gt(zero));
        // Level rays never cross the base: infinity, or NaN at the base itself.
        let until_base = (u.abs() / w).min(length);
        let first = L::select(crosses, until_base, length);
        let second = L::select(crosses & until_base.lt(length), length - until_base, zero);
        let above = L::select(starts_above, first, second);
        let below = L::select(starts_above, second, first);
        let lowest = L::select(starts_above, L::select(falls, (u - w * above).max(zero), u), zero);
        // Along level rays the density is constant.
        let change = L::select(w.gt(zero), w * above, zero);
        let mean = L::select(change.lt(one), above * mean_decay(s, change), opacity(s, change) / w);
        // No density gives no depth, even over an infinite length.
        let thinned = exp_minus(s, lowest);
        let above = L::select(thinned.gt(zero), thinned * mean, zero);
        (below + above).max(zero)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integral by Simpson's rule on both sides of the base.
    fn quadrature(height: &Height<f64>, y: f64, slope: f64, length: f64) -> f64 {
        let density = |t: f64| libm::exp(-((y + slope * t - height.base) / height.falloff).max(0.0));
        let base = (height.base - y) / slope;
        let split = if base > 0.0 && base < length { base } else { length };
        let simpson = |from: f64, to: f64| {
            let (n, h) = (20_000, (to - from) / 20_000.0);
            let inner: f64 =
                (1..n).map(|i| density(from + h * f64::from(i)) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
            (density(from) + inner + density(to)) * h / 3.0
        };
        simpson(0.0, split) + simpson(split, length)
    }

    #[test]
    fn depth_agrees_with_quadrature() {
        let height = Height { base: 1.0, falloff: 0.5 };
        for y in [-3.0, 0.9, 1.0, 1.2, 4.0] {
            for slope in [-1.0, -0.3, -1e-3, -1e-9, 0.0, 1e-9, 1e-3, 0.3, 1.0] {
                for length in [1e-3, 1.0, 7.0, 30.0] {
                    let expected = quadrature(&height, y, slope, length);
                    let got = height.equivalent((), y, slope, length);
                    assert!(
                        (got - expected).abs() <= 1e-10 * expected + 1e-15,
                        "{y} {slope} {length}: {got} {expected}"
                    );
                    let narrow = Height { base: 1.0f32, falloff: 0.5 };
                    let got = f64::from(narrow.equivalent((), y as f32, slope as f32, length as f32));
                    // A rounding of u is one of the exponent.
                    assert!((got - expected).abs() <= 2e-5 * expected + 1e-9, "{y} {slope} {length}: {got} {expected}");
                }
            }
        }
    }

    #[test]
    fn rays_into_the_sky_leave_the_fog() {
        let fog = Fog { color: [1.0; 3], density: 2.0, height: Some(Height { base: 1.0, falloff: 0.5 }) };
        let depth = |y: f64, slope: f64| fog.optical_depth((), y, slope, f64::INFINITY);
        assert_eq!(depth(1.0, 1.0), 1.0, "density times falloff");
        assert_eq!(depth(0.0, 0.5), 2.0 * (2.0 + 1.0), "2 below the base, 0.5/0.5 above");
        assert_eq!(depth(0.0, 0.0), f64::INFINITY);
        assert_eq!(depth(9.0, -0.1), f64::INFINITY);
        assert_eq!(depth(1e15, 0.0), 0.0, "none up there");
        let even = Fog { height: None, ..fog };
        assert_eq!(even.optical_depth((), 0.0, 1.0, f64::INFINITY), f64::INFINITY);
    }

    #[test]
    fn extreme_numbers_give_no_nan() {
        let extremes = [-1e15f32, -1.0, -1e-15, 0.0, 1e-15, 1.0, 1e15];
        for base in extremes {
            for falloff in [1e-15f32, 1.0, 1e15] {
                let fog = Fog { color: [1.0; 3], density: 1e15, height: Some(Height { base, falloff }) };
                for y in extremes.into_iter().chain([3e22, -3e22]) {
                    for slope in [-1.0f32, -1e-20, -1e-44, 0.0, 1e-44, 1e-20, 1.0] {
                        for length in [0.0, 1e-15, 1.0, 1e22, f32::INFINITY] {
                            let depth = fog.optical_depth((), y, slope, length);
                            assert!(depth >= 0.0, "{base} {falloff} {y} {slope} {length}: {depth}");
                        }
                    }
                }
            }
        }
    }
}
