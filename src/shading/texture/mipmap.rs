//! Mipmaps: a picture and ever smaller copies of it in linear light (Williams, Pyramidal Parametrics, 1983). A lookup
//! interpolates between two levels, and takes several samples along a footprint that is longer than wide (Heckbert 1989).
//!
//! All of it is f64 for one ray at a time: fetching texels takes most of the time, and the bits are the same everywhere.

use crate::math;

/// A picture and its smaller copies.
#[derive(Debug)]
pub struct Mipmap {
    levels: Vec<Level>,
}

/// Rows from top to bottom.
#[derive(Debug)]
struct Level {
    width: usize,
    height: usize,
    texels: Vec<[f32; 3]>,
}

/// What lies beyond the edges of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wrap {
    /// The picture again.
    Repeat,
    /// Its last texel.
    Clamp,
}

/// Most samples along a footprint; longer footprints are blurred.
const MOST_LOOKS: f64 = 16.0;

impl Mipmap {
    /// The mipmap over `width * height` texels, at least one, row by row from the top.
    pub fn new(width: u32, height: u32, texels: Vec<[f32; 3]>) -> Self {
        let mut levels = vec![Level { width: width as usize, height: height as usize, texels }];
        while let Some(next) = levels.last().and_then(Level::halved) {
            levels.push(next);
        }
        Self { levels }
    }

    /// Bytes of memory it takes.
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(&level.texels[..])).sum()
    }

    /// Texels across and down.
    pub fn size(&self) -> [f64; 2] {
        [self.levels[0].width as f64, self.levels[0].height as f64]
    }

    /// Its texel, if all are the same.
    pub fn uniform(&self) -> Option<[f64; 3]> {
        let texels = &self.levels[0].texels;
        texels.iter().all(|texel| *texel == texels[0]).then(|| texels[0].map(f64::from))
    }

    /// The largest of each channel over all texels.
    pub fn brightest(&self) -> [f64; 3] {
        let most = |most: [f32; 3], texel: &[f32; 3]| std::array::from_fn(|c| most[c].max(texel[c]));
        self.levels[0].texels.iter().fold([0.0; 3], most).map(f64::from)
    }

    /// The mean of all texels.
    pub fn mean(&self) -> [f64; 3] {
        self.levels[self.levels.len() - 1].texels[0].map(f64::from)
    }

    /// The level whose texels are `texels` wide, as a number between 0 and the last.
    pub fn level(&self, texels: f64) -> f64 {
        let last = (self.levels.len() - 1) as f64;
        if texels > 1.0 { math::log2(texels).min(last) } else { 0.0 }
    }

    /// Between the two nearest levels, bilinear in each, at (u, v) in a picture whose lower left corner is (0, 0) and
    /// whose upper right corner is (1, 1).
    pub fn at(&self, uv: [f64; 2], level: f64, wrap: [Wrap; 2]) -> [f64; 3] {
        let below = (level.floor() as usize).min(self.levels.len() - 1);
        let fine = self.levels[below].at(uv, wrap);
        match (self.levels.get(below + 1), level - level.floor()) {
            (Some(above), part) if part > 0.0 => mix(fine, above.at(uv, wrap), part),
            _ => fine,
        }
    }

    /// The mean over a footprint around (u, v), given by its two axes, from side to side.
    pub fn average(&self, uv: [f64; 2], axes: [[f64; 2]; 2], wrap: [Wrap; 2]) -> [f64; 3] {
        let [width, height] = self.size();
        let texels = |[u, v]: [f64; 2]| ((u * width).powi(2) + (v * height).powi(2)).sqrt();
        let [a, b] = axes.map(texels);
        let (longer, long, short) = if a > b { (axes[0], a, b) } else { (axes[1], b, a) };
        let looks = (long / short.max(1.0)).ceil().clamp(1.0, MOST_LOOKS);
        let level = self.level(short.max(long / MOST_LOOKS));
        let mut sum = [0.0; 3];
        for look in 0..looks as u32 {
            let along = (f64::from(look) + 0.5) / looks - 0.5;
            let seen = self.at([uv[0] + longer[0] * along, uv[1] + longer[1] * along], level, wrap);
            for (sum, seen) in sum.iter_mut().zip(seen) {
                *sum += seen / looks;
            }
        }
        sum
    }
}

impl Level {
    /// Half as large in each direction, at least one texel. Texels are means over equal parts, so the mean of all stays.
    fn halved(&self) -> Option<Self> {
        if self.texels.len() == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let (columns, rows) = (shares(self.width, width), shares(self.height, height));
        let mut texels = Vec::with_capacity(width * height);
        for row in &rows {
            for column in &columns {
                let mut sum = [0.0; 3];
                for &(y, down) in row {
                    for &(x, across) in column {
                        let texel = self.texels[y * self.width + x];
                        for (sum, texel) in sum.iter_mut().zip(texel) {
                            *sum += f64::from(texel) * (down * across);
                        }
                    }
                }
                texels.push(sum.map(|x| x as f32));
            }
        }
        Some(Self { width, height, texels })
    }

