//! R: refraction at one surface, and Fresnel's reflectance.

use super::Case;
use super::evidence::Evidence;
use super::lab::{Lab, ask, ball, from_front, hit, rows, square, truth, vector};
use crate::common::Random;
use crate::common::naive;
use crate::common::wide::Wide;
use glam::DVec3;
use serde_json::json;
use strahl::inspect::tree::Tree;
use strahl::math::{acos, asin, hypot, sin_cos};
use strahl::scene::Scene;

pub const CASES: &[Case] = &[
    ("R01", critical),
    ("R02", about_critical),
    ("R03", into_denser),
    ("R04", grazing),
    ("R05", near_normal),
    ("R06", matched),
    ("R07", brewster),
    ("R08", reciprocity),
    ("R09", leaving),
    ("R10", limb),
    ("R15", fermat),
];

/// Everything below y = 0 is of this index.
fn half_space(lab: &Lab, ior: f64) -> Scene {
    let material = json!({ "medium": { "diffuse": 0, "transmission": 1, "ior": ior } });
    lab.scene(
        json!([{ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "medium" } }]),
        json!({ "materials": material }),
    )
}

/// Unit direction downwards at an angle of incidence.
fn down(lab: &Lab, angle: f64) -> DVec3 {
    let (sin, cos) = sin_cos(angle);
    lab.round3(DVec3::new(sin, -cos, 0.0))
}

fn critical(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "refract_critical", &["exact"]);
    // Pythagorean triples x, y, z: sin(theta) = x/z, and with n1/n2 = z/x, rounded downwards, nothing is reflected.
    for m in 2..30 {
        for n in 1..m {
            let (x, y, z) = (f64::from(2 * m * n), f64::from(m * m - n * n), f64::from(m * m + n * n));
            let ior = lab.round(x / z);
            let eta = lab.round(1.0 / ior);
            if (Wide::of(eta) * Wide::of(x) - Wide::of(z)).value() > 0.0 || ior < 0.1 {
                continue;
            }
            let found = hit(&half_space(lab, ior), DVec3::Y, DVec3::new(x, -y, 0.0));
            let near = found.is_some_and(|h| (h.reflectance - 1.0).abs() < 16.0 * lab.u.sqrt() * (z / y) * (z / x));
            e.check(near, || format!("at the critical angle of {x}/{z}"));
            e.twin(naive::refract(lab, DVec3::new(x, -y, 0.0), DVec3::Y, eta).is_nan());
        }
    }
    e
}

fn about_critical(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "refract_critical", &[]);
    for row in rows("refract_critical") {
        let forced = &row["decision"][lab.pick("TIR_f32", "TIR_f64")];
        let (n1, n2) = (&row["in"]["n1_incident"], &row["in"]["n2_transmitted"]);
        let (d, eta) = (vector(&row["in"]["d"]), n1.as_f64().unwrap() / n2.as_f64().unwrap());
        let total = naive::refract(lab, d, DVec3::Y, lab.round(eta)).is_nan();
        if let Some(expected) = forced.as_bool().or_else(|| forced.as_str().and_then(|s| s.parse().ok())) {
            e.twin(total != expected);
        }
    }
    // A window seen from below is a clean circle: total reflection once along the angle, and R rises to it.
    let scene = half_space(lab, 1.5);
    let (mut was_total, mut last) = (false, 0.0);
    let edge = asin(1.0 / 1.5);
    for k in -400i32..400 {
        let d = down(lab, edge + f64::from(k) * 64.0 * lab.u);
        let found = hit(&scene, -DVec3::Y, DVec3::new(d.x, -d.y, 0.0)).unwrap();
        e.check(found.tir || !was_total || k.abs() < 2, || format!("light again at {k}"));
        e.check(found.reflectance >= last - 64.0 * lab.u.sqrt(), || format!("R falls at {k}"));
        (was_total, last) = (found.tir, found.reflectance);
    }
    e.excuse(
        true,
        "the textbook's radicand is as good as any: outside the band that rounding the input makes, it decides rightly",
    );
    e
}

fn into_denser(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("angles");
    for ior in [1.0, 1.1, 1.5, 2.4, 100.0] {
        let scene = half_space(lab, ior);
        for i in 0..4000 {
            let d = down(lab, std::f64::consts::FRAC_PI_2 * f64::from(i) / 4000.0);
            let found = hit(&scene, DVec3::Y, d);
            e.check(found.is_some_and(|h| !h.tir && h.transmitted.is_some()), || format!("into {ior} along {d}"));
            // Textbook: total reflection where sin(theta2) <= n1/n2.
            e.twin(d.x / ior <= 1.0 / ior);
        }
    }
    e
}

/// Fresnel's reflectance with 106 bits.
fn exact_reflectance(d: DVec3, eta: f64) -> f64 {
    let [x, y, eta, one] = [d.x, d.y, eta, 1.0].map(Wide::of);
    let squared = x * x + y * y;
    let sine2 = x * x / squared;
    let c1 = (y * y / squared).sqrt();
    let c2 = (one - eta * eta * sine2).sqrt();
    let (s, p) = ((eta * c1 - c2) / (eta * c1 + c2), (c1 - eta * c2) / (c1 + eta * c2));
    ((s * s + p * p) * Wide::of(0.5)).value()
}

