//! What was left out of a pixel, and the proof that it does not matter.
//!
//! All radiance is 0 or more, so with the sum of what was traced, lo, the pixel of recursion without end lies in
//! [lo, lo + R]: R adds up weight times [`Ceiling`](crate::bound::ceiling::Ceiling) over the rays that were not followed, and
//! what lights could have added that were not asked for. Since sRGB codes grow with light, the pixel's code lies between
//! those of both ends.
//!
//! To prove a pixel, rays that matter little (w U < tau) are put aside at first. Where the two codes are too far apart then,
//! those rays are followed after all, the heavier ones first, until the codes agree.

use super::hits::Hits;
use super::kernel::{Followed, Tracer};
use super::observer::{NotFollowed, Observer};
use super::pixel::Samples;
use super::sampling::{Sampler, shifts};
use crate::bound::interval::{allowed_raise, interval};
use crate::film::srgb::Codes8;
use crate::lanes::{Lanes, MAX_LANES, Mask, Real, V3, lanes_of};
use crate::scene::world::Pruning;
use crate::trace::variants::Effects;

/// w U below which rays are put aside at first, for a pixel that may be 0, 1 or 2 codes off. These numbers and the next ones
/// take the fewest rays over the scenes of the repository.
const FIRST: [f64; 3] = [1e-3, 1e-2, 2e-2];
/// How much all lights together may add that are not asked for.
const DARK: [f64; 3] = [1e-5, 1.2e-3, 2.4e-3];
/// From one round to the next, rays matter that weigh so much less.
const FINER: f64 = 0.75;
/// Rounds until a pixel is given up: 0.75^80 is 1e-10.
const ROUNDS: u32 = 80;

/// w U below which rays are left out of pixels that rounding keeps from being proved.
const STRAIGHT: f64 = 1e-9;

/// What proving a packet of pixels needs to know.
#[derive(Debug)]
pub(super) struct Certificate<L: Lanes> {
    /// R so far, without the rays put aside.
    rest: V3<L>,
    /// Part of R that comes from lights that were not asked for.
    dark: L,
    /// Largest `dark`.
    dark_limit: L,
    /// Rays put aside.
    aside: Vec<Aside<L>>,
    /// Those of the round before.
    waiting: Vec<Aside<L>>,
    /// Rays of the pixel, for the rounding of its sum.
    rays: L,
    /// Lanes that are not proved.
    open: u32,
    /// Rounds so far.
    rounds: u32,
    /// Whether rays are left out for good instead of being put aside.
    straight: bool,
    /// Columns and rows of the pixels.
    corners: [[u32; MAX_LANES]; 2],
    /// The batch of samples at hand.
    pub(super) batch: u32,
    /// The sample at hand.
    sample: u32,
}

/// Rays put aside.
#[derive(Debug, Clone, Copy)]
struct Aside<L: Lanes> {
    rays: Followed<L>,
    /// How far they have come, for their cones.
    come: L,
    /// Their sample.
    sample: u32,
}

impl<L: Lanes> Certificate<L> {
    pub(super) fn new(s: L::Simd) -> Self {
        let zero = L::lit(s, 0.0);
        Self {
            rest: V3 { x: zero, y: zero, z: zero },
            dark: zero,
            dark_limit: zero,
            aside: Vec::new(),
            waiting: Vec::new(),
            rays: zero,
            open: 0,
            rounds: 0,
            straight: false,
            corners: [[0; MAX_LANES]; 2],
            batch: 0,
            sample: 0,
        }
    }

    /// Columns or rows of samples of a batch, which are shifted by multiples of 2^-32 of a pixel.
    #[inline(never)]
    fn shift(&self, axis: usize, offset: f64, at: &mut [L::Real; MAX_LANES]) {
        let shifts = shifts(&self.corners, self.batch, axis);
        for lane in 0..L::COUNT {
            let within = offset + f64::from(shifts[lane]) / 4_294_967_296.0;
            at[lane] = L::Real::from_f64(f64::from(self.corners[axis][lane]) + within - within.floor());
        }
    }
}

