//! What a picture will take, from tracing few of its pixels: the pilot.
//!
//! The picture is cut into as many cells as blocks shall be traced, and each cell gives one block of pixels, anywhere in
//! it. Blocks of one packet are as coherent as the picture's own, and of the pixels in their middle all neighbours are
//! known, so that the share of pixels that antialiasing refines is known, too. Cells are visited in an order of which
//! every part is spread over the picture; when time is up, what has been traced is enough for wider intervals.

use super::ray_times::{KINDS, RayTimes, by_kind};
use crate::film::Region;
use crate::film::srgb::code8;
use crate::lanes::MAX_LANES;
use crate::render::{BLOCK, Cancelled, Control, Probe, REFINED_SAMPLES, RayCounts, code_in, is_uneven, probe, refines};
use crate::scene::Scene;
use rayon::prelude::*;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// How far a pilot goes before it is content with what it has.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Wall time.
    pub time: Duration,
    /// Share of the pixels, and so about of the time that the picture takes.
    pub share: f64,
}

impl Effort {
    /// For an answer at once.
    pub const QUICK: Self = Self { time: Duration::from_millis(3), share: 1.0 };
    /// Before a picture: little beside it, however long it takes.
    pub const BESIDE: Self = Self { time: Duration::from_secs(1), share: 0.012 };
}

/// Blocks between two looks at the effort, which all threads share.
const CHUNK: u32 = 48;
/// Blocks of a picture: 1/256 of them, but at least this many (if it has as many).
const LEAST_BLOCKS: u32 = 1_024;
const SHARE: u32 = 256;
/// How far the same work may be from its time at another moment.
const CLOCK: f64 = 0.05;
/// Most packets of uneven pixels that are timed.
const EDGE_PACKETS: usize = 24;

/// A number expected, and the interval that holds the true one in 19 of 20 pictures.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Expected {
    /// The estimate.
    pub value: f64,
    /// Lower and upper end of the interval.
    pub interval: [f64; 2],
}

/// What the pilot has found, for the whole region.
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
    /// All rays.
    pub rays: Expected,
    /// What each kind of ray takes, refined pixels included.
    pub times: RayTimes,
    /// What the rays that antialiasing adds take, in nanoseconds: its packets gather edges from all over and are less
    /// coherent than blocks.
    pub added_nanoseconds: f64,
    /// How far the whole time may be from what is expected, as a share of it, in 19 of 20 pictures.
    pub time_off: f64,
}

impl Pilot {
    /// Traces a pilot of a region, which must fit the picture, on the current rayon pool.
    pub fn run(scene: &Scene, region: Region, control: &Control, effort: Effort) -> Result<Self, Cancelled> {
        let started = Instant::now();
        let cells = Cells::new(region);
        let probe = probe(scene, control);
        let trace = |k: u32| {
            let cell = cells.visited(k);
            (cell, Block::trace(scene, &probe, cells.block(cell)))
        };
        let enough = (f64::from(cells.blocks[0] * cells.blocks[1]) * effort.share).ceil() as u32;
        let wanted = cells.count().min(enough);
        let mut blocks = Vec::with_capacity(wanted as usize);
        for first in (0..wanted).step_by(CHUNK as usize) {
            blocks.par_extend((first..wanted.min(first + CHUNK)).into_par_iter().with_max_len(1).map(trace));
            if control.cancelled.load(Ordering::Relaxed) {
                return Err(Cancelled);
            }
            if started.elapsed() > effort.time {
                break;
            }
        }
        // Neighbours in space are neighbours in the list, for the spread of neighbours.
        blocks.sort_unstable_by_key(|(cell, _)| *cell);
        let blocks: Vec<Block> = blocks.into_iter().map(|(_, block)| block).collect();
        Ok(Self::of(&blocks, region.pixels(), refines(scene), &probe))
    }

