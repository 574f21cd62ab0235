//! B: bounding boxes and hierarchies.

use super::Case;
use super::evidence::Evidence;
use super::lab::{Lab, ask, ball, description, direction, hit, rows, square, truth, vector};
use super::planes::{pictures, twin_of_ties};
use super::textbook::tree::{Tree, areas, median, middle};
use super::textbook::{Object, Shape};
use crate::common::Random;
use crate::common::naive;
use crate::common::wide::Wide;
use glam::DVec3;
use serde_json::{Value, json};
use std::time::Instant;
use strahl::accel::BvhKind;
use strahl::inspect::query::{RayQuery, answer};
use strahl::scene::Scene;
use strahl::scene::compile::{CompileOptions, compile_with};

pub const CASES: &[Case] = &[
    ("B01", slab_nan),
    ("B02", flat),
    ("B03", rounding),
    ("B04", bad_rays),
    ("B05", huge),
    ("B06", few),
    ("B07", order),
];

pub fn cuboid(low: DVec3, high: DVec3) -> Value {
    json!({ "box": { "min": low.to_array(), "max": high.to_array(), "material": "red" } })
}

fn slab_nan(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "aabb_slab_nan", &[]);
    for row in rows("aabb_slab_nan") {
        let (o, d) = (vector(&row["ray"]["o"]), vector(&row["ray"]["d"]));
        let found = naive::slab(lab, o, d, vector(&row["shape"]["lo"]), vector(&row["shape"]["hi"]), false);
        e.twin(row["expect"]["hit_closed_box"] == true && !found);
    }
    e
}

/// A sheet of triangles at height y, n by n squares.
fn sheet(lab: &Lab, n: usize, y: f64) -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let mut random = Random::new(12);
    let at = |k: usize, random: &mut Random| k as f64 + random.between(-0.3, 0.3);
    let mut vertices = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            vertices.push(lab.round3(DVec3::new(at(i, &mut random) / 3.0, y, at(j, &mut random) / 3.0)));
        }
    }
    let corner = |i: usize, j: usize| i * (n + 1) + j;
    let faces = (0..n * n).flat_map(|k| {
        let (i, j) = (k / n, k % n);
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        [[a, c, b], [a, d, c]]
    });
    (vertices, faces.collect())
}

fn flat(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays at inner vertices of flat sheets");
    let n = 20;
    for y in [0.1, 77.7] {
        let (vertices, faces) = sheet(lab, n, lab.round(y));
        let points: Vec<[f64; 3]> = vertices.iter().map(|v| v.to_array()).collect();
        let scene = lab.scene(json!([{ "mesh": { "vertices": points, "faces": faces } }]), json!({}));
        let mut random = Random::new(13);
        for (k, aim) in vertices.iter().enumerate() {
            if k / (n + 1) % n == 0 || k % (n + 1) % n == 0 {
                continue;
            }
            for _ in 0..8 {
                let o = lab.round3(*aim + DVec3::new(random.between(-2.0, 2.0), 3.0, random.between(-2.0, 2.0)));
                let d = lab.round3(*aim - o);
                e.check(hit(&scene, o, d).is_some(), || format!("from {o} along {d}"));
                let mut around = faces.iter().filter(|face| face.contains(&k)).map(|face| face.map(|i| vertices[i]));
                let met = around.any(|t| {
                    let (low, high) = (t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2]));
                    naive::slab(lab, o, d, low, high, false) && naive::woop(lab, o, d, t, false)
                });
                e.twin(!met);
            }
        }
    }
    e
}

/// A description's scene by one hierarchy.
fn by(lab: &Lab, scene: &Value, bvh: BvhKind) -> Scene {
    let loaded = lab.load(scene).unwrap_or_else(|p| panic!("{p}"));
    compile_with(&loaded.description, CompileOptions { bvh, ..CompileOptions::default() }).unwrap()
}

