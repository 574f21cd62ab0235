//! Gradient noise (Perlin, Improving Noise, SIGGRAPH 2002) and its fractal sum, with derivatives.

use crate::lanes::{Double, Ids, Mask, V3};

/// Noise at points in units of its lattice, about -1 to 1 and 0 at lattice points, and its gradient.
#[inline(always)]
fn noise<W: Double>(s: W::Simd, p: V3<W>, seed: u64) -> (W, V3<W>) {
    let cell = V3 { x: p.x.floor(), y: p.y.floor(), z: p.z.floor() };
    let f = p - cell;
    let one = W::lit(s, 1.0);
    let fades = [fade(s, f.x), fade(s, f.y), fade(s, f.z)];
    // Beyond 2^63 all cells are the same; coordinates of such points are coarser than cells anyway.
    let ends = |t: W| [t.whole(), (t + one).whole()];
    let [cell_x, cell_y, cell_z] = [ends(cell.x), ends(cell.y), ends(cell.z)];
    let seed = W::Ids::splat(s, seed);
    let by_x = [W::hash(s, seed, cell_x[0]), W::hash(s, seed, cell_x[1])];
    let (x, y, z) = ([f.x, f.x - one], [f.y, f.y - one], [f.z, f.z - one]);

    // First the four edges along x, then two faces along y, then the cell along z.
    let zero = W::lit(s, 0.0);
    let mut faces = [Ramp { value: zero, gradient: V3 { x: zero, y: zero, z: zero } }; 2];
    let mut by_xy = [by_x[0]; 4];
    for i in 0..4 {
        by_xy[i] = W::hash(s, by_x[i & 1], cell_y[i >> 1]);
    }
    for far in 0..2 {
        let mut edges = faces;
        for up in 0..2 {
            let mut corners = edges;
            for right in 0..2 {
                let gradient = direction::<W>(s, W::hash(s, by_xy[right + 2 * up], cell_z[far]));
                corners[right] = Ramp { value: gradient.dot(V3 { x: x[right], y: y[up], z: z[far] }), gradient };
            }
            edges[up] = corners[0].towards(corners[1], 0, fades[0]);
        }
        faces[far] = edges[0].towards(edges[1], 1, fades[1]);
    }
    let Ramp { value, gradient } = faces[0].towards(faces[1], 2, fades[2]);
    (value, gradient)
}

/// A function of the place: its value there and its gradient.
#[derive(Debug, Clone, Copy)]
struct Ramp<W> {
    value: W,
    gradient: V3<W>,
}

impl<W: Double> Ramp<W> {
    /// On the way to another one along an axis: how far, and how fast that grows.
    #[inline(always)]
    fn towards(self, other: Self, axis: usize, [part, slope]: [W; 2]) -> Self {
        let rise = other.value - self.value;
        let mut gradient = self.gradient + (other.gradient - self.gradient) * part;
        let along = match axis {
            0 => &mut gradient.x,
            1 => &mut gradient.y,
            _ => &mut gradient.z,
        };
        *along = *along + slope * rise;
        Self { value: self.value + part * rise, gradient }
    }
}

/// 6 t^5 - 15 t^4 + 10 t^3, whose first and second derivatives vanish at both ends, and its slope.
#[inline(always)]
fn fade<W: Double>(s: W::Simd, t: W) -> [W; 2] {
    let (one, two) = (W::lit(s, 1.0), W::lit(s, 2.0));
    [
        t * t * t * (t * (t * W::lit(s, 6.0) - W::lit(s, 15.0)) + W::lit(s, 10.0)),
        W::lit(s, 30.0) * t * t * (t * (t - two) + one),
    ]
}

/// From the middle of a cube to one of its edges, four of which are twice as likely.
#[inline(always)]
fn direction<W: Double>(s: W::Simd, hash: W::Ids) -> V3<W> {
    let (zero, one) = (W::lit(s, 0.0), W::lit(s, 1.0));
    let a = W::select(W::bit(s, hash, 60), -one, one);
    let b = W::select(W::bit(s, hash, 61), -one, one);
    // (a, b, 0), (a, 0, b), (0, a, b), and (a, a, 0) or (0, b, -b).
    let (low, high, last) = (W::bit(s, hash, 32), W::bit(s, hash, 33), W::bit(s, hash, 34));
    V3 {
        x: W::select(high & !(low & !last), zero, a),
        y: W::select(high, W::select(low & last, b, a), W::select(low, zero, b)),
        z: W::select(high, W::select(low, W::select(last, -b, zero), b), W::select(low, b, zero)),
    }
}

