//! The choices of each sample of a pixel: its place in the pixel, a point of the lens, a time, a point of a light.
//!
//! The first are coordinates of one point of Sobol's sequence (`sobol.rs`), in the order of [`Dimensions`], so that they are spread
//! evenly together. Later ones, and choices further down the tree of rays, of which there may be any number, take two coordinates
//! in an order of their own (Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020). Each pixel scrambles its choices in its
//! own way; the places in the pixel are the same in all. All of it is computed from the pixel, the sample's number and
//! the place in the tree, so it does not depend on threads, tiles or packets; and the first samples of a pixel are the same
//! however many follow.

use super::ray_packet::RayKind;
use super::sobol::{self, hash, scramble};
use crate::lanes::{Lanes, MAX_LANES, Real};
use crate::scene::effects::{Effect, SceneEffects};

/// The scrambling of places in the pixel: of 1,500 tried the one with the least error over 4,000 edges, for 4 to 64 samples.
/// It is 0.82 of that of Hammersley's points for 16.
const PLACES: u32 = 974;

/// The last coordinate that begins a pair. Coordinates 4 and 5 of 256 points are even in rectangles of 8 points (t = 3), those
/// before in ones of 2; gloss behind a lens had 2.5 times the error by that.
const LAST_PAIR: u8 = 3;

/// Kinds of choices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Choice {
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
    /// A facet of clearcoat.
    Clearcoat,
    /// A direction of the surroundings.
    Surroundings,
    /// A point of what glows.
    Emitter,
    /// Whether a facet counts from which others hide the light.
    Hidden,
    /// Whether a ray is followed.
    Roulette,
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
            // Numbers that no light has.
            Self::Clearcoat => u32::MAX,
            Self::Surroundings => u32::MAX - 1,
            Self::Emitter => u32::MAX - 2,
            Self::Hidden => u32::MAX - 3,
            Self::Roulette => u32::MAX - 4,
        }
    }
}

/// The coordinates that choices take, after the two of the place in the pixel. The first ones are spread best, so
/// choices that a scene does not call for take none, and two that come late are worth less than an order of their own.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Dimensions {
    time: u8,
    lens: u8,
    first_hit: u8,
}

impl Dimensions {
    /// Those of a scene's effects.
    pub(super) fn of(effects: SceneEffects) -> Self {
        let after = |effect, coordinates| if effects.has(effect) { coordinates } else { 0 };
        let time = 2 + after(Effect::Dispersion, 1);
        let lens = time + after(Effect::MotionBlur, 1);
        Self { time, lens, first_hit: lens + after(Effect::DepthOfField, 2) }
    }

    /// The first coordinate of a choice at a place in the tree of rays; none further down, and where others come before. Of what a
    /// camera ray hits, all choices take the same ones: their light is added, so they need not be spread evenly together.
    #[inline(always)]
    fn first(self, choice: Choice, path: u32) -> Option<usize> {
        let pair = |first: u8| (first <= LAST_PAIR).then_some(usize::from(first));
        match choice {
            Choice::Wavelength => Some(2),
            Choice::Time => Some(usize::from(self.time)),
            Choice::Lens => pair(self.lens),
            _ if path == 0 => pair(self.first_hit),
            _ => None,
        }
    }
}

/// A hash of each lane's pixel and of a set of its samples.
#[inline(always)]
fn hashes([columns, rows]: &[[u32; MAX_LANES]; 2], set: u32) -> [u32; MAX_LANES] {
    let seed = 0x9e37_79b9 ^ if set == 0 { 0 } else { hash(set) };
    let mut hashes = [0; MAX_LANES];
    for lane in 0..MAX_LANES {
        hashes[lane] = hash(columns[lane] ^ hash(rows[lane] ^ seed));
    }
    hashes
}

/// How far a set shifts the samples within each lane's pixel along an axis, in 2^-32 of a pixel.
pub(super) fn shifts(corners: &[[u32; MAX_LANES]; 2], set: u32, axis: usize) -> [u32; MAX_LANES] {
    // Numbers that no kind of choice has.
    hashes(corners, set).map(|pixel| hash(pixel ^ hash(0x8000_0000 + axis as u32)))
}

