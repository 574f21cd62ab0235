//! Mipmaps: a picture and ever smaller copies of it in linear light (Williams, Pyramidal Parametrics, 1983). `lookup.rs` looks them
//! up.
//!
//! Pictures of 8 bits are kept as their codes, with a table of what they stand for: 7 bytes for a texel with all levels in place of
//! 16, and the same numbers to the bit. Smaller copies are numbers: rounded to codes they would change pictures.

use crate::control;
use rayon::prelude::*;

/// A picture and its smaller copies.
#[derive(Debug)]
pub struct Mipmap {
    pub(super) levels: Vec<Level>,
    /// The smallest and the largest of each channel.
    extremes: [[f32; 3]; 2],
}

/// Rows from top to bottom.
#[derive(Debug)]
pub(super) struct Level {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) texels: Texels,
}

/// What is kept of a level.
#[derive(Debug)]
pub(super) enum Texels {
    Numbers(Vec<[f32; 3]>),
    /// Three codes for each texel, and what they stand for.
    Codes(Vec<u8>, Box<[f32; 256]>),
}

impl Mipmap {
    /// The mipmap over `width * height` texels, at least one, row by row from the top.
    pub fn new(width: u32, height: u32, texels: Vec<[f32; 3]>) -> Self {
        Self::over(width, height, Texels::Numbers(texels))
    }

    /// The same over codes, three for each texel, and what each of them stands for.
    pub fn of_codes(width: u32, height: u32, codes: Vec<u8>, values: [f32; 256]) -> Self {
        Self::over(width, height, Texels::Codes(codes, Box::new(values)))
    }

    fn over(width: u32, height: u32, texels: Texels) -> Self {
        let extremes = extremes(&texels);
        let mut mipmap =
            Self { levels: vec![Level { width: width as usize, height: height as usize, texels }], extremes };
        while let Some(next) = mipmap.halved() {
            mipmap.levels.push(next);
        }
        mipmap
    }

    /// Bytes of memory it takes.
    pub fn bytes(&self) -> usize {
        let of = |level: &Level| match &level.texels {
            Texels::Numbers(texels) => size_of_val(&texels[..]),
            Texels::Codes(codes, values) => codes.len() + size_of_val(&values[..]),
        };
        self.levels.iter().map(of).sum()
    }

    /// Bytes that one takes, its largest size as codes or as numbers.
    pub fn bytes_for(width: u32, height: u32, is_coded: bool) -> u64 {
        let (mut width, mut height) = (u64::from(width), u64::from(height));
        let mut bytes = if is_coded { 3 * width * height + 1_024 } else { 12 * width * height };
        while width * height > 1 {
            (width, height) = ((width / 2).max(1), (height / 2).max(1));
            bytes += 12 * width * height;
        }
        bytes
    }

    /// Texels across and down.
    pub fn size(&self) -> [f64; 2] {
        [self.levels[0].width as f64, self.levels[0].height as f64]
    }

    /// Its texel, if all are the same.
    pub fn uniform(&self) -> Option<[f64; 3]> {
        let [least, most] = self.extremes;
        (least == most).then(|| least.map(f64::from))
    }

    /// The largest of each channel over all texels.
    pub fn brightest(&self) -> [f64; 3] {
        self.extremes[1].map(|channel| f64::from(channel.max(0.0)))
    }

    /// The smallest of each channel over all texels.
    pub fn darkest(&self) -> [f64; 3] {
        self.extremes[0].map(f64::from)
    }

    /// The means over the cells of a grid, no finer than the texels, of a picture that repeats across, row by row from the top. Each
    /// row of texels counts by `weight`. Between texels lookups are linear, so an eighth of each texel lies in each of its neighbours.
    pub fn means(&self, columns: usize, rows: usize, weight: impl Fn(usize) -> f64 + Sync) -> Vec<[f64; 3]> {
        const SPREAD: [f64; 3] = [0.125, 0.75, 0.125];
        let Level { width, height, .. } = &self.levels[0];
        let cells = shares(*width, columns);
        let of_row = |part: &Vec<(usize, f64)>| {
            if control::step(part.len() as u32 * steps(*width)) {
                return vec![[0.0; 3]; columns];
            }
            let mut row = vec![[0.0; 3]; *width];
            let all: f64 = part.iter().map(|(y, share)| share * weight(*y)).sum();
            for &(y, share) in part {
                let around = [y.saturating_sub(1), y, (y + 1).min(height - 1)];
                for (y, factor) in around.into_iter().zip(SPREAD.map(|part| part * share * weight(y) / all)) {
                    for (x, sum) in row.iter_mut().enumerate() {
                        add(sum, self.texel(0, x, y).map(f64::from), factor);
                    }
                }
            }
            let of_cell = |cell: &Vec<(usize, f64)>| {
                let mut mean = [0.0; 3];
                for &(x, share) in cell {
                    let around = [(x + width - 1) % width, x, (x + 1) % width];
                    around.into_iter().zip(SPREAD).for_each(|(x, part)| add(&mut mean, row[x], part * share));
                }
                mean
            };
            cells.iter().map(of_cell).collect::<Vec<_>>()
        };
        shares(*height, rows).par_iter().map(of_row).collect::<Vec<_>>().concat()
    }