fn grazing(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(16.0, "u of R");
    let scene = half_space(lab, 1.5);
    for k in 4..lab.pick(24, 52) {
        let d = DVec3::new(1.0, -(2f64.powi(-k)), 0.0);
        let reflectance = hit(&scene, DVec3::Y * 1e-6, d).map_or(f64::NAN, |h| h.reflectance);
        let exact = exact_reflectance(d, lab.round(1.0 / lab.round(1.5)));
        e.check((0.0..=1.0).contains(&reflectance), || format!("R = {reflectance} at 2^-{k}"));
        e.measure((reflectance - exact).abs() / lab.u);
        // The cosine from the sine.
        let sine = naive::normalize(lab, d).x;
        let cosine = lab.round(1.0 - lab.round(sine * sine)).sqrt();
        let twin = exact_reflectance(DVec3::new(sine, -cosine.max(1e-300), 0.0), 1.0 / 1.5);
        e.twin_measure((twin - exact).abs() / lab.u);
    }
    e
}

fn near_normal(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(4.0, "u of the ratio of sines");
    for (ior, eta) in [(1.5, 1.0 / 1.5), (1.25, 0.8), (2.0, 0.5)] {
        let scene = half_space(lab, ior);
        for k in [10, 20, 40, 60] {
            let lateral = 2f64.powi(-k);
            let found = hit(&scene, DVec3::Y, DVec3::new(lateral, -1.0, 0.0)).unwrap();
            let ratio = |t: f64| (t / (lateral / hypot(lateral, 1.0)) / eta - 1.0).abs() / lab.u;
            e.measure(ratio(found.transmitted.unwrap()[0]));
            let angle = lab.round(acos(lab.round(1.0 / hypot(lateral, 1.0))));
            e.twin_measure(ratio(lab.round(sin_cos(asin(eta * sin_cos(angle).0)).0)));
        }
    }
    e
}

fn matched(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays and pixels");
    let mut random = Random::new(30);
    let equal = half_space(lab, 1.0);
    for _ in 0..500 {
        let d = down(lab, random.between(0.0, 1.57));
        let unit = naive::normalize(lab, d);
        let found = hit(&equal, DVec3::Y, d).unwrap();
        let close = found.transmitted.is_some_and(|t| DVec3::from_array(t).distance(unit) <= 4.0 * lab.u);
        e.check(close && found.reflectance == 0.0 && !found.tir, || format!("along {d}: {found:?}"));
        e.twin(
            naive::refract(lab, d, DVec3::Y, 1.0).distance(unit) > 4.0 * lab.u
                || naive::refract(lab, d, DVec3::Y, 1.0).is_nan(),
        );
    }
    for ulps in [-4.0, -2.0, 2.0, 4.0] {
        let ior = 1.0 + ulps * lab.u;
        let found = hit(&half_space(lab, ior), DVec3::Y, DVec3::new(0.6, -0.8, 0.0)).unwrap();
        let off =
            found.transmitted.map_or(f64::INFINITY, |t| DVec3::from_array(t).distance(DVec3::new(0.6, -0.8, 0.0)));
        e.check(off <= 16.0 * lab.u, || format!("n = 1 + {ulps} u bends by {off:e}"));
        let normal = hit(&half_space(lab, ior), DVec3::Y, -DVec3::Y).unwrap().reflectance;
        let exact = ((ior - 1.0) / (ior + 1.0)).powi(2);
        e.check((normal / exact - 1.0).abs() <= 16.0 * lab.u, || format!("R = {normal:e} instead of {exact:e}"));
    }
    let floor = json!({ "plane": { "point": [0, -1, 0], "normal": [0, 1, 0], "material": "tiles" } });
    let more = json!({
        "image": square(64), "background": [0.3, 0.4, 0.6],
        // Not so that pixels look exactly at the borders of tiles.
        "camera": { "pinhole": { "eye": [0.13, 0.37, 5], "look_at": [0.02, 0.05, 0] } },
        "materials": { "tiles": { "diffuse": { "checker": { "a": 0.9, "b": 0.2 } } } }
    });
    let without = lab.picture(json!([floor]), more.clone()).film;
    let body = json!({ "box": { "min": [0.3, -0.5, -0.4], "max": [1, 0.6, 0.2], "material": "nothing" } });
    let with = lab.picture(json!([floor, ball([-0.4, 0.0, 0.0], 0.8, "nothing"), body]), more).film;
    let count = without.pixels.iter().zip(&with.pixels).filter(|(a, b)| a != b).count();
    e.check(count == 0, || format!("{count} pixels show glass of index 1"));
    e
}

