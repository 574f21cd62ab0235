//! The color of a material in every kernel: uniform, or a checkerboard.

use crate::lanes::{Lanes, Real, V3};

/// A color that may depend on the place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BaseColor<R> {
    /// The same everywhere.
    Uniform([R; 3]),
    /// `a` where the sum of floor(p / size) over the axes is even, `b` elsewhere.
    Checker {
        /// Color of the even tiles.
        a: [R; 3],
        /// Color of the odd tiles.
        b: [R; 3],
        /// Edge of a tile.
        size: R,
        /// 1 / size, if that is exact.
        inverse: Option<R>,
        /// Whether x, y and z count.
        axes: [bool; 3],
    },
}

impl<R: Real> BaseColor<R> {
    /// The color at points of the body's own coordinates, or its mean over boxes around them, whose extents are
    /// asked for where they matter.
    #[inline(always)]
    pub fn at<L: Lanes<Real = R>>(&self, s: L::Simd, local: V3<L>, extents: Option<&dyn Fn() -> V3<L>>) -> V3<L> {
        match self {
            Self::Uniform(color) => V3::splat(s, *color),
            Self::Checker { a, b, size, inverse, axes } => {
                let tiles = |p: L| match inverse {
                    Some(inverse) => p * L::splat(s, *inverse),
                    None => p / L::splat(s, *size),
                };
                if let Some(extents) = extents {
                    let extents = extents();
                    let mut mean = L::lit(s, 1.0);
                    for ((p, extent), counts) in
                        [local.x, local.y, local.z].into_iter().zip([extents.x, extents.y, extents.z]).zip(axes)
                    {
                        if *counts {
                            mean = mean * stripes(s, tiles(p), tiles(extent));
                        }
                    }
                    // Between the two colors whatever the roundings are.
                    let share = (L::lit(s, 0.5) + L::lit(s, 0.5) * mean).max(L::lit(s, 0.0)).min(L::lit(s, 1.0));
                    let (a, b) = (V3::splat(s, *a), V3::splat(s, *b));
                    return a * share + b * (L::lit(s, 1.0) - share);
                }
                let mut sum = L::lit(s, 0.0);
                for (p, counts) in [local.x, local.y, local.z].into_iter().zip(axes) {
                    if *counts {
                        sum = sum + tiles(p).floor();
                    }
                }
                let half = sum * L::lit(s, 0.5);
                V3::select(half.floor().eq(half), V3::splat(s, *a), V3::splat(s, *b))
            }
        }
    }
}

/// Tiles from a border within which a surface may lie on it: more than the roundings of a hit in single precision.
const NEAR: f64 = 1e-4;

/// The mean over an interval of the function that is 1 between an even number and the next one, and -1 beyond that: an axis of
/// a checkerboard (Apodaca and Gritz, Advanced RenderMan, 1999; Quilez, Filtering the Checkerboard Pattern, 2017).
#[inline(always)]
fn stripes<L: Lanes>(s: L::Simd, p: L, extent: L) -> L {
    // Far beyond any tile that a mean still shows.
    let extent = extent.min(L::lit(s, 1e30));
    let p = off_border(s, p, extent);
    let (half, one, two) = (L::lit(s, 0.5), L::lit(s, 1.0), L::lit(s, 2.0));
    let here = from_even(s, p);
    let sign = L::select(here.lt(L::lit(s, 0.0)), -one, one);
    // An interval of at most 1 holds one border at most.
    let away = here.abs();
    let narrow = sign * (two * away.min(one - away) / extent.max(L::lit(s, 1e-30))).min(one);
    // The integral of the function is the distance from the nearest even number.
    let reach = extent * half;
    let wide = (from_even(s, here + reach).abs() - from_even(s, here - reach).abs()) / extent.max(one);
    L::select(extent.le(one), narrow, wide)
}

/// What lies on a border and does not leave it, such as a side of a box, is in the tile behind it: the mean of both would be grey,
/// and roundings would choose between them from pixel to pixel.
#[inline(always)]
fn off_border<L: Lanes>(s: L::Simd, p: L, extent: L) -> L {
    let near = L::lit(s, NEAR);
    let half = L::lit(s, 0.5);
    let border = (p + half).floor();
    // In its middle, which far from the origin is another number than the border.
    L::select(extent.lt(near) & (p - border).abs().lt(near), border + half, p)
}

/// Distance from the nearest even number, at most 1, exact and with its sign.
#[inline(always)]
fn from_even<L: Lanes>(s: L::Simd, x: L) -> L {
    let half = L::lit(s, 0.5);
    x - L::lit(s, 2.0) * (x * half + half).floor()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(p: f64, extent: f64) -> f64 {
        stripes::<f64>((), p, extent)
    }

    #[test]
    fn stripes_are_the_mean_of_many_points() {
        for i in 0..400 {
            let (p, extent) = (f64::from(i) * 0.37 - 70.0, [0.01, 0.3, 0.9, 1.0, 1.3, 2.0, 5.7][i as usize % 7]);
            let at = |k: i32| p + extent * ((f64::from(k) + 0.5) / 4_000.0 - 0.5);
            let sum: f64 = (0..4_000).map(|k| if (at(k).floor() as i64).rem_euclid(2) == 0 { 1.0 } else { -1.0 }).sum();
            assert!(
                (mean(p, extent) - sum / 4_000.0).abs() < 2e-3,
                "{p} {extent}: {} {}",
                mean(p, extent),
                sum / 4_000.0
            );
        }
    }

    #[test]
    fn what_lies_on_a_border_is_in_the_tile_behind_it() {
        for border in [-3.0, 0.0, 7.0, 1e5] {
            let expected = if (border as i64).rem_euclid(2) == 0 { 1.0 } else { -1.0 };
            for off in [-5e-5, -1e-7, 0.0, 1e-7, 5e-5] {
                for extent in [0.0, 1e-9, 5e-5] {
                    assert_eq!(mean(border + off, extent), expected, "{border} {off} {extent}");
                    let single = stripes::<f32>((), (border + off) as f32, extent as f32);
                    assert_eq!(f64::from(single), expected, "{border} {off} {extent} in single precision");
                }
            }
        }
    }

    #[test]
    fn within_a_tile_it_is_exact_and_far_away_it_is_grey() {
        for tile in [-3.0, 0.0, 7.0, 1e5] {
            let expected = if (tile as i64).rem_euclid(2) == 0 { 1.0 } else { -1.0 };
            assert_eq!([mean(tile + 0.5, 0.0), mean(tile + 0.25, 0.5), mean(tile + 0.5, 1.0)], [expected; 3]);
            assert_eq!(mean(tile, 0.5), 0.0);
        }
        for extent in [10.0, 1e3, 1e9, f64::MAX] {
            assert!((0..50).all(|i| mean(f64::from(i) * 0.137, extent).abs() <= 1.0 / extent));
        }
    }
}
