//! The sum of a pixel's light, as if it were added in twice the precision.
//!
//! Each addition's rounding error is computed exactly (Knuth's TwoSum) and added up beside the sum, so the order of rays does
//! not matter but for the last bits of the errors. With u the unit roundoff and n terms of 0 or more, the sum of both is off
//! by at most gamma(n-1)^2 of itself (Ogita, Rump and Oishi, Accurate Sum and Dot Product, 2005, proposition 4.5).

use crate::lanes::{Lanes, MAX_LANES, Real, V3};

/// Light of each pixel of a packet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PixelSum<L: Lanes> {
    /// The rounded sum.
    rounded: V3<L>,
    /// The sum of the errors of its additions.
    errors: V3<L>,
}

impl<L: Lanes> PixelSum<L> {
    /// No light.
    #[inline(always)]
    pub(crate) fn black(s: L::Simd) -> Self {
        let black = V3::splat(s, [L::Real::default(); 3]);
        Self { rounded: black, errors: black }
    }

    /// Adds light to some lanes.
    #[inline(always)]
    pub(super) fn add(&mut self, s: L::Simd, lanes: u32, radiance: V3<L>) {
        let black = V3::splat(s, [L::Real::default(); 3]);
        let radiance = V3::select(L::mask(s, lanes), radiance, black);
        let sum = self.rounded + radiance;
        let added = sum - self.rounded;
        self.errors = self.errors + ((self.rounded - (sum - added)) + (radiance - added));
        self.rounded = sum;
    }

    /// Begins again with some lanes.
    #[inline(always)]
    pub(super) fn clear(&mut self, s: L::Simd, lanes: u32) {
        let (black, mask) = (V3::splat(s, [L::Real::default(); 3]), L::mask(s, lanes));
        self.rounded = V3::select(mask, black, self.rounded);
        self.errors = V3::select(mask, black, self.errors);
    }

    /// Writes the sums with the bits that the kernel's format does not hold, channel by channel, from sample `first` on.
    #[inline(always)]
    pub(super) fn store(&self, light: &mut [[f64; MAX_LANES]; 3], first: usize) {
        let rounded = [self.rounded.x, self.rounded.y, self.rounded.z];
        let errors = [self.errors.x, self.errors.y, self.errors.z];
        for (light, (rounded, errors)) in light.iter_mut().zip(rounded.into_iter().zip(errors)) {
            let mut parts = [[L::Real::default(); MAX_LANES]; 2];
            rounded.store(&mut parts[0]);
            errors.store(&mut parts[1]);
            let light = &mut light[first..first + L::COUNT];
            for (light, (rounded, error)) in light.iter_mut().zip(parts[0].iter().zip(&parts[1])) {
                *light = rounded.to_f64() + error.to_f64();
            }
        }
    }
}

/// The relative error of the sum of `terms` terms.
#[inline(always)]
pub(super) fn relative_error<R: Real>(terms: f64) -> f64 {
    let gamma = terms * R::ROUNDOFF / (1.0 - (terms * R::ROUNDOFF).min(0.5));
    // Of the sum of both in double precision.
    gamma * gamma + 4.0 * f64::EPSILON
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_nearly_exact_in_any_order() {
        let terms: Vec<f32> = (1u32..5_000).map(|i| 1.0 / (i * i) as f32).collect();
        let sum = |terms: &mut dyn Iterator<Item = f32>| {
            let mut sum = PixelSum::<f32>::black(());
            terms.for_each(|term| sum.add((), 1, V3 { x: term, y: term, z: term }));
            let mut light = [[0.0; MAX_LANES]; 3];
            sum.store(&mut light, 0);
            light[0][0]
        };
        let exact: f64 = terms.iter().rev().map(|term| f64::from(*term)).sum();
        let bound = exact * relative_error::<f32>(5_000.0);
        for sum in [sum(&mut terms.iter().copied()), sum(&mut terms.iter().rev().copied())] {
            assert!((sum - exact).abs() <= bound, "{sum} {exact}");
        }
        let plain: f32 = terms.iter().sum();
        assert!((f64::from(plain) - exact).abs() > bound);
    }
}
