//! A traced block of pixels, and what it tells about antialiasing.

use crate::film::Region;
use crate::render::{CONTRAST, PacketCost, contrast_in, contrast_within, refined_samples};
use crate::scene::Scene;
use crate::trace::counts::RayCounts;

/// How many neighbours of a pixel are in its block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Known {
    All,
    /// All but those beyond one side of the block.
    ButSide,
    /// All but those beyond two.
    ButCorner,
}

/// A traced block.
#[derive(Debug, Clone)]
pub(super) struct Block {
    pub(super) region: Region,
    pub(super) pixels: u64,
    pub(super) base: RayCounts,
    pub(super) nanoseconds: f64,
    /// Pixels that differ from a neighbour in the block: with all neighbours known, without those beyond a side, and without
    /// those beyond a corner.
    seen: [f64; 3],
    /// Samples that they get.
    samples: [f64; 3],
    /// What pixels with all neighbours known tell of the others.
    pub(super) chances: Chances,
}

impl Block {
    pub(super) fn new(scene: &Scene, block: Region, pixels: &[[f32; 3]], cost: PacketCost) -> Self {
        let mut seen = Self {
            region: block,
            pixels: block.pixels(),
            base: cost.rays,
            nanoseconds: cost.nanoseconds,
            seen: [0.0; 3],
            samples: [0.0; 3],
            chances: Chances::default(),
        };
        if scene.refines() {
            let codes: Vec<[u8; 3]> = pixels.iter().map(|p| scene.display().codes(*p)).collect();
            let apart = |c: usize| {
                codes.iter().map(|p| p[c]).max() > codes.iter().map(|p| p[c].saturating_add(CONTRAST - 1)).min()
            };
            if (0..3).any(apart) {
                block.iter().for_each(|at| seen.look(scene, block, &codes, at));
            }
        }
        seen
    }

    fn look(&mut self, scene: &Scene, block: Region, codes: &[[u8; 3]], [x, y]: [u32; 2]) {
        let contrast = contrast_in(codes, block, [x, y]);
        if contrast < CONTRAST {
            return;
        }
        let known = known(scene, block, x, y);
        self.seen[known as usize] += 1.0;
        self.samples[known as usize] += f64::from(refined_samples(contrast, scene.samples));
        if known != Known::All {
            return;
        }
        // The same pixel as if it were at a side or in a corner of its block.
        let around = Region { x, y, width: 1, height: 1 }.with_border(scene.width, scene.height);
        if around.pixels() < 9 {
            return;
        }
        let part = |x: u32, y: u32, width: u32, height: u32| Region { x, y, width, height };
        let sides = [part(x - 1, y - 1, 2, 3), part(x, y - 1, 2, 3), part(x - 1, y - 1, 3, 2), part(x - 1, y, 3, 2)];
        let corners = [part(x - 1, y - 1, 2, 2), part(x, y - 1, 2, 2), part(x - 1, y, 2, 2), part(x, y, 2, 2)];
        let seen = |parts: [Region; 4]| {
            parts.iter().filter(|part| contrast_within(codes, block, **part, [x, y]) >= CONTRAST).count() as f64
        };
        self.chances.add(self.base.total() as f64 / self.pixels as f64, seen(sides), seen(corners));
    }

    /// Estimated number of pixels that are refined.
    pub(super) fn refined(&self, chances: &Chances) -> f64 {
        chances.of_all(self.seen)
    }

    /// Estimated samples that they get, for each base sample of the block.
    pub(super) fn refined_samples(&self, chances: &Chances, base_samples: u32) -> f64 {
        chances.of_all(self.samples) / (self.pixels as f64 * f64::from(base_samples))
    }
}

fn known(scene: &Scene, block: Region, x: u32, y: u32) -> Known {
    let around = Region { x, y, width: 1, height: 1 }.with_border(scene.width, scene.height);
    let beyond = |first: u32, length: u32, own_first: u32, own_length: u32| {
        u32::from(first < own_first) + u32::from(first + length > own_first + own_length)
    };
    match beyond(around.x, around.width, block.x, block.width) + beyond(around.y, around.height, block.y, block.height)
    {
        0 => Known::All,
        1 => Known::ButSide,
        _ => Known::ButCorner,
    }
}

/// The chance that a pixel that differs from a neighbour differs from one of the neighbours left without one side, or two.
/// Pixels are weighted by their rays, since rays are to be estimated.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Chances {
    asked: f64,
    side: f64,
    corner: f64,
}

impl Chances {
    /// The prior: a straight edge along the pixels is seen from three sides of four and from half of the corners, one across
    /// them from more.
    const THOUGHT: Self = Self { asked: 16.0, side: 16.0 * 0.8, corner: 16.0 * 0.65 };

    fn add(&mut self, weight: f64, sides: f64, corners: f64) {
        self.asked += weight * 4.0;
        self.side += weight * sides;
        self.corner += weight * corners;
    }

    pub(super) fn of<'a>(blocks: impl IntoIterator<Item = &'a Block>) -> Self {
        blocks.into_iter().fold(Self::THOUGHT, |all, block| Self {
            asked: all.asked + block.chances.asked,
            side: all.side + block.chances.side,
            corner: all.corner + block.chances.corner,
        })
    }

    /// What all pixels have, from those that were seen.
    fn of_all(&self, [all, sides, corners]: [f64; 3]) -> f64 {
        all + sides / self.side() + corners / self.corner()
    }

    fn side(&self) -> f64 {
        self.side / self.asked
    }

    fn corner(&self) -> f64 {
        self.corner / self.asked
    }
}