    fn at(&self, [u, v]: [f64; 2], wrap: [Wrap; 2]) -> [f64; 3] {
        let (left, right, across) = neighbours(u, self.width, wrap[0]);
        let (upper, lower, down) = neighbours(1.0 - v, self.height, wrap[1]);
        let texel = |x: usize, y: usize| self.texels[y * self.width + x].map(f64::from);
        let above = mix(texel(left, upper), texel(right, upper), across);
        let below = mix(texel(left, lower), texel(right, lower), across);
        mix(above, below, down)
    }
}

/// For each of `fewer` equal parts of a row of `many` texels: the texels it covers, and their shares in it.
fn shares(many: usize, fewer: usize) -> Vec<Vec<(usize, f64)>> {
    // In units of 1/fewer of a texel all borders are whole numbers.
    let part = |i: usize| {
        let (from, to) = (i * many, (i + 1) * many);
        let cover = |texel: usize| to.min((texel + 1) * fewer) - from.max(texel * fewer);
        (from / fewer..to.div_ceil(fewer)).map(|texel| (texel, cover(texel) as f64 / many as f64)).collect()
    };
    (0..fewer).map(part).collect()
}

/// The two texels whose centres enclose a place in a row, 0 to 1, and how far it lies from the first to the second.
fn neighbours(place: f64, count: usize, wrap: Wrap) -> (usize, usize, f64) {
    let inside = match wrap {
        Wrap::Repeat => place - place.floor(),
        Wrap::Clamp => place.clamp(0.0, 1.0),
    };
    let x = inside * count as f64 - 0.5;
    let first = x.floor();
    let texel = |i: i64| match wrap {
        Wrap::Repeat => i.rem_euclid(count as i64) as usize,
        Wrap::Clamp => i.clamp(0, count as i64 - 1) as usize,
    };
    (texel(first as i64), texel(first as i64 + 1), x - first)
}

/// From `a` to `b`.
pub(super) fn mix(a: [f64; 3], b: [f64; 3], part: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] * (1.0 - part) + b[i] * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(width: u32, height: u32) -> Mipmap {
        let texel = |i: u32| [(i % width) as f32, (i / width) as f32, 1.0];
        Mipmap::new(width, height, (0..width * height).map(texel).collect())
    }

    #[test]
    fn every_level_has_the_mean_of_the_picture() {
        for (width, height) in [(1, 1), (2, 1), (7, 5), (64, 64), (13, 1), (100, 3)] {
            let mipmap = ramp(width, height);
            let expected = [f64::from(width - 1) / 2.0, f64::from(height - 1) / 2.0, 1.0];
            for level in &mipmap.levels {
                for channel in 0..3 {
                    let sum: f64 = level.texels.iter().map(|texel| f64::from(texel[channel])).sum();
                    let mean = sum / level.texels.len() as f64;
                    assert!((mean - expected[channel]).abs() < 1e-4, "{width} x {height}: {mean}");
                }
            }
            assert_eq!(mipmap.levels[mipmap.levels.len() - 1].texels.len(), 1);
        }
    }

    #[test]
    fn magnified_it_is_bilinear() {
        let mipmap = ramp(8, 4);
        let clamp = [Wrap::Clamp; 2];
        for (u, v) in [(0.3, 0.4), (0.5, 0.5), (0.1, 0.8)] {
            let small = [[0.01, 0.0], [0.0, 0.02]];
            let [x, y, one] = mipmap.average([u, v], small, clamp);
            assert!((x - (u * 8.0 - 0.5)).abs() < 1e-12 && (y - ((1.0 - v) * 4.0 - 0.5)).abs() < 1e-12 && one == 1.0);
        }
        assert_eq!(mipmap.at([-3.0, 9.0], 0.0, clamp), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn seams_do_not_show() {
        let mipmap = ramp(8, 4);
        let repeat = [Wrap::Repeat; 2];
        for level in [0.0, 0.7, 2.0] {
            for x in [0.0, 1.0, -5.0] {
                let [left, right] = [x - 1e-9, x + 1e-9].map(|u| mipmap.at([u, 0.3], level, repeat)[0]);
                assert!((left - right).abs() < 1e-6, "{left} {right}");
            }
            let [here, there] = [0.25, 7.25].map(|u| mipmap.at([u, 0.3], level, repeat));
            assert_eq!(here, there);
        }
    }

    #[test]
    fn a_huge_footprint_sees_the_mean() {
        let mipmap = ramp(16, 16);
        let mean = mipmap.average([0.2, 0.7], [[30.0, 0.0], [0.0, 1e9]], [Wrap::Repeat; 2]);
        assert!(mean.iter().zip(mipmap.mean()).all(|(a, b)| (a - b).abs() < 1e-9));
    }
}
