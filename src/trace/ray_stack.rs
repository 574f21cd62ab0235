//! The stack of rays that wait to be followed, and which rays get onto it.

use super::kernel::Tracer;
use super::observer::{NotFollowed, Observer};
use super::ray_packet::{RayKind, RayPacket};
use super::variants::Variant;
use crate::lanes::{Ids, Lanes, Mask, V3};
use crate::shading::media::{MediumList, OUTSIDE};

/// Largest weight of a ray, so that nothing overflows in single precision. Only materials with r_s + r_t above 1, of which a
/// warning tells, come near.
const MAX_WEIGHT: f64 = 1e9;

impl<L: Lanes, O: Observer<L>, V: Variant> Tracer<'_, L, O, V> {
    /// Makes `rays` those on top of the stack; false if there are none.
    #[inline(always)]
    pub(crate) fn pop(&mut self, rays: &mut RayPacket<L>) -> bool {
        let Some(next) = self.stack.pop() else { return false };
        *rays = next;
        if V::FOOTPRINTS {
            self.cones.pop();
        }
        if V::SECONDARY && self.media.is_crowded() {
            self.forget_media(rays);
        }
        true
    }

    /// Forgets the lists of media that neither `next` nor any ray that waits needs.
    #[inline(never)]
    fn forget_media(&mut self, next: &mut RayPacket<L>) {
        let (s, stack) = (self.s, &mut self.stack);
        let deferred = self.certificate.deferred.media().chain(self.proof.waiting_media());
        L::vectorize(
            s,
            #[inline(always)]
            || {
                let mut kept = self.media.compact();
                let waiting = stack.iter_mut().chain([next]).map(|packet| (packet.active, &mut packet.media));
                for (active, media) in waiting.chain(deferred) {
                    let lists = *media;
                    *media = L::Ids::from_fn(s, |lane| match active & (1 << lane) {
                        0 => u64::from(OUTSIDE),
                        _ => u64::from(kept.keep(lists.lane(lane) as MediumList)),
                    });
                }
            },
        );
    }

    /// Stacks rays. Rays of too little weight are deferred or omitted; rays beyond the limit are dropped.
    #[inline(always)]
    pub(super) fn push(&mut self, mut rays: RayPacket<L>) {
        let max = L::lit(self.s, MAX_WEIGHT);
        let w = rays.weight;
        rays.weight = V3 { x: w.x.min(max), y: w.y.min(max), z: w.z.min(max) };
        if !self.world.rules.spd_counts {
            let significant = self.significant(rays.weight, rays.depth, rays.straight) & rays.active;
            let light = rays.active & !significant;
            if light != 0 {
                self.defer(&rays, light);
            }
            rays.active = significant;
        }
        let active = L::mask(self.s, rays.active);
        self.followed = L::select(active, self.followed + L::lit(self.s, 1.0), self.followed);
        let beyond = (active & self.followed.ge(self.certificate.most_followed)).bits();
        let never_ending = self.never_ending(&rays);
        if beyond | never_ending != 0 {
            self.drop_rays(&mut rays, beyond, never_ending);
        }
        if rays.active != 0 {
            let count = u64::from(rays.active.count_ones());
            self.counts.deepest = self.counts.deepest.max(rays.depth);
            match rays.kind {
                RayKind::Camera => self.counts.camera += count,
                RayKind::Reflected => self.counts.reflected += count,
                RayKind::Transmitted => self.counts.transmitted += count,
                RayKind::Gathered => self.counts.gathered += count,
            }
            self.count_lanes(rays.active, rays.depth);
            self.stack.push(rays);
            if V::FOOTPRINTS {
                self.cones.push();
            }
        }
    }

    /// Leaves out rays whose chains would never end, and rays beyond a limit if they do not get more room.
    #[inline(never)]
    fn drop_rays(&mut self, rays: &mut RayPacket<L>, beyond: u32, never_ending: u32) {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                let lanes = never_ending | self.beyond_limit(rays, beyond & !never_ending);
                rays.active &= !lanes;
                self.counts.dropped += u64::from(lanes.count_ones());
                self.record_omitted_rays(lanes, rays.weight, rays.depth, rays.straight);
                if O::WATCHING && lanes != 0 {
                    self.observer.not_followed(rays.parent, rays.kind, rays.weight, NotFollowed::Budget);
                }
            },
        );
    }
}
