//! Light from the surroundings without a sample: what surfaces scatter by nine coefficients (Ramamoorthi and Hanrahan, An
//! Efficient Representation for Irradiance Environment Maps, 2001), what rough ones reflect by blurred pictures of the surroundings
//! (Karis, Real Shading in Unreal Engine 4, 2013). Nothing in the scene hides any of it.

use super::microfacet::{unhidden, visible_facet};
use super::sphere::{Sphere, middle};
use super::texture::environment::Environment;
use super::texture::mipmap::Mipmap;
use crate::lanes::{Double, Lanes, Mask, Real, V3};
use crate::math::Rgb;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::sync::Arc;

/// Roughness of each blurred picture, and its rows. A lobe is wider than a texel.
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
    /// From sharp to blurred completely, each with its roughness.
    pictures: Vec<(f64, Environment)>,
}

impl Surroundings {
    /// Those of an environment map.
    pub fn new(environment: &Environment) -> Self {
        let sphere = Sphere::new(environment);
        let blurred = BLURRED.par_iter().map(|(roughness, rows)| (*roughness, blurred(&sphere, *roughness, *rows)));
        let mut pictures = vec![(0.0, environment.clone())];
        pictures.extend(blurred.collect::<Vec<_>>());
        let most = environment.mipmap.brightest().map(|channel| channel * environment.intensity);
        Self { harmonics: harmonics(&sphere), most, pictures }
    }

    /// The brightest of it.
    pub fn most(&self) -> [f64; 3] {
        self.most
    }

    /// Bytes of memory it takes beside its environment.
    pub fn bytes(&self) -> usize {
        self.pictures.iter().skip(1).map(|(_, picture)| picture.mipmap.bytes()).sum()
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
        for (i, (own, picture)) in self.pictures.iter().enumerate() {
            // 1 at its own roughness, falling to 0 at that of its neighbours.
            let part = |other: Option<&(f64, Environment)>| match other {
                Some((other, _)) => one - (roughness - W::lit(s, *own)) / W::lit(s, other - own),
                None => one,
            };
            let before = i.checked_sub(1).and_then(|before| self.pictures.get(before));
            let weight = part(before).min(part(self.pictures.get(i + 1))).min(one);
            let near = weight.gt(zero);
            if near.bits() & lanes != 0 {
                let seen = picture.radiance(s, dir, zero, near.bits() & lanes);
                light = light + seen * W::select(near, weight, zero);
            }
        }
        light
    }
}

fn harmonics(sphere: &Sphere) -> [[f64; 3]; 9] {
    let mut sums = [Rgb::ZERO; 9];
    for (n, angle, light) in sphere.parts() {
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

/// The picture that lobes of a roughness see in each direction, looked at head on.
fn blurred(sphere: &Sphere, roughness: f64, rows: u32) -> Environment {
    let alpha = roughness * roughness;
    let up = V3 { x: 0.0, y: 0.0, z: 1.0 };
    let looks: Vec<(V3<f64>, f64, f64)> = (0..LOOKS)
        .filter_map(|i| {
            // Hammersley's points.
            let point = [(f64::from(i) + 0.5) / f64::from(LOOKS), f64::from(i.reverse_bits()) / 4_294_967_296.0];
            let facet = visible_facet((), up, up, alpha, point);
            let out = facet * (2.0 * facet.z) - up;
            let across = 1.0 - facet.z * facet.z;
            let spread = alpha * alpha * facet.z * facet.z + across;
            let density = alpha * alpha / (4.0 * PI * spread * spread);
            let angle = (1.0 / (f64::from(LOOKS) * density)).sqrt().min(0.5);
            (out.z > 0.0).then(|| (out, unhidden((), up, out, alpha), angle))
        })
        .collect();
    let all: f64 = looks.iter().map(|(_, weight, _)| weight).sum();
    let texel = |i: u32| {
        let n = middle(i % (2 * rows), i / (2 * rows), rows);
        let (right, ahead) = n.any_orthonormal_pair();
        let light = looks.iter().fold(Rgb::ZERO, |light, (out, weight, spread)| {
            light + sphere.mean(right * out.x + ahead * out.y + n * out.z, *spread) * *weight
        });
        (light / all).to_array().map(|channel| channel as f32)
    };
    let texels = (0..2 * rows * rows).into_par_iter().map(texel).collect();
    Environment { mipmap: Arc::new(Mipmap::new(2 * rows, rows, texels)), turn: 0.0, intensity: 1.0 }
}
