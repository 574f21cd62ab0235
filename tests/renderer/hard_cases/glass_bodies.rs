//! R: refraction by bodies: plates, liquids, eyes and traps in glass.

use super::Case;
use super::evidence::Evidence;
use super::lab::{Lab, ask, ball, rows, truth, vector};
use super::textbook::{Object, Shape, Tracer};
use crate::common::Random;
use crate::common::naive;
use glam::DVec3;
use serde_json::{Value, json};
use strahl::math::sin_cos;

pub const CASES: &[Case] =
    &[("R11", plates), ("R12", thousand_plates), ("R13", liquid), ("R14", eye_in_glass), ("R16", long_way)];

fn plates(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "refract_slab", &[]);
    for row in rows("refract_slab") {
        if let Some(thickness) = row["in"]["thickness"].as_f64() {
            // The second face lies within an epsilon of 1e-4.
            let plate = Shape::Cuboid(DVec3::new(-256.0, -thickness, -256.0), DVec3::new(256.0, 0.0, 256.0));
            let d = vector(&row["in"]["d"]);
            let steps = Tracer::new(lab, vec![Object::glass(plate, 1.5)]).through(-d, d, 9);
            let behind = vector(&row["expect"]["exit_direction_unit_equals_entry"]);
            let allowed = row["tol"][lab.pick("exit_direction_abs_f32", "exit_direction_abs_f64")].as_f64().unwrap();
            let out = steps.last().filter(|last| steps.len() == 3 && last.media == 0);
            e.twin(!out.is_some_and(|last| (last.direction - behind).abs().max_element() <= allowed));
        }
    }
    e
}

/// Plates of glass on each other, `gap` apart.
fn stack(count: usize, gap: f64) -> Value {
    let plate = |i: usize| {
        let top = -(i as f64) * (1.0 + gap);
        json!({ "box": { "min": [-1e4, top - 1.0, -1e4], "max": [1e4, top, 1e4], "material": "glass" } })
    };
    json!((0..count).map(plate).collect::<Vec<_>>())
}

fn thousand_plates(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(8000.0, "u of the direction behind 1000 plates");
    let d = DVec3::new(0.6, -0.8, 0.0);
    for gap in [0.0, 0.125] {
        let more = json!({ "render": { "max_depth": 5000, "min_weight": 0 } });
        let tree = lab.tree(DVec3::new(0.0, 2.0, 0.0), d, stack(1000, gap), more);
        let last = tree.rays.last().unwrap();
        let off = DVec3::from_array(last.direction).distance(naive::normalize(lab, d));
        e.measure(off / lab.u);
        e.check(last.hit.is_none() && last.media.is_empty(), || {
            format!("gap {gap}: ends in {} media", last.media.len())
        });
        e.check(last.origin[1] < -999.0, || format!("gap {gap}: ends at {:?}", last.origin));
        // Across: to the stack, through 1000 plates at sin = 0.6 / 1.5, and through the gaps.
        let across = 1.5 + 1000.0 * 0.4 / (1.0f64 - 0.16).sqrt() + 999.0 * gap * 0.75;
        let aside = |x: f64| (x / across - 1.0).abs() / lab.u;
        e.measure(aside(last.origin[0]));
        // The entry into the next plate lies within the epsilon of the exit from the last, and the bare stack does not
        // know which medium a ray is in.
        let plate = |i: usize| {
            let top = -(i as f64) * (1.0 + gap);
            let (low, high) = (DVec3::new(-1e4, top - 1.0, -1e4), DVec3::new(1e4, top, 1e4));
            Object::glass(Shape::Cuboid(low, high), lab.round(1.5))
        };
        let steps = Tracer::new(lab, (0..1000).map(plate).collect()).through(DVec3::Y * 2.0, d, 2100);
        let end = steps.last().unwrap();
        e.twin(end.media > 0 || aside(end.origin.x) > 8000.0);
        e.twin_measure(end.direction.distance(naive::normalize(lab, d)) / lab.u);
    }
    e
}

