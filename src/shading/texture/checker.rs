//! The colour of a material in every kernel: uniform, or a checkerboard.

use crate::lanes::{Lanes, Real, V3};

/// A colour that may depend on the place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BaseColor<R> {
    /// The same everywhere.
    Uniform([R; 3]),
    /// `a` where the sum of floor(p / size) over the axes is even, `b` elsewhere.
    Checker {
        /// Colour of the even tiles.
        a: [R; 3],
        /// Colour of the odd tiles.
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
    /// The colour at points of the body's own coordinates.
    #[inline(always)]
    pub fn at<L: Lanes<Real = R>>(&self, s: L::Simd, local: V3<L>) -> V3<L> {
        match self {
            Self::Uniform(color) => V3::splat(s, *color),
            Self::Checker { a, b, size, inverse, axes } => {
                let tiles = |p: L| match inverse {
                    Some(inverse) => p * L::splat(s, *inverse),
                    None => p / L::splat(s, *size),
                };
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
