//! Rays that are deferred until their pixel needs them, in the order they came.
//!
//! A pixel defers a limited number. What is beyond is omitted and adds to the pixel's bound, so the bound stays one; and the
//! limit is each pixel's own, so it does not matter which pixels share a packet. Rays are kept one by one: most packets hold a
//! few, and lanes without a ray would take ten times the memory.

use super::ray_packet::{RayKind, RayPacket};
use crate::lanes::{Ids, Lanes, MAX_LANES, V3, lanes_of};
use crate::shading::media::MediumList;
use std::collections::VecDeque;

/// Numbers of a ray: origin, direction, start, weight, and its distance from the eye.
const NUMBERS: usize = 11;

/// The deferred rays of a packet of pixels.
#[derive(Debug)]
pub(super) struct DeferredRays<R> {
    packets: VecDeque<Packet>,
    /// The rays of each packet, lane by lane.
    rays: VecDeque<Ray<R>>,
    /// How many each pixel has here.
    counts: [u32; MAX_LANES],
    /// How many each pixel may have here.
    limit: u32,
}

/// What the rays of a packet share.
#[derive(Debug, Clone, Copy)]
struct Packet {
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

impl<R> Default for DeferredRays<R> {
    fn default() -> Self {
        Self { packets: VecDeque::new(), rays: VecDeque::new(), counts: [0; MAX_LANES], limit: 0 }
    }
}

impl<R: Copy> DeferredRays<R> {
    /// Forgets them, and begins with other pixels.
    pub(super) fn clear(&mut self, limit: u32) {
        self.packets.clear();
        self.rays.clear();
        (self.counts, self.limit) = ([0; MAX_LANES], limit);
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
        lanes_of(lanes).filter(|lane| self.counts[*lane] < self.limit).fold(0, |room, lane| room | 1 << lane)
    }

    /// Adds rays behind the others.
    #[inline(always)]
    pub(super) fn push<L: Lanes<Real = R>>(&mut self, deferred: &Deferred<L>) {
        let Deferred { rays, distance, sample } = *deferred;
        let RayPacket { active: lanes, depth, kind, path, dispersed, parent, .. } = rays;
        if lanes == 0 {
            return;
        }
        self.packets.push_back(Packet { lanes, depth, path, dispersed, parent, sample, kind });
        let V3 { x, y, z } = rays.origin;
        let (dir, weight) = (rays.dir, rays.weight);
        let mut numbers = [[x.lane(0); MAX_LANES]; NUMBERS];
        let all = [x, y, z, dir.x, dir.y, dir.z, rays.t_min, weight.x, weight.y, weight.z, distance];
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
    pub(super) fn pop<L: Lanes<Real = R>>(&mut self, s: L::Simd) -> Option<Deferred<L>> {
        let Packet { lanes, depth, path, dispersed, parent, sample, kind } = self.packets.pop_front()?;
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
        let [ox, oy, oz, dx, dy, dz, t_min, wx, wy, wz, distance] = &numbers;
        let rays = RayPacket {
            origin: V3 { x: L::load(s, ox), y: L::load(s, oy), z: L::load(s, oz) },
            dir: V3 { x: L::load(s, dx), y: L::load(s, dy), z: L::load(s, dz) },
            t_min: L::load(s, t_min),
            weight: V3 { x: L::load(s, wx), y: L::load(s, wy), z: L::load(s, wz) },
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

    /// Lane, weight and depth of every ray.
    #[inline(always)]
    pub(super) fn weights(&self) -> impl Iterator<Item = (usize, [R; 3], u32)> {
        let lanes = self.packets.iter().flat_map(|packet| lanes_of(packet.lanes).map(|lane| (lane, packet.depth)));
        lanes
            .zip(&self.rays)
            .map(|((lane, depth), ray)| (lane, [ray.numbers[7], ray.numbers[8], ray.numbers[9]], depth))
    }

    /// The media of every ray.
    pub(super) fn media(&mut self) -> impl Iterator<Item = &mut MediumList> {
        self.rays.iter_mut().map(|ray| &mut ray.media)
    }
}
