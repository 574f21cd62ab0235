//! Primitives while a hierarchy is built, alone or in runs of neighbours that stay together: their boxes lie side by side in
//! memory, and are moved instead of pointed at.

use super::bounds::Slab;
use crate::lanes::Real;
use std::ops::Range;

/// A box of four coordinates, three of which are space. The union of two takes one instruction for each side; with three
/// coordinates it takes more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Box4<R> {
    min: [R; 4],
    max: [R; 4],
}

impl<R: Real> Box4<R> {
    /// The box without points.
    pub(super) fn empty() -> Self {
        Self { min: [R::from_f64(f64::INFINITY); 4], max: [R::from_f64(f64::NEG_INFINITY); 4] }
    }

    /// The smallest box around the corners of a triangle.
    #[inline(always)]
    pub(super) fn around(corners: [[R; 3]; 3]) -> Self {
        let [a, b, c] = corners.map(|[x, y, z]| {
            let point = [x, y, z, R::default()];
            Self { min: point, max: point }
        });
        a.union(b).union(c)
    }

    /// The smallest box around two.
    #[inline(always)]
    pub(super) fn union(self, other: Self) -> Self {
        Self {
            min: std::array::from_fn(|i| smaller(self.min[i], other.min[i])),
            max: std::array::from_fn(|i| larger(self.max[i], other.max[i])),
        }
    }

    /// Lowest corner and extent.
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

/// The box of a primitive, or of a run of some whose indices follow each other. The fourth coordinates hold the first index, in
/// two halves of 16 bits, the lower with the count in the 8 bits above it: every format represents whole numbers of 24 bits
/// exactly. It takes 32 bytes in single precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BuildPrimitive<R>(pub(super) Box4<R>);

impl<R: Real> BuildPrimitive<R> {
    /// `count` primitives, from 1 to 255, in one box.
    pub(super) fn new(slab: &Slab<R>, first: u32, count: u32) -> Self {
        let half = |bits: u32| R::from_f64(f64::from(bits));
        let ([a, b, c], [x, y, z]) = (slab.min, slab.max);
        Self(Box4 { min: [a, b, c, half(count << 16 | first & 0xffff)], max: [x, y, z, half(first >> 16)] })
    }

    /// Number of primitives.
    #[inline(always)]
    pub(super) fn count(&self) -> u32 {
        self.0.min[3].to_f64() as u32 >> 16
    }

    /// Indices of the primitives.
    pub(super) fn indices(&self) -> Range<usize> {
        let [low, high] = [self.0.min[3], self.0.max[3]].map(|half| half.to_f64() as usize);
        let first = high << 16 | low & 0xffff;
        first..first + (low >> 16)
    }

    /// Twice the centre. The fourth coordinate means nothing.
    #[inline(always)]
    pub(super) fn center(&self) -> [R; 4] {
        std::array::from_fn(|i| self.0.min[i] + self.0.max[i])
    }

    /// One coordinate of twice the centre.
    #[inline(always)]
    pub(super) fn center_on(&self, axis: usize) -> R {
        self.0.min[axis] + self.0.max[axis]
    }

    /// The box that is (twice) the centre.
    #[inline(always)]
    pub(super) fn center_box(&self) -> Box4<R> {
        let center = self.center();
        Box4 { min: center, max: center }
    }
}

/// The box around some primitives, and the box around (twice) their centres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NodeBounds<R> {
    pub(super) around: Box4<R>,
    pub(super) centers: Box4<R>,
}

impl<R: Real> NodeBounds<R> {
    pub(super) fn of(primitives: &[BuildPrimitive<R>]) -> Self {
        let around = primitives.iter().fold(Box4::empty(), |around, primitive| around.union(primitive.0));
        Self { around, centers: centers(primitives) }
    }
}

/// The box around (twice) the centres of some primitives.
pub(super) fn centers<R: Real>(primitives: &[BuildPrimitive<R>]) -> Box4<R> {
    primitives.iter().fold(Box4::empty(), |around, primitive| around.union(primitive.center_box()))
}
