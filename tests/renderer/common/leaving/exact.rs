//! Where rays leave bodies, with 106 bits.

use crate::common::numbers::Numbers;
use crate::common::wide::{Wide, Wide3};
use glam::DVec3;
use strahl::math::hypot;

/// Axis of the tori, not of unit length.
const AXIS: DVec3 = DVec3::new(0.3, -0.5, 0.8);

/// The larger root of a t^2 + 2 b t + c, or nothing.
fn last(a: Wide, b: Wide, c: Wide) -> Option<Wide> {
    let discriminant = b * b - a * c;
    (discriminant.value() >= 0.0).then(|| {
        let root = discriminant.sqrt();
        // Without a difference of numbers that are nearly equal.
        if b.value() > 0.0 { -c / (b + root) } else { (root - b) / a }
    })
}

/// Where a ray leaves a body, by more digits than the kernel's.
pub struct Exit {
    pub t: f64,
    /// How far off a kernel's answer may be times the cosine: some roundings of the distance to where the body is
    /// written down.
    pub allowed: f64,
    /// The cosine of incidence there. Beside an edge the kernel may rightly name the neighbouring face.
    pub cosine: f64,
}

/// Where a ray from inside leaves a sphere, box or cylinder of size `r` around `c`; `None` for other bodies.
pub fn exit(name: &str, lab: &Numbers, (c, r): (DVec3, f64), o: DVec3, d: DVec3) -> Option<Exit> {
    let (f, way) = (Wide3::of(o) - Wide3::of(c), Wide3::of(d));
    let reach = |t: f64| lab.u * f.value().length().max(t * d.length());
    let exit = |t: f64, allowed: f64, normal: DVec3| Exit {
        t,
        allowed,
        cosine: (normal.normalize().dot(d) / d.length()).abs(),
    };
    match name {
        "sphere" => {
            let r = Wide::of(lab.round(r));
            let t = last(way.dot(way), f.dot(way), f.dot(f) - r * r)?.value();
            Some(exit(t, 6.0 * reach(t), f.value() + d * t))
        }
        "box" => {
            let half = DVec3::new(1.0, 0.7, 0.4);
            let wall = |i: usize| {
                let wall = if d[i] > 0.0 { lab.round(c[i] + half[i] * r) } else { lab.round(c[i] - half[i] * r) };
                ((Wide::of(wall) - Wide::of(o[i])) / Wide::of(d[i])).value()
            };
            let walls = (0..3).filter(|i| d[*i] != 0.0).map(|i| (wall(i), DVec3::AXES[i]));
            let (t, normal) = walls.min_by(|a, b| a.0.total_cmp(&b.0))?;
            Some(exit(t, 8.0 * reach(t), normal))
        }
        "cylinder" => {
            // As the file has it: a base, whose rounding to the format moves the whole body, and an axis.
            let (half, radius) = (DVec3::new(0.5, 0.6, 0.2) * r, Wide::of(lab.round(0.7 * r)));
            let (base, a) = (c - half, (c + half) - (c - half));
            let (f, axis) = (Wide3::of(o) - Wide3::of(lab.round3(base)), Wide3::of(a));
            let (aa, fa, da) = (axis.dot(axis), f.dot(axis), way.dot(axis));
            // Squares of the distances from the axis, times |a|^2.
            let side = last(
                way.dot(way) * aa - da * da,
                f.dot(way) * aa - fa * da,
                (f.dot(f) - radius * radius) * aa - fa * fa,
            );
            let cap = if da.value() > 0.0 { aa } else { Wide::of(0.0) };
            let cap = ((cap - fa) / da).value();
            let side = side.map_or(f64::INFINITY, Wide::value);
            let (t, p) = (side.min(cap), f.value() + d * side.min(cap));
            let normal = if side < cap { p - a * (p.dot(a) / a.length_squared()) } else { a };
            // Both ends of the way are computed from the base.
            let ends = f.value().length().max(p.length());
            Some(exit(t, 8.0 * lab.u * ends.max(t * d.length()), normal))
        }
        _ => None,
    }
}

/// How far a point is outside a torus of size `r` around `c`; below 0 inside.
pub fn outside_torus(c: DVec3, r: f64, p: DVec3) -> f64 {
    let q = p - c;
    let height = q.dot(AXIS.normalize());
    let across = (q - AXIS.normalize() * height).length();
    hypot(across - 0.7 * r, height) - 0.25 * r
}

/// Whether a point of the torus lies on its convex hull, which no ray away from it can meet again.
pub fn outer(normal: DVec3, q: DVec3) -> bool {
    let axis = AXIS.normalize();
    let across = q - axis * q.dot(axis);
    across.dot(normal) > 0.01 * across.length()
}
