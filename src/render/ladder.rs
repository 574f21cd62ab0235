//! The ladder of a progressive picture: what is traced next, by how much it is expected to improve the picture for each ray.
//!
//! It first covers the whole picture: one pixel in 1,024, then one in 64, 16 and 4. From then on each rung takes the best of
//! all that is left: pixels that were not traced, pixels that lack light rays, and pixels that need more samples. What counts
//! is the contrast of a pixel to its neighbours, where those not traced are interpolated.

use super::contrast::CONTRAST;
use super::partial_picture::PartialPicture;
use super::tiles::near_with;
use crate::scene::Scene;
use crate::scene::effects::REFINED_SAMPLES;
use crate::scene::world::Pruning;
use rayon::prelude::*;

/// Distance of the pixels of the first rung, across and down.
pub(super) const COARSEST: u32 = 32;
/// Share of the pixels that are always traced, in the first rung.
pub(crate) const COARSEST_SHARE: f64 = 1.0 / (COARSEST * COARSEST) as f64;
/// The first rungs: the distance of their pixels, across and down, and the share of them that is taken, the best first.
const COVERING: [(u32, f64); 5] = [(COARSEST, 1.0), (8, 1.0), (4, 1.0), (2, 0.5), (2, 1.0)];
/// The share of all that is left that each later rung takes. With smaller ones the order is better, and more time goes into it.
const SHARE: f64 = 0.15;
/// Rungs after which each takes all that is left.
const RUNGS: usize = COVERING.len() + 16;
/// The least number of pixels in a rung, since all threads wait for its end.
const FEWEST: usize = 1_024;
/// Pixels in a chunk of one sample each.
pub(crate) const CHUNK: usize = 512;
/// Weight below which rays are omitted from the first sample of a pixel. In a hall of mirrors and in glass this takes half of
/// the rays.
const LIGHT: f64 = 0.05;
/// Samples of one step over those of the step before.
const MORE: u32 = 4;
/// Expected square of the error of a pixel of one sample, as a share of the square of its contrast. Measured, as the others, by
/// trying orders on 15 scenes.
const ALIASED: f32 = 0.2;
/// How many times as much a pixel that was not traced may be off: it is as smooth as what it is interpolated from.
const HIDDEN: f32 = 4.0;
/// The least expected square of an error: what is not seen from the neighbours.
const UNSEEN: f32 = 0.3;
/// Expected square of the error of a pixel that lacks light rays, as a share of the square of what they could bring.
const LACKING: f32 = 0.3;

/// How a pixel is traced.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    pub(super) samples: u32,
    pub(super) pruning: Pruning,
}

/// Pixels that are traced before the next ones are chosen, level by level.
#[derive(Debug)]
pub(super) struct Rung {
    pixels: Vec<[u32; 2]>,
    /// The levels that they reach, and the end of the pixels of each.
    ends: Vec<(u8, usize)>,
}

/// Pixels that are traced with one step.
#[derive(Debug)]
pub(super) struct Chunk<'a> {
    pub(super) pixels: &'a [[u32; 2]],
    /// The level that they reach.
    pub(super) level: u8,
}

/// The steps of a scene's pixels. Level 0 is that of pixels that were not traced, level i has been reached with step i - 1.
#[derive(Debug)]
pub(super) struct Ladder {
    steps: Vec<Step>,
    /// Samples of each pixel at least.
    base: u32,
}

impl Ladder {
    pub(super) fn new(scene: &Scene) -> Self {
        let proved = Pruning::Proved { max_codes: 1 };
        let last = if scene.refines() { REFINED_SAMPLES } else { scene.samples };
        let mut steps = vec![Step { samples: 1, pruning: Pruning::Weight(LIGHT) }];
        let mut samples = 1;
        while samples < last {
            steps.push(Step { samples, pruning: proved });
            let next = samples * MORE;
            samples = if samples < scene.samples { next.min(scene.samples) } else { next.min(last) };
        }
        steps.push(Step { samples: last, pruning: proved });
        Self { steps, base: scene.samples }
    }

    /// Whether a rung is one of the first, which cover the picture.
    pub(super) fn covers(number: usize) -> bool {
        number < COVERING.len()
    }

    /// Whether a rung takes the best of what is left, for which the picture has to be up to date.
    pub(super) fn chooses(number: usize) -> bool {
        COVERING.get(number).is_none_or(|(_, share)| *share < 1.0)
    }

    /// The distance of the pixels that are certainly traced after a rung, across and down.
    pub(super) fn distance(number: usize) -> u32 {
        let first = &COVERING[..COVERING.len().min(number + 1)];
        first.iter().rfind(|(_, share)| *share == 1.0).map_or(1, |(distance, _)| *distance)
    }

    pub(super) fn step(&self, level: u8) -> Step {
        self.steps[usize::from(level) - 1]
    }

    /// Samples of a pixel of a level.
    pub(super) fn samples(&self, level: u8) -> u32 {
        if level == 0 { 0 } else { self.step(level).samples }
    }

    /// Whether a level is one of antialiasing.
    pub(super) fn refines(&self, level: u8) -> bool {
        self.samples(level) > self.base
    }

    /// Whether pixels of enough contrast are refined, and no others.
    pub(super) fn is_antialiased(&self) -> bool {
        self.base == 1 && self.refines(self.steps.len() as u8)
    }

