//! E: lights, highlights and sums beyond the format.

use super::Case;
use super::evidence::Evidence;
use super::lab::{Lab, ask, ball, description, from_front, picture, square, truth};
use super::textbook::{Object, Shape, Tracer};
use crate::common::naive;
use glam::DVec3;
use serde_json::{Value, json};
use strahl::film::{FileFormat, encode};
use strahl::math::pow;

pub const CASES: &[Case] = &[
    ("E04", beyond_one),
    ("E05", odd_powers),
    ("E06", light_on_point),
    ("E07", terminator),
    ("E08", light_on_surface),
    ("E09", wall_near_light),
    ("E10", overflow),
];

fn beyond_one(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "phong_exponent", &[]);
    let base = 1.0 + 2.0 * lab.u;
    e.twin(pow(base, 1e6) > 1.0);
    e
}

/// A floor seen from above under one light.
fn floor(material: Value, light: Value) -> Value {
    description(
        json!([{ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor" } }]),
        json!({
            "camera": { "orthographic": { "eye": [0, 4, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "height": 2 } },
            "image": square(33), "materials": { "floor": material }, "lights": [light]
        }),
    )
}

fn pixels(lab: &Lab, scene: &Value) -> Vec<[f32; 3]> {
    picture(&lab.load(scene).unwrap_or_else(|p| panic!("{p}")).scene).film.pixels
}

fn odd_powers(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "phong_exponent", &[]);
    for shininess in [0.0, 0.5, 1.0, 1e6] {
        let shiny = json!({ "ambient": 0, "diffuse": 0, "specular": 1, "shininess": shininess });
        for x in [-5.0, 0.0, 5.0] {
            for pixel in pixels(lab, &floor(shiny.clone(), json!({ "point": { "position": [x, 0.5, 0] } }))) {
                e.check(pixel.iter().all(|c| (0.0..=1.0).contains(c)), || format!("m = {shininess}: {pixel:?}"));
            }
        }
    }
    e.twin(pow(-0.25, 0.5).is_nan());
    e
}

fn light_on_point(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pixels");
    let shiny = json!({ "ambient": 0, "diffuse": 0.8, "specular": 0.5 });
    for height in [0.0, 1e-40, 1e-15, 1e-10, 1e-5] {
        for falloff in [json!("inverse_square"), json!("none"), json!({ "linear": { "reach": 1 } })] {
            let light = json!({ "point": { "position": [0, height, 0], "falloff": falloff } });
            for pixel in pixels(lab, &floor(shiny.clone(), light)) {
                e.check(pixel.iter().all(|c| c.is_finite() && *c >= 0.0), || {
                    format!("{height:e}, {falloff}: {pixel:?}")
                });
            }
        }
    }
    let d = DVec3::ZERO;
    e.twin(!(naive::normalize(lab, d) * (1.0 / d.length_squared())).is_finite());
    e
}

fn terminator(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pixels at the border of light");
    let shiny = json!({ "ambient": 0, "diffuse": 0, "specular": 1, "shininess": 1 });
    for slope in [0.0, -0.0, 2f64.powi(-50), 2f64.powi(-20), 0.1] {
        // Light along the floor or from below it.
        let light = json!({ "directional": { "direction": [1, slope, 0] } });
        for pixel in pixels(lab, &floor(shiny.clone(), light)) {
            e.check(pixel == [0.0; 3], || format!("slope {slope}: {pixel:?}"));
        }
        // (R.V)^m without a look at n.l.
        let to_light = DVec3::new(-1.0, -slope, 0.0).normalize();
        let mirrored = 2.0 * to_light.y * DVec3::Y - to_light;
        e.twin(mirrored.dot(DVec3::new(1.0, 1.0, 0.0)) > 0.0);
    }
    // Across a ball light falls without a step back up.
    let more = json!({
        "camera": from_front([0.0; 3], 4.0, 2.0), "image": { "width": 201, "height": 1 },
        "lights": [{ "directional": { "direction": [-1, 0, 0] } }]
    });
    let mut more = more;
    more["camera"]["orthographic"]["height"] = json!(2.0 / 201.0);
    let row = lab.picture(json!([ball([0.0; 3], 1.0, "matt")]), more).film.pixels;
    for pair in row.windows(2).take(195).skip(5) {
        e.check(pair[0][0] <= pair[1][0], || format!("light falls from {:?} to {:?}", pair[0], pair[1]));
    }
    e
}

fn light_on_surface(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pixels");
    for height in [1.0, 0.1, 1.0 / 3.0, 77.7] {
        let mut scene =
            floor(json!({ "ambient": 0, "diffuse": 0.8 }), json!({ "point": { "position": [0.1, height, 0.2] } }));
        // Seen from between the floor and the ceiling that the light touches.
        scene["camera"]["orthographic"]["eye"] = json!([0, height / 2.0, 0]);
        let ceiling = json!({ "plane": { "point": [0, height, 0], "normal": [0, -1, 0] } });
        scene["objects"].as_array_mut().unwrap().push(ceiling);
        let all = pixels(lab, &scene);
        let lit = all.iter().filter(|p| p[0] > 0.0).count();
        e.check(lit == all.len(), || format!("ceiling at {height}: {lit} of {} pixels are lit", all.len()));
        // A shadow ray that ends at t <= 1.
        let mut shadowed = [0, 0];
        for i in 0..200 {
            let p = lab.round3(DVec3::new(f64::from(i) * 0.017 - 1.7, 0.0, 0.3));
            let d = lab.round3(DVec3::new(0.1, height, 0.2) - p);
            let normal = lab.round3(DVec3::new(0.01, -1.0, 0.02).normalize());
            let t = naive::plane(lab, p, d, lab.round3(DVec3::new(0.1, height, 0.2)), normal);
            shadowed[usize::from(t <= 1.0)] += 1;
        }
        e.twin(shadowed[0] > 0 && shadowed[1] > 0);
    }
    e
}

fn wall_near_light(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pixels");
    let light = 2.0;
    for k in (4..lab.pick(18, 46)).step_by(2) {
        let gap = 2f64.powi(-k);
        for (wall, lit) in [(light + gap, true), (light - gap, false)] {
            let mut scene =
                floor(json!({ "ambient": 0, "diffuse": 0.8 }), json!({ "point": { "position": [0, light, 0] } }));
            scene["camera"]["orthographic"]["eye"] = json!([0, 1, 0]);
            let ceiling = json!({ "plane": { "point": [0, wall, 0], "normal": [0, -1, 0] } });
            scene["objects"].as_array_mut().unwrap().push(ceiling);
            for pixel in pixels(lab, &scene) {
                e.check((pixel[0] > 0.0) == lit, || format!("wall at {wall}: {pixel:?}"));
            }
            // A shadow ray that is cut short by an epsilon at the light, too.
            let twin = Tracer::new(lab, vec![Object::matt(Shape::Plane(DVec3::Y * wall, -DVec3::Y))]);
            let at = |k: i32| f64::from(k) / 16.5 - 1.0 + 0.5 / 16.5;
            let points = (0..33 * 33).map(|k| lab.round3(DVec3::new(at(k % 33), 0.0, at(k / 33))));
            let wrong = points.filter(|p| twin.shadowed(*p, DVec3::Y * light) == lit).count();
            e.twin(wrong > 0);
        }
    }
    e
}

fn overflow(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("channels");
    let bright =
        json!({ "ambient": 1000, "diffuse": 1000, "specular": 1000, "reflection": 1000, "transmission": 1000 });
    let light = |y: f64| json!({ "point": { "position": [0, y, 0], "intensity": 1e15, "falloff": "inverse_square" } });
    let mut scene = floor(bright, light(1e-3));
    scene["ambient"] = json!(1e15);
    scene["background"] = json!(1e15);
    scene["lights"] = json!([light(1e-3), light(1.0), light(1e14)]);
    scene["objects"].as_array_mut().unwrap().push(ball([0.0, 0.5, 0.0], 0.3, "floor"));
    scene["render"]["max_depth"] = json!(20);
    scene["image"] = square(6);
    let film = picture(&lab.load(&scene).unwrap_or_else(|p| panic!("{p}")).scene).film;
    for channel in film.pixels.iter().flatten() {
        e.check(channel.is_finite() && *channel >= 0.0, || format!("{channel}"));
    }
    e.check(!encode(&film, FileFormat::Png8).is_empty(), || "no picture".to_owned());
    // The same floor, ball and lights without bounds on sums and weights, for a film of f32.
    let (floor, ball) = (Shape::Plane(DVec3::ZERO, DVec3::Y), Shape::Sphere(DVec3::Y * 0.5, 0.3));
    let object = |shape: Shape| Object { glow: 1e18, diffuse: 1e3, mirror: 1e3, clear: 1e3, shape, ior: 1.0 };
    let mut twin = Tracer::new(lab, vec![object(floor), object(ball)]);
    twin.lights = [1e-3, 1.0, 1e14].map(|y| (DVec3::Y * y, 1e15)).to_vec();
    (twin.background, twin.patience) = (1e15, 10_000);
    for x in [-0.1, 0.05, 0.4] {
        let light = twin.radiance(DVec3::new(x, 4.0, 0.1), -DVec3::Y, 20) as f32;
        e.twin(!light.is_finite());
    }
    e
}
