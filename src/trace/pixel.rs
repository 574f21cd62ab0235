//! The samples of pixels, and the media around their eye.

use super::batch::BATCH;
use super::eye_media::media_at;
use crate::lanes::Lanes;
use crate::scene::world::World;
use crate::shading::media::Medium;

/// Share of a pixel over which textures are averaged for a sample of a set of which there may be any number.
const SHARE_OF_SET: f64 = 1.0 / 1_024.0;

/// Which samples pixels get.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Samples {
    /// The number of the first one.
    pub(crate) first: u32,
    /// How many, at least 1.
    pub(crate) count: u32,
    /// Whether they are a part of those that the pixel may get.
    pub(super) is_part: bool,
    /// 0 for those that pictures are made of, evenly spread. Any other number stands for others, as evenly spread, and
    /// independent of those of all other numbers.
    pub(crate) set: u32,
}

impl Samples {
    /// Those that pictures are made of.
    pub(crate) fn of_picture(count: u32) -> Self {
        Self { first: 0, count, is_part: false, set: 0 }
    }

    /// A run of those that pictures are made of, of which others may follow.
    pub(crate) fn run(first: u32, count: u32) -> Self {
        Self { first, count, is_part: true, set: 0 }
    }

    /// Those of another set.
    pub(crate) fn of_set(set: u32, count: u32) -> Self {
        Self { first: 0, count, is_part: false, set }
    }

    /// Whether they are all of a pixel, in several groups.
    pub(crate) fn needs_attempts(self) -> bool {
        !self.is_part && self.count as usize > BATCH
    }

    /// The number after the last one.
    pub(crate) fn end(self) -> u32 {
        self.first + self.count
    }

    /// The share of its pixel over which textures are averaged for each sample.
    pub(super) fn share(self) -> f64 {
        if self.set == 0 { 1.0 / f64::from(self.end()) } else { SHARE_OF_SET }
    }
}

/// The media around the eye, if all rays start there.
pub(crate) fn eye_media<L: Lanes>(s: L::Simd, world: &World<L::Real>) -> Vec<Medium<L::Real>> {
    if !world.has_media() || !world.shared_eye {
        return Vec::new();
    }
    let eye = world.camera.primary(s, L::lit(s, 0.0), L::lit(s, 0.0)).origin.lane(0);
    media_at::<L>(s, world, eye, None)
}
