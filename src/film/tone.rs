//! Tone curves: bright light is compressed until it fits a screen.
//!
//! Each curve comes twice: for a color, and for an interval of each channel of a color. The second follows the first step
//! by step, and every step grows or falls in each of its inputs, so its ends are those of the inputs.

use crate::lanes::{Lanes, Mask, V3, log2, power};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How bright light is compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ToneMapping {
    /// Not at all: each channel above 1 is cut off at 1.
    #[default]
    None,
    /// Khronos PBR Neutral: colors below 0.8 stay almost as they are, brighter ones keep their hue and fade to white.
    KhronosPbrNeutral,
    /// AgX with its default contrast, as in three.js and Filament: 16.5 stops like photographic film, of which mid-grey, 0.18,
    /// becomes half of all codes.
    Agx,
}

/// An interval: its lower and its upper end.
type Ends = [f64; 2];

/// Intervals are this much wider than computed, since computing rounds: far more than a curve's operations can, and far
/// less than a 16-bit code.
const ROUNDING: f64 = 1e-10;

fn outwards([low, high]: Ends) -> Ends {
    [(low - ROUNDING).max(0.0), high + ROUNDING]
}

/// Where compression starts, less the light that a surface of glass mirrors.
const START: f64 = 0.8 - 0.04;
const DESATURATION: f64 = 0.15;

/// Khronos PBR Neutral Tone Mapper, specification 1.0.
#[inline(always)]
pub(super) fn khronos_pbr_neutral<L: Lanes<Real = f64>>(s: L::Simd, color: V3<L>) -> V3<L> {
    let offset = fresnel(s, color.x.min(color.y).min(color.z));
    let color = color - V3 { x: offset, y: offset, z: offset };
    let peak = color.x.max(color.y).max(color.z);
    let bright = peak.ge(L::lit(s, START));
    if !bright.any() {
        return color;
    }
    let [new_peak, fade] = compressed(s, peak);
    let whole = V3 { x: fade, y: fade, z: fade };
    let shares = V3 { x: color.x / peak, y: color.y / peak, z: color.z / peak };
    V3::select(bright, (shares * (L::lit(s, 1.0) - fade) + whole) * new_peak, color)
}

/// The light that a mirroring surface has added to a color with this least channel. It grows with it.
#[inline(always)]
fn fresnel<L: Lanes<Real = f64>>(s: L::Simd, least: L) -> L {
    let dark = least - L::lit(s, 6.25) * least * least;
    L::select(least.lt(L::lit(s, 0.08)), dark, L::lit(s, 0.04))
}

/// What is added to colors with these least channels so that Khronos PBR Neutral takes it away again: `fresnel` of the sum.
/// Colors whose brightest channel is below `START` are then shown as they are.
#[inline(always)]
pub fn taken_by_khronos_pbr_neutral<L: Lanes>(s: L::Simd, least: L) -> L {
    let bright = L::lit(s, 0.04);
    L::select(least.lt(bright), (least * L::lit(s, 0.16)).sqrt() - least, bright)
}

/// What becomes of the brightest channel, and how much a color fades to white. Both grow with it.
#[inline(always)]
fn compressed<L: Lanes<Real = f64>>(s: L::Simd, peak: L) -> [L; 2] {
    let (one, room) = (L::lit(s, 1.0), 1.0 - START);
    let new_peak = one - L::lit(s, room * room) / (peak + L::lit(s, room) - L::lit(s, START));
    [new_peak, one - one / (L::lit(s, DESATURATION) * (peak - new_peak) + one)]
}

pub(super) fn khronos_pbr_neutral_ends(color: [Ends; 3]) -> [Ends; 3] {
    // A channel less the offset grows with the channel and falls with the others.
    let moved: [Ends; 3] = std::array::from_fn(|c| {
        let end = |own: usize| {
            let others = (0..3).filter(|other| *other != c).map(|other| color[other][1 - own]);
            color[c][own] - fresnel((), others.fold(color[c][own], f64::min))
        };
        [end(0).max(0.0), end(1)]
    });
    let peak = [0, 1].map(|end| moved.iter().map(|channel| channel[end]).fold(0.0, f64::max));
    if peak[1] < START {
        return moved.map(outwards);
    }
    let bright = peak.map(|peak| peak.max(START));
    let [[least, fade_least], [most, fade_most]] = bright.map(|peak| compressed((), peak));
    moved.map(|[low, high]| {
        // The share of the peak grows with the channel and falls with the peak; what is shown grows with share and fade.
        let shares = [low / bright[1], (high / bright[0]).min(1.0)];
        let faded = |share: f64, fade: f64| share * (1.0 - fade) + fade;
        let ends = [least * faded(shares[0], fade_least), most * faded(shares[1], fade_most)];
        // Where the peak may lie below the start of compression, colors may stay as they are.
        outwards(if peak[0] < START { [ends[0].min(low), ends[1].max(high.min(START))] } else { ends })
    })
}

type Matrix = [[f64; 3]; 3];

/// Linear sRGB to linear Rec. 2020, by rows.
const TO_REC2020: Matrix = [[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0113], [0.0164, 0.0880, 0.8956]];
const FROM_REC2020: Matrix = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
/// AgX: colors move towards grey before each channel is compressed, and away from it afterwards.
const INSET: Matrix = [
    [0.856627153315983, 0.0951212405381588, 0.0482516061458583],
    [0.137318972929847, 0.761241990602591, 0.101439036467562],
    [0.11189821299995, 0.0767994186031903, 0.811302368396859],
];
const OUTSET: Matrix = [
    [1.1271005818144368, -0.11060664309660323, -0.016493938717834573],
    [-0.1413297634984383, 1.157823702216272, -0.016493938717834257],
    [-0.14132976349843826, -0.11060664309660294, 1.2519364065950405],
];
/// The stops around mid-grey that AgX tells apart, as logarithms of light.
const STOPS: Ends = [-12.47393, 4.026069];

