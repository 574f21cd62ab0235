//! Tracing pixels with a kernel, and collecting their results.

use super::picture::PixelCost;
use super::probe::PacketCost;
use super::sample_sums::{PIXELS, PixelSums, SampleSums, trace_samples};
use super::statistical_sampling::Reached;
use super::thread_time::ThreadTime;
use crate::bound::interval::raise;
use crate::bound::{BoundedPixel, BoundedPixels};
use crate::camera::Camera;
use crate::control::Control;
use crate::film::Display;
use crate::film::srgb::Codes8;
use crate::lanes::{Lanes, Real, lanes_of};
use crate::scene::world::{Pruning, World};
use crate::shading::media::Medium;
use crate::trace::counts::{LaneCounts, RayCounts};
use crate::trace::hits::Hits;
use crate::trace::kernel::Tracer;
use crate::trace::pixel::Samples;
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
    /// Whether the sums of pixels are wanted, not what is shown of them.
    pub(super) sums: bool,
    /// Whether the cost of each packet is recorded.
    pub(super) watched: bool,
    /// Whether that of each pixel is: its rays, and with the packets' costs its part of their time.
    pub(super) measured: bool,
}

/// The results of some pixels.
#[derive(Default)]
pub(crate) struct Traced {
    /// In the order asked for.
    pub(crate) pixels: Vec<[f32; 3]>,
    /// Their alpha, if the background is transparent.
    pub(super) alpha: Vec<f32>,
    /// The sums of their samples instead, if asked for.
    pub(super) sums: Vec<PixelSums>,
    /// Those that may miss light, in the same order if they were traced by one call.
    pub(super) bounded: BoundedPixels,
    /// The interval of each pixel with several samples, in 8-bit codes from its lower to its upper end. In the same order.
    pub(super) widths: Vec<u8>,
    pub(crate) rays: RayCounts,
    /// How many samples the pixels got, where each gets as many as it asks for.
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
        all.alpha.reserve(parts.iter().map(|part| part.alpha.len()).sum());
        parts.into_iter().for_each(|part| all.append(part));
        all
    }

    /// Puts the pixels of a part and their alpha to some places, and adds what else is known of it.
    pub(super) fn put(&mut self, places: impl Iterator<Item = usize> + Clone, mut part: Self) {
        places.clone().zip(part.pixels.drain(..)).for_each(|(place, pixel)| self.pixels[place] = pixel);
        places.zip(part.alpha.drain(..)).for_each(|(place, alpha)| self.alpha[place] = alpha);
        self.append(part);
    }

    /// Adds those of others.
    pub(super) fn append(&mut self, part: Self) {
        self.pixels.extend(part.pixels);
        self.alpha.extend(part.alpha);
        self.sums.extend(part.sums);
        self.bounded.append(part.bounded);
        self.widths.extend(part.widths);
        self.costs.extend(part.costs);
        self.packets.extend(part.packets);
        self.rays = self.rays + part.rays;
        self.reached = self.reached + part.reached;
    }
}

/// Traces the pixels at `at`, a few at a time.
#[inline(always)]
pub(super) fn trace_with<L: Lanes, V: Variant>(
    s: L::Simd,
    job: &TraceJob<'_, L::Real>,
    at: &[[u32; 2]],
    samples: Samples,
    out: &mut Traced,
) {
    let mut tracer = Tracer::<L, (), V>::new(s, job.world, &job.camera, &job.eye, job.pruning, ());
    tracer.lane_counts = job.measured.then(Box::default);
    let mut hits = Hits::none(s);
    let mut bounded = Vec::new();
    let mut sums = SampleSums::new(samples, job.world.transparent);
    for pixels in at.chunks(PIXELS) {
        let started = job.watched.then(ThreadTime::start);
        let mut counts = LaneCounts::default();
        trace_samples(&mut tracer, pixels, &mut hits, &mut sums, &mut counts);
        show_pixels(job, pixels, &sums, out, &mut bounded);
        let nanoseconds = started.map(|started| started.nanoseconds());
        if let Some(nanoseconds) = nanoseconds {
            let rays = std::mem::take(&mut tracer.counts);
            out.rays = out.rays + rays;
            out.packets.push(PacketCost { rays, nanoseconds });
        }
        if job.measured {
            out.costs.extend(costs(pixels, samples.count, &counts, nanoseconds.unwrap_or(0.0)));
        }
    }
    out.bounded.add(bounded);
    out.rays = out.rays + tracer.counts;
}

