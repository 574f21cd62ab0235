//! Contact sheets: many pictures, small and side by side in one.

use super::encode::png_of;
use super::{Film, Region};
use rayon::prelude::*;

/// Longest side of a sheet that nobody asks to be wider, in pixels.
const SIDE: u32 = 2_048;
/// Longest and shortest side of a picture on it.
const SIDES: [u32; 2] = [512, 16];

/// Pixels across and down of each of so many pictures on a sheet, which is about as wide as high.
pub fn cell(count: u32, [width, height]: [u32; 2]) -> [u32; 2] {
    let longest = width.max(height);
    let side = (SIDE / columns(count, [width, height])).clamp(SIDES[1], SIDES[0]).min(longest);
    [width, height].map(|length| ((u64::from(length) * u64::from(side) / u64::from(longest)) as u32).max(1))
}

/// How many of them are side by side.
pub fn columns(count: u32, [width, height]: [u32; 2]) -> u32 {
    let count = count.max(1);
    (1..count)
        .find(|n| u64::from(*n).pow(2) * u64::from(width) >= u64::from(count) * u64::from(height))
        .unwrap_or(count)
}

/// A small picture of a film, at most as large as that: each pixel is the mean of the light in its place.
pub fn small(film: &Film, [width, height]: [u32; 2]) -> Film {
    let Region { width: w, height: h, .. } = film.region;
    // Where a pixel of the small one begins, in pixels of the large one.
    let edge = |at: u32, length: u32, of: u32| f64::from(at) * f64::from(of) / f64::from(length);
    let mean = |index: usize| {
        let [x, y] = [index as u32 % width, index as u32 / width];
        let ([left, right], [top, bottom]) =
            ([x, x + 1].map(|x| edge(x, width, w)), [y, y + 1].map(|y| edge(y, height, h)));
        let (mut color, mut alpha, mut area) = ([0.0_f64; 3], 0.0, 0.0);
        for row in top as u32..(bottom.ceil() as u32).min(h) {
            let down = (f64::from(row) + 1.0).min(bottom) - f64::from(row).max(top);
            for column in left as u32..(right.ceil() as u32).min(w) {
                let share = down * ((f64::from(column) + 1.0).min(right) - f64::from(column).max(left));
                let at = row as usize * w as usize + column as usize;
                (0..3).for_each(|c| color[c] += share * f64::from(film.pixels[at][c]));
                alpha += share * film.alpha.get(at).map_or(0.0, |alpha| f64::from(*alpha));
                area += share;
            }
        }
        (color.map(|c| (c / area) as f32), (alpha / area) as f32)
    };
    let (pixels, alpha): (Vec<_>, Vec<_>) = (0..width as usize * height as usize).into_par_iter().map(mean).unzip();
    Film {
        region: Region::whole(width, height),
        full_width: width,
        full_height: height,
        pixels,
        alpha: if film.alpha.is_empty() { Vec::new() } else { alpha },
        display: film.display,
    }
}

/// A sheet of pictures of one size.
#[derive(Debug)]
pub struct Sheet {
    cell: [u32; 2],
    columns: u32,
    rows: u32,
    /// Four codes for each pixel.
    codes: Vec<u8>,
}

impl Sheet {
    /// An empty one for so many pictures, so many side by side.
    pub fn new(count: u32, cell: [u32; 2], columns: u32) -> Self {
        let rows = count.div_ceil(columns);
        let pixels = u64::from(columns) * u64::from(rows) * u64::from(cell[0]) * u64::from(cell[1]);
        Self { cell, columns, rows, codes: vec![0; 4 * pixels as usize] }
    }

    /// Puts a picture in its place: the file of a small one. Nothing is put there if it has another size.
    pub fn put(&mut self, number: u32, png: &[u8]) {
        let [width, height] = self.cell;
        let Ok(picture) = image::load_from_memory_with_format(png, image::ImageFormat::Png) else { return };
        if [picture.width(), picture.height()] != self.cell || number >= self.columns * self.rows {
            return;
        }
        let row = 4 * width as usize;
        let (column, above) = ((number % self.columns) as usize, (number / self.columns * height) as usize);
        let rows = self.codes.chunks_mut(row * self.columns as usize).skip(above);
        for (to, from) in rows.zip(picture.to_rgba8().chunks(row)) {
            to[column * row..][..row].copy_from_slice(from);
        }
    }

    /// The file.
    pub fn png(&self) -> Vec<u8> {
        let [width, height] = self.cell;
        png_of(width * self.columns, height * self.rows, &self.codes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{FileFormat, encode};

    #[test]
    fn sheets_are_about_square() {
        assert_eq!((columns(36, [512, 512]), cell(36, [512, 512])), (6, [341, 341]));
        assert_eq!((columns(36, [1920, 1080]), cell(36, [1920, 1080])), (5, [409, 230]));
        assert_eq!((columns(1, [64, 64]), cell(1, [64, 64])), (1, [64, 64]));
        assert_eq!((columns(3, [1, 16_384]), cell(3_600, [16_384, 1])), (3, [512, 1]));
    }

    #[test]
    fn light_is_kept_and_pictures_are_where_they_belong() {
        let film = |value: f32| Film {
            region: Region::whole(7, 5),
            full_width: 7,
            full_height: 5,
            pixels: (0..35).map(|i| [value * i as f32; 3]).collect(),
            ..Film::default()
        };
        let whole = small(&film(1.0), [1, 1]);
        assert!((whole.pixels[0][0] - 17.0).abs() < 1e-6);
        let third = small(&film(1.0), [3, 2]);
        let mean = third.pixels.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / 6.0;
        assert!((mean - 17.0).abs() < 1e-5, "{mean}");

        let mut sheet = Sheet::new(3, [7, 5], 2);
        let file = encode(&film(0.02), FileFormat::Png8);
        sheet.put(2, &file);
        sheet.put(1, &encode(&third, FileFormat::Png8));
        let seen = image::load_from_memory(&sheet.png()).unwrap().to_rgba8();
        assert_eq!(seen.dimensions(), (14, 10));
        let alone = image::load_from_memory(&file).unwrap().to_rgba8();
        assert!(alone.enumerate_pixels().all(|(x, y, pixel)| seen.get_pixel(x, y + 5) == pixel));
        assert_eq!(seen.get_pixel(10, 2).0, [0; 4], "another size is not put there");
    }
}
