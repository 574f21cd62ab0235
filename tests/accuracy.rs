//! How far distances are from the exact ones, in units of u D / cos, from near and far, in both precisions.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail loudly and say what it measured")]

mod common;

use common::Random;
use common::wide::{Wide, Wide3};
use glam::DVec3;
use serde_json::{Value, json};
use strahl::scene::description::Precision;
use strahl::scene::{Format, Overrides, load};
use strahl::trace::packets::first_hits;
use strahl::trace::query::RayQuery;

/// D / r, from close by to where single precision barely sees the body.
const DISTANCES: [f64; 8] = [1.5, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7];

/// A body and the function that is 0 on its surface, which takes a point relative to the centre, and its gradient.
struct Body {
    name: &'static str,
    bound: f64,
    object: Value,
    center: DVec3,
    surface: Box<dyn Fn(Wide3, DVec3) -> (Wide, DVec3)>,
}

fn narrow(precision: Precision, v: DVec3) -> DVec3 {
    if precision == Precision::Single { v.as_vec3().as_dvec3() } else { v }
}

/// Bodies of size about 1 around a centre, whose numbers are the same in both precisions.
fn bodies(random: &mut Random) -> Vec<Body> {
    let c = DVec3::from_array(random.point(10.0)).as_vec3().as_dvec3();
    // Axes with short binary digits, of which every multiple used here is exact.
    let axis = DVec3::new(0.5, -0.375, 0.25);
    let center = c.to_array();
    let at = |v: DVec3| (c + v).as_vec3().as_dvec3();
    let (base, top) = (at(-axis), at(axis));
    let (low, high) = (at(DVec3::new(-1.0, -0.75, -0.5)), at(DVec3::new(1.0, 0.75, 0.5)));
    let body = |name, bound, object, surface| Body { name, bound, object, center: c, surface };
    let cone = move |r0: f64, r1: f64| -> Box<dyn Fn(Wide3, DVec3) -> (Wide, DVec3)> {
        let (b, a) = (base - c, top - base);
        Box::new(move |q, _| {
            // |q - b|^2 - h^2 - (r0 + k h)^2 times |a|^2 squared, where h = (q - b).a / |a|.
            let q = q - Wide3::of(b);
            let a3 = Wide3::of(a);
            let (aa, qa) = (a3.dot(a3), q.dot(a3));
            let r = Wide::of(r0) * aa + (Wide::of(r1) - Wide::of(r0)) * qa;
            let value = (q.dot(q) * aa - qa * qa) * aa - r * r;
            let (aa, qa, r) = (aa.value(), qa.value(), r.value());
            let gradient = (q.value() * aa - a * qa) * (2.0 * aa) - a * (2.0 * r * (r1 - r0));
            (value, gradient)
        })
    };
    vec![
        body(
            "sphere",
            6.0,
            json!({ "sphere": { "center": center, "radius": 1, "material": "m" } }),
            Box::new(|q, _| (q.dot(q) - Wide::of(1.0), q.value() * 2.0)),
        ),
        body(
            "cylinder",
            8.0,
            json!({ "cylinder": { "base": base.to_array(), "top": top.to_array(), "radius": 0.75, "capped": false, "material": "m" } }),
            cone(0.75, 0.75),
        ),
        body(
            "frustum",
            8.0,
            json!({ "cone": { "base": base.to_array(), "base_radius": 0.875, "top": top.to_array(), "top_radius": 0.25,
                "capped": false, "material": "m" } }),
            cone(0.875, 0.25),
        ),
        body(
            "plane",
            8.0,
            json!({ "plane": { "point": center, "normal": [0, 1, 0], "material": "m" } }),
            Box::new(|q, _| (q.0[1], DVec3::Y)),
        ),
        body(
            "disc",
            8.0,
            json!({ "disc": { "center": center, "normal": [0, 0, 1], "radius": 1, "material": "m" } }),
            Box::new(|q, _| (q.0[2], DVec3::Z)),
        ),
        body(
            "box",
            8.0,
            json!({ "box": { "min": low.to_array(), "max": high.to_array(), "material": "m" } }),
            Box::new(move |q, normal| {
                let face = if normal.element_sum() < 0.0 { low - c } else { high - c };
                let n = Wide3::of(normal);
                ((q - Wide3::of(face)).dot(n), normal)
            }),
        ),
        body(
            "torus",
            16.0,
            json!({ "torus": { "center": center, "axis": [0, 0, 1], "major_radius": 0.75, "minor_radius": 0.25, "material": "m" } }),
            Box::new(|q, _| {
                let (big, small) = (0.75, 0.25);
                let across = q.0[0] * q.0[0] + q.0[1] * q.0[1];
                let k = q.dot(q) + Wide::of(big * big - small * small);
                let p = q.value();
                let flat = DVec3::new(p.x, p.y, 0.0);
                (k * k - across * Wide::of(4.0 * big * big), p * (4.0 * k.value()) - flat * (8.0 * big * big))
            }),
        ),
    ]
}

