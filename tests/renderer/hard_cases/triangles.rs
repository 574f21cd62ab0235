//! T, single triangles: small, thin, empty, seen from the edge, in pairs and in great number.

use super::Case;
use super::evidence::Evidence;
use super::lab::{Lab, ask, description, direction, finite, hit, hit_within, rows, square, truth, vector};
use super::textbook::tree::{Tree, middle};
use super::textbook::{Object, Shape};
use crate::common::Random;
use crate::common::naive;
use glam::DVec3;
use serde_json::{Value, json};
use strahl::inspect::tree::NodeKind;

pub const CASES: &[Case] = &[
    ("T05", zeros),
    ("T07", tiny),
    ("T08", needle),
    ("T09", degenerate),
    ("T10", edge_on),
    ("T11", ends),
    ("T14", quads),
    ("T15", identical),
    ("T18", facing_away),
    ("T19", odd_normals),
];

fn triangle(corners: [DVec3; 3]) -> Value {
    json!({ "triangle": { "vertices": corners.map(|c| c.to_array()), "material": "red" } })
}

fn zeros(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays with 0, -0 and subnormal components");
    for axis in 0..3 {
        let turn = |v: [f64; 3]| DVec3::from_array(std::array::from_fn(|i| v[(i + axis) % 3]));
        let corners = [[0.0, -1.0, -1.0], [0.0, 2.0, -1.0], [0.0, -1.0, 2.0]].map(turn);
        let scene = lab.scene(json!([triangle(corners)]), json!({}));
        for small in [0.0, -0.0, 1e-40, -1e-40, 1e-45, 1e-310] {
            for other in [0.0, -0.0, -1e-42] {
                let (o, d) = (turn([-2.0, 0.25, 0.125]), turn([1.0, small, other]));
                let found = hit(&scene, o, d);
                e.check(found.as_ref().is_some_and(|h| h.t == 2.0 && finite(h)), || format!("along {d}: {found:?}"));
                // Always sheared along z.
                e.twin(!naive::woop_along(lab, o, d, corners, false, 2));
            }
        }
    }
    e
}

fn tiny(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "tri_tiny", &[]);
    for row in rows("tri_tiny") {
        let corners = std::array::from_fn(|i| vector(&row["shape"]["tris"][0][i]));
        e.twin(naive::triangle(lab, vector(&row["ray"]["o"]), vector(&row["ray"]["d"]), corners, 1e-6).is_none());
    }
    e
}

fn needle(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(64.0, "u of the needle's length, off its line");
    let mut random = Random::new(9);
    for _ in 0..40 {
        let (along, across) = (direction(&mut random), direction(&mut random));
        let across = along.cross(across).normalize();
        let base = lab.round3(DVec3::from_array(random.point(100.0)));
        let corners = [base, lab.round3(base + along * 1e4), lab.round3(base + across * lab.pick(0.1, 1e-6))];
        let scene = lab.scene(json!([triangle(corners)]), json!({}));
        let mut met = 0;
        for _ in 0..200 {
            let b = random.between(0.1, 0.8);
            let aim = corners[0] * (1.0 - b - 0.1) + corners[1] * b + corners[2] * 0.1;
            let o = lab.round3(aim + direction(&mut random) * 50.0);
            let d = lab.round3(aim - o);
            let off_line = |p: DVec3| (p - base).cross(along).length() - across.length() * lab.pick(0.1, 1e-6);
            if let Some(found) = hit(&scene, o, d) {
                met += 1;
                e.check(finite(&found), || format!("{found:?}"));
                e.measure(off_line(DVec3::from_array(found.point)) / (1e4 * lab.u));
                let length = DVec3::from_array(found.normal).length();
                e.check((length - 1.0).abs() < 8.0 * lab.u, || format!("a normal of length {length}"));
            }
            if let Some([t, u, v]) = naive::triangle(lab, o, d, corners, 0.0) {
                // The weights, and the point they make, as far along the needle as the ray is.
                let of_weights = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
                e.twin_measure(of_weights.distance(naive::point(lab, o, d, t)) / (1e4 * lab.u));
            }
        }
        e.check(met > 0, || "a needle is never met".to_owned());
    }
    e
}

