//! S: spheres.

use super::Case;
use super::evidence::Evidence;
use super::exact;
use super::lab::{Lab, ask, ball, direction, finite, from_front, hit, rows, square, truth, vector};
use crate::common::Random;
use crate::common::naive;
use crate::common::wide::Wide3;
use glam::DVec3;
use serde_json::json;
use strahl::inspect::tree::NodeKind;

pub const CASES: &[Case] = &[
    ("S01", far),
    ("S02", planet),
    ("S03", tangent),
    ("S04", leaving),
    ("S05", short_chord),
    ("S06", centre),
    ("S07", tiny),
    ("S08", direction_scales),
    ("S09", shells),
    ("S10", bounces),
];

const UNIT_BALL: [f64; 3] = [0.0; 3];

fn far(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(6.0, "u D / cos");
    let scene = lab.scene(json!([ball(UNIT_BALL, 1.0, "red")]), json!({}));
    let mut random = Random::new(1);
    for power in 1..=7 {
        let away = 10f64.powi(power);
        for _ in 0..2000 {
            let o = lab.round3(direction(&mut random) * away);
            let d = lab.round3(direction(&mut random) * random.between(0.0, 1.5) - o);
            let line = exact::sphere(Wide3::of(o), Wide3::of(d), 1.0);
            let found = hit(&scene, o, d);
            let twin = naive::sphere(lab, o, d, DVec3::ZERO, 1.0, 0.0);
            if line.beside.abs() > 8.0 * lab.u * away {
                e.check(found.is_some() == line.first.is_some(), || format!("wrong decision at {o} along {d}"));
                e.twin(twin.is_some() != line.first.is_some());
            }
            if let (Some(found), Some(t)) = (found, line.first) {
                let cosine = ((o + d * t).normalize().dot(d.normalize())).abs();
                let unit = lab.u * away / cosine;
                // In the band itself the cosine is noise.
                if line.beside < -8.0 * lab.u * away {
                    e.measure((found.t - t).abs() * d.length() / unit);
                    e.twin_measure(twin.map_or(f64::INFINITY, |twin| (twin - t).abs() * d.length() / unit));
                }
            }
        }
    }
    e
}

fn planet(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(8.0, "u of the way to the ground");
    let radius = 6_371_000.0;
    let center = DVec3::new(0.0, -radius, 0.0);
    let scene = lab.scene(json!([ball(center.into(), radius, "red")]), json!({}));
    for height in [1.5, 2.5, 17.5, 128.5] {
        let eye = DVec3::new(0.0, height, 0.0);
        for aside in [0.0, 0.5, 1.0, 3.0] {
            let d = DVec3::new(aside, -1.0, 0.0);
            let t = exact::sphere(Wide3::of(eye - center), Wide3::of(d), radius).first.unwrap();
            let off = |t_found: f64| (t_found / t - 1.0).abs() / lab.u;
            e.measure(hit(&scene, eye, d).map_or(f64::INFINITY, |h| off(h.t)));
            e.twin_measure(naive::sphere(lab, eye, d, center, radius, 0.0).map_or(f64::INFINITY, off));
        }
        let dip = (height * (2.0 * radius + height)).sqrt() / radius;
        // Single precision knows the ground to a few metres.
        let margin = 1.0 + (16.0 * lab.u * radius / height).max(1e-6);
        for i in 0..360 {
            let (sin, cos) = strahl::math::sin_cos(f64::from(i).to_radians());
            let level = |slope: f64| lab.round3(DVec3::new(cos, -slope, sin));
            e.check(hit(&scene, eye, level(dip * margin)).is_some(), || format!("no ground at {i} degrees"));
            let above = if margin > 1.5 { -dip } else { dip / margin };
            e.check(hit(&scene, eye, level(above)).is_none(), || format!("ground in the sky at {i} degrees"));
        }
    }
    e
}

