//! A picture while it is rendered in steps.

use super::contrast::{CONTRAST, codes_of, codes_over_background, contrasts, over_background};
use super::held_out::{HeldOut, QUANTILES};
use super::interpolation::interpolate;
use super::ladder::{COARSEST, Chunk, Ladder};
use super::packets::Traced;
use crate::bound::BoundedPixel;
use crate::film::{Display, Region};
use crate::trace::counts::RayCounts;
use rayon::prelude::*;

/// Likely width of the interval around the sample of a pixel on an edge, as a share of the contrast there: twice the standard
/// deviation of the part that an edge covers, which may lie anywhere in the pixel.
const EDGE: f64 = 0.58;

/// The pixels so far, row by row.
pub(super) struct PartialPicture {
    pub(super) region: Region,
    /// How light becomes colors.
    display: Display,
    shown: Vec<[f32; 3]>,
    /// The alpha of each pixel; empty where the background is opaque.
    alpha: Vec<f32>,
    /// Upper bound of each traced pixel.
    highest: Vec<[f32; 3]>,
    /// The least alpha of each traced pixel.
    least_alpha: Vec<f32>,
    /// The level of each pixel on the ladder.
    pub(super) levels: Vec<u8>,
    /// Whether rays that were omitted at first could bring a pixel more than a code.
    lacks: Vec<bool>,
    /// Codes of the pixels, before antialiasing.
    codes: Vec<[u8; 3]>,
    /// The same over what is behind a transparent background.
    codes_over_background: Vec<[u8; 3]>,
    /// Contrast of each pixel to its neighbours, before antialiasing.
    pub(super) contrasts: Vec<u8>,
    /// Interval of each pixel in codes, if it has several samples.
    widths: Vec<u8>,
    /// Whether the pixels that were not traced have been interpolated.
    was_updated: bool,
    /// How wrong pixels were before they were traced, and with one sample.
    held_out: [HeldOut; 2],
    pub(super) rays: RayCounts,
    /// Those of antialiasing.
    pub(super) refining: RayCounts,
}

impl PartialPicture {
    pub(super) fn new(region: Region, display: Display, is_transparent: bool) -> Self {
        let count = region.pixels() as usize;
        let count_of_alpha = if is_transparent { count } else { 0 };
        Self {
            region,
            display,
            shown: vec![[0.0; 3]; count],
            alpha: vec![0.0; count_of_alpha],
            highest: vec![[0.0; 3]; count],
            least_alpha: vec![0.0; count_of_alpha],
            levels: vec![0; count],
            lacks: vec![false; count],
            codes: vec![[0; 3]; count],
            codes_over_background: vec![[0; 3]; count_of_alpha],
            contrasts: vec![0; count],
            widths: vec![0; count],
            was_updated: false,
            held_out: [HeldOut::default(), HeldOut::default()],
            rays: RayCounts::default(),
            refining: RayCounts::default(),
        }
    }

    /// Pixels whose level is so.
    pub(super) fn count(&self, is_wanted: impl Fn(u8) -> bool) -> u64 {
        self.levels.iter().filter(|level| is_wanted(**level)).count() as u64
    }

    /// Whether a pixel is one of those at a distance from each other, across and down, which is a power of two.
    pub(super) fn is_on_grid(&self, [x, y]: [u32; 2], distance: u32) -> bool {
        ((x - self.region.x) | (y - self.region.y)) & (distance - 1) == 0
    }

    /// Codes that omitted rays could add to a traced pixel.
    pub(super) fn lacking(&self, index: usize) -> u8 {
        let (shown, highest) = (self.shown[index], self.highest[index]);
        let off = match self.alpha.get(index) {
            Some(&alpha) if highest != shown || self.least_alpha[index] < alpha => {
                self.display.codes_of_part_off(shown, highest, [self.least_alpha[index], alpha])
            }
            None if highest != shown => self.display.codes_off(shown, highest),
            _ => return 0,
        };
        off.into_iter().fold(0, u8::max)
    }

    /// Whether that pixel next to one, or it itself, lacks light with few rays that is traced before all others there.
    pub(super) fn neighbour_lacks(&self, [x, y]: [u32; 2]) -> bool {
        let (column, row) = (x - self.region.x, y - self.region.y);
        self.lacks[((row & !1) * self.region.width + (column & !1)) as usize]
    }