fn degenerate(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "tri_degenerate", &[]);
    for corners in [[DVec3::ZERO; 3], [DVec3::ZERO, DVec3::X, DVec3::X], [DVec3::ZERO, DVec3::X, DVec3::X * 2.0]] {
        let scene = description(json!([triangle(corners)]), json!({}));
        e.check(lab.load(&scene).is_err(), || format!("taken: {corners:?}"));
        let found = naive::triangle(lab, DVec3::new(0.5, 0.0, 1.0), -DVec3::Z, corners, 0.0);
        e.twin(found.is_some_and(|[t, ..]| !t.is_finite()));
    }
    e
}

fn edge_on(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays in a triangle's plane");
    let mut random = Random::new(10);
    for _ in 0..60 {
        let corners: [DVec3; 3] = std::array::from_fn(|_| lab.round3(DVec3::from_array(random.point(1.0))));
        let scene = lab.scene(json!([triangle(corners)]), json!({}));
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        for _ in 0..200 {
            let within = (corners[1] - corners[0]) * random.between(-1.0, 1.0)
                + (corners[2] - corners[0]) * random.between(-1.0, 1.0);
            let o = lab.round3(middle + within.normalize() * 8.0);
            let d = lab.round3(middle - o);
            // Depth is measured along the longest axis.
            let k = d.abs().max_position();
            let ts = corners.map(|c| (c[k] - o[k]) / d[k]);
            let (near, far) =
                (ts.iter().copied().fold(f64::INFINITY, f64::min), ts.iter().copied().fold(0.0, f64::max));
            let inside = |t: f64| t >= near - 0.01 && t <= far + 0.01;
            if let Some(found) = hit(&scene, o, d) {
                e.check(finite(&found) && inside(found.t), || {
                    format!("t = {} of {near} to {far}; {corners:?} from {o} along {d}", found.t)
                });
            } else {
                e.check(true, String::new);
            }
            if let Some([t, ..]) = naive::triangle(lab, o, d, corners, 0.0) {
                e.twin(!inside(t));
            }
        }
    }
    e
}

fn ends(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("ends of rays");
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let scene = lab.scene(json!([triangle(corners)]), json!({}));
    let next = 1.0 + 2.0 * lab.u;
    for corner in corners {
        let o = corner + DVec3::Z;
        let t = |low: f64, high: Option<f64>| hit_within(&scene, o, -DVec3::Z, low, high).map(|h| h.t);
        e.check(t(0.0, None) == Some(1.0), || "not met".to_owned());
        e.check(t(0.0, Some(1.0)).is_none(), || "met at the very end".to_owned());
        e.check(t(0.0, Some(next)) == Some(1.0), || "not met just before the end".to_owned());
        e.check(t(1.0, None).is_none(), || "met at the very start".to_owned());
        e.check(t(1.0 - lab.u, None) == Some(1.0), || "not met just after the start".to_owned());
        for d in [-DVec3::Z, DVec3::Z, DVec3::new(0.3, 0.2, -0.7)] {
            e.check(hit(&scene, corner, d).is_none(), || format!("met where it starts, along {d}"));
            e.twin(naive::triangle(lab, corner, d, corners, 0.0).is_some_and(|[t, ..]| t >= 0.0));
        }
    }
    e
}

