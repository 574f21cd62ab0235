//! Bodies of any size and place, in scenes of their own.

use crate::common::meshes::Closed;
use glam::DVec3;
use serde_json::{Value, json};
use strahl::scene::description::Precision;
use strahl::scene::{Format, Overrides, Scene, load};

/// Distances of the centre from the origin of coordinates, in sizes of the body.
pub const PLACES: [f64; 3] = [0.0, 100.0, 1e4];

/// Primitives that enclose something, but for the last three.
pub const PRIMITIVES: [&str; 10] =
    ["sphere", "box", "cylinder", "frustum", "torus", "mesh", "cube mesh", "disc", "triangle", "plane"];

/// A body of size about `r` around `c`.
pub fn object(name: &str, c: DVec3, r: f64) -> Value {
    let at = |x: f64, y: f64, z: f64| (c + DVec3::new(x, y, z) * r).to_array();
    let center = c.to_array();
    match name {
        "sphere" => json!({ "sphere": { "center": center, "radius": r, "material": "m" } }),
        "box" => json!({ "box": { "min": at(-1.0, -0.7, -0.4), "max": at(1.0, 0.7, 0.4), "material": "m" } }),
        "cylinder" => json!({ "cylinder": {
            "base": at(-0.5, -0.6, -0.2), "top": at(0.5, 0.6, 0.2), "radius": 0.7 * r, "material": "m"
        } }),
        "frustum" => json!({ "cone": {
            "base": at(-0.5, 0.6, -0.2), "base_radius": 0.9 * r,
            "top": at(0.5, -0.6, 0.2), "top_radius": 0.3 * r, "material": "m"
        } }),
        "torus" => json!({ "torus": {
            "center": center, "axis": [0.3, -0.5, 0.8], "major_radius": 0.7 * r, "minor_radius": 0.25 * r, "material": "m"
        } }),
        "mesh" => Closed::icosphere(1).placed(r, c).json("m"),
        "cube mesh" => Closed::cube().placed(r * 0.7, c).json("m"),
        "disc" => json!({ "disc": { "center": center, "normal": [0.3, 0.9, -0.4], "radius": r, "material": "m" } }),
        "triangle" => json!({ "triangle": {
            "vertices": [at(-0.8, -0.5, 0.1), at(0.9, -0.3, -0.4), at(0.1, 0.8, 0.5)], "material": "m"
        } }),
        _ => json!({ "plane": { "point": center, "normal": [0.3, 0.9, -0.4], "material": "m" } }),
    }
}

pub fn scene_of(object: &Value, precision: Precision) -> Scene {
    let text = json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "pinhole": { "eye": [0, 0, 0], "look_at": [0, 0, -1] } },
        "lights": [],
        "materials": { "m": { "diffuse": 0.5, "transmission": 0.5 } },
        "objects": [object]
    });
    let overrides = Overrides { precision: Some(precision), ..Overrides::default() };
    load(text.to_string().as_bytes(), Format::Json, &overrides).unwrap_or_else(|p| panic!("{p}")).scene
}
