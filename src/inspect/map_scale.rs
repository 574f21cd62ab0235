//! The scale below a map: its colors, ticks with their numbers, and what they mean.

use font8x8::{BASIC_FONTS, UnicodeFonts};

/// Which color stands for which number.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scale {
    /// The number of the first color, above 0 on a logarithmic scale.
    pub(super) low: f32,
    /// The number of the last color. Greater ones have it, too.
    pub(super) high: f32,
    /// Whether equal steps are equal factors.
    pub(super) is_logarithmic: bool,
    /// What the numbers are, from the longest text to the shortest: the first that fits is written.
    pub(super) names: [String; 2],
}

/// Edge of a letter.
const LETTER: usize = 8;
/// Rows: a gap, the colors, the ticks, a gap, the numbers, a gap, the name, a gap.
const ROWS: [usize; 8] = [3, 10, 4, 2, LETTER, 4, LETTER, 3];

/// The color map viridis (van der Walt and Smith 2015), by the polynomials of Zucker ("matplotlib colormaps", CC0), from 0
/// to 1. Its brightness rises evenly, so it can be read without seeing colors.
pub(super) fn viridis(t: f32) -> [u8; 3] {
    const POLYNOMIALS: [[f32; 3]; 7] = [
        [0.277_727_33, 0.005_407_345, 0.334_099_8],
        [0.105_093_04, 1.404_613_5, 1.384_590_2],
        [-0.330_861_83, 0.214_847_56, 0.095_095_165],
        [-4.634_230_6, -5.799_101, -19.332_441],
        [6.228_27, 14.179_934, 56.690_55],
        [4.776_385, -13.745_145, -65.353_035],
        [-5.435_456, 4.645_852_6, 26.312_435],
    ];
    let t = t.clamp(0.0, 1.0);
    let channel = |c: usize| POLYNOMIALS.iter().rev().fold(0.0, |sum, factors| sum * t + factors[c]);
    std::array::from_fn(|c| (255.0 * channel(c).clamp(0.0, 1.0)).round() as u8)
}

impl Scale {
    /// Where a number lies, 0 to 1.
    pub(super) fn along(&self, value: f32) -> f32 {
        let part = if self.is_logarithmic {
            libm::logf(value.max(self.low) / self.low) / libm::logf((self.high / self.low).max(1.01))
        } else {
            (value - self.low) / (self.high - self.low).max(1e-9)
        };
        part.clamp(0.0, 1.0)
    }

    /// Rows of pixels below the map.
    pub(super) fn rows(&self, width: usize) -> Vec<[u8; 3]> {
        let [gap, colors, ticks, space, numbers, between, _, _] = ROWS;
        let mut rows = vec![[255; 3]; width * ROWS.iter().sum::<usize>()];
        for row in rows.chunks_mut(width).skip(gap).take(colors) {
            for (x, pixel) in row.iter_mut().enumerate() {
                *pixel = viridis(x as f32 / (width - 1).max(1) as f32);
            }
        }
        let top = gap + colors + ticks + space;
        let mut free = 0;
        for tick in self.ticks() {
            let x = (self.along(tick) * (width - 1) as f32).round() as usize;
            let text = number(tick);
            let wide = LETTER * text.len();
            let left = x.saturating_sub(wide / 2).min(width.saturating_sub(wide));
            if left < free || wide > width {
                continue;
            }
            free = left + wide + LETTER;
            for row in gap + colors..gap + colors + ticks {
                rows[row * width + x] = [0; 3];
            }
            write(&mut rows[top * width..], width, left, &text);
        }
        if let Some(name) = self.names.iter().find(|name| LETTER * name.len() <= width) {
            write(&mut rows[(top + numbers + between) * width..], width, 0, name);
        }
        rows
    }

