//! The torus: roots of its quartic are bracketed by the roots of the derivative and found by halving.

use super::ray::{Ball, Crossing, Ray};
use super::shape::Shape;
use crate::math;
use glam::DVec3;
use std::f64::consts::PI;

/// All points at `minor` from a circle of radius `major`, with `minor` < `major`.
#[derive(Debug)]
pub(super) struct Torus {
    pub(super) center: DVec3,
    /// Unit.
    pub(super) axis: DVec3,
    pub(super) major: f64,
    pub(super) minor: f64,
}

impl Torus {
    /// Signed distance from the surface, of a point relative to the centre.
    fn distance(&self, p: DVec3) -> f64 {
        let z = p.dot(self.axis);
        math::hypot((p - self.axis * z).length() - self.major, z) - self.minor
    }
}

impl Shape for Torus {
    /// Along p = o + s d with |d| = 1 and o.d = 0, the quartic (|p|^2 + R^2 - r^2)^2 - 4 R^2 (|p|^2 - p_z^2) has the
    /// sign of the distance to the tube's surface. So the quartic serves to separate the roots, while the distance,
    /// which does not cancel, decides where they are.
    fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let (middle, line) = ray.around(self.center);
        let speed = ray.dir.length();
        let (o, d) = (line.origin, line.dir / speed);
        let outer = (self.major + self.minor) * (1.0 + 1e-9);
        let half_chord_squared = outer * outer - o.length_squared();
        if half_chord_squared <= 0.0 {
            return Vec::new();
        }
        let end = half_chord_squared.sqrt();

        let (oz, dz) = (o.dot(self.axis), d.dot(self.axis));
        let major_squared = self.major * self.major;
        let m = o.length_squared() + major_squared - self.minor * self.minor;
        let c2 = 2.0 * m - 4.0 * major_squared * (1.0 - dz * dz);
        let c1 = 8.0 * major_squared * oz * dz;
        let derivative = |s: f64| (4.0 * s * s + 2.0 * c2) * s + c1;
        let turn = (-c2 / 6.0).max(0.0).sqrt().min(end);

        let mut brackets = vec![-end];
        brackets.extend(roots_between(&[-end, -turn, turn, end], derivative));
        brackets.push(end);
        roots_between(&brackets, |s| self.distance(o + d * s))
            .into_iter()
            .map(|s| {
                let p = o + d * s;
                let across = (p - self.axis * p.dot(self.axis)).normalize();
                let normal = (p - across * self.major).normalize();
                let point = self.center + across * self.major + normal * self.minor;
                Crossing::flat(middle + s / speed, point, normal)
            })
            .collect()
    }

    fn contains(&self, point: DVec3) -> bool {
        self.distance(point - self.center) < 0.0
    }

    fn ball(&self) -> Option<Ball> {
        Some(Ball { center: self.center, radius: self.major + self.minor })
    }

    fn volume(&self) -> Option<f64> {
        Some(2.0 * PI * PI * self.major * self.minor.powi(2))
    }
}

/// The roots of `f` between neighbouring `points`, one wherever its sign differs, to the last bit.
fn roots_between(points: &[f64], f: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut roots = Vec::new();
    for pair in points.windows(2) {
        let (mut a, mut b) = (pair[0], pair[1]);
        let sign_at_a = f(a) > 0.0;
        if (f(b) > 0.0) == sign_at_a {
            continue;
        }
        loop {
            let mid = f64::midpoint(a, b);
            if mid <= a || mid >= b {
                break;
            }
            if (f(mid) > 0.0) == sign_at_a { a = mid } else { b = mid }
        }
        roots.push(f64::midpoint(a, b));
    }
    roots
}
