//! The rays that a pilot traces: blocks of pixels all over the region, and a few packets of pixels that antialiasing will refine.
//!
//! Rays are spread unevenly: a tenth of the pixels often takes nine tenths of them. Blocks are many and small. They tell how many
//! pixels will be refined, and how many rays those take. Packets of refined pixels are expensive, and tell only how much longer a
//! ray takes there than in the block. They are drawn with a probability proportional to the time they stand for, so that their
//! mean is that of the time.

use super::block::{Block, Chances};
use super::cells::Cells;
use super::pilot::{Effort, standard_errors};
use crate::control::{Cancelled, Control, Stopwatch};
use crate::film::Region;
use crate::render::{BLOCK, PacketCost, Probe, border_share};
use crate::scene::Scene;
use rayon::prelude::*;
use std::ops::Range;
use std::time::{Duration, Instant};

/// Share of the blocks that are traced, but at least this many.
const SHARE: f64 = 1.0 / 16.0;
const LEAST_BLOCKS: f64 = 1_024.0;
/// At most so many: to go through the blocks of a zoomed picture would take longer than the pilot.
const MOST_BLOCKS: f64 = 1_048_576.0;
/// Blocks that a thread takes at a time.
const RUN: u32 = 16;
/// One of this many runs is traced before the number of further runs is decided.
const FIRST: u32 = 16;
/// A pilot that has not finished its first blocks after this time ends with what it has, unless it may take longer anyway.
const LONGEST: Duration = Duration::from_secs(2);
/// Share of the effort for blocks if pixels are refined, too.
const OF_BLOCKS: f64 = 0.5;
/// Least and most packets of refined pixels.
const PACKETS: [f64; 2] = [8.0, 64.0];
/// Blocks of base samples that are traced to find the pixels of a packet.
const FINDING: f64 = 4.0;
/// About how many samples a refined pixel gets.
const REFINED: f64 = 12.0;
/// Relative error of what refining adds where nothing was refined.
const UNKNOWN: f64 = 0.5;
/// Edge of the tiles in which these pixels are searched.
const TILE: u32 = 16;
/// A block was interrupted if its rays took this many times as long as those of 99 of 100 blocks.
const INTERRUPTED: f64 = 3.0;

/// What a pilot has traced.
#[derive(Debug)]
pub(super) struct Survey {
    /// Neighbours in space are neighbours in the list.
    pub(super) blocks: Vec<Block>,
    /// Chances to see from a block that a pixel will be refined, and with how many samples.
    pub(super) chances: [Chances; 2],
    /// Whether pixels are refined.
    pub(super) refines: bool,
    /// Base samples of each pixel.
    base_samples: u32,
    /// Time of a ray in packets of refined pixels, relative to the blocks they come from.
    pub(super) slowdowns: Vec<f64>,
    /// Whether even the first blocks took too long, so that the picture takes at least what they tell.
    pub(super) is_cut_off: bool,
    /// Rays of refined pixels, relative to those expected from the base samples around them. They differ, since what a pixel's
    /// proof needs depends on the number of its samples, and those with more contrast have other rays.
    heavier: f64,
    /// The half width of its 95 % interval.
    heavier_off: f64,
}

