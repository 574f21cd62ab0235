//! The unfinished picture of a job: finished tiles, and a preview whose gaps are filled by coarser pictures.

use crate::service::pictures::assembly::{empty, join};
use strahl::film::encode::png_of;
use strahl::film::{Film, Region};
use strahl::render::Picture;

/// Longest side of a preview in pixels.
pub(crate) const PREVIEW_SIDE: u32 = 1_024;

/// The picture so far.
#[derive(Debug)]
pub(super) struct Canvas {
    pub(super) picture: Picture,
    /// The preview.
    pub(super) preview: Film,
    /// Width of a pixel of the preview in pixels of the picture: a power of two.
    scale: u32,
    /// Pixels of the preview that come from finished tiles.
    decided: Vec<bool>,
    /// Whether anything was painted.
    is_painted: bool,
}

/// Width of a pixel of the preview in pixels of the picture: a power of two.
fn scale_of(width: u32, height: u32) -> u32 {
    width.max(height).div_ceil(PREVIEW_SIDE).next_power_of_two()
}

/// The preview of a picture in a file of codes, a PNG; none if it is in another format.
pub(super) fn preview_of(file: &[u8], width: u32, height: u32) -> Option<Vec<u8>> {
    let picture = image::load_from_memory(file).ok()?;
    let scale = scale_of(width, height);
    let small = picture.thumbnail_exact(width.div_ceil(scale), height.div_ceil(scale));
    let (width, height, alpha) = (small.width(), small.height(), small.color().has_alpha());
    let codes = if alpha { small.into_rgba8().into_raw() } else { small.into_rgb8().into_raw() };
    Some(png_of(width, height, &codes))
}

impl Canvas {
    /// The level of the coarse picture that has the size of the preview.
    pub(super) fn level(&self) -> u32 {
        self.scale.ilog2()
    }

    /// All black.
    pub(super) fn new(width: u32, height: u32) -> Self {
        let scale = scale_of(width, height);
        let small = [width.div_ceil(scale), height.div_ceil(scale)];
        let preview = empty(small, Region::whole(small[0], small[1])).film;
        Self {
            picture: empty([width, height], Region::whole(width, height)),
            decided: vec![false; preview.pixels.len()],
            preview,
            scale,
            is_painted: false,
        }
    }

    /// The preview, once anything was painted.
    pub(super) fn painted(&self) -> Option<&Film> {
        Some(&self.preview).filter(|_| self.is_painted)
    }

    /// A preview that becomes finer and finer, without any tile of the picture.
    pub(super) fn of_preview(width: u32, height: u32) -> Self {
        Self { picture: Picture::default(), ..Self::new(width, height) }
    }

    /// All of a picture.
    pub(super) fn of(picture: Picture) -> Self {
        let Film { full_width, full_height, .. } = picture.film;
        let mut canvas = Self::new(full_width, full_height);
        canvas.finish(&picture);
        Self { picture, ..canvas }
    }

    /// Adds a finished tile. Its corners lie at multiples of 32 pixels, or it is the whole picture.
    pub(super) fn finish(&mut self, tile: &Picture) {
        self.is_painted = true;
        join(&mut self.picture, tile);
        self.preview.display = tile.film.display;
        let Region { x, y, width, height } = tile.film.region;
        let scale = self.scale;
        for row in y / scale..(y + height).div_ceil(scale) {
            for column in x / scale..(x + width).div_ceil(scale) {
                let at = (row * self.preview.region.width + column) as usize;
                let (color, alpha) = average(&self.picture.film, column * scale, row * scale, scale);
                put(&mut self.preview, at, color, alpha);
                self.decided[at] = true;
            }
        }
    }

    /// Shows a coarse picture, whose pixels are 2^level times as wide as the picture's, where no tile is finished.
    pub(super) fn fill(&mut self, coarse: &Film, level: u32) {
        self.is_painted = true;
        let (scale, width) = (self.scale as f32, self.preview.region.width as usize);
        let of = |small: usize| (small as f32 + 0.5) * scale / (1 << level) as f32 - 0.5;
        self.preview.display = coarse.display;
        for at in (0..self.decided.len()).filter(|at| !self.decided[*at]) {
            let (color, alpha) = interpolated(coarse, [of(at % width), of(at / width)]);
            put(&mut self.preview, at, color, alpha);
        }
    }

