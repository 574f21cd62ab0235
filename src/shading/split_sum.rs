//! How much of a uniform light a rough mirror reflects (Karis, Real Shading in Unreal Engine 4, 2013): with Schlick's law
//! F = F0 + (F90 - F0)(1 - v.h)^5 that is F0 a + F90 b, where a and b depend on the angle and the roughness alone.
//!
//! They are means over visible facets (`microfacet.rs`), in a table.

use super::microfacet::{smith_g1, visible_facet};
use crate::lanes::{Double, Lanes, MAX_LANES, Mask, Real, V3, dispatch, lanes_of};
use crate::math;
use fearless_simd::{Level, f64x8};
use std::sync::OnceLock;

/// Steps of the cosine between ray and normal, and of the roughness.
const COSINES: usize = 32;
const ROUGHNESSES: usize = 16;

/// Facets across and along the square that they are chosen from: around the normal few do as well as many.
const FACETS: [u32; 2] = [16, 64];

/// The cosine that stands for light along the surface, where no facet is seen.
const ALONG: f64 = 1e-3;

/// a, b and the cosine of the facets by cosine, for one roughness.
type Shares = [[f64; 3]; COSINES + 1];

/// The columns of those roughnesses that a surface has asked for.
struct Table([OnceLock<Shares>; ROUGHNESSES + 1]);

impl Table {
    fn get() -> &'static Self {
        static TABLE: Table = Table([const { OnceLock::new() }; ROUGHNESSES + 1]);
        &TABLE
    }

    /// By one thread: in a pool, it might take up other work that waits for the column.
    fn column(&self, j: usize) -> &Shares {
        self.0[j].get_or_init(
            #[cold]
            || dispatch!(Level::new(), integrals::<f64x8, f64>(ratio(j, ROUGHNESSES))),
        )
    }

    /// Bilinear.
    fn at(&self, cosine: f64, roughness: f64) -> [f64; 3] {
        let place = |x: f64, steps: usize| {
            let x = x.clamp(0.0, 1.0) * steps as f64;
            let whole = (x.floor() as usize).min(steps - 1);
            (whole, x - whole as f64)
        };
        let ((i, across), (j, along)) = (place(cosine, COSINES), place(roughness, ROUGHNESSES));
        let (here, next) = (self.column(j), self.column(j + 1));
        let mix = |a: [f64; 3], b: [f64; 3], part: f64| [0, 1, 2].map(|k| a[k] * (1.0 - part) + b[k] * part);
        mix(mix(here[i], next[i], along), mix(here[i + 1], next[i + 1], along), across)
    }
}

fn ratio(i: usize, of: usize) -> f64 {
    i as f64 / of as f64
}

/// A column of the table.
fn integrals<W: Double>(s: W::Simd, roughness: f64) -> Shares {
    std::array::from_fn(|i| {
        W::vectorize(
            s,
            #[inline(always)]
            || integral::<W>(s, ratio(i, COSINES), roughness),
        )
    })
}

/// Facets over lanes, added up in their order, so that lanes do not count.
#[inline(always)]
fn integral<W: Double>(s: W::Simd, cosine: f64, roughness: f64) -> [f64; 3] {
    let cosine = cosine.max(ALONG);
    let splat = |x: f64| W::splat(s, x);
    let (zero, one) = (splat(0.0), splat(1.0));
    let ns = V3 { x: zero, y: zero, z: one };
    let eye = V3 { x: splat((1.0 - cosine * cosine).max(0.0).sqrt()), y: zero, z: splat(cosine) };
    let alpha = splat(roughness * roughness);
    let mut sums = [0.0; 2];
    let [across, along] = FACETS;
    for first in (0..across * along).step_by(W::COUNT) {
        let share = |k: u32, of: u32| (f64::from(k) + 0.5) / f64::from(of);
        let a = W::from_fn(s, |lane| share((first + lane as u32) % across, across));
        let b = W::from_fn(s, |lane| share((first + lane as u32) / across, along));
        let facet = visible_facet(s, ns, eye, alpha, [a, b]);
        let cosine = facet.dot(eye);
        let versine = (one - cosine).max(zero);
        let out = facet * (cosine + cosine) - eye;
        let (share, grazing) = (smith_g1(s, ns, out, alpha), versine * versine * versine * versine * versine);
        let (whole, part) = (share * (one - grazing), share * grazing);
        for lane in lanes_of(out.z.gt(zero).bits() & W::ALL) {
            sums[0] += whole.lane(lane);
            sums[1] += part.lane(lane);
        }
    }
    let [a, b] = sums.map(|sum| sum / f64::from(across * along));
    [a, b, 1.0 - math::pow(b / (a + b), 0.2)]
}

