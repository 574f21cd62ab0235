//! FLIP, the difference that a person sees who flips between two pictures (Andersson, Nilsson, Akenine-Möller,
//! Oskarsson, Åström, Fairchild, FLIP: A Difference Evaluator for Alternating Images, HPG 2020), for 8-bit pictures. Once the work
//! of a thread is to stop, what it says is of no use.

use super::image::over_both;
use super::{Image8, Spread};
use crate::control;
use crate::math::{self, exp, pow, srgb_to_linear};
use rayon::prelude::*;
use std::f64::consts::{PI, SQRT_2};

/// Pixels per degree of the published viewing conditions: a screen 0.7 m wide with 3,840 pixels, seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 67.020_643_276_582_25;

type Rgb = [f64; 3];

/// FLIP of each pixel of two pictures of one size, from 0, the same, to 1.
pub fn flip(reference: &Image8, test: &Image8) -> Spread {
    Spread::of(flip_map(reference, test))
}

/// The same for each pixel, row by row; where there is alpha, the larger of those over black and over white.
pub fn flip_map(reference: &Image8, test: &Image8) -> Vec<f64> {
    over_both(reference, test, over_black)
}

fn over_black(reference: &Image8, test: &Image8) -> Vec<f64> {
    let (a, b) = (Seen::new(reference), Seen::new(test));
    let most = pow(hyab(hunt([0.0, 1.0, 0.0]), hunt([0.0, 0.0, 1.0])), 0.7);
    let pixel = |i: usize| {
        if control::step(1) {
            return 0.0;
        }
        let color = spread_out(pow(hyab(a.color[i], b.color[i]), 0.7), most);
        let edges = (a.edges[i] - b.edges[i]).abs();
        let points = (a.points[i] - b.points[i]).abs();
        let feature = (edges.max(points) / SQRT_2).sqrt();
        if color == 0.0 { 0.0 } else { pow(color, 1.0 - feature) }
    };
    (0..reference.pixels.len()).into_par_iter().map(pixel).collect()
}

/// Color errors up to 0.4 of the largest fill 0.95 of the range.
fn spread_out(error: f64, most: f64) -> f64 {
    let knee = 0.4 * most;
    if error < knee { error * 0.95 / knee } else { 0.95 + (error - knee) / (most - knee) * 0.05 }
}

/// A picture as the eye filters it.
struct Seen {
    /// Hunt-adjusted CIELAB after the eye's blur.
    color: Vec<[f64; 3]>,
    /// Strength of edges.
    edges: Vec<f64>,
    /// Strength of points.
    points: Vec<f64>,
}

impl Seen {
    fn new(picture: &Image8) -> Self {
        let (width, height) = (picture.width, picture.height());
        let table: Vec<f64> = (0..=255u8).map(|code| srgb_to_linear(f64::from(code) / 255.0)).collect();
        let opponent: Vec<[f64; 3]> =
            picture.pixels.par_iter().map(|pixel| to_opponent(pixel.map(|code| table[code as usize]))).collect();
        let channel = |c: usize| Plane { width, height, values: opponent.iter().map(|pixel| pixel[c]).collect() };
        let [y, cx, cz] = [channel(0), channel(1), channel(2)];

        // Contrast sensitivity as sums of Gaussians of frequency (Table 1); a Gaussian is separable.
        let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
        let blur = |plane: &Plane, terms: &[[f64; 2]]| plane.filtered_by_sum(terms, radius);
        let y_seen = blur(&y, &[[1.0, 0.0047]]);
        let cx_seen = blur(&cx, &[[1.0, 0.0053]]);
        let cz_seen = blur(&cz, &[[34.1, 0.04], [13.5, 0.025]]);
        let color = (0..width * height)
            .into_par_iter()
            .map(|i| hunt(from_opponent([y_seen[i], cx_seen[i], cz_seen[i]]).map(|x| x.clamp(0.0, 1.0))))
            .collect();

        // Features of the width 0.082 degrees, of the lightness between 0 and 1.
        let lightness = Plane { values: y.values.iter().map(|y| (y + 16.0) / 116.0).collect(), ..y };
        let deviation = 0.5 * 0.082 * PIXELS_PER_DEGREE;
        let radius = (3.0 * deviation).ceil() as i32;
        let gauss = |x: f64| exp(-x * x / (2.0 * deviation * deviation));
        let smooth = normalized(radius, gauss);
        let first = normalized_by_sign(radius, |x| -x * gauss(x));
        let second = normalized_by_sign(radius, |x| (x * x / (deviation * deviation) - 1.0) * gauss(x));
        let strength = |kernel: &[f64]| -> Vec<f64> {
            let x = lightness.filtered(kernel, &smooth);
            let y = lightness.filtered(&smooth, kernel);
            x.iter().zip(&y).map(|(x, y)| math::hypot(*x, *y)).collect()
        };
        Self { color, edges: strength(&first), points: strength(&second) }
    }
}