fn quads(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays at quads");
    let mut random = Random::new(11);
    for _ in 0..10 {
        for warp in [0.0, 0.5] {
            let place = DVec3::from_array(random.point(5.0));
            let (a, b) = (direction(&mut random), direction(&mut random));
            let normal = a.cross(b);
            let corners = [place, place + a, place + a + b + normal * warp, place + b].map(|v| lab.round3(v));
            let quad = json!([{ "quad": { "vertices": corners.map(|c| c.to_array()) } }]);
            let halves = [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]];
            let whole = lab.scene(quad, json!({}));
            let parts = lab.scene(json!(halves.map(triangle)), json!({}));
            for i in 0..400 {
                let k = random.between(0.05, 0.95);
                let on_diagonal = corners[0] + (corners[2] - corners[0]) * k;
                let aside =
                    if i % 2 == 0 { DVec3::ZERO } else { (corners[1] - on_diagonal) * random.between(0.0, 0.9) };
                let o = lab.round3(place + normal.normalize() * 7.0 + DVec3::from_array(random.point(0.5)));
                let d = lab.round3(on_diagonal + aside - o);
                let [t, halved] = [&whole, &parts].map(|s| hit(s, o, d).map(|h| h.t));
                e.check(t.is_some() && t == halved, || format!("{t:?} and {halved:?}"));
                e.twin(halves.iter().all(|h| naive::triangle(lab, o, d, *h, 0.0).is_none()));
            }
        }
    }
    e
}

fn identical(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays at 300,000 triangles in one place");
    let faces = vec![[0, 1, 2]; 300_000];
    let mesh = json!({ "mesh": { "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": faces } });
    let scene = lab.scene(json!([mesh]), json!({}));
    for x in [0.1, 0.3, 0.45] {
        let found = hit(&scene, DVec3::new(x, x, 1.0), -DVec3::Z);
        e.check(found.is_some_and(|h| h.t == 1.0), || format!("not met at {x}"));
    }
    // A builder that cuts at the middle of the centres does not end; here it is stopped 1000 levels deep.
    let triangle = Shape::Triangle([DVec3::ZERO, DVec3::X, DVec3::Y]);
    e.twin(Tree::of(&vec![Object::seen(triangle, 1.0); 3000], middle, 1000).is_none());
    e
}

/// Triangles whose corners' normals lean far over.
fn leaning(normals: Value) -> Value {
    json!([{ "mesh": { "vertices": [[-1, 0, -1], [1, 0, -1], [0, 0, 1]], "faces": [[0, 2, 1]], "normals": normals, "material": "mirror" } }])
}

fn facing_away(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("mirrored rays");
    let lean = DVec3::new(1.0, 0.3, 0.0);
    for i in 1..40 {
        let angle = f64::from(i) * 2.0;
        let (sin, cos) = strahl::math::sin_cos(angle.to_radians());
        for side in [1.0, -1.0] {
            let d = DVec3::new(side * sin, -cos, 0.0);
            let normals = json!(vec![lean.to_array(); 3]);
            let tree = lab.tree(-d * 2.0, d, leaning(normals), json!({}));
            let mirrored = tree.rays.iter().find(|r| r.kind == NodeKind::Reflected);
            let up = mirrored.map_or(f64::NAN, |r| r.direction[1]);
            e.check(up > 0.0, || format!("{angle} degrees: the mirrored ray goes {up}"));
            let n = lean.normalize();
            e.twin((d - 2.0 * d.dot(n) * n).y <= 0.0);
        }
    }
    e
}

fn odd_normals(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("refusals and pixels");
    let refused = description(leaning(json!([[0, 0, 0], [0, 1, 0], [0, 1, 0]])), json!({}));
    e.check(lab.load(&refused).is_err(), || "a normal without a direction is taken".to_owned());
    // Normals that cancel halfway between two corners.
    let more = json!({
        "camera": { "orthographic": { "eye": [0, 3, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "height": 2 } },
        "image": square(33), "background": 1, "lights": [{ "directional": { "direction": [0.1, -1, 0] } }]
    });
    for normals in [
        json!([[1, 0, 0], [-1, 0, 0], [0, 1, 0]]),
        json!([[1, 0, 0], [-1, 0, 0], [0, -1, 0]]),
        json!([[0, 1, 0], [0, -1, 0], [1e-15, 0, 0]]),
    ] {
        for pixel in lab.picture(leaning(normals), more.clone()).film.pixels {
            e.check(pixel.iter().all(|c| c.is_finite()), || format!("a pixel is {pixel:?}"));
        }
    }
    e.twin(!naive::normalize(lab, DVec3::X * 0.5 + DVec3::NEG_X * 0.5).is_finite());
    e
}