fn brewster(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(8.0, "u of R - R_s / 2");
    // tan(theta) = n = 3/4 is the triple 3-4-5; 5/12 and 8/15 are triples as well.
    for (x, y) in [(3.0, 4.0), (8.0, 15.0), (5.0, 12.0)] {
        let ior = lab.round(x / y);
        let scene = half_space(lab, ior);
        let r = hit(&scene, DVec3::Y, DVec3::new(x, -y, 0.0)).unwrap().reflectance;
        let rs = (ior * ior - 1.0) / (ior * ior + 1.0);
        e.measure((r - rs * rs / 2.0).abs() / lab.u);
        let twin = naive::reflectance(lab, DVec3::new(x, -y, 0.0), DVec3::Y, lab.round(1.0 / ior));
        e.twin_measure((twin - rs * rs / 2.0).abs() / lab.u);
    }
    e.excuse(true, "in the sum R the square of the naive r_p, noise of order u, vanishes");
    e
}

fn reciprocity(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(4.0, "u of R, there and back");
    let mut random = Random::new(31);
    for ior in [1.33, 1.5, 2.4] {
        let scene = half_space(lab, ior);
        for _ in 0..1000 {
            let d = down(lab, random.between(0.0, 1.05));
            let there = hit(&scene, DVec3::Y, d).unwrap();
            let back = -DVec3::from_array(there.transmitted.unwrap());
            let again = hit(&scene, -DVec3::Y, back).unwrap();
            e.measure((there.reflectance - again.reflectance).abs() / lab.u);
            e.check((0.0..=1.0).contains(&there.reflectance), || format!("R = {}", there.reflectance));
            let schlick = |c: f64| ((ior - 1.0) / (ior + 1.0)).powi(2) * (1.0 - (1.0 - c).powi(5)) + (1.0 - c).powi(5);
            e.twin_measure((schlick(-d.y) - schlick(back.y)).abs() / lab.u);
        }
    }
    e
}

/// Glass sphere of index 1.5 and rays past its centre at b.
fn through_ball(lab: &Lab, b: f64) -> Tree {
    lab.tree(DVec3::new(b, 0.0, 4.0), -DVec3::Z, json!([ball([0.0; 3], 1.0, "glass")]), json!({}))
}

fn leaving(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "glass_sphere_deviation", &[]);
    for i in 1..90 {
        let tree = through_ball(lab, f64::from(i) / 100.0);
        for pair in tree.rays.windows(2) {
            let n = DVec3::from_array(pair[0].hit.as_ref().unwrap().normal);
            let sides = [&pair[0], &pair[1]].map(|ray| n.dot(DVec3::from_array(ray.direction)));
            e.check(sides[0] * sides[1] > 0.0, || "a ray turns back at a surface".to_owned());
        }
        let exit = &tree.rays[1];
        let (d, n) = (DVec3::from_array(exit.direction), DVec3::from_array(exit.hit.as_ref().unwrap().normal));
        let out = DVec3::from_array(tree.rays[2].direction);
        // The outward normal and the indices of entering.
        e.twin(naive::refract(lab, d, n, 1.0 / 1.5).distance(out) > 1e-2);
    }
    e
}

fn limb(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "glass_sphere_deviation", &[]);
    for k in 1..lab.pick(22, 50) {
        let b = 1.0 - 2f64.powi(-k);
        let tree = through_ball(lab, b);
        e.check(tree.rays.len() == 3, || format!("b = 1 - 2^-{k}: {} rays", tree.rays.len()));
        e.check(tree.rays.iter().all(|r| r.snell.is_none_or(|s| !s.tir)), || {
            format!("b = 1 - 2^-{k}: total reflection")
        });
    }
    let mut random = Random::new(33);
    for _ in 0..4000 {
        let n = super::lab::direction(&mut random);
        let across = n.any_orthonormal_vector();
        let sine = 1.0 - 2f64.powi(-(lab.pick(18, 47) + random.below(6) as i32));
        let d = lab.round3(across * sine - n * (1.0 - sine * sine).sqrt());
        let inside = naive::refract(lab, d, lab.round3(n), lab.round(1.0 / 1.5));
        let exit = naive::point(lab, lab.round3(n), inside, naive::sphere_roots(lab, n, inside, DVec3::ZERO, 1.0)[1]);
        e.twin(naive::refract(lab, inside, -exit, 1.5).is_nan());
    }
    let more = json!({ "camera": from_front([0.0; 3], 3.0, 2.0), "image": square(150) });
    let rays = lab.picture(json!([ball([0.0; 3], 1.0, "glass")]), more).rays;
    e.check(rays.total_internal_reflections == 0, || format!("{rays:?}"));
    e
}

fn fermat(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "fermat_plane", &[]);
    for row in rows("fermat_plane") {
        let input = &row["in"];
        let (n1, n2) = (input["n1"].as_f64().unwrap(), input["n2"].as_f64().unwrap());
        let d = vector(&input["d"]);
        let start = vector(&input["A"]);
        let at = start + d * (-start.y / d.y);
        // With the index the wrong way round a neighbouring way is shorter.
        let bent = naive::refract(lab, d, DVec3::Y, n2 / n1);
        let end = at + bent;
        let way = |x: f64| n1 * start.distance(at + DVec3::X * x) + n2 * end.distance(at + DVec3::X * x);
        e.twin(bent.is_nan() || way(1e-3) < way(0.0) || way(-1e-3) < way(0.0));
    }
    e
}
