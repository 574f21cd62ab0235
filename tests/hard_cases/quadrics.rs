//! C: cylinders, cones, discs and tori.

use crate::Case;
use crate::common::Random;
use crate::common::wide::Wide3;
use crate::evidence::Evidence;
use crate::exact;
use crate::lab::{Lab, ask, direction, finite, from_front, hit, hit_within, square, truth};
use crate::naive;
use glam::{DVec2, DVec3};
use serde_json::{Value, json};
use strahl::scene::Scene;

pub const CASES: &[Case] = &[
    ("C01", along_axis),
    ("C02", far_cylinder),
    ("C03", rim),
    ("C04", along_generator),
    ("C05", apex),
    ("C06", disc_rim),
    ("C07", far_torus),
    ("C08", double_roots),
    ("C09", thin_and_fat),
    ("C10", torus_again),
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

fn torus(major: f64, minor: f64, material: &str) -> Value {
    json!([{ "torus": { "center": [0, 0, 0], "major_radius": major, "minor_radius": minor, "material": material } }])
}

/// Whether the expanded quartic fails to change sign about a root.
fn lost_root(lab: &Lab, o: DVec3, d: DVec3, (major, minor): (f64, f64), t: f64, about: f64) -> bool {
    let value = |t: f64| naive::torus(lab, o, d, major, minor, t);
    !(value(t - about) * value(t + about) < 0.0)
}

fn far_torus(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "torus_quartic", &[]);
    let scene = lab.scene(torus(1.0, 0.25, "red"), json!({}));
    for away in [1e1, 1e2, 1e3, 1e4, 1e5] {
        // Straight down onto the top at (1, 0.25, 0), and onto the hole.
        let o = DVec3::new(1.0, away, 0.0);
        let found = hit(&scene, o, -DVec3::Y);
        let off = found.map_or(f64::INFINITY, |h| (h.t - (away - 0.25)).abs());
        e.check(off <= 16.0 * lab.u * away, || format!("from {away}: off by {off:e}"));
        e.check(hit(&scene, DVec3::Y * away, -DVec3::Y).is_none(), || format!("from {away}: no hole"));
        for i in 1..40 {
            // Down onto the outer half, where the surface is at y = sqrt(r^2 - (x-R)^2).
            let (x, away) = (lab.round(1.0 + f64::from(i) * 0.0031), lab.round(away * 1.0371));
            let t = away - (0.0625 - (x - 1.0) * (x - 1.0)).sqrt();
            e.twin(lost_root(lab, DVec3::new(x, away, 0.0), -DVec3::Y, (1.0, 0.25), t, 16.0 * lab.u * away));
        }
    }
    e
}

/// All crossings of a line.
fn crossings(scene: &Scene, o: DVec3, d: DVec3) -> Vec<f64> {
    let mut ts = Vec::new();
    while let Some(found) = hit_within(scene, o, d, ts.last().copied().unwrap_or(0.0), None) {
        ts.push(found.t);
        if ts.len() > 9 {
            break;
        }
    }
    ts
}

fn double_roots(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(16.0, "u S / cos");
    let (major, minor) = (1.0, 0.25);
    let scene = lab.scene(torus(major, minor, "red"), json!({}));
    for k in 2..lab.pick(18, 44) {
        let height = minor * (1.0 - 2f64.powi(-k));
        let half = (minor * minor - height * height).sqrt();
        let o = DVec3::new(-5.0, height, 0.0);
        let expected = [-major - half, -major + half, major - half, major + half].map(|x| x + 5.0);
        let found = crossings(&scene, o, DVec3::X);
        e.check(found.len() == 4, || format!("2^-{k} below the top: {found:?} instead of {expected:?}"));
        for (found, expected) in found.iter().zip(expected) {
            e.measure((found - expected).abs() / (lab.u * 5.0 * minor / half));
        }
        let above = DVec3::new(-5.0, minor * (1.0 + 2f64.powi(-k)), 0.0);
        e.check(hit(&scene, above, DVec3::X).is_none(), || format!("2^-{k} above the top"));
        let about = 64.0 * lab.u * 5.0 * minor / half;
        e.twin(about < half && lost_root(lab, o, DVec3::X, (major, minor), expected[0], about));
    }
    let tangent = crossings(&scene, DVec3::new(-5.0, minor, 0.0), DVec3::X);
    e.check(tangent.len().is_multiple_of(2) && tangent.len() <= 4, || format!("tangent: {tangent:?}"));
    e
}

