//! From radiance to the colors that a picture shows: exposure, and a tone curve.
//!
//! Radiance stays as it is. A picture whose radiance is only known to lie in an interval gets an interval of colors here, so
//! that what is proved of its light is proved of its codes. Where channels are mixed, that is interval arithmetic (Moore
//! 1966), which may be wider than the truth, never narrower.

use super::srgb::Codes8;
use super::tone::{self, ToneMapping};
use crate::lanes::{Lanes, MAX_LANES, V3, dispatch};
use fearless_simd::{Level, f64x8};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// What lies between the radiance of a picture and its codes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Display {
    /// Factor on all radiance.
    gain: f64,
    tone: ToneMapping,
    /// The linear color that formats of codes show where the background is transparent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    backdrop: Option<[f32; 3]>,
}

impl Default for Display {
    /// Radiance is shown as it is.
    fn default() -> Self {
        Self { gain: 1.0, tone: ToneMapping::None, backdrop: None }
    }
}

/// Pixels that one thread shows at a time.
pub(super) const CHUNK: usize = 1 << 10;

/// Most radiance that is told apart. It is far beyond white for every exposure that scenes may name.
const MOST: f64 = 1e30;

impl Display {
    /// An exposure of some stops, then a tone curve.
    pub fn new(stops: f64, tone: ToneMapping) -> Self {
        Self { gain: crate::math::pow(2.0, stops), tone, backdrop: None }
    }

    /// The same over a linear color, where the background is transparent.
    #[must_use]
    pub fn over(self, color: [f64; 3]) -> Self {
        Self { backdrop: Some(color.map(|channel| channel as f32)), ..self }
    }

    /// That color.
    pub(crate) fn backdrop(&self) -> Option<[f32; 3]> {
        self.backdrop
    }

    /// The radiance that is shown as that color, but for the tone curve.
    pub(crate) fn radiance_behind(&self) -> Option<[f64; 3]> {
        self.backdrop.map(|color| color.map(|channel| f64::from(channel) / self.gain))
    }

    /// Whether radiance is shown as it is.
    #[inline(always)]
    pub fn is_plain(&self) -> bool {
        self.gain == 1.0 && self.tone == ToneMapping::None
    }

    /// An upper estimate of the nanoseconds of one thread for a pixel.
    pub fn nanoseconds(&self) -> f64 {
        match self.tone {
            ToneMapping::None => 0.0,
            ToneMapping::KhronosPbrNeutral => 30.0,
            ToneMapping::Agx => 150.0,
        }
    }

    /// Whether twice the radiance is shown as twice the light.
    pub(crate) fn is_linear(&self) -> bool {
        self.tone == ToneMapping::None
    }

    /// Factor on all radiance.
    pub(crate) fn gain(&self) -> f64 {
        self.gain
    }

    /// The linear color that is shown for a radiance.
    #[inline(always)]
    pub fn show(&self, radiance: [f32; 3]) -> [f32; 3] {
        if self.is_plain() {
            return radiance;
        }
        let [x, y, z] = radiance.map(f64::from);
        self.changed((), V3 { x, y, z }).lane(0).map(|channel| channel as f32)
    }

    #[inline(always)]
    fn changed<L: Lanes<Real = f64>>(&self, s: L::Simd, radiance: V3<L>) -> V3<L> {
        let light =
            V3 { x: self.exposed(s, radiance.x), y: self.exposed(s, radiance.y), z: self.exposed(s, radiance.z) };
        match self.tone {
            ToneMapping::None => light,
            ToneMapping::KhronosPbrNeutral => tone::khronos_pbr_neutral(s, light),
            ToneMapping::Agx => tone::agx(s, light),
        }
    }

    /// [`Self::show`] of many radiances, over lanes: the same bits.
    pub(super) fn show_each(&self, radiance: &[[f32; 3]], shown: &mut [[f32; 3]]) {
        if self.is_plain() {
            return shown.copy_from_slice(radiance);
        }
        dispatch!(Level::new(), show_over_lanes::<f64x8, f64>(self, radiance, shown));
    }

