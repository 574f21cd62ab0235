//! The proof that what a batch omits does not change the picture.
//!
//! Since sRGB codes grow with light, the code of a group of samples lies between those of both ends of its interval
//! (`certificate.rs`). Rays of little weight (w U < tau) are deferred at first. While the two codes are too far apart, deferred
//! rays are followed after all, the heavier ones first, in rounds.
//! `judgement.rs` says which groups those are.

use super::batch::{BATCH, SampleBatch};
use super::certificate::Certificate;
use super::deferred::Deferred;
use super::hits::Hits;
use super::judgement::Checkpoint;
use super::kernel::Tracer;
use super::observer::Observer;
use super::pixel_sum::PixelSum;
use super::sampling::Sampler;
use crate::bound::ceiling::Ceiling;
use crate::film::Display;
use crate::lanes::{Lanes, MAX_LANES, Mask, Real, V3, lanes_of};
use crate::scene::world::Pruning;
use crate::trace::variants::Variant;

/// tau: w U below which rays are deferred at first, for a pixel that may be 0, 1 or 2 codes off. With these numbers and the
/// next ones the scenes of the repository take the fewest rays.
const FIRST_THRESHOLD: [f64; 3] = [1e-3, 1e-2, 2e-2];
/// A ceiling so high overstates what most rays bring, as that of highlights on clearcoat and glass does: in the end nearly all are
/// followed. Then they are at once, down to this share of tau.
const LOOSE: f64 = 32.0;
const LEAST_OF_FIRST: f64 = 0.1;
/// Most light that all skipped lights together could add.
const SKIPPED_LIGHT: [f64; 3] = [1e-5, 1.2e-3, 2.4e-3];
/// Factor on tau from one round to the next. Fewer rounds follow up to 0.05 more rays, which fill their packets better: many lanes
/// of a packet pass a lower threshold at once. Where every code counts, scenes of mirrors face to face would take twice the time.
const REFINEMENT: [f64; 3] = [0.75, 0.3, 0.3];
/// Rays that each sample may have in the first round, and at least as many in others, until its threshold rises.
pub(super) const FIRST_RAYS: f64 = 512.0;
/// Rays until it rises again.
pub(super) const MORE_RAYS: f64 = 64.0;
/// Factor on the threshold.
pub(super) const RISE: f64 = 2.0;
/// The most that the factor is where a group has deferred so many rays that looking through them takes longer than following more
/// rays than needed.
const COARSE_REFINEMENT: f64 = 0.5;
/// How many those are.
const MANY: u32 = 256;
/// Rounds until the proof of a batch is given up: 0.75^80 is 1e-10.
const ROUNDS: u32 = 80;
/// How often a pixel of several groups is traced before its proof is given up.
pub(crate) const ATTEMPTS: usize = 3;

/// The w U below which rays are deferred or omitted, and the most light that skipped lights could add.
pub(super) fn thresholds(pruning: Pruning, display: &Display, ceiling: &Ceiling) -> (f64, f64) {
    match pruning {
        Pruning::Weight(min_weight) => (min_weight, 0.0),
        Pruning::Proved { max_codes } => {
            let codes = usize::from(max_codes.min(2));
            let highest = ceiling.of(u32::MAX).into_iter().fold(0.0, f64::max);
            let looseness = (LOOSE / highest).clamp(LEAST_OF_FIRST, 1.0);
            // A brighter exposure shows less light.
            (looseness * FIRST_THRESHOLD[codes] / display.gain(), SKIPPED_LIGHT[codes] / display.gain())
        }
    }
}

/// The state of proving a batch.
#[derive(Debug)]
pub(super) struct BatchProof<L: Lanes> {
    pub(super) batch: SampleBatch,
    /// The packet at work.
    pub(super) packet: usize,
    /// The others, and a place for that one; empty if a batch is a packet.
    pub(super) waiting: Vec<WaitingPacket<L>>,
    /// Samples that are not proved yet.
    pub(super) unproved: u32,
    /// Samples whose proof was given up.
    pub(super) given_up: u32,
    /// How near each group was to its proof, by its first sample.
    pub(super) checkpoints: [Checkpoint; BATCH],
    /// Rounds so far.
    rounds: u32,
    /// Whether lights that add little may be skipped.
    pub(super) skips_lights: bool,
    /// Which attempt this is.
    pub(super) attempt: usize,
}

/// A packet of the batch that is not at work.
#[derive(Debug)]
pub(super) struct WaitingPacket<L: Lanes> {
    pub(super) certificate: Certificate<L>,
    pub(super) sum: PixelSum<L>,
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
    pub(super) fn packets(&self) -> usize {
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
                if self.stays_deferred() {
                    self.certificate.deferred.put_back();
                    continue;
                }
                let Some(Deferred { mut rays, cones }) = self.certificate.deferred.pop(self.s) else { break };
                let unproved = self.unproved_lanes();
                self.omit(&rays, rays.active & !unproved);
                rays.active &= unproved;
                if rays.active != 0 {
                    if V::FOOTPRINTS {
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

    /// Whether all rays of the first deferred packet are still too light, and of samples that are not proved. They would be
    /// deferred again.
    #[inline(always)]
    fn stays_deferred(&self) -> bool {
        let Some((lanes, weight, depth, straight)) = self.certificate.deferred.front() else { return false };
        lanes & !self.unproved_lanes() == 0 && self.significant(weight, depth, straight) & lanes == 0
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
        let refinement = REFINEMENT[usize::from(max_codes.min(2))];
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
            let refinement = L::select(many, L::lit(s, refinement.min(COARSE_REFINEMENT)), L::lit(s, refinement));
            let certificate = self.certificate_of_mut(packet);
            certificate.most_followed = L::load(s, &most);
            certificate.min_weight = certificate.min_weight * refinement;
            certificate.this_round = certificate.deferred.len();
        }
        self.resume(0, hits, sum);
        true
    }

    pub(super) fn certificate_of(&self, packet: usize) -> &Certificate<L> {
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
            if self.is_transparent() {
                self.certificate.unseen = self.unseen_with_deferred(&self.certificate);
            }
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
            certificate.clear = L::select(mask, zero, certificate.clear);
            let black = V3 { x: zero, y: zero, z: zero };
            certificate.omitted = V3::select(mask, black, certificate.omitted);
            certificate.unseen = L::select(mask, zero, certificate.unseen);
            certificate.skipped_light = L::select(mask, zero, certificate.skipped_light);
        }
        true
    }
}
