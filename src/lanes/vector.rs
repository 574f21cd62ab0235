//! Vectors of three, one for each lane.

use super::Lanes;
use std::ops::{Add, Mul, Neg, Sub};

/// x, y and z of every lane.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "the names say it")]
pub struct V3<L> {
    pub x: L,
    pub y: L,
    pub z: L,
}

impl<L: Lanes> V3<L> {
    /// The same vector in all lanes.
    #[inline(always)]
    pub fn splat(s: L::Simd, v: [L::Real; 3]) -> Self {
        Self { x: L::splat(s, v[0]), y: L::splat(s, v[1]), z: L::splat(s, v[2]) }
    }

    /// Lane i gets `f(i)`.
    #[inline(always)]
    pub fn from_fn(s: L::Simd, mut f: impl FnMut(usize) -> [L::Real; 3]) -> Self {
        Self { x: L::from_fn(s, |i| f(i)[0]), y: L::from_fn(s, |i| f(i)[1]), z: L::from_fn(s, |i| f(i)[2]) }
    }

    /// The vector in lane `i`.
    #[inline(always)]
    pub fn lane(self, i: usize) -> [L::Real; 3] {
        [self.x.lane(i), self.y.lane(i), self.z.lane(i)]
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, o: Self) -> L {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// Vector product.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self { x: self.y * o.z - self.z * o.y, y: self.z * o.x - self.x * o.z, z: self.x * o.y - self.y * o.x }
    }

    /// Length.
    #[inline(always)]
    pub fn length(self) -> L {
        self.dot(self).sqrt()
    }

    /// Multiplied by the reciprocal of its length, since a division takes as long as ten products; NaN for the zero vector.
    #[inline(always)]
    pub fn normalized(self, s: L::Simd) -> Self {
        self * (L::lit(s, 1.0) / self.length())
    }

    /// The same with `other` where it has no direction.
    #[inline(always)]
    pub fn unit_or(self, s: L::Simd, other: Self) -> Self {
        let inverse = L::lit(s, 1.0) / self.length();
        let known = inverse.gt(L::lit(s, 0.0)) & inverse.lt(L::lit(s, f64::INFINITY));
        Self::select(known, self * inverse, other)
    }

    /// Where it is neither infinite nor NaN.
    #[inline(always)]
    pub fn is_finite(self, s: L::Simd) -> L::Mask {
        let (all, beyond) = (self.abs(), L::lit(s, f64::INFINITY));
        all.x.lt(beyond) & all.y.lt(beyond) & all.z.lt(beyond)
    }

    /// Where all components are the same.
    #[inline(always)]
    pub fn eq(self, o: Self) -> L::Mask {
        self.x.eq(o.x) & self.y.eq(o.y) & self.z.eq(o.z)
    }

    /// A matrix, given by its columns, times the vector.
    #[inline(always)]
    pub fn turned(self, s: L::Simd, [x, y, z]: [[L::Real; 3]; 3]) -> Self {
        Self::splat(s, x) * self.x + Self::splat(s, y) * self.y + Self::splat(s, z) * self.z
    }

    /// Two unit vectors perpendicular to this unit vector and to each other (Duff et al., Building an Orthonormal Basis,
    /// Revisited, JCGT 6(1), 2017).
    #[inline(always)]
    pub fn across(self, s: L::Simd) -> [Self; 2] {
        let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
        let sign = L::select(self.z.lt(zero), -one, one);
        let a = -one / (sign + self.z);
        let b = self.x * self.y * a;
        [
            Self { x: one + sign * self.x * self.x * a, y: sign * b, z: -sign * self.x },
            Self { x: b, y: sign + self.y * self.y * a, z: -self.y },
        ]
    }

    /// Component by component.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    /// Component by component.
    #[inline(always)]
    pub fn times(self, o: Self) -> Self {
        Self { x: self.x * o.x, y: self.y * o.y, z: self.z * o.z }
    }

    /// `a` where the mask is true, `b` elsewhere.
    #[inline(always)]
    pub fn select(mask: L::Mask, a: Self, b: Self) -> Self {
        Self { x: L::select(mask, a.x, b.x), y: L::select(mask, a.y, b.y), z: L::select(mask, a.z, b.z) }
    }
}

impl<L: Lanes> Add for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl<L: Lanes> Sub for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl<L: Lanes> Neg for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<L: Lanes> Mul<L> for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, k: L) -> Self {
        Self { x: self.x * k, y: self.y * k, z: self.z * k }
    }
}