/// One number for each pixel.
struct Plane {
    width: usize,
    height: usize,
    values: Vec<f64>,
}

impl Plane {
    /// Filtered by one kernel along rows and another along columns; beyond the edge lies the pixel at the edge.
    fn filtered(&self, along_x: &[f64], along_y: &[f64]) -> Vec<f64> {
        let (width, height) = (self.width, self.height);
        let stops = |len: usize| control::step(1 + (len / 8) as u32);
        let row = |values: &[f64], y: usize| -> Vec<f64> {
            if stops(width) {
                return vec![0.0; width];
            }
            let values = &values[y * width..(y + 1) * width];
            (0..width).map(|x| weighted(along_x, x, width, |x| values[x])).collect()
        };
        let rows: Vec<Vec<f64>> = (0..height).into_par_iter().map(|y| row(&self.values, y)).collect();
        let column = |y: usize| -> Vec<f64> {
            if stops(width) {
                return vec![0.0; width];
            }
            (0..width).map(|x| weighted(along_y, y, height, |y| rows[y][x])).collect()
        };
        let columns: Vec<Vec<f64>> = (0..height).into_par_iter().map(column).collect();
        columns.concat()
    }

    /// Filtered by sum over [a, b] of a sqrt(pi/b) exp(-pi^2 z^2 / b), with z in degrees, whose weights add up to 1.
    fn filtered_by_sum(&self, terms: &[[f64; 2]], radius: i32) -> Vec<f64> {
        let term = |b: f64| kernel(radius, |x| exp(-PI * PI * x * x / (PIXELS_PER_DEGREE * PIXELS_PER_DEGREE * b)));
        let weight = |[a, b]: [f64; 2]| a * (PI / b).sqrt();
        let area = |b: f64| term(b).iter().sum::<f64>().powi(2);
        let total: f64 = terms.iter().map(|&[a, b]| weight([a, b]) * area(b)).sum();
        let mut sum = vec![0.0; self.values.len()];
        for &[a, b] in terms {
            let one = term(b);
            for (sum, value) in sum.iter_mut().zip(self.filtered(&one, &one)) {
                *sum += value * weight([a, b]) / total;
            }
        }
        sum
    }
}

/// Sum of a kernel's weights times the values around `at`.
fn weighted(kernel: &[f64], at: usize, end: usize, value: impl Fn(usize) -> f64) -> f64 {
    let radius = kernel.len() / 2;
    let place = |k: usize| (at + k).saturating_sub(radius).min(end - 1);
    kernel.iter().enumerate().map(|(k, weight)| weight * value(place(k))).sum()
}

fn kernel(radius: i32, f: impl Fn(f64) -> f64) -> Vec<f64> {
    (-radius..=radius).map(|x| f(f64::from(x))).collect()
}

fn normalized(radius: i32, f: impl Fn(f64) -> f64) -> Vec<f64> {
    let values = kernel(radius, f);
    let sum: f64 = values.iter().sum();
    values.into_iter().map(|x| x / sum).collect()
}

