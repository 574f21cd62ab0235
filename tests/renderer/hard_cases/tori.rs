//! C: tori.

use super::Case;
use super::evidence::Evidence;
use super::lab::{Lab, ask, from_front, hit, hit_within, square, truth};
use crate::common::Random;
use crate::common::naive;
use glam::DVec3;
use serde_json::{Value, json};
use strahl::math::hypot;
use strahl::scene::Scene;

pub const CASES: &[Case] = &[("C07", far_torus), ("C08", double_roots), ("C09", thin_and_fat), ("C10", torus_again)];

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
            if hypot(at(i as u32 % edge), at(i as u32 / edge)) > 1.01 {
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