    /// The mean of all texels.
    pub fn mean(&self) -> [f64; 3] {
        self.texel(self.levels.len() - 1, 0, 0).map(f64::from)
    }

    fn texel(&self, level: usize, x: usize, y: usize) -> [f32; 3] {
        self.levels[level].texel(x, y)
    }

    /// The copy of the last level that is half as large in each direction, at least one texel. Texels are means over equal
    /// parts, so the mean of all stays.
    fn halved(&self) -> Option<Level> {
        let last = self.levels.last()?;
        if last.width * last.height == 1 {
            return None;
        }
        let (width, height) = ((last.width / 2).max(1), (last.height / 2).max(1));
        let texels = match &last.texels {
            _ if !last.width.is_multiple_of(2) || !last.height.is_multiple_of(2) => last.means_of_parts(width, height),
            Texels::Numbers(texels) => means_of_four(width, texels, |texel| *texel),
            Texels::Codes(codes, values) => means_of_four(width, codes.as_chunks().0, |codes| decoded(*codes, values)),
        };
        Some(Level { width, height, texels: Texels::Numbers(texels) })
    }
}

impl Level {
    pub(super) fn texel(&self, x: usize, y: usize) -> [f32; 3] {
        let i = y * self.width + x;
        match &self.texels {
            Texels::Numbers(texels) => texels[i],
            Texels::Codes(codes, values) => decoded(codes.as_chunks().0[i], values),
        }
    }

    /// The means over equal parts, which may cover texels in part.
    fn means_of_parts(&self, width: usize, height: usize) -> Vec<[f32; 3]> {
        let (columns, rows) = (shares(self.width, width), shares(self.height, height));
        let mut texels = Vec::with_capacity(width * height);
        for row in &rows {
            if control::step(steps(self.width)) {
                // Nobody looks at it any more.
                texels.resize(width * height, [0.0; 3]);
                break;
            }
            for column in &columns {
                let mut sum = [0.0; 3];
                for &(y, down) in row {
                    for &(x, across) in column {
                        add(&mut sum, self.texel(x, y).map(f64::from), down * across);
                    }
                }
                texels.push(sum.map(|x| x as f32));
            }
        }
        texels
    }
}

/// The means of two by two texels, so many across.
fn means_of_four<T>(width: usize, texels: &[T], texel: impl Fn(&T) -> [f32; 3]) -> Vec<[f32; 3]> {
    let mut means = Vec::with_capacity(texels.len() / 4);
    for rows in texels.chunks_exact(4 * width) {
        if control::step(steps(2 * width)) {
            // Nobody looks at it any more.
            means.resize(texels.len() / 4, [0.0; 3]);
            break;
        }
        let (upper, lower) = rows.split_at(2 * width);
        for (upper, lower) in upper.as_chunks::<2>().0.iter().zip(lower.as_chunks::<2>().0) {
            let mut sum = [0.0; 3];
            upper.iter().chain(lower).for_each(|it| add(&mut sum, texel(it).map(f64::from), 0.25));
            means.push(sum.map(|x| x as f32));
        }
    }
    means
}

/// Steps of a control for two rows of texels.
fn steps(width: usize) -> u32 {
    1 + (width / 64) as u32
}

fn add(sum: &mut [f64; 3], light: [f64; 3], factor: f64) {
    sum.iter_mut().zip(light).for_each(|(sum, channel)| *sum += channel * factor);
}

/// The smallest and the largest of each channel.
fn extremes(texels: &Texels) -> [[f32; 3]; 2] {
    let mut extremes = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    let mut note = |texel: [f32; 3]| {
        for c in 0..3 {
            extremes[0][c] = extremes[0][c].min(texel[c]);
            extremes[1][c] = extremes[1][c].max(texel[c]);
        }
    };
    match texels {
        Texels::Numbers(texels) => texels.iter().for_each(|texel| note(*texel)),
        Texels::Codes(codes, values) => {
            // Codes that are there, so that values are looked up once.
            let mut is_there = [[false; 256]; 3];
            for texel in codes.as_chunks::<3>().0 {
                for c in 0..3 {
                    is_there[c][usize::from(texel[c])] = true;
                }
            }
            for code in 0..256 {
                for c in (0..3).filter(|c| is_there[*c][code]) {
                    extremes[0][c] = extremes[0][c].min(values[code]);
                    extremes[1][c] = extremes[1][c].max(values[code]);
                }
            }
        }
    }
    extremes
}

