//! Sobol's sequence, and Owen's scrambling of it.
//!
//! Of every aligned run of 2^k points, each of the first two coordinates puts one into each of 2^k equal parts of [0, 1), and both
//! together put one into each rectangle of area 2^-k whose sides are powers of 1/2. All coordinates together are as even as
//! a few dimensions allow, so the error of n samples falls like 1/n, or n^(-3/4) where there are edges, instead of n^(-1/2).
//! (Sobol, USSR Computational Mathematics 7(4), 1967; direction numbers of Joe and Kuo, SIAM J. Sci. Comput. 30, 2008.)

/// Coordinates of a point.
pub(super) const DIMENSIONS: usize = 5;

/// Degree and coefficients of each dimension's polynomial, and its first direction numbers, from the second dimension on.
const POLYNOMIALS: [(usize, u32, [u32; 3]); DIMENSIONS - 1] =
    [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1]), (3, 2, [1, 1, 1])];

/// What each bit of a point's number adds to its coordinates.
const DIRECTIONS: [[u32; DIMENSIONS]; 32] = directions();

const fn directions() -> [[u32; DIMENSIONS]; 32] {
    let mut all = [[0; DIMENSIONS]; 32];
    let mut bit = 0;
    while bit < 32 {
        all[bit][0] = 1 << (31 - bit);
        let mut dimension = 1;
        while dimension < DIMENSIONS {
            let (degree, coefficients, first) = POLYNOMIALS[dimension - 1];
            all[bit][dimension] = if bit < degree {
                first[bit] << (31 - bit)
            } else {
                let mut sum = all[bit - degree][dimension] ^ (all[bit - degree][dimension] >> degree);
                let mut k = 1;
                while k < degree {
                    if coefficients >> (degree - 1 - k) & 1 == 1 {
                        sum ^= all[bit - k][dimension];
                    }
                    k += 1;
                }
                sum
            };
            dimension += 1;
        }
        bit += 1;
    }
    all
}

/// One coordinate of each of some points, in 2^-32.
#[inline(always)]
pub(super) fn coordinates<const N: usize>(numbers: &[u32; N], dimension: usize) -> [u32; N] {
    let all = numbers.iter().fold(0, |all, number| all | number);
    let mut coordinates = [0; N];
    for (bit, directions) in DIRECTIONS.iter().enumerate().take((u32::BITS - all.leading_zeros()) as usize) {
        let direction = directions[dimension];
        for (coordinate, number) in coordinates.iter_mut().zip(numbers) {
            *coordinate ^= direction & 0u32.wrapping_sub(number >> bit & 1);
        }
    }
    coordinates
}

/// The first two coordinates of point `index`. The direction numbers of the second one are Pascal's triangle modulo 2, whose
/// element (i, j) is 1 if the digits of i are among those of j: a step for each digit adds them all up.
#[inline(always)]
pub(super) const fn plane(index: u32) -> [u32; 2] {
    let mut y = index;
    y ^= (y >> 1) & 0x5555_5555;
    y ^= (y >> 2) & 0x3333_3333;
    y ^= (y >> 4) & 0x0f0f_0f0f;
    y ^= (y >> 8) & 0x00ff_00ff;
    y ^= y >> 16;
    [index.reverse_bits(), y.reverse_bits()]
}

/// Owen's scrambling of a binary fraction: each digit is flipped or not, depending on those before it.
#[inline(always)]
pub(super) const fn scramble(x: u32, seed: u32) -> u32 {
    scramble_reversed(x.reverse_bits(), seed)
}

/// The same for a fraction whose digits come in the opposite order.
#[inline(always)]
pub(super) const fn scramble_reversed(mut x: u32, seed: u32) -> u32 {
    // Laine and Karras's permutation, with Burley's constants: carries run from low to high only.
    x = x.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

/// A hash without collisions (Wellons' lowbias32).
#[inline(always)]
pub(super) const fn hash(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(index: u32) -> [u32; DIMENSIONS] {
        std::array::from_fn(|dimension| coordinates(&[index, 0], dimension)[0])
    }

    #[test]
    fn every_run_of_64_puts_one_point_into_each_rectangle() {
        for seed in [0, 1, 77, u32::MAX] {
            for run in 0..4 {
                let points: Vec<[u32; 2]> = (0..64)
                    .map(|i| point(run * 64 + i))
                    .map(|[x, y, ..]| [scramble(x, seed), scramble(y, hash(seed))])
                    .collect();
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
    fn every_run_puts_one_point_into_each_part_of_each_dimension() {
        for run in 0..3 {
            for dimension in 0..DIMENSIONS {
                let mut parts: Vec<u32> = (0..64).map(|i| scramble(point(run * 64 + i)[dimension], 5) >> 26).collect();
                parts.sort_unstable();
                assert_eq!(parts, (0..64).collect::<Vec<_>>(), "run {run}, dimension {dimension}");
            }
        }
    }

    #[test]
    fn the_plane_is_that_of_the_first_two_coordinates() {
        for index in (0..2_000).chain((0..32).map(|bit| 1 << bit)).chain([u32::MAX, 0x1234_5678, 0xdead_beef]) {
            let [x, y, ..] = point(index);
            assert_eq!(plane(index), [x, y], "{index}");
        }
    }

    #[test]
    fn its_first_points_are_the_published_ones() {
        // Joe and Kuo's table for three dimensions, in their order of a Gray code.
        let published = [[0.5, 0.5, 0.5], [0.75, 0.25, 0.25], [0.25, 0.75, 0.75], [0.375, 0.375, 0.625]];
        for (i, expected) in (1u32..).zip(published) {
            let [x, y, z, ..] = point(i ^ (i >> 1)).map(|x| f64::from(x) / 4_294_967_296.0);
            assert_eq!([x, y, z], expected, "{i}");
        }
    }
}
