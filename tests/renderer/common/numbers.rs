//! The numbers of one precision.

use glam::DVec3;
use strahl::scene::description::Precision;

/// One precision and its rounding.
#[derive(Clone, Copy)]
pub struct Numbers {
    pub precision: Precision,
    /// Largest relative error of one rounding.
    pub u: f64,
}

impl Numbers {
    pub fn new(precision: Precision) -> Self {
        let epsilon = if precision == Precision::Single { f32::EPSILON.into() } else { f64::EPSILON };
        Self { precision, u: epsilon / 2.0 }
    }

    pub fn is_double(&self) -> bool {
        self.precision == Precision::Double
    }

    /// One of two values, by precision.
    pub fn pick<T>(&self, single: T, double: T) -> T {
        if self.is_double() { double } else { single }
    }

    /// The nearest number of this format.
    pub fn round(&self, x: f64) -> f64 {
        if self.is_double() { x } else { f64::from(x as f32) }
    }

    /// The nearest vector of this format.
    pub fn round3(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.round(v.x), self.round(v.y), self.round(v.z))
    }

    pub fn name(&self) -> &'static str {
        self.pick("single", "double")
    }
}