fn liquid(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(64.0, "u of the direction in the water");
    let (sin, cos) = sin_cos(1.2);
    let d = lab.round3(DVec3::new(sin, -cos, 0.0));
    let expected = d.x / d.length() / 1.33;
    for overlap in [0.0, 1e-5, 1e-3] {
        let objects = json!([
            { "box": { "min": [-50, -1, -50], "max": [50, 0, 50], "material": "glass" } },
            { "box": { "min": [-50, -9, -50], "max": [50, -1.0 + overlap, 50], "material": "water" } }
        ]);
        let tree = lab.tree(-d * 2.0, d, objects, json!({}));
        let in_water = tree.rays.iter().find(|r| r.media.len() == 1 && r.origin[1] < -0.9);
        let off = in_water.map_or(f64::INFINITY, |r| (r.direction[0] - expected).abs() / lab.u);
        e.check(off <= 64.0, || format!("overlap {overlap}: off by {off} u"));
        e.measure(off);
        e.check(in_water.is_some_and(|r| r.media[0].object == "/objects/1"), || format!("overlap {overlap}: no water"));
        // Into glass, into water, out of glass: a bare stack pops the water.
        let solid = |low: f64, high: f64, ior: f64| {
            let shape = Shape::Cuboid(DVec3::new(-50.0, low, -50.0), DVec3::new(50.0, lab.round(high), 50.0));
            Object::glass(shape, lab.round(ior))
        };
        let twin = Tracer::new(lab, vec![solid(-1.0, 0.0, 1.5), solid(-9.0, -1.0 + overlap, 1.33)]);
        let steps = twin.through(-d * 2.0, d, 9);
        let in_water = steps.iter().find(|step| step.origin.y < -0.99 && step.direction.y < 0.0);
        e.twin_measure(in_water.map_or(f64::INFINITY, |step| (step.direction.x - expected).abs() / lab.u));
    }
    e
}

fn eye_in_glass(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("eyes in glass");
    let mut random = Random::new(32);
    for _ in 0..40 {
        let eye = lab.round3(DVec3::from_array(random.point(0.4)));
        let more =
            json!({ "camera": { "pinhole": { "eye": eye.to_array(), "look_at": random.point(3.0), "vfov_deg": 1 } } });
        let objects = json!([ball([0.0; 3], 1.0, "glass"), ball([0.1, 0.0, 0.0], 5.0, "water")]);
        let tree = strahl::inspect::tree::trace_pixel(&lab.scene(objects, more), 0, 0);
        let first = &tree.rays[0];
        let media: Vec<&str> = first.media.iter().map(|m| m.object.as_str()).collect();
        e.check(media == ["/objects/0", "/objects/1"], || format!("media {media:?}"));
        let snell = first.snell.unwrap();
        e.check((snell.n1 / snell.n2 - 1.5 / 1.33).abs() < 1e-6, || format!("{snell:?}"));
        // A stack that starts empty leaves a body it was never in.
        let balls = [(DVec3::ZERO, 1.0, 1.5), (DVec3::X * lab.round(0.1), 5.0, 1.33)];
        let balls = balls.map(|(center, radius, ior)| Object::glass(Shape::Sphere(center, radius), ior));
        let steps = Tracer::new(lab, balls.to_vec()).through(eye, DVec3::from_array(first.direction), 2);
        let [n1, n2] = steps[0].indices;
        e.twin((n1 / n2 - 1.5 / 1.33).abs() > 1e-6);
    }
    e
}

fn long_way(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays of a trap");
    let more = json!({
        "render": { "max_depth": 20_000, "min_weight": 0 }, "background": 1,
        "materials": { "trap": { "ambient": 0, "diffuse": 0, "transmission": 0.99, "ior": 1.5 } }
    });
    // Inside a block at 45 degrees nothing gets out.
    let block = json!([{ "box": { "min": [-1, -1, -1e9], "max": [1, 1, 1e9], "material": "trap" } }]);
    let mut more = more;
    more["camera"] =
        json!({ "pinhole": { "eye": [0.3, 0, 0], "look_at": [1.3, 1, 0], "up": [0, 0, 1], "vfov_deg": 1 } });
    let tree = strahl::inspect::tree::trace_pixel(&lab.scene(block, more), 0, 0);
    let mut last = 1.0;
    for ray in &tree.rays {
        let weight = ray.weight[0];
        e.check((0.0..=last).contains(&weight), || format!("weight {weight} after {last}"));
        last = weight;
    }
    e.check(tree.rays.len() > 1000 && tree.value.iter().all(|v| (0.0..=1.0).contains(v)), || {
        format!("{:?} after {}", tree.value, tree.rays.len())
    });
    // In clear glass without a far side the way is infinite, and Beer's law has no answer to 0 times infinity.
    let (eye, d) = (DVec3::Y * -1.0, DVec3::new(0.1, -1.0, 0.2));
    let half_space = json!([{ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "glass" } }]);
    let tree = lab.tree(eye, d, half_space, json!({ "background": [0.25, 0.5, 1] }));
    e.check(tree.value == [0.25, 0.5, 1.0], || format!("endless glass shows {:?}", tree.value));
    let twin = Tracer::new(lab, vec![Object::glass(Shape::Plane(DVec3::ZERO, DVec3::Y), 1.5)]);
    let way = twin.nearest(eye, d).map_or(f64::INFINITY, |hit| hit.0);
    e.twin(!(naive::transmittance(lab, 0.0, way) * 0.5).is_finite());
    e
}
