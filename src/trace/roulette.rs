//! Russian roulette (Arvo and Kirk, Particle Transport and Image Synthesis, 1990), for global illumination between surfaces that scatter,
//! mirror and pass it: a ray has several children there, and a white room would have more rays than anybody can wait for.
//!
//! Beyond the first surface a child is followed as often as its share q of its parent's weight says, and then counts 1/q of it. In the
//! mean nothing changes. One number decides for all children, whose shares lie side by side: a ray has at most one child if its
//! surface sends on no more than comes, and no weight is above that of the parent in any channel, as ceilings need it. What the
//! camera sees straight on is one chain, and all of it is followed: alpha has no noise of it.

use super::facets::again;
use super::kernel::Tracer;
use super::observer::{NotFollowed, Observer};
use super::ray_packet::RayPacket;
use super::sampling::Choice;
use super::variants::Variant;
use crate::lanes::{Lanes, Mask, V3};

/// Length of the longest chains of which all rays are followed: from the eye, and from what it sees.
const WHOLE: u32 = 2;

/// The roulette of what the current rays have hit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Roulette<L> {
    /// The weights of the rays.
    arriving: V3<L>,
    /// The number in [0, 1) of each.
    number: L,
    /// The shares of children so far.
    taken: L,
    /// Whether there is one.
    is_on: bool,
}

impl<L: Lanes> Roulette<L> {
    /// None.
    #[inline(always)]
    pub(super) fn off(s: L::Simd) -> Self {
        let zero = L::lit(s, 0.0);
        Self { arriving: V3 { x: zero, y: zero, z: zero }, number: zero, taken: zero, is_on: false }
    }

    /// How often a child of this weight is followed.
    #[inline(always)]
    fn share_of(&self, s: L::Simd, weight: V3<L>) -> L {
        let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
        let V3 { x, y, z } = self.arriving;
        let part = |of: L, all: L| L::select(all.gt(zero), of / all, zero);
        part(weight.x, x).max(part(weight.y, y)).max(part(weight.z, z)).min(one)
    }
}

impl<L: Lanes, O: Observer<L>, V: Variant> Tracer<'_, L, O, V> {
    /// The current rays come to what they hit.
    #[inline(always)]
    pub(super) fn begin_roulette(&mut self, rays: &RayPacket<L>) {
        if self.world.branches {
            self.roulette.is_on = rays.depth >= WHOLE && !rays.straight;
            if self.roulette.is_on {
                self.draw(rays);
            }
        }
    }

    #[inline(never)]
    fn draw(&mut self, rays: &RayPacket<L>) {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                // The place in the tree repeats itself in chains of more than 16.
                let [number, _]: [L; 2] = self.sampler.square(self.s, again(rays.path, rays.depth), Choice::Roulette);
                self.roulette = Roulette { arriving: rays.weight, number, taken: L::lit(self.s, 0.0), is_on: true };
            },
        );
    }

    /// Stacks rays that leave from what the current rays hit.
    #[inline(always)]
    pub(super) fn send(&mut self, mut rays: RayPacket<L>) {
        if V::DETAILS && self.roulette.is_on {
            self.play(&mut rays);
        }
        self.push(rays);
    }

    /// Records rays that would leave from what the current rays hit, beyond the greatest depth.
    #[inline(always)]
    pub(super) fn omit_children(&mut self, lanes: u32, weight: V3<L>, depth: u32, straight: bool) {
        let most = if V::DETAILS && self.roulette.is_on { self.most_of_followed(lanes, weight) } else { weight };
        self.record_omitted_rays(lanes, most, depth, straight);
    }

    /// What children add at most to those that came before, whose weights are not above `weight`: who is followed may weigh as much as
    /// the parent, and of shares that are n in all at most n children are, rounded up.
    #[inline(never)]
    fn most_of_followed(&mut self, lanes: u32, weight: V3<L>) -> V3<L> {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                let s = self.s;
                let share = self.roulette.share_of(s, weight);
                let Roulette { arriving, taken, .. } = self.roulette;
                let all = taken + share;
                // Rounded up: -floor(-x).
                let followed = (-taken).floor() - (-all).floor();
                self.roulette.taken = L::select(L::mask(s, lanes), all, taken);
                let most = arriving * followed;
                // Those that are always followed keep their weight.
                let whole = V3::select(share.ge(L::lit(s, 1.0)), weight, most);
                V3 { x: most.x.max(whole.x), y: most.y.max(whole.y), z: most.z.max(whole.z) }
            },
        )
    }

    /// Decides which of the rays are followed.
    #[inline(never)]
    fn play(&mut self, rays: &mut RayPacket<L>) {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                let s = self.s;
                let one = L::lit(s, 1.0);
                let Roulette { number, taken, .. } = self.roulette;
                let w = rays.weight;
                let share = self.roulette.share_of(s, w);
                // Shares of more than all begin again, and have some numbers twice.
                let place = number - taken;
                let place = place - place.floor();
                let followed = place.lt(share);
                self.roulette.taken = L::select(L::mask(s, rays.active), taken + share, taken);
                if O::WATCHING && rays.active & !followed.bits() != 0 {
                    self.observer.not_followed(rays.parent, rays.kind, rays.weight, NotFollowed::Roulette);
                }
                rays.active &= followed.bits();
                rays.weight = V3::select(followed, w * (one / share), w);
            },
        );
    }
}
