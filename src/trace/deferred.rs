//! Rays that are deferred until their sample needs them, in the order they came.
//!
//! A sample defers a limited number. What is beyond is omitted and adds to the sample's bound, so the bound stays one; and the
//! limit is each sample's own, so it does not matter which samples share a packet. Weights are kept by packet, since bounds are
//! summed from them again and again. Of the rest, lanes without a ray are left out: they could take several times the memory.

use super::ray_cones::Cones;
use super::ray_packet::{RayKind, RayPacket};
use crate::lanes::{Lanes, MAX_LANES, V3, lanes_of};
use std::collections::VecDeque;

/// Numbers of a ray besides its weight: origin, direction, start, and its cone with the density of its direction.
const NUMBERS: usize = 10;
/// Numbers of a packet.
const BLOCK: usize = NUMBERS * MAX_LANES;

/// The deferred rays of a packet of samples.
#[derive(Debug)]
pub(super) struct DeferredRays<L: Lanes> {
    packets: VecDeque<Packet<L>>,
    /// The numbers of each packet's rays: the first of all its rays, the second of all, and so on.
    numbers: VecDeque<L::Real>,
    /// How many each sample has here.
    counts: [u32; MAX_LANES],
    /// How many each sample may have here.
    limit: u32,
}

/// What the rays of a packet share.
#[derive(Debug, Clone, Copy)]
struct Packet<L: Lanes> {
    weight: V3<L>,
    media: L::Ids,
    lanes: u32,
    depth: u32,
    path: u32,
    dispersed: u32,
    parent: u32,
    kind: RayKind,
    straight: bool,
    gathered: bool,
}

/// A packet of deferred rays.
#[derive(Debug, Clone, Copy)]
pub(super) struct Deferred<L: Lanes> {
    pub(super) rays: RayPacket<L>,
    /// Their cones.
    pub(super) cones: Cones<L>,
}

impl<L: Lanes> Default for DeferredRays<L> {
    fn default() -> Self {
        Self { packets: VecDeque::new(), numbers: VecDeque::new(), counts: [0; MAX_LANES], limit: 0 }
    }
}

impl<L: Lanes> DeferredRays<L> {
    /// Forgets them, and begins with other samples.
    pub(super) fn begin(&mut self, limit: u32) {
        self.clear();
        self.limit = limit;
    }

    /// Forgets them.
    pub(super) fn clear(&mut self) {
        if !self.is_empty() {
            self.packets.clear();
            self.numbers.clear();
            self.counts = [0; MAX_LANES];
        }
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

    /// The lanes of `lanes` whose samples may defer another ray.
    #[inline(always)]
    pub(super) fn with_room(&self, lanes: u32) -> u32 {
        if self.packets.len() < self.limit as usize {
            return lanes;
        }
        lanes_of(lanes).filter(|lane| self.counts[*lane] < self.limit).fold(0, |room, lane| room | 1 << lane)
    }

    /// How many rays a lane's sample has deferred.
    pub(super) fn count(&self, lane: usize) -> u32 {
        self.counts[lane]
    }

    /// Adds rays behind the others.
    #[inline(always)]
    pub(super) fn push(&mut self, deferred: &Deferred<L>) {
        let Deferred { rays, cones: [width, spread, density] } = *deferred;
        let RayPacket { active: lanes, depth, kind, straight, gathered, path, dispersed, parent, .. } = rays;
        if lanes == 0 {
            return;
        }
        let (weight, media) = (rays.weight, rays.media);
        self.packets.push_back(Packet {
            weight,
            media,
            lanes,
            depth,
            path,
            dispersed,
            parent,
            kind,
            straight,
            gathered,
        });
        let (origin, dir) = (rays.origin, rays.dir);
        let mut block = [L::Real::default(); BLOCK];
        let mut end = 0;
        for number in [origin.x, origin.y, origin.z, dir.x, dir.y, dir.z, rays.t_min, width, spread, density] {
            number.store(&mut block[end..]);
            if lanes == L::ALL {
                end += L::COUNT;
                continue;
            }
            let begin = end;
            for lane in lanes_of(lanes) {
                block[end] = block[begin + lane];
                end += 1;
            }
        }
        self.numbers.extend(&block[..end]);
        lanes_of(lanes).for_each(|lane| self.counts[lane] += 1);
    }

    /// Lanes, weights and depth of the first packet, and whether nothing has reflected it.
    #[inline(always)]
    pub(super) fn front(&self) -> Option<(u32, V3<L>, u32, bool)> {
        self.packets.front().map(|packet| (packet.lanes, packet.weight, packet.depth, packet.straight))
    }

    /// Puts the first packet behind the others.
    #[inline(always)]
    pub(super) fn put_back(&mut self) {
        if let Some(packet) = self.packets.pop_front() {
            self.numbers.rotate_left(NUMBERS * packet.lanes.count_ones() as usize);
            self.packets.push_back(packet);
        }
    }

    /// Takes the first packet out.
    #[inline(always)]
    pub(super) fn pop(&mut self, s: L::Simd) -> Option<Deferred<L>> {
        let Packet { weight, media, lanes, depth, path, dispersed, parent, kind, straight, gathered } =
            self.packets.pop_front()?;
        lanes_of(lanes).for_each(|lane| self.counts[lane] -= 1);
        let rays = lanes.count_ones() as usize;
        let mut block = [L::Real::default(); BLOCK];
        let (front, back) = self.numbers.as_slices();
        let in_front = front.len().min(NUMBERS * rays);
        block[..in_front].copy_from_slice(&front[..in_front]);
        block[in_front..NUMBERS * rays].copy_from_slice(&back[..NUMBERS * rays - in_front]);
        self.numbers.drain(..NUMBERS * rays);
        // Not by `from_fn`, whose closure is compiled for SSE2 in arrays as long as this.
        let mut loaded = [L::lit(s, 0.0); NUMBERS];
        for (i, number) in loaded.iter_mut().enumerate() {
            let numbers = &block[i * rays..];
            *number = if lanes == L::ALL {
                L::load(s, numbers)
            } else {
                // Lanes without a ray get the numbers of one.
                let mut spread = [numbers[0]; MAX_LANES];
                lanes_of(lanes).zip(numbers).for_each(|(lane, number)| spread[lane] = *number);
                L::load(s, &spread)
            };
        }
        let [ox, oy, oz, dx, dy, dz, t_min, width, spread, density] = loaded;
        let rays = RayPacket {
            origin: V3 { x: ox, y: oy, z: oz },
            dir: V3 { x: dx, y: dy, z: dz },
            t_min,
            weight,
            active: lanes,
            media,
            depth,
            kind,
            straight,
            gathered,
            path,
            dispersed,
            parent,
        };
        Some(Deferred { rays, cones: [width, spread, density] })
    }

    /// Lanes, weights and depth of each packet.
    #[inline(always)]
    pub(super) fn weights(&self) -> impl Iterator<Item = (u32, V3<L>, u32)> {
        self.packets.iter().map(|packet| (packet.lanes, packet.weight, packet.depth))
    }

    /// The same of those that nothing has reflected.
    pub(super) fn weights_of_straight(&self) -> impl Iterator<Item = (u32, V3<L>, u32)> {
        self.packets.iter().filter(|packet| packet.straight).map(|packet| (packet.lanes, packet.weight, packet.depth))
    }

    /// Lanes and media of each packet.
    pub(super) fn media(&mut self) -> impl Iterator<Item = (u32, &mut L::Ids)> {
        self.packets.iter_mut().map(|packet| (packet.lanes, &mut packet.media))
    }
}
