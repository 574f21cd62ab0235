//! Gradient noise (Perlin, Improving Noise, SIGGRAPH 2002) and its fractal sum, with derivatives.

use glam::DVec3;

/// Noise at a point in units of its lattice, about -1 to 1 and 0 at lattice points, and its gradient.
pub fn noise(p: DVec3, seed: u64) -> (f64, DVec3) {
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

/// A fractal sum of noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fractal {
    /// Cells of the coarsest octave in a unit of length.
    pub frequency: f64,
    /// Octaves, at least one.
    pub octaves: u32,
}

impl Fractal {
    /// The sum at a point, from 0 to 1, and its gradient. Octaves too fine for a footprint of a given width fade out before
    /// they alias: the shortest wave of noise is about one cell.
    pub fn at(&self, p: DVec3, width: f64) -> (f64, DVec3) {
        let (mut value, mut gradient, mut all) = (0.0, DVec3::ZERO, 0.0);
        let (mut frequency, mut strength) = (self.frequency, 1.0);
        for octave in 0..self.octaves {
            let seen = (2.0 - 2.0 * width * frequency).clamp(0.0, 1.0);
            if seen > 0.0 {
                // Every octave has its own lattice points, or all would be 0 in the same places.
                let shift = DVec3::splat(0.37 * f64::from(octave));
                let (x, dx) = noise(p * frequency + shift, u64::from(octave));
                value += x * (strength * seen);
                gradient += dx * (frequency * strength * seen);
            }
            all += strength;
            frequency *= 2.0;
            strength *= 0.5;
        }
        // From -1..1 to 0..1.
        let scaled = 0.5 + 0.5 * value / all;
        let inside = (0.0..=1.0).contains(&scaled);
        (scaled.clamp(0.0, 1.0), if inside { gradient * (0.5 / all) } else { DVec3::ZERO })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> impl Iterator<Item = DVec3> {
        (0..2000).map(|i| DVec3::new(0.737, 1.173, -0.391) * f64::from(i) * 0.31)
    }

    #[test]
    fn is_0_at_the_lattice_and_within_bounds_elsewhere() {
        for x in -3..3 {
            assert_eq!(noise(DVec3::new(f64::from(x), 7.0, -2.0), 1).0, 0.0);
        }
        let values: Vec<f64> = points().map(|p| noise(p, 0).0).collect();
        assert!(values.iter().all(|x| x.abs() <= 1.04));
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        assert!(mean.abs() < 0.03, "{mean}");
        assert!(values.iter().any(|x| *x > 0.5) && values.iter().any(|x| *x < -0.5));
    }

    #[test]
    fn gradients_are_those_of_the_values() {
        let fractal = Fractal { frequency: 1.7, octaves: 3 };
        for p in points().take(200) {
            let (_, gradient) = fractal.at(p, 0.0);
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let h = 1e-5;
                let slope = (fractal.at(p + axis * h, 0.0).0 - fractal.at(p - axis * h, 0.0).0) / (2.0 * h);
                assert!((slope - gradient.dot(axis)).abs() < 1e-6, "{slope} {}", gradient.dot(axis));
            }
        }
    }

    #[test]
    fn wide_footprints_see_grey() {
        let fractal = Fractal { frequency: 1.0, octaves: 4 };
        assert_eq!(fractal.at(DVec3::new(0.3, 0.4, 0.7), 1.0), (0.5, DVec3::ZERO));
        assert!(fractal.at(DVec3::splat(1e30), 0.0).0.is_finite());
    }
}