fn rounding(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays by hierarchy and by brute force");
    let mut random = Random::new(14);
    for (scale, offset) in [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1e4), (1.0, 148_376.0)] {
        let mut place =
            || lab.round3((DVec3::from_array(random.point(5.0)) + DVec3::new(offset, offset * 0.3, -offset)) * scale);
        let mut aims = Vec::new();
        let objects: Vec<Value> = (0..150)
            .map(|i| {
                let p = place();
                aims.push(p);
                match i % 3 {
                    0 => ball(p.into(), 0.3 * scale, "red"),
                    1 => cuboid(p, lab.round3(p + DVec3::splat(0.4 * scale))),
                    _ => {
                        let corners =
                            [p, p + DVec3::new(0.3, 0.4, 0.1) * scale, p + DVec3::new(-0.2, 0.5, 0.3) * scale];
                        json!({ "triangle": { "vertices": corners.map(|c| lab.round3(c).to_array()) } })
                    }
                }
            })
            .collect();
        let scene = description(json!(objects), json!({}));
        let scenes = [BvhKind::Flat, BvhKind::Sah, BvhKind::Median].map(|bvh| by(lab, &scene, bvh));
        for _ in 0..1500 {
            let o = place();
            let aim = aims[random_below(&mut aims.len(), &o)];
            let d = lab.round3(aim - o);
            if d == DVec3::ZERO {
                continue;
            }
            let [brute, sah, median] = scenes.each_ref().map(|s| hit(s, o, d).map(|h| (h.t, h.object)));
            e.check(brute == sah && brute == median, || format!("{brute:?}, {sah:?}, {median:?} from {o} along {d}"));
        }
    }
    // A ray through the middle of a small box far away; the quotients multiplied out say otherwise.
    let mut random = Random::new(15);
    let size = 2e4 * lab.u;
    for _ in 0..20_000 {
        let low = lab.round3(DVec3::from_array(random.point(5.0)) + DVec3::new(1e4, 3e3, -1e4));
        let high = lab.round3(low + DVec3::splat(size));
        let o = lab.round3(DVec3::from_array(random.point(10.0)));
        let d = lab.round3((low + (high - low) * random.between(0.0, 1.0) - o) / 2000.0);
        let through = (0..3).all(|i| {
            let at = Wide::of(o[i]) + Wide::of(d[i]) * Wide::of(2000.0);
            let share = (at - Wide::of(low[i])).value() / (high[i] - low[i]);
            (0.01..0.99).contains(&share)
        });
        if through {
            e.twin(!naive::slab(lab, o, d, low, high, true));
        }
    }
    e
}

/// A number below `n` that depends on a point.
fn random_below(n: &mut usize, p: &DVec3) -> usize {
    (p.x.to_bits() ^ p.y.to_bits().rotate_left(21) ^ p.z.to_bits().rotate_left(42)) as usize % *n
}

fn bad_rays(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(2.5, "times the time of a sound ray");
    let mut random = Random::new(16);
    let balls: Vec<[f64; 3]> = (0..4000).map(|_| random.point(10.0)).collect();
    let objects: Vec<Value> = balls.iter().map(|p| ball(*p, 0.3, "red")).collect();
    let scene = lab.scene(json!(objects), json!({}));
    let rays = |o: [f64; 3], d: [f64; 3], t_max: Option<f64>| {
        let query = RayQuery { origin: o, direction: d, t_min: 0.0, t_max };
        let mut best = f64::INFINITY;
        for _ in 0..7 {
            let start = Instant::now();
            for _ in 0..300 {
                std::hint::black_box(answer(&scene, std::hint::black_box(&query)));
            }
            best = best.min(start.elapsed().as_secs_f64());
        }
        (best, answer(&scene, &query).at)
    };
    let (sound, _) = rays([0.1, 0.2, 30.0], [0.01, 0.02, -1.0], None);
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    for (o, d, t_max) in [
        ([nan, 0.0, 0.0], [0.0, 0.0, -1.0], None),
        ([inf, 0.0, 0.0], [0.0, 0.0, -1.0], None),
        ([0.0, -inf, 9.0], [0.0, 1.0, -1.0], None),
        ([0.1, 0.2, 30.0], [nan, 0.0, -1.0], None),
        ([0.1, 0.2, 30.0], [nan; 3], None),
        ([0.1, 0.2, 30.0], [inf, 0.0, -1.0], None),
        ([0.1, 0.2, 30.0], [0.0; 3], None),
        ([0.1, 0.2, 30.0], [0.01, 0.02, -1.0], Some(nan)),
        ([0.1, 0.2, 30.0], [0.01, 0.02, -1.0], Some(-inf)),
    ] {
        let (time, found) = rays(o, d, t_max);
        e.check(found.is_none(), || format!("{o:?} along {d:?} up to {t_max:?} hits {found:?}"));
        e.measure(time / sound);
    }
    // The naive hierarchy, counted instead of timed: a comparison with NaN rejects no box, so that all are opened.
    let list: Vec<Object> =
        balls.iter().map(|p| Object::seen(Shape::Sphere(DVec3::from_array(*p), 0.3), 1.0)).collect();
    let tree = Tree::of(&list, median, 100).unwrap();
    let asked = |o: [f64; 3], d: [f64; 3]| tree.nearest(lab, &list, o.into(), d.into()).1 as f64;
    let sound = asked([0.1, 0.2, 30.0], [0.01, 0.02, -1.0]);
    for (o, d) in [([nan; 3], [0.0, 0.0, -1.0]), ([0.1, 0.2, 30.0], [nan; 3])] {
        e.twin_measure(asked(o, d) / sound);
    }
    e
}