/// Positive weights add up to 1, negative ones to -1.
fn normalized_by_sign(radius: i32, f: impl Fn(f64) -> f64) -> Vec<f64> {
    let values = kernel(radius, f);
    let positive: f64 = values.iter().filter(|x| **x > 0.0).sum();
    let negative: f64 = values.iter().filter(|x| **x < 0.0).sum();
    values.into_iter().map(|x| if x > 0.0 { x / positive } else { -x / negative }).collect()
}

/// The white of linear sRGB, as the matrix below has it.
const WHITE: [f64; 3] = [0.950_428_545_377_180_6, 1.0, 1.088_900_370_798_127_7];

fn to_xyz([r, g, b]: Rgb) -> [f64; 3] {
    [
        (10_135_552.0 * r + 8_788_810.0 * g + 4_435_075.0 * b) / 24_577_794.0,
        (2_613_072.0 * r + 8_788_810.0 * g + 887_015.0 * b) / 12_288_897.0,
        (1_425_312.0 * r + 8_788_810.0 * g + 70_074_185.0 * b) / 73_733_382.0,
    ]
}

fn from_xyz([x, y, z]: [f64; 3]) -> Rgb {
    [
        3.241_003_275 * x - 1.537_398_934 * y - 0.498_615_861 * z,
        -0.969_224_334 * x + 1.875_929_983 * y + 0.041_554_224 * z,
        0.055_639_423 * x - 0.204_011_202 * y + 1.057_148_933 * z,
    ]
}

/// YCxCz, CIELAB's axes without its cube root.
fn to_opponent(rgb: Rgb) -> [f64; 3] {
    let xyz = to_xyz(rgb);
    let [x, y, z] = std::array::from_fn(|i| xyz[i] / WHITE[i]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn from_opponent([l, a, b]: [f64; 3]) -> Rgb {
    let y = (l + 16.0) / 116.0;
    let xyz = [y + a / 500.0, y, y - b / 200.0];
    from_xyz(std::array::from_fn(|i| xyz[i] * WHITE[i]))
}

/// CIELAB whose chroma grows with lightness, as Hunt saw.
fn hunt(rgb: Rgb) -> [f64; 3] {
    let xyz = to_xyz(rgb);
    let delta: f64 = 6.0 / 29.0;
    let f = |t: f64| if t > delta.powi(3) { libm::cbrt(t) } else { t / (3.0 * delta * delta) + 4.0 / 29.0 };
    let [x, y, z] = std::array::from_fn(|i| f(xyz[i] / WHITE[i]));
    let l = 116.0 * y - 16.0;
    [l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)]
}

fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + math::hypot(a[1] - b[1], a[2] - b[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: usize, pixels: impl IntoIterator<Item = [u8; 3]>) -> Image8 {
        Image8::opaque(width, pixels.into_iter().collect())
    }

    #[test]
    fn the_same_picture_is_0_and_black_against_white_is_1() {
        let black = picture(32, vec![[0; 3]; 1024]);
        let white = picture(32, vec![[255; 3]; 1024]);
        assert_eq!(flip(&black, &black).max, 0.0);
        let all = flip(&black, &white);
        assert!((all.mean - 1.0).abs() < 0.05 && (all.max - all.mean).abs() < 1e-9, "{all:?}");
    }

    #[test]
    fn work_that_is_to_stop_compares_no_further() {
        let [black, white] = [[0; 3], [255; 3]].map(|code| picture(512, vec![code; 1 << 18]));
        let control = control::Control::default();
        control.cancel();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let stopped = pool.install(|| {
            control.enter_for_good();
            [flip(&black, &white), crate::metrics::ciede2000(&black, &white)]
        });
        // The thread looks now and then only.
        assert!(stopped.iter().all(|spread| spread.mean < 0.5), "{stopped:?}");
        assert!(flip(&black, &white).mean > 0.9);
    }
}
