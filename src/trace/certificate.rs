//! The certificate of a pixel: a bound on the light of all omitted rays, and the proof that it does not change the picture.
//!
//! All radiance is 0 or more. So with the sum lo of what was traced, the pixel of recursion without end lies in [lo, lo + R].
//! R is the sum over the omitted rays of weight times [`Ceiling`](crate::bound::ceiling::Ceiling), and of the most that
//! skipped lights could have added. Since sRGB codes grow with light, the pixel's code lies between those of both ends.
//!
//! To prove a pixel, rays of little weight (w U < tau) are deferred at first. While the two codes are too far apart, deferred
//! rays are followed after all, the heavier ones first. A pixel defers a limited number of rays (`deferred.rs`).

use super::deferred::{Deferred, DeferredRays};
use super::hits::Hits;
use super::kernel::Tracer;
use super::observer::{NotFollowed, Observer};
use super::pixel::Samples;
use super::ray_packet::RayPacket;
use super::sampling::{Sampler, shifts};
use crate::bound::interval::{allowed_raise, interval};
use crate::film::srgb::Codes8;
use crate::lanes::{Lanes, MAX_LANES, Mask, Real, V3, lanes_of};
use crate::scene::world::Pruning;
use crate::trace::variants::Variant;

/// tau: w U below which rays are deferred at first, for a pixel that may be 0, 1 or 2 codes off. With these numbers and the
/// next ones the scenes of the repository take the fewest rays.
const FIRST_THRESHOLD: [f64; 3] = [1e-3, 1e-2, 2e-2];
/// Most light that all skipped lights together could add.
const SKIPPED_LIGHT: [f64; 3] = [1e-5, 1.2e-3, 2.4e-3];
/// Factor on tau from one round to the next.
const REFINEMENT: f64 = 0.75;
/// Rounds until the proof of a pixel is given up: 0.75^80 is 1e-10.
const ROUNDS: u32 = 80;

/// w U below which rays are omitted in pixels that cannot be proved because of rounding.
const LAST_THRESHOLD: f64 = 1e-9;

/// The state of proving a packet of pixels.
#[derive(Debug)]
pub(super) struct Certificate<L: Lanes> {
    /// R so far, without the deferred rays.
    omitted: V3<L>,
    /// Most light that the skipped lights could have added.
    skipped_light: L,
    /// Largest `skipped_light` allowed.
    skipped_light_limit: L,
    /// The deferred rays.
    pub(super) deferred: DeferredRays<L>,
    /// How many packets of them were deferred in the round before, and are followed in this one.
    this_round: usize,
    /// Rays of each pixel, for the rounding of its sum.
    rays: L,
    /// Lanes that are not proved yet.
    unproved_lanes: u32,
    /// Rounds so far.
    rounds: u32,
    /// Whether rays are omitted instead of deferred, so that the others are followed in depth-first order.
    in_order: bool,
    /// Columns and rows of the pixels.
    corners: [[u32; MAX_LANES]; 2],
    /// The current batch of samples.
    pub(super) batch: u32,
    /// The current sample.
    sample: u32,
}