/// Decides what is shown of pixels, and lists the upper bounds of those that may miss light.
#[inline(never)]
fn show_pixels<R: Real>(
    job: &TraceJob<'_, R>,
    pixels: &[[u32; 2]],
    sums: &SampleSums,
    out: &mut Traced,
    bounded: &mut Vec<BoundedPixel>,
) {
    if job.sums {
        out.sums.extend((0..pixels.len()).map(|pixel| sums.pixel(pixel)));
        return;
    }
    let display = &job.world.display;
    let first = out.pixels.len();
    if let Some([red, green, blue]) = sums.single() {
        let light = red.iter().zip(green).zip(blue).take(pixels.len());
        out.pixels.extend(light.map(|((red, green), blue)| [*red as f32, *green as f32, *blue as f32]));
    } else {
        for pixel in 0..pixels.len() {
            let mean = sums.mean(pixel);
            let shown = mean.light.map(|channel| channel as f32);
            out.pixels.push(shown);
            if !job.low {
                let of_colors = width(display, shown, mean.halves);
                let is_transparent = job.world.transparent;
                out.widths.push(if is_transparent {
                    of_colors.max(sums.pixel(pixel).width_of_alpha())
                } else {
                    of_colors
                });
            }
        }
    }
    if job.world.transparent {
        out.alpha.extend((0..pixels.len()).map(|pixel| sums.pixel(pixel).alpha()));
    }
    for pixel in lanes_of(sums.incomplete()) {
        let mean = sums.mean(pixel);
        let (shown, highest) = show_bounded(job, mean.light, mean.ends());
        let least_alpha = if job.world.transparent { sums.pixel(pixel).least_alpha() } else { 0.0 };
        out.pixels[first + pixel] = shown;
        bounded.push(BoundedPixel { at: pixels[pixel], highest, least_alpha });
    }
}

/// Decides what is shown of a pixel, and lists its upper bound if it may miss light.
pub(super) fn show_pixel<R: Real>(
    job: &TraceJob<'_, R>,
    at: [u32; 2],
    sums: &PixelSums,
    out: &mut Traced,
    bounded: &mut Vec<BoundedPixel>,
) {
    if job.world.transparent {
        out.alpha.push(sums.alpha());
    }
    let mean = sums.mean();
    if !sums.is_incomplete() {
        return out.pixels.push(mean.light.map(|channel| channel as f32));
    }
    let (shown, highest) = show_bounded(job, mean.light, mean.ends());
    out.pixels.push(shown);
    let least_alpha = if job.world.transparent { sums.least_alpha() } else { 0.0 };
    bounded.push(BoundedPixel { at, highest, least_alpha });
}

/// What is shown of a pixel that may miss light, and its upper bound. It takes no whole mean, which would then be worked out with its
/// halves.
fn show_bounded<R: Real>(job: &TraceJob<'_, R>, light: [f64; 3], ends: [[f32; 2]; 3]) -> ([f32; 3], [f32; 3]) {
    if job.low {
        (ends.map(|[low, _]| low), ends.map(|[_, high]| high))
    } else {
        show(&job.world.display, light, ends, job.pruning)
    }
}

/// The costs of pixels, which share their time by their rays.
fn costs(pixels: &[[u32; 2]], samples: u32, counts: &LaneCounts, nanoseconds: f64) -> impl Iterator<Item = PixelCost> {
    let all: u64 = counts.rays.iter().map(|rays| u64::from(*rays)).sum();
    let each = nanoseconds / all.max(1) as f64;
    pixels.iter().zip(counts.rays).zip(counts.deepest).map(move |((at, rays), deepest)| PixelCost {
        at: *at,
        samples,
        rays: u64::from(rays),
        nanoseconds: (f64::from(rays) * each) as u64,
        deepest,
    })
}

/// What is shown of a pixel with an interval, and its upper bound as seen from there.
#[inline(always)]
pub(super) fn show(display: &Display, sum: [f64; 3], ends: [[f32; 2]; 3], pruning: Pruning) -> ([f32; 3], [f32; 3]) {
    if !display.is_plain() {
        return show_curved(display, sum.map(|channel| channel as f32), ends);
    }
    let codes = Codes8::get();
    let (mut shown, mut highest) = ([0.0; 3], [0.0; 3]);
    for c in 0..3 {
        let [low, high] = ends[c];
        shown[c] = match pruning {
            Pruning::Weight(_) => sum[c],
            Pruning::Proved { max_codes } => sum[c] + raise(sum[c], ends[c], max_codes),
        } as f32;
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

/// [`show`] where codes are not those of the light itself: the sum, and an upper bound that covers the lower end, too.
#[inline(never)]
fn show_curved(display: &Display, sum: [f32; 3], ends: [[f32; 2]; 3]) -> ([f32; 3], [f32; 3]) {
    let (low, high) = (ends.map(|[low, _]| low), ends.map(|[_, high]| high));
    let needed = display.codes_around(sum, low, high);
    let mut highest = high;
    // The lower end lies below the sum by rounding alone, so there is nearly always nothing to do.
    for _ in 0..64 {
        if display.codes_off(sum, highest).iter().zip(&needed).all(|(off, needed)| off >= needed) {
            return (sum, highest);
        }
        highest = std::array::from_fn(|c| 2.0 * highest[c] - sum[c] + f32::MIN_POSITIVE);
    }
    (low, high)
}

/// The width in codes of the interval around a pixel in which more samples would likely put it, in its worst channel. With
/// the means a and b of two halves of its samples, the error of the mean of all is likely |a - b|/2.
fn width(display: &Display, mean: [f32; 3], [first, second]: [[f64; 3]; 2]) -> u8 {
    let codes = Codes8::get();
    let off: [f32; 3] = std::array::from_fn(|c| (0.5 * (first[c] - second[c])).abs() as f32);
    let ends = display.ends(std::array::from_fn(|c| mean[c] - off[c]), std::array::from_fn(|c| mean[c] + off[c]));
    ends.into_iter().map(|[low, high]| codes.code(high) - codes.code(low)).fold(0, u8::max)
}
