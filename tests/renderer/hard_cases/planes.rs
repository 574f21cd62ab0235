//! P: planes.

use super::Case;
use super::evidence::Evidence;
use super::lab::{Lab, ask, ball, description, finite, hit, picture, rows, square, truth, vector};
use super::textbook::tree::{Tree, median};
use super::textbook::{Object, Shape, Tracer};
use crate::common::naive;
use crate::common::{Random, render_as};
use glam::DVec3;
use serde_json::{Value, json};
use strahl::accel::BvhKind;
use strahl::render::RenderOptions;
use strahl::scene::compile::{CompileOptions, compile_with};

pub const CASES: &[Case] = &[
    ("P01", slopes),
    ("P02", parallel),
    ("P03", within),
    ("P04", offset),
    ("P05", eye_on_plane),
    ("P06", coplanar),
    ("P07", opposite),
];

fn floor() -> Value {
    json!([{ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "red" } }])
}

fn slopes(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "plane_grazing", &[]);
    let scene = lab.scene(floor(), json!({}));
    for k in 10..=100 {
        let d = DVec3::new(1.0, -(2f64.powi(-k)), 0.0);
        let found = hit(&scene, DVec3::Y, d);
        e.check(found.as_ref().is_some_and(|h| h.t == 2f64.powi(k) && finite(h)), || format!("2^-{k}: {found:?}"));
        // The usual guard: a cosine below a millionth counts as parallel.
        let twin = naive::guarded_plane(lab, DVec3::Y, d, DVec3::ZERO, DVec3::Y, 1e-6);
        e.twin(twin != Some(2f64.powi(k)));
    }
    e
}

fn parallel(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "plane_grazing", &[]);
    let scene = lab.scene(floor(), json!({}));
    for (x, y) in [(1.0, 0.0), (1.0, -0.0), (-1.0, 0.0), (-1.0, -0.0), (0.25, -0.0)] {
        for height in [1.0, -1.0, 1e-30] {
            let (o, d) = (DVec3::new(3.0, height, 0.0), DVec3::new(x, y, 0.5));
            e.check(hit(&scene, o, d).is_none(), || format!("hit from {o} along {d}"));
            let t = naive::plane(lab, o, d, DVec3::ZERO, DVec3::Y);
            e.twin(t >= 0.0 && !naive::point(lab, o, d, t).is_finite());
        }
    }
    e
}

fn within(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays in the plane");
    let scene = lab.scene(floor(), json!({}));
    let mut random = Random::new(4);
    for y in [0.0, -0.0] {
        for _ in 0..100 {
            let mut o = lab.round3(DVec3::from_array(random.point(9.0)));
            let mut d = lab.round3(DVec3::from_array(random.point(1.0)));
            (o.y, d.y) = (y, y);
            e.check(hit(&scene, o, d).is_none(), || format!("hit from {o} along {d}"));
            let t = naive::plane(lab, o, d, DVec3::ZERO, DVec3::Y);
            // What passes `if t < 0 { return miss }`.
            let misses = t < 0.0;
            e.twin(!misses);
        }
    }
    e
}

fn offset(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(8.0, "u |p - o| / cos");
    for row in rows("plane_far") {
        let (o, d, p) = (vector(&row["ray"]["o"]), vector(&row["ray"]["d"]), vector(&row["shape"]["point"]));
        let normal = vector(&row["shape"]["normal_unnormalised"]);
        let plane = json!({ "plane": { "point": p.to_array(), "normal": normal.to_array() } });
        let number = |key: &str| row["expect"][key].as_f64().unwrap();
        let unit = lab.u * p.distance(o) / number("cos_incidence").abs();
        let off = |t: f64| (t - number("t")).abs() * d.length() / unit;
        e.measure(hit(&lab.scene(json!([plane]), json!({})), o, d).map_or(f64::INFINITY, |h| off(h.t)));
        e.twin_measure(off(naive::plane(lab, o, d, p, lab.round3(normal.normalize()))));
    }
    e
}

fn eye_on_plane(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pixels and rays");
    let objects = json!([floor()[0], ball([0.0, 0.0, -3.0], 1.0, "green")]);
    let more = json!({
        "camera": { "pinhole": { "eye": [0, 0, 0], "look_at": [0, 0, -1], "vfov_deg": 90 } },
        "image": square(32), "background": [0, 0, 1]
    });
    for pixel in lab.picture(objects, more).film.pixels {
        e.check(pixel[0] == 0.0, || "the plane the eye lies in is seen".to_owned());
    }
    // A light in the plane lights none of it.
    let more = json!({
        "camera": { "pinhole": { "eye": [0, 2, 4], "look_at": [0, 0, 0] } }, "image": square(32),
        "lights": [{ "point": { "position": [0, 0, 0] } }]
    });
    let matt = json!([{ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "matt" } }]);
    for pixel in lab.picture(matt, more).film.pixels {
        e.check(pixel == [0.0; 3], || format!("lit by a light in it: {pixel:?}"));
    }
    let mut random = Random::new(5);
    for _ in 0..200 {
        let d = lab.round3(DVec3::from_array(random.point(1.0)));
        e.twin(naive::plane(lab, DVec3::ZERO, d, DVec3::ZERO, DVec3::Y) >= 0.0);
    }
    e
}

