//! Scenes small enough for paper: what rays hit and where, what surfaces and lights do with them, where cameras look.
//! Everything is asked in both precisions.
#![allow(clippy::disallowed_methods, reason = "expected values come from another library than strahl's")]

mod cameras;
mod light;
mod optics;
mod placement;
mod ranges;
mod recursion;
mod scales;
mod shapes;
mod trees;

use glam::DVec3;
use serde_json::{Value, json};
use strahl::film::Region;
use strahl::inspect::query::{RayHit, RayQuery, answer};
use strahl::inspect::tree::{Node, NodeKind, Tree, trace_pixel};
use strahl::render::{Control, render};
use strahl::scene::description::Precision;
use strahl::scene::{Format, Overrides, Scene, load};

/// A scene in one precision.
struct World {
    scene: Scene,
    /// What a handful of roundings of numbers around 1 may amount to.
    small: f64,
}

/// A scene without light under a grey sky, `more` replacing keys, in both precisions.
fn worlds(objects: Value, more: Value) -> [World; 2] {
    let mut description = json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "orthographic": { "eye": [0, 5, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "height": 1 } },
        "lights": [],
        "ambient": 0,
        "materials": {
            "glass": { "diffuse": 0, "transmission": 1, "ior": 1.5 },
            "water": { "diffuse": 0, "transmission": 1, "ior": 1.33 },
            "nothing": { "diffuse": 0, "transmission": 1, "ior": 1 },
            "front": { "one_sided": true },
            "mirror": { "diffuse": 0, "reflection": 0.5 }
        },
        "objects": objects
    });
    for (key, value) in more.as_object().unwrap() {
        match (&mut description[key], value) {
            (Value::Object(old), Value::Object(new)) if key == "materials" => old.extend(new.clone()),
            (old, new) => *old = new.clone(),
        }
    }
    [(Precision::Single, f32::EPSILON.into()), (Precision::Double, f64::EPSILON)].map(|(precision, epsilon)| {
        let overrides = Overrides { precision: Some(precision), ..Overrides::default() };
        let scene =
            load(description.to_string().as_bytes(), Format::Json, &overrides).unwrap_or_else(|p| panic!("{p}")).scene;
        World { scene, small: 16.0 * epsilon }
    })
}

fn bodies(objects: Value) -> [World; 2] {
    worlds(objects, json!({}))
}

fn one(object: Value) -> [World; 2] {
    bodies(json!([object]))
}

fn ray(origin: [f64; 3], direction: [f64; 3]) -> RayQuery {
    RayQuery { origin, direction, t_min: 0.0, t_max: None }
}

fn query(world: &World, origin: [f64; 3], direction: [f64; 3]) -> Option<RayHit> {
    answer(&world.scene, &ray(origin, direction)).at
}

#[track_caller]
fn assert_near(actual: f64, expected: f64, tolerance: f64) {
    assert!((actual - expected).abs() <= tolerance, "{actual} instead of {expected} (tolerance {tolerance:e})");
}

#[track_caller]
fn assert_vector(actual: [f64; 3], expected: [f64; 3], tolerance: f64) {
    for i in 0..3 {
        assert!((actual[i] - expected[i]).abs() <= tolerance, "{actual:?} instead of {expected:?} ({tolerance:e})");
    }
}

/// A ray hits at `t`, on a surface with this outward normal (of any length), which it goes into or comes out of.
#[track_caller]
fn hits(worlds: &[World; 2], origin: [f64; 3], direction: [f64; 3], t: f64, normal: [f64; 3], entering: bool) {
    for world in worlds {
        let hit = query(world, origin, direction).unwrap_or_else(|| panic!("{origin:?} along {direction:?} misses"));
        let (o, d) = (DVec3::from(origin), DVec3::from(direction));
        let size = world.small * (1.0 + o.abs().max_element() + (d * t).abs().max_element());
        assert_near(hit.t * d.length(), t * d.length(), size);
        assert_vector(hit.point, (o + d * t).into(), size);
        assert_vector(hit.normal, DVec3::from(normal).normalize().into(), size);
        assert_near(DVec3::from(hit.normal).length(), 1.0, world.small);
        assert_eq!(hit.entering, entering, "{origin:?} along {direction:?}");
    }
}

#[track_caller]
fn misses(worlds: &[World; 2], origin: [f64; 3], direction: [f64; 3]) {
    for world in worlds {
        assert_eq!(query(world, origin, direction), None, "{origin:?} along {direction:?}");
    }
}

/// Numbers in [0, 1), the same ones in every run (Knuth's linear congruential generator).
fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

fn minus(v: [f64; 3]) -> [f64; 3] {
    v.map(|x| 0.0 - x)
}

/// The pixel of a scene of one pixel, rendered; the ray tree must agree with it.
fn pixels(objects: Value, more: Value) -> Vec<([f64; 3], f64)> {
    worlds(objects, more)
        .iter()
        .map(|world| {
            let picture = render(&world.scene, Region::whole(1, 1), &Control::default()).unwrap();
            (picture.film.pixels[0].map(f64::from), f64::from(f32::EPSILON) * 4.0)
        })
        .collect()
}

#[track_caller]
fn shows(objects: Value, more: Value, expected: [f64; 3]) {
    for (pixel, small) in pixels(objects, more) {
        assert_vector(pixel, expected, small * (1.0 + expected.into_iter().fold(0.0, f64::max)));
    }
}
