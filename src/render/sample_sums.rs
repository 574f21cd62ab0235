//! The samples of a few pixels: in which batches they are traced, and their sums.
//!
//! Samples are added in double precision, group by group in the order of their numbers. So a pixel depends neither on the batches that its samples
//! were traced in nor on the width of packets.

use crate::bound::interval::{interval, proved};
use crate::film::Display;
use crate::lanes::{Lanes, MAX_LANES, lanes_of};
use crate::scene::world::Pruning;
use crate::trace::batch::{BATCH, BatchLight, SampleBatch, trace_batch};
use crate::trace::counts::LaneCounts;
use crate::trace::hits::Hits;
use crate::trace::kernel::Tracer;
use crate::trace::observer::Observer;
use crate::trace::pixel::Samples;
use crate::trace::proof::ATTEMPTS;
use crate::trace::variants::Variant;
use std::ops::Range;

/// Pixels whose samples are traced together.
pub(crate) const PIXELS: usize = MAX_LANES;

/// The samples of pixels that are still to be traced, in order: those of several pixels in a batch, or a part of those of one.
struct SampleQueue<'a> {
    pixels: &'a [[u32; 2]],
    samples: Samples,
    /// The pixels that are asked for; all of them where a batch has several.
    open: u32,
    /// How many pixels a batch has.
    together: usize,
    /// The next sample of the first of them.
    next: u32,
    /// The pixels of the last batch.
    last: Range<usize>,
}

impl<'a> SampleQueue<'a> {
    fn new<L: Lanes>(pixels: &'a [[u32; 2]], samples: Samples, open: u32) -> Self {
        let count = samples.count as usize;
        // Those of a packet where a group has room in it, so that no packet waits for another.
        let room = if count <= L::COUNT { L::COUNT } else { BATCH };
        Self { pixels, samples, open, together: (room / count).max(1), next: samples.first, last: 0..0 }
    }

    /// Fills a batch with whole groups; false if there are none left.
    #[inline(always)]
    fn next_batch(&mut self, batch: &mut SampleBatch) -> bool {
        if self.open == 0 {
            return false;
        }
        let first = self.open.trailing_zeros() as usize;
        let end = (first + self.together).min(self.pixels.len());
        self.last = first..end;
        let count = (self.samples.end() - self.next).min(BATCH as u32);
        batch.fill(&self.pixels[first..end], self.next, count);
        self.next += count;
        if self.next == self.samples.end() {
            (self.open, self.next) = (self.open & !(((1u64 << end) - 1) as u32), self.samples.first);
        }
        true
    }

    /// The number of the first sample of the last batch, among those that are asked for.
    fn number(&self, len: usize) -> u32 {
        let end = if self.next == self.samples.first { self.samples.end() } else { self.next };
        end - self.samples.first - (len / self.last.len()) as u32
    }

    /// The pixel of each sample of the last batch.
    fn owners(&self, len: usize) -> impl Iterator<Item = usize> {
        let (first, count) = (self.last.start, len / self.last.len());
        (0..len).map(move |sample| first + sample / count)
    }
}

/// The sums of the samples of some pixels, each of which gets as many. Reused from some to the next ones.
#[derive(Debug)]
pub(crate) struct SampleSums {
    /// The samples of each.
    samples: Samples,
    /// Whether the background is transparent. Else what is said of it stays 0.
    is_transparent: bool,
    /// The last batch, and what it brought.
    batch: SampleBatch,
    brought: BatchLight,
    light: [[f64; PIXELS]; 3],
    /// That of the second half of the samples. If there are 2^k, both halves are spread as evenly as all.
    second: [[f64; PIXELS]; 3],
    /// How much of a transparent background they see: all, and those of the second half.
    clear: [[f64; PIXELS]; 2],
    /// The most light that they lack.
    omitted: [[f64; PIXELS]; 3],
    /// The most that they may have missed of the background.
    unseen: [f64; PIXELS],
    /// The largest relative rounding error of a sample that may lack light.
    rounding: [f64; PIXELS],
    /// The pixels that may lack light.
    incomplete: u32,
    /// Those of which a proof was given up.
    given_up: u32,
}

