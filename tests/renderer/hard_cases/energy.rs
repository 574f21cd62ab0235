//! E: energy and recursion.

use super::Case;
use super::evidence::Evidence;
use super::lab::{Lab, ask, ball, description, from_front, picture, rows, square, truth, vector};
use super::textbook::{Object, Shape, Tracer};
use crate::common::naive;
use crate::common::on_own_threads;
use glam::DVec3;
use serde_json::{Value, json};
use std::time::Instant;
use strahl::scene::limits::RAYS_PER_SAMPLE;

pub const CASES: &[Case] = &[("E01", growth), ("E02", corridor), ("E03", tree)];

/// Balls of glass that also mirror, before a bright sky.
fn balls(reflection: f64, transmission: f64, depth: u32, min_weight: f64, edge: u32) -> Value {
    let glass = json!({ "ambient": 0, "diffuse": 0, "reflection": reflection, "transmission": transmission });
    let more = json!({
        "camera": from_front([0.0; 3], 5.0, 2.0), "image": square(edge), "background": 1,
        "materials": { "both": glass }, "render": { "max_depth": depth, "min_weight": min_weight }
    });
    description(json!([ball([0.0; 3], 1.0, "both"), ball([0.0, 0.0, -2.5], 1.0, "both")]), more)
}

/// Faces of the panes: where both the mirrored and the transmitted ray meet another face, the tree of rays doubles.
fn faces() -> impl Iterator<Item = (DVec3, DVec3)> {
    (0..12).map(|i| (DVec3::new(-99.0, -99.0, -f64::from(i)), DVec3::new(99.0, 99.0, 0.5 - f64::from(i))))
}

/// Twelve panes of glass that also mirror, before a bright sky, in one pixel.
fn panes(reflection: f64, transmission: f64, depth: u32, min_weight: f64) -> Value {
    let glass = json!({ "ambient": 0, "diffuse": 0, "reflection": reflection, "transmission": transmission });
    let more = json!({
        "camera": from_front([0.0; 3], 5.0, 2.0), "image": square(1), "background": 1,
        "materials": { "both": glass }, "render": { "max_depth": depth, "min_weight": min_weight }
    });
    let pane = |(low, high): (DVec3, DVec3)| json!({ "box": { "min": low.to_array(), "max": high.to_array(), "material": "both" } });
    description(json!(faces().map(pane).collect::<Vec<_>>()), more)
}

/// How many rays the textbook's tracer follows through the panes, and the light it finds; it is stopped after as many
/// rays as strahl allows a sample.
fn naive_panes(lab: &Lab, reflection: f64, transmission: f64, depth: u32) -> (u64, f64) {
    let pane = |(low, high)| Object {
        mirror: reflection,
        clear: transmission,
        ..Object::glass(Shape::Cuboid(low, high), 1.5)
    };
    let mut tracer = Tracer::new(lab, faces().map(pane).collect());
    (tracer.background, tracer.patience) = (1.0, RAYS_PER_SAMPLE.max);
    let light = tracer.radiance(DVec3::new(0.1, 0.2, 5.0), -DVec3::Z, depth);
    (tracer.rays.get(), light)
}

fn growth(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pixels and bounds");
    for (r, t) in [(0.5, 0.5), (0.1, 0.9), (0.0, 1.0), (0.3, 0.3)] {
        for pixel in lab.load(&balls(r, t, 12, 0.0, 12)).map(|l| picture(&l.scene).film.pixels).unwrap() {
            let bound = 1.0 + 4096.0 * lab.u.max(f64::from(f32::EPSILON));
            e.check(pixel.iter().all(|c| (0.0..=bound as f32).contains(c)), || {
                format!("r_s + r_t <= 1 gives {pixel:?}")
            });
        }
    }
    for (r, t) in [(1.0, 1.0), (0.8, 0.9), (1000.0, 1000.0)] {
        let loaded = lab.load(&panes(r, t, 40, 0.0)).unwrap();
        e.check(!loaded.scene.warnings.is_empty(), || format!("no warning of {r} + {t}"));
        let picture = picture(&loaded.scene);
        let rays = picture.rays;
        let most = RAYS_PER_SAMPLE.max;
        e.check(rays.reflected + rays.transmitted <= most, || format!("{rays:?}"));
        e.check(picture.film.pixels.iter().flatten().all(|c| c.is_finite()), || "an infinite pixel".to_owned());
        let (rays, light) = naive_panes(lab, r, t, 40);
        e.twin(!light.is_finite() || rays > most);
    }
    e
}

fn corridor(lab: &Lab) -> Evidence {
    let mut e = truth();
    let lab = *lab;
    // Recursion would need some kilobytes for each of 10,000 rays.
    let asked = std::thread::Builder::new().stack_size(256 << 10).spawn(move || {
        let mut e = truth();
        ask(&lab, &mut e, "mirror_corridor", &[]);
        e
    });
    let asked = asked.unwrap().join();
    e.check(asked.as_ref().is_ok_and(Evidence::passes), || "the corridor of exact answers".to_owned());
    e.measure(asked.map_or(f64::INFINITY, |e| e.figure()));
    // An offset of a ten-thousandth at each mirror, in a loop, since recursion would end the test with its stack.
    for row in rows("mirror_corridor") {
        for (k, off) in naive_corridor(&lab, &row) {
            e.twin(off > 8.0 * k * lab.u);
        }
    }
    e
}

/// The naive way to the listed hits of a corridor: the number of each and how far off the way is, as a share of it.
pub fn naive_corridor(lab: &Lab, row: &Value) -> Vec<(f64, f64)> {
    let (mut p, mut d) = (vector(&row["ray"]["o"]), vector(&row["ray"]["d"]));
    d = naive::normalize(lab, d);
    let mirrors = [(DVec3::ZERO, DVec3::X), (DVec3::X, -DVec3::X)];
    let (mut way, mut met, mut found) = (0.0, 0.0, Vec::new());
    for expected in row["expect"]["hits"].as_array().unwrap() {
        let k = expected["k"].as_f64().unwrap();
        while met < k {
            let (at, n) = mirrors[usize::from(d.x > 0.0)];
            let t = naive::plane(lab, p, d, at, n);
            p = naive::add(lab, naive::point(lab, p, d, t), n * 1e-4);
            d = lab.round3(d - 2.0 * d.dot(n) * n);
            (way, met) = (way + t, met + 1.0);
        }
        found.push((k, (way / expected["dist_total"].as_f64().unwrap() - 1.0).abs()));
    }
    found
}

fn tree(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(2.0, "s for a tree 50 deep");
    for scene in [balls(0.5, 0.5, 50, 0.001, 8), panes(0.5, 0.5, 50, 0.001)] {
        let loaded = lab.load(&scene).unwrap();
        let (rays, seconds) = on_own_threads(|| {
            let start = Instant::now();
            (picture(&loaded.scene).rays, start.elapsed().as_secs_f64())
        });
        e.measure(seconds);
        let followed = rays.reflected + rays.transmitted;
        e.check(followed < 64 * RAYS_PER_SAMPLE.max && rays.dropped == 0, || format!("{rays:?}"));
    }
    e.twin(naive_panes(lab, 0.5, 0.5, 50).0 > RAYS_PER_SAMPLE.max);
    e
}