impl Survey {
    pub(super) fn make(scene: &Scene, region: Region, control: &Control, effort: Effort) -> Result<Self, Cancelled> {
        let started = Stopwatch::start();
        let is_cancelled = || control.stops();
        let is_late = |times: f64| started.elapsed() > effort.time.mul_f64(times) || is_cancelled();
        let all = f64::from(region.width.div_ceil(BLOCK)) * f64::from(region.height.div_ceil(BLOCK));
        let cells = Cells::new(region, (all * SHARE).clamp(LEAST_BLOCKS, MOST_BLOCKS));
        let probe = Probe::new(scene, control);
        let in_time = Control::until(Instant::now() + LONGEST.max(effort.time));
        let (runs, first) = (cells.count().div_ceil(RUN), cells.count().div_ceil(RUN * FIRST));
        let block = |at: Region, codes: &[[u8; 6]], cost: PacketCost| {
            let PacketCost { rays, nanoseconds } = cost;
            let more = if scene.adaptive { border_share(scene, region, at.pixels(), rays.camera) } else { 0.0 };
            let cost = PacketCost { rays: rays.times(1.0 + more), nanoseconds: nanoseconds * (1.0 + more) };
            Block::new(scene, at, codes, cost)
        };
        let trace_run = |k: u32, end: &Control| -> Vec<(u32, Block)> {
            if k > 0 && is_late(1.0) {
                return Vec::new();
            }
            let run: Vec<u32> = (k * RUN..cells.count().min((k + 1) * RUN)).map(|k| cells.visited(k)).collect();
            let regions: Vec<Region> = run.iter().map(|cell| cells.block(*cell)).collect();
            let _entered = end.enter();
            let traced = probe.blocks(&regions).into_iter().zip(regions);
            run.into_iter().zip(traced.map(|((codes, cost), at)| block(at, &codes, cost))).collect()
        };
        let trace = |runs: Range<u32>| -> Vec<(u32, Block)> {
            let of_run = |k: u32| trace_run(k, &in_time);
            let mut blocks: Vec<_> = runs.into_par_iter().with_max_len(1).flat_map_iter(of_run).collect();
            let is_begun = |(_, block): &(u32, Block)| block.base.camera > 0;
            if in_time.is_cancelled() && blocks.iter().any(is_begun) {
                // Those that were not begun tell nothing; one that was takes at least what it took so far.
                blocks.retain(is_begun);
            }
            blocks
        };
        let (refines, mut traced) = (scene.refines(), trace(0..first));
        let mut survey = Self {
            blocks: Vec::new(),
            chances: [Chances::default(); 2],
            refines,
            base_samples: scene.samples,
            slowdowns: Vec::new(),
            is_cut_off: false,
            heavier: 1.0,
            heavier_off: if refines { UNKNOWN } else { 0.0 },
        };
        survey.set(traced.iter().map(|(_, block)| block.clone()).collect());
        let share = effort.share * if refines { OF_BLOCKS } else { 1.0 };
        let times = (share * survey.rays(region) / survey.base_rays()).clamp(1.0, f64::from(FIRST));
        let more = trace(first..runs.min((f64::from(first) * times) as u32));
        if more.len() < traced.len() {
            // The first run filled tables of the scene. It is traced again, if that is quick.
            let soon = Control::until(Instant::now() + effort.time);
            let again = trace_run(0, &soon);
            if !soon.is_cancelled() {
                for ((_, block), (_, again)) in traced.iter_mut().zip(again) {
                    block.nanoseconds = block.nanoseconds.min(again.nanoseconds);
                }
            }
        }
        survey.set(in_order(traced, more));
        if refines {
            let share = effort.share * (1.0 - OF_BLOCKS);
            survey.refine(&probe, region, share, || is_late(1.5) || in_time.is_cancelled());
        }
        survey.is_cut_off = in_time.is_cancelled();
        if is_cancelled() { Err(Cancelled) } else { Ok(survey) }
    }

    fn set(&mut self, blocks: Vec<Block>) {
        self.chances = Chances::of(&blocks);
        self.blocks = blocks;
    }

    /// Estimate of what refining adds to a block whose base samples take `base`.
    pub(super) fn added(&self, block: &Block, base: f64) -> f64 {
        if self.refines { base * block.refined_samples(&self.chances, self.base_samples) * self.heavier } else { 0.0 }
    }

    /// The relative error of what refining adds that the blocks do not tell.
    pub(super) fn added_off(&self) -> f64 {
        self.heavier_off / self.heavier
    }

    fn base_rays(&self) -> f64 {
        self.blocks.iter().map(|block| block.base.total() as f64).sum()
    }

    /// Rays of the whole region.
    fn rays(&self, region: Region) -> f64 {
        let added: f64 = self.blocks.iter().map(|block| self.added(block, block.base.total() as f64)).sum();
        let pixels: u64 = self.blocks.iter().map(|block| block.pixels).sum();
        (self.base_rays() + added) * region.pixels() as f64 / pixels as f64
    }

