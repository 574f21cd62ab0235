//! Primitives on their way into a hierarchy: their boxes, side by side in memory and moved rather than pointed at.

use super::bounds::Slab;
use crate::lanes::Real;

/// A box of four coordinates, of which three are space: unions of four are one instruction for each side, of three not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hull<R> {
    min: [R; 4],
    max: [R; 4],
}

impl<R: Real> Hull<R> {
    /// The box without points.
    pub(super) fn empty() -> Self {
        Self { min: [R::from_f64(f64::INFINITY); 4], max: [R::from_f64(f64::NEG_INFINITY); 4] }
    }

    /// The smallest box around two.
    #[inline(always)]
    pub(super) fn union(self, other: Self) -> Self {
        Self {
            min: std::array::from_fn(|i| smaller(self.min[i], other.min[i])),
            max: std::array::from_fn(|i| larger(self.max[i], other.max[i])),
        }
    }

    /// Lowest corner, and the way from there to the highest.
    #[inline(always)]
    pub(super) fn sides(&self) -> ([R; 4], [R; 4]) {
        (self.min, std::array::from_fn(|i| self.max[i] - self.min[i]))
    }

    /// The box in space.
    pub(super) fn slab(&self) -> Slab<R> {
        let [[a, b, c, _], [x, y, z, _]] = [self.min, self.max];
        Slab { min: [a, b, c], max: [x, y, z] }
    }
}

#[inline(always)]
fn smaller<R: Real>(a: R, b: R) -> R {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger<R: Real>(a: R, b: R) -> R {
    if a > b { a } else { b }
}

/// The box of a primitive, and its index in two halves of 16 bits, which every format holds exactly, as the fourth
/// coordinates: 32 bytes in single precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Part<R>(pub(super) Hull<R>);

impl<R: Real> Part<R> {
    pub(super) fn new(slab: &Slab<R>, index: u32) -> Self {
        let half = |bits: u32| R::from_f64(f64::from(bits));
        let ([a, b, c], [x, y, z]) = (slab.min, slab.max);
        Self(Hull { min: [a, b, c, half(index & 0xffff)], max: [x, y, z, half(index >> 16)] })
    }

    /// Index of the primitive.
    pub(super) fn index(&self) -> u32 {
        (self.0.max[3].to_f64() as u32) << 16 | self.0.min[3].to_f64() as u32
    }

    /// Twice the centre. The fourth coordinate means nothing.
    #[inline(always)]
    pub(super) fn center(&self) -> [R; 4] {
        std::array::from_fn(|i| self.0.min[i] + self.0.max[i])
    }

    /// The box that is (twice) the centre.
    #[inline(always)]
    pub(super) fn center_hull(&self) -> Hull<R> {
        let center = self.center();
        Hull { min: center, max: center }
    }
}

/// Where some parts are: the box around them, and the box around (twice) their centres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place<R> {
    pub(super) hull: Hull<R>,
    pub(super) centers: Hull<R>,
}

impl<R: Real> Place<R> {
    pub(super) fn of(parts: &[Part<R>]) -> Self {
        let empty = Self { hull: Hull::empty(), centers: Hull::empty() };
        parts.iter().fold(empty, |place, part| Self {
            hull: place.hull.union(part.0),
            centers: place.centers.union(part.center_hull()),
        })
    }
}
