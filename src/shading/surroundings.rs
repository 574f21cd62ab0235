//! Light from the surroundings without a sample: what surfaces scatter by nine coefficients (Ramamoorthi and Hanrahan, An
//! Efficient Representation for Irradiance Environment Maps, 2001), what rough ones reflect by blurred pictures of the surroundings
//! (Karis, Real Shading in Unreal Engine 4, 2013). Nothing in the scene hides any of it.

use super::environment_pyramid::{EnvironmentPyramid, Lobe, Place, beside};
use super::microfacet::{smith_g1, visible_facet};
use super::texture::environment::{Environment, directions};
use super::texture::mipmap::Mipmap;
use crate::lanes::{Double, Lanes, Mask, Real, V3, dispatch};
use crate::math::Rgb;
use fearless_simd::{Level, f64x8};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::RangeInclusive;
use std::sync::{Arc, OnceLock};

/// Roughness of each blurred picture, and its rows. A lobe is wider than a texel. The sharper ones have three quarters of all texels.
const BLURRED: [(f64, u32); 6] = [(0.1, 64), (0.2, 64), (0.35, 32), (0.5, 32), (0.75, 16), (1.0, 16)];

/// Directions of a lobe that are looked up, each over its share of the lobe.
const LOOKS: u32 = 32;

/// What a scene's surroundings do to its surfaces.
#[derive(Debug)]
pub struct Surroundings {
    /// Irradiance over pi, as factors on 1, y, z, x, xy, yz, 3z^2 - 1, xz and x^2 - y^2 of the normal.
    harmonics: [[f64; 3]; 9],
    /// The brightest of it.
    most: [f64; 3],
    /// The surroundings as they are.
    sharp: Environment,
    /// What blurred pictures are made of.
    pyramid: EnvironmentPyramid,
    /// From hardly blurred to completely, those that a surface has asked for.
    blurred: [OnceLock<Environment>; BLURRED.len()],
}

impl Surroundings {
    /// Those of an environment map, for surfaces of some roughnesses.
    pub fn new(environment: &Environment, roughnesses: &[RangeInclusive<f64>]) -> Self {
        let pyramid = EnvironmentPyramid::new(environment);
        let most = environment.mipmap.brightest().map(|channel| channel * environment.intensity);
        let blurred = std::array::from_fn(|_| OnceLock::new());
        let surroundings = Self { harmonics: harmonics(&pyramid), most, sharp: environment.clone(), pyramid, blurred };
        surroundings.prepare(roughnesses);
        surroundings
    }

    /// Gets them ready for surfaces of more roughnesses, on all threads. Without it the first ray that needs a picture waits for it.
    pub fn prepare(&self, roughnesses: &[RangeInclusive<f64>]) {
        let is_wanted =
            |i: &usize| self.blurred[*i].get().is_none() && roughnesses.iter().any(|range| is_seen(*i, range));
        let missing: Vec<usize> = (0..BLURRED.len()).filter(is_wanted).collect();
        missing.into_par_iter().for_each(|i| _ = self.blurred[i].set(blurred(&self.pyramid, i)));
    }

    /// Picture 0 is the sharp one.
    fn picture(&self, i: usize) -> &Environment {
        match i.checked_sub(1) {
            Some(i) => self.blurred[i].get_or_init(
                #[cold]
                || blurred(&self.pyramid, i),
            ),
            None => &self.sharp,
        }
    }

    /// The brightest of it.
    pub fn most(&self) -> [f64; 3] {
        self.most
    }

    /// Most bytes of memory it takes beside its environment: surfaces of more roughnesses may come.
    pub fn bytes(&self) -> usize {
        let blurred: u64 = BLURRED.iter().map(|(_, rows)| Mipmap::bytes_for(2 * rows, *rows, false)).sum();
        blurred as usize + self.pyramid.bytes()
    }

    /// The light that a white surface with unit normals `n` scatters.
    #[inline(always)]
    pub fn scattered<L: Lanes>(&self, s: L::Simd, n: V3<L>) -> V3<L> {
        let (one, three, zero) = (L::lit(s, 1.0), L::lit(s, 3.0), L::lit(s, 0.0));
        let basis =
            [one, n.y, n.z, n.x, n.x * n.y, n.y * n.z, three * n.z * n.z - one, n.x * n.z, n.x * n.x - n.y * n.y];
        let mut light = V3 { x: zero, y: zero, z: zero };
        for (factor, value) in self.harmonics.iter().zip(basis) {
            light = light + V3::splat(s, factor.map(L::Real::from_f64)) * value;
        }
        // Nine coefficients may overshoot.
        let most = V3::<L>::splat(s, self.most.map(L::Real::from_f64));
        V3 { x: light.x.max(zero).min(most.x), y: light.y.max(zero).min(most.y), z: light.z.max(zero).min(most.z) }
    }

