//! The judgement of a batch: which groups of its samples are proved, and which more rays may prove.
//!
//! A group that is a whole pixel is held against codes. What is proved of one that is a part of a pixel is its width, as a share
//! of a code there: codes are concave in light, so the interval of the mean is no wider than the intervals of the parts. It may
//! still contain the border of a code. Then all groups of the pixel are traced again, with narrower intervals.

use super::batch::{BATCH, BatchLight};
use super::certificate::Certificate;
use super::kernel::Tracer;
use super::observer::Observer;
use super::pixel_sum::{PixelSum, relative_error};
use super::proof::ATTEMPTS;
use crate::bound::interval::{Background, alpha_allowed, excess, interval, proved, share_of_code};
use crate::lanes::{Lanes, MAX_LANES, Real, V3, lanes_of};
use crate::math::{log2, pow};
use crate::scene::world::Pruning;
use crate::trace::variants::Variant;

/// Rays that a proof seems to need, as a multiple of those it may have, until it is given up: the last ones often bring more.
const GIVE_UP_FACTOR: f64 = 2.0;
/// Share of the rays of a group that may be followed before its proof must come nearer.
const FREE_SHARE: f64 = 1.0 / 40.0;
/// Deferred rays of a sample that stand for chains which do not branch.
const CHAINS: u32 = 2;
/// Widths that parts of pixels are proved to have, one for each attempt, as shares of what a whole pixel may have.
const WIDTHS: [f64; ATTEMPTS] = [0.9, 0.3, 0.05];
/// Those of pixels that may be 0 codes off, as shares of a code.
const EXACT_WIDTHS: [f64; ATTEMPTS] = [1.0 / 32.0, 1.0 / 2_048.0, 1.0 / 1_048_576.0];

/// How near a group was to its proof.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Checkpoint {
    /// Its rays until then.
    rays: f64,
    /// The light that it missed at most.
    omitted: f64,
}

/// What is known of the samples of a batch so far.
struct BatchState {
    light: [[f64; BATCH]; 3],
    omitted: [[f64; BATCH]; 3],
    rays: [f64; BATCH],
}

