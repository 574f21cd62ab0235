//! Maps of a picture in false colours: proved errors, rays, time and depth of each pixel.

use crate::film::srgb;
use crate::film::{Film, Region};
use crate::metrics::Image8;
use crate::render::Picture;
use schemars::JsonSchema;
use serde::Deserialize;

/// What a map shows of each pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum MapKind {
    /// Most 8-bit codes that it is off, by what is proved; 255 where nothing bounds it.
    #[default]
    Proved,
    /// Rays of all kinds.
    Rays,
    /// Nanoseconds of tracing it alone.
    Time,
    /// Rays in the longest chain.
    Depth,
}

/// A number for each pixel of a region.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    kind: MapKind,
    region: Region,
    values: Vec<f32>,
}

/// Rows of the scale below the picture: a gap, the colors, a gap, a line of text, a gap.
const SCALE: [usize; 5] = [3, 8, 3, 10, 3];

impl Map {
    /// The map of a picture. All but [`MapKind::Proved`] need one from
    /// [`render_one_by_one`](crate::render::render_one_by_one).
    pub fn of(kind: MapKind, picture: &Picture) -> Self {
        let region = picture.film.region;
        let mut values = vec![0.0; picture.film.pixels.len()];
        if kind == MapKind::Proved {
            for bounded in picture.bounded.iter() {
                let index = region.index(bounded.at);
                let (table, shown) = (srgb::Codes8::get(), picture.film.pixels[index]);
                let off = |c: usize| table.code(bounded.highest[c]).saturating_sub(table.code(shown[c]));
                values[index] = f32::from(off(0).max(off(1)).max(off(2)));
            }
            return Self { kind, region, values };
        }
        for cost in &picture.costs {
            let value = &mut values[region.index(cost.at)];
            match kind {
                MapKind::Rays => *value += cost.rays as f32,
                MapKind::Time => *value += cost.nanoseconds as f32,
                // A refined pixel is listed twice: its base samples and the others.
                _ => *value = value.max(cost.deepest as f32),
            }
        }
        Self { kind, region, values }
    }

    /// The numbers, in all three channels of a film.
    pub fn film(&self) -> Film {
        let Region { x, y, width, height } = self.region;
        let pixels = self.values.iter().map(|value| [*value; 3]).collect();
        Film { region: self.region, full_width: x + width, full_height: y + height, pixels }
    }

    /// The map in colors, from dark blue to yellow, with its scale below: linear for codes and depths, logarithmic for rays
    /// and times.
    pub fn draw(&self) -> Image8 {
        let most = self.values.iter().copied().fold(0.0, f32::max);
        let (low, high) = match self.kind {
            MapKind::Proved => (0.0, most.max(1.0)),
            MapKind::Depth => (0.0, most.max(1.0)),
            MapKind::Rays | MapKind::Time => {
                let least = self.values.iter().copied().filter(|value| *value > 0.0).fold(f32::INFINITY, f32::min);
                (least.min(most).max(1.0), most.max(2.0))
            }
        };
        let along = |value: f32| match self.kind {
            MapKind::Proved | MapKind::Depth => (value - low) / (high - low),
            MapKind::Rays | MapKind::Time => libm::logf(value.max(low) / low) / libm::logf((high / low).max(1.01)),
        };
        let width = self.region.width as usize;
        let mut pixels: Vec<[u8; 3]> = self.values.iter().map(|value| viridis(along(*value))).collect();
        let [gap, colors, between, text, below] = SCALE;
        pixels.resize(pixels.len() + gap * width, [255; 3]);
        for _ in 0..colors {
            pixels.extend((0..width).map(|x| viridis(x as f32 / (width - 1).max(1) as f32)));
        }
        pixels.resize(pixels.len() + between * width, [255; 3]);
        let line = pixels.len();
        pixels.resize(line + (text + below) * width, [255; 3]);
        let unit = match self.kind {
            MapKind::Proved => "CODES",
            MapKind::Rays => "RAYS",
            MapKind::Time => "NS",
            MapKind::Depth => "DEEP",
        };
        let (left, right) = (brief(low), format!("{} {unit}", brief(high)));
        write(&mut pixels[line..], width, 2, &left);
        let from = width.saturating_sub(ADVANCE * right.len() + 1);
        if from > ADVANCE * (left.len() + 1) {
            write(&mut pixels[line..], width, from, &right);
        }
        Image8 { width, pixels }
    }
}

