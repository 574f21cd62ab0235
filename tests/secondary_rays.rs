//! Rays that leave a surface neither meet it again nor miss its far side, whatever its size and place.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail loudly and say what it measured")]

mod common;

use common::Random;
use common::meshes::Closed;
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use strahl::scene::description::Precision;
use strahl::scene::{Format, Overrides, Scene, load};
use strahl::trace::packets::{FirstHit, first_hits};
use strahl::trace::query::RayQuery;

/// Distances of the centre from the origin of coordinates, in sizes of the body.
const PLACES: [f64; 3] = [0.0, 100.0, 1e4];

/// Primitives that enclose something, but for the last three.
const PRIMITIVES: [&str; 10] =
    ["sphere", "box", "cylinder", "frustum", "torus", "mesh", "cube mesh", "disc", "triangle", "plane"];

/// A body of size about `r` around `c`.
fn object(name: &str, c: DVec3, r: f64) -> Value {
    let at = |x: f64, y: f64, z: f64| (c + DVec3::new(x, y, z) * r).to_array();
    let center = c.to_array();
    match name {
        "sphere" => json!({ "sphere": { "center": center, "radius": r, "material": "m" } }),
        "box" => json!({ "box": { "min": at(-1.0, -0.7, -0.4), "max": at(1.0, 0.7, 0.4), "material": "m" } }),
        "cylinder" => json!({ "cylinder": {
            "base": at(-0.5, -0.6, -0.2), "top": at(0.5, 0.6, 0.2), "radius": 0.7 * r, "material": "m"
        } }),
        "frustum" => json!({ "cone": {
            "base": at(-0.5, 0.6, -0.2), "base_radius": 0.9 * r,
            "top": at(0.5, -0.6, 0.2), "top_radius": 0.3 * r, "material": "m"
        } }),
        "torus" => json!({ "torus": {
            "center": center, "axis": [0.3, -0.5, 0.8], "major_radius": 0.7 * r, "minor_radius": 0.25 * r, "material": "m"
        } }),
        "mesh" => Closed::icosphere(1).placed(r, c).json("m"),
        "cube mesh" => Closed::cube().placed(r * 0.7, c).json("m"),
        "disc" => json!({ "disc": { "center": center, "normal": [0.3, 0.9, -0.4], "radius": r, "material": "m" } }),
        "triangle" => json!({ "triangle": {
            "vertices": [at(-0.8, -0.5, 0.1), at(0.9, -0.3, -0.4), at(0.1, 0.8, 0.5)], "material": "m"
        } }),
        _ => json!({ "plane": { "point": center, "normal": [0.3, 0.9, -0.4], "material": "m" } }),
    }
}

fn scene_of(object: &Value, precision: Precision) -> Scene {
    let text = json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "pinhole": { "eye": [0, 0, 0], "look_at": [0, 0, -1] } },
        "lights": [],
        "materials": { "m": { "diffuse": 0.5, "transmission": 0.5 } },
        "objects": [object]
    });
    let overrides = Overrides { precision: Some(precision), ..Overrides::default() };
    load(text.to_string().as_bytes(), Format::Json, &overrides).unwrap_or_else(|p| panic!("{p}")).scene
}

fn unit(random: &mut Random) -> DVec3 {
    loop {
        let v = DVec3::from_array(random.point(1.0));
        if v.length_squared() <= 1.0 && v.length_squared() > 0.01 {
            return v.normalize();
        }
    }
}

/// A direction on the side of `normal`; one in four is grazing.
fn away(normal: DVec3, random: &mut Random) -> DVec3 {
    let v = unit(random);
    let v = if v.dot(normal) < 0.0 { -v } else { v };
    let flat = v - normal * v.dot(normal);
    let cosine = if random.below(4) == 0 {
        strahl::math::pow(10.0, random.between(-3.0, -1.0))
    } else {
        v.dot(normal).max(1e-3)
    };
    (flat.normalize_or(normal.any_orthonormal_vector()) + normal * cosine).normalize()
}