impl<L: Lanes, O: Observer<L>, V: Variant> Tracer<'_, L, O, V> {
    /// Finds the groups that may be more than `max_codes` off, and that more rays may prove.
    #[inline(always)]
    pub(super) fn judge(&mut self, max_codes: u8, sum: &PixelSum<L>) {
        let state = self.state(sum);
        let background = if self.is_transparent() { Some(self.background_seen()) } else { None };
        let mut unproved = 0;
        let batch = self.proof.batch;
        for group in batch.groups(self.proof.unproved) {
            let share = 1.0 / f64::from(group.count_ones());
            let (mut light, mut omitted, mut rays) = ([0.0; 3], [0.0; 3], 0.0);
            for sample in lanes_of(group) {
                for c in 0..3 {
                    light[c] += share * state.light[c][sample];
                    omitted[c] += share * state.omitted[c][sample];
                }
                rays += state.rays[sample];
            }
            let of_group = |all: &[f64; BATCH]| lanes_of(group).map(|sample| share * all[sample]).sum::<f64>();
            let seen = background.as_ref().map(|background| background.each_ref().map(of_group));
            let unseen = seen.map_or(0.0, |[_, unseen]| unseen);
            if omitted == [0.0; 3] && unseen == 0.0 {
                continue;
            }
            // No sample has more rays than all of them.
            let rounding = self.rounding(rays);
            let ends = interval(light, omitted, rounding);
            let proved = self.is_proved(group, max_codes, ends, seen);
            // Where rounding alone may change a code, more rays do not help.
            let further = (0..3).any(|c| !proved[c] && omitted[c] > 0.5 * rounding * light[c]);
            if further || (proved != [true; 3] && unseen > 0.5 * rounding) {
                if self.is_within_reach(group, max_codes, ends, seen, rays) {
                    unproved |= group;
                } else {
                    self.proof.given_up |= group;
                }
            }
        }
        self.proof.unproved = unproved;
    }

    /// Whether each channel of a group is proved, and its alpha.
    fn is_proved(&self, group: u32, max_codes: u8, ends: [[f32; 2]; 3], seen: Background) -> [bool; 3] {
        let display = &self.world.display;
        match self.width(group, max_codes) {
            None => proved(display, ends, seen, max_codes),
            Some(width) => {
                let is_seen = seen.is_none_or(|[_, unseen]| unseen <= width * alpha_allowed(max_codes));
                share_of_code(display, ends, seen, max_codes).map(|share| is_seen && share <= width)
            }
        }
    }

    /// How much each sample sees of a transparent background, and the most that it may have missed.
    #[inline(never)]
    fn background_seen(&self) -> [[f64; BATCH]; 2] {
        let [mut clear, mut unseen] = [[0.0; BATCH]; 2];
        self.store_clear(&mut clear);
        self.store_unseen(&mut unseen);
        [clear, unseen]
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
    fn is_within_reach(&mut self, group: u32, max_codes: u8, ends: [[f32; 2]; 3], seen: Background, rays: f64) -> bool {
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
        let unseen = seen.map_or(0.0, |[_, unseen]| unseen);
        let omitted = ends.iter().map(|[low, high]| f64::from(high - low)).fold(unseen, f64::max);
        let rate = log2(before.omitted / omitted) / log2(rays / before.rays);
        self.proof.checkpoints[first] = Checkpoint { rays, omitted };
        // What is left are the skipped lights, which the next attempt does not skip.
        let skipped =
            |sample: usize| self.certificate_of(sample / L::COUNT).skipped_light.lane(sample % L::COUNT).to_f64();
        let skipped = lanes_of(group).map(skipped).sum::<f64>() / f64::from(group.count_ones());
        let excess = match self.width(group, max_codes) {
            None => excess(&self.world.display, ends, seen, max_codes),
            Some(width) => {
                let shares = share_of_code(&self.world.display, ends, seen, max_codes);
                shares.into_iter().fold(1.0, |most, share| f64::max(most, share / width))
            }
        };
        let excess = excess.max(unseen / (self.width(group, max_codes).unwrap_or(1.0) * alpha_allowed(max_codes)));
        before.rays == 0.0
            || skipped > 0.5 * omitted
            || rays * pow(excess, 1.0 / rate.max(1e-3)) <= GIVE_UP_FACTOR * most_rays
    }

    /// What is known of all samples so far.
    #[inline(always)]
    fn state(&self, sum: &PixelSum<L>) -> BatchState {
        let black = [[0.0; BATCH]; 3];
        let mut state = BatchState { light: black, omitted: black, rays: [0.0; BATCH] };
        for packet in 0..self.proof.packets() {
            let is_at_work = packet == self.proof.packet;
            let sum = if is_at_work { sum } else { &self.proof.waiting[packet].sum };
            let certificate = self.certificate_of(packet);
            let first = packet * L::COUNT;
            sum.store(&mut state.light, first);
            let omitted = self.with_deferred(certificate);
            for (omitted, channel) in state.omitted.iter_mut().zip([omitted.x, omitted.y, omitted.z]) {
                store(channel, omitted, first);
            }
            store(certificate.rays, &mut state.rays, first);
        }
        state
    }

    /// R and what the deferred rays of a packet can bring.
    #[inline(always)]
    pub(super) fn with_deferred(&self, certificate: &Certificate<L>) -> V3<L> {
        let mut omitted = certificate.omitted;
        for (lanes, weight, depth) in certificate.deferred.weights() {
            omitted = V3::select(L::mask(self.s, lanes), omitted + self.upper_bound(weight, depth), omitted);
        }
        omitted
    }

    /// What the omitted and the deferred rays of a packet can see of a transparent background.
    #[inline(never)]
    pub(super) fn unseen_with_deferred(&self, certificate: &Certificate<L>) -> L {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                let mut unseen = certificate.unseen;
                for (lanes, weight, depth) in certificate.deferred.weights_of_straight() {
                    unseen = L::select(L::mask(self.s, lanes), unseen + self.clear_bound(weight, depth), unseen);
                }
                unseen
            },
        )
    }

    /// Writes how much of a transparent background each sample may have missed.
    #[inline(never)]
    fn store_unseen(&self, unseen: &mut [f64; BATCH]) {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                for packet in 0..self.proof.packets() {
                    store(self.unseen_with_deferred(self.certificate_of(packet)), unseen, packet * L::COUNT);
                }
            },
        );
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
        if self.is_transparent() {
            self.store_clear(&mut brought.clear);
        }
        if self.proof.waiting.is_empty() && self.incomplete() & L::ALL == 0 {
            sum.store(&mut brought.light, 0);
        } else {
            self.store_bounds(sum, brought);
        }
    }

    /// Writes how much each sample sees of the background.
    #[inline(never)]
    fn store_clear(&self, clear: &mut [f64; BATCH]) {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                for packet in 0..self.proof.packets() {
                    store(self.certificate_of(packet).clear, clear, packet * L::COUNT);
                }
            },
        );
    }

    #[inline(never)]
    fn store_bounds(&mut self, sum: &PixelSum<L>, brought: &mut BatchLight) {
        L::vectorize(
            self.s,
            #[inline(always)]
            || {
                let state = self.state(sum);
                (brought.light, brought.omitted) = (state.light, state.omitted);
                if self.is_transparent() {
                    self.store_unseen(&mut brought.unseen);
                }
                brought.given_up = self.proof.given_up;
                for sample in lanes_of(self.proof.batch.all()) {
                    brought.rounding[sample] = 0.0;
                    let lacks_background = self.is_transparent() && brought.unseen[sample] > 0.0;
                    if lacks_background || (0..3).any(|c| brought.omitted[c][sample] > 0.0) {
                        brought.incomplete |= 1 << sample;
                        brought.rounding[sample] = self.rounding(state.rays[sample]);
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