/// The place of a sample within its pixel along an axis. The first is the centre.
#[inline(always)]
pub(crate) fn sample_offset(index: u32, axis: usize) -> f64 {
    FIRST_PLACES[axis].get(index as usize).copied().unwrap_or_else(|| computed_place(index, axis))
}

/// The first places, since most pixels have no more samples.
static FIRST_PLACES: [[f64; 256]; 2] = first_places();

const fn first_places() -> [[f64; 256]; 2] {
    let mut places = [[0.0; 256]; 2];
    let mut index = 0;
    while index < 256 {
        (places[0][index], places[1][index]) = (computed_place(index as u32, 0), computed_place(index as u32, 1));
        index += 1;
    }
    places
}

const fn computed_place(index: u32, axis: usize) -> f64 {
    let seed = [hash(PLACES), hash(PLACES ^ 0x5bd1_e995)][axis];
    let place = scramble(sobol::plane(index)[axis], seed) ^ scramble(0, seed) ^ (1 << 31);
    place as f64 / 4_294_967_296.0
}

/// The choices of the samples of a packet.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sampler {
    /// A hash of each sample's pixel.
    pixels: [u32; MAX_LANES],
    /// The number of each.
    numbers: [u32; MAX_LANES],
    dimensions: Dimensions,
}

impl Sampler {
    /// The choices of samples by their number in a set, and by the columns and rows of their pixels. Different sets choose
    /// independently.
    #[inline(always)]
    pub(crate) fn new(
        corners: &[[u32; MAX_LANES]; 2],
        set: u32,
        numbers: &[u32; MAX_LANES],
        dimensions: Dimensions,
    ) -> Self {
        Self { pixels: hashes(corners, set), numbers: *numbers, dimensions }
    }

    /// A point of the unit square for each lane, in [0, 1) x [0, 1), for a choice at a place in the tree of rays.
    #[inline(always)]
    pub(crate) fn square<L: Lanes>(&self, s: L::Simd, path: u32, choice: Choice) -> [L; 2] {
        let seed = hash(path ^ hash(choice.number()));
        if let Some(first) = self.dimensions.first(choice, path) {
            let [x, y] = [first, first + 1];
            return [
                self.scrambled(s, &sobol::coordinates(&self.numbers, x), hash(seed ^ 1)),
                self.scrambled(s, &sobol::coordinates(&self.numbers, y), hash(seed ^ 2)),
            ];
        }
        let mut points = [[0; MAX_LANES]; 2];
        for lane in 0..MAX_LANES {
            [points[0][lane], points[1][lane]] = sobol::plane(scramble(self.numbers[lane], seed));
        }
        [self.scrambled(s, &points[0], hash(seed ^ 1)), self.scrambled(s, &points[1], hash(seed ^ 2))]
    }

    /// A time in [0, 1) for each lane.
    #[inline(always)]
    pub(crate) fn time<L: Lanes>(&self, s: L::Simd) -> L {
        let first = self.dimensions.first(Choice::Time, 0).unwrap_or_default();
        self.scrambled(s, &sobol::coordinates(&self.numbers, first), hash(hash(Choice::Time.number())))
    }

    /// One of `count` wavelengths for each lane, a power of 2: each aligned run of `count` samples takes each of them once.
    #[inline(always)]
    pub(crate) fn wavelength(&self, count: u32) -> [usize; MAX_LANES] {
        debug_assert!(count.is_power_of_two());
        let first = self.dimensions.first(Choice::Wavelength, 0).unwrap_or_default();
        let (points, seed) = (sobol::coordinates(&self.numbers, first), hash(hash(Choice::Wavelength.number())));
        let mut wavelengths = [0; MAX_LANES];
        for lane in 0..MAX_LANES {
            let x = scramble(points[lane], hash(self.pixels[lane] ^ seed));
            wavelengths[lane] = ((u64::from(x) * u64::from(count)) >> 32) as usize;
        }
        wavelengths
    }