fn ray(origin: DVec3, direction: DVec3) -> RayQuery {
    RayQuery { origin: origin.into(), direction: direction.into(), t_min: 0.0, t_max: None }
}

/// What went wrong with rays that leave the surface of one kind of body.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
struct Count {
    rays: usize,
    /// Rays away from a body that met it.
    self_hits: usize,
    /// Rays into a body that did not meet its far side.
    lost: usize,
    /// Rays into a body that left it somewhere else than where they do.
    misplaced: usize,
}

impl Count {
    fn wrong(&self) -> usize {
        self.self_hits + self.lost + self.misplaced
    }
}

/// Unit roundoff.
fn roundoff(precision: Precision) -> f64 {
    if precision == Precision::Single { f64::from(f32::EPSILON) / 2.0 } else { f64::EPSILON / 2.0 }
}

/// Sends `count` rays onto a body of size `r` that far away, and from where each hits one off and one into the body.
fn leave(name: &str, r: f64, place: f64, precision: Precision, count: usize, random: &mut Random) -> Count {
    let center = unit(random) * (place * r);
    let center = if precision == Precision::Single { center.as_vec3().as_dvec3() } else { center };
    let object = object(name, center, r);
    let scene = scene_of(&object, precision);
    let sheet = ["disc", "triangle", "plane"].contains(&name);

    let onto: Vec<RayQuery> = (0..count)
        .map(|_| {
            let origin = center + unit(random) * (3.0 * r);
            ray(origin, (center + unit(random) * (random.between(0.0, 0.9) * r) - origin).normalize())
        })
        .collect();
    let hits: Vec<FirstHit> = first_hits(&scene, &onto).into_iter().flatten().collect();
    let hits: Vec<FirstHit> = hits.into_iter().filter(|hit| name != "torus" || outer(hit, center)).collect();
    let directions: Vec<DVec3> = hits.iter().map(|hit| away(DVec3::from_array(hit.normal), random)).collect();
    let both = |inward: bool| -> Vec<RayQuery> {
        let start = |hit: &FirstHit| DVec3::from_array(if inward { hit.inside } else { hit.outside });
        hits.iter().zip(&directions).map(|(hit, d)| ray(start(hit), if inward { -*d } else { *d })).collect()
    };

    let mut found = Count { rays: hits.len(), ..Count::default() };
    found.self_hits = first_hits(&scene, &both(false)).iter().flatten().count();
    let inward = both(true);
    let exits = first_hits(&scene, &inward);
    if sheet {
        found.self_hits += exits.iter().flatten().count();
        return found;
    }
    let u = roundoff(precision);
    for (ray, exit) in inward.iter().zip(&exits) {
        let Some(exit) = exit else {
            found.lost += 1;
            continue;
        };
        let (origin, direction) = (DVec3::from_array(ray.origin), DVec3::from_array(ray.direction));
        let narrow = if precision == Precision::Single { direction.as_vec3().as_dvec3() } else { direction };
        let cosine = narrow.dot(DVec3::from_array(exit.normal));
        let off = (origin + narrow * exit.t).distance(DVec3::from_array(exit.point));
        let bound = 128.0 * u * (r + center.length()) / cosine.abs().max(1e-6);
        found.misplaced += usize::from(cosine < 0.0 || off > bound);
    }
    found
}

/// Whether a point of the torus lies on its convex hull, which no ray away from it can meet again.
fn outer(hit: &FirstHit, center: DVec3) -> bool {
    let axis = DVec3::new(0.3, -0.5, 0.8).normalize();
    let q = DVec3::from_array(hit.point) - center;
    let across = q - axis * q.dot(axis);
    across.dot(DVec3::from_array(hit.normal)) > 0.01 * across.length()
}

