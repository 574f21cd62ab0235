//! The samples of a packet of pixels: where they lie, and their sum.

use super::eye_media::media_at;
use super::hits::Hits;
use super::kernel::Tracer;
use super::observer::Observer;
use super::ray_packet::RayPacket;
use super::variants::Variant;
use crate::control;
use crate::lanes::{Lanes, Real, V3};
use crate::scene::world::World;
use crate::shading::media::Medium;

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

/// Adds all samples of a packet of pixels, each weighted 1/n. Returns what one half of them added.
#[inline(always)]
pub(crate) fn add_samples<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
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
    let mut rays = RayPacket::none(s);
    tracer.begin_packet(pixels, samples);
    let (mut active, mut sample) = (active, 0);
    // One call of `follow_from` for the first rays of each sample and those put aside: it holds all of the kernel.
    while !control::is_stopping() {
        let (before, second);
        if sample < count {
            let offset = sample_offset(sample, count);
            let (x, y) = (tracer.coordinates(0, offset[0]), tracer.coordinates(1, offset[1]));
            (before, second) = (*sum, is_of_second_half(sample));
            tracer.begin_sample(sample);
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
pub(crate) fn is_of_second_half(sample: u32) -> bool {
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