    /// The level that does most for a pixel for each ray, and by how much; none if it needs no more. `contrast` is that to its
    /// neighbours, `lacking` is what omitted rays could bring, both in codes. `first` is the level that it begins with.
    fn next(&self, level: u8, contrast: u8, lacking: impl FnOnce() -> u8, first: u8) -> Option<(u8, f32)> {
        let aliased = ALIASED * f32::from(contrast) * f32::from(contrast) + UNSEEN;
        if level == 0 {
            return Some((first, HIDDEN * aliased / f32::from(first)));
        }
        // With samples that are evenly spread, the variance falls like n^(-3/2) on edges.
        let left = |level: u8| {
            let samples = self.samples(level) as f32;
            aliased / (samples * samples.sqrt())
        };
        let more = Some(level.max(2) + 1).filter(|more| usize::from(*more) <= self.steps.len());
        let more = more.filter(|more| !self.refines(*more) || contrast >= CONTRAST);
        let more = more.map(|more| (more, (left(level) - left(more)) / self.samples(more) as f32));
        let lacking = if level == 1 && self.base == 1 { lacking() } else { 0 };
        let lighter = (lacking > 1).then(|| (2, LACKING * f32::from(lacking) * f32::from(lacking)));
        match (more, lighter) {
            (Some(more), Some(lighter)) => Some(if more.1 > lighter.1 { more } else { lighter }),
            (more, lighter) => more.or(lighter),
        }
    }

    /// What is left to do for a pixel.
    fn next_of(&self, partial: &PartialPicture, at: [u32; 2]) -> Option<(u8, f32)> {
        let index = partial.region.index(at);
        // Where a neighbour lacks light, this one would too, and be darker than what is interpolated.
        let first = if self.base == 1 && partial.neighbour_lacks(at) { 2 } else { 1 };
        self.next(partial.levels[index], partial.contrasts[index], || partial.lacking(index), first)
    }

    /// The pixels of a rung.
    pub(super) fn rung(&self, number: usize, partial: &PartialPicture) -> Rung {
        let region = partial.region;
        let (stride, share) = match COVERING.get(number) {
            Some(rung) => *rung,
            None => (1, if number < RUNGS { SHARE } else { 1.0 }),
        };
        let wanted = |at: [u32; 2]| {
            let is_first = || partial.is_on_grid(at, stride) && partial.levels[region.index(at)] == 0;
            if !Self::covers(number) || is_first() { self.next_of(partial, at) } else { None }
        };
        let mut gains: Vec<f32> = if share < 1.0 {
            let rows = (region.y..region.y + region.height).into_par_iter();
            let of_row =
                |y| (region.x..region.x + region.width).filter_map(move |x| wanted([x, y]).map(|(_, gain)| gain));
            rows.flat_map_iter(of_row).collect()
        } else {
            Vec::new()
        };
        let taken = ((gains.len() as f64 * share) as usize).max(FEWEST);
        let least =
            if taken < gains.len() { *gains.select_nth_unstable_by(taken, |a, b| b.total_cmp(a)).1 } else { 0.0 };
        let best = |at: [u32; 2]| wanted(at).filter(|(_, gain)| *gain >= least).map(|(level, _)| (at, level));
        let near = near_with(region, best);
        let mut rung = Rung { pixels: Vec::with_capacity(near.len()), ends: Vec::new() };
        for level in 1..=self.steps.len() as u8 {
            rung.pixels.extend(near.iter().filter(|(_, reached)| *reached == level).map(|(at, _)| *at));
            rung.ends.push((level, rung.pixels.len()));
        }
        rung
    }

    /// The chunks of a rung.
    pub(super) fn chunks<'a>(&self, rung: &'a Rung) -> Vec<Chunk<'a>> {
        let mut chunks = Vec::new();
        let mut first = 0;
        for &(level, end) in &rung.ends {
            let size = (CHUNK / self.samples(level) as usize).max(16);
            chunks.extend(rung.pixels[first..end].chunks(size).map(|pixels| Chunk { pixels, level }));
            first = end;
        }
        chunks
    }

    /// Pixels that need more, and the samples that they need. The picture has to be up to date.
    pub(super) fn left(&self, partial: &PartialPicture) -> (u64, u64) {
        let of_pixel = |index: usize| {
            let (level, region) = (partial.levels[index], partial.region);
            let (column, row) = (index as u32 % region.width, index as u32 / region.width);
            let next = self.next_of(partial, [region.x + column, region.y + row]);
            let Some((next, _)) = next else { return (0, 0) };
            let refined = partial.contrasts[index] >= CONTRAST;
            let steps = (next..=self.steps.len() as u8).filter(|step| *step == next || *step > 2);
            let steps = steps.filter(|step| *step == next || !self.refines(*step) || refined);
            let needed: u64 = steps.map(|step| u64::from(self.samples(step))).sum();
            (1, if level == 0 && self.base == 1 { needed + 1 } else { needed })
        };
        let sum = |a: (u64, u64), b: (u64, u64)| (a.0 + b.0, a.1 + b.1);
        (0..partial.levels.len()).into_par_iter().with_min_len(1 << 12).map(of_pixel).reduce(|| (0, 0), sum)
    }
}