    /// Refines packets of pixels, for about a share of the rays of the region.
    fn refine(&mut self, probe: &Probe<'_>, region: Region, share: f64, is_late: impl Fn() -> bool + Sync) {
        let added: Vec<f64> = self.blocks.iter().map(|block| self.added(block, block.nanoseconds)).collect();
        let all: f64 = added.iter().sum();
        if all <= 0.0 {
            return;
        }
        // Of a packet where it is likely to be drawn.
        let rays = |block: &Block| block.base.total() as f64 * (FINDING + REFINED / f64::from(self.base_samples));
        let rays = self.blocks.iter().zip(&added).map(|(block, added)| added / all * rays(block)).sum::<f64>();
        let count = (share * self.rays(region) / rays).clamp(PACKETS[0], PACKETS[1]);
        let mut drawn = Vec::new();
        let (mut reached, mut next) = (0.0, 0.5 * all / count);
        for (block, added) in self.blocks.iter().zip(added) {
            reached += added;
            while reached > next {
                drawn.push(block);
                next += all / count;
            }
        }
        let slowdown = |block: &Block| {
            if is_late() {
                return None;
            }
            let (cost, samples) = probe.refined(block.region, tile_around(block.region, region))?;
            let [rays, base] = [cost.rays, block.base].map(|rays| rays.total().max(1) as f64);
            let thought = base * f64::from(samples) / (block.pixels as f64 * f64::from(self.base_samples));
            Some((cost.nanoseconds / rays / (block.nanoseconds / base), rays / thought.max(1.0)))
        };
        drawn.dedup_by_key(|block| block.region);
        let (slowdowns, heavier): (Vec<f64>, Vec<f64>) =
            drawn.into_par_iter().with_max_len(1).filter_map(slowdown).unzip();
        if heavier.len() > 1 {
            let n = heavier.len() as f64;
            let mean = heavier.iter().sum::<f64>() / n;
            let variance = heavier.iter().map(|each| (each - mean).powi(2)).sum::<f64>() / (n - 1.0);
            (self.heavier, self.heavier_off) = (mean, standard_errors(n) * (variance / n).sqrt());
        }
        self.slowdowns = slowdowns;
    }
}

/// The tile of a region in which a block begins. The block may extend beyond it.
fn tile_around(block: Region, region: Region) -> Region {
    let begin = |at: u32, from: u32| from + (at - from) / TILE * TILE;
    let (x, y) = (begin(block.x, region.x), begin(block.y, region.y));
    let [right, bottom] = [region.x + region.width, region.y + region.height];
    Region { x, y, width: TILE.min(right - x), height: TILE.min(bottom - y) }
}

/// The blocks in the order of their cells. Corrects the time of the first blocks, which found caches cold, and of those that
/// were interrupted.
fn in_order(mut first: Vec<(u32, Block)>, more: Vec<(u32, Block)>) -> Vec<Block> {
    let pace = |blocks: &[(u32, Block)]| {
        let rays: u64 = blocks.iter().map(|(_, block)| block.base.total()).sum();
        blocks.iter().map(|(_, block)| block.nanoseconds).sum::<f64>() / rays.max(1) as f64
    };
    if more.len() >= first.len() {
        let warm = (pace(&more) / pace(&first)).min(1.0);
        first.iter_mut().for_each(|(_, block)| block.nanoseconds *= warm);
    }
    first.extend(more);
    first.sort_unstable_by_key(|(cell, _)| *cell);
    let mut blocks: Vec<Block> = first.into_iter().map(|(_, block)| block).collect();
    let each = |block: &Block| block.nanoseconds / block.base.total().max(1) as f64;
    let mut paces: Vec<f64> = blocks.iter().map(each).collect();
    paces.sort_unstable_by(f64::total_cmp);
    let most = INTERRUPTED * paces[(paces.len() - 1) * 99 / 100];
    for block in &mut blocks {
        block.nanoseconds = block.nanoseconds.min(most * block.base.total().max(1) as f64);
    }
    blocks
}
