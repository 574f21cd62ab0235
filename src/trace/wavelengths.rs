//! The wavelengths of a packet, one for each sample, for dispersion.

use super::sampling::Sampler;
use crate::lanes::{Lanes, MAX_LANES, Real, V3};
use crate::shading::spectrum::{Spectrum, WAVELENGTHS};

/// A wavelength in each lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wavelengths<L: Lanes> {
    /// This times the mean dispersion is added to the index of refraction.
    pub(super) bend: L,
    /// Factor on a ray's weight when its light is split.
    pub(super) color: V3<L>,
}

impl<L: Lanes> Wavelengths<L> {
    /// The wavelength for which scenes give indices of refraction.
    #[inline(always)]
    pub(super) fn yellow(s: L::Simd) -> Self {
        Self { bend: L::lit(s, 0.0), color: V3::splat(s, [L::Real::from_f64(1.0); 3]) }
    }

    /// The wavelength of each lane's sample.
    #[inline(always)]
    pub(super) fn choose(s: L::Simd, spectrum: &Spectrum<L::Real>, sampler: &Sampler) -> Self {
        let cases = sampler.wavelength(WAVELENGTHS as u32);
        let mut columns = [[L::Real::default(); MAX_LANES]; 4];
        for (lane, case) in cases.into_iter().enumerate() {
            let [r, g, b] = spectrum.colors[case];
            for (column, number) in columns.iter_mut().zip([r, g, b, spectrum.bend[case]]) {
                column[lane] = number;
            }
        }
        let [r, g, b, bend] = &columns;
        Self { bend: L::load(s, bend), color: V3 { x: L::load(s, r), y: L::load(s, g), z: L::load(s, b) } }
    }
}