/// The color map viridis (van der Walt and Smith 2015), by the polynomials of Zucker ("matplotlib colormaps", CC0), from 0
/// to 1. Its brightness rises evenly, so it can be read without seeing colors.
fn viridis(t: f32) -> [u8; 3] {
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

/// A number in a few digits.
fn brief(value: f32) -> String {
    match value {
        v if v < 10_000.0 => format!("{v:.0}"),
        v if v < 1e6 => format!("{:.0}K", v / 1e3),
        v => format!("{:.1}M", v / 1e6),
    }
}

/// Pixels from one letter to the next: three columns of two pixels, and a gap.
const ADVANCE: usize = 8;

/// Writes a line into rows of pixels, each dot of a letter two pixels wide and high.
fn write(rows: &mut [[u8; 3]], width: usize, left: usize, text: &str) {
    for (place, letter) in text.chars().enumerate() {
        for (row, dots) in glyph(letter).into_iter().enumerate() {
            for column in (0..3).filter(|column| dots & (4 >> column) != 0) {
                for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let at = left + place * ADVANCE + 2 * column + x;
                    if at < width {
                        rows[(2 * row + y) * width + at] = [0; 3];
                    }
                }
            }
        }
    }
}

/// The five rows of a letter of three columns, for the letters that scales need.
fn glyph(letter: char) -> [u8; 5] {
    match letter {
        '0' | 'O' => [7, 5, 5, 5, 7],
        '1' => [2, 6, 2, 2, 7],
        '2' => [7, 1, 7, 4, 7],
        '3' => [7, 1, 7, 1, 7],
        '4' => [5, 5, 7, 1, 1],
        '5' => [7, 4, 7, 1, 7],
        '6' => [7, 4, 7, 5, 7],
        '7' => [7, 1, 2, 2, 2],
        '8' => [7, 5, 7, 5, 7],
        '9' => [7, 5, 7, 1, 7],
        '.' => [0, 0, 0, 0, 2],
        'A' => [2, 5, 7, 5, 5],
        'C' => [7, 4, 4, 4, 7],
        'D' => [6, 5, 5, 5, 6],
        'E' => [7, 4, 6, 4, 7],
        'K' => [5, 5, 6, 5, 5],
        'M' => [5, 7, 7, 5, 5],
        'N' => [6, 5, 5, 5, 5],
        'P' => [7, 5, 7, 4, 4],
        'R' => [6, 5, 6, 5, 5],
        'S' => [3, 4, 2, 1, 6],
        'Y' => [5, 5, 2, 2, 2],
        _ => [0; 5],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(kind: MapKind, values: Vec<f32>) -> Map {
        let region = Region { x: 3, y: 4, width: values.len() as u32, height: 1 };
        Map { kind, region, values }
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
    fn the_least_and_the_most_have_the_ends_of_the_scale() {
        let depths = map(MapKind::Depth, vec![0.0, 5.0, 10.0]).draw();
        assert_eq!(depths.pixels[..3], [viridis(0.0), viridis(0.5), viridis(1.0)]);
        let rays = map(MapKind::Rays, vec![2.0, 20.0, 200.0]).draw();
        assert_eq!(rays.pixels[..3], [viridis(0.0), viridis(0.5), viridis(1.0)]);
        assert_eq!(rays.height(), 1 + SCALE.iter().sum::<usize>());
    }

    #[test]
    fn maps_of_one_value_or_none_can_be_drawn() {
        for kind in [MapKind::Proved, MapKind::Rays, MapKind::Time, MapKind::Depth] {
            for value in [0.0, 1.0, 3e9] {
                assert_eq!(map(kind, vec![value; 120]).draw().width, 120);
            }
            map(kind, vec![1.0]).draw();
        }
    }
}