    /// Takes up the pixels of a chunk, of which those at the end may not have been traced.
    pub(super) fn paint(&mut self, chunk: &Chunk<'_>, ladder: &Ladder, traced: &Traced) {
        self.rays = self.rays + traced.rays;
        let (level, refines) = (chunk.level, ladder.refines(chunk.level));
        if refines {
            self.refining = self.refining + traced.rays;
        }
        let alpha = traced.alpha.iter().copied().chain(std::iter::repeat(1.0));
        for ((&at, pixel), alpha) in chunk.pixels.iter().zip(&traced.pixels).zip(alpha) {
            let index = self.region.index(at);
            let samples = ladder.samples(self.levels[index]);
            if let Some(held_out) = self.held_out.get_mut(samples as usize).filter(|_| self.was_updated) {
                let mut change = differ(self.codes[index], self.display.codes(*pixel));
                if let Some(before) = self.codes_over_background.get(index) {
                    change = change.max(differ(*before, over_background(&self.display, *pixel, alpha)));
                }
                held_out.add(self.contrasts[index], change);
            }
            (self.shown[index], self.highest[index], self.levels[index]) = (*pixel, *pixel, level);
        }
        for (&at, alpha) in chunk.pixels.iter().zip(&traced.alpha) {
            let index = self.region.index(at);
            (self.alpha[index], self.least_alpha[index]) = (*alpha, *alpha);
        }
        for (&at, width) in chunk.pixels.iter().zip(&traced.widths) {
            self.widths[self.region.index(at)] = *width;
        }
        for bounded in traced.bounded.iter() {
            let index = self.region.index(bounded.at);
            self.highest[index] = bounded.highest;
            if let Some(least) = self.least_alpha.get_mut(index) {
                *least = bounded.least_alpha;
            }
        }
        for &at in chunk.pixels.iter().take(if level <= 2 { traced.pixels.len() } else { 0 }) {
            let index = self.region.index(at);
            self.lacks[index] |= level == 2 || self.lacking(index) > 1;
        }
    }

    /// Brings what is known of all pixels up to date: those that were not traced, and contrasts.
    pub(super) fn update(&mut self, ladder: &Ladder) {
        let (levels, width) = (&self.levels, self.region.width);
        interpolate(&mut self.shown, self.region, COARSEST, |index| levels[index] > 0);
        let update = |codes: &mut Vec<[u8; 3]>, new: Vec<[u8; 3]>| {
            let each = codes.par_iter_mut().zip(new).zip(levels);
            each.filter(|(_, level)| !ladder.refines(**level)).for_each(|((code, new), _)| *code = new);
        };
        update(&mut self.codes, codes_of(&self.display, &self.shown));
        self.contrasts = contrasts(&self.codes, width);
        if !self.alpha.is_empty() {
            let alpha = interpolated_alpha(&self.alpha, self.region, levels);
            update(&mut self.codes_over_background, codes_over_background(&self.display, &self.shown, &alpha));
            let over_background = contrasts(&self.codes_over_background, width);
            self.contrasts.iter_mut().zip(over_background).for_each(|(most, contrast)| *most = contrast.max(*most));
        }
        self.was_updated = true;
    }

    /// The pixels so far, interpolated where they were not traced. It changes nothing, so watchers do not change a picture.
    pub(super) fn so_far(&self) -> Vec<[f32; 3]> {
        let mut pixels = self.shown.clone();
        interpolate(&mut pixels, self.region, COARSEST, |index| self.levels[index] > 0);
        pixels
    }

    /// The alpha of the pixels so far, interpolated where they were not traced; empty where the background is opaque.
    pub(super) fn alpha(&self) -> Vec<f32> {
        if self.alpha.is_empty() { Vec::new() } else { interpolated_alpha(&self.alpha, self.region, &self.levels) }
    }