impl<L: Lanes, O: Observer<L>, E: Effects> Tracer<'_, L, O, E> {
    /// Begins with a packet of pixels of so many samples each.
    #[inline(always)]
    pub(crate) fn begin(&mut self, pixels: &[[u32; 2]], samples: Samples) {
        let s = self.s;
        let zero = L::lit(s, 0.0);
        let share = 1.0 / f64::from(samples.count);
        let (least, dark) = match self.pruning {
            Pruning::Weight(min_weight) => (min_weight, 0.0),
            Pruning::Proved { max_codes } => {
                let codes = usize::from(max_codes.min(2));
                (FIRST[codes], DARK[codes])
            }
        };
        self.min_weight = L::lit(s, share * least);
        self.certificate.rest = V3 { x: zero, y: zero, z: zero };
        self.certificate.dark = zero;
        self.certificate.dark_limit = L::lit(s, dark);
        self.certificate.rays = zero;
        for (lane, [x, y]) in pixels.iter().enumerate() {
            (self.certificate.corners[0][lane], self.certificate.corners[1][lane]) = (*x, *y);
        }
        self.certificate.batch = samples.batch;
        self.certificate.open = u32::MAX;
        self.certificate.rounds = 0;
        self.certificate.straight = false;
        self.certificate.aside.clear();
        self.certificate.waiting.clear();
        self.media.clear();
        self.followed = zero;
    }

    /// Columns or rows of samples, so far from the corner of each pixel.
    #[inline(always)]
    pub(crate) fn coordinates(&self, axis: usize, offset: f64) -> L {
        let certificate = &self.certificate;
        let mut at = [L::Real::default(); MAX_LANES];
        if certificate.batch == 0 {
            for lane in 0..L::COUNT {
                at[lane] = L::Real::from_f64(f64::from(certificate.corners[axis][lane]) + offset);
            }
        } else {
            certificate.shift(axis, offset, &mut at);
        }
        L::load(self.s, &at)
    }

    /// Begins with a sample.
    #[inline(always)]
    pub(crate) fn choose(&mut self, index: u32) {
        self.certificate.sample = index;
        self.end_of_round();
        if E::DETAILS {
            self.sampler = Sampler::new(&self.certificate.corners, self.certificate.batch, index);
        }
    }

    /// R: how much each pixel of the packet may lack.
    #[inline(always)]
    pub(crate) fn rest(&self) -> V3<L> {
        self.certificate.rest
    }

    /// The lanes of which something was left out.
    #[inline(always)]
    pub(crate) fn lacking(&self) -> u32 {
        let rest = self.certificate.rest;
        rest.x.max(rest.y).max(rest.z).gt(L::lit(self.s, 0.0)).bits()
    }

    /// The most that rays of a depth bring which have a weight.
    #[inline(always)]
    fn most(&self, weight: V3<L>, depth: u32) -> V3<L> {
        let ceiling = self.world.ceiling.of((self.world.rules.max_depth + 1).saturating_sub(depth));
        weight.times(V3::splat(self.s, ceiling.map(L::Real::from_f64)))
    }

    /// Rays of some lanes are not followed.
    #[inline(always)]
    pub(super) fn leave_out(&mut self, lanes: u32, weight: V3<L>, depth: u32) {
        let most = self.most(weight, depth);
        self.lack(L::mask(self.s, lanes), most);
    }

    /// Some lanes lack radiance.
    #[inline(always)]
    pub(super) fn lack(&mut self, lanes: L::Mask, radiance: V3<L>) {
        let rest = self.certificate.rest;
        self.certificate.rest = V3::select(lanes, rest + radiance, rest);
    }

    /// The lanes whose rays matter enough to be followed now.
    #[inline(always)]
    pub(super) fn matter(&self, rays: &Followed<L>) -> u32 {
        let zero = L::lit(self.s, 0.0);
        let heaviest = |v: V3<L>| v.x.max(v.y).max(v.z);
        let there = heaviest(rays.weight).gt(zero);
        let enough = match self.pruning {
            Pruning::Weight(_) => heaviest(rays.weight),
            Pruning::Proved { .. } => heaviest(self.most(rays.weight, rays.depth)),
        };
        (enough.ge(self.min_weight) & there).bits() & rays.active
    }

    /// Puts rays of some lanes aside, or leaves them out where nothing is to be proved.
    #[inline(never)]
    pub(super) fn put_aside(&mut self, rays: &Followed<L>, lanes: u32) {
        L::vectorize(
            self.s,
            #[inline(always)]
            || match self.pruning {
                Pruning::Proved { .. } if !self.certificate.straight => {
                    let come = if E::DETAILS { self.cones.end } else { L::lit(self.s, 0.0) };
                    let rays = Followed { active: lanes, ..*rays };
                    self.certificate.aside.push(Aside { rays, come, sample: self.certificate.sample });
                }
                _ => self.give_up(rays, lanes),
            },
        );
    }

    /// Whether lights that would add this much to the lanes of `lit` need not be asked for; what they lack is noted.
    #[inline(always)]
    pub(super) fn stays_dark(&mut self, lit: L::Mask, added: V3<L>) -> L::Mask {
        let dark = self.certificate.dark + added.x.max(added.y).max(added.z);
        let little = lit & dark.le(self.certificate.dark_limit);
        self.certificate.dark = L::select(little, dark, self.certificate.dark);
        little
    }

    /// Stacks the next rays to follow for the pixels of `active` that are not proved, of those put aside. Returns whether
    /// there are any; not if all pixels are proved, or cannot be.
    #[inline(always)]
    pub(crate) fn prove(&mut self, active: u32, hits: &mut Hits<L>, sum: &V3<L>) -> bool {
        let Pruning::Proved { max_codes } = self.pruning else { return false };
        let certificate = &self.certificate;
        if certificate.aside.is_empty() && certificate.waiting.is_empty() && self.lacking() & active == 0 {
            self.end_of_round();
            self.certificate.open = 0;
            return false;
        }
        self.prove_within(max_codes, active, hits, sum)
    }

    #[inline(never)]
    fn prove_within(&mut self, max_codes: u8, active: u32, hits: &mut Hits<L>, sum: &V3<L>) -> bool {
        L::vectorize(
            self.s,
            #[inline(always)]
            || self.next_round(max_codes, active, hits, sum),
        )
    }

    #[inline(always)]
    fn next_round(&mut self, max_codes: u8, active: u32, hits: &mut Hits<L>, sum: &V3<L>) -> bool {
        loop {
            while let Some(Aside { mut rays, come, sample }) = self.certificate.waiting.pop() {
                let open = self.certificate.open;
                self.give_up(&rays, rays.active & !open);
                rays.active &= open;
                if rays.active != 0 {
                    self.resume(sample, hits);
                    if E::DETAILS {
                        self.cones.end = come;
                    }
                    self.push(rays);
                    if !self.stack.is_empty() {
                        return true;
                    }
                }
            }
            self.end_of_round();
            let open = self.open(active & self.certificate.open, max_codes, sum);
            self.certificate.open = open;
            let certificate = &mut self.certificate;
            if open == 0 || certificate.aside.is_empty() || certificate.rounds == ROUNDS {
                return false;
            }
            certificate.rounds += 1;
            self.min_weight = self.min_weight * L::lit(self.s, FINER);
            std::mem::swap(&mut certificate.waiting, &mut certificate.aside);
            // The first that was put aside comes first.
            certificate.waiting.reverse();
        }
    }

    /// Counts the rays since the last sample or round.
    #[inline(always)]
    fn end_of_round(&mut self) {
        self.certificate.rays = self.certificate.rays + self.followed;
        self.followed = L::lit(self.s, 0.0);
    }

    /// The lanes that are not proved to be the same.
    #[inline(always)]
    fn unproved(&self, among: u32, sum: &V3<L>) -> u32 {
        let (codes, rest, roundings) = (Codes8::get(), self.certificate.rest, self.roundings());
        let mut unproved = 0;
        for lane in lanes_of(among) {
            let ends = interval(sum.lane(lane), rest.lane(lane), roundings.lane(lane));
            if ends.iter().any(|[low, high]| codes.code(*low) != codes.code(*high)) {
                unproved |= 1 << lane;
            }
        }
        unproved
    }

    /// Leaves out what is still aside. If lanes are not proved because of lights that were not asked for, it begins again with
    /// these lanes, which it returns, and will ask every light.
    #[inline(always)]
    pub(crate) fn finish(&mut self, active: u32, sum: &mut V3<L>) -> u32 {
        let proves = matches!(self.pruning, Pruning::Proved { .. });
        if !proves || (self.certificate.aside.is_empty() && self.lacking() & active == 0) {
            return 0;
        }
        self.leave_out_rest(active, sum)
    }

    #[inline(never)]
    fn leave_out_rest(&mut self, active: u32, sum: &mut V3<L>) -> u32 {
        L::vectorize(
            self.s,
            #[inline(always)]
            || self.leave_out_rest_in(active, sum),
        )
    }

    #[inline(always)]
    fn leave_out_rest_in(&mut self, active: u32, sum: &mut V3<L>) -> u32 {
        let s = self.s;
        let mut left = std::mem::take(&mut self.certificate.aside);
        for aside in left.drain(..) {
            self.give_up(&aside.rays, aside.rays.active);
        }
        self.certificate.aside = left;
        let zero = L::lit(s, 0.0);
        let again = match self.pruning {
            // What more rays cannot prove, since rounding alone may change a code, is traced in the order of recursion
            // without end: with the same roundings.
            Pruning::Proved { max_codes: 0 } if !self.certificate.straight => {
                self.certificate.straight = true;
                self.min_weight = self.share * L::lit(s, STRAIGHT);
                self.unproved(active, sum)
            }
            _ => self.certificate.open & self.certificate.dark.gt(zero).bits(),
        };
        if again == 0 {
            return 0;
        }
        if O::WATCHING {
            self.observer.again();
        }
        let certificate = &mut self.certificate;
        let black = V3 { x: zero, y: zero, z: zero };
        let mask = L::mask(s, again);
        *sum = V3::select(mask, black, *sum);
        certificate.rest = V3::select(mask, black, certificate.rest);
        certificate.dark = L::select(mask, zero, certificate.dark);
        certificate.rays = L::select(mask, zero, certificate.rays);
        certificate.dark_limit = zero;
        certificate.rounds = 0;
        again
    }

    #[inline(always)]
    fn give_up(&mut self, rays: &Followed<L>, lanes: u32) {
        if lanes != 0 {
            self.leave_out(lanes, rays.weight, rays.depth);
            if O::WATCHING {
                self.observer.not_followed(rays.parent, rays.kind, rays.weight, NotFollowed::Weight);
            }
        }
    }

    /// Goes back to a sample.
    #[inline(always)]
    fn resume(&mut self, sample: u32, hits: &mut Hits<L>) {
        if sample != self.certificate.sample {
            self.certificate.sample = sample;
            if E::DETAILS {
                self.sampler = Sampler::new(&self.certificate.corners, self.certificate.batch, sample);
            }
            self.make_choices(hits);
        }
    }

    /// The lanes of `among` that may be more than `max_codes` off, and of which following more rays can tell more.
    #[inline(always)]
    fn open(&self, among: u32, max_codes: u8, sum: &V3<L>) -> u32 {
        let s = self.s;
        let mut rest = self.certificate.rest;
        for aside in &self.certificate.aside {
            let most = self.most(aside.rays.weight, aside.rays.depth);
            rest = V3::select(L::mask(s, aside.rays.active), rest + most, rest);
        }
        let lacking = rest.x.max(rest.y).max(rest.z).gt(L::lit(s, 0.0)).bits() & among;
        if lacking == 0 {
            return 0;
        }
        let roundings = self.roundings();
        let mut open = 0;
        for lane in lanes_of(lacking) {
            let (sum, rest, rounding) = (sum.lane(lane), rest.lane(lane), roundings.lane(lane));
            let ends = interval(sum, rest, rounding);
            let further = (0..3).any(|c| {
                let [low, high] = ends[c];
                let codes = Codes8::get();
                let proved = codes.code(high) - codes.code(low) <= max_codes + allowed_raise(low, max_codes);
                // Where rounding alone may change a code, more rays do not tell.
                !proved && rest[c].to_f64() > 0.5 * rounding.to_f64() * sum[c].to_f64()
            });
            if further {
                open |= 1 << lane;
            }
        }
        open
    }

    /// How far the sum of a pixel may be off, relative to it: each of its terms may have been rounded, in it and in the sum
    /// of recursion without end.
    #[inline(always)]
    pub(crate) fn roundings(&self) -> L {
        let s = self.s;
        let terms = 1.0 + self.world.lights.len() as f64;
        (self.certificate.rays + L::lit(s, 2.0)) * L::lit(s, 2.0 * terms * L::Real::ROUNDOFF)
    }

    /// Whether a chain keeps so much of its weight that it would go on without end.
    #[inline(always)]
    pub(super) fn endless(&self, rays: &Followed<L>) -> u32 {
        if rays.depth < 64 || !rays.depth.is_power_of_two() || self.pruning == Pruning::Weight(0.0) {
            return 0;
        }
        match self.pruning {
            Pruning::Weight(_) => 0,
            Pruning::Proved { .. } => {
                let kept = L::lit(self.s, crate::math::pow(0.99, f64::from(rays.depth)));
                let weight = rays.weight.x.max(rays.weight.y).max(rays.weight.z);
                weight.gt(kept * self.share).bits() & rays.active
            }
        }
    }
}