/// Largest error of the rays that hit a body from one distance, in u D / cos, and how many there were.
fn worst(body: &Body, distance: f64, precision: Precision, count: usize, random: &mut Random) -> (f64, usize) {
    let text = json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "pinhole": { "eye": [0, 0, 0], "look_at": [0, 0, -1] } },
        "lights": [],
        "materials": { "m": { "diffuse": 0.5 } },
        "objects": [body.object]
    });
    let overrides = Overrides { precision: Some(precision), ..Overrides::default() };
    let scene = load(text.to_string().as_bytes(), Format::Json, &overrides).unwrap_or_else(|p| panic!("{p}")).scene;
    let rays: Vec<RayQuery> = (0..count)
        .map(|_| {
            let origin = narrow(precision, body.center + DVec3::from_array(random.point(1.0)).normalize() * distance);
            let target = body.center + DVec3::from_array(random.point(0.6));
            let direction = narrow(precision, (target - origin).normalize());
            RayQuery { origin: origin.into(), direction: direction.into(), t_min: 0.0, t_max: None }
        })
        .collect();
    let u = if precision == Precision::Single { f64::from(f32::EPSILON) } else { f64::EPSILON } / 2.0;
    let (mut largest, mut used) = (0.0, 0);
    for (ray, hit) in rays.iter().zip(first_hits(&scene, &rays)) {
        let Some(hit) = hit else { continue };
        let (o, d) = (DVec3::from_array(ray.origin), DVec3::from_array(ray.direction));
        let f = Wide3::of(o) - Wide3::of(body.center);
        let normal = DVec3::from_array(hit.normal);
        // Newton's method from the kernel's answer; where it does not settle, the ray grazes.
        let mut t = Wide::of(hit.t);
        let (mut step, mut cosine) = (f64::INFINITY, 0.0);
        for _ in 0..12 {
            let (value, gradient) = (body.surface)(f + Wide3::of(d).times(t), normal);
            let slope = gradient.dot(d);
            cosine = slope.abs() / (gradient.length() * d.length());
            step = value.value() / slope;
            t = t - Wide::of(step);
        }
        let reach = f.value().length();
        if step.abs() > 1e-3 * u * reach || cosine * cosine < 64.0 * u * reach {
            continue;
        }
        used += 1;
        let error = (t - Wide::of(hit.t)).value().abs() * d.length();
        largest = f64::max(largest, error * cosine / (u * reach));
    }
    (largest, used)
}

fn check(precision: Precision) {
    let mut random = Random::new(5);
    let mut wrong = Vec::new();
    for _ in 0..4 {
        for body in bodies(&mut random) {
            let mut line = Vec::new();
            for distance in DISTANCES {
                let (error, used) = worst(&body, distance, precision, 2500, &mut random);
                if error > body.bound {
                    wrong.push(format!("{} from {distance:e}: {error:.1} u D / cos", body.name));
                }
                line.push(format!("{error:.1} ({used})"));
            }
            println!("{precision:?} {:8} {}", body.name, line.join(", "));
        }
    }
    assert!(wrong.is_empty(), "{precision:?}: {wrong:#?}");
}

#[test]
fn distances_in_single_are_off_by_a_few_roundings() {
    check(Precision::Single);
}

#[test]
fn distances_in_double_are_off_by_a_few_roundings() {
    check(Precision::Double);
}
