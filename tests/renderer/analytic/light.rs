//! Lights, shadows and what surfaces do with them.

use super::*;

/// A floor at the origin, seen from straight above.
fn floor() -> Value {
    json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "m" } })
}

#[track_caller]
fn floor_shows(material: Value, lights: Value, expected: [f64; 3]) {
    shows(json!([floor()]), json!({ "materials": { "m": material }, "lights": lights }), expected);
}

/// 3-4-5: five away, N.L = 0.8, R.V = 0.8.
fn point(more: Value) -> Value {
    let mut light = json!({ "position": [3, 4, 0] });
    light.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    json!([{ "point": light }])
}

#[test]
fn rays_that_hit_nothing_show_the_background() {
    let away = json!([{ "sphere": { "center": [0, 50, 0], "radius": 1 } }]);
    shows(away, json!({ "background": [0.25, 0.5, 2] }), [0.25, 0.5, 2.0]);
}

#[test]
fn ambient_light_is_a_product_and_defaults_to_the_diffuse_color() {
    let more = |material: Value| json!({ "ambient": [0.5, 1, 2], "materials": { "m": material } });
    shows(json!([floor()]), more(json!({ "diffuse": [0.1, 0.2, 0.3] })), [0.05, 0.2, 0.6]);
    shows(json!([floor()]), more(json!({ "diffuse": 0.1, "ambient": [1, 0, 0.25] })), [0.5, 0.0, 0.5]);
}

#[test]
fn diffuse_light_falls_with_the_cosine() {
    floor_shows(json!({ "diffuse": [0.5, 0.25, 0] }), point(json!({})), [0.4, 0.2, 0.0]);
    floor_shows(json!({ "diffuse": 0.5 }), point(json!({ "color": [1, 0.5, 0], "intensity": 3 })), [1.2, 0.6, 0.0]);
    let directional = json!([{ "directional": { "direction": [6, -8, 0], "intensity": 2 } }]);
    floor_shows(json!({ "diffuse": 0.5 }), directional, [0.8; 3]);
    let below = json!([{ "point": { "position": [3, -4, 0] } }, { "directional": { "direction": [0, 1, 0] } }]);
    floor_shows(json!({ "diffuse": 0.5, "specular": 1 }), below, [0.0; 3]);
}

#[test]
fn highlights_are_powers_of_the_cosine() {
    for (shininess, power) in [(0.0, 1.0), (1.0, 0.8), (2.0, 0.64), (3.5, 0.8f64.powf(3.5)), (32.0, 0.8f64.powi(32))] {
        let shiny = json!({ "diffuse": 0, "specular": [1, 0.5, 0], "shininess": shininess });
        floor_shows(shiny, point(json!({ "intensity": 2 })), [2.0 * power, power, 0.0]);
    }
    let mirror_direction = json!([{ "point": { "position": [0, 4, 0] } }]);
    floor_shows(json!({ "diffuse": 0, "specular": 0.7, "shininess": 1e6 }), mirror_direction, [0.7; 3]);
    floor_shows(json!({ "diffuse": 0.5, "specular": 0.5, "shininess": 2 }), point(json!({})), [0.72; 3]);
}

#[test]
fn lights_add_up() {
    let lights = json!([
        { "point": { "position": [3, 4, 0], "color": [1, 0, 0] } },
        { "point": { "position": [0, 4, 3], "color": [0, 1, 0] } },
        { "directional": { "direction": [0, -1, 0], "color": [0, 0, 1] } }
    ]);
    floor_shows(json!({ "diffuse": 0.5 }), lights, [0.4, 0.4, 0.5]);
}

#[test]
fn three_falloffs() {
    let diffuse = json!({ "diffuse": 1 });
    floor_shows(diffuse.clone(), point(json!({ "falloff": "none" })), [0.8; 3]);
    floor_shows(diffuse.clone(), point(json!({ "falloff": "inverse_square" })), [0.8 / 25.0; 3]);
    floor_shows(diffuse.clone(), point(json!({ "falloff": { "linear": { "reach": 20 } } })), [0.6; 3]);
    floor_shows(diffuse, point(json!({ "falloff": { "linear": { "reach": 4.9 } } })), [0.0; 3]);
}

#[test]
fn spots_fade_between_two_angles() {
    // The axis misses the point on the floor by `off` degrees.
    let spot = |off: f64, inner: f64, outer: f64| {
        let angle = 4f64.atan2(3.0) + off.to_radians();
        let direction = [-angle.cos(), -angle.sin(), 0.0];
        json!([{ "spot": { "position": [3, 4, 0], "direction": direction, "inner_deg": inner, "outer_deg": outer } }])
    };
    let diffuse = json!({ "diffuse": 1 });
    for (off, inner, outer, part) in [
        (0.0, 10.0, 20.0, 1.0),
        (9.0, 10.0, 20.0, 1.0),
        (-9.0, 10.0, 20.0, 1.0),
        (21.0, 10.0, 20.0, 0.0),
        (19.0, 20.0, 20.0, 1.0),
        (21.0, 20.0, 20.0, 0.0),
    ] {
        floor_shows(diffuse.clone(), spot(off, inner, outer), [0.8 * part; 3]);
    }
    let cosine = |degrees: f64| degrees.to_radians().cos();
    let x = (cosine(15.0) - cosine(20.0)) / (cosine(10.0) - cosine(20.0));
    let expected = 0.8 * x * x * (3.0 - 2.0 * x);
    // Differences of cosines magnify a rounding twentyfold.
    for (pixel, small) in
        pixels(json!([floor()]), json!({ "materials": { "m": diffuse }, "lights": spot(15.0, 10.0, 20.0) }))
    {
        assert_vector(pixel, [expected; 3], 20.0 * small);
    }
}