/// The sums of the samples of a pixel, to which others may be added.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PixelSums {
    pub(super) samples: u32,
    light: [f64; 3],
    second: [f64; 3],
    clear: [f64; 2],
    omitted: [f64; 3],
    unseen: f64,
    rounding: f64,
    given_up: bool,
}

/// The mean of the samples of a pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PixelMean {
    pub(crate) light: [f64; 3],
    /// The most light that it lacks.
    pub(crate) omitted: [f64; 3],
    /// The relative rounding error.
    pub(crate) rounding: f64,
    /// The means of both halves of the samples; one sample has no second half.
    pub(super) halves: [[f64; 3]; 2],
}

impl PixelMean {
    /// The interval in which the light of recursion without end lies.
    pub(crate) fn ends(&self) -> [[f32; 2]; 3] {
        interval(self.light, self.omitted, self.rounding)
    }
}

impl SampleSums {
    pub(crate) fn new(samples: Samples, is_transparent: bool) -> Self {
        let black = [[0.0; PIXELS]; 3];
        Self {
            samples,
            is_transparent,
            batch: SampleBatch::new(samples),
            brought: BatchLight::default(),
            light: black,
            second: black,
            clear: [[0.0; PIXELS]; 2],
            omitted: black,
            unseen: [0.0; PIXELS],
            rounding: [0.0; PIXELS],
            incomplete: 0,
            given_up: 0,
        }
    }

    /// Begins with other pixels.
    #[inline(always)]
    fn begin(&mut self) {
        let black = [[0.0; PIXELS]; 3];
        // Where each pixel has one sample, it is copied.
        if self.samples.count > 1 {
            (self.light, self.second) = (black, black);
        }
        if self.is_transparent {
            (self.clear, self.unseen) = ([[0.0; PIXELS]; 2], [0.0; PIXELS]);
        }
        if self.incomplete != 0 {
            (self.omitted, self.rounding) = (black, [0.0; PIXELS]);
        }
        (self.incomplete, self.given_up) = (0, 0);
    }

    /// Begins again with some pixels.
    fn clear(&mut self, pixels: u32) {
        for pixel in lanes_of(pixels) {
            let channels = self.light.iter_mut().chain(&mut self.second).chain(&mut self.omitted);
            channels.for_each(|channel| channel[pixel] = 0.0);
            self.clear.iter_mut().for_each(|clear| clear[pixel] = 0.0);
            (self.unseen[pixel], self.rounding[pixel]) = (0.0, 0.0);
        }
        (self.incomplete, self.given_up) = (self.incomplete & !pixels, self.given_up & !pixels);
    }

    /// Adds the samples of the batch, from number `number` on, to those of its pixels.
    #[inline(always)]
    fn add(&mut self, pixels: Range<usize>, number: u32) {
        let len = self.batch.len();
        let (first, count) = (pixels.start, len / pixels.len());
        let of_first = (self.samples.count.div_ceil(2).saturating_sub(number) as usize).min(count);
        for c in 0..3 {
            let light = &self.brought.light[c];
            let (sums, second) = (&mut self.light[c][first..], &mut self.second[c][first..]);
            match count {
                1 if self.samples.count == 1 => sums[..len].copy_from_slice(&light[..len]),
                4 => add_each::<4>(&light[..len], of_first, sums, second),
                8 => add_each::<8>(&light[..len], of_first, sums, second),
                16 => add_each::<16>(light, of_first, sums, second),
                _ => add_any(&light[..len], count, of_first, sums, second),
            }
        }
        if self.is_transparent {
            self.add_clear(first, count, of_first);
        }
        if self.brought.incomplete != 0 {
            self.add_bounds(first, count);
        }
    }

    #[inline(never)]
    fn add_clear(&mut self, first: usize, count: usize, of_first: usize) {
        let samples = self.brought.clear[..self.batch.len()].chunks_exact(count);
        for (pixel, samples) in (first..).zip(samples) {
            let [all, late] = [samples, &samples[of_first..]].map(|samples| samples.iter().sum::<f64>());
            self.clear[0][pixel] += all;
            self.clear[1][pixel] += late;
        }
    }

