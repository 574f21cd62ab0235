//! The proof that what a batch omits does not change the picture.
//!
//! Since sRGB codes grow with light, the code of a group of samples lies between those of both ends of its interval
//! (`certificate.rs`). Rays of little weight (w U < tau) are deferred at first. While the two codes are too far apart, deferred
//! rays are followed after all, the heavier ones first, in rounds.
//!
//! A group that is a whole pixel is held against codes. What is proved of one that is a part of a pixel is its width, as a share
//! of a code there: codes are concave in light, so the interval of the mean is no wider than the intervals of the parts. It may
//! still contain the border of a code. Then all groups of the pixel are traced again, with narrower intervals.

use super::batch::{BATCH, BatchLight, SampleBatch};
use super::certificate::Certificate;
use super::deferred::Deferred;
use super::hits::Hits;
use super::kernel::Tracer;
use super::observer::Observer;
use super::pixel_sum::{PixelSum, relative_error};
use super::sampling::Sampler;
use crate::bound::interval::{excess, interval, proved, share_of_code};
use crate::film::Display;
use crate::lanes::{Lanes, MAX_LANES, Mask, Real, V3, lanes_of};
use crate::math::{log2, pow};
use crate::scene::world::Pruning;
use crate::trace::variants::Variant;

/// tau: w U below which rays are deferred at first, for a pixel that may be 0, 1 or 2 codes off. With these numbers and the
/// next ones the scenes of the repository take the fewest rays.
const FIRST_THRESHOLD: [f64; 3] = [1e-3, 1e-2, 2e-2];
/// Most light that all skipped lights together could add.
const SKIPPED_LIGHT: [f64; 3] = [1e-5, 1.2e-3, 2.4e-3];
/// Factor on tau from one round to the next.
const REFINEMENT: f64 = 0.75;
/// Rays that each sample may have in the first round, and at least as many in others, until its threshold rises.
pub(super) const FIRST_RAYS: f64 = 512.0;
/// Rays until it rises again.
pub(super) const MORE_RAYS: f64 = 64.0;
/// Factor on the threshold.
pub(super) const RISE: f64 = 2.0;
/// Rays that a proof seems to need, as a multiple of those it may have, until it is given up: the last ones often bring more.
const HOPE: f64 = 2.0;
/// Share of the rays of a group that may be followed before its proof must come nearer.
const FREE_SHARE: f64 = 1.0 / 40.0;
/// The factor on tau where a group has deferred so many rays that looking through them takes longer than following more rays
/// than needed.
const COARSE_REFINEMENT: f64 = 0.5;
/// How many those are.
const MANY: u32 = 256;
/// Deferred rays of a sample that stand for chains which do not branch.
const CHAINS: u32 = 2;
/// Rounds until the proof of a batch is given up: 0.75^80 is 1e-10.
const ROUNDS: u32 = 80;
/// Widths that parts of pixels are proved to have, one for each attempt, as shares of what a whole pixel may have.
const WIDTHS: [f64; ATTEMPTS] = [0.9, 0.3, 0.05];
/// Those of pixels that may be 0 codes off, as shares of a code.
const EXACT_WIDTHS: [f64; ATTEMPTS] = [1.0 / 32.0, 1.0 / 2_048.0, 1.0 / 1_048_576.0];
/// How often a pixel of several groups is traced before its proof is given up.
pub(crate) const ATTEMPTS: usize = 3;

/// The w U below which rays are deferred or omitted, and the most light that skipped lights could add.
pub(super) fn thresholds(pruning: Pruning, display: &Display) -> (f64, f64) {
    match pruning {
        Pruning::Weight(min_weight) => (min_weight, 0.0),
        Pruning::Proved { max_codes } => {
            let codes = usize::from(max_codes.min(2));
            // A brighter exposure shows less light.
            (FIRST_THRESHOLD[codes] / display.gain(), SKIPPED_LIGHT[codes] / display.gain())
        }
    }
}

