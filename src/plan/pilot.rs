//! The pilot: traces few pixels of a picture to estimate its rays and time.
//!
//! The picture is cut into cells, and one block of pixels is traced at a random place in each. Blocks of one packet are as
//! coherent as the picture's own packets, and most neighbours of their pixels are known, so they also tell which share of the
//! pixels antialiasing refines. Any part of the order of cells is spread over the picture, so that a pilot that runs out of time
//! has only wider intervals.

use super::block::Block;
use super::ray_times::{KINDS, RayTimes, by_kind};
use super::survey::Survey;
use crate::control::{Cancelled, Control};
use crate::film::Region;
use crate::math;
use crate::scene::Scene;
use std::time::Duration;

/// Relative variation of the time of the same work, as measured on shared machines.
const CLOCK: f64 = 0.15;

/// Limits of a pilot.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Wall time.
    pub time: Duration,
    /// Share of the rays that the picture is expected to have.
    pub share: f64,
}

impl Effort {
    /// For an answer at once.
    pub const QUICK: Self = Self { time: Duration::from_millis(3), share: f64::INFINITY };
    /// Before a render: little compared with the picture.
    pub const BESIDE: Self = Self { time: Duration::from_secs(1), share: 0.01 };
}

/// An estimate with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Expected {
    /// The estimate.
    pub value: f64,
    /// Lower and upper end of the interval.
    pub interval: [f64; 2],
}

impl Expected {
    /// The same, where something else may be off by so much.
    fn widened(self, by: f64) -> Self {
        let reach = |end: usize| math::hypot(self.interval[end] - self.value, by);
        Self { interval: [(self.value - reach(0)).max(0.0), self.value + reach(1)], ..self }
    }
}

/// Estimates of a pilot for the whole region.
#[derive(Debug, Clone)]
pub struct Pilot {
    /// Pixels traced.
    pub traced: u64,
    /// Pixels of the region.
    pub pixels: u64,
    /// Rays by kind, in the order of [`KINDS`].
    pub kinds: [Expected; KINDS.len()],
    /// Total internal reflections.
    pub total_reflections: Expected,
    /// Rays of all kinds that antialiasing adds.
    pub added: Expected,
    /// Pixels it refines.
    pub refined: Expected,
    /// Pixels whose proof is given up.
    pub given_up: Expected,
    /// All rays.
    pub rays: Expected,
    /// Time of each kind of ray, including refined pixels.
    pub times: RayTimes,
    /// Nanoseconds of a ray that antialiasing adds. Its packets collect edges from anywhere and are less coherent than blocks.
    pub added_nanoseconds: f64,
    /// Whether even its first pixels took too long: the picture takes at least what is expected here.
    pub is_cut_off: bool,
    /// Relative half width of the 95 % interval of the time.
    pub time_off: f64,
}

impl Pilot {
    /// Traces a pilot of a region, which must fit the picture, on the current rayon pool.
    pub fn run(scene: &Scene, region: Region, control: &Control, effort: Effort) -> Result<Self, Cancelled> {
        Ok(Self::of(&Survey::make(scene, region, control, effort)?, region))
    }

