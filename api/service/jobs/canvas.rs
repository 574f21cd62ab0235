//! The unfinished picture of a job: finished tiles, and a preview whose gaps are filled by coarser passes.

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
}

impl Canvas {
    /// All black.
    pub(super) fn new(width: u32, height: u32) -> Self {
        let scale = width.max(height).div_ceil(PREVIEW_SIDE).next_power_of_two();
        let small = [width.div_ceil(scale), height.div_ceil(scale)];
        let preview = empty(small, Region::whole(small[0], small[1])).film;
        Self {
            picture: empty([width, height], Region::whole(width, height)),
            decided: vec![false; preview.pixels.len()],
            preview,
            scale,
        }
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
        join(&mut self.picture, tile);
        let Region { x, y, width, height } = tile.film.region;
        let scale = self.scale;
        for row in y / scale..(y + height).div_ceil(scale) {
            for column in x / scale..(x + width).div_ceil(scale) {
                let at = (row * self.preview.region.width + column) as usize;
                self.preview.pixels[at] = average(&self.picture.film, column * scale, row * scale, scale);
                self.decided[at] = true;
            }
        }
    }

    /// Adds a part of a coarse pass, whose pixels are 2^level times as wide as the picture's.
    pub(super) fn fill(&mut self, part: &Film, level: u32) {
        let (scale, width) = (self.scale, self.preview.region.width);
        for (at, pixel) in self.preview.pixels.iter_mut().enumerate().filter(|(at, _)| !self.decided[*at]) {
            let of = |small: usize| (small as u32 * scale) >> level;
            let (x, y) = (of(at % width as usize), of(at / width as usize));
            let Region { x: left, y: top, width, height } = part.region;
            if (left..left + width).contains(&x) && (top..top + height).contains(&y) {
                *pixel = part.pixels[((y - top) * width + (x - left)) as usize];
            }
        }
    }

    /// A part of the picture.
    pub(super) fn crop(&self, region: Region) -> Film {
        let Film { full_width, full_height, .. } = self.picture.film;
        let at = |[x, y]: [u32; 2]| self.picture.film.pixels[y as usize * full_width as usize + x as usize];
        Film { region, full_width, full_height, pixels: region.iter().map(at).collect() }
    }
}

/// Average of the pixels of a square that lie in the picture.
fn average(film: &Film, left: u32, top: u32, side: u32) -> [f32; 3] {
    let Region { width, height, .. } = film.region;
    let square = Region { x: left, y: top, width: side.min(width - left), height: side.min(height - top) };
    let weight = 1.0 / square.pixels() as f32;
    square.iter().fold([0.0; 3], |sum, [x, y]| {
        let pixel = film.pixels[y as usize * width as usize + x as usize];
        std::array::from_fn(|channel| sum[channel] + pixel[channel] * weight)
    })
}

/// A black region of a picture of some width and height, for which no ray was traced.
pub(super) fn empty([full_width, full_height]: [u32; 2], region: Region) -> Picture {
    let pixels = vec![[0.0; 3]; region.pixels() as usize];
    let film = Film { region, full_width, full_height, pixels };
    Picture { film, ..Picture::default() }
}

/// Puts a tile where it belongs, and adds up what they took.
fn join(whole: &mut Picture, piece: &Picture) {
    paste(&mut whole.film, &piece.film);
    whole.bounded.append(piece.bounded.clone());
    whole.sampling += &piece.sampling;
    whole.costs.extend_from_slice(&piece.costs);
    whole.rays = whole.rays + piece.rays;
    whole.refined.pixels += piece.refined.pixels;
    whole.refined.rays = whole.refined.rays + piece.refined.rays;
    whole.trace_ms += piece.trace_ms;
    whole.refine_ms += piece.refine_ms;
}

/// Puts a part of a film where it belongs.
fn paste(whole: &mut Film, piece: &Film) {
    let (outer, inner) = (whole.region, piece.region);
    let (left, top) = ((inner.x - outer.x) as usize, (inner.y - outer.y) as usize);
    let rows = whole.pixels.chunks_mut(outer.width as usize).skip(top);
    for (row, part) in rows.zip(piece.pixels.chunks(inner.width as usize)) {
        row[left..left + part.len()].copy_from_slice(part);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(region: Region, value: f32) -> Film {
        Film { region, full_width: 1, full_height: 1, pixels: vec![[value; 3]; region.pixels() as usize] }
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
        assert_eq!(canvas.crop(Region { x: 95, y: 70, width: 2, height: 1 }).pixels, [[1.0; 3], [0.0; 3]]);
    }
}
