//! Maps of a picture in false colors: proved errors, rays, time and depth of each pixel.

use super::map_scale::{Scale, viridis};
use crate::film::{Film, Region, encode_gray};
use crate::metrics::Image8;
use crate::render::Picture;
use schemars::JsonSchema;
use serde::Deserialize;

/// What a map shows of each pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum MapKind {
    /// Most 8-bit codes that it is off, by what is proved; where nothing bounds what is missing, those up to white.
    #[default]
    Proved,
    /// Rays of all kinds.
    Rays,
    /// Nanoseconds of processor time: those of the up to 16 pixels that were traced with it, by its share of their rays.
    Time,
    /// Rays in the longest chain.
    Depth,
    /// Samples.
    Samples,
}

/// A number for each pixel of a region.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    kind: MapKind,
    region: Region,
    values: Vec<f32>,
}

/// Share of the pixels that the scale of a map of times has colors for. A thread that the system interrupts makes a pixel take a
/// hundred times as long, which would leave one color to all others.
const TIMED: f64 = 0.999;

impl Map {
    /// The map of a picture. All but [`MapKind::Proved`] need one from
    /// [`render_measured`](crate::render::render_measured).
    pub fn of(kind: MapKind, picture: &Picture) -> Self {
        let region = picture.film.region;
        let mut values = vec![0.0; picture.film.pixels.len()];
        if kind == MapKind::Proved {
            for bounded in picture.bounded.iter() {
                let index = region.index(bounded.at);
                let off = picture.film.codes_off(index, bounded.highest, bounded.least_alpha);
                values[index] = f32::from(off.into_iter().fold(0, u8::max));
            }
            return Self { kind, region, values };
        }
        for cost in &picture.costs {
            let value = &mut values[region.index(cost.at)];
            match kind {
                MapKind::Rays => *value += cost.rays as f32,
                MapKind::Time => *value += cost.nanoseconds as f32,
                MapKind::Samples => *value += cost.samples as f32,
                // A refined pixel is listed twice: its base samples and the others.
                _ => *value = value.max(cost.deepest as f32),
            }
        }
        Self { kind, region, values }
    }

    /// A map of a picture whose pixels are blocks of `step` x `step` of these, of which it has those in `region`.
    pub fn enlarged(self, step: u32, region: Region) -> Self {
        if step == 1 {
            return self;
        }
        let values = region.iter().map(|[x, y]| self.values[self.region.index([x / step, y / step])]).collect();
        Self { region, values, ..self }
    }

    /// The numbers as a grey PFM.
    pub fn pfm(&self) -> Vec<u8> {
        encode_gray(self.region.width, self.region.height, &self.values)
    }

    /// The numbers, in all three channels of a film.
    pub fn film(&self) -> Film {
        let Region { x, y, width, height } = self.region;
        let pixels = self.values.iter().map(|value| [*value; 3]).collect();
        Film { region: self.region, full_width: x + width, full_height: y + height, pixels, ..Film::default() }
    }

    /// The map in colors, from dark blue to yellow, with its scale below: linear for codes and depths, logarithmic for rays
    /// and times.
    pub fn draw(&self) -> Image8 {
        let (unit, scale) = self.scale();
        let width = self.region.width as usize;
        let mut pixels: Vec<[u8; 3]> = self.values.iter().map(|value| viridis(scale.along(unit * *value))).collect();
        pixels.extend(scale.rows(width));
        Image8::opaque(width, pixels)
    }

    /// What the numbers are multiplied by for the scale, and the scale.
    fn scale(&self) -> (f32, Scale) {
        let mut sorted = self.values.clone();
        sorted.sort_by(f32::total_cmp);
        let most = sorted.last().copied().unwrap_or(0.0);
        let least = sorted.iter().copied().find(|value| *value > 0.0).unwrap_or(1.0);
        let rank = libm::ceil(TIMED * sorted.len() as f64) as usize;
        let usual = sorted.get(rank.saturating_sub(1)).copied().unwrap_or(most);
        let names = |long: &str, short: &str| [long.to_owned(), short.to_owned()];
        match self.kind {
            MapKind::Proved => {
                let names = names("codes of 255 that each pixel is off at most", "codes");
                (1.0, Scale { low: 0.0, high: most.max(1.0), is_logarithmic: false, names })
            }
            MapKind::Depth => {
                let names = names("rays in the longest chain of each pixel", "depth");
                (1.0, Scale { low: 0.0, high: most.max(1.0), is_logarithmic: false, names })
            }
            MapKind::Samples => {
                let names = names("samples of each pixel, logarithmic", "samples, log");
                (1.0, Scale { low: 1.0, high: most.max(2.0), is_logarithmic: true, names })
            }
            MapKind::Rays => {
                let names = names("rays of each pixel, logarithmic", "rays, log");
                (1.0, Scale { low: least.max(1.0), high: most.max(2.0), is_logarithmic: true, names })
            }
            MapKind::Time => {
                let more = if usual < most { "; up to " } else { "" };
                let slowest = if usual < most { format!("{:.3}", MS * most) } else { String::new() };
                let long = format!("ms of processor time of each pixel, logarithmic{more}{slowest}");
                let high = MS * usual.max(2.0 * least);
                (MS, Scale { low: MS * least, high, is_logarithmic: true, names: [long, "ms, log".to_owned()] })
            }
        }
    }
}

/// Milliseconds of a nanosecond.
const MS: f32 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    fn map(kind: MapKind, values: Vec<f32>) -> Map {
        let region = Region { x: 3, y: 4, width: values.len() as u32, height: 1 };
        Map { kind, region, values }
    }

    #[test]
    fn the_least_and_the_most_have_the_ends_of_the_scale() {
        let depths = map(MapKind::Depth, vec![0.0, 5.0, 10.0]).draw();
        assert_eq!(depths.pixels[..3], [viridis(0.0), viridis(0.5), viridis(1.0)]);
        let rays = map(MapKind::Rays, vec![2.0, 20.0, 200.0]).draw();
        assert_eq!(rays.pixels[..3], [viridis(0.0), viridis(0.5), viridis(1.0)]);
    }

    /// Times of the other pixels keep their colors.
    #[test]
    fn one_pixel_that_was_interrupted_does_not_stretch_the_scale_of_times() {
        let mut times: Vec<f32> = (0..5_000).map(|i| 1_000.0 + i as f32).collect();
        let before = map(MapKind::Time, times.clone()).draw();
        times[7] = 25e6;
        let after = map(MapKind::Time, times).draw();
        let moved = (8..5_000).map(|i| before.pixels[i].iter().zip(after.pixels[i]).map(|(a, b)| a.abs_diff(b)).max());
        assert!(moved.flatten().all(|codes| codes <= 3));
        assert_eq!(after.pixels[7], viridis(1.0));
    }

    #[test]
    fn maps_of_one_value_or_none_can_be_drawn() {
        for kind in [MapKind::Proved, MapKind::Rays, MapKind::Time, MapKind::Depth, MapKind::Samples] {
            for value in [0.0, 1.0, 3e9] {
                assert_eq!(map(kind, vec![value; 120]).draw().width, 120);
            }
            map(kind, vec![1.0]).draw();
        }
    }
}
