//! Bodies of extreme size under transforms that cancel it.

use serde_json::json;
use strahl::inspect::query::{RayQuery, answer};
use strahl::scene::description::Precision;
use strahl::scene::{Format, Overrides, load};

#[test]
fn extreme_scales_cancel_out() {
    // A body of any size under the inverse scale is a body of size 1, seen at the same distances.
    for precision in [Precision::Single, Precision::Double] {
        let overrides = Overrides { precision: Some(precision), ..Overrides::default() };
        for power in [-14, -10, -5, 5, 10, 14] {
            let size = 10f64.powi(power);
            for body in [
                json!({ "sphere": { "center": [0, 0, 0], "radius": size } }),
                json!({ "cylinder": { "base": [0, -size, 0], "top": [0, size, 0], "radius": size } }),
                json!({ "cone": { "base": [0, -size, 0], "top": [0, size, 0], "base_radius": 2.0 * size } }),
                json!({ "torus": { "center": [0, 0, 0], "axis": [0, 1, 0], "major_radius": 0.75 * size, "minor_radius": 0.25 * size } }),
                json!({ "box": { "min": [-size, -size, -size], "max": [size, size, size] } }),
            ] {
                let scene = json!({
                    "version": 1,
                    "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
                    "definitions": { "body": [body] },
                    "objects": [{ "instance": { "of": "body", "transform": { "scale": 1.0 / size } } }]
                });
                let loaded = load(&serde_json::to_vec(&scene).unwrap(), Format::Json, &overrides).unwrap();
                let ray = RayQuery { origin: [0.0, 0.0, 5.0], direction: [0.0, 0.0, -1.0], t_min: 0.0, t_max: None };
                let hit = answer(&loaded.scene, &ray).at.unwrap_or_else(|| panic!("{precision:?} misses {body}"));
                assert!((hit.t - 4.0).abs() < 1e-5, "{precision:?}: t = {} for {body}", hit.t);
                let ray = RayQuery { direction: [0.0, 2.0, -1.0], ..ray };
                assert!(!answer(&loaded.scene, &ray).hit, "{precision:?} meets {body} beside it");
            }
        }
    }
}