    /// Round numbers between the ends; the ends themselves where there is no other.
    fn ticks(&self) -> Vec<f32> {
        let steps = [1.0, 2.0, 5.0];
        let inside = |value: &f32| (self.low..=self.high).contains(value);
        let decades = |low: f32, high: f32| {
            let ends = [low, high].map(|end| libm::floorf(libm::log10f(end)) as i32);
            (ends[0]..=ends[1]).flat_map(move |decade| steps.map(|step| step * power_of_ten(decade)))
        };
        let ticks: Vec<f32> = if self.is_logarithmic {
            let few = self.high / self.low < 1e3;
            let is_decade = |value: &f32| libm::roundf(libm::log10f(*value) * 1e4) % 1e4 == 0.0;
            decades(self.low, self.high).filter(inside).filter(|value| few || is_decade(value)).collect()
        } else {
            let wide = self.high - self.low;
            // Codes and depths are whole numbers.
            let step = decades(1.0, wide.max(1.0) * 10.0).find(|step| wide / step <= 10.0).unwrap_or(wide);
            (0..=10).map(|i| libm::ceilf(self.low / step) * step + i as f32 * step).filter(inside).collect()
        };
        if ticks.len() < 2 { vec![self.low, self.high] } else { ticks }
    }
}

fn power_of_ten(decade: i32) -> f32 {
    crate::math::pow(10.0, f64::from(decade)) as f32
}

/// A number in a few characters.
fn number(value: f32) -> String {
    match value {
        v if v >= 1e6 => trimmed(format!("{:.1}", v / 1e6)) + "M",
        v if v >= 1e4 => trimmed(format!("{:.1}", v / 1e3)) + "k",
        v if v >= 10.0 => format!("{v:.0}"),
        v if v >= 0.1 => trimmed(format!("{v:.2}")),
        v => trimmed(format!("{v:.5}")),
    }
}

/// Without zeros after the point.
fn trimmed(number: String) -> String {
    number.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Writes a line of ASCII into rows of pixels.
fn write(rows: &mut [[u8; 3]], width: usize, left: usize, text: &str) {
    for (place, letter) in text.chars().enumerate() {
        let glyph = BASIC_FONTS.get(letter).unwrap_or_default();
        for (row, dots) in glyph.into_iter().enumerate() {
            for column in (0..LETTER).filter(|column| dots & (1 << column) != 0) {
                let at = left + place * LETTER + column;
                if at < width {
                    rows[row * width + at] = [0; 3];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(low: f32, high: f32, is_logarithmic: bool) -> Scale {
        Scale { low, high, is_logarithmic, names: ["rays of each pixel, logarithmic".into(), "rays, log".into()] }
    }

    #[test]
    fn colors_go_from_dark_blue_to_yellow_and_get_ever_brighter() {
        let brightness = |[r, g, b]: [u8; 3]| 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
        let steps: Vec<f64> = (0..=64).map(|i| brightness(viridis(i as f32 / 64.0))).collect();
        assert!(steps.windows(2).all(|pair| pair[0] < pair[1]), "{steps:?}");
        // Matplotlib's ends are #440154 and #fde725.
        let near = |a: [u8; 3], b: [u8; 3]| a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 4);
        assert!(near(viridis(0.0), [0x44, 0x01, 0x54]) && near(viridis(1.0), [0xfd, 0xe7, 0x25]));
    }

    #[test]
    fn ticks_are_round_numbers() {
        let named = |scale: Scale| scale.ticks().into_iter().map(number).collect::<Vec<_>>().join(" ");
        assert_eq!(named(scale(0.0, 10.0, false)), "0 1 2 3 4 5 6 7 8 9 10");
        assert_eq!(named(scale(0.0, 255.0, false)), "0 50 100 150 200 250");
        assert_eq!(named(scale(0.0, 1.0, false)), "0 1");
        assert_eq!(named(scale(3.0, 300.0, true)), "5 10 20 50 100 200");
        assert_eq!(named(scale(1.0, 2e6, true)), "1 10 100 1000 10k 100k 1M");
        assert_eq!(named(scale(0.0004, 0.03, true)), "0.0005 0.001 0.002 0.005 0.01 0.02");
        assert_eq!(named(scale(3.0, 4.0, true)), "3 4");
    }

    #[test]
    fn numbers_stand_apart_and_inside() {
        for width in [1, 7, 40, 120, 640, 1920] {
            for scale in [scale(0.0, 255.0, false), scale(1.0, 2e6, true), scale(5.0, 5.0, true)] {
                let rows = scale.rows(width);
                assert_eq!(rows.len(), width * ROWS.iter().sum::<usize>());
                // Something is written wherever the shorter name has room.
                let is_written = rows[width * 19..].contains(&[0; 3]);
                assert!(is_written || width < 72, "{width}");
            }
        }
    }
}
