//! Adaptive sampling by doubling: as many samples for each pixel as its error asks for.
//!
//! Pixels begin with few samples, and get twice as many while they are likely off by more than the target. The means of n and of
//! n/2 samples differ by about the error of n/2, and the error of n is about half of it. The samples of one pixel may agree by
//! chance, so its neighbours are asked, too, and what was seen before counts a little. Where many samples help little the target is
//! wider, so that no pixel takes those of a hundred others.

use super::packets::{KernelFormat, TraceJob, Traced, show_pixel};
use super::renderer::Renderer;
use super::sample_sums::PixelSums;
use super::statistical_sampling::Reached;
use super::tiles::near;
use crate::bound::BoundedPixel;
use crate::control::Cancelled;
use crate::film::Region;
use crate::math;
use crate::scene::Scene;
use crate::scene::world::Pruning;
use crate::trace::pixel::Samples;
use rayon::prelude::*;
use std::collections::HashSet;

/// Samples that pixels begin with. With 4, things that move are missed.
pub(crate) const FIRST: u32 = 8;
/// Most samples of a pixel.
const MOST: u32 = 256;
/// Looks at a pixel. Each asks its neighbours, so a pixel and what is said of it depend on those so far away.
const BORDER: u32 = (MOST / FIRST).ilog2() + 1;
/// The difference, in codes, from which on a pixel goes on after its first samples.
const TARGET: f64 = 0.9;
/// By which power of the number of samples it grows.
const GROWTH: f64 = 0.7;
/// Weight of a pixel's own difference beside those around it.
const OWN: f32 = 0.7;
/// Weight of what was seen at the last look, in squares, and what is left of it after a doubling.
const BEFORE: f32 = 0.3;
const LEFT: f32 = 0.6;
/// Weight of the contrast to neighbours after the first samples, which may all miss a small part of the light, or be all that is
/// missed: a pixel next to others of another color looks again.
const CONTRAST: f32 = 0.1;
/// Edge of the part of a picture that is worked on at a time. Its border is traced for its neighbours, too.
const EDGE: u32 = 256;
/// Bytes of what is known of a pixel: twice its sums, while a run is added, its place, its codes over black and white, and two numbers.
const PIXEL_BYTES: u64 = 2 * size_of::<PixelSums>() as u64 + 48;

/// Bytes of memory that adaptive sampling takes beside a picture of so many pixels.
pub fn sampling_bytes(scene: &Scene, pixels: u64) -> u64 {
    let (edge, border) = (u64::from(EDGE), u64::from(BORDER));
    let around = 4 * border * (edge + border);
    if scene.adaptive { PIXEL_BYTES * (pixels.min(edge * edge) + around) } else { 0 }
}

/// Samples that a region's parts take at first for their borders, as a share of all that `camera` rays of `pixels` are.
pub(crate) fn border_share(scene: &Scene, region: Region, pixels: u64, camera: u64) -> f64 {
    let with_border = |part| (0..BORDER).fold(part, |part: Region, _| part.with_border(scene.width, scene.height));
    let traced: u64 = region.tiles(EDGE).map(|part| with_border(part).pixels()).sum();
    let more = traced as f64 / region.pixels() as f64 - 1.0;
    more * (u64::from(FIRST) * pixels) as f64 / camera.max(1) as f64
}

/// Pixels and what is known of them.
struct Patch<'a, R> {
    renderer: &'a Renderer<'a, R>,
    job: TraceJob<'a, R>,
    /// The pixels that are asked for.
    wanted: Region,
    /// Those and the ones they depend on.
    around: Region,
    /// Row by row.
    sums: Vec<PixelSums>,
    /// The mean of each, in codes: over black, and over what is behind a transparent background.
    codes: Vec<[[f32; 3]; 2]>,
    /// The difference between the last two means of each, in codes of the worst channel.
    differences: Vec<f32>,
    /// That of each with its surroundings.
    likely: Vec<f32>,
    /// What it took.
    traced: Traced,
}

/// The runs of samples of a pixel that gets a number of them.
pub(super) fn runs(samples: u32) -> impl Iterator<Item = Samples> {
    let doublings = std::iter::successors(Some(FIRST), |n| Some(2 * n)).take_while(move |n| *n < samples);
    std::iter::once(Samples::run(0, FIRST)).chain(doublings.map(|n| Samples::run(n, n)))
}

/// The difference from which on a pixel goes on after so many samples.
fn target(samples: u32) -> f32 {
    (TARGET * math::pow(f64::from(samples / FIRST), GROWTH)) as f32
}

