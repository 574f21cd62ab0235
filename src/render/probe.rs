//! Probes: a few blocks of pixels, traced and timed for the [`pilot`](crate::plan::pilot).

use super::antialiasing::{Uneven, refined_samples};
use super::contrast::{CONTRAST, codes_over_both, contrasts_of};
use super::packets::{KernelFormat, Traced};
use crate::control::Control;
use crate::trace::counts::RayCounts;
use crate::trace::pixel::Samples;

use super::renderer::Renderer;
use super::thread_time::ThreadTime;
use super::tiles::near;
use super::{BLOCK, RenderOptions};
use crate::film::Region;
use crate::lanes::MAX_LANES;
use crate::scene::Scene;
use crate::scene::compile::Precise;

/// The cost of a packet of pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PacketCost {
    pub(crate) rays: RayCounts,
    pub(crate) nanoseconds: f64,
}

impl PacketCost {
    /// The sum of several packets.
    pub(crate) fn of(packets: &[Self]) -> Self {
        let rays = packets.iter().fold(RayCounts::default(), |rays, packet| rays + packet.rays);
        Self { rays, nanoseconds: packets.iter().map(|packet| packet.nanoseconds).sum() }
    }
}

/// Traces probes of a scene. Once the render is cancelled, results come early and are useless.
pub(crate) enum Probe<'a> {
    Single(Renderer<'a, f32>),
    Double(Renderer<'a, f64>),
}

impl<'a> Probe<'a> {
    pub(crate) fn new(scene: &'a Scene, control: &'a Control) -> Self {
        match &scene.world {
            Precise::Single(world) => {
                Self::Single(Renderer::new(scene, world, control, RenderOptions::default()).watched())
            }
            Precise::Double(world) => {
                Self::Double(Renderer::new(scene, world, control, RenderOptions::default()).watched())
            }
        }
    }

    /// The codes of the base samples of blocks, which are all of the same size, over black and over what is behind.
    pub(crate) fn blocks(&self, blocks: &[Region]) -> Vec<(Vec<[u8; 6]>, PacketCost)> {
        match self {
            Self::Single(renderer) => renderer.blocks(blocks),
            Self::Double(renderer) => renderer.blocks(blocks),
        }
    }

    /// The cost of refining a packet of pixels in or near a block, in the same tile, without the base samples that decide which
    /// pixels are refined, and its samples; none if no pixel is refined.
    pub(crate) fn refined(&self, block: Region, tile: Region) -> Option<(PacketCost, u32)> {
        match self {
            Self::Single(renderer) => renderer.refined(block, tile),
            Self::Double(renderer) => renderer.refined(block, tile),
        }
    }
}

impl<R: KernelFormat> Renderer<'_, R> {
    fn blocks(&self, blocks: &[Region]) -> Vec<(Vec<[u8; 6]>, PacketCost)> {
        let whole = blocks.iter().all(|block| block.pixels() == u64::from(BLOCK * BLOCK));
        if blocks.is_empty() || !whole || self.scene.adaptive || self.scene.statistical.is_some() {
            // Else the number of pixels is not that of blocks.
            return blocks.iter().map(|block| self.block(block)).collect();
        }
        let mut traced = Traced::default();
        let at: Vec<[u32; 2]> = blocks.iter().flat_map(|block| block.iter()).collect();
        R::trace(self.options.level, &self.job, &at, Samples::of_picture(self.scene.samples), &mut traced);
        self.control.add_rays(traced.rays.total());
        let packets = traced.packets.chunks(traced.packets.len() / blocks.len());
        let codes = codes_over_both(&self.job.world.display, &traced.pixels, &traced.alpha);
        codes.chunks(MAX_LANES).zip(packets).map(|(codes, packets)| (codes.to_vec(), PacketCost::of(packets))).collect()
    }

    fn block(&self, block: &Region) -> (Vec<[u8; 6]>, PacketCost) {
        let at: Vec<[u32; 2]> = block.iter().collect();
        let mut traced = Traced::default();
        let started = ThreadTime::start();
        if self.scene.adaptive {
            // Once the render is cancelled, results are useless.
            traced = self.doubled_block(*block).unwrap_or_default();
        } else {
            self.trace_pixels(&at, self.scene.samples, &mut traced);
            self.control.add_rays(traced.rays.total());
        }
        let nanoseconds = started.nanoseconds();
        let codes = codes_over_both(&self.job.world.display, &traced.pixels, &traced.alpha);
        (codes, PacketCost { rays: traced.rays, nanoseconds })
    }

    fn refined(&self, block: Region, tile: Region) -> Option<(PacketCost, u32)> {
        let base = |part: Region| {
            let at: Vec<[u32; 2]> = part.tiles(BLOCK).flat_map(Region::iter).collect();
            let mut traced = Traced::default();
            R::trace(self.options.level, &self.job, &at, Samples::of_picture(self.scene.samples), &mut traced);
            self.control.add_rays(traced.rays.total());
            let (pixels, alpha) = (traced.pixels.clone(), traced.alpha.clone());
            at.iter().zip(pixels).for_each(|(at, pixel)| traced.pixels[part.index(*at)] = pixel);
            at.iter().zip(alpha).for_each(|(at, alpha)| traced.alpha[part.index(*at)] = alpha);
            let contrasts = contrasts_of(&self.job.world.display, &traced, part.width);
            let uneven = near(part, |at| contrasts[part.index(at)] >= CONTRAST);
            let pixel = |at: [u32; 2]| Uneven { at, contrast: contrasts[part.index(at)] };
            uneven.into_iter().map(pixel).collect::<Vec<_>>()
        };
        // One row of blocks is often enough.
        let y = block.y.min(tile.y + tile.height - block.height);
        let mut uneven = base(Region { y, height: block.height, ..tile });
        if uneven.len() < MAX_LANES {
            uneven = base(tile);
        }
        let first = uneven.iter().position(|pixel| pixel.at[1] >= block.y && pixel.at[0] >= block.x).unwrap_or(0);
        let first = first.min(uneven.len().saturating_sub(MAX_LANES));
        let packet = &uneven[first..uneven.len().min(first + MAX_LANES)];
        let started = ThreadTime::start();
        // Once the render is cancelled, results are useless.
        let rays = self.refine(packet).unwrap_or_default().rays;
        let nanoseconds = started.nanoseconds();
        let samples: u32 = packet.iter().map(|pixel| refined_samples(pixel.contrast, self.scene.samples)).sum();
        (!packet.is_empty()).then_some((PacketCost { rays, nanoseconds }, samples))
    }
}