    /// The light that lobes around unit directions see.
    #[inline(always)]
    pub fn reflected<W: Double>(&self, s: W::Simd, dir: V3<W>, roughness: W, lanes: u32) -> V3<W> {
        let (zero, one) = (W::lit(s, 0.0), W::lit(s, 1.0));
        let mut light = V3 { x: zero, y: zero, z: zero };
        for i in 0..=BLURRED.len() {
            let (before, next) = (i.checked_sub(1), Some(i + 1).filter(|next| *next <= BLURRED.len()));
            let weight = nearness(s, i, before, roughness).min(nearness(s, i, next, roughness)).min(one);
            let near = weight.gt(zero);
            if near.bits() & lanes != 0 {
                let seen = self.picture(i).radiance(s, dir, zero, near.bits() & lanes);
                light = light + seen * W::select(near, weight, zero);
            }
        }
        light
    }
}

/// 1 at the roughness of a picture, falling to 0 at that of its neighbour, if it has one there.
#[inline(always)]
fn nearness<W: Double>(s: W::Simd, picture: usize, neighbour: Option<usize>, roughness: W) -> W {
    let one = W::lit(s, 1.0);
    let Some(neighbour) = neighbour else { return one };
    let own = roughness_of(picture);
    one - (roughness - W::lit(s, own)) / W::lit(s, roughness_of(neighbour) - own)
}

/// The roughness of a picture; 0 is the sharp one.
fn roughness_of(picture: usize) -> f64 {
    picture.checked_sub(1).map_or(0.0, |i| BLURRED[i].0)
}

/// Whether surfaces of a range of roughnesses see a blurred picture: those between the roughnesses of its neighbours do.
fn is_seen(i: usize, range: &RangeInclusive<f64>) -> bool {
    /// Single precision rounds roughnesses.
    const ROUNDED: f64 = 1e-6;
    let above = BLURRED.get(i + 1).map_or(f64::INFINITY, |(roughness, _)| *roughness);
    range.start() * (1.0 - ROUNDED) < above && range.end() * (1.0 + ROUNDED) > roughness_of(i)
}

fn harmonics(pyramid: &EnvironmentPyramid) -> [[f64; 3]; 9] {
    let mut sums = [Rgb::ZERO; 9];
    for (n, angle, light) in pyramid.parts() {
        let basis = [1.0, n.y, n.z, n.x, n.x * n.y, n.y * n.z, 3.0 * n.z * n.z - 1.0, n.x * n.z, n.x * n.x - n.y * n.y];
        for (sum, value) in sums.iter_mut().zip(basis) {
            *sum += light * (angle * value);
        }
    }
    // The square of each function's factor, times what a cosine keeps of its band: 1, 2/3 and 1/4.
    let [first, second] = [3.0 / (4.0 * PI) * 2.0 / 3.0, 15.0 / (4.0 * PI) / 4.0];
    let middle = 5.0 / (16.0 * PI) / 4.0;
    let last = 15.0 / (16.0 * PI) / 4.0;
    let factors = [1.0 / (4.0 * PI), first, first, first, second, second, middle, second, last];
    std::array::from_fn(|i| (sums[i] * factors[i]).to_array())
}

/// A blurred picture: what lobes of its roughness see in each direction, looked at head on. By one thread: in a pool, one that makes a
/// picture for a ray might take up other work that waits for it.
fn blurred(pyramid: &EnvironmentPyramid, i: usize) -> Environment {
    let (_, rows) = BLURRED[i];
    let texels = dispatch!(Level::new(), texels::<f64x8, f64>(pyramid, i));
    Environment { mipmap: Arc::new(Mipmap::new(2 * rows, rows, texels)), turn: 0.0, intensity: 1.0 }
}

/// A direction of a lobe: its direction from the normal z, its weight, and its share of the lobe.
type LobeDirection<'a> = (DVec3, f64, Lobe<'a>);

