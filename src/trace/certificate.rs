//! The certificate of a sample: a bound on the light of all omitted rays.
//!
//! All radiance is 0 or more. So with the sum lo of what was traced, the sample of recursion without end lies in [lo, lo + R].
//! R is the sum over the omitted rays of weight times [`Ceiling`](crate::bound::ceiling::Ceiling), and of the most that
//! skipped lights could have added. What is done about it is in `proof.rs`.

use super::deferred::{Deferred, DeferredRays};
use super::kernel::Tracer;
use super::observer::{NotFollowed, Observer};
use super::proof::{FIRST_RAYS, MORE_RAYS, RISE};
use super::ray_packet::RayPacket;
use super::sampling::{sample_offset, shifts};
use crate::lanes::{Lanes, MAX_LANES, Mask, Real, V3};
use crate::math::pow;
use crate::scene::limits::RAYS_PER_SAMPLE;
use crate::scene::world::Pruning;
use crate::trace::variants::Variant;

/// The depth from which on chains are asked whether they would ever end, and again at each power of two.
const FIRST_LOOK: u32 = 64;
/// They would not if they keep this share of their weight with each ray.
const KEPT_WITHOUT_END: f64 = 0.99;

/// What is known of the samples of a packet.
#[derive(Debug)]
pub(super) struct Certificate<L: Lanes> {
    /// R so far, without the deferred rays.
    pub(super) omitted: V3<L>,
    /// The share of a transparent background that is seen.
    pub(super) clear: L,
    /// That which omitted rays could see, without the deferred ones.
    pub(super) unseen: L,
    /// Most light that the skipped lights could have added.
    pub(super) skipped_light: L,
    /// Largest `skipped_light` allowed.
    pub(super) skipped_light_limit: L,
    /// The smallest weight followed, or w U where something is to be proved.
    pub(super) min_weight: L,
    /// The deferred rays.
    pub(super) deferred: DeferredRays<L>,
    /// How many packets of them were deferred in the round before, and are followed in this one.
    pub(super) this_round: usize,
    /// Rays of each sample, without those of this round.
    pub(super) rays: L,
    /// How many rays each sample may have in this round.
    pub(super) most_followed: L,
    /// How many rays each may have in all.
    pub(super) most_rays: L,
}

impl<L: Lanes> Certificate<L> {
    pub(super) fn new(s: L::Simd) -> Self {
        let zero = L::lit(s, 0.0);
        Self {
            omitted: V3 { x: zero, y: zero, z: zero },
            clear: zero,
            unseen: zero,
            skipped_light: zero,
            skipped_light_limit: zero,
            min_weight: zero,
            deferred: DeferredRays::default(),
            this_round: 0,
            rays: zero,
            most_followed: zero,
            most_rays: zero,
        }
    }

    /// Begins with other samples.
    #[inline(always)]
    pub(super) fn begin(&mut self, s: L::Simd, most_deferred: u32) {
        let zero = L::lit(s, 0.0);
        self.omitted = V3 { x: zero, y: zero, z: zero };
        (self.clear, self.unseen, self.skipped_light) = (zero, zero, zero);
        self.rays = zero;
        self.deferred.begin(most_deferred);
        self.this_round = 0;
    }
}