    fn of(survey: &Survey, region: Region) -> Self {
        let blocks = &survey.blocks;
        let (pixels, traced) = (region.pixels(), blocks.iter().map(|block| block.pixels).sum::<u64>());
        let left = (1.0 - traced as f64 / pixels as f64).max(0.0);
        let expect = |value: &dyn Fn(&Block) -> f64| expected(blocks, value, pixels as f64, left);
        let all = |block: &Block| block.base.total() as f64;
        let with_added = |block: &Block, base: f64| base + survey.added(block, base);
        let fitted = RayTimes::fit(&blocks.iter().map(|block| (block.base, block.nanoseconds)).collect::<Vec<_>>());
        let (slowdown, slowdown_off) = typical(&survey.slowdowns);
        let added_time = |block: &Block| survey.added(block, block.nanoseconds) * slowdown;
        let time = expect(&|b| b.nanoseconds + added_time(b));
        let (added, added_time) = (expect(&|b| survey.added(b, all(b))), expect(&added_time));
        let refined = |block: &Block| if survey.refines { block.refined(&survey.chances) } else { 0.0 };
        let added_off = survey.added_off();
        let off = [
            time.interval[1] - time.value,
            math::hypot(slowdown_off, added_off) * added_time.value,
            CLOCK * time.value,
        ];
        // What refining adds is off in all blocks by the same factor.
        let with_added_off = |expected: Expected, added: f64| expected.widened(added_off * added);
        let kind = |kind: usize| {
            let of = |block: &Block| by_kind(&block.base)[kind];
            with_added_off(expect(&|b| with_added(b, of(b))), expect(&|b| survey.added(b, of(b))).value)
        };
        let kinds: [Expected; KINDS.len()] = std::array::from_fn(kind);
        let mut rays = with_added_off(expect(&|b| with_added(b, all(b))), added.value);
        // Camera rays are among them, and mostly known for certain.
        rays.interval[0] = rays.interval[0].max(kinds[0].interval[0]);
        let mut pilot = Self {
            traced,
            pixels,
            kinds,
            total_reflections: expect(&|b| with_added(b, b.base.total_internal_reflections as f64)),
            added: with_added_off(added, added.value),
            refined: expect(&refined),
            given_up: expect(&|b| b.base.given_up as f64),
            rays,
            times: fitted,
            is_cut_off: survey.is_cut_off,
            added_nanoseconds: added_time.value / added.value.max(1.0),
            time_off: off.iter().map(|off| off * off).sum::<f64>().sqrt() / time.value.max(1.0),
        };
        // The fit gives the ratio between kinds, the blocks give the whole time.
        let factor = time.value / pilot.nanoseconds().max(1.0);
        pilot.times = RayTimes { nanoseconds: fitted.nanoseconds.map(|each| each * factor) };
        pilot
    }

    /// Nanoseconds of one thread that all rays take.
    pub fn nanoseconds(&self) -> f64 {
        (0..KINDS.len()).map(|kind| self.kinds[kind].value * self.times.nanoseconds[kind]).sum()
    }
}

/// The median of some numbers, or 1 of none, and its relative error as an estimate of the mean. The mean of few would be of no
/// use, since single packets are interrupted or find the caches cold.
fn typical(numbers: &[f64]) -> (f64, f64) {
    let n = numbers.len() as f64;
    if numbers.is_empty() {
        return (1.0, 0.0);
    }
    let median = |mut numbers: Vec<f64>| {
        numbers.sort_unstable_by(f64::total_cmp);
        0.5 * (numbers[(numbers.len() - 1) / 2] + numbers[numbers.len() / 2])
    };
    let middle = median(numbers.to_vec());
    // For a normal distribution. The median is off by 1.25 times as much as the mean.
    let spread = 1.483 * median(numbers.iter().map(|each| (each - middle).abs()).collect());
    (middle, (2.0 + 8.0 / n) * 1.25 * spread / (n.sqrt() * middle))
}

/// How many standard errors an interval of n blocks reaches to either side: 2.5, since what pixels cost has a long tail, and more
/// for few blocks, whose spread is itself uncertain.
pub(super) fn standard_errors(n: f64) -> f64 {
    2.5 + 8.0 / n
}

/// Estimates the sum over all pixels of a value that blocks have, and its interval from the spread of neighbouring blocks:
/// collapsed strata with one block each (Cochran, Sampling Techniques, 5A.12). `left` is the share that was not traced.
fn expected(blocks: &[Block], value: &dyn Fn(&Block) -> f64, pixels: f64, left: f64) -> Expected {
    let n = blocks.len() as f64;
    let traced: f64 = blocks.iter().map(|block| block.pixels as f64).sum();
    let mean = blocks.iter().map(value).sum::<f64>() / traced;
    let each = |block: &Block| value(block) - mean * block.pixels as f64;
    let squares: f64 = blocks.windows(2).map(|pair| (each(&pair[0]) - each(&pair[1])).powi(2)).sum();
    let variance = squares / (2.0 * (n - 1.0).max(1.0)) * n / (traced * traced) * left;
    // A single block has no spread.
    let reach = if n < 2.0 { mean * left } else { standard_errors(n) * variance.sqrt() };
    Expected { value: mean * pixels, interval: [(mean - reach).max(0.0) * pixels, (mean + reach) * pixels] }
}
