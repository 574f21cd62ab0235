//! Large floors under a small scene: flat ones of any kind, with their exact points.

use super::Random;
use super::numbers::Numbers;
use super::wide::Wide3;
use glam::DVec3;
use serde_json::{Value, json};
use strahl::inspect::first_hits::first_hits;
use strahl::inspect::query::RayQuery;
use strahl::scene::description::Precision;
use strahl::scene::{Format, Overrides, load};

/// What a floor may be made of.
pub const KINDS: [&str; 4] = ["triangle", "quad", "polygon", "mesh"];

/// A floor around the origin.
pub struct Floor {
    pub object: Value,
    pub normal: DVec3,
    /// Two directions along it.
    pub along: [DVec3; 2],
}

/// A floor of a size, level or not, whose corners are whole numbers, so that they are exact and in one plane.
pub fn floor(kind: &str, size: f64, level: bool) -> Floor {
    let [a, b] = if level {
        [DVec3::X, -DVec3::Z]
    } else {
        [DVec3::new(3.0, 1.0, 0.0) / 4.0, DVec3::new(-1.0, 2.0, -3.0) / 4.0]
    };
    let corner = |x: f64, y: f64| ((a * x + b * y) * (4.0 * (size / 4.0).ceil())).to_array();
    // No corner, edge or diagonal has a special place under the scene.
    let four = [corner(-1.0, -1.5), corner(1.25, -1.0), corner(1.5, 1.0), corner(-1.25, 1.25)];
    let object = match kind {
        "triangle" => json!({ "triangle": { "vertices": [corner(-1.0, -1.0), corner(2.0, -1.0), corner(-0.5, 2.0)] } }),
        "quad" => json!({ "quad": { "vertices": four } }),
        "polygon" => json!({ "polygon": { "vertices": [four[0], four[1], corner(2.0, 0.25), four[2], four[3]] } }),
        "mesh" => json!({ "mesh": { "vertices": four, "faces": [[0, 1, 3], [1, 2, 3]] } }),
        "disc" => json!({ "disc": { "center": [0, 0, 0], "normal": a.cross(b).to_array(), "radius": size } }),
        _ => json!({ "plane": { "point": [0, 0, 0], "normal": a.cross(b).to_array() } }),
    };
    Floor { object, normal: a.cross(b), along: [a.normalize(), b.normalize()] }
}

/// The same object with a material.
pub fn with_material(mut object: Value, material: &str) -> Value {
    object.as_object_mut().unwrap().values_mut().next().unwrap()["material"] = json!(material);
    object
}

/// Errors of points on a floor, in u (distance + 1): strahl's, and those of o + t d with Möller and Trumbore's t.
pub struct Errors {
    pub worst: f64,
    pub naive: f64,
    pub judged: usize,
}

/// Points that rays from a height of 0.1 to 3 find, up to 30 away where the floor is that large.
pub fn point_errors(kind: &str, size: f64, level: bool, precision: Precision, count: usize) -> Errors {
    let lab = Numbers::new(precision);
    let Floor { object, normal, along: [a, b] } = floor(kind, size, level);
    let text = json!({
        "version": 1, "image": { "width": 1, "height": 1 }, "lights": [], "objects": [object],
        "camera": { "pinhole": { "eye": [0, 5, 0], "look_at": [0, 0, -1] } }
    });
    let overrides = Overrides { precision: Some(precision), ..Overrides::default() };
    let scene = load(text.to_string().as_bytes(), Format::Json, &overrides).unwrap_or_else(|p| panic!("{p}")).scene;
    let mut random = Random::new(7);
    let rays: Vec<RayQuery> = (0..count)
        .map(|_| {
            let mut place = |reach: f64| a * random.between(-reach, reach) + b * random.between(-reach, reach);
            let (from, target) = (place(0.1 * size.min(10.0)), place(0.2 * size.min(100.0)));
            let origin = lab.round3(from + normal.normalize() * random.between(0.1, 3.0));
            let direction = lab.round3((target - origin).normalize());
            RayQuery { origin: origin.into(), direction: direction.into(), t_min: 0.0, t_max: None }
        })
        .collect();
    let mut errors = Errors { worst: 0.0, naive: 0.0, judged: 0 };
    for (ray, hit) in rays.iter().zip(first_hits(&scene, &rays)) {
        let (o, d) = (DVec3::from_array(ray.origin), DVec3::from_array(ray.direction));
        errors.judged += 1;
        let Some(hit) = hit else {
            println!("{kind} of {size}: {o} along {d} misses");
            errors.worst = f64::INFINITY;
            continue;
        };
        let n = Wide3::of(normal);
        let t = -(Wide3::of(o).dot(n) / Wide3::of(d).dot(n));
        let exact = Wide3::of(o) + Wide3::of(d).times(t);
        let unit = lab.u * (t.value() * d.length() + 1.0);
        let off = |p: DVec3| (Wide3::of(p) - exact).value().abs().max_element() / unit;
        errors.worst = errors.worst.max(off(DVec3::from_array(hit.point)));
        let corners = [[-1.0, -1.0], [2.0, -1.0], [-0.5, 2.0]].map(|[x, y]| lab.round3((a * x + b * y) * size));
        if let Some([t, ..]) = super::naive::triangle(&lab, o, d, corners, 0.0) {
            errors.naive = errors.naive.max(off(super::naive::point(&lab, o, d, t)));
        }
    }
    errors
}
