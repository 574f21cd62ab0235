//! Numbers of about 106 bits as sums of two f64 (Dekker 1971, Knuth's TwoSum), for exact answers in double precision.

use glam::DVec3;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// high + low, where low is below the last bit of high.
#[derive(Clone, Copy, Debug)]
pub struct Wide(pub f64, pub f64);

impl Wide {
    pub fn of(x: f64) -> Self {
        Self(x, 0.0)
    }

    fn sum(a: f64, b: f64) -> Self {
        let s = a + b;
        let t = s - a;
        Self(s, (a - (s - t)) + (b - t))
    }

    /// The nearest f64.
    pub fn value(self) -> f64 {
        self.0 + self.1
    }

    /// Square root of a number that is not below 0.
    pub fn sqrt(self) -> Self {
        let guess = self.0.sqrt();
        if guess == 0.0 {
            return Self::of(0.0);
        }
        let sum = Self::of(guess) + self / Self::of(guess);
        Self(0.5 * sum.0, 0.5 * sum.1)
    }
}

impl Add for Wide {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        let high = Self::sum(self.0, o.0);
        let low = Self::sum(self.1, o.1);
        let s = Self::sum(high.0, high.1 + low.0);
        Self::sum(s.0, s.1 + low.1)
    }
}

impl Neg for Wide {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Sub for Wide {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Mul for Wide {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let p = self.0 * o.0;
        let error = self.0.mul_add(o.0, -p);
        Self::sum(p, error + (self.0 * o.1 + self.1 * o.0))
    }
}

impl Div for Wide {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let first = Self::of(self.0 / o.0);
        let second = Self::of((self - first * o).0 / o.0);
        let third = Self::of((self - (first + second) * o).0 / o.0);
        first + second + third
    }
}

/// A point or vector.
#[derive(Clone, Copy, Debug)]
pub struct Wide3(pub [Wide; 3]);

impl Wide3 {
    pub fn of(v: DVec3) -> Self {
        Self(v.to_array().map(Wide::of))
    }

    pub fn dot(self, o: Self) -> Wide {
        self.0[0] * o.0[0] + self.0[1] * o.0[1] + self.0[2] * o.0[2]
    }

    pub fn times(self, k: Wide) -> Self {
        Self(self.0.map(|x| x * k))
    }

    pub fn value(self) -> DVec3 {
        DVec3::from_array(self.0.map(Wide::value))
    }
}

impl Add for Wide3 {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + o.0[i]))
    }
}

impl Sub for Wide3 {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - o.0[i]))
    }
}