fn tangent(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "sphere_grazing", &[]);
    let scene = lab.scene(json!([ball(UNIT_BALL, 1.0, "red")]), json!({}));
    for k in -64..=64 {
        let o = DVec3::new(-4.0, 1.0 + f64::from(k) * lab.u, 0.0);
        if let Some(found) = hit(&scene, o, DVec3::X) {
            e.check(finite(&found) && found.normal[0] <= 0.0, || format!("tangent {k}: {found:?}"));
        }
        e.twin(naive::sphere_roots(lab, o, DVec3::X, DVec3::ZERO, 1.0)[0].is_nan());
    }
    e
}

fn leaving(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays off mirrors that met them again, and dark pixels");
    for (radius, center) in [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 100.0), (1e3, 1e5)] {
        let center = [center, -center, 0.5 * center];
        let more = json!({
            "camera": from_front(center, 3.0 * radius, 2.2 * radius), "image": square(40), "background": 1,
            "render": { "max_depth": 2 }
        });
        let film = lab.picture(json!([ball(center, radius, "mirror")]), more).film;
        for pixel in film.pixels {
            e.check(pixel == [1.0; 3], || format!("a pixel is {pixel:?} at radius {radius}"));
        }
    }
    let (mut random, radius) = (Random::new(2), lab.pick(1e3, 1e13));
    for _ in 0..2000 {
        let n = direction(&mut random);
        let w = direction(&mut random);
        let (p, w) = (lab.round3(n * radius), lab.round3(if w.dot(n) < 0.0 { -w } else { w }));
        e.twin(naive::sphere(lab, p, w, DVec3::ZERO, radius, 1e-4).is_some());
    }
    e
}

fn short_chord(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "sphere_origin_on_surface", &["inward", "tangent", "outward", "big"]);
    for radius in [1e-6, 1.0, 1e6] {
        let more = json!({ "camera": from_front([0.0; 3], 3.0 * radius, 2.0 * radius), "image": square(64) });
        let rays = lab.picture(json!([ball([0.0; 3], radius, "glass")]), more).rays;
        e.check(rays.transmitted == 2 * rays.camera_hits, || format!("radius {radius}: {rays:?}"));
    }
    for row in rows("sphere_origin_on_surface") {
        if row["expect"]["hit"] == true && row["name"].as_str().unwrap().contains("inward") {
            let (o, d) = (vector(&row["ray"]["o"]), vector(&row["ray"]["d"]));
            let (center, radius) = (vector(&row["shape"]["center"]), row["shape"]["radius"].as_f64().unwrap());
            // The same question a millionth as large.
            let t = naive::sphere(lab, o * 1e-6, d * 1e-6, center * 1e-6, radius * 1e-6, 1e-4 / d.length() * 1e6);
            e.twin(t.is_none());
        }
    }
    e
}

fn centre(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "sphere_origin_on_surface", &["center", "inside"]);
    let mut random = Random::new(3);
    for radius in [1e-6, 1.0, 3e5] {
        let scene = lab.scene(json!([ball(UNIT_BALL, radius, "red")]), json!({}));
        for _ in 0..500 {
            let d = lab.round3(direction(&mut random));
            let found = hit(&scene, DVec3::ZERO, d);
            let off = found.map_or(f64::INFINITY, |h| (h.t * d.length() / lab.round(radius) - 1.0).abs());
            e.check(off <= 8.0 * lab.u, || format!("radius {radius} along {d}: off by {off:e}"));
            e.twin(naive::sphere_roots(lab, DVec3::ZERO, d, DVec3::ZERO, radius)[0] < 0.0);
        }
    }
    e
}

fn tiny(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays and refusals");
    for power in 6..=15 {
        let radius = 10f64.powi(-power);
        let scene = lab.scene(json!([ball(UNIT_BALL, radius, "red")]), json!({}));
        let at = |x: f64| DVec3::new(x * radius, 0.0, 1.0);
        let found = hit(&scene, at(0.3), -DVec3::Z);
        e.check(found.as_ref().is_some_and(finite), || format!("radius {radius:e}: {found:?}"));
        e.check(hit(&scene, at(3.0), -DVec3::Z).is_none(), || format!("radius {radius:e}: too thick"));
        e.twin(naive::sphere(lab, at(3.0), -DVec3::Z, DVec3::ZERO, radius, 0.0).is_some());
    }
    for radius in [1e-16, 1e-30, 1e-40, 1e-310] {
        let scene = super::lab::description(json!([ball(UNIT_BALL, radius, "red")]), json!({}));
        e.check(lab.load(&scene).is_err(), || format!("radius {radius:e} is taken"));
    }
    e
}

