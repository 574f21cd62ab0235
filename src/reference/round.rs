//! Quadrics: the sphere, and the cone with the cylinder as a special case.

use super::flat::{Disc, Plane};
use super::ray::{Ball, Crossing, Ray};
use super::shape::Shape;
use crate::math;
use glam::DVec3;
use std::f64::consts::PI;

/// A ball as a body.
#[derive(Debug)]
pub(super) struct Sphere {
    pub(super) center: DVec3,
    pub(super) radius: f64,
}

impl Shape for Sphere {
    /// From the point closest to the centre the two crossings lie half a chord away: no quadratic to cancel in.
    fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let (middle, line) = ray.around(self.center);
        let distance = line.origin.length();
        if distance > self.radius {
            return Vec::new();
        }
        let half = ((self.radius - distance) * (self.radius + distance)).sqrt() / ray.dir.length();
        let at = |s: f64| {
            let normal = line.at(s).normalize();
            Crossing::flat(middle + s, self.center + normal * self.radius, normal)
        };
        vec![at(-half), at(half)]
    }

    fn contains(&self, point: DVec3) -> bool {
        point.distance(self.center) < self.radius
    }

    fn ball(&self) -> Option<Ball> {
        Some(Ball { center: self.center, radius: self.radius })
    }

    fn volume(&self) -> Option<f64> {
        Some(4.0 / 3.0 * PI * self.radius.powi(3))
    }
}

/// Frustum of a circular cone around an axis; a cylinder if both radii are equal.
#[derive(Debug)]
pub(super) struct Frustum {
    base: DVec3,
    /// Unit, from base to top.
    axis: DVec3,
    height: f64,
    base_radius: f64,
    /// Radius gained per length along the axis.
    slope: f64,
    caps: Vec<Disc>,
    ball: Ball,
    capped: bool,
}

impl Frustum {
    pub(super) fn new(base: DVec3, base_radius: f64, top: DVec3, top_radius: f64, capped: bool) -> Self {
        let height = base.distance(top);
        let axis = (top - base) / height;
        let disc = |point, normal, radius| Disc { plane: Plane { point, normal }, radius };
        let mut caps = vec![disc(base, -axis, base_radius), disc(top, axis, top_radius)];
        caps.retain(|cap| capped && cap.radius > 0.0);
        Self {
            base,
            axis,
            height,
            base_radius,
            slope: (top_radius - base_radius) / height,
            caps,
            ball: Ball { center: base.midpoint(top), radius: math::hypot(height / 2.0, base_radius.max(top_radius)) },
            capped,
        }
    }

    /// With z along the axis and q across it, |q|^2 = (r0 + k z)^2.
    fn side_crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let (middle, line) = ray.around(self.ball.center);
        let o = line.origin + (self.ball.center - self.base);
        let (oz, dz) = (o.dot(self.axis), line.dir.dot(self.axis));
        let (oq, dq) = (o - self.axis * oz, line.dir - self.axis * dz);
        let k = self.slope;
        let (radius, growth) = (self.base_radius + k * oz, k * dz);
        let a = dq.length_squared() - growth * growth;
        let b = oq.dot(dq) - growth * radius;
        let c = (oq.length() - radius) * (oq.length() + radius);

        let mut found = Vec::new();
        for s in half_quadratic_roots(a, b, c) {
            let z = oz + dz * s;
            if !(0.0..=self.height).contains(&z) {
                continue;
            }
            let across = (oq + dq * s).normalize_or_zero();
            let point = self.base + self.axis * z + across * (self.base_radius + k * z);
            found.push(Crossing::flat(middle + s, point, across - self.axis * k));
        }
        found.retain(|crossing| crossing.normal != DVec3::ZERO);
        found
    }
}

impl Shape for Frustum {
    fn volume(&self) -> Option<f64> {
        let (r, q) = (self.base_radius, self.base_radius + self.slope * self.height);
        self.capped.then_some(PI / 3.0 * self.height * (r * r + r * q + q * q))
    }

    fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let mut found: Vec<Crossing> = self.caps.iter().flat_map(|cap| cap.crossings(ray)).collect();
        found.extend(self.side_crossings(ray));
        found
    }

    fn contains(&self, point: DVec3) -> bool {
        let z = (point - self.base).dot(self.axis);
        let across = (point - self.base - self.axis * z).length();
        0.0 < z && z < self.height && across < self.base_radius + self.slope * z
    }

    fn ball(&self) -> Option<Ball> {
        Some(self.ball)
    }
}

/// Real roots of a x^2 + 2 b x + c, without cancellation: q = -(b + sign(b) sqrt(b^2 - a c)), roots q/a and c/q.
fn half_quadratic_roots(a: f64, b: f64, c: f64) -> Vec<f64> {
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return Vec::new();
    }
    let q = -(b + discriminant.sqrt().copysign(b));
    let mut roots = Vec::new();
    if a != 0.0 {
        roots.push(q / a);
    }
    if q != 0.0 {
        roots.push(c / q);
    } else if a != 0.0 {
        roots.push(0.0);
    }
    roots
}
