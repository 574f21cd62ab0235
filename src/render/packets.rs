//! Packets of pixels: tracing them with a kernel, and collecting their results.

use super::adaptive_sampling::Reached;
use super::picture::PixelCost;
use super::probe::PacketCost;
use super::thread_time::ThreadTime;
use crate::bound::interval::{interval, raise};
use crate::bound::{BoundedPixel, BoundedPixels};
use crate::camera::Camera;
use crate::control::Control;
use crate::film::srgb::Codes8;
use crate::lanes::{Lanes, MAX_LANES, Real, V3, lanes_of};
use crate::scene::world::{Pruning, World};
use crate::shading::media::Medium;
use crate::trace::counts::RayCounts;
use crate::trace::hits::Hits;
use crate::trace::kernel::Tracer;
use crate::trace::pixel::{Samples, add_samples, is_of_second_half};
use crate::trace::variants::{KernelVariant, Variant};
use fearless_simd::Level;

/// A format with kernels: `f32` or `f64`.
pub(crate) trait KernelFormat: Real {
    /// Traces the pixels at `at`.
    fn trace(level: Level, job: &TraceJob<'_, Self>, at: &[[u32; 2]], samples: Samples, out: &mut Traced);
    /// The bodies around the eye.
    fn eye_media(world: &World<Self>) -> Vec<Medium<Self>>;
}

/// The data that all tiles of a picture share.
#[derive(Clone)]
pub(crate) struct TraceJob<'a, R> {
    pub(super) world: &'a World<R>,
    pub(super) camera: Camera<R>,
    pub(super) eye: Vec<Medium<R>>,
    pub(super) control: &'a Control,
    pub(super) kernel: KernelVariant,
    pub(super) pruning: Pruning,
    /// Whether pixels show the lower end of their interval.
    pub(super) low: bool,
    /// Whether the cost of each packet is recorded.
    pub(super) watched: bool,
}

/// The results of some pixels.
#[derive(Default)]
pub(crate) struct Traced {
    /// In the order asked for.
    pub(crate) pixels: Vec<[f32; 3]>,
    /// Those that may miss light, in the same order if they were traced by one call.
    pub(super) bounded: BoundedPixels,
    /// The interval of each pixel with several samples, in 8-bit codes from its lower to its upper end. In the same order.
    pub(super) widths: Vec<u8>,
    pub(crate) rays: RayCounts,
    /// The progress of the pixels in the statistical mode.
    pub(super) reached: Reached,
    /// The cost of each pixel, if asked for.
    pub(super) costs: Vec<PixelCost>,
    /// The cost of each packet, if asked for.
    pub(super) packets: Vec<PacketCost>,
}

impl Traced {
    /// The parts one after the other.
    pub(super) fn joined(parts: Vec<Self>) -> Self {
        let mut all = Self::default();
        all.pixels.reserve(parts.iter().map(|part| part.pixels.len()).sum());
        for part in parts {
            all.pixels.extend(part.pixels);
            all.bounded.append(part.bounded);
            all.widths.extend(part.widths);
            all.costs.extend(part.costs);
            all.rays = all.rays + part.rays;
            all.reached = all.reached + part.reached;
        }
        all
    }
}

/// Traces the pixels at `at`, a packet at a time.
#[inline(always)]
pub(super) fn trace_with<L: Lanes, V: Variant>(
    s: L::Simd,
    job: &TraceJob<'_, L::Real>,
    at: &[[u32; 2]],
    samples: Samples,
    out: &mut Traced,
) {
    let mut tracer = Tracer::<L, (), V>::new(s, job.world, &job.camera, &job.eye, job.pruning, ());
    let mut hits = Hits::none(s);
    let mut all_bounded = Vec::new();
    let of_second = (0..samples.count).filter(|sample| is_of_second_half(*sample)).count() as f32;
    for packet in at.chunks(L::COUNT) {
        let started = job.watched.then(ThreadTime::start);
        let active = ((1u64 << packet.len()) - 1) as u32;
        let mut sum = V3::splat(s, [L::Real::from_f64(0.0); 3]);
        let half = add_samples(&mut tracer, packet, active, samples, &mut hits, &mut sum);
        let [red, green, blue] = lanes(sum);
        let first = out.pixels.len();
        out.pixels.extend((0..packet.len()).map(|lane| [red[lane], green[lane], blue[lane]].map(narrow)));
        let bounded = tracer.incomplete() & active;
        if bounded != 0 {
            show_bounded(&tracer, job.low, packet, bounded, &sum, &mut out.pixels[first..], &mut all_bounded);
        }
        if samples.count > 1 && !job.low {
            let halves = lanes(half);
            out.widths.extend((0..packet.len()).map(|lane| {
                let half = [halves[0][lane], halves[1][lane], halves[2][lane]].map(narrow);
                width(out.pixels[first + lane], half, samples.count, of_second)
            }));
        }
        if let Some(started) = started {
            let rays = std::mem::take(&mut tracer.counts);
            out.rays = out.rays + rays;
            out.packets.push(PacketCost { rays, nanoseconds: started.nanoseconds() });
        }
    }
    out.bounded.add(all_bounded);
    out.rays = out.rays + tracer.counts;
}