fn huge(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays and pictures");
    let mut random = Random::new(17);
    let mut objects: Vec<Value> = (0..200).map(|_| ball(random.point(4.0), 0.3, "red")).collect();
    objects.push(json!({ "plane": { "point": [0, -5, 0], "normal": [0.1, 1, 0], "material": "green" } }));
    objects.push(json!({ "plane": { "point": [0, 9e14, 0], "normal": [0, -1, 0], "material": "green" } }));
    objects.push(cuboid(DVec3::splat(-1e15), DVec3::splat(1e15)));
    objects.push(ball([0.0, 0.0, -5e14], 1e14, "green"));
    let scene = description(json!(objects), json!({}));
    let scenes = [BvhKind::Flat, BvhKind::Sah, BvhKind::Median].map(|bvh| by(lab, &scene, bvh));
    for _ in 0..2000 {
        let (o, d) = (lab.round3(DVec3::from_array(random.point(9.0))), direction(&mut random));
        let [a, b, c] = scenes.each_ref().map(|s| hit(s, o, d).map(|h| (h.t, h.object)));
        e.check(a.is_some() && a == b && a == c, || format!("{a:?}, {b:?}, {c:?}"));
    }
    // Surface areas with an infinite box among them: every cost is infinity over infinity, so that nothing is ever cut
    // and each ray asks every object.
    let mut bodies: Vec<Object> =
        (0..200).map(|_| Object::seen(Shape::Sphere(DVec3::from_array(random.point(4.0)), 0.3), 1.0)).collect();
    let finite = Tree::of(&bodies, areas, 200).unwrap();
    bodies.push(Object::seen(Shape::Plane(DVec3::Y * -5.0, DVec3::new(0.1, 1.0, 0.0)), 1.0));
    let infinite = Tree::of(&bodies, areas, 200).unwrap();
    for _ in 0..200 {
        let (o, d) = (lab.round3(DVec3::from_array(random.point(9.0))), direction(&mut random));
        let [without, with] = [&finite, &infinite].map(|tree| tree.nearest(lab, &bodies, o, d).1);
        e.twin(with > 200 && without < 100);
    }
    e
}

fn few(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("scenes");
    let one = lab.scene(json!([ball([0.0; 3], 1.0, "red")]), json!({}));
    e.check(hit(&one, DVec3::Z * 3.0, -DVec3::Z).is_some(), || "one".to_owned());
    e.check(lab.load(&description(json!([]), json!({}))).is_err(), || "no objects are taken".to_owned());
    let empty = lab.load(&description(json!([{ "group": { "objects": [] } }]), json!({})));
    e.check(empty.is_err() || empty.is_ok_and(|l| hit(&l.scene, DVec3::Z, -DVec3::Z).is_none()), || {
        "an empty group".to_owned()
    });
    let same: Vec<Value> = (1..=2000).map(|i| ball([1.0, 2.0, 3.0], f64::from(i) * 1e-3, "red")).collect();
    let found = hit(&lab.scene(json!(same), json!({})), DVec3::new(1.0, 2.0, 9.0), -DVec3::Z);
    e.check(found.is_some_and(|h| h.object == "/objects/1999"), || "equal centres".to_owned());
    let equal = vec![ball([0.0; 3], 1.0, "red"); 3000];
    let found = hit(&lab.scene(json!(equal), json!({})), DVec3::Z * 9.0, -DVec3::Z);
    e.check(found.is_some_and(|h| h.object == "/objects/0"), || "equal objects".to_owned());
    // A builder that cuts at the middle of the centres does not end; here it is stopped 1000 levels deep.
    let equal = vec![Object::seen(Shape::Sphere(DVec3::ZERO, 1.0), 1.0); 3000];
    e.twin(Tree::of(&equal, middle, 1000).is_none());
    e
}

fn order(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pictures");
    let mut random = Random::new(18);
    let (mut objects, mut twins) = (Vec::new(), Vec::new());
    for i in 0..60 {
        let (p, material) = (random.point(2.0), ["red", "green", "glass", "mirror"][i % 4]);
        let other = ["green", "red", "mirror", "glass"][i % 4];
        let corners = [p, random.point(2.0), random.point(2.0)];
        for (material, glow) in [(material, 1.0), (other, 2.0)] {
            twins.push(Object::seen(Shape::Sphere(p.into(), 0.3), glow));
            twins.push(Object::seen(Shape::Triangle(corners.map(DVec3::from_array)), glow));
            objects.push(ball(p, 0.3, material));
            objects.push(json!({ "triangle": { "vertices": corners, "material": material } }));
        }
    }
    let more = json!({ "image": square(40), "background": [0.2, 0.3, 0.9] });
    let films = pictures(lab, &description(json!(objects), more));
    for film in &films[1..] {
        e.check(*film == films[0], || "a hierarchy or a cut changes the picture".to_owned());
    }
    twin_of_ties(lab, &mut e, &twins, DVec3::Z * 5.0);
    e
}
