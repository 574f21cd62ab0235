//! Rays that are deferred until their pixel needs them, in the order they came.
//!
//! A pixel defers a limited number. What is beyond is omitted and adds to the pixel's bound, so the bound stays one; and the
//! limit is each pixel's own, so it does not matter which pixels share a packet. Weights are kept by packet, since bounds are
//! summed from them again and again. The rest is kept ray by ray: most packets hold a few, and lanes without a ray would take
//! several times the memory.

use super::ray_packet::{RayKind, RayPacket};
use crate::lanes::{Ids, Lanes, MAX_LANES, V3, lanes_of};
use crate::shading::media::MediumList;
use std::collections::VecDeque;

/// Numbers of a ray besides its weight: origin, direction, start, and its distance from the eye.
const NUMBERS: usize = 8;

/// The deferred rays of a packet of pixels.
#[derive(Debug)]
pub(super) struct DeferredRays<L: Lanes> {
    packets: VecDeque<Packet<L>>,
    /// The rays of each packet, lane by lane.
    rays: VecDeque<Ray<L::Real>>,
    /// How many each pixel has here.
    counts: [u32; MAX_LANES],
    /// How many each pixel may have here.
    limit: u32,
}

/// What the rays of a packet share.
#[derive(Debug, Clone, Copy)]
struct Packet<L> {
    weight: V3<L>,
    lanes: u32,
    depth: u32,
    path: u32,
    dispersed: u32,
    parent: u32,
    sample: u32,
    kind: RayKind,
}

#[derive(Debug, Clone, Copy)]
struct Ray<R> {
    numbers: [R; NUMBERS],
    media: MediumList,
}

/// A packet of deferred rays.
#[derive(Debug, Clone, Copy)]
pub(super) struct Deferred<L: Lanes> {
    pub(super) rays: RayPacket<L>,
    /// Their distance from the eye, for their cones.
    pub(super) distance: L,
    /// Their sample.
    pub(super) sample: u32,
}

impl<L: Lanes> Default for DeferredRays<L> {
    fn default() -> Self {
        Self { packets: VecDeque::new(), rays: VecDeque::new(), counts: [0; MAX_LANES], limit: 0 }
    }
}

impl<L: Lanes> DeferredRays<L> {
    /// Forgets them, and begins with other pixels.
    pub(super) fn begin(&mut self, limit: u32) {
        self.clear();
        self.limit = limit;
    }

    /// Forgets them.
    pub(super) fn clear(&mut self) {
        self.packets.clear();
        self.rays.clear();
        self.counts = [0; MAX_LANES];
    }

    /// Whether there are none.
    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.packets.is_empty()
    }

    /// Number of packets.
    pub(super) fn len(&self) -> usize {
        self.packets.len()
    }

    /// The lanes of `lanes` whose pixels may defer another ray.
    #[inline(always)]
    pub(super) fn with_room(&self, lanes: u32) -> u32 {
        if self.rays.len() < self.limit as usize {
            return lanes;
        }
        lanes_of(lanes).filter(|lane| self.counts[*lane] < self.limit).fold(0, |room, lane| room | 1 << lane)
    }

    /// Adds rays behind the others.
    #[inline(always)]
    pub(super) fn push(&mut self, deferred: &Deferred<L>) {
        let Deferred { rays, distance, sample } = *deferred;
        let RayPacket { active: lanes, depth, kind, path, dispersed, parent, .. } = rays;
        if lanes == 0 {
            return;
        }
        self.packets.push_back(Packet { weight: rays.weight, lanes, depth, path, dispersed, parent, sample, kind });
        let V3 { x, y, z } = rays.origin;
        let mut numbers = [[L::Real::default(); MAX_LANES]; NUMBERS];
        let all = [x, y, z, rays.dir.x, rays.dir.y, rays.dir.z, rays.t_min, distance];
        for (to, from) in numbers.iter_mut().zip(all) {
            from.store(to);
        }
        for lane in lanes_of(lanes) {
            let numbers = std::array::from_fn(|i| numbers[i][lane]);
            self.rays.push_back(Ray { numbers, media: rays.media.lane(lane) as MediumList });
            self.counts[lane] += 1;
        }
    }

    /// Takes the first packet out.
    #[inline(always)]
    pub(super) fn pop(&mut self, s: L::Simd) -> Option<Deferred<L>> {
        let Packet { weight, lanes, depth, path, dispersed, parent, sample, kind } = self.packets.pop_front()?;
        // Lanes without a ray get the numbers of one.
        let first = *self.rays.front()?;
        let mut numbers = first.numbers.map(|number| [number; MAX_LANES]);
        let mut media = [first.media; MAX_LANES];
        for lane in lanes_of(lanes) {
            let ray = self.rays.pop_front()?;
            for (to, from) in numbers.iter_mut().zip(ray.numbers) {
                to[lane] = from;
            }
            media[lane] = ray.media;
            self.counts[lane] -= 1;
        }
        let [ox, oy, oz, dx, dy, dz, t_min, distance] = &numbers;
        let rays = RayPacket {
            origin: V3 { x: L::load(s, ox), y: L::load(s, oy), z: L::load(s, oz) },
            dir: V3 { x: L::load(s, dx), y: L::load(s, dy), z: L::load(s, dz) },
            t_min: L::load(s, t_min),
            weight,
            active: lanes,
            media: L::Ids::from_fn(s, |lane| u64::from(media[lane])),
            depth,
            kind,
            path,
            dispersed,
            parent,
        };
        Some(Deferred { rays, distance: L::load(s, distance), sample })
    }

    /// Lanes, weights and depth of each packet.
    #[inline(always)]
    pub(super) fn weights(&self) -> impl Iterator<Item = (u32, V3<L>, u32)> {
        self.packets.iter().map(|packet| (packet.lanes, packet.weight, packet.depth))
    }

    /// The media of every ray.
    pub(super) fn media(&mut self) -> impl Iterator<Item = &mut MediumList> {
        self.rays.iter_mut().map(|ray| &mut ray.media)
    }
}
