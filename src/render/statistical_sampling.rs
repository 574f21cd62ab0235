//! Adaptive sampling, for the statistical mode: each pixel gets samples until its confidence interval is narrow enough.
//!
//! Samples come in batches. Each batch is evenly spread and has a shift of its own, so the means of batches are independent,
//! and their variance gives the error of the mean of all. After ever more batches, the interval of Student's t is computed.
//! Since k tests have k chances to be wrong, test k may use only 1/(k(k + 1)) of the allowed doubt. No pixel depends on
//! another, so any crop is that of the whole picture.

use super::packets::{KernelFormat, TraceJob, Traced, show};
use super::picture::PixelCost;
use crate::bound::BoundedPixel;
use crate::trace::pixel::Samples;

use super::student_t::student_t;
use crate::film::Display;
use crate::math::linear_to_srgb;
use crate::scene::description::Statistical;
use fearless_simd::Level;
use serde::{Deserialize, Serialize};
use std::ops::Add;

/// Samples of a batch.
const BATCH: u32 = 4;
/// Batches before the first test.
const FIRST: u32 = 8;
/// Most batches of a pixel.
const MOST: u32 = 1_024;

/// The batches of a pixel that has a number of samples.
pub(super) fn batches(samples: u32) -> impl Iterator<Item = Samples> {
    (1..=samples / BATCH).map(|batch| Samples::of_set(batch, BATCH))
}

/// How far pixels came.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Reached {
    /// Pixels that were asked for.
    pub pixels: u64,
    /// Those that reached their target.
    pub sure: u64,
    /// Samples of all.
    pub samples: u64,
    /// Most samples of one.
    pub most_samples: u32,
}

impl Add for Reached {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self {
            pixels: self.pixels + o.pixels,
            sure: self.sure + o.sure,
            samples: self.samples + o.samples,
            most_samples: self.most_samples.max(o.most_samples),
        }
    }
}

/// The statistics of a pixel's batches.
#[derive(Debug, Clone, Copy, Default)]
struct Pixel {
    batches: u32,
    /// Mean of the lower ends.
    mean: [f64; 3],
    /// Sum of the squared distances of batches from it (Welford 1962).
    squares: [f64; 3],
    /// Mean of the upper ends.
    highest: [f64; 3],
    /// Mean of their alpha, and the sum of its squared distances.
    alpha: f64,
    squares_of_alpha: f64,
    /// Mean of the least that it can be.
    least_alpha: f64,
    /// Width of the interval in codes, at the last test.
    width: f64,
}

impl Pixel {
    fn add(&mut self, low: [f32; 3], high: [f32; 3], [alpha, least_alpha]: [f32; 2]) {
        self.batches += 1;
        let n = f64::from(self.batches);
        let away = f64::from(alpha) - self.alpha;
        self.alpha += away / n;
        self.squares_of_alpha += away * (f64::from(alpha) - self.alpha);
        self.least_alpha += (f64::from(least_alpha) - self.least_alpha) / n;
        for c in 0..3 {
            let away = f64::from(low[c]) - self.mean[c];
            self.mean[c] += away / n;
            self.squares[c] += away * (f64::from(low[c]) - self.mean[c]);
            self.highest[c] += (f64::from(high[c]) - self.highest[c]) / n;
        }
    }

    /// Whether the interval mean -+ t s/sqrt(n) is at most `codes` wide in each channel, alpha included.
    fn is_sure(&mut self, display: &Display, t: f64, codes: f64) -> bool {
        let n = f64::from(self.batches);
        let code = |linear: f64| 255.0 * linear_to_srgb(linear.clamp(0.0, 1.0));
        let off = |squares: f64| t * (squares / ((n - 1.0) * n)).sqrt();
        let of_alpha = 2.0 * 255.0 * off(self.squares_of_alpha);
        let off = self.squares.map(off);
        let [low, high] = [-1.0, 1.0].map(|sign| std::array::from_fn(|c| self.mean[c] + sign * off[c]));
        let widths: [f64; 3] = if display.is_plain() {
            std::array::from_fn(|c| code(high[c]) - code(low[c]))
        } else {
            let ends = display.ends(low.map(|c| c as f32), high.map(|c| c as f32));
            ends.map(|[low, high]| code(f64::from(high)) - code(f64::from(low)))
        };
        self.width = widths.into_iter().fold(of_alpha, f64::max);
        self.width <= codes
    }
}