/// AgX (Sobotka 2022), as three.js and Filament have it.
#[inline(always)]
pub(super) fn agx<L: Lanes<Real = f64>>(s: L::Simd, color: V3<L>) -> V3<L> {
    let (black, white) = (L::lit(s, 0.0), L::lit(s, 1.0));
    let inset = times(s, &INSET, times(s, &TO_REC2020, color));
    let inset = V3 { x: contrast(s, inset.x), y: contrast(s, inset.y), z: contrast(s, inset.z) };
    let outset = times(s, &OUTSET, inset);
    let outset = V3 { x: linearised(s, outset.x), y: linearised(s, outset.y), z: linearised(s, outset.z) };
    let shown = times(s, &FROM_REC2020, outset);
    V3 { x: shown.x.max(black).min(white), y: shown.y.max(black).min(white), z: shown.z.max(black).min(white) }
}

pub(super) fn agx_ends(color: [Ends; 3]) -> [Ends; 3] {
    let inset = times_ends(&INSET, times_ends(&TO_REC2020, color));
    let outset = times_ends(&OUTSET, inset.map(|ends| ends.map(|end| contrast((), end))))
        .map(|ends| ends.map(|end| linearised((), end)));
    times_ends(&FROM_REC2020, outset).map(|ends| outwards(ends.map(|channel| channel.clamp(0.0, 1.0))))
}

/// The logarithm of light within [`STOPS`], through the curve of film: a polynomial by Wrensch (2023), which grows from 0 to
/// 1.
#[inline(always)]
fn contrast<L: Lanes<Real = f64>>(s: L::Simd, light: L) -> L {
    let stops = log2(s, light.max(L::lit(s, 1e-10))) - L::lit(s, STOPS[0]);
    let x = (stops / L::lit(s, STOPS[1] - STOPS[0])).max(L::lit(s, 0.0)).min(L::lit(s, 1.0));
    const POLYNOMIAL: [f64; 7] = [-0.00232, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5];
    let mut sum = L::lit(s, 0.0);
    for factor in POLYNOMIAL.iter().rev() {
        sum = sum * x + L::lit(s, *factor);
    }
    sum
}

#[inline(always)]
fn linearised<L: Lanes<Real = f64>>(s: L::Simd, encoded: L) -> L {
    power(s, encoded.max(L::lit(s, 0.0)), 2.2)
}

#[inline(always)]
fn times<L: Lanes<Real = f64>>(s: L::Simd, [x, y, z]: &Matrix, v: V3<L>) -> V3<L> {
    V3 { x: V3::splat(s, *x).dot(v), y: V3::splat(s, *y).dot(v), z: V3::splat(s, *z).dot(v) }
}

/// A sum of multiples is least where the factors above 0 meet lower ends, and the others upper ones.
fn times_ends(rows: &Matrix, v: [Ends; 3]) -> [Ends; 3] {
    rows.map(|row| [0, 1].map(|end| (0..3).map(|c| row[c] * v[c][if row[c] < 0.0 { 1 - end } else { end }]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    fn neutral([x, y, z]: [f64; 3]) -> [f64; 3] {
        khronos_pbr_neutral((), V3 { x, y, z }).lane(0)
    }

    fn of_grey(light: f64) -> [f64; 3] {
        agx((), V3 { x: light, y: light, z: light }).lane(0)
    }

    #[test]
    fn neutral_keeps_dark_colors_and_fades_bright_ones() {
        let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        // Below the start only the offset of 0.04 is taken away.
        assert!(close(neutral([0.5, 0.3, 0.2]), [0.46, 0.26, 0.16]));
        assert!(close(neutral([0.5, 0.3, 0.0]), [0.5, 0.3, 0.0]));
        // A peak of 1.24 becomes 1 - 0.24^2/(1.24 + 0.24 - 0.76) = 0.92.
        assert!(close(neutral([1.28; 3]), [0.92; 3]));
        let bright = neutral([1e6, 0.0, 0.0]);
        assert!(bright.iter().all(|channel| (0.99..=1.0).contains(channel)), "{bright:?}");
    }

    #[test]
    fn what_neutral_takes_can_be_added_before() {
        for least in [0.0, 1e-6, 0.01, 0.039, 0.04, 0.3, 0.7] {
            let color = [0.75, least, 0.72];
            let added = taken_by_khronos_pbr_neutral((), least);
            let shown = neutral(color.map(|channel| channel + added));
            assert!(shown.iter().zip(color).all(|(a, b)| (a - b).abs() < 1e-12), "{least}: {shown:?}");
        }
    }

    #[test]
    fn agx_keeps_greys_grey_and_ends_at_white() {
        for light in [0.0, 1e-4, 0.18, 1.0, 16.0, 1e9] {
            let [r, g, b] = of_grey(light);
            assert!((r - g).abs() < 2e-3 && (g - b).abs() < 2e-3, "{light}: {r} {g} {b}");
        }
        let [_, middle, _] = of_grey(0.18);
        assert!((math::linear_to_srgb(middle) - 0.5).abs() < 1e-2, "{middle}");
        assert!(of_grey(1e6)[1] > 0.98);
    }

    #[test]
    fn contrast_grows() {
        let of = |i: i32| contrast((), math::pow(2.0, f64::from(i) * 0.01));
        assert!((-1_300..450).all(|i| of(i) <= of(i + 1)));
    }
}
