//! Pixels between those that were traced: from coarse to fine, each is the mean of the four nearest of the next coarser grid.
//!
//! Means that follow edges were tried: they are better on some scenes and worse on as many.

use crate::film::Region;
use rayon::prelude::*;

/// Rows that are interpolated before their values are stored.
const BAND: usize = 256;

/// Interpolates the pixels of a region for which `is_known` is false, row by row. Those of the grid with a distance of
/// `coarsest`, a power of two, have to be known.
pub(super) fn interpolate(
    pixels: &mut [[f32; 3]],
    region: Region,
    coarsest: u32,
    is_known: impl Fn(usize) -> bool + Sync,
) {
    let mut step = coarsest / 2;
    while step > 0 {
        // First the middles of squares, then those of their edges, which lie between corners and middles.
        for of_edges in [false, true] {
            let rows: Vec<u32> = (0..region.height).step_by(step as usize).collect();
            let rows: Vec<u32> = rows.into_iter().filter(|y| of_edges || (y / step) % 2 == 1).collect();
            for band in rows.chunks(BAND) {
                let read = &*pixels;
                let of_row = |y: &u32| -> Vec<(u32, [f32; 3])> {
                    let first = if of_edges && (y / step) % 2 == 1 { 0 } else { step };
                    let across = (first..region.width).step_by(2 * step as usize);
                    let unknown = across.filter(|x| !is_known((y * region.width + x) as usize));
                    unknown.map(|x| (x, mean(read, region, [x, *y], step, of_edges))).collect()
                };
                let values: Vec<Vec<(u32, [f32; 3])>> = band.par_iter().with_min_len(16).map(of_row).collect();
                let (first, apart) = (band[0], if of_edges { step } else { 2 * step });
                let [first, apart] = [first, apart].map(|rows| (rows * region.width) as usize);
                let rows = pixels[first..].par_chunks_mut(apart).zip(values).with_min_len(16);
                rows.for_each(|(row, values)| values.into_iter().for_each(|(x, value)| row[x as usize] = value));
            }
        }
        step /= 2;
    }
}

/// The mean of the pixels at a distance from one, across and down or diagonally. Of two opposite ones both count or neither,
/// unless only single ones lie in the picture.
fn mean(pixels: &[[f32; 3]], region: Region, [x, y]: [u32; 2], step: u32, straight: bool) -> [f32; 3] {
    if x >= step && y >= step && x + step < region.width && y + step < region.height {
        // Away from the borders all four are there; they are added in the same order.
        let (here, down) = ((y * region.width + x) as usize, (step * region.width) as usize);
        let step = step as usize;
        let four = if straight {
            [here - step, here + step, here - down, here + down]
        } else {
            [here - down - step, here + down + step, here - down + step, here + down - step]
        };
        let sum = four.iter().fold([0.0; 3], |sum: [f32; 3], at| std::array::from_fn(|c| sum[c] + pixels[*at][c]));
        return sum.map(|sum| sum / 4.0);
    }
    let pixel = |x: Option<u32>, y: Option<u32>| {
        let (x, y) = (x.filter(|x| *x < region.width)?, y.filter(|y| *y < region.height)?);
        Some(pixels[(y * region.width + x) as usize])
    };
    let (left, up) = (x.checked_sub(step), y.checked_sub(step));
    let (right, down) = (Some(x + step), Some(y + step));
    let (x, y) = (Some(x), Some(y));
    let pairs = if straight {
        [[pixel(left, y), pixel(right, y)], [pixel(x, up), pixel(x, down)]]
    } else {
        [[pixel(left, up), pixel(right, down)], [pixel(right, up), pixel(left, down)]]
    };
    let whole = pairs.iter().any(|[a, b]| a.is_some() && b.is_some());
    let counted = pairs.iter().filter(|[a, b]| !whole || (a.is_some() && b.is_some()));
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for pixel in counted.flatten().flatten() {
        sum = std::array::from_fn(|c| sum[c] + pixel[c]);
        count += 1.0;
    }
    sum.map(|sum| sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_is_interpolated_exactly() {
        let region = Region { x: 3, y: 9, width: 65, height: 33 };
        let slope = |[x, y]: [u32; 2]| [x as f32, y as f32, (x + 2 * y) as f32];
        for (coarsest, extra) in [(8, false), (8, true), (32, false), (2, true)] {
            let known = |index: usize| {
                let (x, y) = (index % 65, index / 65);
                (x % coarsest == 0 && y % coarsest == 0) || (extra && index.is_multiple_of(7))
            };
            let mut pixels: Vec<[f32; 3]> = region.iter().map(slope).collect();
            for (index, pixel) in pixels.iter_mut().enumerate() {
                if !known(index) {
                    *pixel = [f32::NAN; 3];
                }
            }
            interpolate(&mut pixels, region, coarsest as u32, known);
            for (at, pixel) in region.iter().zip(&pixels) {
                let wanted = slope(at);
                assert!((0..3).all(|c| (pixel[c] - wanted[c]).abs() < 1e-3), "{at:?} {pixel:?} {wanted:?}");
            }
        }
        // A region narrower than the grid.
        let mut thin: Vec<[f32; 3]> = vec![[7.0; 3], [0.0; 3], [0.0; 3]];
        interpolate(&mut thin, Region { x: 0, y: 0, width: 1, height: 3 }, 32, |index| index == 0);
        assert_eq!(thin, [[7.0; 3]; 3]);
    }
}