/// The state of proving a batch.
#[derive(Debug)]
pub(super) struct BatchProof<L: Lanes> {
    batch: SampleBatch,
    /// The packet at work.
    packet: usize,
    /// The others, and a place for that one; empty if a batch is a packet.
    waiting: Vec<WaitingPacket<L>>,
    /// Samples that are not proved yet.
    unproved: u32,
    /// Samples whose proof was given up.
    given_up: u32,
    /// How near each group was to its proof, by its first sample.
    checkpoints: [Checkpoint; BATCH],
    /// Rounds so far.
    rounds: u32,
    /// Whether lights that add little may be skipped.
    pub(super) skips_lights: bool,
    /// Which attempt this is.
    attempt: usize,
}

/// A packet of the batch that is not at work.
#[derive(Debug)]
struct WaitingPacket<L: Lanes> {
    certificate: Certificate<L>,
    sum: PixelSum<L>,
}

/// How near a group was to its proof.
#[derive(Debug, Clone, Copy, Default)]
struct Checkpoint {
    /// Its rays until then.
    rays: f64,
    /// The light that it missed at most.
    omitted: f64,
}

/// How things stand with the samples of a batch.
struct Standing {
    light: [[f64; BATCH]; 3],
    omitted: [[f64; BATCH]; 3],
    rays: [f64; BATCH],
}

impl<L: Lanes> BatchProof<L> {
    pub(super) fn new() -> Self {
        Self {
            batch: SampleBatch::new(super::pixel::Samples::of_picture(1)),
            packet: 0,
            waiting: Vec::new(),
            unproved: 0,
            given_up: 0,
            checkpoints: [Checkpoint::default(); BATCH],
            rounds: 0,
            skips_lights: true,
            attempt: 0,
        }
    }

    /// The first sample of the packet at work.
    #[inline(always)]
    pub(super) fn first(&self) -> usize {
        self.packet * L::COUNT
    }

    /// Lanes and media of the deferred rays of packets that are not at work.
    pub(super) fn waiting_media(&mut self) -> impl Iterator<Item = (u32, &mut L::Ids)> {
        self.waiting.iter_mut().flat_map(|waiting| waiting.certificate.deferred.media())
    }

    /// Whether its samples are the middles of their pixels.
    pub(super) fn is_of_middles(&self) -> bool {
        let samples = self.batch.samples();
        samples.count == 1 && samples.set == 0
    }

    /// The groups of some samples.
    fn groups_of(&self, samples: u32) -> u32 {
        self.batch.groups(samples).fold(0, |all, group| all | group)
    }

    /// The number of packets.
    fn packets(&self) -> usize {
        self.waiting.len().max(1)
    }
}

