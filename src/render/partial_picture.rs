//! A picture while it is rendered in stages.

use super::contrast::{CONTRAST, codes_of, contrasts};
use super::packets::Traced;
use crate::bound::BoundedPixel;
use crate::trace::counts::RayCounts;

use crate::film::Region;
use rayon::prelude::*;

/// Distance of the traced pixels, across and down, in the first and the second stage.
pub(super) const STRIDES: [u32; 2] = [32, 8];
/// Likely width of the interval around the sample of a pixel on an edge, as a share of the contrast there: twice the standard
/// deviation of the part that an edge covers, which may lie anywhere in the pixel.
const EDGE: f64 = 0.58;

/// Rows that a thread fills at a time.
const STRIP: u32 = 16;

/// The pixels so far.
pub(super) struct PartialPicture {
    pub(super) region: Region,
    pub(super) shown: Vec<[f32; 3]>,
    /// Upper bound of each pixel.
    pub(super) highest: Vec<[f32; 3]>,
    /// Samples of each pixel so far.
    pub(super) samples: Vec<u32>,
    /// Interval of each pixel in codes, if it has several samples.
    widths: Vec<u8>,
    pub(super) rays: RayCounts,
}

impl PartialPicture {
    pub(super) fn new(region: Region) -> Self {
        let count = region.pixels() as usize;
        Self {
            region,
            shown: vec![[0.0; 3]; count],
            highest: vec![[0.0; 3]; count],
            samples: vec![0; count],
            widths: vec![0; count],
            rays: RayCounts::default(),
        }
    }

    /// Samples that the picture is made of.
    pub(super) fn traced_samples(&self) -> u64 {
        self.samples.iter().map(|samples| u64::from(*samples)).sum()
    }

    /// Pixels that were traced themselves.
    pub(super) fn traced_pixels(&self) -> u64 {
        self.samples.iter().filter(|samples| **samples > 0).count() as u64
    }

    pub(super) fn paint(&mut self, at: &[[u32; 2]], samples: u32, traced: &Traced) {
        self.rays = self.rays + traced.rays;
        for (&at, pixel) in at.iter().zip(&traced.pixels) {
            let index = self.region.index(at);
            (self.shown[index], self.highest[index], self.samples[index]) = (*pixel, *pixel, samples);
        }
        for (&at, width) in at.iter().zip(&traced.widths) {
            self.widths[self.region.index(at)] = *width;
        }
        for bounded in traced.bounded.iter() {
            self.highest[self.region.index(bounded.at)] = bounded.highest;
        }
    }

    /// Whether a pixel is the first of a square of `stride` pixels across and down.
    pub(super) fn is_first(&self, [x, y]: [u32; 2], stride: u32) -> bool {
        (x - self.region.x).is_multiple_of(stride) && (y - self.region.y).is_multiple_of(stride)
    }

    /// The first pixel of the square around a pixel.
    fn first(&self, [x, y]: [u32; 2], stride: u32) -> usize {
        let square = |at: u32, from: u32| from + (at - from) / stride * stride;
        self.region.index([square(x, self.region.x), square(y, self.region.y)])
    }

    /// The index of the finest stride whose square around a pixel has been traced.
    fn level(&self, at: [u32; 2]) -> usize {
        usize::from(self.samples[self.first(at, STRIDES[1])] > 0)
    }

    /// The picture so far. Pixels that were not traced look like the first one of their square, and have no upper bound.
    /// `tells` says whether intervals can be estimated.
    pub(super) fn filled(self, tells: bool) -> Traced {
        let of = |at: [u32; 2]| {
            let index = self.region.index(at);
            if self.samples[index] > 0 {
                return (self.shown[index], self.highest[index]);
            }
            (self.shown[self.first(at, STRIDES[self.level(at)])], [f32::INFINITY; 3])
        };
        let strips: Vec<Region> = self.strips().collect();
        let fill = |strip: &Region| {
            let (mut pixels, mut bounded) = (Vec::with_capacity(strip.pixels() as usize), Vec::new());
            for at in strip.iter() {
                let (shown, highest) = of(at);
                pixels.push(shown);
                if highest != shown {
                    bounded.push(BoundedPixel { at, highest });
                }
            }
            (pixels, bounded)
        };
        let parts: Vec<(Vec<[f32; 3]>, Vec<BoundedPixel>)> = strips.par_iter().map(fill).collect();
        let mut filled = Traced { rays: self.rays, ..Traced::default() };
        filled.pixels.reserve(self.shown.len());
        for (pixels, bounded) in parts {
            filled.pixels.extend(pixels);
            filled.bounded.add(bounded);
        }
        if tells {
            filled.widths = self.all_widths(&filled.pixels);
        }
        filled
    }

    /// The region in strips, for threads.
    fn strips(&self) -> impl Iterator<Item = Region> + use<> {
        let region = self.region;
        let rows = (region.y..region.y + region.height).step_by(STRIP as usize);
        rows.map(move |y| Region { y, height: STRIP.min(region.y + region.height - y), ..region })
    }

    /// The interval of each pixel in codes: by its samples; with one sample by its neighbours; without a sample by the
    /// difference of its square from the squares around it.
    fn all_widths(&self, shown: &[[f32; 3]]) -> Vec<u8> {
        let of_pixels = contrasts(&codes_of(shown), self.region.width);
        let of_squares = STRIDES.map(|stride| self.contrasts_of_squares(shown, stride));
        let each = |at: [u32; 2]| {
            let index = self.region.index(at);
            match self.samples[index] {
                0 => of_squares[self.level(at)](at).saturating_mul(2),
                1 if of_pixels[index] < CONTRAST => of_pixels[index],
                1 => (f64::from(of_pixels[index]) * EDGE) as u8,
                _ => self.widths[index],
            }
        };
        let strips: Vec<Region> = self.strips().collect();
        strips.par_iter().flat_map_iter(|strip| strip.iter().map(each)).collect()
    }

    /// How much the square around a pixel differs from its neighbours.
    fn contrasts_of_squares(&self, shown: &[[f32; 3]], stride: u32) -> impl Fn([u32; 2]) -> u8 + Sync + use<> {
        let Region { x, y, width, height } = self.region;
        let squares = Region { x: 0, y: 0, width: width.div_ceil(stride), height: height.div_ceil(stride) };
        let of_square = |[column, row]: [u32; 2]| shown[self.first([x + column * stride, y + row * stride], stride)];
        let mut contrasts = contrasts(&codes_of(&squares.iter().map(of_square).collect::<Vec<_>>()), squares.width);
        if squares.pixels() == 1 {
            // Nothing to compare it with.
            contrasts = vec![u8::MAX];
        }
        move |at: [u32; 2]| contrasts[squares.index([(at[0] - x) / stride, (at[1] - y) / stride])]
    }
}
