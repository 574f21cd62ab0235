//! C: cylinders, cones and discs.

use super::Case;
use super::evidence::Evidence;
use super::exact;
use super::lab::{Lab, ask, direction, finite, hit, truth};
use crate::common::Random;
use crate::common::naive;
use crate::common::wide::Wide3;
use glam::{DVec2, DVec3};
use serde_json::{Value, json};

pub const CASES: &[Case] = &[
    ("C01", along_axis),
    ("C02", far_cylinder),
    ("C03", rim),
    ("C04", along_generator),
    ("C05", apex),
    ("C06", disc_rim),
];

fn cylinder(low: f64, high: f64, radius: f64) -> Value {
    json!([{ "cylinder": { "base": [0, 0, low], "top": [0, 0, high], "radius": radius } }])
}

/// The nearer root of the naive quadratic of a cylinder about z.
fn naive_side(lab: &Lab, o: DVec3, d: DVec3, radius: f64) -> f64 {
    let flat = |v: DVec3| DVec3::new(v.x, v.y, 0.0);
    naive::sphere_roots(lab, flat(o), flat(d), DVec3::ZERO, radius)[0]
}

fn along_axis(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "cylinder_parallel_axis", &[]);
    for k in 1..=80 {
        // From inside to the side, which is at x = 1: t = 2^k / 2.
        let scene = lab.scene(cylinder(-1e15, 1e15, 1.0), json!({}));
        let (o, d) = (DVec3::new(0.5, 0.0, 0.0), DVec3::new(2f64.powi(-k), 0.0, 1.0));
        let t = 2f64.powi(k - 1);
        let found = hit(&scene, o, d);
        if t < 1e15 {
            let off = found.map_or(f64::INFINITY, |h| (h.t / t - 1.0).abs());
            e.check(off <= 16.0 * lab.u, || format!("slope 2^-{k}: off by {off:e}"));
        }
        // Seen along the axis from a slope that makes a = d.x^2 vanish.
        let twin = naive_side(lab, o, DVec3::new(2f64.powi(-k * lab.pick(2, 14)), 0.0, 1.0), 1.0);
        e.twin(!twin.is_finite());
    }
    e
}

fn far_cylinder(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(8.0, "u D / cos");
    let scene = lab.scene(cylinder(-1e7, 1e7, 1.0), json!({}));
    let mut random = Random::new(22);
    for away in [1e2, 1e3, 1e4, 1e5, 1e6] {
        for _ in 0..1000 {
            let angle = random.between(0.0, 6.2);
            let (sin, cos) = strahl::math::sin_cos(angle);
            let o = lab.round3(DVec3::new(away * cos, away * sin, random.between(-1.0, 1.0) * away));
            let d = lab.round3(DVec3::from_array(random.point(1.2)) - o);
            let flat = |v: DVec3| Wide3::of(v.with_z(0.0));
            let line = exact::sphere(flat(o), flat(d), 1.0);
            let Some(t) = line.first else { continue };
            if line.beside > -16.0 * lab.u * away {
                continue;
            }
            let p = o + d * t;
            let cosine = (DVec2::new(p.x, p.y).normalize().dot(DVec2::new(d.x, d.y)) / d.length()).abs();
            let unit = lab.u * o.length() / cosine;
            let found = hit(&scene, o, d);
            e.measure(found.map_or(f64::INFINITY, |h| (h.t - t).abs() * d.length() / unit));
            e.twin_measure((naive_side(lab, o, d, 1.0) - t).abs() * d.length() / unit);
        }
    }
    e
}

fn rim(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays at rims");
    let (radius, high) = (lab.round(1.7), lab.round(2.3));
    let scene = lab.scene(cylinder(0.0, high, radius), json!({}));
    let mut random = Random::new(23);
    for _ in 0..4000 {
        let (sin, cos) = strahl::math::sin_cos(random.between(0.0, 6.2));
        let out = DVec3::new(cos, sin, 0.0);
        let aim = lab.round3(out * radius + DVec3::Z * high);
        let way = out * random.between(0.2, 2.0) + DVec3::Z * random.between(0.2, 2.0);
        let o = lab.round3(aim + way * 3.0);
        let d = lab.round3(aim - o);
        e.check(hit(&scene, o, d).is_some_and(|h| finite(&h)), || format!("the rim is missed from {o} along {d}"));
        let side = naive_side(lab, o, d, radius);
        let side_z = naive::point(lab, o, d, side).z;
        let top = naive::plane(lab, o, d, DVec3::Z * high, DVec3::Z);
        let p = naive::point(lab, o, d, top);
        let r = lab.round(lab.round(p.x * p.x) + lab.round(p.y * p.y));
        e.twin(!(side_z < high) && !(r < lab.round(radius * radius)));
    }
    e
}