    fn of(blocks: &[Block], pixels: u64, refines: bool, probe: &Probe<'_>) -> Self {
        let traced: u64 = blocks.iter().map(|block| block.pixels).sum();
        // Of what antialiasing does only the pixels with known neighbours tell.
        let seen = if refines { blocks.iter().map(|block| block.inner).sum() } else { traced };
        let left = (1.0 - seen as f64 / pixels as f64).max(0.0);
        let expect = |value: &dyn Fn(&Block) -> f64| expected(blocks, value, pixels as f64, left);
        let all = |block: &Block| block.base.total() as f64;
        let fitted = RayTimes::fit(&blocks.iter().map(|block| (block.base, block.nanoseconds)).collect::<Vec<_>>());
        let mut pilot = Self {
            traced,
            pixels,
            kinds: std::array::from_fn(|kind| expect(&|b| b.with_refined(by_kind(&b.base)[kind]))),
            total_reflections: expect(&|b| b.with_refined(b.base.total_internal_reflections as f64)),
            added: expect(&|b| b.refined(all(b))),
            refined: expect(&|b| b.share() * b.pixels as f64),
            rays: expect(&|b| b.with_refined(all(b))),
            times: fitted,
            added_nanoseconds: 0.0,
            time_off: 0.0,
        };
        let time = expect(&|b| b.with_refined(b.nanoseconds));
        pilot.time_off = (time.interval[1] - time.value) / time.value.max(1.0) + CLOCK;
        // The fit says how kinds share the time, the blocks how much there is.
        let factor = time.value / pilot.nanoseconds().max(1.0);
        pilot.times = RayTimes { nanoseconds: fitted.nanoseconds.map(|each| each * factor) };
        let even = pilot.nanoseconds() / pilot.rays.value.max(1.0);
        pilot.added_nanoseconds = even * slowdown(blocks, &pilot.times, probe);
        // All kinds share what the added rays take longer.
        let longer = pilot.added.value * (pilot.added_nanoseconds - even);
        let factor = 1.0 + longer / pilot.nanoseconds().max(1.0);
        pilot.times = RayTimes { nanoseconds: pilot.times.nanoseconds.map(|each| each * factor) };
        pilot
    }

    /// Nanoseconds of one thread that all rays take.
    pub fn nanoseconds(&self) -> f64 {
        (0..KINDS.len()).map(|kind| self.kinds[kind].value * self.times.nanoseconds[kind]).sum()
    }
}

/// How many times as long rays take from packets of uneven pixels, as antialiasing puts them together. The pilot's uneven
/// pixels lie further apart than the picture's, so the truth is between 1 and what its packets take: their geometric mean.
fn slowdown(blocks: &[Block], times: &RayTimes, probe: &Probe<'_>) -> f64 {
    let mut uneven: Vec<[u32; 2]> = blocks.iter().flat_map(|block| &block.uneven).copied().collect();
    uneven.sort_unstable_by_key(|[x, y]| (*y, *x));
    let begun = Instant::now();
    let packets =
        uneven.chunks_exact(MAX_LANES).take(EDGE_PACKETS).take_while(|_| begun.elapsed() < Effort::QUICK.time / 4);
    let paces = packets.map(|packet| {
        let started = Instant::now();
        let (_, rays) = probe(packet);
        let nanoseconds = started.elapsed().as_secs_f64() * 1e9;
        nanoseconds / by_kind(&rays).iter().zip(times.nanoseconds).map(|(n, t)| n * t).sum::<f64>().max(1.0)
    });
    let mut paces: Vec<f64> = paces.collect();
    // The median: a packet may have been interrupted.
    paces.sort_unstable_by(f64::total_cmp);
    paces.get(paces.len() / 2).copied().unwrap_or(1.0).sqrt()
}

/// What one block has shown.
#[derive(Debug, Clone)]
struct Block {
    pixels: u64,
    base: RayCounts,
    /// Pixels of which all neighbours are known.
    inner: u64,
    /// Those of them that differ from one.
    uneven: Vec<[u32; 2]>,
    /// Samples that a refined pixel gets for each base sample.
    factor: f64,
    nanoseconds: f64,
}

impl Block {
    fn trace(scene: &Scene, probe: &Probe<'_>, block: Region) -> Self {
        let at: Vec<[u32; 2]> = block.iter().collect();
        let started = Instant::now();
        let (pixels, base) = probe(&at);
        let nanoseconds = started.elapsed().as_secs_f64() * 1e9;
        let mut traced = Self {
            pixels: block.pixels(),
            base,
            inner: 0,
            uneven: Vec::new(),
            factor: f64::from(REFINED_SAMPLES) / f64::from(scene.samples),
            nanoseconds,
        };
        if refines(scene) {
            let codes: Vec<[u8; 3]> = pixels.iter().map(|p| p.map(code8)).collect();
            let known = |&[x, y]: &[u32; 2]| {
                let around = Region { x, y, width: 1, height: 1 }.with_border(scene.width, scene.height);
                around.x >= block.x
                    && around.y >= block.y
                    && around.x + around.width <= block.x + block.width
                    && around.y + around.height <= block.y + block.height
            };
            for [x, y] in at.iter().copied().filter(known) {
                traced.inner += 1;
                if is_uneven(code_in(&codes, block), block, x, y) {
                    traced.uneven.push([x, y]);
                }
            }
        }
        traced
    }

    /// Share of the pixels that are refined.
    fn share(&self) -> f64 {
        self.uneven.len() as f64 / self.inner.max(1) as f64
    }

    /// Rays of refined pixels, given those of all base samples: a refined pixel's samples are like its block's.
    fn refined(&self, base: f64) -> f64 {
        base * self.share() * self.factor
    }

    fn with_refined(&self, base: f64) -> f64 {
        base + self.refined(base)
    }
}

