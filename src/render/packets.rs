//! Packets of pixels through the kernels, and what becomes of them.

use super::costs::PixelCost;
use super::probe::PacketCost;
use super::statistical::Reached;
use super::{Lacking, LackingPixels, RayCounts};
use crate::camera::Camera;
use crate::film::srgb::Codes8;
use crate::lanes::{Lanes, MAX_LANES, Real, V3, dispatch, lanes_of};
use crate::scene::world::{Pruning, World};
use crate::shading::media::Medium;
use crate::trace::certificate::{ends, raised};
use crate::trace::enclosing::media_at;
use crate::trace::hits::Hits;
use crate::trace::kernel::{Followed, Tracer};
use crate::trace::observer::Observer;
use crate::trace::variants::{Clear, Detailed, DetailedMirrors, Effects, Everything, Local, Mirrors, Specialised};
use fearless_simd::{Level, f32x16, f64x8};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// The two kernels that pictures are traced with.
pub(crate) trait Kernel: Real {
    /// Traces the pixels at `at`.
    fn trace(level: Level, job: &Job<'_, Self>, at: &[[u32; 2]], samples: Samples, out: &mut Traced);
    /// The bodies around the eye.
    fn eye_media(world: &World<Self>) -> Vec<Medium<Self>>;
}

/// What all tiles of a picture share.
#[derive(Clone)]
pub(crate) struct Job<'a, R> {
    pub(super) world: &'a World<R>,
    pub(super) camera: Camera<R>,
    pub(super) eye: Vec<Medium<R>>,
    pub(super) cancelled: &'a AtomicBool,
    pub(super) kernel: Specialised,
    pub(super) pruning: Pruning,
    /// Whether pixels that are known to lie between two ends show their lower one.
    pub(super) low: bool,
    /// Whether it is noted what each packet takes.
    pub(super) watched: bool,
}

/// Which samples pixels get.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Samples {
    /// How many, at least 1.
    pub(crate) count: u32,
    /// 0 for those that pictures are made of, evenly spread. Any other number stands for others, as evenly spread, and
    /// independent of those of all other numbers.
    pub(crate) batch: u32,
}

impl Samples {
    /// Those that pictures are made of.
    pub(crate) fn of_picture(count: u32) -> Self {
        Self { count, batch: 0 }
    }
}

/// What became of some pixels.
#[derive(Default)]
pub(crate) struct Traced {
    /// In the order asked for.
    pub(crate) pixels: Vec<[f32; 3]>,
    /// Those that may lack light, in the same order if they were asked for at once.
    pub(super) lacking: LackingPixels,
    /// How unsure each pixel of several samples is, as they tell: the 8-bit codes from the lower to the upper end of an
    /// interval around it. In the same order.
    pub(super) widths: Vec<u8>,
    pub(crate) rays: RayCounts,
    /// How far each pixel has come, in the statistical mode.
    pub(super) reached: Reached,
    /// What each pixel took, if asked for.
    pub(super) costs: Vec<PixelCost>,
    /// What each packet took, if asked for.
    pub(super) packets: Vec<PacketCost>,
}

impl Traced {
    /// The parts one after the other.
    pub(super) fn joined(parts: Vec<Self>) -> Self {
        let mut all = Self::default();
        all.pixels.reserve(parts.iter().map(|part| part.pixels.len()).sum());
        for part in parts {
            all.pixels.extend(part.pixels);
            all.lacking.append(part.lacking);
            all.widths.extend(part.widths);
            all.costs.extend(part.costs);
            all.rays = all.rays + part.rays;
            all.reached = all.reached + part.reached;
        }
        all
    }
}

macro_rules! kernel {
    ($real:ident, $lanes:ident) => {
        impl Kernel for $real {
            fn trace(level: Level, job: &Job<'_, Self>, at: &[[u32; 2]], samples: Samples, out: &mut Traced) {
                dispatch!(level, s => match job.kernel {
                    Specialised::Local => trace_with::<$lanes<_>, Local>(s, job, at, samples, out),
                    Specialised::Mirrors => trace_with::<$lanes<_>, Mirrors>(s, job, at, samples, out),
                    Specialised::Clear => trace_with::<$lanes<_>, Clear>(s, job, at, samples, out),
                    Specialised::DetailedMirrors => trace_with::<$lanes<_>, DetailedMirrors>(s, job, at, samples, out),
                    Specialised::Detailed => trace_with::<$lanes<_>, Detailed>(s, job, at, samples, out),
                    Specialised::Everything => trace_with::<$lanes<_>, Everything>(s, job, at, samples, out),
                });
            }
            fn eye_media(world: &World<Self>) -> Vec<Medium<Self>> {
                eye_media::<Self>((), world)
            }
        }
    };
}

kernel!(f32, f32x16);
kernel!(f64, f64x8);