    /// The linear colors that are shown for many radiances, by the current rayon pool.
    pub(crate) fn all<'a>(&self, radiance: &'a [[f32; 3]]) -> Cow<'a, [[f32; 3]]> {
        if self.is_plain() {
            return Cow::Borrowed(radiance);
        }
        let mut shown = vec![[0.0; 3]; radiance.len()];
        let chunks = radiance.par_chunks(CHUNK).zip(shown.par_chunks_mut(CHUNK));
        chunks.for_each(|(radiance, shown)| self.show_each(radiance, shown));
        Cow::Owned(shown)
    }

    /// The lowest and the highest color that is shown for a radiance between `low` and `high`, channel by channel.
    pub fn ends(&self, low: [f32; 3], high: [f32; 3]) -> [[f32; 2]; 3] {
        if self.tone == ToneMapping::None || low == high {
            let (low, high) = (self.show(low), self.show(high));
            return std::array::from_fn(|c| [low[c], high[c]]);
        }
        let light = std::array::from_fn(|c| [self.expose(low[c]), self.expose(high[c])]);
        let ends = match self.tone {
            ToneMapping::Agx => tone::agx_ends(light),
            _ => tone::khronos_pbr_neutral_ends(light),
        };
        ends.map(|[low, high]| [low as f32, high as f32])
    }

    /// The 8-bit codes of a radiance.
    pub fn codes(&self, radiance: [f32; 3]) -> [u8; 3] {
        let table = Codes8::get();
        self.show(radiance).map(|channel| table.code(channel))
    }

    /// The 8-bit codes of a radiance and of what is seen behind it, with their fractions, which are linear in light.
    pub(crate) fn fine_codes(&self, radiance: [f32; 3], behind: [f32; 3]) -> [f32; 3] {
        let (table, shown) = (Codes8::get(), self.show(radiance));
        [0, 1, 2].map(|c| {
            let channel = shown[c] + behind[c];
            let code = table.code(channel);
            if code == u8::MAX {
                return 255.0;
            }
            let [least, next] = [code, code + 1].map(|code| table.least(code));
            f32::from(code) + (channel.max(0.0) - least) / (next - least)
        })
    }

    /// How many codes a picture that shows the radiance `low` is off at most, channel by channel, if the radiance is
    /// nowhere above `high`.
    pub fn codes_off(&self, low: [f32; 3], high: [f32; 3]) -> [u8; 3] {
        let table = Codes8::get();
        if self.is_plain() {
            return std::array::from_fn(|c| table.code(high[c]).saturating_sub(table.code(low[c])));
        }
        self.codes_around(low, low, high)
    }

    /// How far the codes of a radiance between `low` and `high` are at most from those of `shown`.
    pub(crate) fn codes_around(&self, shown: [f32; 3], low: [f32; 3], high: [f32; 3]) -> [u8; 3] {
        let (shown, ends) = (self.codes(shown), self.ends(low, high));
        std::array::from_fn(|c| {
            let [least, most] = ends[c].map(|end| Codes8::get().code(end));
            most.saturating_sub(shown[c]).max(shown[c].saturating_sub(least))
        })
    }

    pub(super) fn expose(&self, channel: f32) -> f64 {
        self.exposed((), f64::from(channel))
    }

    #[inline(always)]
    fn exposed<L: Lanes<Real = f64>>(&self, s: L::Simd, channel: L) -> L {
        let (zero, light) = (L::lit(s, 0.0), channel * L::lit(s, self.gain));
        // NaN becomes black.
        L::select(light.gt(zero), light.min(L::lit(s, MOST)), zero)
    }
}