/// Estimates the sum over all pixels of a value that blocks have, and its interval from the spread of neighbouring blocks:
/// strata with one block each, collapsed (Cochran, Sampling Techniques, 5A.12). `left` is the share not seen.
fn expected(blocks: &[Block], value: &dyn Fn(&Block) -> f64, pixels: f64, left: f64) -> Expected {
    let n = blocks.len() as f64;
    let traced: f64 = blocks.iter().map(|block| block.pixels as f64).sum();
    let mean = blocks.iter().map(value).sum::<f64>() / traced;
    let each = |block: &Block| value(block) - mean * block.pixels as f64;
    let squares: f64 = blocks.windows(2).map(|pair| (each(&pair[0]) - each(&pair[1])).powi(2)).sum();
    let variance = squares / (2.0 * (n - 1.0).max(1.0)) * n / (traced * traced) * left;
    // 2.0 standard errors, and more for few blocks, whose spread is itself uncertain. A single block has none.
    let errors = 2.0 + 8.0 / n;
    let reach = if n < 2.0 { mean * left } else { errors * variance.sqrt() };
    Expected { value: mean * pixels, interval: [(mean - reach).max(0.0) * pixels, (mean + reach) * pixels] }
}

/// The cells of a region, one block in each.
#[derive(Debug, Clone, Copy)]
struct Cells {
    region: Region,
    /// Blocks across and down the region.
    blocks: [u32; 2],
    /// Cells across and down.
    cells: [u32; 2],
}

impl Cells {
    fn new(region: Region) -> Self {
        let blocks = [region.width.div_ceil(BLOCK), region.height.div_ceil(BLOCK)];
        let wanted = f64::from((blocks[0] * blocks[1] / SHARE).max(LEAST_BLOCKS));
        let across = (wanted * f64::from(blocks[0]) / f64::from(blocks[1])).sqrt().round();
        let columns = (across as u32).clamp(1, blocks[0]);
        let rows = ((wanted / f64::from(columns)).round() as u32).clamp(1, blocks[1]);
        Self { region, blocks, cells: [columns, rows] }
    }

    fn count(&self) -> u32 {
        self.cells[0] * self.cells[1]
    }

    /// The k-th cell to visit: steps near the golden section of the count, which any prefix spreads evenly.
    fn visited(&self, k: u32) -> u32 {
        let count = self.count();
        let golden = (f64::from(count) * 0.618_033_988_749_894_9) as u32;
        let common = |mut a: u32, mut b: u32| {
            while b != 0 {
                (a, b) = (b, a % b);
            }
            a
        };
        let step = (golden.max(1)..).find(|step| common(*step, count) == 1).unwrap_or(1);
        ((u64::from(k) * u64::from(step)) % u64::from(count)) as u32
    }

    /// The block of a cell. Cells are counted along rows, back and forth.
    fn block(&self, cell: u32) -> Region {
        let [columns, rows] = self.cells;
        let row = cell / columns;
        let along = cell % columns;
        let column = if row.is_multiple_of(2) { along } else { columns - 1 - along };
        let hash = cell.wrapping_mul(0x9e37_79b9).rotate_left(15).wrapping_mul(0x85eb_ca6b);
        let inside = |index: u32, cells: u32, blocks: u32, random: u32| {
            let [first, end] = [index, index + 1].map(|i| (u64::from(i) * u64::from(blocks) / u64::from(cells)) as u32);
            first + random % (end - first)
        };
        let x = inside(column, columns, self.blocks[0], hash >> 16) * BLOCK;
        let y = inside(row, rows, self.blocks[1], hash & 0xffff) * BLOCK;
        Region {
            x: self.region.x + x,
            y: self.region.y + y,
            width: BLOCK.min(self.region.width - x),
            height: BLOCK.min(self.region.height - y),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_is_visited_once_and_gives_a_block_of_the_region() {
        for (width, height) in [(1, 1), (3, 200), (960, 540), (240, 135), (4_000, 3)] {
            let region = Region { x: 5, y: 7, width, height };
            let cells = Cells::new(region);
            let mut visited: Vec<u32> = (0..cells.count()).map(|k| cells.visited(k)).collect();
            let mut blocks: Vec<(u32, u32)> = visited
                .iter()
                .map(|cell| cells.block(*cell))
                .inspect(|b| {
                    assert!(b.x >= 5 && b.y >= 7 && b.x + b.width <= 5 + width && b.y + b.height <= 7 + height)
                })
                .map(|b| (b.x, b.y))
                .collect();
            visited.sort_unstable();
            assert!(visited.iter().copied().eq(0..cells.count()), "{width} x {height}");
            blocks.sort_unstable();
            blocks.dedup();
            assert_eq!(blocks.len() as u32, cells.count(), "{width} x {height}");
        }
    }
}