/// Traces the pixels at `at` until each meets the target. Once cancelled it returns early, and the results are useless.
pub(super) fn trace<R: KernelFormat>(
    level: Level,
    job: &TraceJob<'_, R>,
    target: &Statistical,
    at: &[[u32; 2]],
    out: &mut Traced,
) {
    let job = TraceJob { low: true, ..job.clone() };
    let mut pixels = vec![Pixel::default(); at.len()];
    let mut open: Vec<usize> = (0..at.len()).collect();
    let none = |at: &[u32; 2]| PixelCost { at: *at, samples: 0, rays: 0, nanoseconds: 0, deepest: 0 };
    let mut costs: Vec<PixelCost> = at.iter().filter(|_| job.measured).map(none).collect();
    let (mut batch, mut until) = (0, FIRST);
    for look in 1.. {
        let asked: Vec<[u32; 2]> = open.iter().map(|index| at[*index]).collect();
        while batch < until {
            batch += 1;
            let mut part = Traced::default();
            R::trace(level, &job, &asked, Samples::of_set(batch, BATCH), &mut part);
            if job.control.stops() {
                return;
            }
            out.rays = out.rays + part.rays;
            for (index, cost) in open.iter().zip(&part.costs) {
                costs[*index] = costs[*index].and(cost);
            }
            let mut bounded = part.bounded.iter().peekable();
            let alpha = part.alpha.into_iter().chain(std::iter::repeat(1.0));
            for ((index, low), alpha) in open.iter().zip(part.pixels).zip(alpha) {
                let found = bounded.next_if(|bounded| bounded.at == at[*index]);
                let (high, least) = found.map_or((low, alpha), |bounded| (bounded.highest, bounded.least_alpha));
                pixels[*index].add(low, high, [alpha, least]);
            }
        }
        let doubt = (1.0 - target.confidence) / f64::from(look * (look + 1));
        let t = student_t(batch - 1, doubt);
        let asked = open.len();
        open.retain(|index| !pixels[*index].is_sure(&job.world.display, t, 2.0 * target.half_width));
        let sure = asked - open.len();
        out.reached = out.reached + Reached { pixels: sure as u64, sure: sure as u64, ..Reached::default() };
        if open.is_empty() || batch == MOST {
            break;
        }
        until = (batch * 3 / 2).min(MOST);
    }
    out.costs.append(&mut costs);
    out.reached.pixels += open.len() as u64;
    let mut bounded = Vec::new();
    for (&at, pixel) in at.iter().zip(&pixels) {
        let samples = pixel.batches * BATCH;
        out.reached =
            out.reached + Reached { samples: u64::from(samples), most_samples: samples, ..Reached::default() };
        let mean = pixel.mean.map(|c| c as f32);
        let highest = pixel.highest.map(|c| c as f32);
        out.widths.push(pixel.width.ceil() as u8);
        if job.world.transparent {
            out.alpha.push(pixel.alpha as f32);
        }
        let least_alpha = pixel.least_alpha as f32;
        if mean == highest {
            out.pixels.push(mean);
            if least_alpha < pixel.alpha as f32 {
                bounded.push(BoundedPixel { at, highest, least_alpha });
            }
            continue;
        }
        let ends = std::array::from_fn(|c| [mean[c].next_down().max(0.0), highest[c].next_up()]);
        let (shown, highest) = show(&job.world.display, mean.map(f64::from), ends, job.pruning);
        out.pixels.push(shown);
        bounded.push(BoundedPixel { at, highest, least_alpha });
    }
    out.bounded.add(bounded);
}