    /// A part of the picture.
    pub(super) fn crop(&self, region: Region) -> Film {
        let Film { full_width, full_height, ref pixels, ref alpha, display, .. } = self.picture.film;
        let at = |[x, y]: [u32; 2]| y as usize * full_width as usize + x as usize;
        Film {
            region,
            full_width,
            full_height,
            pixels: region.iter().map(|pixel| pixels[at(pixel)]).collect(),
            alpha: region.iter().filter_map(|pixel| alpha.get(at(pixel)).copied()).collect(),
            display,
        }
    }
}

/// Puts a pixel into a film, which becomes transparent with the first alpha.
fn put(film: &mut Film, at: usize, color: [f32; 3], alpha: Option<f32>) {
    film.pixels[at] = color;
    if let Some(alpha) = alpha {
        film.alpha.resize(film.pixels.len(), 0.0);
        film.alpha[at] = alpha;
    }
}

/// Average of the pixels of a square that lie in the picture, and of their alpha, if there is any.
fn average(film: &Film, left: u32, top: u32, side: u32) -> ([f32; 3], Option<f32>) {
    let Region { width, height, .. } = film.region;
    let square = Region { x: left, y: top, width: side.min(width - left), height: side.min(height - top) };
    let weight = 1.0 / square.pixels() as f32;
    let at = |[x, y]: [u32; 2]| y as usize * width as usize + x as usize;
    let color = square.iter().fold([0.0; 3], |sum, pixel| {
        let pixel = film.pixels[at(pixel)];
        std::array::from_fn(|channel| sum[channel] + pixel[channel] * weight)
    });
    let alpha = square.iter().filter_map(|pixel| film.alpha.get(at(pixel))).map(|alpha| alpha * weight).sum();
    (color, (!film.alpha.is_empty()).then_some(alpha))
}

/// The color between the centres of a picture's pixels, and the alpha, if there is any.
fn interpolated(film: &Film, [x, y]: [f32; 2]) -> ([f32; 3], Option<f32>) {
    let Region { width, height, .. } = film.region;
    let around = |at: f32, length: u32| {
        let at = at.clamp(0.0, (length - 1) as f32);
        (at as usize, (at as usize + 1).min(length as usize - 1), at.fract())
    };
    let ((left, right, across), (top, bottom, down)) = (around(x, width), around(y, height));
    let mix = |a: f32, b: f32, share: f32| a * (1.0 - share) + b * share;
    let mean = |of: &dyn Fn(usize) -> f32| {
        let [a, b] = [top, bottom].map(|y| y * width as usize).map(|row| mix(of(row + left), of(row + right), across));
        mix(a, b, down)
    };
    let color = std::array::from_fn(|c| mean(&|at| film.pixels[at][c]));
    (color, (!film.alpha.is_empty()).then(|| mean(&|at| film.alpha[at])))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(region: Region, value: f32) -> Film {
        let pixels = vec![[value; 3]; region.pixels() as usize];
        Film { region, full_width: 1, full_height: 1, pixels, ..Film::default() }
    }

    #[test]
    fn tiles_decide_and_passes_fill_the_gaps() {
        let mut canvas = Canvas::new(1_100, 100);
        assert_eq!((canvas.preview.region, canvas.scale), (Region::whole(550, 50), 2));
        canvas.fill(&part(Region::whole(138, 13), 0.25), 3);
        assert!(canvas.preview.pixels.iter().all(|pixel| *pixel == [0.25; 3]));
        let tile = Region { x: 64, y: 64, width: 32, height: 32 };
        canvas.finish(&Picture { film: part(tile, 1.0), ..empty([1_100, 100], tile) });
        canvas.fill(&part(Region::whole(275, 25), 0.5), 2);
        let at = |canvas: &Canvas, x: usize, y: usize| canvas.preview.pixels[y * 550 + x];
        assert_eq!([at(&canvas, 32, 32), at(&canvas, 47, 47), at(&canvas, 48, 47)], [[1.0; 3], [1.0; 3], [0.5; 3]]);
        // Between the centres of coarse pixels lies what is between them.
        let mut coarse = part(Region::whole(138, 13), 0.0);
        coarse.pixels.iter_mut().step_by(2).for_each(|pixel| *pixel = [1.0; 3]);
        canvas.fill(&coarse, 3);
        let row: Vec<f32> = (0..6).map(|x| at(&canvas, x, 0)[0]).collect();
        assert_eq!(row, [1.0, 1.0, 0.875, 0.625, 0.375, 0.125]);
        assert_eq!(canvas.crop(Region { x: 95, y: 70, width: 2, height: 1 }).pixels, [[1.0; 3], [0.0; 3]]);
    }
}