/// Names the instruction set's type once, so that the macro's argument can be a type over it.
#[inline(always)]
fn trace_with<L: Lanes, E: Effects>(
    s: L::Simd,
    job: &Job<'_, L::Real>,
    at: &[[u32; 2]],
    samples: Samples,
    out: &mut Traced,
) {
    let mut tracer = Tracer::<L, (), E>::new(s, job.world, &job.camera, &job.eye, job.cancelled, job.pruning, ());
    let mut hits = Hits::none(s);
    let (codes, mut all_lacking) = (Codes8::get(), Vec::new());
    let of_second = (0..samples.count).filter(|sample| is_of_second_half(*sample)).count() as f32;
    for packet in at.chunks(L::COUNT) {
        let started = job.watched.then(Instant::now);
        let active = ((1u64 << packet.len()) - 1) as u32;
        let mut sum = V3::splat(s, [L::Real::from_f64(0.0); 3]);
        let half = add_samples(&mut tracer, packet, active, samples, &mut hits, &mut sum);
        let [red, green, blue] = lanes(sum);
        let first = out.pixels.len();
        out.pixels.extend((0..packet.len()).map(|lane| [red[lane], green[lane], blue[lane]].map(narrow)));
        let lacking = tracer.lacking() & active;
        if lacking != 0 {
            let (rest, roundings) = (tracer.rest(), tracer.roundings());
            for lane in lanes_of(lacking) {
                let sum = [red[lane], green[lane], blue[lane]];
                let ends = ends(sum, rest.lane(lane), roundings.lane(lane));
                let (shown, highest) = if job.low {
                    (ends.map(|[low, _]| low), ends.map(|[_, high]| high))
                } else {
                    show(codes, sum, ends, job.pruning)
                };
                out.pixels[first + lane] = shown;
                all_lacking.push(Lacking { at: packet[lane], highest });
            }
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
            out.packets.push(PacketCost { rays, nanoseconds: started.elapsed().as_secs_f64() * 1e9 });
        }
    }
    out.lacking.add(all_lacking);
    out.rays = out.rays + tracer.counts;
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

/// What is shown of a pixel that lies between two ends, and what it is at most, seen from there.
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
            Pruning::Proved { max_codes } => sum[c] + raised(sum[c], ends[c], max_codes),
        });
        // Whatever lies some codes below, by rounding, counts as if it lay as many above.
        let [code, lower] = codes.code_and_lower(shown[c], low);
        let below = code - lower.min(code);
        highest[c] = high;
        if below > 0 && codes.code(high) - code < below {
            highest[c] = codes.least(code.saturating_add(below)).max(high);
        }
    }
    (shown, highest)
}

/// The codes between the ends of the interval around a pixel in which more samples would likely put it, in the channel that
/// is least sure: with the means a and b of two halves of its samples, the mean of all is likely as far off as |a - b|/2.
/// `second` is what the second half, `samples` of `count`, has added.
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

/// A channel of the film.
#[inline(always)]
fn narrow<R: Real>(channel: R) -> f32 {
    channel.to_f64() as f32
}

/// Adds all samples of a packet of pixels, each weighted 1/n. Returns what one half of them added.
#[inline(always)]
pub(crate) fn add_samples<L: Lanes, O: Observer<L>, E: Effects>(
    tracer: &mut Tracer<'_, L, O, E>,
    pixels: &[[u32; 2]],
    active: u32,
    samples: Samples,
    hits: &mut Hits<L>,
    sum: &mut V3<L>,
) -> V3<L> {
    let s = tracer.simd();
    let count = samples.count;
    let weight = L::Real::from_f64(1.0 / f64::from(count));
    let black = V3::splat(s, [L::Real::from_f64(0.0); 3]);
    let mut half = black;
    let mut rays = Followed::none(s);
    tracer.begin(pixels, samples);
    let (mut active, mut sample) = (active, 0);
    // One call of `follow_from` for the first rays of each sample and those put aside: it holds all of the kernel.
    while !tracer.is_cancelled() {
        let (before, second);
        if sample < count {
            let offset = sample_offset(sample, count);
            let (x, y) = (tracer.coordinates(0, offset[0]), tracer.coordinates(1, offset[1]));
            (before, second) = (*sum, is_of_second_half(sample));
            tracer.choose(sample);
            tracer.sample(x, y, active, weight, &mut rays, hits, sum);
            sample += 1;
        } else if tracer.prove(active, hits, sum) {
            if !tracer.pop(&mut rays) {
                continue;
            }
            (before, second) = (*sum, false);
        } else {
            active = tracer.finish(active, sum);
            if active == 0 {
                break;
            }
            sample = 0;
            half = V3::select(L::mask(s, active), black, half);
            continue;
        }
        tracer.follow_from(&mut rays, hits, sum);
        if second {
            half = half + (*sum - before);
        }
    }
    half
}

/// Whether a sample is of the second half, by the sum of its digits in base 2 (Thue and Morse): of any aligned run of
/// samples one half is of each, so that both are spread as evenly as all.
fn is_of_second_half(sample: u32) -> bool {
    !sample.count_ones().is_multiple_of(2)
}

/// The media around the eye, if all rays start there.
pub(crate) fn eye_media<L: Lanes>(s: L::Simd, world: &World<L::Real>) -> Vec<Medium<L::Real>> {
    if !world.transmits || !world.shared_eye {
        return Vec::new();
    }
    let eye = world.camera.primary(s, L::lit(s, 0.0), L::lit(s, 0.0)).origin.lane(0);
    media_at::<L>(s, world, eye, None)
}

/// Offset of sample i of n within its pixel: the Hammersley set, which puts one sample into each of n columns and of
/// n rows. A single sample is the pixel's centre.
pub fn sample_offset(i: u32, n: u32) -> [f64; 2] {
    let n = f64::from(n);
    // The van der Corput sequence reaches from 0 to 1 - 1/n on average one half of 1/n below the middle.
    let radical_inverse = f64::from(i.reverse_bits()) / 4_294_967_296.0;
    if n == 1.0 { [0.5, 0.5] } else { [(f64::from(i) + 0.5) / n, (radical_inverse + 0.5 / n).min(1.0 - 0.5 / n)] }
}
