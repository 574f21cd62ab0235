//! Naive planes, boxes, discs, cylinders, cones and tori.

use super::{lane, narrow, plane, point, wide};
use crate::common::numbers::Numbers;
use glam::DVec3;
use strahl::lanes::{Lanes, Mask};

/// A plane with the usual guard: a cosine below `least` counts as parallel.
pub fn guarded_plane(lab: &Numbers, o: DVec3, d: DVec3, at: DVec3, normal: DVec3, least: f64) -> Option<f64> {
    let t = plane(lab, o, d, at, normal);
    let parallel = lab.round(normal.dot(d)).abs() < least;
    (!parallel && t > 0.0).then_some(t)
}

/// A box by slabs: the nearer face beyond `epsilon`, or the farther. A box must have room between its faces.
pub fn cuboid(lab: &Numbers, o: DVec3, d: DVec3, low: DVec3, high: DVec3, epsilon: f64) -> Option<f64> {
    fn meet<L: Lanes<Simd = ()>>(o: DVec3, d: DVec3, low: DVec3, high: DVec3) -> [f64; 2] {
        let (mut near, mut far) = (lane::<L>(f64::NEG_INFINITY), lane::<L>(f64::INFINITY));
        for i in 0..3 {
            let inverse = lane::<L>(1.0) / lane::<L>(d[i]);
            let [t0, t1] = [low[i], high[i]].map(|b| (lane::<L>(b) - lane::<L>(o[i])) * inverse);
            let (t0, t1) = if t0.gt(t1).any() { (t1, t0) } else { (t0, t1) };
            near = L::select(t0.gt(near), t0, near);
            far = L::select(t1.lt(far), t1, far);
        }
        [wide(near), wide(far)]
    }
    let [near, far] = run!(lab, meet(o, d, low, high));
    if near < far { [near, far].into_iter().find(|t| *t > epsilon) } else { None }
}

/// A disc: the plane, and a distance from the centre below the radius.
pub fn disc(lab: &Numbers, o: DVec3, d: DVec3, center: DVec3, normal: DVec3, radius: f64) -> Option<f64> {
    let t = plane(lab, o, d, center, normal);
    let within = lab.round((point(lab, o, d, t) - center).length()) < radius;
    (t > 0.0 && within).then_some(t)
}

/// A cylinder or a frustum of a cone: both roots of b^2 - 4ac for the side, and a disc for each end if it is closed.
/// The ends are `(centre, radius)`.
pub fn frustum(lab: &Numbers, o: DVec3, d: DVec3, ends: [(DVec3, f64); 2], closed: bool, epsilon: f64) -> Option<f64> {
    fn side<L: Lanes<Simd = ()>>(o: DVec3, d: DVec3, [(base, r0), (top, r1)]: [(DVec3, f64); 2]) -> [[f64; 2]; 2] {
        let axis = narrow::<L>(top) - narrow::<L>(base);
        let height = axis.dot(axis).sqrt();
        let axis = axis * (lane::<L>(1.0) / height);
        let (f, d, two) = (narrow::<L>(o) - narrow::<L>(base), narrow::<L>(d), lane::<L>(2.0));
        let (fh, dh) = (f.dot(axis), d.dot(axis));
        let (fp, dp) = (f - axis * fh, d - axis * dh);
        let k = (lane::<L>(r1) - lane::<L>(r0)) / height;
        let r = lane::<L>(r0) + k * fh;
        let a = dp.dot(dp) - k * k * dh * dh;
        let b = two * (fp.dot(dp) - r * k * dh);
        let c = fp.dot(fp) - r * r;
        let root = (b * b - lane::<L>(4.0) * a * c).sqrt();
        [(-b - root) / (two * a), (-b + root) / (two * a)].map(|t| [wide(t), wide((fh + t * dh) / height)])
    }
    let roots = run!(lab, side(o, d, ends));
    let mut found: Vec<f64> = roots.into_iter().filter(|[_, h]| (0.0..=1.0).contains(h)).map(|[t, _]| t).collect();
    if closed {
        let axis = lab.round3((ends[1].0 - ends[0].0).normalize());
        found.extend(ends.iter().filter_map(|(center, radius)| disc(lab, o, d, *center, axis, *radius)));
    }
    found.into_iter().filter(|t| *t > epsilon).min_by(f64::total_cmp)
}

/// Coefficients of the expanded quartic of a torus about y, that of t^0 first.
fn quartic<L: Lanes<Simd = ()>>(o: DVec3, d: DVec3, major: f64, minor: f64) -> [L; 5] {
    let (o, d) = (narrow::<L>(o), narrow::<L>(d));
    let (big, small, two, four) = (lane::<L>(major), lane::<L>(minor), lane::<L>(2.0), lane::<L>(4.0));
    let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - small * small - big * big);
    [
        c * c - four * big * big * (small * small - o.y * o.y),
        four * b * c + two * four * big * big * o.y * d.y,
        two * a * c + four * b * b + four * big * big * d.y * d.y,
        four * a * b,
        a * a,
    ]
}

/// Value of the expanded quartic of a torus about y at t.
pub fn torus(lab: &Numbers, o: DVec3, d: DVec3, major: f64, minor: f64, t: f64) -> f64 {
    fn value<L: Lanes<Simd = ()>>(o: DVec3, d: DVec3, major: f64, minor: f64, t: f64) -> f64 {
        let t = lane::<L>(t);
        let [c0, c1, c2, c3, c4] = quartic::<L>(o, d, major, minor);
        wide((((c4 * t + c3) * t + c2) * t + c1) * t + c0)
    }
    run!(lab, value(o, d, major, minor, t))
}

/// Roots of the expanded quartic of a torus about y up to `reach`: changes of sign between those of the derivative,
/// halved until they are known to an absolute tolerance.
pub fn torus_roots(
    lab: &Numbers,
    o: DVec3,
    d: DVec3,
    (major, minor): (f64, f64),
    reach: f64,
    tolerance: f64,
) -> Vec<f64> {
    fn coefficients<L: Lanes<Simd = ()>>(o: DVec3, d: DVec3, major: f64, minor: f64) -> [f64; 5] {
        quartic::<L>(o, d, major, minor).map(wide)
    }
    roots(lab, &run!(lab, coefficients(o, d, major, minor)), reach, tolerance)
}

fn roots(lab: &Numbers, polynomial: &[f64], reach: f64, tolerance: f64) -> Vec<f64> {
    if polynomial.len() < 2 {
        return Vec::new();
    }
    let value = |t: f64| polynomial.iter().rev().fold(0.0, |sum, c| lab.round(lab.round(sum * t) + c));
    let derivative: Vec<f64> =
        polynomial.iter().enumerate().skip(1).map(|(i, c)| lab.round(lab.round(i as f64) * c)).collect();
    let mut borders = vec![0.0];
    borders.extend(roots(lab, &derivative, reach, tolerance));
    borders.push(reach);
    let mut found = Vec::new();
    for pair in borders.windows(2) {
        let (mut low, mut high) = (pair[0], pair[1]);
        let rising = value(low) < value(high);
        if !(value(low) * value(high) < 0.0) {
            continue;
        }
        for _ in 0..200 {
            let middle = lab.round(0.5 * (low + high));
            if high - low < tolerance || middle <= low || middle >= high {
                break;
            }
            if (value(middle) < 0.0) == rising {
                low = middle;
            } else {
                high = middle;
            }
        }
        found.push(lab.round(0.5 * (low + high)));
    }
    found
}