fn show_over_lanes<L: Lanes<Real = f64>>(s: L::Simd, display: &Display, radiance: &[[f32; 3]], shown: &mut [[f32; 3]]) {
    L::vectorize(
        s,
        #[inline(always)]
        || {
            for (radiance, shown) in radiance.chunks(L::COUNT).zip(shown.chunks_mut(L::COUNT)) {
                let [mut red, mut green, mut blue] = [[0.0; MAX_LANES]; 3];
                for (lane, [r, g, b]) in radiance.iter().enumerate() {
                    (red[lane], green[lane], blue[lane]) = (f64::from(*r), f64::from(*g), f64::from(*b));
                }
                let color = V3 { x: L::load(s, &red), y: L::load(s, &green), z: L::load(s, &blue) };
                let color = display.changed(s, color);
                color.x.store(&mut red);
                color.y.store(&mut green);
                color.z.store(&mut blue);
                for (lane, pixel) in shown.iter_mut().enumerate() {
                    *pixel = [red[lane] as f32, green[lane] as f32, blue[lane] as f32];
                }
            }
        },
    );
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::film) const CURVES: [ToneMapping; 3] =
        [ToneMapping::None, ToneMapping::KhronosPbrNeutral, ToneMapping::Agx];

    /// Numbers from 0 to 1 that look random.
    pub(in crate::film) fn noise(i: u64) -> f32 {
        let mut x = i.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (x >> 40) as f32 / (1 << 24) as f32
    }

    #[test]
    fn no_color_leaves_the_interval_of_its_radiance() {
        for tone in CURVES {
            for stops in [-3.0, 0.0, 0.3, 5.0] {
                let display = Display::new(stops, tone);
                let two_to = |power: f32| crate::math::pow(2.0, f64::from(power)) as f32;
                for case in 0..2_000 {
                    let at = |c: usize, k: u64| noise(case * 100 + k * 3 + c as u64);
                    // Dark and bright, narrow and wide.
                    let low: [f32; 3] = std::array::from_fn(|c| two_to(24.0 * at(c, 0) - 20.0));
                    let wide = two_to(20.0 * noise(case) - 20.0);
                    let size: [f32; 3] = std::array::from_fn(|c| low[c] * wide * at(c, 1));
                    let high = std::array::from_fn(|c| low[c] + size[c]);
                    let (ends, off) = (display.ends(low, high), display.codes_off(low, high));
                    let shown = display.codes(low);
                    for inside in 0..12 {
                        let share = |c: usize| match inside {
                            0..8 => (inside >> c & 1) as f32,
                            _ => at(c, inside),
                        };
                        let light = std::array::from_fn(|c| (low[c] + share(c) * size[c]).clamp(low[c], high[c]));
                        let (seen, codes) = (display.show(light), display.codes(light));
                        for c in 0..3 {
                            let [least, most] = ends[c];
                            assert!((least..=most).contains(&seen[c]), "{tone:?} {low:?} {high:?} {light:?} {ends:?}");
                            assert!(codes[c].abs_diff(shown[c]) <= off[c], "{tone:?} {low:?} {high:?} {light:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn narrow_intervals_stay_narrow() {
        for tone in CURVES {
            let display = Display::new(0.0, tone);
            for case in 0..1_000 {
                let low: [f32; 3] = std::array::from_fn(|c| 2.0 * noise(3 * case + c as u64));
                let high = low.map(|channel| channel + 1e-4);
                assert!(display.codes_off(low, high).into_iter().all(|off| off <= 2), "{tone:?} {low:?}");
                assert_eq!(display.codes_off(low, low), [0; 3]);
            }
        }
    }

    #[test]
    fn odd_radiance_has_a_color() {
        for tone in CURVES {
            let display = Display::new(1.0, tone);
            for odd in [f32::NAN, f32::INFINITY, f32::MAX, 0.0, 1e-40] {
                assert!(display.show([odd; 3]).into_iter().all(f32::is_finite), "{tone:?} {odd}");
                let ends = display.ends([0.0; 3], [odd.max(0.0); 3]);
                assert!(ends.as_flattened().iter().all(|end| end.is_finite()), "{tone:?} {odd} {ends:?}");
            }
            assert_eq!(display.codes([0.0; 3]), [0; 3], "{tone:?}");
        }
    }

    #[test]
    fn many_are_shown_as_each_alone() {
        for tone in CURVES {
            let display = Display::new(0.7, tone);
            for count in [1, 7, 8, 1_003] {
                let light = |i: u64| match i % 97 {
                    0 => f32::NAN,
                    1 => f32::INFINITY,
                    2 => -1.0,
                    _ => crate::math::pow(2.0, f64::from(24.0 * noise(i) - 16.0)) as f32,
                };
                let radiance: Vec<[f32; 3]> =
                    (0..count).map(|i| [light(3 * i), light(3 * i + 1), light(3 * i + 2)]).collect();
                let mut shown = vec![[0.0; 3]; radiance.len()];
                display.show_each(&radiance, &mut shown);
                let alone: Vec<[f32; 3]> = radiance.iter().map(|radiance| display.show(*radiance)).collect();
                let bits =
                    |colors: &[[f32; 3]]| -> Vec<u32> { colors.as_flattened().iter().map(|c| c.to_bits()).collect() };
                assert_eq!(bits(&shown), bits(&alone), "{tone:?}");
            }
        }
    }

    #[test]
    fn a_stop_doubles_light() {
        let display = Display::new(1.0, ToneMapping::None);
        assert_eq!(display.show([0.25, 0.5, 3.0]), [0.5, 1.0, 6.0]);
        assert!(Display::new(0.0, ToneMapping::None).is_plain());
    }
}