/// What the codes of a texel stand for.
#[inline(always)]
pub(super) fn decoded([r, g, b]: [u8; 3], values: &[f32; 256]) -> [f32; 3] {
    [values[usize::from(r)], values[usize::from(g)], values[usize::from(b)]]
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    fn ramp(width: u32, height: u32) -> Mipmap {
        let texel = |i: u32| [(i % width) as f32, (i / width) as f32, 1.0];
        Mipmap::new(width, height, (0..width * height).map(texel).collect())
    }

    /// The slow twin takes the shares of texels into account, which are whole here.
    #[test]
    fn means_of_four_are_those_of_parts() {
        let codes: Vec<u8> = (0..3 * 24 * 8).map(|i: u32| (i * 97 + i / 7) as u8).collect();
        let values = std::array::from_fn(|code| (code * code) as f32 / 65_025.0);
        let coded = Mipmap::of_codes(24, 8, codes, values);
        for level in &coded.levels[..3] {
            let numbers: Vec<[f32; 3]> =
                (0..level.width * level.height).map(|i| level.texel(i % level.width, i / level.width)).collect();
            let of_parts = level.means_of_parts(level.width / 2, level.height / 2);
            assert_eq!(means_of_four(level.width / 2, &numbers, |texel| *texel), of_parts);
        }
        let Texels::Numbers(second) = &coded.levels[1].texels else { panic!("codes of codes") };
        assert_eq!(*second, coded.levels[0].means_of_parts(12, 4));
    }

    #[test]
    fn every_level_has_the_mean_of_the_picture() {
        for (width, height) in [(1, 1), (2, 1), (7, 5), (64, 64), (13, 1), (100, 3)] {
            let mipmap = ramp(width, height);
            let expected = [f64::from(width - 1) / 2.0, f64::from(height - 1) / 2.0, 1.0];
            for (index, level) in mipmap.levels.iter().enumerate() {
                for channel in 0..3 {
                    let texels = (0..level.height).flat_map(|y| (0..level.width).map(move |x| (x, y)));
                    let sum: f64 = texels.map(|(x, y)| f64::from(mipmap.texel(index, x, y)[channel])).sum();
                    let mean = sum / (level.width * level.height) as f64;
                    assert!((mean - expected[channel]).abs() < 1e-4, "{width} x {height}: {mean}");
                }
            }
            let last = &mipmap.levels[mipmap.levels.len() - 1];
            assert_eq!((last.width, last.height), (1, 1));
        }
    }

    /// Codes take a quarter of the memory, and give the same numbers on every level.
    #[test]
    fn codes_are_the_numbers_that_they_stand_for_to_the_bit() {
        let values: [f32; 256] = std::array::from_fn(|code| math::srgb_to_linear(code as f64 / 255.0) as f32);
        for (width, height) in [(1, 1), (2, 2), (2, 1), (64, 32), (13, 8), (31, 17), (100, 6), (256, 256)] {
            let codes: Vec<u8> = (0..3 * u64::from(width * height)).map(|i| (i * i / 7 % 256) as u8).collect();
            let numbers = codes.chunks(3).map(|texel| [0, 1, 2].map(|c| values[usize::from(texel[c])])).collect();
            let (coded, numbers) =
                (Mipmap::of_codes(width, height, codes, values), Mipmap::new(width, height, numbers));
            assert_eq!((coded.uniform(), coded.mean()), (numbers.uniform(), numbers.mean()));
            assert_eq!((coded.brightest(), coded.darkest()), (numbers.brightest(), numbers.darkest()));
            for (level, kept) in numbers.levels.iter().enumerate() {
                for (x, y) in (0..kept.height).flat_map(|y| (0..kept.width).map(move |x| (x, y))) {
                    assert_eq!(
                        coded.texel(level, x, y),
                        kept.texel(x, y),
                        "{width} x {height}, level {level}, {x} {y}"
                    );
                }
            }
            for (mipmap, is_coded) in [(&coded, true), (&numbers, false)] {
                assert_eq!(mipmap.bytes() as u64, Mipmap::bytes_for(width, height, is_coded), "{width} x {height}");
            }
        }
        // With all levels, and the table of 1 KiB.
        let texels = 1 << 24;
        assert_eq!(Mipmap::bytes_for(4_096, 4_096, true), 7 * texels - 4 + 1_024);
        assert_eq!(Mipmap::bytes_for(4_096, 4_096, false), 16 * texels - 4);
    }
}