    /// A number in [0, 1) for each lane, from its coordinate.
    #[inline(always)]
    fn scrambled<L: Lanes>(&self, s: L::Simd, coordinates: &[u32; MAX_LANES], seed: u32) -> L {
        let mut numbers = [L::Real::default(); MAX_LANES];
        for lane in 0..MAX_LANES {
            // 24 bits fit into a number of single precision.
            let bits = scramble(coordinates[lane], hash(self.pixels[lane] ^ seed)) >> 8;
            numbers[lane] = L::Real::from_f64(f64::from(bits) / 16_777_216.0);
        }
        L::load(s, &numbers)
    }
}

/// The place in the tree of the ray of a kind that leaves from what a ray hits.
#[inline(always)]
pub(crate) fn child(path: u32, kind: RayKind) -> u32 {
    path.wrapping_mul(4).wrapping_add(kind as u32 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampler(index: u32, dimensions: Dimensions) -> Sampler {
        Sampler::new(&[std::array::from_fn(|i| i as u32), [5; MAX_LANES]], 0, &[index; MAX_LANES], dimensions)
    }

    #[test]
    fn the_first_sample_is_the_centre_and_others_lie_around_it() {
        assert_eq!([0, 1].map(|axis| sample_offset(0, axis)), [0.5; 2]);
        for count in [4, 16, 64, 1_024] {
            let mean = |axis: usize| (0..count).map(|i| sample_offset(i, axis)).sum::<f64>() / f64::from(count);
            let places: Vec<[f64; 2]> = (0..count).map(|i| [0, 1].map(|axis| sample_offset(i, axis))).collect();
            assert!(places.iter().flatten().all(|x| (0.0..1.0).contains(x)));
            assert!([0, 1].iter().all(|axis| (mean(*axis) - 0.5).abs() < 0.08 / f64::from(count).sqrt()), "{count}");
        }
    }

    #[test]
    fn a_run_takes_each_wavelength_once_and_its_halves_every_other_one() {
        for run in 0..3 {
            let dimensions = Dimensions::of([Effect::Dispersion, Effect::MotionBlur].into_iter().collect());
            let mut of_halves = [vec![], vec![]];
            for index in 0..64 {
                let wavelength = sampler(run * 64 + index, dimensions).wavelength(64)[3];
                of_halves[usize::from(index >= 32)].push(wavelength / 2);
            }
            for mut half in of_halves {
                half.sort_unstable();
                assert_eq!(half, (0..32).collect::<Vec<_>>(), "run {run}");
            }
        }
    }

    /// Coordinates 4 and 5 would put 8 of 256 points into one of such rectangles.
    #[test]
    fn choices_behind_a_lens_are_even() {
        for effects in [&[Effect::DepthOfField][..], &[Effect::DepthOfField, Effect::MotionBlur, Effect::Dispersion]] {
            let dimensions = Dimensions::of(effects.iter().copied().collect());
            for bits in 4..=8 {
                let points: Vec<[f64; 2]> =
                    (0..1 << bits).map(|index| sampler(index, dimensions).square((), 0, Choice::Facet)).collect();
                for across in 0..=bits {
                    let [columns, rows] = [across, bits - across].map(|bits| f64::from(1 << bits));
                    let mut met = vec![0; 1 << bits];
                    points
                        .iter()
                        .for_each(|[x, y]| met[((x * columns).floor() * rows + (y * rows).floor()) as usize] += 1);
                    assert!(met.iter().all(|count| *count == 1), "{bits} {across}");
                }
            }
        }
    }

    #[test]
    fn choices_of_one_sample_differ_and_lie_in_the_square() {
        let effects: SceneEffects =
            [Effect::DepthOfField, Effect::MotionBlur, Effect::ColorBleeding].into_iter().collect();
        let sampler = sampler(3, Dimensions::of(effects));
        let mut numbers = vec![sampler.time::<f64>(())];
        for (path, choice) in
            [(0, Choice::Lens), (0, Choice::Light(0)), (0, Choice::Light(1)), (1, Choice::ColorBleeding)]
        {
            numbers.extend(sampler.square::<f64>((), path, choice));
        }
        assert!(numbers.iter().all(|x| (0.0..1.0).contains(x)));
        numbers.sort_unstable_by(f64::total_cmp);
        assert!(numbers.windows(2).all(|pair| pair[1] - pair[0] > 1e-6), "{numbers:?}");
    }
}