#[test]
fn checkers_are_even_where_the_tiles_add_up_to_an_even_number() {
    let axes = ["x", "y", "z", "xy", "xz", "yz", "xyz"];
    for name in axes {
        for (i, x) in [-0.75, -0.25, 0.25, 0.75].into_iter().enumerate() {
            for (k, z) in [-0.25, 0.25, 0.75].into_iter().enumerate() {
                for (j, y) in [0.25, 0.75].into_iter().enumerate() {
                    let tiles = [i as i32 - 2, j as i32, k as i32 - 1];
                    let sum: i32 = (0..3).filter(|&a| name.contains(["x", "y", "z"][a])).map(|a| tiles[a]).sum();
                    let floor = json!({ "plane": { "point": [0, y, 0], "normal": [0, 1, 0], "material": "m" } });
                    let checker = json!({ "checker": { "a": [1, 0, 0], "b": [0, 0, 1], "size": 0.5, "axes": name } });
                    let camera = json!({ "orthographic": { "eye": [x, 5, z], "look_at": [x, 0, z], "up": [0, 0, -1], "height": 1 } });
                    let point = json!({ "filter_checkers": false });
                    let more = json!({ "materials": { "m": { "diffuse": checker } }, "ambient": 1, "camera": camera, "render": point });
                    let expected = if sum.rem_euclid(2) == 0 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] };
                    shows(json!([floor]), more, expected);
                }
            }
        }
    }
}

#[test]
fn checkers_move_with_their_body() {
    let checker = json!({ "checker": { "a": 1, "b": 0 } });
    let group = |transform: Value| json!([{ "group": { "objects": [floor()], "transform": transform } }]);
    let more = |x: f64| {
        let camera =
            json!({ "orthographic": { "eye": [x, 5, 0.5], "look_at": [x, 0, 0.5], "up": [0, 0, -1], "height": 1 } });
        let point = json!({ "filter_checkers": false });
        json!({ "materials": { "m": { "diffuse": checker } }, "ambient": 1, "camera": camera, "render": point })
    };
    shows(group(json!({})), more(1.5), [0.0; 3]);
    shows(group(json!({ "scale": 2 })), more(1.5), [1.0; 3]);
    shows(group(json!({ "translate": [1, 0, 0] })), more(1.5), [1.0; 3]);
    shows(group(json!({ "translate": [1, 0, 0] })), more(0.5), [0.0; 3]);
}

fn shadowed(blocker: Value, shadows: &str, expected: [f64; 3]) {
    let more = json!({
        "materials": { "m": { "diffuse": 1, "ambient": 0.25 }, "filter": { "diffuse": 0, "transmission": [0.5, 0.25, 0] } },
        "ambient": 0.4,
        "lights": [{ "point": { "position": [3, 4, 0] } }],
        "render": { "shadows": shadows }
    });
    shows(json!([floor(), blocker]), more, expected);
}

#[test]
fn shadows_are_opaque_transmissive_or_absent() {
    let pane = json!({ "disc": { "center": [1.5, 2, 0], "normal": [3, 4, 0], "radius": 0.5, "material": "filter" } });
    let ball = json!({ "sphere": { "center": [1.5, 2, 0], "radius": 0.5, "material": "filter" } });
    let wall = json!({ "sphere": { "center": [1.5, 2, 0], "radius": 0.5 } });
    for blocker in [&pane, &ball, &wall] {
        shadowed(blocker.clone(), "opaque", [0.1; 3]);
        shadowed(blocker.clone(), "none", [0.9; 3]);
    }
    shadowed(pane, "transmissive", [0.1 + 0.4, 0.1 + 0.2, 0.1]);
    shadowed(ball, "transmissive", [0.1 + 0.2, 0.1 + 0.05, 0.1]);
    shadowed(wall, "transmissive", [0.1; 3]);
}

#[test]
fn what_stands_behind_the_light_casts_no_shadow() {
    let behind = json!({ "sphere": { "center": [6, 8, 0], "radius": 1 } });
    shadowed(behind, "opaque", [0.9; 3]);
    let beside = json!({ "sphere": { "center": [1.5, 2, 3], "radius": 1 } });
    shadowed(beside, "opaque", [0.9; 3]);
}
