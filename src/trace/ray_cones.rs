//! Ray cones: the width of the rays of a packet, from the cone of a pixel and the distance from the eye.
//!
//! They have a stack of their own beside that of the rays, so that variants without details do not carry them.

use super::hits::Hits;
use crate::camera::Cone;
use crate::lanes::{Lanes, MAX_LANES, Real, V3, lanes_of};
use crate::shading::texture::environment::Environment;
use glam::DVec3;

/// The cones of a packet's rays.
#[derive(Debug)]
pub(crate) struct RayCones<L> {
    /// The cone of a whole pixel.
    pixel: Cone,
    /// The cone of a sample, which is a part of a pixel.
    sample: Cone,
    /// Distance from the eye to where the current rays start.
    start: L,
    /// Distance from the eye to where the next rays start.
    pub(super) end: L,
    /// One `start` for each entry of the stack of rays.
    waiting: Vec<L>,
    /// Lanes whose shading normal bumps have tilted.
    pub(super) tilted: u32,
}

impl<L: Lanes> RayCones<L> {
    #[inline(always)]
    pub(super) fn new(s: L::Simd, pixel: Cone) -> Self {
        let zero = L::lit(s, 0.0);
        Self { pixel, sample: pixel, start: zero, end: zero, waiting: Vec::new(), tilted: 0 }
    }

    /// Starts at the eye, with a sample that has a given share of its pixel.
    #[inline(always)]
    pub(super) fn restart(&mut self, s: L::Simd, share: L) {
        let part = share.lane(0).to_f64().sqrt();
        self.sample = Cone { width: self.pixel.width * part, spread: self.pixel.spread * part };
        self.start = L::lit(s, 0.0);
        self.waiting.clear();
    }

    /// The current rays have hit something.
    #[inline(always)]
    pub(super) fn hit(&mut self, s: L::Simd, hits: &Hits<L>) {
        self.end = L::select(L::mask(s, hits.found), self.start + hits.t, self.start);
        self.tilted = 0;
    }

    /// Rays have been put on the stack.
    #[inline(always)]
    pub(super) fn push(&mut self) {
        self.waiting.push(self.end);
    }

    /// Rays have been taken from the stack.
    #[inline(always)]
    pub(super) fn pop(&mut self) {
        if let Some(start) = self.waiting.pop() {
            self.start = start;
        }
    }

    /// Where the next rays start; in `unseen` lanes the surface is invisible, and the current ray goes on.
    #[inline(always)]
    pub(super) fn unless(&self, unseen: L::Mask) -> L {
        L::select(unseen, self.start, self.end)
    }

    /// Widths of the rays where they hit.
    #[inline(always)]
    pub(super) fn widths(&self, s: L::Simd) -> L {
        L::lit(s, self.sample.width) + L::lit(s, self.sample.spread) * self.end
    }

    /// Angle of the cones.
    pub(super) fn spread(&self) -> f64 {
        self.sample.spread
    }
}

/// The environment map in the directions of some lanes, over cones of an angle.
pub(super) fn around<L: Lanes>(s: L::Simd, environment: &Environment, dir: V3<L>, lanes: u32, spread: f64) -> V3<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || {
            let mut seen = [[L::Real::default(); 3]; MAX_LANES];
            for lane in lanes_of(lanes) {
                let dir = DVec3::from_array(dir.lane(lane).map(Real::to_f64));
                seen[lane] = environment.radiance(dir, spread).map(L::Real::from_f64);
            }
            V3::from_fn(s, |lane| seen[lane])
        },
    )
}
