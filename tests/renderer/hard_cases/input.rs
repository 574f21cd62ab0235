//! I: what a file may say that makes no sense.

use super::Case;
use super::evidence::Evidence;
use super::lab::{Lab, ball, description, hit};
use crate::common::naive;
use glam::DVec3;
use serde_json::{Value, json};

pub const CASES: &[Case] = &[("I01", not_finite), ("I02", sizes), ("I03", image), ("I04", indices), ("I05", subnormal)];

/// Refused, and the problem names the place.
fn refused(lab: &Lab, e: &mut Evidence, text: &str, place: &str) {
    match lab.load_text(text) {
        Ok(_) => e.check(false, || format!("taken: {place}")),
        Err(problems) => {
            let named = problems.0.iter().any(|p| p.pointer.contains(place) || p.line.is_some());
            e.check(named, || format!("{place}: {problems}"));
        }
    }
}

/// A scene's text with a word in place of `"HERE"`.
fn with(object: Value, word: &str) -> String {
    description(json!([object]), json!({})).to_string().replace("\"HERE\"", word)
}

fn not_finite(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("files");
    for word in ["1e999", "-1e999", "NaN", "Infinity", "-Infinity", "nan", "1e16", "-1e300", "1e308"] {
        for object in [
            json!({ "sphere": { "center": ["HERE", 0, 0], "radius": 1 } }),
            json!({ "sphere": { "center": [0, 0, 0], "radius": "HERE" } }),
            json!({ "plane": { "point": [0, 0, 0], "normal": [0, "HERE", 0] } }),
            json!({ "mesh": { "vertices": [[0, 0, 0], [1, 0, 0], [0, "HERE", 0]], "faces": [[0, 1, 2]] } }),
        ] {
            refused(lab, &mut e, &with(object, word), "/objects/0");
        }
        // What a lenient reader makes of it, and a ray from the middle of such a ball.
        let radius: f64 = word.parse().unwrap_or(0.0);
        let roots = naive::sphere_roots(lab, DVec3::ZERO, DVec3::X, DVec3::ZERO, radius);
        e.twin(!roots[1].is_finite());
    }
    e
}

fn sizes(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("files");
    for word in ["0", "-1", "-0.0", "1e-40", "1e-310", "-1e-310", "1e-16"] {
        for object in [
            json!({ "sphere": { "center": [0, 0, 0], "radius": "HERE" } }),
            json!({ "disc": { "center": [0, 0, 0], "normal": [0, 1, 0], "radius": "HERE" } }),
            json!({ "cylinder": { "base": [0, 0, 0], "top": [0, 1, 0], "radius": "HERE" } }),
            json!({ "torus": { "center": [0, 0, 0], "major_radius": 1, "minor_radius": "HERE" } }),
            json!({ "torus": { "center": [0, 0, 0], "major_radius": "HERE", "minor_radius": 0.1 } }),
            json!({ "plane": { "point": [0, 0, 0], "normal": [0, 0, 0] } }),
            json!({ "box": { "min": [0, 0, 0], "max": [1, -1, 1] } }),
        ] {
            refused(lab, &mut e, &with(object, word), "/objects/0");
        }
        let radius: f64 = word.parse().unwrap();
        let normal = naive::normalize(lab, DVec3::new(0.0, 0.0, 1.0) * lab.round(radius) * lab.round(radius));
        e.twin(normal.is_nan() || radius < 0.0);
    }
    e
}

fn image(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("files");
    for (width, height) in [
        ("0", "0"),
        ("0", "5"),
        ("-1", "5"),
        ("65536", "65536"),
        ("4294967295", "4294967295"),
        ("4294967296", "1"),
        ("18446744073709551616", "1"),
        ("1e9", "1"),
        ("16384", "16384"),
        ("1.5", "2"),
    ] {
        let mut scene = description(json!([ball([0.0; 3], 1.0, "red")]), json!({}));
        scene["image"] = json!({ "width": "W", "height": "H" });
        let text = scene.to_string().replace("\"W\"", width).replace("\"H\"", height);
        refused(lab, &mut e, &text, "/image");
        // A buffer whose length is computed in 32 bits, and the last pixel written to it.
        let [w, h] = [width, height].map(|text| text.parse::<f64>().unwrap() as u32);
        let length = w.wrapping_mul(h).wrapping_mul(3);
        if length < 1 << 26 {
            let mut buffer = vec![0u8; length as usize];
            let last = (u64::from(h) * u64::from(w)).wrapping_mul(3).wrapping_sub(1);
            e.twin(buffer.get_mut(last as usize).is_none());
        }
    }
    e
}

fn indices(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("files");
    for faces in [
        "[[0, 1, 3]]",
        "[[0, 1, 4294967295]]",
        "[[0, 1, -1]]",
        "[[0, 1, 1e10]]",
        "[]",
        "[[0, 1]]",
        "[[0, 0, 1]]",
        "[[0, 1, 2.5]]",
    ] {
        let mesh = json!({ "mesh": { "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": "HERE" } });
        refused(lab, &mut e, &with(mesh, faces), "/objects/0/mesh");
    }
    for vertices in ["[]", "[[0, 0, 0]]", "[[0, 0], [1, 0], [0, 1]]"] {
        let mesh = json!({ "mesh": { "vertices": "HERE", "faces": [[0, 1, 2]] } });
        refused(lab, &mut e, &with(mesh, vertices), "/objects/0/mesh");
    }
    let mesh = json!({ "mesh": { "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]], "normals": [[0, 0, 1]] } });
    refused(lab, &mut e, &with(mesh, ""), "/objects/0/mesh/normals");
    // Numbers taken as they come, and vertices looked up: `get` fails where indexing panics.
    let vertices = [DVec3::ZERO, DVec3::X, DVec3::Y];
    for faces in [[0.0, 1.0, 3.0], [0.0, 1.0, 4_294_967_295.0], [0.0, 1.0, -1.0], [0.0, 1.0, 1e10], [0.0, 0.0, 1.0]] {
        let corners = faces.map(|i: f64| vertices.get(i as u32 as usize));
        let normal = match corners {
            [Some(a), Some(b), Some(c)] => naive::normalize(lab, (*b - *a).cross(*c - *a)),
            _ => DVec3::NAN,
        };
        e.twin(normal.is_nan());
    }
    e
}

fn subnormal(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays");
    let scene = lab.scene(json!([ball([0.0; 3], 1.0, "red")]), json!({}));
    let smallest = lab.pick(f64::from(f32::MIN_POSITIVE), f64::MIN_POSITIVE);
    for share in [0.5, 0.25, 1e-3] {
        let tiny = smallest * share;
        for axis in 0..3 {
            let mut unit = DVec3::ZERO;
            unit[axis] = 1.0;
            // A subnormal part is as good as none, and a direction of nothing else is a direction.
            let mut d = -unit;
            d[(axis + 1) % 3] = tiny;
            let found = hit(&scene, unit * 3.0, d);
            let at = found.as_ref().map(|h| (h.t, h.point[axis], h.point[(axis + 2) % 3]));
            e.check(at == Some((2.0, 1.0, 0.0)), || format!("{found:?}"));
            let found = hit(&scene, unit * 3.0, -unit * tiny);
            e.check(found.is_some_and(|h| h.normal == unit.to_array()), || format!("along {tiny:e}"));
            let flushed = if tiny < smallest { 0.0 } else { tiny };
            e.twin(naive::normalize(lab, unit * flushed).is_nan());
        }
    }
    e
}
