//! How deep rays go, and what is left of them.

use super::*;

fn mirror_floor() -> Value {
    json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "mirror" } })
}

#[test]
fn a_mirror_shows_the_background_times_its_reflection() {
    let more = |depth: u32| json!({ "background": [0.25, 0.5, 1], "render": { "max_depth": depth } });
    shows(json!([mirror_floor()]), more(2), [0.125, 0.25, 0.5]);
    shows(json!([mirror_floor()]), more(1), [0.0; 3]);
}

/// Two mirrors that glow a little face each other; the value is a geometric series, cut off.
fn corridor(render: Value) -> [World; 2] {
    let disc = |y: f64, normal: f64| json!({ "disc": { "center": [0, y, 0], "normal": [0, normal, 0], "radius": 1, "material": "glowing" } });
    let more = json!({
        "materials": { "glowing": { "diffuse": 0, "ambient": 1, "reflection": 0.5 } },
        "ambient": 1, "background": 100, "render": render
    });
    worlds(json!([disc(0.0, 1.0), disc(6.0, -1.0)]), more)
}

#[test]
fn max_depth_and_min_weight_cut_the_series() {
    for (render, terms, why) in [
        (json!({ "max_depth": 1 }), 1, "depth"),
        (json!({ "max_depth": 4, "min_weight": 0 }), 4, "depth"),
        (json!({ "max_depth": 100, "min_weight": 0.2 }), 3, "weight"),
        (json!({ "max_depth": 100, "min_weight": 0.25 }), 3, "weight"),
        (json!({ "max_depth": 100, "min_weight": 0.26 }), 2, "weight"),
    ] {
        for world in &corridor(render.clone()) {
            let expected = 2.0 - 0.5f64.powi(terms - 1);
            let tree = trace_pixel(&world.scene, 0, 0);
            assert_eq!(tree.value, [expected; 3], "{render}");
            assert_eq!(tree.rays.len(), terms as usize);
            let ended = &tree.rays.last().unwrap().not_followed;
            assert_eq!(ended.iter().map(|e| e.why).collect::<Vec<_>>(), [why]);
            assert_eq!(ended[0].weight, [0.5f64.powi(terms); 3]);
        }
    }
}

#[test]
fn under_total_reflection_transmission_joins_reflection() {
    let more = json!({
        "materials": { "prism": { "diffuse": 0, "transmission": 0.625, "reflection": 0.25, "ior": 1.5 } },
        "camera": { "orthographic": { "eye": [-1, -1, 0], "look_at": [0, 0, 0], "height": 1 } },
        "background": 1, "render": { "max_depth": 3 }
    });
    let floor = json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "prism" } });
    for world in &worlds(json!([floor]), more) {
        let tree = trace_pixel(&world.scene, 0, 0);
        assert_eq!(tree.rays[0].media.len(), 1, "the eye is in the glass");
        assert!(tree.rays[0].snell.unwrap().tir);
        assert_eq!(tree.rays.len(), 2);
        assert_eq!((tree.rays[1].kind, tree.rays[1].weight), (NodeKind::Reflected, [0.875; 3]));
        assert_eq!(tree.value, [0.875; 3]);
    }
}

#[test]
fn a_glass_pane_passes_and_reflects_its_shares() {
    let pane = json!({ "disc": { "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 1, "material": "pane" } });
    let below = json!({ "plane": { "point": [0, -3, 0], "normal": [0, 1, 0], "material": "red" } });
    let more = json!({
        "materials": {
            "pane": { "diffuse": 0, "transmission": 0.75, "reflection": 0.125, "ior": 1.5 },
            "red": { "diffuse": 0, "ambient": [1, 0, 0] }
        },
        "ambient": 1, "background": [0, 0, 1]
    });
    shows(json!([pane, below]), more, [0.75, 0.0, 0.125]);
}
