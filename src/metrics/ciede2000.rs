//! The color difference CIEDE2000 (Sharma, Wu, Dalal, The CIEDE2000 Color-Difference Formula: Implementation Notes,
//! Supplementary Test Data, and Mathematical Observations, 2005).

use super::image::over_both;
use super::{Image8, Spread};
use crate::control;
use crate::math::{self, atan2, pow, sin_cos, srgb_to_linear};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// CIEDE2000 of each pixel of two pictures of one size; of no use once the work of a thread is to stop. Where there is alpha, the larger of those over black and over white.
pub fn ciede2000(a: &Image8, b: &Image8) -> Spread {
    let difference =
        |(a, b): (&[u8; 3], &[u8; 3])| if a == b || control::step(1) { 0.0 } else { delta_e(lab(*a), lab(*b)) };
    let all = |a: &Image8, b: &Image8| a.pixels.par_iter().zip(&b.pixels).map(difference).collect();
    Spread::of(over_both(a, b, all))
}

/// CIELAB under D65 of an sRGB code.
fn lab(code: [u8; 3]) -> [f64; 3] {
    let [r, g, b] = code.map(|c| srgb_to_linear(f64::from(c) / 255.0));
    let x = (0.412_390_8 * r + 0.357_584_34 * g + 0.180_480_79 * b) / 0.950_455_93;
    let y = 0.212_639_01 * r + 0.715_168_68 * g + 0.072_192_32 * b;
    let z = (0.019_330_82 * r + 0.119_194_78 * g + 0.950_532_15 * b) / 1.089_057_75;
    let f = |t: f64| if t > 216.0 / 24_389.0 { libm::cbrt(t) } else { (24_389.0 / 27.0 * t + 16.0) / 116.0 };
    let (x, y, z) = (f(x), f(y), f(z));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn delta_e([l1, a1, b1]: [f64; 3], [l2, a2, b2]: [f64; 3]) -> f64 {
    let chroma = (math::hypot(a1, b1) + math::hypot(a2, b2)) / 2.0;
    let part = |c: f64| (pow(c, 7.0) / (pow(c, 7.0) + pow(25.0, 7.0))).sqrt();
    let g = 1.5 - 0.5 * part(chroma);
    let (a1, a2) = (a1 * g, a2 * g);
    let (c1, c2) = (math::hypot(a1, b1), math::hypot(a2, b2));
    let hue = |a: f64, b: f64| if a == 0.0 && b == 0.0 { 0.0 } else { atan2(b, a).rem_euclid(TAU) };
    let (h1, h2) = (hue(a1, b1), hue(a2, b2));
    let grey = c1 * c2 == 0.0;
    let turn = match h2 - h1 {
        _ if grey => 0.0,
        turn if turn > PI => turn - TAU,
        turn if turn < -PI => turn + TAU,
        turn => turn,
    };
    let (dl, dc, dh) = (l2 - l1, c2 - c1, 2.0 * (c1 * c2).sqrt() * sin_cos(turn / 2.0).0);
    let (l, c) = ((l1 + l2) / 2.0, (c1 + c2) / 2.0);
    let h = match h1 + h2 {
        sum if grey => sum,
        sum if (h1 - h2).abs() <= PI => sum / 2.0,
        sum if sum < TAU => (sum + TAU) / 2.0,
        sum => (sum - TAU) / 2.0,
    };
    let cos = |x: f64| sin_cos(x).1;
    let t = 1.0 - 0.17 * cos(h - 30f64.to_radians()) + 0.24 * cos(2.0 * h) + 0.32 * cos(3.0 * h + 6f64.to_radians())
        - 0.20 * cos(4.0 * h - 63f64.to_radians());
    let bend = (h.to_degrees() - 275.0) / 25.0;
    let rotation = -sin_cos(60f64.to_radians() * math::exp(-bend * bend)).0 * 2.0 * part(c);
    let offset = (l - 50.0) * (l - 50.0);
    let sl = 1.0 + 0.015 * offset / (20.0 + offset).sqrt();
    let (sc, sh) = (1.0 + 0.045 * c, 1.0 + 0.015 * c * t);
    let (dl, dc, dh) = (dl / sl, dc / sc, dh / sh);
    (dl * dl + dc * dc + dh * dh + rotation * dc * dh).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of the authors' test data, with what they found.
    const PUBLISHED: [([f64; 3], [f64; 3], f64); 14] = [
        ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
        ([50.0, 3.1571, -77.2803], [50.0, 0.0, -82.7485], 2.8615),
        ([50.0, 2.8361, -74.0200], [50.0, 0.0, -82.7485], 3.4412),
        ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0000),
        ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
        ([50.0, 2.4900, -0.0010], [50.0, -2.4900, 0.0009], 7.1792),
        ([50.0, 2.4900, -0.0010], [50.0, -2.4900, 0.0011], 7.2195),
        ([50.0, -0.0010, 2.4900], [50.0, 0.0009, -2.4900], 4.8045),
        ([50.0, 2.5, 0.0], [50.0, 0.0, -2.5], 4.3065),
        ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
        ([50.0, 2.5, 0.0], [58.0, 24.0, 15.0], 19.4535),
        ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
        ([22.7233, 20.0904, -46.6940], [23.0331, 14.9730, -42.5619], 2.0373),
        ([2.0776, 0.0795, -1.1350], [0.9033, -0.0636, -0.5514], 0.9082),
    ];

    #[test]
    fn published_pairs_have_their_published_differences() {
        for (a, b, expected) in PUBLISHED {
            assert!((delta_e(a, b) - expected).abs() < 5e-5, "{a:?} {b:?}: {}", delta_e(a, b));
            assert!((delta_e(b, a) - expected).abs() < 5e-5);
        }
    }

    #[test]
    fn white_is_white() {
        let [l, a, b] = lab([255; 3]);
        assert!((l - 100.0).abs() < 1e-4 && a.abs() < 1e-3 && b.abs() < 1e-3, "{l} {a} {b}");
    }
}
