//! Wavelengths, for dispersion.

use crate::lanes::Real;
use crate::math;
use glam::DVec3;

/// Wavelengths that light is split into.
pub const WAVELENGTHS: usize = 64;

/// Nanometres of Fraunhofer's lines F, d and C.
const LINES: [f64; 3] = [486.1, 587.6, 656.3];

/// The wavelengths of light: the color and the refraction of each.
#[derive(Debug, Clone)]
pub struct Spectrum<R> {
    /// Factor on linear red, green and blue. Their mean is 1, so that white stays white.
    pub colors: [[R; 3]; WAVELENGTHS],
    /// (1/lambda^2 - 1/lambda_d^2) / (1/lambda_F^2 - 1/lambda_C^2): this times a body's mean dispersion is added to its index
    /// of refraction (Cauchy's formula n = A + B/lambda^2).
    pub bend: [R; WAVELENGTHS],
}

impl<R: Real> Spectrum<R> {
    /// The visible wavelengths.
    pub fn visible() -> Self {
        let wavelength = |i: usize| 400.0 + 300.0 * (i as f64 + 0.5) / WAVELENGTHS as f64;
        let colors: [[f64; 3]; WAVELENGTHS] = std::array::from_fn(|i| rgb(wavelength(i)));
        let mean = |c: usize| colors.iter().map(|color| color[c]).sum::<f64>() / WAVELENGTHS as f64;
        let means = [mean(0), mean(1), mean(2)];
        let inverse = |nanometres: f64| 1.0 / (nanometres * nanometres);
        let [f, d, c] = LINES.map(inverse);
        Self {
            colors: colors.map(|color| std::array::from_fn(|c| R::from_f64(color[c] / means[c]))),
            bend: std::array::from_fn(|i| R::from_f64((inverse(wavelength(i)) - d) / (f - c))),
        }
    }

    /// The largest factor of a single wavelength on each channel.
    pub fn strongest(&self) -> DVec3 {
        self.colors.iter().map(|color| DVec3::from_array(color.map(Real::to_f64))).fold(DVec3::ZERO, DVec3::max)
    }
}

/// Linear sRGB of a wavelength in nanometres; negative channels are 0.
fn rgb(nanometres: f64) -> [f64; 3] {
    // Wyman, Sloan, Shirley, Simple Analytic Approximations to the CIE XYZ Color Matching Functions, JCGT 2(2), 2013.
    let lobe = |middle: f64, below: f64, above: f64| {
        let t = (nanometres - middle) * if nanometres < middle { below } else { above };
        math::pow(std::f64::consts::E, -0.5 * t * t)
    };
    let x =
        0.362 * lobe(442.0, 0.0624, 0.0374) + 1.056 * lobe(599.8, 0.0264, 0.0323) - 0.065 * lobe(501.1, 0.0490, 0.0382);
    let y = 0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322);
    let z = 1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725);
    let channel = |a: f64, b: f64, c: f64| (a * x + b * y + c * z).max(0.0);
    [
        channel(3.240_625_5, -1.537_208, -0.498_628_6),
        channel(-0.968_930_7, 1.875_756_1, 0.041_517_5),
        channel(0.055_710_1, -0.204_021_1, 1.056_995_9),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_stays_white_and_lines_bend_as_named() {
        let spectrum = Spectrum::<f64>::visible();
        for c in 0..3 {
            let mean = spectrum.colors.iter().map(|color| color[c]).sum::<f64>() / WAVELENGTHS as f64;
            assert!((mean - 1.0).abs() < 1e-12);
        }
        // Between the wavelengths beside F and C the index falls by the mean dispersion.
        let at = |nanometres: f64| {
            let place = (nanometres - 400.0) / 300.0 * WAVELENGTHS as f64 - 0.5;
            let (i, rest) = (place as usize, place.fract());
            spectrum.bend[i] * (1.0 - rest) + spectrum.bend[i + 1] * rest
        };
        assert!((at(LINES[0]) - at(LINES[2]) - 1.0).abs() < 1e-3);
        assert!(at(LINES[1]).abs() < 1e-3);
    }

    #[test]
    fn wavelengths_have_their_colors() {
        let [red, green, blue] = [620.0, 540.0, 450.0].map(rgb);
        assert!(red[0] > 2.0 * red[1] && red[0] > 2.0 * red[2]);
        assert!(green[1] > 2.0 * green[0] && green[1] > 2.0 * green[2]);
        assert!(blue[2] > 2.0 * blue[0] && blue[2] > 2.0 * blue[1]);
    }
}
