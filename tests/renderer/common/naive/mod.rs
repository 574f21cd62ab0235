//! What textbooks do, in the format of the case, to be run beside strahl. Nothing else may use it.

use crate::common::numbers::Numbers;
use glam::DVec3;
use strahl::lanes::{Lanes, Mask, Real, V3};

pub use bodies::{cuboid, disc, frustum, guarded_plane, torus, torus_roots};

/// Runs a function over one lane in the lab's format.
macro_rules! run {
    ($lab:expr, $function:ident($($argument:expr),*)) => {
        if $lab.is_double() { $function::<f64>($($argument),*) } else { $function::<f32>($($argument),*) }
    };
}

mod bodies;

fn lane<L: Lanes<Simd = ()>>(x: f64) -> L {
    L::lit((), x)
}

fn narrow<L: Lanes<Simd = ()>>(v: DVec3) -> V3<L> {
    V3 { x: lane(v.x), y: lane(v.y), z: lane(v.z) }
}

fn wide<L: Lanes<Simd = ()>>(x: L) -> f64 {
    x.lane(0).to_f64()
}

fn wide3<L: Lanes<Simd = ()>>(v: V3<L>) -> DVec3 {
    DVec3::new(wide(v.x), wide(v.y), wide(v.z))
}

/// Both roots of b^2 - 4ac with c = f.f - r^2; NaN where the root is negative, which nobody looks at.
pub fn sphere_roots(lab: &Numbers, o: DVec3, d: DVec3, center: DVec3, radius: f64) -> [f64; 2] {
    fn roots<L: Lanes<Simd = ()>>(o: DVec3, d: DVec3, center: DVec3, radius: f64) -> [f64; 2] {
        let (d, r) = (narrow::<L>(d), lane::<L>(radius));
        let f = narrow::<L>(o) - narrow::<L>(center);
        let (a, b, c) = (d.dot(d), lane::<L>(2.0) * f.dot(d), f.dot(f) - r * r);
        let root = (b * b - lane::<L>(4.0) * a * c).sqrt();
        let twice = lane::<L>(2.0) * a;
        [wide((-b - root) / twice), wide((-b + root) / twice)]
    }
    run!(lab, roots(o, d, center, radius))
}

/// The first root beyond `epsilon`.
pub fn sphere(lab: &Numbers, o: DVec3, d: DVec3, center: DVec3, radius: f64, epsilon: f64) -> Option<f64> {
    sphere_roots(lab, o, d, center, radius).into_iter().find(|t| *t > epsilon)
}

/// Like [`sphere`], with c = o.o - 2 o.c + c.c - r^2.
pub fn sphere_expanded(lab: &Numbers, o: DVec3, d: DVec3, center: DVec3, radius: f64) -> f64 {
    fn root<L: Lanes<Simd = ()>>(o: DVec3, d: DVec3, center: DVec3, radius: f64) -> f64 {
        let (o, d, m, r, two) =
            (narrow::<L>(o), narrow::<L>(d), narrow::<L>(center), lane::<L>(radius), lane::<L>(2.0));
        let a = d.dot(d);
        let b = two * (o.dot(d) - m.dot(d));
        let c = o.dot(o) - two * o.dot(m) + m.dot(m) - r * r;
        wide((-b - (b * b - lane::<L>(4.0) * a * c).sqrt()) / (two * a))
    }
    run!(lab, root(o, d, center, radius))
}

/// (n.p - n.o) / n.d, whatever comes out.
pub fn plane(lab: &Numbers, o: DVec3, d: DVec3, point: DVec3, normal: DVec3) -> f64 {
    fn meet<L: Lanes<Simd = ()>>(o: DVec3, d: DVec3, point: DVec3, normal: DVec3) -> f64 {
        let n = narrow::<L>(normal);
        wide((n.dot(narrow(point)) - n.dot(narrow(o))) / n.dot(narrow(d)))
    }
    run!(lab, meet(o, d, point, normal))
}

/// Moeller and Trumbore's t, u and v with bounds that let NaN through; nothing below `least` counts as a determinant.
pub fn triangle(lab: &Numbers, o: DVec3, d: DVec3, corners: [DVec3; 3], least: f64) -> Option<[f64; 3]> {
    fn meet<L: Lanes<Simd = ()>>(o: DVec3, d: DVec3, corners: [DVec3; 3], least: f64) -> Option<[f64; 3]> {
        let [a, b, c] = corners.map(narrow::<L>);
        let d = narrow::<L>(d);
        let (e1, e2) = (b - a, c - a);
        let p = d.cross(e2);
        let det = e1.dot(p);
        if det.abs().lt(lane(least)).any() {
            return None;
        }
        let inverse = lane::<L>(1.0) / det;
        let s = narrow::<L>(o) - a;
        let u = s.dot(p) * inverse;
        let q = s.cross(e1);
        let v = d.dot(q) * inverse;
        let (zero, one) = (lane::<L>(0.0), lane::<L>(1.0));
        if (u.lt(zero) | u.gt(one) | v.lt(zero) | (u + v).gt(one)).any() {
            return None;
        }
        Some([wide(e2.dot(q) * inverse), wide(u), wide(v)])
    }
    run!(lab, meet(o, d, corners, least))
}