impl<L: Lanes> Certificate<L> {
    pub(super) fn new(s: L::Simd) -> Self {
        let zero = L::lit(s, 0.0);
        Self {
            omitted: V3 { x: zero, y: zero, z: zero },
            skipped_light: zero,
            skipped_light_limit: zero,
            deferred: DeferredRays::default(),
            this_round: 0,
            rays: zero,
            unproved_lanes: 0,
            rounds: 0,
            in_order: false,
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

impl<L: Lanes, O: Observer<L>, V: Variant> Tracer<'_, L, O, V> {
    /// Begins with a packet of pixels.
    #[inline(always)]
    pub(crate) fn begin_packet(&mut self, pixels: &[[u32; 2]], samples: Samples) {
        let s = self.s;
        let zero = L::lit(s, 0.0);
        let share = 1.0 / f64::from(samples.count);
        let (least, skipped_light) = match self.pruning {
            Pruning::Weight(min_weight) => (min_weight, 0.0),
            Pruning::Proved { max_codes } => {
                let codes = usize::from(max_codes.min(2));
                (FIRST_THRESHOLD[codes], SKIPPED_LIGHT[codes])
            }
        };
        self.min_weight = L::lit(s, share * least);
        self.certificate.omitted = V3 { x: zero, y: zero, z: zero };
        self.certificate.skipped_light = zero;
        self.certificate.skipped_light_limit = L::lit(s, skipped_light);
        self.certificate.rays = zero;
        for (lane, [x, y]) in pixels.iter().enumerate() {
            (self.certificate.corners[0][lane], self.certificate.corners[1][lane]) = (*x, *y);
        }
        self.certificate.batch = samples.batch;
        self.certificate.unproved_lanes = u32::MAX;
        self.certificate.rounds = 0;
        self.certificate.in_order = false;
        self.certificate.deferred.begin(Pruning::most_deferred(samples.count));
        self.certificate.this_round = 0;
        self.media.clear();
        self.followed = zero;
    }

    /// Columns or rows of a sample: the corner of each pixel plus an offset.
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
    pub(crate) fn begin_sample(&mut self, index: u32) {
        self.certificate.sample = index;
        self.end_of_round();
        if V::DETAILS {
            self.sampler = Sampler::new(&self.certificate.corners, self.certificate.batch, index);
        }
    }

    /// R: the most light that each pixel of the packet may miss.
    #[inline(always)]
    pub(crate) fn omitted(&self) -> V3<L> {
        self.certificate.omitted
    }

    /// The lanes of which rays or lights were omitted.
    #[inline(always)]
    pub(crate) fn incomplete(&self) -> u32 {
        let omitted = self.certificate.omitted;
        omitted.x.max(omitted.y).max(omitted.z).gt(L::lit(self.s, 0.0)).bits()
    }

    /// The most light that rays of a weight and a depth can bring.
    #[inline(always)]
    fn upper_bound(&self, weight: V3<L>, depth: u32) -> V3<L> {
        let ceiling = self.world.ceiling.of((self.world.rules.max_depth + 1).saturating_sub(depth));
        weight.times(V3::splat(self.s, ceiling.map(L::Real::from_f64)))
    }

    /// Adds omitted rays of some lanes to R.
    #[inline(always)]
    pub(super) fn record_omitted_rays(&mut self, lanes: u32, weight: V3<L>, depth: u32) {
        let upper_bound = self.upper_bound(weight, depth);
        self.record_omitted_light(L::mask(self.s, lanes), upper_bound);
    }

    /// Adds omitted light of some lanes to R.
    #[inline(always)]
    pub(super) fn record_omitted_light(&mut self, lanes: L::Mask, radiance: V3<L>) {
        let omitted = self.certificate.omitted;
        self.certificate.omitted = V3::select(lanes, omitted + radiance, omitted);
    }

    /// The lanes whose rays have enough weight to be followed now.
    #[inline(always)]
    pub(super) fn significant(&self, rays: &RayPacket<L>) -> u32 {
        let zero = L::lit(self.s, 0.0);
        let heaviest = |v: V3<L>| v.x.max(v.y).max(v.z);
        let there = heaviest(rays.weight).gt(zero);
        let enough = match self.pruning {
            Pruning::Weight(_) => heaviest(rays.weight),
            Pruning::Proved { .. } => heaviest(self.upper_bound(rays.weight, rays.depth)),
        };
        (enough.ge(self.min_weight) & there).bits() & rays.active
    }

    /// Defers rays of some lanes, or omits them where nothing is to be proved.
    #[inline(never)]
    pub(super) fn defer(&mut self, rays: &RayPacket<L>, lanes: u32) {
        L::vectorize(
            self.s,
            #[inline(always)]
            || match self.pruning {
                Pruning::Proved { .. } if !self.certificate.in_order => {
                    let distance = if V::DETAILS { self.cones.end } else { L::lit(self.s, 0.0) };
                    let kept = self.certificate.deferred.with_room(lanes);
                    let sample = self.certificate.sample;
                    let deferred = Deferred { rays: RayPacket { active: kept, ..*rays }, distance, sample };
                    self.certificate.deferred.push(&deferred);
                    self.omit(rays, lanes & !kept);
                }
                _ => self.omit(rays, lanes),
            },
        );
    }

    /// The lanes of `lit` in which a light that would add at most `added` is skipped.
    #[inline(always)]
    pub(super) fn may_skip_light(&mut self, lit: L::Mask, added: V3<L>) -> L::Mask {
        let skipped_light = self.certificate.skipped_light + added.x.max(added.y).max(added.z);
        let little = lit & skipped_light.le(self.certificate.skipped_light_limit);
        self.certificate.skipped_light = L::select(little, skipped_light, self.certificate.skipped_light);
        little
    }

    /// Stacks the next deferred rays of the pixels of `active` that are not proved. Returns false if there are none, or if the
    /// others cannot be proved.
    #[inline(always)]
    pub(crate) fn prove(&mut self, active: u32, hits: &mut Hits<L>, sum: &V3<L>) -> bool {
        let Pruning::Proved { max_codes } = self.pruning else { return false };
        let certificate = &self.certificate;
        if certificate.deferred.is_empty() && self.incomplete() & active == 0 {
            self.end_of_round();
            self.certificate.unproved_lanes = 0;
            return false;
        }
        self.prove_in(max_codes, active, hits, sum)
    }

    #[inline(never)]
    fn prove_in(&mut self, max_codes: u8, active: u32, hits: &mut Hits<L>, sum: &V3<L>) -> bool {
        L::vectorize(
            self.s,
            #[inline(always)]
            || self.next_round(max_codes, active, hits, sum),
        )
    }

    #[inline(always)]
    fn next_round(&mut self, max_codes: u8, active: u32, hits: &mut Hits<L>, sum: &V3<L>) -> bool {
        loop {
            while self.certificate.this_round > 0 {
                self.certificate.this_round -= 1;
                let Some(Deferred { mut rays, distance, sample }) = self.certificate.deferred.pop(self.s) else {
                    break;
                };
                let unproved_lanes = self.certificate.unproved_lanes;
                self.omit(&rays, rays.active & !unproved_lanes);
                rays.active &= unproved_lanes;
                if rays.active != 0 {
                    self.resume(sample, hits);
                    if V::DETAILS {
                        self.cones.end = distance;
                    }
                    self.push(rays);
                    if !self.stack.is_empty() {
                        return true;
                    }
                }
            }
            self.end_of_round();
            let unproved_lanes = self.unproved_lanes(active & self.certificate.unproved_lanes, max_codes, sum);
            self.certificate.unproved_lanes = unproved_lanes;
            let certificate = &mut self.certificate;
            if unproved_lanes == 0 || certificate.deferred.is_empty() || certificate.rounds == ROUNDS {
                return false;
            }
            certificate.rounds += 1;
            self.min_weight = self.min_weight * L::lit(self.s, REFINEMENT);
            certificate.this_round = certificate.deferred.len();
        }
    }

    /// Adds up the rays since the last sample or round.
    #[inline(always)]
    fn end_of_round(&mut self) {
        self.certificate.rays = self.certificate.rays + self.followed;
        self.followed = L::lit(self.s, 0.0);
    }

    /// The lanes whose codes are not proved to be exact.
    #[inline(always)]
    fn inexact(&self, among: u32, sum: &V3<L>) -> u32 {
        let (codes, omitted, roundings) = (Codes8::get(), self.certificate.omitted, self.roundings());
        let mut inexact = 0;
        for lane in lanes_of(among) {
            let ends = interval(sum.lane(lane), omitted.lane(lane), roundings.lane(lane));
            if ends.iter().any(|[low, high]| codes.code(*low) != codes.code(*high)) {
                inexact |= 1 << lane;
            }
        }
        inexact
    }

    /// Omits the rays that are still deferred. Lanes that are not proved because of skipped lights have to be traced again, now
    /// with every light: it resets them and returns them.
    #[inline(always)]
    pub(crate) fn finish(&mut self, active: u32, sum: &mut V3<L>) -> u32 {
        let proves = matches!(self.pruning, Pruning::Proved { .. });
        if !proves || (self.certificate.deferred.is_empty() && self.incomplete() & active == 0) {
            return 0;
        }
        self.omit_deferred(active, sum)
    }

    #[inline(never)]
    fn omit_deferred(&mut self, active: u32, sum: &mut V3<L>) -> u32 {
        L::vectorize(
            self.s,
            #[inline(always)]
            || self.omit_deferred_in(active, sum),
        )
    }

    #[inline(always)]
    fn omit_deferred_in(&mut self, active: u32, sum: &mut V3<L>) -> u32 {
        let s = self.s;
        if O::WATCHING {
            while let Some(Deferred { rays, .. }) = self.certificate.deferred.pop(s) {
                self.omit(&rays, rays.active);
            }
        }
        self.certificate.omitted = self.with_deferred();
        self.certificate.deferred.clear();
        let zero = L::lit(s, 0.0);
        let again = match self.pruning {
            // More rays do not help where rounding alone may change a code. Such pixels are traced again in the order of
            // recursion without end, which gives the same roundings.
            Pruning::Proved { max_codes: 0 } if !self.certificate.in_order => {
                self.certificate.in_order = true;
                self.min_weight = self.share * L::lit(s, LAST_THRESHOLD);
                self.inexact(active, sum)
            }
            _ => self.certificate.unproved_lanes & self.certificate.skipped_light.gt(zero).bits(),
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
        certificate.omitted = V3::select(mask, black, certificate.omitted);
        certificate.skipped_light = L::select(mask, zero, certificate.skipped_light);
        certificate.rays = L::select(mask, zero, certificate.rays);
        certificate.skipped_light_limit = zero;
        certificate.rounds = 0;
        again
    }

    #[inline(always)]
    fn omit(&mut self, rays: &RayPacket<L>, lanes: u32) {
        if lanes != 0 {
            self.record_omitted_rays(lanes, rays.weight, rays.depth);
            if O::WATCHING {
                self.observer.not_followed(rays.parent, rays.kind, rays.weight, NotFollowed::Weight);
            }
        }
    }

    /// Goes back to the sample of deferred rays.
    #[inline(always)]
    fn resume(&mut self, sample: u32, hits: &mut Hits<L>) {
        if sample != self.certificate.sample {
            self.certificate.sample = sample;
            if V::DETAILS {
                self.sampler = Sampler::new(&self.certificate.corners, self.certificate.batch, sample);
            }
            self.make_choices(hits);
        }
    }

    /// R and what the deferred rays can bring.
    #[inline(always)]
    fn with_deferred(&self) -> V3<L> {
        let mut omitted = self.certificate.omitted;
        for (lanes, weight, depth) in self.certificate.deferred.weights() {
            omitted = V3::select(L::mask(self.s, lanes), omitted + self.upper_bound(weight, depth), omitted);
        }
        omitted
    }

    /// The lanes of `among` that may be more than `max_codes` off, and that more rays may prove.
    #[inline(always)]
    fn unproved_lanes(&self, among: u32, max_codes: u8, sum: &V3<L>) -> u32 {
        let s = self.s;
        let omitted = self.with_deferred();
        let incomplete = omitted.x.max(omitted.y).max(omitted.z).gt(L::lit(s, 0.0)).bits() & among;
        if incomplete == 0 {
            return 0;
        }
        let roundings = self.roundings();
        let mut unproved_lanes = 0;
        for lane in lanes_of(incomplete) {
            let (sum, omitted, rounding) = (sum.lane(lane), omitted.lane(lane), roundings.lane(lane));
            let ends = interval(sum, omitted, rounding);
            let further = (0..3).any(|c| {
                let [low, high] = ends[c];
                let codes = Codes8::get();
                let proved = codes.code(high) - codes.code(low) <= max_codes + allowed_raise(low, max_codes);
                // Where rounding alone may change a code, more rays do not help.
                !proved && omitted[c].to_f64() > 0.5 * rounding.to_f64() * sum[c].to_f64()
            });
            if further {
                unproved_lanes |= 1 << lane;
            }
        }
        unproved_lanes
    }

    /// The relative rounding error of a pixel's sum and of the sum of recursion without end together: each term may have been
    /// rounded in both.
    #[inline(always)]
    pub(crate) fn roundings(&self) -> L {
        let s = self.s;
        let terms = 1.0 + self.world.lights.len() as f64;
        (self.certificate.rays + L::lit(s, 2.0)) * L::lit(s, 2.0 * terms * L::Real::ROUNDOFF)
    }

    /// The lanes whose chains keep so much of their weight that they would never end.
    #[inline(always)]
    pub(super) fn never_ending(&self, rays: &RayPacket<L>) -> u32 {
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