    #[inline(never)]
    fn add_bounds(&mut self, first: usize, count: usize) {
        let brought = &self.brought;
        for sample in 0..self.batch.len() {
            let pixel = first + sample / count;
            for c in 0..3 {
                self.omitted[c][pixel] += brought.omitted[c][sample];
            }
            if self.is_transparent {
                self.unseen[pixel] += brought.unseen[sample];
            }
            self.rounding[pixel] = self.rounding[pixel].max(brought.rounding[sample]);
            self.incomplete |= (brought.incomplete >> sample & 1) << pixel;
            self.given_up |= (brought.given_up >> sample & 1) << pixel;
        }
    }

    /// The pixels that may lack light.
    pub(super) fn incomplete(&self) -> u32 {
        self.incomplete
    }

    /// The light of each pixel, channel by channel, where each has one sample.
    pub(super) fn single(&self) -> Option<&[[f64; PIXELS]; 3]> {
        (self.samples.count == 1).then_some(&self.light)
    }

    /// The mean of a pixel's samples.
    #[inline(always)]
    pub(crate) fn mean(&self, pixel: usize) -> PixelMean {
        self.pixel(pixel).mean()
    }

    /// The sums of a pixel.
    #[inline(always)]
    pub(super) fn pixel(&self, pixel: usize) -> PixelSums {
        let of = |channels: &[[f64; PIXELS]; 3]| [channels[0][pixel], channels[1][pixel], channels[2][pixel]];
        PixelSums {
            samples: self.samples.count,
            light: of(&self.light),
            second: of(&self.second),
            clear: self.clear.map(|clear| clear[pixel]),
            omitted: of(&self.omitted),
            unseen: self.unseen[pixel],
            rounding: self.rounding[pixel],
            given_up: self.given_up >> pixel & 1 == 1,
        }
    }

    /// The pixels that may be more than `max_codes` off, though none of their proofs was given up.
    fn unproved(&self, among: u32, display: &Display, max_codes: u8) -> u32 {
        lanes_of(among)
            .filter(|pixel| self.pixel(*pixel).is_unproved(display, self.is_transparent, max_codes))
            .fold(0, |unproved, pixel| unproved | 1 << pixel)
    }
}

impl PixelSums {
    /// The share of the pixel that is not background: 1 less the light of a white one (Porter and Duff 1984, Smith and Blinn 1996:
    /// the difference of the picture before white and before black).
    pub(super) fn alpha(&self) -> f32 {
        (1.0 - self.clear[0] / f64::from(self.samples)).clamp(0.0, 1.0) as f32
    }

    /// The least that it can be.
    pub(super) fn least_alpha(&self) -> f32 {
        (1.0 - (self.clear[0] + self.unseen) / f64::from(self.samples)).clamp(0.0, 1.0) as f32
    }

    /// The interval of alpha in codes, by how far both halves of the samples are apart.
    pub(super) fn width_of_alpha(&self) -> u8 {
        let [all, half] = self.clear();
        // |a - b| of two halves is twice the distance of one from both.
        (2.0 * 255.0 * (all - half).abs()).round() as u8
    }

    /// How much of a transparent background all samples see, and those of the first half.
    pub(super) fn clear(&self) -> [f64; 2] {
        let [all, late] = self.clear;
        [all / f64::from(self.samples), (all - late) / f64::from(self.samples.div_ceil(2))]
    }

    /// Their mean.
    #[inline(always)]
    pub(super) fn mean(&self) -> PixelMean {
        let count = f64::from(self.samples);
        let first = f64::from(self.samples.div_ceil(2));
        let share = 1.0 / count;
        PixelMean {
            light: self.light.map(|light| light * share),
            omitted: self.omitted.map(|light| light * share),
            rounding: if self.rounding == 0.0 { 0.0 } else { self.rounding + count * f64::EPSILON },
            halves: [
                std::array::from_fn(|c| (self.light[c] - self.second[c]) / first),
                self.second.map(|light| light / (count - first)),
            ],
        }
    }

    /// Whether light was omitted, or what is seen of a transparent background.
    pub(super) fn is_incomplete(&self) -> bool {
        self.omitted != [0.0; 3] || self.unseen != 0.0
    }

    /// Whether it may be more than `max_codes` off, though its proof was not given up.
    pub(super) fn is_unproved(&self, display: &Display, is_transparent: bool, max_codes: u8) -> bool {
        let is_proved = || {
            let seen = [self.clear[0], self.unseen].map(|share| share / f64::from(self.samples));
            proved(display, self.mean().ends(), is_transparent.then_some(seen), max_codes) == [true; 3]
        };
        self.is_incomplete() && !self.given_up && !is_proved()
    }

