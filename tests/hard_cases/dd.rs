//! Numbers of 106 bits, as sums of two f64 (Dekker 1971), and the exact answers that need them.

use glam::DVec3;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// `high + low`.
#[derive(Clone, Copy)]
pub struct Dd {
    high: f64,
    low: f64,
}

impl Dd {
    /// The nearest f64.
    pub fn f64(self) -> f64 {
        self.high + self.low
    }

    /// Square root of a number above 0.
    pub fn sqrt(self) -> Self {
        let guess = Self::from(self.high.sqrt());
        (guess + self / guess) * 0.5.into()
    }
}

impl From<f64> for Dd {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

fn sum(a: f64, b: f64) -> Dd {
    let high = a + b;
    let part = high - a;
    Dd { high, low: (a - (high - part)) + (b - part) }
}

impl Add for Dd {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        let (s, t) = (sum(self.high, o.high), sum(self.low, o.low));
        let s = sum(s.high, s.low + t.high);
        sum(s.high, s.low + t.low)
    }
}

impl Neg for Dd {
    type Output = Self;
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for Dd {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Mul for Dd {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let high = self.high * o.high;
        let low = self.high.mul_add(o.high, -high) + (self.high * o.low + self.low * o.high);
        sum(high, low)
    }
}

impl Div for Dd {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let first = Self::from(self.high / o.high);
        let second = (self - first * o).high / o.high;
        let third = (self - (first + second.into()) * o).high / o.high;
        first + second.into() + third.into()
    }
}

/// A vector of [`Dd`].
pub fn exact(v: DVec3) -> [Dd; 3] {
    v.to_array().map(Dd::from)
}

/// Scalar product.
pub fn dot(a: [Dd; 3], b: [Dd; 3]) -> Dd {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Where a line meets a sphere.
pub struct Crossing {
    /// How far the line passes the centre, less the radius.
    pub beside: f64,
    /// The nearer root, if there is one.
    pub first: Option<Dd>,
}

/// A sphere about the origin, or with one coordinate of everything 0 an infinite cylinder about that axis.
pub fn sphere(f: [Dd; 3], d: [Dd; 3], radius: f64) -> Crossing {
    let r = Dd::from(radius);
    let (a, b, c) = (dot(d, d), dot(f, d), dot(f, f) - r * r);
    let discriminant = b * b - a * c;
    // l^2 - r^2 = -discriminant / a.
    let beside = -(discriminant / a).f64();
    let beside = beside / ((radius * radius + beside).max(0.0).sqrt() + radius);
    let first = (discriminant.f64() > 0.0).then(|| (-b - discriminant.sqrt()) / a);
    Crossing { beside, first }
}