fn lobe_directions(pyramid: &EnvironmentPyramid, roughness: f64) -> Vec<LobeDirection<'_>> {
    let alpha = roughness * roughness;
    let up = V3 { x: 0.0, y: 0.0, z: 1.0 };
    (0..LOOKS)
        .filter_map(|i| {
            // Hammersley's points.
            let point = [(f64::from(i) + 0.5) / f64::from(LOOKS), f64::from(i.reverse_bits()) / 4_294_967_296.0];
            let facet = visible_facet((), up, up, alpha, point);
            let out = facet * (2.0 * facet.z) - up;
            let across = 1.0 - facet.z * facet.z;
            let spread = alpha * alpha * facet.z * facet.z + across;
            let density = alpha * alpha / (4.0 * PI * spread * spread);
            let angle = (1.0 / (f64::from(LOOKS) * density)).sqrt().min(0.5);
            let dir = DVec3::new(out.x, out.y, out.z);
            (out.z > 0.0).then(|| (dir, smith_g1((), up, out, alpha), pyramid.lobe(angle)))
        })
        .collect()
}

/// The texels of a blurred picture. Directions are added up in their order, so that lanes do not count.
fn texels<W: Double>(s: W::Simd, pyramid: &EnvironmentPyramid, i: usize) -> Vec<[f32; 3]> {
    let (roughness, rows) = BLURRED[i];
    let lobe = lobe_directions(pyramid, roughness);
    let outs: Vec<DVec3> = lobe.iter().map(|(out, ..)| *out).collect();
    let all: f64 = lobe.iter().map(|(_, weight, _)| weight).sum();
    let texel = |n: DVec3| {
        let (right, ahead) = n.any_orthonormal_pair();
        let mut light = Rgb::ZERO;
        W::vectorize(
            s,
            #[inline(always)]
            || {
                let (right, ahead) = (V3::<W>::splat(s, right.to_array()), V3::<W>::splat(s, ahead.to_array()));
                let n = V3::<W>::splat(s, n.to_array());
                for (outs, part) in outs.chunks(W::COUNT).zip(lobe.chunks(W::COUNT)) {
                    let out = beside::<W>(s, outs);
                    let places = Place::of(s, right * out.x + ahead * out.y + n * out.z);
                    for ((_, weight, lobe), place) in part.iter().zip(places) {
                        light += lobe.mean(&place) * *weight;
                    }
                }
            },
        );
        (light / all).to_array().map(|channel| channel as f32)
    };
    directions(rows).into_iter().map(texel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::texture::environment::clear_sky;

    fn made(surroundings: &Surroundings) -> usize {
        surroundings.blurred.iter().filter(|picture| picture.get().is_some()).count()
    }

    /// What is ready beforehand is all that is looked at, and pictures are the same whoever makes them.
    #[test]
    fn surfaces_need_the_pictures_of_their_roughness_alone() {
        let [zenith, horizon, ground] = [[0.1, 0.2, 0.9], [0.8, 0.9, 1.0], [0.2, 0.1, 0.0]].map(Rgb::from_array);
        let sky = Arc::new(clear_sky(zenith, horizon, ground));
        let sky = Environment { mipmap: sky, turn: 0.2, intensity: 1.5 };
        let whole = Surroundings::new(&sky, &[0.0..=1.0]);
        assert_eq!(made(&whole), BLURRED.len());
        let dir = DVec3::new(0.3, 0.4, -0.5).normalize();
        let dir = V3 { x: dir.x, y: dir.y, z: dir.z };
        for roughness in [0.0, 0.05, 0.1, 0.27, 0.35, 0.5, 0.6, 0.75, 0.9, 1.0] {
            // As the lanes of single precision have it.
            for seen in [roughness, f64::from(roughness as f32)] {
                let own = Surroundings::new(&sky, &[roughness..=roughness]);
                let ready = made(&own);
                assert!(ready <= if roughness == 0.0 { 0 } else { 3 }, "{roughness}: {ready}");
                let light = own.reflected((), dir, seen, 1);
                assert_eq!(made(&own), ready, "{roughness}");
                let late = Surroundings::new(&sky, &[]).reflected((), dir, seen, 1);
                let expected = whole.reflected((), dir, seen, 1);
                for other in [light, late] {
                    assert_eq!([other.x, other.y, other.z], [expected.x, expected.y, expected.z], "{roughness}");
                }
            }
        }
    }
}
