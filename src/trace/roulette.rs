//! Russian roulette (Arvo and Kirk, Particle Transport and Image Synthesis, 1990), where light is traced between surfaces that scatter,
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

    /// Decides which of the rays are followed.
    #[inline(never)]
    fn play(&mut self, rays: &mut RayPacket<L>) {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                let s = self.s;
                let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
                let Roulette { arriving, number, taken, .. } = self.roulette;
                let part = |of: L, all: L| L::select(all.gt(zero), of / all, zero);
                let w = rays.weight;
                let share = part(w.x, arriving.x).max(part(w.y, arriving.y)).max(part(w.z, arriving.z)).min(one);
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