/// A fractal sum of noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fractal {
    /// Cells of the coarsest octave in a unit of length.
    pub frequency: f64,
    /// Octaves, at least one.
    pub octaves: u32,
}

impl Fractal {
    /// The sum at points, from 0 to 1, and its gradient. Octaves too fine for a footprint of a given width fade out before
    /// they alias: the shortest wave of noise is about one cell.
    pub(super) fn at<W: Double>(&self, s: W::Simd, p: V3<W>, width: W) -> (W, V3<W>) {
        W::vectorize(
            s,
            #[inline(always)]
            || self.at_in(s, p, width),
        )
    }

    #[inline(always)]
    fn at_in<W: Double>(&self, s: W::Simd, p: V3<W>, width: W) -> (W, V3<W>) {
        let (zero, half, one, two) = (W::lit(s, 0.0), W::lit(s, 0.5), W::lit(s, 1.0), W::lit(s, 2.0));
        let nothing = V3 { x: zero, y: zero, z: zero };
        let (mut value, mut gradient, mut all) = (zero, nothing, 0.0);
        let (mut frequency, mut strength) = (self.frequency, 1.0);
        for octave in 0..self.octaves {
            let seen = (two - two * width * W::lit(s, frequency)).max(zero).min(one);
            let some = seen.gt(zero);
            if some.any() {
                // Every octave has its own lattice points, or all would be 0 in the same places.
                let shift = V3::splat(s, [0.37 * f64::from(octave); 3]);
                let (x, dx) = noise(s, p * W::lit(s, frequency) + shift, u64::from(octave));
                value = W::select(some, value + x * (W::lit(s, strength) * seen), value);
                gradient = V3::select(some, gradient + dx * (W::lit(s, frequency * strength) * seen), gradient);
            }
            all += strength;
            frequency *= 2.0;
            strength *= 0.5;
        }
        // From -1..1 to 0..1.
        let all = W::lit(s, all);
        let scaled = half + half * value / all;
        let inside = scaled.ge(zero) & scaled.le(one);
        (scaled.max(zero).min(one), V3::select(inside, gradient * (half / all), nothing))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Lanes;
    use fearless_simd::{Level, Simd, f64x8};
    use glam::DVec3;

    /// The same one by one, as the paper has it.
    fn slow_noise(p: DVec3, seed: u64) -> (f64, DVec3) {
        let cell = p.floor();
        let f = p - cell;
        // 6 t^5 - 15 t^4 + 10 t^3, whose first and second derivatives vanish at both ends.
        let fade = f * f * f * (f * (f * 6.0 - DVec3::splat(15.0)) + DVec3::splat(10.0));
        let slope = 30.0 * f * f * (f * (f - DVec3::splat(2.0)) + DVec3::ONE);
        let (mut value, mut gradient) = (0.0, DVec3::ZERO);
        for (corner, direction) in (0..8).zip(directions(cell, seed)) {
            let side = DVec3::new(f64::from(corner & 1), f64::from(corner >> 1 & 1), f64::from(corner >> 2));
            let ramp = direction.dot(f - side);
            // The weight is a product of fade or 1 - fade over the axes.
            let weight = side * fade + (DVec3::ONE - side) * (DVec3::ONE - fade);
            let turn = (side * 2.0 - DVec3::ONE) * slope;
            let all = weight.x * weight.y * weight.z;
            value += all * ramp;
            let change =
                DVec3::new(turn.x * weight.y * weight.z, turn.y * weight.x * weight.z, turn.z * weight.x * weight.y);
            gradient += direction * all + change * ramp;
        }
        (value, gradient)
    }

    /// The directions at the corners of a cell: bits 0, 1 and 2 of their numbers say on which side in x, y and z they are.
    fn directions(cell: DVec3, seed: u64) -> [DVec3; 8] {
        // Beyond 2^63 all cells are the same; coordinates of such points are coarser than cells anyway.
        let step = |hash: u64, x: f64| scramble(hash ^ (x as i64 as u64));
        let side = |bit: usize| bit as f64;
        let by_x = [step(seed, cell.x), step(seed, cell.x + 1.0)];
        let by_xy = [0, 1, 2, 3].map(|i| step(by_x[i & 1], cell.y + side(i >> 1)));
        [0, 1, 2, 3, 4, 5, 6, 7].map(|i| direction(step(by_xy[i & 3], cell.z + side(i >> 2))))
    }

    /// From the middle of a cube to one of its edges, four of which are twice as likely.
    fn direction(hash: u64) -> DVec3 {
        let sign = |bit: u64| if hash >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let (a, b) = (sign(60), sign(61));
        match hash >> 32 & 3 {
            0 => DVec3::new(a, b, 0.0),
            1 => DVec3::new(a, 0.0, b),
            2 => DVec3::new(0.0, a, b),
            _ => match hash >> 34 & 1 {
                0 => DVec3::new(a, a, 0.0),
                _ => DVec3::new(0.0, b, -b),
            },
        }
    }

    /// A hash without collisions (the finaliser of SplitMix64).
    fn scramble(mut x: u64) -> u64 {
        x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    fn vector(p: DVec3) -> V3<f64> {
        V3 { x: p.x, y: p.y, z: p.z }
    }

    fn noise_at(p: DVec3, seed: u64) -> (f64, DVec3) {
        let (value, gradient) = noise((), vector(p), seed);
        (value, DVec3::from_array(gradient.lane(0)))
    }

    fn sum_at(fractal: Fractal, p: DVec3, width: f64) -> (f64, DVec3) {
        let (value, gradient) = fractal.at((), vector(p), width);
        (value, DVec3::from_array(gradient.lane(0)))
    }

    #[inline(always)]
    fn compare<S: Simd>(s: S) {
        let places: Vec<DVec3> = points().chain([1e15, -1e19, 1e30].map(|x| DVec3::new(x, 0.5 * x, 0.3))).collect();
        for (seed, places) in (0..).zip(places.chunks_exact(8)) {
            let p = V3::<f64x8<S>>::from_fn(s, |i| places[i].to_array());
            let (value, gradient) = noise(s, p, seed);
            for (i, place) in places.iter().enumerate() {
                let expected = slow_noise(*place, seed);
                let lane = (value.lane(i), DVec3::from_array(gradient.lane(i)));
                assert_eq!(noise_at(*place, seed), lane, "{place}");
                // They add in another order.
                let off = (lane.0 - expected.0).abs().max((lane.1 - expected.1).abs().max_element());
                assert!(off < 1e-14, "{off} at {place}");
            }
        }
    }

    #[test]
    fn lanes_agree_to_the_bit_and_with_the_slow_one() {
        let best = Level::new();
        fearless_simd::dispatch!(best, s => compare(s));
        #[cfg(target_arch = "x86_64")]
        if let Some(lower) = best.as_avx2() {
            fearless_simd::dispatch!(Level::Avx2(lower), s => compare(s));
        }
    }

    fn points() -> impl Iterator<Item = DVec3> {
        (0..2000).map(|i| DVec3::new(0.737, 1.173, -0.391) * f64::from(i) * 0.31)
    }

    #[test]
    fn is_0_at_the_lattice_and_within_bounds_elsewhere() {
        for x in -3..3 {
            assert_eq!(noise_at(DVec3::new(f64::from(x), 7.0, -2.0), 1).0, 0.0);
        }
        let values: Vec<f64> = points().map(|p| noise_at(p, 0).0).collect();
        assert!(values.iter().all(|x| x.abs() <= 1.04));
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        assert!(mean.abs() < 0.03, "{mean}");
        assert!(values.iter().any(|x| *x > 0.5) && values.iter().any(|x| *x < -0.5));
    }

    #[test]
    fn gradients_are_those_of_the_values() {
        let fractal = Fractal { frequency: 1.7, octaves: 3 };
        for p in points().take(200) {
            let (_, gradient) = sum_at(fractal, p, 0.0);
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let h = 1e-5;
                let slope = (sum_at(fractal, p + axis * h, 0.0).0 - sum_at(fractal, p - axis * h, 0.0).0) / (2.0 * h);
                assert!((slope - gradient.dot(axis)).abs() < 1e-6, "{slope} {}", gradient.dot(axis));
            }
        }
    }

    #[test]
    fn wide_footprints_see_grey() {
        let fractal = Fractal { frequency: 1.0, octaves: 4 };
        assert_eq!(sum_at(fractal, DVec3::new(0.3, 0.4, 0.7), 1.0), (0.5, DVec3::ZERO));
        assert!(sum_at(fractal, DVec3::splat(1e30), 0.0).0.is_finite());
    }
}