/// Woop's test; `contract` fuses each difference of products into one operation, as some compilers do.
pub fn woop(lab: &Numbers, o: DVec3, d: DVec3, corners: [DVec3; 3], contract: bool) -> bool {
    woop_along(lab, o, d, corners, contract, d.abs().max_position())
}

/// Woop's test with a given major axis.
pub fn woop_along(lab: &Numbers, o: DVec3, d: DVec3, corners: [DVec3; 3], contract: bool, k: usize) -> bool {
    let fused = |a: f64, b: f64, c: f64| {
        if lab.is_double() { a.mul_add(b, c) } else { f64::from((a as f32).mul_add(b as f32, c as f32)) }
    };
    let round = |x: f64| lab.round(x);
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    let (sx, sy) = (round(d[i] / d[k]), round(d[j] / d[k]));
    let [a, b, c] = corners.map(|v| {
        let at = [round(v[i] - o[i]), round(v[j] - o[j]), round(v[k] - o[k])];
        [round(at[0] - round(sx * at[2])), round(at[1] - round(sy * at[2]))]
    });
    let area = |p: [f64; 2], q: [f64; 2]| {
        let product = round(p[1] * q[0]);
        if contract { fused(p[0], q[1], -product) } else { round(p[0] * q[1]) - product }
    };
    let (u, v, w) = (area(c, b), area(a, c), area(b, a));
    (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0)
}

/// The slab test with ifs, and the quotient multiplied out: b/d - o/d if `split`.
pub fn slab(lab: &Numbers, o: DVec3, d: DVec3, low: DVec3, high: DVec3, split: bool) -> bool {
    fn meet<L: Lanes<Simd = ()>>(o: DVec3, d: DVec3, low: DVec3, high: DVec3, split: bool) -> bool {
        let (mut near, mut far) = (lane::<L>(0.0), lane::<L>(f64::INFINITY));
        for i in 0..3 {
            let inverse = lane::<L>(1.0) / lane::<L>(d[i]);
            let at = |b: f64| {
                if split {
                    lane::<L>(b) * inverse - lane::<L>(o[i]) * inverse
                } else {
                    (lane::<L>(b) - lane::<L>(o[i])) * inverse
                }
            };
            let (mut t0, mut t1) = (at(low[i]), at(high[i]));
            if t0.gt(t1).any() {
                std::mem::swap(&mut t0, &mut t1);
            }
            near = L::select(t0.gt(near), t0, near);
            far = L::select(t1.lt(far), t1, far);
            // Also false for NaN.
            if !near.le(far).any() {
                return false;
            }
        }
        true
    }
    run!(lab, meet(o, d, low, high, split))
}

/// Snell's law from cosines: eta d + (eta c1 - sqrt(1 - eta^2 (1 - c1^2))) n; NaN where the root is negative.
pub fn refract(lab: &Numbers, d: DVec3, n: DVec3, eta: f64) -> DVec3 {
    fn bend<L: Lanes<Simd = ()>>(d: DVec3, n: DVec3, eta: f64) -> DVec3 {
        let (d, n, eta, one) = (narrow::<L>(d).normalized(()), narrow::<L>(n), lane::<L>(eta), lane::<L>(1.0));
        let c1 = -n.dot(d);
        let c2 = (one - eta * eta * (one - c1 * c1)).sqrt();
        wide3(d * eta + n * (eta * c1 - c2))
    }
    run!(lab, bend(d, n, eta))
}

/// Fresnel's reflectance for unpolarised light, from cosines.
pub fn reflectance(lab: &Numbers, d: DVec3, n: DVec3, eta: f64) -> f64 {
    fn share<L: Lanes<Simd = ()>>(d: DVec3, n: DVec3, eta: f64) -> f64 {
        let (d, n, eta, one) = (narrow::<L>(d).normalized(()), narrow::<L>(n), lane::<L>(eta), lane::<L>(1.0));
        let c1 = -n.dot(d);
        let c2 = (one - eta * eta * (one - c1 * c1)).sqrt();
        let (s, p) = ((eta * c1 - c2) / (eta * c1 + c2), (c1 - eta * c2) / (c1 + eta * c2));
        wide((s * s + p * p) * lane(0.5))
    }
    run!(lab, share(d, n, eta))
}

/// Beer's law: exp(-absorption * way).
pub fn transmittance(lab: &Numbers, absorption: f64, way: f64) -> f64 {
    lab.round(strahl::math::pow(std::f64::consts::E, lab.round(-absorption * way)))
}

/// v / |v|.
pub fn normalize(lab: &Numbers, v: DVec3) -> DVec3 {
    fn unit<L: Lanes<Simd = ()>>(v: DVec3) -> DVec3 {
        wide3(narrow::<L>(v).normalized(()))
    }
    run!(lab, unit(v))
}

/// The sum of a point and a way in the format.
pub fn add(lab: &Numbers, a: DVec3, b: DVec3) -> DVec3 {
    lab.round3(a + b)
}

/// o + t d in the format.
pub fn point(lab: &Numbers, o: DVec3, d: DVec3, t: f64) -> DVec3 {
    fn at<L: Lanes<Simd = ()>>(o: DVec3, d: DVec3, t: f64) -> DVec3 {
        wide3(narrow::<L>(o) + narrow::<L>(d) * lane::<L>(t))
    }
    run!(lab, at(o, d, t))
}