/// Decides what is shown of the pixels of a packet that may miss light, and lists their upper bounds.
#[inline(never)]
fn show_bounded<L: Lanes, V: Variant>(
    tracer: &Tracer<'_, L, (), V>,
    low: bool,
    packet: &[[u32; 2]],
    lanes: u32,
    sum: &V3<L>,
    pixels: &mut [[f32; 3]],
    bounded: &mut Vec<BoundedPixel>,
) {
    L::vectorize(
        tracer.simd(),
        #[inline(always)]
        || {
            let (codes, omitted, roundings) = (Codes8::get(), tracer.omitted(), tracer.roundings());
            for lane in lanes_of(lanes) {
                let sum = sum.lane(lane);
                let ends = interval(sum, omitted.lane(lane), roundings.lane(lane));
                let (shown, highest) = if low {
                    (ends.map(|[low, _]| low), ends.map(|[_, high]| high))
                } else {
                    show(codes, sum, ends, tracer.pruning)
                };
                pixels[lane] = shown;
                bounded.push(BoundedPixel { at: packet[lane], highest });
            }
        },
    );
}

/// The numbers in each lane, channel by channel.
#[inline(always)]
fn lanes<L: Lanes>(v: V3<L>) -> [[L::Real; MAX_LANES]; 3] {
    let mut channels = [[L::Real::default(); MAX_LANES]; 3];
    for (channel, lanes) in channels.iter_mut().zip([v.x, v.y, v.z]) {
        lanes.store(channel);
    }
    channels
}

/// What is shown of a pixel with an interval, and its upper bound as seen from there.
#[inline(always)]
pub(super) fn show<R: Real>(
    codes: &Codes8,
    sum: [R; 3],
    ends: [[f32; 2]; 3],
    pruning: Pruning,
) -> ([f32; 3], [f32; 3]) {
    let (mut shown, mut highest) = ([0.0; 3], [0.0; 3]);
    for c in 0..3 {
        let [low, high] = ends[c];
        shown[c] = narrow(match pruning {
            Pruning::Weight(_) => sum[c],
            Pruning::Proved { max_codes } => sum[c] + raise(sum[c], ends[c], max_codes),
        });
        // Codes that the lower end lies below, because of rounding, count as if they lay above.
        let [code, lower] = codes.code_and_lower(shown[c], low);
        let below = code - lower.min(code);
        highest[c] = high;
        if below > 0 && codes.code(high) - code < below {
            highest[c] = codes.least(code.saturating_add(below)).max(high);
        }
    }
    (shown, highest)
}

/// The width in codes of the interval around a pixel in which more samples would likely put it, in its worst channel. With
/// the means a and b of two halves of its samples, the error of the mean of all is likely |a - b|/2. `second` is the sum of
/// the second half, which has `samples` of `count`.
fn width(mean: [f32; 3], second: [f32; 3], count: u32, samples: f32) -> u8 {
    let codes = Codes8::get();
    let count = count as f32;
    let channel = |c: usize| {
        let first = (mean[c] - second[c]) * count / (count - samples);
        let off = (0.5 * (first - second[c] * count / samples)).abs();
        codes.code(mean[c] + off) - codes.code(mean[c] - off)
    };
    channel(0).max(channel(1)).max(channel(2))
}

/// A channel in the format of films.
#[inline(always)]
fn narrow<R: Real>(channel: R) -> f32 {
    channel.to_f64() as f32
}
