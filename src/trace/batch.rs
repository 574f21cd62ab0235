//! Batches of samples: which samples are traced together, and what they bring.
//!
//! A packet of rays holds the samples of one pixel where it has many, since they hit the same things. The samples of a pixel come in
//! groups of up to 16 that are traced and proved together. A group lies in one batch, beside those of other pixels where there
//! is room. What a group brings depends neither on the others nor on the width of packets.

use super::hits::Hits;
use super::kernel::Tracer;
use super::observer::Observer;
use super::pixel::Samples;
use super::pixel_sum::PixelSum;
use super::ray_packet::RayPacket;
use super::variants::Variant;
use crate::control;
use crate::lanes::{Lanes, MAX_LANES};

/// Most samples of a group, and of a batch.
pub(crate) const BATCH: usize = MAX_LANES;

/// Samples that are traced together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SampleBatch {
    /// Columns and rows of their pixels.
    corners: [[u32; BATCH]; 2],
    /// The number of each sample in its pixel.
    numbers: [u32; BATCH],
    /// The samples of the group of each.
    groups: [u32; BATCH],
    len: usize,
    /// The number of the first sample of each pixel, and how many each has here; 0 in an empty batch.
    first: u32,
    each: u32,
    samples: Samples,
}

/// The samples of a packet.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SamplePacket {
    /// Columns and rows of their pixels.
    pub(super) corners: [[u32; MAX_LANES]; 2],
    /// The number of each sample in its pixel.
    pub(super) numbers: [u32; MAX_LANES],
    /// Names the set of samples that they are of.
    pub(super) set: u32,
}

/// What samples brought, in twice the precision of the kernel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct BatchLight {
    /// Light of each.
    pub(crate) light: [[f64; BATCH]; 3],
    /// The share of the background that each sees, if that is transparent.
    pub(crate) clear: [f64; BATCH],
    /// Those that may lack light.
    pub(crate) incomplete: u32,
    /// If there are any, the most light that each may lack.
    pub(crate) omitted: [[f64; BATCH]; 3],
    /// If there are any, the most that each may have missed of a transparent background.
    pub(crate) unseen: [f64; BATCH],
    /// If there are any, the relative rounding error of their light.
    pub(crate) rounding: [f64; BATCH],
    /// Those whose proof was given up.
    pub(crate) given_up: u32,
}

impl SampleBatch {
    /// An empty batch for some of each pixel's samples.
    pub(crate) fn new(samples: Samples) -> Self {
        Self { corners: [[0; BATCH]; 2], numbers: [0; BATCH], groups: [0; BATCH], len: 0, first: 0, each: 0, samples }
    }

    /// The sample of one number of each pixel.
    pub(crate) fn of_pixels(pixels: &[[u32; 2]], number: u32, samples: Samples) -> Self {
        let mut batch = Self::new(samples);
        batch.fill(pixels, number, 1);
        batch
    }

    /// Makes its samples those of some pixels, `count` of each from number `first` on. There must be room.
    #[inline(always)]
    pub(crate) fn fill(&mut self, pixels: &[[u32; 2]], first: u32, count: u32) {
        let [columns, rows] = &mut self.corners;
        let each = count as usize;
        if let [[x, y]] = pixels {
            (*columns, *rows) = ([*x; BATCH], [*y; BATCH]);
        } else if each == 1 {
            for ([x, y], (column, row)) in pixels.iter().zip(columns.iter_mut().zip(rows)) {
                (*column, *row) = (*x, *y);
            }
        } else {
            let places = columns.chunks_exact_mut(each).zip(rows.chunks_exact_mut(each));
            for ([x, y], (columns, rows)) in pixels.iter().zip(places) {
                columns.fill(*x);
                rows.fill(*y);
            }
        }
        self.len = pixels.len() * each;
        // Batches of the same kind differ by their pixels only.
        if (self.first, self.each) != (first, count) {
            (self.first, self.each) = (first, count);
            for sample in 0..BATCH as u32 {
                let group = sample / count * count;
                self.numbers[sample as usize] = first + sample - group;
                self.groups[sample as usize] = ((((1u64 << count) - 1) << group) as u32) & ((1 << BATCH) - 1);
            }
        }
    }

    /// How many samples it has.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Which samples each pixel gets.
    pub(super) fn samples(&self) -> Samples {
        self.samples
    }

    /// All its samples, a bit for each.
    pub(super) fn all(&self) -> u32 {
        (1 << self.len) - 1
    }

    /// The samples of the group of one.
    pub(super) fn group_of(&self, sample: usize) -> u32 {
        self.groups[sample]
    }

    /// The groups with samples among some, in order.
    pub(super) fn groups(&self, mut among: u32) -> impl Iterator<Item = u32> {
        std::iter::from_fn(move || {
            let group = *self.groups.get(among.trailing_zeros() as usize)?;
            among &= !group;
            Some(group)
        })
    }

    /// A packet of its samples.
    #[inline(always)]
    pub(super) fn packet<L: Lanes>(&self, packet: usize) -> SamplePacket {
        let mut of_packet = SamplePacket { corners: self.corners, numbers: self.numbers, set: self.samples.set };
        if packet > 0 {
            let [columns, rows] = &mut of_packet.corners;
            for numbers in [columns, rows, &mut of_packet.numbers] {
                numbers.copy_within(packet * L::COUNT.., 0);
            }
        }
        of_packet
    }
}

/// Traces a batch. Where proofs of pixels with several groups did not suffice, they are tried again, each time more exactly.
#[inline(always)]
pub(crate) fn trace_batch<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    batch: &SampleBatch,
    attempt: usize,
    hits: &mut Hits<L>,
    brought: &mut BatchLight,
) {
    let s = tracer.simd();
    let mut sum = PixelSum::black(s);
    let mut rays = RayPacket::none(s);
    tracer.begin_batch(batch, attempt);
    let packets = batch.len.div_ceil(L::COUNT);
    let mut packet = 0;
    // One call of `follow_from` for the first rays of each sample and those put aside: it holds all of the kernel.
    while !control::is_stopping() {
        if packet < packets {
            tracer.exchange(packet, &mut sum);
            packet += 1;
            let active = tracer.unproved_lanes();
            if active == 0 {
                continue;
            }
            tracer.begin_samples(active);
            let (x, y) = (tracer.coordinates(0), tracer.coordinates(1));
            tracer.sample(x, y, active, &mut rays, hits);
        } else if tracer.prove(hits, &mut sum) {
            if !tracer.pop(&mut rays) {
                continue;
            }
        } else if tracer.finish(&mut sum) {
            packet = 0;
            continue;
        } else {
            break;
        }
        tracer.follow_from(&mut rays, hits, &mut sum);
    }
    tracer.store_light(&sum, brought);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_keep_together() {
        let mut batch = SampleBatch::new(Samples::of_picture(6));
        batch.fill(&[[3, 4], [5, 4]], 0, 6);
        assert_eq!((batch.len(), batch.all()), (12, 0xfff));
        assert_eq!(batch.groups(0b1000_0010_0100).collect::<Vec<_>>(), [0x3f, 0xfc0]);
        assert_eq!(batch.groups(0b1000_0000_0000).collect::<Vec<_>>(), [0xfc0]);
        let second = batch.packet::<f64>(7);
        assert_eq!((second.corners[0][0], second.corners[1][0], second.numbers[0]), (5, 4, 1));
    }
}