/// a and b for some lanes, and the cosine c of a facet that stands for all, for laws other than Schlick's: b/(a + b) = (1 - c)^5.
pub(super) fn reflected_share<L: Lanes>(s: L::Simd, cosine: L, roughness: L, lanes: u32) -> [L; 3] {
    let table = Table::get();
    let mut shares = [[L::Real::default(); MAX_LANES]; 3];
    for lane in lanes_of(lanes) {
        let of_lane = table.at(cosine.lane(lane).to_f64(), roughness.lane(lane).to_f64());
        for (column, share) in shares.iter_mut().zip(of_lane) {
            column[lane] = L::Real::from_f64(share);
        }
    }
    [L::load(s, &shares[0]), L::load(s, &shares[1]), L::load(s, &shares[2])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sin_cos;
    use std::f64::consts::PI;

    /// a and b by their definition: D V cos over all directions of light, by a fine grid.
    fn by_definition(cosine: f64, alpha: f64) -> [f64; 2] {
        let view = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
        let visible = |c: f64| 1.0 / (c + (alpha * alpha + (1.0 - alpha * alpha) * c * c).sqrt());
        let (rows, columns) = (1_200, 600);
        let mut sums = [0.0; 2];
        for row in 0..rows {
            let z = (f64::from(row) + 0.5) / f64::from(rows);
            for column in 0..columns {
                let (sin, cos) = sin_cos((f64::from(column) + 0.5) / f64::from(columns) * PI);
                let reach = (1.0 - z * z).sqrt();
                let half = [view[0] + reach * cos, reach * sin, view[2] + z];
                let length = half.iter().map(|x| x * x).sum::<f64>().sqrt();
                let nh = half[2] / length;
                let d = nh * nh * (alpha * alpha - 1.0) + 1.0;
                let value = alpha * alpha / (PI * d * d) * visible(z) * visible(cosine) * z;
                let grazing = (1.0 - length / 2.0).powi(5);
                sums[0] += value * (1.0 - grazing);
                sums[1] += value * grazing;
            }
        }
        sums.map(|sum| sum * 2.0 * PI / f64::from(rows * columns))
    }

    #[test]
    fn the_table_is_the_integral() {
        for (cosine, roughness) in [(1.0, 0.5), (0.9, 1.0), (0.5, 0.4), (0.3, 0.75), (0.7, 0.63), (0.15, 0.9)] {
            let expected = by_definition(cosine, roughness * roughness);
            let [a, b, _] = reflected_share((), cosine, roughness, 1);
            let off = (a - expected[0]).abs().max((b - expected[1]).abs());
            assert!(off < 3e-3, "cos {cosine}, roughness {roughness}: {a} {b} instead of {expected:?}");
        }
    }

    /// The slow twin goes facet by facet.
    #[test]
    fn lanes_do_not_count() {
        for roughness in [0.0, 0.0625, 0.5, 1.0] {
            let lanes = dispatch!(Level::new(), integrals::<f64x8, f64>(roughness));
            assert_eq!(lanes, integrals::<f64>((), roughness), "{roughness}");
        }
    }

    #[test]
    fn smooth_mirrors_follow_schlick_and_none_reflects_more_than_all() {
        let [a, b, _] = reflected_share((), 0.5, 0.0, 1);
        assert!((a - (1.0 - 1.0 / 32.0)).abs() < 1e-9 && (b - 1.0 / 32.0).abs() < 1e-9, "{a} {b}");
        for i in 0..=100 {
            for j in 0..=100 {
                let [a, b, _] = reflected_share((), f64::from(i) / 100.0, f64::from(j) / 100.0, 1);
                assert!(a >= 0.0 && b >= 0.0 && a + b <= 1.0 + 1e-12, "{i} {j}: {a} {b}");
            }
        }
    }
}
