//! The choices of each sample of a pixel: a point of the lens, a time, a point of a light.
//!
//! Choices come in pairs. The pairs of a pixel's samples are points of Sobol's (0,2)-sequence: every run of 2^k points has
//! one in each of 2^k equal rectangles of any shape. So the error of n samples falls like 1/n, or n^(-3/4) where there are
//! edges, instead of n^(-1/2). Each kind of choice, and each place in the tree of rays, takes the points in an order of its
//! own (Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020), and each pixel shifts them by a vector of its own
//! (Cranley and Patterson 1976). All of it is computed from the pixel, the sample's number and the place in the tree, so it
//! does not depend on threads, tiles or packets.

use super::ray_packet::RayKind;
use crate::lanes::{Lanes, MAX_LANES, Real};

/// Kinds of choices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice {
    /// A point of the lens.
    Lens,
    /// A time while the shutter is open.
    Time,
    /// A wavelength.
    Wavelength,
    /// A facet of a rough surface.
    Facet,
    /// A direction from a diffuse surface.
    ColorBleeding,
    /// A point of a light, by its index.
    Light(usize),
}

impl Choice {
    fn number(self) -> u32 {
        match self {
            Self::Lens => 0,
            Self::Time => 1,
            Self::Wavelength => 2,
            Self::Facet => 3,
            Self::ColorBleeding => 4,
            Self::Light(index) => 5 + index as u32,
        }
    }
}

/// A hash of each lane's pixel and of a batch of its samples.
#[inline(always)]
fn hashes([columns, rows]: &[[u32; MAX_LANES]; 2], batch: u32) -> [u32; MAX_LANES] {
    let seed = 0x9e37_79b9 ^ if batch == 0 { 0 } else { hash(batch) };
    let mut hashes = [0; MAX_LANES];
    for lane in 0..MAX_LANES {
        hashes[lane] = hash(columns[lane] ^ hash(rows[lane] ^ seed));
    }
    hashes
}

/// How far a batch shifts the samples within each lane's pixel along an axis, in 2^-32 of a pixel.
pub(super) fn shifts(corners: &[[u32; MAX_LANES]; 2], batch: u32, axis: usize) -> [u32; MAX_LANES] {
    // Numbers that no kind of choice has.
    hashes(corners, batch).map(|pixel| hash(pixel ^ hash(0x8000_0000 + axis as u32)))
}

/// The choices of one sample of each pixel of a packet.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sampler {
    /// A hash of each lane's pixel.
    pixels: [u32; MAX_LANES],
    /// The sample's number.
    index: u32,
}

impl Sampler {
    /// The choices of sample `index` of a batch, of pixels given by columns and rows. Different batches choose independently.
    #[inline(always)]
    pub fn new(corners: &[[u32; MAX_LANES]; 2], batch: u32, index: u32) -> Self {
        Self { pixels: hashes(corners, batch), index }
    }

    /// A point of the unit square for each lane, in [0, 1) x [0, 1), for a choice at a place in the tree of rays.
    #[inline(always)]
    pub fn square<L: Lanes>(&self, s: L::Simd, path: u32, choice: Choice) -> [L; 2] {
        let seed = hash(path ^ hash(choice.number()));
        let [x, y] = scrambled_sobol(self.index, seed);
        [self.shifted(s, x, hash(seed ^ 1)), self.shifted(s, y, hash(seed ^ 2))]
    }

    /// A number in [0, 1) for each lane, for a choice that is made once for a sample.
    #[inline(always)]
    pub fn number<L: Lanes>(&self, s: L::Simd, choice: Choice) -> L {
        let seed = hash(hash(choice.number()));
        self.shifted(s, scrambled_sobol(self.index, seed)[0], hash(seed ^ 1))
    }

    /// One of `count` cases for each lane: `count` samples take each of them once.
    #[inline(always)]
    pub fn case(&self, choice: Choice, count: u32) -> [usize; MAX_LANES] {
        let seed = hash(hash(choice.number()));
        let first = (u64::from(scrambled_sobol(self.index, seed)[0]) * u64::from(count)) >> 32;
        let mut cases = [0; MAX_LANES];
        for (case, pixel) in cases.iter_mut().zip(self.pixels) {
            *case = ((first as u32 + hash(pixel ^ seed) % count) % count) as usize;
        }
        cases
    }

    /// A number in [0, 1) for each lane.
    #[inline(always)]
    fn shifted<L: Lanes>(&self, s: L::Simd, x: u32, seed: u32) -> L {
        let mut shifted = [L::Real::default(); MAX_LANES];
        for (shifted, pixel) in shifted.iter_mut().zip(self.pixels) {
            // 24 bits fit into a number of single precision.
            let bits = x.wrapping_add(hash(pixel ^ seed)) >> 8;
            *shifted = L::Real::from_f64(f64::from(bits) / 16_777_216.0);
        }
        L::load(s, &shifted)
    }
}

/// The place in the tree of the ray of a kind that leaves from what a ray hits.
#[inline(always)]
pub fn child(path: u32, kind: RayKind) -> u32 {
    path.wrapping_mul(4).wrapping_add(kind as u32 + 1)
}

/// A hash without collisions (Wellons' lowbias32).
#[inline(always)]
pub fn hash(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// Point `index` of the sequence, whose order and digits are scrambled by `seed`, as fractions of 2^32.
fn scrambled_sobol(index: u32, seed: u32) -> [u32; 2] {
    let index = scramble(index, seed);
    let mut y = 0;
    let (mut rest, mut direction) = (index, 1 << 31);
    while rest != 0 {
        if rest & 1 != 0 {
            y ^= direction;
        }
        rest >>= 1;
        direction ^= direction >> 1;
    }
    [scramble(index.reverse_bits(), hash(seed ^ 3)), scramble(y, hash(seed ^ 4))]
}

/// Owen's scrambling of a binary fraction: each digit is flipped or not, depending on those before it.
fn scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits();
    // Laine and Karras's permutation, with Burley's constants: carries run from low to high only.
    x = x.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_of_64_puts_one_point_into_each_rectangle() {
        for seed in [0, 1, 77, u32::MAX] {
            for run in 0..4 {
                let points: Vec<[u32; 2]> = (0..64).map(|i| scrambled_sobol(run * 64 + i, seed)).collect();
                for across in 0..=6 {
                    let mut met: Vec<u32> =
                        points.iter().map(|[x, y]| (x >> 26 >> (6 - across) << 6) | (y >> 26 >> across)).collect();
                    met.sort_unstable();
                    met.dedup();
                    assert_eq!(met.len(), 64, "seed {seed}, run {run}, 2^{across} columns");
                }
            }
        }
    }

    #[test]
    fn choices_of_one_sample_differ_and_lie_in_the_square() {
        let sampler = Sampler::new(&[std::array::from_fn(|i| i as u32), [5; MAX_LANES]], 0, 3);
        let [x, y]: [f64; 2] = sampler.square((), 0, Choice::ColorBleeding);
        let [u, _]: [f64; 2] = sampler.square((), 1, Choice::ColorBleeding);
        assert!((0.0..1.0).contains(&x) && (0.0..1.0).contains(&y) && x != u);
    }
}