fn direction_scales(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("scales of one direction");
    let scene = lab.scene(json!([ball(UNIT_BALL, 1.0, "red")]), json!({}));
    let (o, d) = (DVec3::new(0.25, 0.5, 10.0), DVec3::new(0.0625, -0.03125, -1.0));
    let expected = hit(&scene, o, d).unwrap();
    let reach = lab.pick(126, 1000);
    for k in (-reach..=reach).step_by(7) {
        let scale = 2f64.powi(k);
        let found = hit(&scene, o, d * scale).map(|h| (h.t * scale, h.point, h.normal));
        e.check(found == Some((expected.t, expected.point, expected.normal)), || format!("2^{k}: {found:?}"));
        let twin = naive::sphere(lab, o, d * scale, DVec3::ZERO, 1.0, 0.0);
        e.twin(twin.is_none_or(|t| (t * scale - expected.t).abs() > 1e-3));
    }
    e
}

fn shells(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("shells and pixels");
    for gap in [4e-5, 2f64.powi(-18), 2f64.powi(-20), 2f64.powi(-22)] {
        let objects = json!([ball(UNIT_BALL, 1.0, "nothing"), ball(UNIT_BALL, 1.0 - gap, "red")]);
        let tree = lab.tree(DVec3::new(0.2, 0.1, 3.0), -DVec3::Z, objects.clone(), json!({}));
        let seen = tree.rays.get(1).and_then(|ray| ray.hit.as_ref());
        e.check(seen.is_some_and(|h| h.object == "/objects/1" && h.t < 2.0 * gap), || format!("gap {gap:e}: {seen:?}"));
        let more = json!({ "camera": from_front(UNIT_BALL, 3.0, 1.2), "image": square(24) });
        for pixel in lab.picture(objects, more).film.pixels {
            e.check(pixel == [1.0, 0.0, 0.0], || format!("gap {gap:e}: a pixel is {pixel:?}"));
        }
        let inside = DVec3::new(0.0, 0.0, 1.0);
        let t = naive::sphere(lab, inside, -DVec3::Z, DVec3::ZERO, 1.0 - gap, 1e-4);
        e.twin(t.is_none_or(|t| t > 2.0 * gap));
    }
    e
}

fn bounces(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(2000.0, "u of the cosine after 1000 bounces");
    let (o, d) = (DVec3::new(0.3, 0.2, 0.1), DVec3::new(0.5, -0.75, 0.25));
    let more = json!({ "render": { "max_depth": 1001, "min_weight": 0 } });
    let tree = lab.tree(o, d, json!([ball(UNIT_BALL, 1.0, "mirror")]), more);
    e.check(tree.rays.len() == 1001, || format!("{} rays", tree.rays.len()));
    let mut first = None;
    for ray in &tree.rays {
        let found = ray.hit.as_ref().unwrap();
        let off = DVec3::from_array(found.point).length() - 1.0;
        e.check(off <= 8.0 * lab.u, || format!("bounce {} is outside by {off:e}", ray.id));
        e.check(ray.id == 0 || ray.kind == NodeKind::Reflected, || "no reflection".to_owned());
        let cosine = DVec3::from_array(found.normal).dot(DVec3::from_array(ray.direction));
        e.measure((cosine - *first.get_or_insert(cosine)).abs() / lab.u);
    }
    let (mut p, mut w, mut first) = (o, d.normalize(), None);
    for _ in 0..1000 {
        let Some(t) = naive::sphere(lab, p, w, DVec3::ZERO, 1.0, 1e-4) else { break };
        let n = -naive::point(lab, p, w, t);
        e.twin_measure((n.dot(w) - *first.get_or_insert(n.dot(w))).abs() / lab.u);
        // Pushed away from the surface by a thousandth.
        (p, w) = (naive::add(lab, -n, n * 1e-3), lab.round3(w - 2.0 * n.dot(w) * n));
    }
    e
}