impl<L: Lanes, O: Observer<L>, V: Variant> Tracer<'_, L, O, V> {
    /// Begins with a batch.
    #[inline(never)]
    pub(crate) fn begin_batch(&mut self, batch: &SampleBatch, attempt: usize) {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                let s = self.s;
                let proof = &mut self.proof;
                let packets = batch.len().div_ceil(L::COUNT);
                let others = if packets > 1 { packets } else { 0 };
                proof.waiting.truncate(others);
                while proof.waiting.len() < others {
                    proof.waiting.push(WaitingPacket { certificate: Certificate::new(s), sum: PixelSum::black(s) });
                }
                for waiting in &mut proof.waiting {
                    waiting.certificate.begin(s, Pruning::MOST_DEFERRED);
                    waiting.sum = PixelSum::black(s);
                }
                self.certificate.begin(s, Pruning::MOST_DEFERRED);
                (proof.batch, proof.packet) = (*batch, 0);
                (proof.unproved, proof.given_up) = (batch.all(), 0);
                proof.checkpoints = [Checkpoint::default(); BATCH];
                (proof.rounds, proof.skips_lights, proof.attempt) = (0, true, attempt);
                self.samples = batch.packet::<L>(0);
                self.media.clear();
                if O::WATCHING {
                    self.observer.batch();
                }
            },
        );
    }

    /// Lanes of the packet at work that are not proved yet.
    #[inline(always)]
    pub(super) fn unproved_lanes(&self) -> u32 {
        (self.proof.unproved >> self.proof.first()) & L::ALL
    }

    /// The share of its pixel over which textures are averaged for each sample.
    #[inline(always)]
    pub(super) fn share(&self) -> f64 {
        self.proof.batch.samples().share()
    }

    /// Puts another packet of the batch to work.
    #[inline(always)]
    pub(super) fn exchange(&mut self, packet: usize, sum: &mut PixelSum<L>) {
        if packet != self.proof.packet {
            self.exchange_in(packet, sum);
        }
    }

    #[inline(never)]
    fn exchange_in(&mut self, packet: usize, sum: &mut PixelSum<L>) {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                self.end_of_round();
                let proof = &mut self.proof;
                for packet in [proof.packet, packet] {
                    std::mem::swap(&mut proof.waiting[packet].certificate, &mut self.certificate);
                    std::mem::swap(&mut proof.waiting[packet].sum, sum);
                }
                proof.packet = packet;
                self.samples = proof.batch.packet::<L>(packet);
            },
        );
    }

    /// The choices of the samples of the packet at work.
    #[inline(always)]
    pub(super) fn choose_samplers(&mut self) {
        if V::DETAILS {
            let samples = &self.samples;
            self.sampler = Sampler::new(&samples.corners, samples.set, &samples.numbers, self.dimensions);
        }
    }

    /// How many rays each sample of the packet at work may have: as many as its group.
    #[inline(always)]
    pub(super) fn most_rays(&self) -> L {
        if self.proof.batch.samples().count == 1 {
            return L::lit(self.s, f64::from(const { Pruning::most_rays(1) }));
        }
        let mut most = [L::Real::default(); MAX_LANES];
        let mut first = 0;
        // Samples beyond the last one are of no group, and have no rays.
        while first < L::COUNT {
            let group = self.proof.batch.group_of((self.proof.first() + first).min(BATCH - 1));
            let rays = L::Real::from_f64(f64::from(Pruning::most_rays(group.count_ones())));
            let end = (u32::BITS - (group >> self.proof.first()).leading_zeros()) as usize;
            let end = end.max(first + 1).min(L::COUNT);
            most[first..end].fill(rays);
            first = end;
        }
        L::load(self.s, &most)
    }

    /// Gives up the proof of the groups of some lanes.
    #[inline(always)]
    pub(super) fn give_up(&mut self, lanes: u32) {
        if lanes != 0 {
            let samples = self.proof.groups_of(lanes << self.proof.first());
            self.proof.unproved &= !samples;
            self.proof.given_up |= samples;
        }
    }

    /// Stacks the next deferred rays of samples that are not proved. Returns false if there are none, or if the others cannot be
    /// proved.
    #[inline(always)]
    pub(super) fn prove(&mut self, hits: &mut Hits<L>, sum: &mut PixelSum<L>) -> bool {
        let Pruning::Proved { max_codes } = self.pruning else {
            self.end_of_round();
            return false;
        };
        if self.proof.waiting.is_empty() && self.is_complete() {
            self.end_of_round();
            self.proof.unproved = 0;
            return false;
        }
        self.prove_in(max_codes, hits, sum)
    }

    /// Whether nothing was omitted or deferred in the packet at work.
    #[inline(always)]
    fn is_complete(&self) -> bool {
        self.certificate.deferred.is_empty() && self.incomplete() & L::ALL == 0
    }

    #[inline(never)]
    fn prove_in(&mut self, max_codes: u8, hits: &mut Hits<L>, sum: &mut PixelSum<L>) -> bool {
        L::vectorize(
            self.s,
            #[inline(always)]
            || self.next_deferred(max_codes, hits, sum),
        )
    }

    #[inline(always)]
    fn next_deferred(&mut self, max_codes: u8, hits: &mut Hits<L>, sum: &mut PixelSum<L>) -> bool {
        loop {
            while self.certificate.this_round > 0 {
                self.certificate.this_round -= 1;
                let Some(Deferred { mut rays, cones }) = self.certificate.deferred.pop(self.s) else { break };
                let unproved = self.unproved_lanes();
                self.omit(&rays, rays.active & !unproved);
                rays.active &= unproved;
                if rays.active != 0 {
                    if V::DETAILS {
                        self.cones.next = cones;
                    }
                    self.push(rays);
                    if !self.stack.is_empty() {
                        return true;
                    }
                }
            }
            self.end_of_round();
            let next = self.proof.packet + 1;
            if next < self.proof.packets() {
                self.resume(next, hits, sum);
            } else if !self.begin_round(max_codes, hits, sum) {
                return false;
            }
        }
    }

    /// Goes on with the deferred rays of another packet.
    #[inline(always)]
    fn resume(&mut self, packet: usize, hits: &mut Hits<L>, sum: &mut PixelSum<L>) {
        if packet != self.proof.packet {
            self.exchange(packet, sum);
            self.choose_samplers();
            self.make_choices(hits);
        }
    }

    /// Begins with another round; false if there is nothing more to be done.
    #[inline(always)]
    fn begin_round(&mut self, max_codes: u8, hits: &mut Hits<L>, sum: &mut PixelSum<L>) -> bool {
        self.judge(max_codes, sum);
        let s = self.s;
        let unproved = self.proof.unproved;
        let deferred = (0..self.proof.packets()).any(|packet| !self.certificate_of(packet).deferred.is_empty());
        if unproved == 0 || !deferred || self.proof.rounds == ROUNDS {
            return false;
        }
        self.proof.rounds += 1;
        // How many rays each sample may have in this round, and the samples of groups that have deferred many.
        let (mut most_followed, mut many) = ([0.0; BATCH], 0);
        for group in self.proof.batch.groups(unproved) {
            let (mut rays, mut wanted, mut count) = (0.0, 0.0, 0);
            for sample in lanes_of(group) {
                let certificate = self.certificate_of(sample / L::COUNT);
                let of_sample = certificate.rays.lane(sample % L::COUNT).to_f64();
                most_followed[sample] = of_sample.max(FIRST_RAYS);
                (rays, wanted) = (rays + of_sample, wanted + most_followed[sample]);
                count += certificate.deferred.count(sample % L::COUNT);
            }
            let left = (f64::from(Pruning::most_rays(group.count_ones())) - rays).max(0.0);
            let share = (left / wanted).min(1.0);
            lanes_of(group).for_each(|sample| most_followed[sample] = (most_followed[sample] * share).floor());
            many |= if count >= MANY { group } else { 0 };
        }
        for packet in 0..self.proof.packets() {
            let first = packet * L::COUNT;
            let mut most = [L::Real::default(); MAX_LANES];
            most.iter_mut().zip(&most_followed[first..]).for_each(|(most, rays)| *most = L::Real::from_f64(*rays));
            let many = L::mask(s, (many >> first) & L::ALL);
            let refinement = L::select(many, L::lit(s, COARSE_REFINEMENT), L::lit(s, REFINEMENT));
            let certificate = self.certificate_of_mut(packet);
            certificate.most_followed = L::load(s, &most);
            certificate.min_weight = certificate.min_weight * refinement;
            certificate.this_round = certificate.deferred.len();
        }
        self.resume(0, hits, sum);
        true
    }

    fn certificate_of(&self, packet: usize) -> &Certificate<L> {
        if packet == self.proof.packet { &self.certificate } else { &self.proof.waiting[packet].certificate }
    }

    fn certificate_of_mut(&mut self, packet: usize) -> &mut Certificate<L> {
        if packet == self.proof.packet { &mut self.certificate } else { &mut self.proof.waiting[packet].certificate }
    }

    /// Adds up the rays since the last round.
    #[inline(always)]
    fn end_of_round(&mut self) {
        self.certificate.rays = self.certificate.rays + self.followed;
        self.followed = L::lit(self.s, 0.0);
    }

    /// Finds the groups that may be more than `max_codes` off, and that more rays may prove.
    #[inline(always)]
    fn judge(&mut self, max_codes: u8, sum: &PixelSum<L>) {
        let standing = self.standing(sum);
        let mut unproved = 0;
        let batch = self.proof.batch;
        for group in batch.groups(self.proof.unproved) {
            let share = 1.0 / f64::from(group.count_ones());
            let (mut light, mut omitted, mut rays) = ([0.0; 3], [0.0; 3], 0.0);
            for sample in lanes_of(group) {
                for c in 0..3 {
                    light[c] += share * standing.light[c][sample];
                    omitted[c] += share * standing.omitted[c][sample];
                }
                rays += standing.rays[sample];
            }
            if omitted == [0.0; 3] {
                continue;
            }
            // No sample has more rays than all of them.
            let rounding = self.rounding(rays);
            let ends = interval(light, omitted, rounding);
            let proved = self.is_proved(group, max_codes, ends);
            // Where rounding alone may change a code, more rays do not help.
            let further = (0..3).any(|c| !proved[c] && omitted[c] > 0.5 * rounding * light[c]);
            if further {
                if self.is_within_reach(group, max_codes, ends, rays) {
                    unproved |= group;
                } else {
                    self.proof.given_up |= group;
                }
            }
        }
        self.proof.unproved = unproved;
    }

    /// Whether each channel of a group is proved.
    fn is_proved(&self, group: u32, max_codes: u8, ends: [[f32; 2]; 3]) -> [bool; 3] {
        let display = &self.world.display;
        match self.width(group, max_codes) {
            None => proved(display, ends, max_codes),
            Some(width) => share_of_code(display, ends, max_codes).map(|share| share <= width),
        }
    }

    /// The width that a group which is a part of its pixel must have; none if it is the whole.
    fn width(&self, group: u32, max_codes: u8) -> Option<f64> {
        let widths = if max_codes == 0 { EXACT_WIDTHS } else { WIDTHS };
        let samples = self.proof.batch.samples();
        let is_part = samples.is_part || group.count_ones() < samples.count;
        is_part.then(|| widths[self.proof.attempt])
    }

    /// Whether a group is likely proved before it has had all of its rays. What it misses falls as a power of the number of rays,
    /// which the rounds so far tell.
    #[inline(never)]
    fn is_within_reach(&mut self, group: u32, max_codes: u8, ends: [[f32; 2]; 3], rays: f64) -> bool {
        let count = |sample: usize| self.certificate_of(sample / L::COUNT).deferred.count(sample % L::COUNT);
        // A few rays are no explosion: they end at the depth that the picture is held against.
        if self.world.ceiling.reach.max_depth.is_some() && lanes_of(group).all(|sample| count(sample) <= CHAINS) {
            return true;
        }
        let most_rays = f64::from(Pruning::most_rays(group.count_ones()));
        let first = group.trailing_zeros() as usize;
        let before = self.proof.checkpoints[first];
        if rays >= most_rays {
            return false;
        }
        if rays < (FREE_SHARE * most_rays).max(1.5 * before.rays) {
            return true;
        }
        let omitted = ends.iter().map(|[low, high]| f64::from(high - low)).fold(0.0, f64::max);
        let rate = log2(before.omitted / omitted) / log2(rays / before.rays);
        self.proof.checkpoints[first] = Checkpoint { rays, omitted };
        // What is left are the skipped lights, which the next attempt does not skip.
        let skipped =
            |sample: usize| self.certificate_of(sample / L::COUNT).skipped_light.lane(sample % L::COUNT).to_f64();
        let skipped = lanes_of(group).map(skipped).sum::<f64>() / f64::from(group.count_ones());
        let excess = match self.width(group, max_codes) {
            None => excess(&self.world.display, ends, max_codes),
            Some(width) => {
                let shares = share_of_code(&self.world.display, ends, max_codes);
                shares.into_iter().fold(1.0, |most, share| f64::max(most, share / width))
            }
        };
        before.rays == 0.0 || skipped > 0.5 * omitted || rays * pow(excess, 1.0 / rate.max(1e-3)) <= HOPE * most_rays
    }

    /// How things stand with all samples.
    #[inline(always)]
    fn standing(&self, sum: &PixelSum<L>) -> Standing {
        let black = [[0.0; BATCH]; 3];
        let mut standing = Standing { light: black, omitted: black, rays: [0.0; BATCH] };
        for packet in 0..self.proof.packets() {
            let is_at_work = packet == self.proof.packet;
            let sum = if is_at_work { sum } else { &self.proof.waiting[packet].sum };
            let certificate = self.certificate_of(packet);
            let first = packet * L::COUNT;
            sum.store(&mut standing.light, first);
            let omitted = self.with_deferred(certificate);
            for (omitted, channel) in standing.omitted.iter_mut().zip([omitted.x, omitted.y, omitted.z]) {
                store(channel, omitted, first);
            }
            store(certificate.rays, &mut standing.rays, first);
        }
        standing
    }

    /// R and what the deferred rays of a packet can bring.
    #[inline(always)]
    fn with_deferred(&self, certificate: &Certificate<L>) -> V3<L> {
        let mut omitted = certificate.omitted;
        for (lanes, weight, depth) in certificate.deferred.weights() {
            omitted = V3::select(L::mask(self.s, lanes), omitted + self.upper_bound(weight, depth), omitted);
        }
        omitted
    }

    /// Omits the rays that are still deferred. Groups that are not proved because of skipped lights have to be traced again, now
    /// with every light: it resets them and returns whether there are any.
    #[inline(always)]
    pub(super) fn finish(&mut self, sum: &mut PixelSum<L>) -> bool {
        let proves = matches!(self.pruning, Pruning::Proved { .. });
        if !proves || (self.proof.waiting.is_empty() && self.is_complete()) {
            return false;
        }
        self.omit_deferred(sum)
    }

    #[inline(never)]
    fn omit_deferred(&mut self, sum: &mut PixelSum<L>) -> bool {
        L::vectorize(
            self.s,
            #[inline(always)]
            || self.omit_deferred_in(sum),
        )
    }

    #[inline(always)]
    fn omit_deferred_in(&mut self, sum: &mut PixelSum<L>) -> bool {
        let s = self.s;
        let zero = L::lit(s, 0.0);
        let mut skipped = 0;
        for packet in 0..self.proof.packets() {
            self.exchange(packet, sum);
            if O::WATCHING {
                while let Some(Deferred { rays, .. }) = self.certificate.deferred.pop(s) {
                    self.omit(&rays, rays.active);
                }
            }
            self.certificate.omitted = self.with_deferred(&self.certificate);
            self.certificate.deferred.clear();
            skipped |= (self.certificate.skipped_light.gt(zero).bits() & L::ALL) << self.proof.first();
        }
        let proof = &mut self.proof;
        let again = proof.groups_of(proof.unproved & skipped);
        proof.given_up |= proof.unproved & !again;
        proof.unproved = again;
        if again == 0 {
            return false;
        }
        proof.skips_lights = false;
        proof.rounds = 0;
        proof.checkpoints = [Checkpoint::default(); BATCH];
        if O::WATCHING {
            self.observer.again();
        }
        for packet in 0..self.proof.packets() {
            self.exchange(packet, sum);
            let lanes = self.unproved_lanes();
            sum.clear(s, lanes);
            let (mask, certificate) = (L::mask(s, lanes), &mut self.certificate);
            let black = V3 { x: zero, y: zero, z: zero };
            certificate.omitted = V3::select(mask, black, certificate.omitted);
            certificate.skipped_light = L::select(mask, zero, certificate.skipped_light);
        }
        true
    }

    /// The relative error of the sum of a sample with some rays.
    #[inline(always)]
    fn rounding(&self, rays: f64) -> f64 {
        let terms_of_ray = 1.0 + self.world.lights.len() as f64;
        relative_error::<L::Real>((rays + 2.0) * terms_of_ray)
    }

    /// What the samples brought.
    #[inline(always)]
    pub(super) fn store_light(&mut self, sum: &PixelSum<L>, brought: &mut BatchLight) {
        (brought.incomplete, brought.given_up) = (0, 0);
        if self.proof.waiting.is_empty() && self.incomplete() & L::ALL == 0 {
            sum.store(&mut brought.light, 0);
        } else {
            self.store_bounds(sum, brought);
        }
    }

    #[inline(never)]
    fn store_bounds(&mut self, sum: &PixelSum<L>, brought: &mut BatchLight) {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                let standing = self.standing(sum);
                (brought.light, brought.omitted) = (standing.light, standing.omitted);
                brought.given_up = self.proof.given_up;
                for sample in lanes_of(self.proof.batch.all()) {
                    brought.rounding[sample] = 0.0;
                    if (0..3).any(|c| brought.omitted[c][sample] > 0.0) {
                        brought.incomplete |= 1 << sample;
                        brought.rounding[sample] = self.rounding(standing.rays[sample]);
                    }
                }
            },
        );
    }
}

/// Writes the numbers of lanes from sample `first` on.
#[inline(always)]
fn store<L: Lanes>(numbers: L, all: &mut [f64; BATCH], first: usize) {
    let mut parts = [L::Real::default(); MAX_LANES];
    numbers.store(&mut parts);
    all[first..first + L::COUNT].iter_mut().zip(&parts).for_each(|(number, part)| *number = part.to_f64());
}