impl<R: KernelFormat> Renderer<'_, R> {
    /// A region with as many samples as each pixel asks for, row by row.
    pub(super) fn doubled(&self, region: Region) -> Result<Traced, Cancelled> {
        let count = region.pixels() as usize;
        let alpha = vec![0.0; if self.job.world.transparent { count } else { 0 }];
        let mut all = Traced { pixels: vec![[0.0; 3]; count], alpha, ..Traced::default() };
        for wanted in region.tiles(EDGE) {
            all.put(wanted.iter().map(|at| region.index(at)), self.patch(wanted)?.shown()?);
        }
        Ok(all)
    }

    /// Pixels anywhere, each as in the whole picture.
    pub(super) fn doubled_list(&self, at: &[[u32; 2]]) -> Result<Traced, Cancelled> {
        let pixel = |[x, y]: &[u32; 2]| self.patch(Region { x: *x, y: *y, width: 1, height: 1 })?.shown();
        Ok(Traced::joined(at.par_iter().map(pixel).collect::<Result<_, _>>()?))
    }

    /// How many samples a pixel gets.
    pub(super) fn doubled_samples_of(&self, [x, y]: [u32; 2]) -> Result<u32, Cancelled> {
        let patch = self.patch(Region { x, y, width: 1, height: 1 })?;
        Ok(patch.sums[patch.around.index([x, y])].samples)
    }

    /// A block of pixels as if it were a picture of its own: about what it takes in the whole.
    pub(super) fn doubled_block(&self, wanted: Region) -> Result<Traced, Cancelled> {
        self.patch_within(wanted, wanted)?.shown()
    }

    fn patch(&self, wanted: Region) -> Result<Patch<'_, R>, Cancelled> {
        self.patch_within(wanted, self.with_border(wanted, BORDER))
    }

    /// A region with some pixels around it, as far as the picture has them.
    fn with_border(&self, region: Region, border: u32) -> Region {
        let [width, height] = self.size;
        (0..border).fold(region, |part, _| part.with_border(width, height))
    }

    fn patch_within(&self, wanted: Region, around: Region) -> Result<Patch<'_, R>, Cancelled> {
        let count = around.pixels() as usize;
        let mut patch = Patch {
            renderer: self,
            job: TraceJob { sums: true, ..self.job.clone() },
            wanted,
            around,
            sums: vec![PixelSums::default(); count],
            codes: vec![[[0.0; 3]; 2]; count],
            differences: vec![0.0; count],
            likely: vec![0.0; count],
            traced: Traced::default(),
        };
        patch.fill()?;
        Ok(patch)
    }
}

/// A pixel and its neighbours, as far as they are known.
fn beside([x, y]: [u32; 2], around: Region) -> Region {
    let [left, top] = [x.saturating_sub(1).max(around.x), y.saturating_sub(1).max(around.y)];
    let [right, bottom] = [(x + 2).min(around.x + around.width), (y + 2).min(around.y + around.height)];
    Region { x: left, y: top, width: right - left, height: bottom - top }
}