impl<L: Lanes, O: Observer<L>, V: Variant> Tracer<'_, L, O, V> {
    /// Begins with samples of the packet at work.
    #[inline(always)]
    pub(crate) fn begin_samples(&mut self, lanes: u32) {
        let s = self.s;
        let (least, skipped_light) = self.thresholds;
        let (most_followed, most_rays) = match self.pruning {
            Pruning::Weight(_) => (RAYS_PER_SAMPLE.max as f64, L::lit(s, f64::INFINITY)),
            Pruning::Proved { .. } => (FIRST_RAYS, self.most_rays()),
        };
        let certificate = &mut self.certificate;
        certificate.min_weight = L::lit(s, least);
        certificate.skipped_light_limit = L::lit(s, if self.proof.skips_lights { skipped_light } else { 0.0 });
        certificate.rays = L::select(L::mask(s, lanes), L::lit(s, 0.0), certificate.rays);
        (certificate.most_followed, certificate.most_rays) = (L::lit(s, most_followed), most_rays);
        self.followed = L::lit(s, 0.0);
        self.choose_samplers();
    }

    /// Columns or rows of the samples of the packet at work.
    #[inline(never)]
    pub(crate) fn coordinates(&self, axis: usize) -> L {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                if self.proof.is_of_middles() {
                    return self.middles(axis);
                }
                let samples = &self.samples;
                let mut within = [0.0; MAX_LANES];
                for lane in 0..L::COUNT {
                    within[lane] = sample_offset(samples.numbers[lane], axis);
                }
                if samples.set != 0 {
                    // Shifted by multiples of 2^-32 of a pixel.
                    let shifts = shifts(&samples.corners, samples.set, axis);
                    for lane in 0..L::COUNT {
                        let shifted = within[lane] + f64::from(shifts[lane]) / 4_294_967_296.0;
                        within[lane] = shifted - shifted.floor();
                    }
                }
                let mut at = [L::Real::default(); MAX_LANES];
                for lane in 0..L::COUNT {
                    at[lane] = L::Real::from_f64(f64::from(samples.corners[axis][lane]) + within[lane]);
                }
                L::load(self.s, &at)
            },
        )
    }

    /// The middles of the pixels of the packet at work.
    #[inline(always)]
    pub(crate) fn middles(&self, axis: usize) -> L {
        let mut at = [L::Real::default(); MAX_LANES];
        for lane in 0..L::COUNT {
            at[lane] = L::Real::from_f64(f64::from(self.samples.corners[axis][lane]) + 0.5);
        }
        L::load(self.s, &at)
    }

    /// The lanes of which rays or lights were omitted.
    #[inline(always)]
    pub(super) fn incomplete(&self) -> u32 {
        let omitted = self.certificate.omitted;
        let mut most = omitted.x.max(omitted.y).max(omitted.z);
        if self.is_transparent() {
            most = most.max(self.certificate.unseen);
        }
        most.gt(L::lit(self.s, 0.0)).bits()
    }

    /// The most light that rays of a weight and a depth can bring.
    #[inline(always)]
    pub(super) fn upper_bound(&self, weight: V3<L>, depth: u32) -> V3<L> {
        let ceiling = self.world.ceiling.of(self.rays_left(depth));
        weight.times(V3::splat(self.s, ceiling.map(L::Real::from_f64)))
    }

    /// Adds what rays of some lanes see of a transparent background: the mean of the channels of what its light is multiplied with.
    /// Over a color that is known it is the least of them, and what colored glass lets through beyond that is light.
    #[inline(never)]
    pub(super) fn see_through(&mut self, lanes: u32, weight: V3<L>) -> V3<L> {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                let clear = self.certificate.clear;
                let mut share = (weight.x + weight.y + weight.z) * L::lit(self.s, 1.0 / 3.0);
                let mut beyond = V3::splat(self.s, [L::Real::default(); 3]);
                if let Some(color) = self.world.behind {
                    share = weight.x.min(weight.y).min(weight.z);
                    beyond = V3 { x: weight.x - share, y: weight.y - share, z: weight.z - share };
                    beyond = beyond.times(V3::splat(self.s, color));
                }
                self.certificate.clear = L::select(L::mask(self.s, lanes), clear + share, clear);
                beyond
            },
        )
    }

    /// The share of a transparent background that rays of a weight and a depth can see.
    #[inline(always)]
    pub(super) fn clear_bound(&self, weight: V3<L>, depth: u32) -> L {
        let most = self.world.ceiling.clear(self.rays_left(depth));
        (weight.x + weight.y + weight.z) * L::lit(self.s, most / 3.0)
    }

    /// The longest chain that a ray of a depth can begin.
    #[inline(always)]
    fn rays_left(&self, depth: u32) -> u32 {
        (self.world.rules.max_depth + 1).saturating_sub(depth)
    }

    /// Adds omitted rays of some lanes to R. Those that are `straight` could have seen a transparent background.
    #[inline(always)]
    pub(super) fn record_omitted_rays(&mut self, lanes: u32, weight: V3<L>, depth: u32, straight: bool) {
        let upper_bound = self.upper_bound(weight, depth);
        let lanes = L::mask(self.s, lanes);
        self.record_omitted_light(lanes, upper_bound);
        if straight && self.is_transparent() {
            self.record_unseen(lanes, weight, depth);
        }
    }

    /// Adds what omitted rays of some lanes could have seen of a transparent background.
    #[inline(always)]
    pub(super) fn record_unseen(&mut self, lanes: L::Mask, weight: V3<L>, depth: u32) {
        let unseen = self.certificate.unseen;
        self.certificate.unseen = L::select(lanes, unseen + self.clear_bound(weight, depth), unseen);
    }

    /// Adds omitted light of some lanes to R.
    #[inline(always)]
    pub(super) fn record_omitted_light(&mut self, lanes: L::Mask, radiance: V3<L>) {
        let omitted = self.certificate.omitted;
        self.certificate.omitted = V3::select(lanes, omitted + radiance, omitted);
    }

    /// The lanes in which rays of a weight and a depth bring enough to be followed now.
    #[inline(always)]
    pub(super) fn significant(&self, weight: V3<L>, depth: u32, straight: bool) -> u32 {
        let zero = L::lit(self.s, 0.0);
        let there = weight.x.max(weight.y).max(weight.z).gt(zero);
        let enough = match self.pruning {
            Pruning::Weight(_) => weight,
            Pruning::Proved { .. } => self.upper_bound(weight, depth),
        };
        let mut enough = enough.x.max(enough.y).max(enough.z);
        if straight && self.is_transparent() {
            enough = enough.max(self.clear_bound(weight, depth));
        }
        (enough.ge(self.certificate.min_weight) & there).bits()
    }

    /// Defers rays of some lanes, or omits them where nothing is to be proved.
    #[inline(never)]
    pub(super) fn defer(&mut self, rays: &RayPacket<L>, lanes: u32) {
        L::vectorize(
            self.s,
            #[inline(always)]
            || match self.pruning {
                Pruning::Proved { .. } => {
                    let cones = if V::FOOTPRINTS { self.cones.next } else { [L::lit(self.s, 0.0); 3] };
                    let kept = self.certificate.deferred.with_room(lanes);
                    let deferred = Deferred { rays: RayPacket { active: kept, ..*rays }, cones };
                    self.certificate.deferred.push(&deferred);
                    self.omit(rays, lanes & !kept);
                }
                _ => self.omit(rays, lanes),
            },
        );
    }

    /// Rays of some lanes are beyond the limit of their sample or round. While a sample is to be proved, its threshold rises
    /// instead, so that rays of more weight have their turn before. Returns the lanes of which no ray may be followed any more.
    #[inline(always)]
    pub(super) fn beyond_limit(&mut self, rays: &mut RayPacket<L>, lanes: u32) -> u32 {
        if lanes == 0 || matches!(self.pruning, Pruning::Weight(_)) {
            return lanes;
        }
        let s = self.s;
        let certificate = &mut self.certificate;
        let all = certificate.rays + self.followed;
        let spent = all.ge(certificate.most_rays).bits() & lanes;
        let raised = L::mask(s, lanes & !spent);
        let (least, most) = (certificate.min_weight, certificate.most_followed);
        certificate.min_weight = L::select(raised, least * L::lit(s, RISE), least);
        certificate.most_followed = L::select(raised, most + L::lit(s, MORE_RAYS), most);
        self.give_up(spent);
        let light = lanes & !spent & !(self.significant(rays.weight, rays.depth, rays.straight) & rays.active);
        if light != 0 {
            self.defer(rays, light);
            rays.active &= !light;
        }
        spent
    }

    /// The lanes of `lit` in which a light that would add at most `added` is skipped.
    #[inline(always)]
    pub(super) fn may_skip_light(&mut self, lit: L::Mask, added: V3<L>) -> L::Mask {
        let skipped_light = self.certificate.skipped_light + added.x.max(added.y).max(added.z);
        let negligible = lit & skipped_light.le(self.certificate.skipped_light_limit);
        self.certificate.skipped_light = L::select(negligible, skipped_light, self.certificate.skipped_light);
        negligible
    }

    /// Omits rays of some lanes.
    #[inline(always)]
    pub(super) fn omit(&mut self, rays: &RayPacket<L>, lanes: u32) {
        if lanes != 0 {
            self.record_omitted_rays(lanes, rays.weight, rays.depth, rays.straight);
            if O::WATCHING {
                self.observer.not_followed(rays.parent, rays.kind, rays.weight, NotFollowed::Weight);
            }
        }
    }

    /// The lanes whose chains keep so much of their weight that they would never end. Those of pictures that are held against a
    /// depth end there.
    #[inline(always)]
    pub(super) fn never_ending(&self, rays: &RayPacket<L>) -> u32 {
        if rays.depth < FIRST_LOOK || !rays.depth.is_power_of_two() {
            return 0;
        }
        match self.pruning {
            Pruning::Proved { .. } if self.world.ceiling.reach.max_depth.is_none() => {
                let kept = L::lit(self.s, pow(KEPT_WITHOUT_END, f64::from(rays.depth)));
                let weight = rays.weight.x.max(rays.weight.y).max(rays.weight.z);
                // A wavelength of split light has more of one channel.
                let color = self.wavelengths.color;
                let begun = color.x.max(color.y).max(color.z).max(L::lit(self.s, 1.0));
                weight.gt(kept * begun).bits() & rays.active
            }
            _ => 0,
        }
    }
}