    /// The picture so far, once it is up to date. Pixels that were not traced have no upper bound. `tells` says whether intervals
    /// can be estimated.
    pub(super) fn filled(self, ladder: &Ladder, tells: bool) -> Traced {
        let widths = if tells { self.all_widths(ladder) } else { Vec::new() };
        let Self { region, shown, alpha, highest, least_alpha, levels, rays, .. } = self;
        let rows = shown.par_chunks(region.width as usize).zip(region.y..region.y + region.height);
        let of_row = |(row, y): (&[[f32; 3]], u32)| -> Vec<BoundedPixel> {
            let of_pixel = |(shown, x): (&[f32; 3], u32)| {
                let index = region.index([x, y]);
                let highest = if levels[index] == 0 { [f32::INFINITY; 3] } else { highest[index] };
                let least_alpha = least_alpha.get(index).copied().unwrap_or_default();
                let is_open = highest != *shown || alpha.get(index).is_some_and(|alpha| least_alpha < *alpha);
                is_open.then_some(BoundedPixel { at: [x, y], highest, least_alpha })
            };
            row.iter().zip(region.x..).filter_map(of_pixel).collect()
        };
        let parts: Vec<Vec<BoundedPixel>> = rows.map(of_row).collect();
        let mut filled = Traced { rays, widths, ..Traced::default() };
        parts.into_iter().for_each(|part| filled.bounded.add(part));
        filled.pixels = shown;
        filled
    }

    /// The interval of each pixel in codes: by its samples; with one or none by those that were held out, or by its neighbours.
    fn all_widths(&self, ladder: &Ladder) -> Vec<u8> {
        let likely: Vec<[Option<[u8; QUANTILES]>; 2]> = (0..=u8::MAX)
            .map(|contrast| [0, 1].map(|samples: usize| self.held_out[samples].changes(contrast)))
            .collect();
        // Nothing was held out in the first coarse pictures.
        let first = self.contrast_of_first();
        let is_covered = ladder.is_antialiased() && self.levels.iter().all(|level| *level > 0);
        let each = |(index, contrast): (usize, &u8)| {
            let samples = ladder.samples(self.levels[index]) as usize;
            if samples > 1 {
                return self.widths[index];
            }
            // Antialiasing refines no such pixel, so none was held out.
            if is_covered && *contrast < CONTRAST {
                return *contrast;
            }
            // Pixels near each other take quantiles far from each other.
            let quantile = (index as u32).wrapping_mul(0x9e37_79b9) >> (u32::BITS - QUANTILES.ilog2());
            match (likely[usize::from(*contrast)][samples], samples) {
                (Some(changes), _) => changes[quantile as usize].saturating_mul(2),
                (None, 0) => first.saturating_mul(2),
                (None, _) if *contrast < CONTRAST => *contrast,
                (None, _) => (f64::from(*contrast) * EDGE) as u8,
            }
        };
        self.contrasts.par_iter().enumerate().with_min_len(1 << 12).map(each).collect()
    }

    /// How much neighbours among the first pixels differ: the difference that one in 20 exceeds.
    fn contrast_of_first(&self) -> u8 {
        let Region { x, y, width, height } = self.region;
        let first = Region { x: 0, y: 0, width: width.div_ceil(COARSEST), height: height.div_ceil(COARSEST) };
        let of_first =
            |[column, row]: [u32; 2]| self.shown[self.region.index([x + column * COARSEST, y + row * COARSEST])];
        let mut contrasts =
            contrasts(&codes_of(&self.display, &first.iter().map(of_first).collect::<Vec<_>>()), first.width);
        contrasts.sort_unstable();
        // Nothing to compare a single one with.
        if first.pixels() == 1 { u8::MAX } else { contrasts[contrasts.len() * 19 / 20] }
    }
}

/// The alpha of pixels, interpolated where they were not traced.
fn interpolated_alpha(alpha: &[f32], region: Region, levels: &[u8]) -> Vec<f32> {
    let mut pixels: Vec<[f32; 3]> = alpha.iter().map(|alpha| [*alpha; 3]).collect();
    interpolate(&mut pixels, region, COARSEST, |index| levels[index] > 0);
    pixels.into_iter().map(|[alpha, ..]| alpha).collect()
}

/// The difference of two colors in codes, in the worst channel.
fn differ(a: [u8; 3], b: [u8; 3]) -> u8 {
    a.iter().zip(b).map(|(a, b)| a.abs_diff(b)).fold(0, u8::max)
}
