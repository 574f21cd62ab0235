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
    /// What pixels with all neighbours known tell of the others: of their number, and of their samples.
    pub(super) chances: [Chances; 2],
}

impl Block {
    pub(super) fn new(scene: &Scene, block: Region, codes: &[[u8; 6]], cost: PacketCost) -> Self {
        let mut seen = Self {
            region: block,
            pixels: block.pixels(),
            base: cost.rays,
            nanoseconds: cost.nanoseconds,
            seen: [0.0; 3],
            samples: [0.0; 3],
            chances: [Chances::default(); 2],
        };
        if scene.refines() {
            let apart = |c: usize| {
                codes.iter().map(|p| p[c]).max() > codes.iter().map(|p| p[c].saturating_add(CONTRAST - 1)).min()
            };
            if (0..6).any(apart) {
                block.iter().for_each(|at| seen.look(scene, block, codes, at));
            }
        }
        seen
    }

    fn look(&mut self, scene: &Scene, block: Region, codes: &[[u8; 6]], [x, y]: [u32; 2]) {
        let contrast = contrast_in(codes, block, [x, y]);
        if contrast < CONTRAST {
            return;
        }
        let known = known(scene, block, x, y);
        let samples = |contrast: u8| f64::from(refined_samples(contrast, scene.samples));
        self.seen[known as usize] += 1.0;
        self.samples[known as usize] += samples(contrast);
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
        let [sides, corners] =
            [sides, corners].map(|parts| parts.map(|part| contrast_within(codes, block, part, [x, y])));
        let weight = self.base.total() as f64 / self.pixels as f64;
        let seen = |contrast: u8| if contrast < CONTRAST { 0.0 } else { 1.0 };
        let tells = |of: &dyn Fn(u8) -> f64| [of(contrast), sides.map(of).iter().sum(), corners.map(of).iter().sum()];
        self.chances[0].add(weight, tells(&seen));
        self.chances[1].add(weight, tells(&|contrast| seen(contrast) * samples(contrast)));
    }

    /// Estimated number of pixels that are refined.
    pub(super) fn refined(&self, chances: &[Chances; 2]) -> f64 {
        chances[0].of_all(self.seen)
    }

    /// Estimated samples that they get, for each base sample of the block.
    pub(super) fn refined_samples(&self, chances: &[Chances; 2], base_samples: u32) -> f64 {
        chances[1].of_all(self.samples) / (self.pixels as f64 * f64::from(base_samples))
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

/// The chance that a pixel that differs from a neighbour differs from one of the neighbours left without one side, or two; or
/// which share of its samples it would get. Pixels are weighted by their rays, since rays are to be estimated.
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

    /// Adds what a pixel has, and the sums of what it would have without each side, and each corner.
    fn add(&mut self, weight: f64, [all, sides, corners]: [f64; 3]) {
        self.asked += weight * 4.0 * all;
        self.side += weight * sides;
        self.corner += weight * corners;
    }

    /// The chances of pixels, and of their samples.
    pub(super) fn of(blocks: &[Block]) -> [Self; 2] {
        [0, 1].map(|of: usize| {
            blocks.iter().map(|block| &block.chances[of]).fold(Self::THOUGHT, |all, more| Self {
                asked: all.asked + more.asked,
                side: all.side + more.side,
                corner: all.corner + more.corner,
            })
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