/// What goes wrong, for each primitive and place, over sizes from 1e-6 to 1e6.
fn table(precision: Precision, each: usize) -> Vec<(&'static str, f64, Count)> {
    let mut random = Random::new(7);
    let mut rows = Vec::new();
    for name in PRIMITIVES {
        for place in PLACES {
            let mut sum = Count::default();
            for exponent in -6..=6 {
                let r = 10f64.powi(exponent) * random.between(0.5, 1.0);
                let count = leave(name, r, place, precision, each, &mut random);
                sum.rays += count.rays;
                sum.self_hits += count.self_hits;
                sum.lost += count.lost;
                sum.misplaced += count.misplaced;
            }
            println!("{precision:?}, {name} at {place} r: {sum:?}");
            rows.push((name, place, sum));
        }
    }
    rows
}

fn check(precision: Precision, each: usize) {
    let wrong: Vec<_> = table(precision, each).into_iter().filter(|(_, _, count)| count.wrong() > 0).collect();
    assert!(wrong.is_empty(), "{precision:?}: {wrong:#?}");
}

#[test]
fn in_double_no_ray_meets_what_it_leaves_and_none_loses_its_exit() {
    check(Precision::Double, 3000);
}

#[test]
fn in_single_no_ray_meets_what_it_leaves_and_none_loses_its_exit() {
    check(Precision::Single, 3000);
}

#[test]
#[ignore = "10^8 rays take minutes"]
fn none_of_a_hundred_million_rays_meets_what_it_leaves() {
    let rays: usize = std::env::var("STRAHL_RAYS").map_or(100_000_000, |n| n.parse().unwrap());
    let each = rays / (2 * PRIMITIVES.len() * PLACES.len() * 13);
    check(Precision::Double, each);
    check(Precision::Single, each);
}

/// How naive code starts a secondary ray: nearest t that counts, and offset along the normal.
const NAIVE: [(&str, f32, f32); 3] = [("no offset", 0.0, 0.0), ("t > 1e-4", 1e-4, 0.0), ("offset 1e-3", 0.0, 1e-3)];

/// The textbook's sphere in f32: the nearest t above `t_min`.
fn textbook_sphere(c: Vec3, r: f32, o: Vec3, d: Vec3, t_min: f32) -> Option<f32> {
    let f = o - c;
    let b = f.dot(d);
    let discriminant = b * b - (f.dot(f) - r * r);
    let root = discriminant.sqrt();
    [-b - root, -b + root].into_iter().find(|t| *t > t_min)
}

#[test]
fn naive_offsets_fail_so_this_harness_can_see_failures() {
    let mut random = Random::new(11);
    let mut wrong = [[0; 2]; 3];
    let mut rays = 0;
    for place in PLACES {
        for exponent in -6..=6 {
            let r = 10f64.powi(exponent) as f32;
            for _ in 0..3000 {
                let c = (unit(&mut random) * place).as_vec3() * r;
                let normal = unit(&mut random);
                let (n, d) = (normal.as_vec3(), away(normal, &mut random).as_vec3());
                let chord = 2.0 * r * n.dot(d);
                rays += 1;
                for (k, (_, t_min, offset)) in NAIVE.into_iter().enumerate() {
                    let p = c + n * r;
                    wrong[k][0] += usize::from(textbook_sphere(c, r, p + n * offset, d, t_min).is_some());
                    let exit = textbook_sphere(c, r, p - n * offset, -d, t_min);
                    let right = exit.is_some_and(|t| (t - chord).abs() <= 0.02 * chord + 32.0 * f32::EPSILON * r);
                    wrong[k][1] += usize::from(!right);
                }
            }
        }
    }
    for ((name, ..), counts) in NAIVE.into_iter().zip(wrong) {
        let [hits, lost] = counts.map(|n| n as f64 / f64::from(rays));
        println!("{name}: {:.1} % false self-hits, {:.1} % of exits lost or misplaced", 100.0 * hits, 100.0 * lost);
        assert!(hits > 0.1 && lost > 0.3, "{name} did not fail");
    }
}