fn cone() -> Value {
    json!([{ "cone": { "base": [0, 0, 0], "base_radius": 1, "top": [0, 1, 0] } }])
}

fn along_generator(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(8.0, "u of the way");
    let scene = lab.scene(cone(), json!({}));
    // On the cone x^2 + z^2 = (1-y)^2 a ray along (1, -1, 0) has one root.
    for (o, d, t) in [
        ([-1.0, 1.25, 0.0], [1.0, -1.0, 0.0], 0.625),
        ([-1.0, 1.25, 0.0], [0.25, -0.25, 0.0], 2.5),
        ([1.0, 1.25, 0.0], [-1.0, -1.0, 0.0], 0.625),
        ([0.0, 1.25, -1.0], [0.0, -1.0, 1.0], 0.625),
        ([-0.875, 1.375, 0.0], [0.6, -1.0, 0.8], f64::NAN),
    ] {
        let (o, d) = (DVec3::from_array(o), lab.round3(DVec3::from_array(d)));
        let found = hit(&scene, o, d);
        e.check(found.as_ref().is_none_or(finite), || format!("{found:?}"));
        if t.is_finite() {
            e.measure(found.map_or(f64::INFINITY, |h| (h.t / t - 1.0).abs() / lab.u));
            let a = lab.round(d.x * d.x + d.z * d.z - d.y * d.y);
            let root = lab.round(1.0 / (2.0 * a));
            e.twin(!root.is_finite());
        }
    }
    // Almost parallel: the second root is far away, the first must not notice.
    for k in 4..lab.pick(22, 50) {
        let lean = 2f64.powi(-k);
        let (o, d) = (DVec3::new(-1.0, 1.25, 0.0), DVec3::new(1.0 + lean, -1.0, 0.0));
        let x = |t: f64| -1.0 + t * d.x;
        let found = hit(&scene, o, d);
        // The side x = -(1-y), met first: -1 + t d.x = -(1 - 1.25 + t) gives t = 1.25 / (2 + lean).
        let t = 1.25 / (2.0 + lean);
        e.check(x(t) < 0.0, || "the wrong side".to_owned());
        e.measure(found.map_or(f64::INFINITY, |h| (h.t / t - 1.0).abs() / lab.u));
    }
    e
}

fn apex(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays at the apex and over it");
    let scene = lab.scene(cone(), json!({}));
    let mut random = Random::new(24);
    for _ in 0..2000 {
        let o = lab.round3(DVec3::Y + direction(&mut random) * 3.0);
        let found = hit(&scene, o, lab.round3(DVec3::Y - o));
        e.check(found.as_ref().is_none_or(finite), || format!("{found:?}"));
        // Through the mirror image of the cone only.
        let aim = DVec3::new(random.between(-0.3, 0.3), 1.8, random.between(-0.3, 0.3));
        let d = DVec3::new(random.between(-1.0, 1.0), random.between(-0.05, 0.3), 1.0);
        let o = lab.round3(aim - d * 5.0);
        let d = lab.round3(aim - o);
        if (1..200).all(|i| (o + d * (f64::from(i) * 0.05)).y > 1.01) {
            e.check(hit(&scene, o, d).is_none(), || format!("the mirrored cone is met from {o}"));
            let f = o - DVec3::Y;
            let (a, b, c) = (
                d.x * d.x + d.z * d.z - d.y * d.y,
                d.x * f.x + d.z * f.z - d.y * f.y,
                f.x * f.x + f.z * f.z - f.y * f.y,
            );
            e.twin(b * b - a * c > 0.0);
        }
    }
    e
}

fn disc_rim(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "disc_rim", &[]);
    for (x, z, radius) in [(3.0, 4.0, 5.0), (5.0, 12.0, 13.0), (8.0, 15.0, 17.0), (0.0, 1.0, 1.0)] {
        let disc = json!([{ "disc": { "center": [0, 0, 0], "normal": [0, 1, 0], "radius": radius } }]);
        let (o, center) = (DVec3::new(x, 1.0, z), DVec3::ZERO);
        e.check(hit(&lab.scene(disc, json!({})), o, -DVec3::Y).is_some(), || {
            format!("the rim of radius {radius} is missed")
        });
        let p = naive::point(lab, o, -DVec3::Y, naive::plane(lab, o, -DVec3::Y, center, DVec3::Y));
        e.twin(!(lab.round(p.length()) < radius));
    }
    e
}