/// The difference of two colors in codes, in the worst channel.
fn apart(a: [[f32; 3]; 2], b: [[f32; 3]; 2]) -> f32 {
    a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

impl<R: KernelFormat> Patch<'_, R> {
    /// Traces the pixels until none asks for more.
    fn fill(&mut self) -> Result<(), Cancelled> {
        let mut open = near(self.around, |_| true);
        for (samples, look) in runs(MOST).zip(1..) {
            self.run(&open, samples)?;
            self.compare(&open);
            // Pixels further away count for no decision from now on.
            let valid = self.renderer.with_border(self.wanted, BORDER.saturating_sub(look));
            open.retain(|at| valid.contains(*at));
            self.look_around(&open);
            let (around, likely, target) = (self.around, &self.likely, target(samples.end()));
            open.retain(|at| likely[around.index(*at)] > target);
            if open.is_empty() {
                break;
            }
        }
        Ok(())
    }

    /// Adds a run of samples to some pixels.
    fn run(&mut self, at: &[[u32; 2]], samples: Samples) -> Result<(), Cancelled> {
        self.renderer.control.add_total(at.len() as u64);
        let traced = self.renderer.list_of(&self.job, at, samples)?;
        for (at, sums) in at.iter().zip(&traced.sums) {
            self.sums[self.around.index(*at)].append(sums);
        }
        self.traced.rays = self.traced.rays + traced.rays;
        let wanted = self.wanted;
        self.traced.costs.extend(traced.costs.into_iter().filter(|cost| wanted.contains(cost.at)));
        Ok(())
    }

    /// Compares the last two means of pixels.
    fn compare(&mut self, at: &[[u32; 2]]) {
        let (around, sums, world) = (self.around, &self.sums, self.job.world);
        let codes = |(light, clear): ([f64; 3], f64)| {
            let (light, clear) = (light.map(|c| c as f32), clear as f32);
            let over_black = world.display.fine_codes(light, [0.0; 3]);
            let with_behind = match world.display.backdrop() {
                _ if !world.transparent => over_black,
                Some(behind) => world.display.fine_codes(light, behind.map(|channel| channel * clear)),
                // Alpha is a channel as the others are: pages blend its codes.
                None => [255.0 * clear; 3],
            };
            [over_black, with_behind]
        };
        let difference = |at: &[u32; 2]| {
            let sums = &sums[around.index(*at)];
            let (mean, [clear, clear_of_half]) = (sums.mean(), sums.clear());
            let [all, half] = [(mean.light, clear), (mean.halves[0], clear_of_half)].map(codes);
            (all, apart(all, half))
        };
        let differences: Vec<([[f32; 3]; 2], f32)> = at.par_iter().with_min_len(1 << 10).map(difference).collect();
        for (at, (codes, difference)) in at.iter().zip(differences) {
            let index = around.index(*at);
            (self.codes[index], self.differences[index]) = (codes, difference);
        }
    }

    /// How far pixels are likely off, from their differences and those around them, and from the last look.
    fn look_around(&mut self, at: &[[u32; 2]]) {
        let (around, differences, codes, before) = (self.around, &self.differences, &self.codes, &self.likely);
        let likely = |at: &[u32; 2]| {
            let (near, index) = (beside(*at, around), around.index(*at));
            let squares: f32 = near.iter().map(|at| differences[around.index(at)].powi(2)).sum();
            let now = (squares / near.pixels() as f32).sqrt().max(OWN * differences[index]);
            if self.sums[index].samples == FIRST {
                let contrast = near.iter().map(|at| apart(codes[around.index(at)], codes[index])).fold(0.0, f32::max);
                return now.max(CONTRAST * contrast);
            }
            ((1.0 - BEFORE) * now * now + BEFORE * (LEFT * before[index]).powi(2)).sqrt()
        };
        let likely: Vec<f32> = at.par_iter().with_min_len(1 << 10).map(likely).collect();
        at.iter().zip(likely).for_each(|(at, new)| self.likely[around.index(*at)] = new);
    }

    /// What is shown of the wanted pixels, row by row.
    fn shown(mut self) -> Result<Traced, Cancelled> {
        let mut out = std::mem::take(&mut self.traced);
        let mut bounded = Vec::new();
        for at in self.wanted.iter() {
            let sums = &self.sums[self.around.index(at)];
            show_pixel(&self.job, at, sums, &mut out, &mut bounded);
            let likely = self.likely[self.around.index(at)];
            out.widths.push((2.0 * likely).ceil() as u8);
            let most = sums.samples;
            let sure = u64::from(likely <= target(most));
            out.reached = out.reached + Reached { pixels: 1, sure, samples: u64::from(most), most_samples: most };
        }
        self.prove(&mut out, &mut bounded)?;
        out.bounded.add(bounded);
        Ok(out)
    }

    /// Traces those pixels again whose runs are proved, each for itself, but not their mean.
    fn prove(&self, out: &mut Traced, bounded: &mut Vec<BoundedPixel>) -> Result<(), Cancelled> {
        let Pruning::Proved { max_codes } = self.job.pruning else { return Ok(()) };
        let world = &self.job.world;
        let open: Vec<(u32, [u32; 2])> = bounded
            .iter()
            .map(|bounded| (self.sums[self.around.index(bounded.at)], bounded.at))
            .filter(|(sums, _)| sums.is_unproved(&world.display, world.transparent, max_codes))
            .map(|(sums, at)| (sums.samples, at))
            .collect();
        let mut counts: Vec<u32> = open.iter().map(|(samples, _)| *samples).collect();
        counts.sort_unstable();
        counts.dedup();
        for count in counts {
            let at: Vec<[u32; 2]> = open.iter().filter(|(samples, _)| *samples == count).map(|(_, at)| *at).collect();
            self.renderer.control.add_total(at.len() as u64);
            let again = self.renderer.list(&at, count)?;
            let traced_again: HashSet<[u32; 2]> = at.iter().copied().collect();
            bounded.retain(|bounded| !traced_again.contains(&bounded.at));
            bounded.extend(again.bounded.iter().copied());
            at.iter().zip(again.pixels).for_each(|(at, pixel)| out.pixels[self.wanted.index(*at)] = pixel);
            at.iter().zip(again.alpha).for_each(|(at, alpha)| out.alpha[self.wanted.index(*at)] = alpha);
            out.rays = out.rays + again.rays;
            out.costs.extend(again.costs);
        }
        Ok(())
    }
}