    /// Adds as many samples as there are, or the first ones.
    pub(super) fn append(&mut self, run: &Self) {
        let is_first = self.samples == 0;
        self.second = if is_first { run.second } else { run.light };
        self.samples += run.samples;
        self.clear = [self.clear[0] + run.clear[0], if is_first { run.clear[1] } else { run.clear[0] }];
        self.unseen += run.unseen;
        for c in 0..3 {
            self.light[c] += run.light[c];
            self.omitted[c] += run.omitted[c];
        }
        self.rounding = self.rounding.max(run.rounding);
        self.given_up |= run.given_up;
    }
}

/// Adds up the samples of pixels with `count` each, of which `of_first` are of the first half.
#[inline(always)]
fn add_any(light: &[f64], count: usize, of_first: usize, sums: &mut [f64], second: &mut [f64]) {
    for (light, (sum, second)) in light.chunks_exact(count).zip(sums.iter_mut().zip(second)) {
        let (early, late) = light.split_at(of_first);
        let (early, late) = (early.iter().sum::<f64>(), late.iter().sum::<f64>());
        *sum += early + late;
        *second += late;
    }
}

/// [`add_any`] of a count that the compiler knows.
#[inline(always)]
fn add_each<const N: usize>(light: &[f64], of_first: usize, sums: &mut [f64], second: &mut [f64]) {
    for (light, (sum, second)) in light.as_chunks::<N>().0.iter().zip(sums.iter_mut().zip(second)) {
        let (mut early, mut late) = (0.0, 0.0);
        for (sample, light) in light.iter().enumerate() {
            let (is_early, is_late) = if sample < of_first { (*light, 0.0) } else { (0.0, *light) };
            early += is_early;
            late += is_late;
        }
        *sum += early + late;
        *second += late;
    }
}

/// Traces all samples of up to [`PIXELS`] pixels. `costs` gets the rays of each pixel, if the tracer counts them.
#[inline(always)]
pub(crate) fn trace_samples<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    pixels: &[[u32; 2]],
    hits: &mut Hits<L>,
    sums: &mut SampleSums,
    costs: &mut LaneCounts,
) {
    let samples = sums.samples;
    let all = ((1u64 << pixels.len()) - 1) as u32;
    sums.begin();
    let mut queue = SampleQueue::new::<L>(pixels, samples, all);
    let (mut open, mut attempt) = (all, 0);
    // One call of `trace_batch`: it holds all of the kernel.
    loop {
        if queue.next_batch(&mut sums.batch) {
            trace_batch(tracer, &sums.batch, attempt, hits, &mut sums.brought);
            let len = sums.batch.len();
            sums.add(queue.last.clone(), queue.number(len));
            if let Some(counts) = &mut tracer.lane_counts {
                costs.add_all(&std::mem::take(&mut **counts), queue.owners(len));
            }
            continue;
        }
        open = match tracer.pruning {
            // Groups that are whole pixels are proved as such, and runs as parts.
            Pruning::Proved { max_codes } if samples.needs_attempts() && attempt + 1 < ATTEMPTS => {
                sums.unproved(open, tracer.display(), max_codes)
            }
            _ => 0,
        };
        if open == 0 {
            break;
        }
        attempt += 1;
        queue = SampleQueue::new::<L>(pixels, samples, open);
        sums.clear(open);
        if O::WATCHING {
            tracer.observer().pixel();
        }
    }
    tracer.counts.given_up += u64::from(sums.given_up.count_ones());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_count_adds_up_as_any_does() {
        fn check<const N: usize>() {
            let light: Vec<f64> =
                (0..3 * N as u32).map(|i| crate::math::pow(1.7, f64::from(i * 7 % 13) - 6.0)).collect();
            for of_first in 0..=N {
                let [mut known, mut any] = [[[1.0, 2.0, 3.0], [0.5, 0.25, 0.125]]; 2];
                let [sums, second] = &mut known;
                add_each::<N>(&light, of_first, sums, second);
                let [sums, second] = &mut any;
                add_any(&light, N, of_first, sums, second);
                assert_eq!(known, any, "{of_first} of {N}");
            }
        }
        check::<4>();
        check::<8>();
        check::<16>();
    }
}
