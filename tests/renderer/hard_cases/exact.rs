//! Where lines meet spheres and circular cylinders, with 106 bits.

use crate::common::wide::{Wide, Wide3};

/// Where a line meets a sphere.
pub struct Crossing {
    /// How far the line passes the centre, less the radius.
    pub beside: f64,
    /// The nearer root, if there is one.
    pub first: Option<f64>,
}

/// A sphere about the origin, or with one coordinate of everything 0 an infinite cylinder about that axis.
pub fn sphere(f: Wide3, d: Wide3, radius: f64) -> Crossing {
    let r = Wide::of(radius);
    let (a, b, c) = (d.dot(d), f.dot(d), f.dot(f) - r * r);
    let discriminant = b * b - a * c;
    // l^2 - r^2 = -discriminant / a.
    let beside = -(discriminant / a).value();
    let beside = beside / ((radius * radius + beside).max(0.0).sqrt() + radius);
    let first = (discriminant.value() > 0.0).then(|| ((-b - discriminant.sqrt()) / a).value());
    Crossing { beside, first }
}