fn thin_and_fat(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(16.0, "u of the way");
    for minor in [1e-5, 1e-3, 0.25, 0.99, 0.999] {
        let minor = lab.round(minor);
        if minor < 64.0 * lab.u * 2.0 {
            continue;
        }
        let scene = lab.scene(torus(1.0, minor, "red"), json!({}));
        let o = DVec3::new(-2.0, 0.0, 0.0);
        let expected = [1.0 - minor, 1.0 + minor, 3.0 - minor, 3.0 + minor];
        let found = crossings(&scene, o, DVec3::X);
        e.check(found.len() == 4, || format!("r = {minor}: {found:?} instead of {expected:?}"));
        for (found, expected) in found.iter().zip(expected) {
            e.measure((found - expected).abs() / (lab.u * 2.0));
        }
        // Roots to an absolute tolerance of 1e-4.
        let twin = naive::torus_roots(lab, o, DVec3::X, (1.0, minor), 8.0, 1e-4);
        e.twin(twin.len() != 4);
        for (found, expected) in twin.iter().zip(expected) {
            e.twin_measure((found - expected).abs() / (lab.u * 2.0));
        }
    }
    e
}

fn torus_again(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pixels and crossings");
    for scale in [1e-6, 1.0, 1e6] {
        let (major, minor) = (lab.round(scale), lab.round(0.3 * scale));
        let stand = |material: &str| json!([{ "torus": { "center": [0, 0, 0], "axis": [0, 0, 1], "major_radius": major, "minor_radius": minor, "material": material } }]);
        let edge = 60;
        let view = |depth: u32| json!({ "camera": from_front([0.0; 3], 3.0 * scale, 2.6 * scale), "image": square(edge), "background": 1, "render": { "max_depth": depth } });
        let film = lab.picture(stand("mirror"), view(2)).film;
        for (i, pixel) in film.pixels.iter().enumerate() {
            let at = |k: u32| ((f64::from(k) + 0.5) / f64::from(edge) - 0.5) * 2.6;
            // Off the outer half light goes straight to the sky.
            if at(i as u32 % edge).hypot(at(i as u32 / edge)) > 1.01 {
                e.check(*pixel == [1.0; 3], || format!("a pixel is {pixel:?} at scale {scale}"));
            }
        }
        let rays = lab.picture(stand("nothing"), view(5)).rays;
        e.check(rays.transmitted == 2 * rays.camera_hits && rays.camera_hits > 0, || format!("{scale}: {rays:?}"));
        // The root of the surface a ray starts on, by one Newton step on the expanded quartic, beyond 1e-4 or not.
        let mut random = Random::new(25);
        for _ in 0..200 {
            let (sin, cos) = strahl::math::sin_cos(random.between(0.0, 6.2));
            let p = lab.round3(DVec3::new(cos, 0.0, sin) * lab.pick(1e3, 1e12) * 1.3);
            let d = DVec3::new(cos, 1.0, sin).normalize();
            let size = lab.pick(1e3, 1e12);
            let value = |t: f64| naive::torus(lab, p, d, size, 0.3 * size, t);
            let slope = (value(size * 1e-3) - value(0.0)) / (size * 1e-3);
            e.twin((value(0.0) / slope).abs() > 1e-4);
        }
    }
    e
}