/// Two quads in one plane, red before green, and a ball of each color in one place.
fn coincident(order: [&str; 2]) -> Value {
    let quad = |material: &str| json!({ "quad": { "vertices": [[-2, -1, 1], [2, -1, 1], [2, 1, -1], [-2, 1, -1]], "material": material } });
    let smaller = |material: &str| json!({ "quad": { "vertices": [[-1, -3, 3], [5, -3, 3], [5, -1.5, 1.5], [-1, -1.5, 1.5]], "material": material } });
    let sphere = |material: &str| ball([0.0, 2.0, 0.0], 0.8, material);
    let mut objects = Vec::new();
    for material in order {
        objects.extend([quad(material), smaller(material), sphere(material)]);
    }
    json!(objects)
}

/// Bytes of a scene by each hierarchy and cut.
pub fn pictures(lab: &Lab, scene: &Value) -> Vec<Vec<[f32; 3]>> {
    let loaded = lab.load(scene).unwrap_or_else(|p| panic!("{p}"));
    let mut films = Vec::new();
    for bvh in [BvhKind::Flat, BvhKind::Sah, BvhKind::Median] {
        let options = CompileOptions { bvh, ..CompileOptions::default() };
        films.push(picture(&compile_with(&loaded.description, options).unwrap()).film.pixels);
    }
    for tile in [1, 7] {
        films.push(render_as(&loaded, RenderOptions { tile, ..RenderOptions::default() }).pixels);
    }
    films
}

fn coplanar(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pictures and pixels");
    let more = json!({ "camera": { "pinhole": { "eye": [0.3, 0.7, 7], "look_at": [0, 0, 0] } }, "image": square(40) });
    for (order, channel) in [(["red", "green"], 0), (["green", "red"], 1)] {
        let films = pictures(lab, &description(coincident(order), more.clone()));
        for film in &films[1..] {
            e.check(*film == films[0], || "a hierarchy or a cut changes the picture".to_owned());
        }
        for pixel in &films[0] {
            e.check(pixel[1 - channel] == 0.0, || "what was written last is seen".to_owned());
        }
    }
    let quad = |c: [[f64; 3]; 4], glow: f64| {
        let [a, b, c, d] = c.map(DVec3::from_array);
        [[a, b, c], [a, c, d]].map(|t| Object::seen(Shape::Triangle(t), glow))
    };
    let mut objects = Vec::new();
    for glow in [1.0, 2.0] {
        objects.extend(quad([[-2.0, -1.0, 1.0], [2.0, -1.0, 1.0], [2.0, 1.0, -1.0], [-2.0, 1.0, -1.0]], glow));
        objects.extend(quad([[-1.0, -3.0, 3.0], [5.0, -3.0, 3.0], [5.0, -1.5, 1.5], [-1.0, -1.5, 1.5]], glow));
        objects.push(Object::seen(Shape::Sphere(DVec3::Y * 2.0, 0.8), glow));
    }
    twin_of_ties(lab, &mut e, &objects, DVec3::new(0.3, 0.7, 7.0));
    e
}

/// The objects seen from `eye` by a plain loop and through a naive hierarchy: of equal distances the first one met
/// counts, so that the hierarchy and the ray's direction decide which of two objects in one place is seen.
pub fn twin_of_ties(lab: &Lab, e: &mut Evidence, objects: &[Object], eye: DVec3) {
    let tree = Tree::of(objects, median, 100).unwrap();
    let plain = Tracer::new(lab, objects.to_vec());
    let mut differing = 0;
    for k in 0..40 * 40 {
        let at = |k: i32| (f64::from(k) + 0.5) / 20.0 - 1.0;
        let d = lab.round3(DVec3::new(2.4 * at(k % 40), 2.4 * at(k / 40), 0.0) - eye);
        let [a, b] = [plain.nearest(eye, d).map(|h| h.1), tree.nearest(lab, objects, eye, d).0];
        differing += usize::from(a.map(|i| objects[i].glow) != b.map(|i| objects[i].glow));
    }
    e.twin(differing > 0);
}

fn opposite(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pixels");
    let plane = |up: f64, material: &str| json!({ "plane": { "point": [0, 0, 0], "normal": [0, up, 0], "material": material } });
    let more = json!({
        "camera": { "pinhole": { "eye": [0, 2, 4], "look_at": [0, 0, 0] } }, "image": square(24), "background": [0, 0, 1]
    });
    let [mirror, glow] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]].map(|c| c.map(|x: f64| x as f32));
    for (up, first) in [(1.0, mirror), (-1.0, mirror), (1.0, glow), (-1.0, glow)] {
        let (a, b) = if first == mirror { ("mirror", "red") } else { ("red", "mirror") };
        for pixel in lab.picture(json!([plane(up, a), plane(-up, b)]), more.clone()).film.pixels {
            e.check(pixel == first, || format!("{a} before {b}: {pixel:?}"));
        }
        let shape = |up: f64| Shape::Plane(DVec3::ZERO, DVec3::Y * up);
        twin_of_ties(
            lab,
            &mut e,
            &[Object::seen(shape(up), 1.0), Object::seen(shape(-up), 2.0)],
            DVec3::new(0.0, 2.0, 4.0),
        );
    }
    e
}
