//! Bodies that move while the shutter is open.

use super::bumps::normals;
use super::{pixels, scene};
use serde_json::{Value, json};

const BOTH: [&str; 2] = ["single", "double"];

/// What a camera that looks down on the square from -2 to 2 sees.
fn seen_from_above(objects: Value, more: Value) -> Value {
    let mut description = json!({
        "version": 1,
        "image": { "width": 64, "height": 64 },
        "camera": { "orthographic": { "eye": [0, 9, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "height": 4 } },
        "ambient": 0, "background": 1, "lights": [],
        "materials": { "black": { "diffuse": 0 }, "white": { "diffuse": 0.9 }, "glass": { "diffuse": 0, "transmission": 0.9, "ior": 1.5, "reflection": 0.1 } },
        "objects": objects,
        "render": { "antialias": false }
    });
    for (key, value) in more.as_object().unwrap() {
        description[key] = value.clone();
    }
    description
}

fn middle(i: usize) -> f64 {
    (i as f64 + 0.5) / 16.0 - 2.0
}

/// The edge of a half-plane that moves from x = 0 to x = 1 uncovers x during the time 1 - x.
#[test]
fn a_moving_edge_is_a_ramp() {
    let half = json!([{ "group": {
        "objects": [{ "quad": { "vertices": [[-9, 0, 9], [0, 0, 9], [0, 0, -9], [-9, 0, -9]], "material": "black" } }],
        "motion": { "translate": [1, 0, 0] }
    } }]);
    for precision in BOTH {
        for (i, pixel) in pixels(seen_from_above(half.clone(), json!({})), precision).iter().enumerate() {
            let x = middle(i % 64);
            let expected = x.clamp(0.0, 1.0);
            // One of 64 samples is a step of the ramp, and a pixel is 1/16 wide.
            assert!((f64::from(pixel[0]) - expected).abs() < 0.04, "{precision}, {x}: {}", pixel[0]);
        }
    }
}

/// An edge through the origin that turns by 90 degrees: at the angle a it passes at the time a/90.
#[test]
fn a_turning_edge_sweeps_angles_evenly() {
    let turning = json!([{ "group": {
        "objects": [{ "quad": { "vertices": [[0, 0, 0], [9, 0, 0], [9, 0, 9], [0, 0, 9]], "material": "black" } }],
        "motion": { "rotate_deg": { "axis": [0, 1, 0], "angle": 90 } }
    } }]);
    for precision in BOTH {
        for (i, pixel) in pixels(seen_from_above(turning.clone(), json!({})), precision).iter().enumerate() {
            let (x, z) = (middle(i % 64), middle(i / 64));
            if x.hypot(z) < 0.5 || x.hypot(z) > 1.9 {
                continue;
            }
            // Turning around y by a positive angle takes +z to +x; the quad covers the angles 0 to 90 from +z first.
            let angle = x.atan2(z).to_degrees().rem_euclid(360.0);
            let covered = if angle < 90.0 {
                angle / 90.0
            } else if angle < 180.0 {
                (180.0 - angle) / 90.0
            } else {
                0.0
            };
            let got = 1.0 - f64::from(pixel[0]);
            assert!((got - covered.clamp(0.0, 1.0)).abs() < 0.06, "{precision}, {x} {z}, {angle}: {got} {covered}");
        }
    }
}

/// A ball that turns around its own middle stays where it is: any difference would be acne, or a leak.
#[test]
fn a_spinning_ball_looks_as_if_it_rested() {
    for material in ["white", "glass"] {
        let ball = |motion: Value| {
            let mut group =
                json!({ "objects": [{ "sphere": { "center": [0.3, 1, -0.2], "radius": 1, "material": material } }] });
            if !motion.is_null() {
                group["motion"] = motion;
            }
            let floor = json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "white" } });
            let light = json!({ "point": { "position": [1, 8, 2] } });
            seen_from_above(
                json!([floor, { "group": group }]),
                json!({ "lights": [light], "ambient": 0.1, "render": { "antialias": false, "samples": 64 } }),
            )
        };
        let spinning = json!({ "rotate_deg": { "axis": [0.3, 1, 0.5], "angle": 1234 }, "center": [0.3, 1, -0.2] });
        for precision in BOTH {
            let rest = pixels(ball(Value::Null), precision);
            let moved = pixels(ball(spinning.clone()), precision);
            let differing = rest.iter().zip(&moved).filter(|(a, b)| (0..3).any(|c| (a[c] - b[c]).abs() > 0.01)).count();
            assert!(differing <= 8, "{material}, {precision}: {differing} pixels differ");
        }
    }
}

/// A slope turns with the body that has it. By a turn of a quarter the light of a lamp at an angle is A + B cos + C sin, with the
/// mean A + 2 (B + C) / pi, and bodies at rest tell A, B and C.
#[test]
fn bumps_turn_with_their_bodies() {
    let slope =
        json!({ "image": { "source": normals(190, 110, 220), "mapping": { "planar": { "axes": "xz", "size": 16 } } } });
    let picture = |group: Value, precision: &str| {
        let mut group = group;
        group["objects"] =
            json!([{ "disc": { "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 9, "material": "bumpy" } }]);
        let more = json!({
            "materials": { "bumpy": { "diffuse": 0.9, "normal_map": slope } },
            "lights": [{ "directional": { "direction": [-1, -2, 0.3] } }],
            "render": { "antialias": false, "samples": 64 }
        });
        f64::from(pixels(seen_from_above(json!([{ "group": group }]), more), precision)[0][0])
    };
    let rotation = |angle: f64| json!({ "axis": [0, 1, 0], "angle": angle });
    for precision in BOTH {
        let resting = |angle: f64| picture(json!({ "transform": { "rotate_deg": rotation(angle) } }), precision);
        let a = 0.5 * (resting(0.0) + resting(180.0));
        let (b, c) = (resting(0.0) - a, resting(90.0) - a);
        assert!(b.abs() > 0.05 && c.abs() > 0.02, "{precision}: {b} {c}");
        let turning = picture(json!({ "motion": { "rotate_deg": rotation(90.0) } }), precision);
        let mean = a + 2.0 / std::f64::consts::PI * (b + c);
        assert!((turning - mean).abs() < 2e-3, "{precision}: {turning} instead of {mean}");
    }
}

/// Shadows and what mirrors show move with the body.
#[test]
fn shadows_are_blurred_as_their_bodies_are() {
    let objects = json!([
        { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "white" } },
        { "group": {
            "objects": [{ "quad": { "vertices": [[-9, 20, 9], [0, 20, 9], [0, 20, -9], [-9, 20, -9]], "material": "black" } }],
            "motion": { "translate": [1, 0, 0] }
        } }
    ]);
    let light = json!({ "lights": [{ "directional": { "direction": [0, -1, 0] } }] });
    for precision in BOTH {
        for (i, pixel) in pixels(seen_from_above(objects.clone(), light.clone()), precision).iter().enumerate() {
            let expected = 0.9 * middle(i % 64).clamp(0.0, 1.0);
            assert!((f64::from(pixel[0]) - expected).abs() < 0.04, "{precision}, {}: {}", middle(i % 64), pixel[0]);
        }
    }
}

#[test]
fn a_motion_that_goes_nowhere_is_removed() {
    let ball = |motion: Value| {
        let mut group = json!({ "objects": [{ "sphere": { "center": [0, 1, 0], "radius": 1, "material": "white" } }] });
        if !motion.is_null() {
            group["motion"] = motion;
        }
        seen_from_above(json!([{ "group": group }]), json!({ "ambient": 0.5 }))
    };
    let nowhere = json!({ "translate": [0, 0, 0], "rotate_deg": { "axis": [0, 1, 0], "angle": 0 } });
    for precision in BOTH {
        assert_eq!(scene(ball(nowhere.clone()), precision).samples, 1);
        assert_eq!(pixels(ball(nowhere.clone()), precision), pixels(ball(Value::Null), precision));
    }
}

#[test]
fn what_is_wrong_with_a_motion_is_named() {
    let objects = json!([{ "group": {
        "objects": [{ "sphere": { "center": [0, 1, 0], "radius": 1 } }],
        "motion": { "translate": [1e20, 0, 0], "rotate_deg": { "axis": [0, 0, 0], "angle": 1e9 } }
    } }]);
    let mut pointers = super::problems(&seen_from_above(objects, json!({})));
    pointers.sort();
    let at = |rest: &str| format!("/objects/0/group/motion/{rest}");
    assert_eq!(pointers, [at("rotate_deg/angle"), at("rotate_deg/axis"), at("translate/0")]);
}

/// A lens that is half inside a glass block, and an eye that a glass ball passes: rays start in their own media.
#[test]
fn each_ray_starts_in_the_media_around_its_own_start() {
    let camera = |aperture: f64| json!({ "pinhole": { "eye": [0, 0, 0], "look_at": [0, 0, -1], "vfov_deg": 1, "aperture": aperture, "focus_distance": 1 } });
    let description = |objects: Value, aperture: f64| {
        json!({
            "version": 1, "image": { "width": 4, "height": 4 }, "camera": camera(aperture), "ambient": 0, "background": 1,
            "lights": [], "materials": { "black": { "diffuse": 0, "absorption": 50, "transmission": 1, "ior": 1 } },
            "objects": objects, "render": { "antialias": false, "samples": 256 }
        })
    };
    // Light is absorbed on its way out of the block, which the left half of the lens is in.
    let half = json!([{ "box": { "min": [-5, -5, -0.5], "max": [0, 5, 5], "material": "black" } }]);
    let passing = json!([{ "group": {
        "objects": [{ "box": { "min": [-10, -5, -5], "max": [-1, 5, 5], "material": "black" } }],
        "motion": { "translate": [2, 0, 0] }
    } }]);
    for precision in BOTH {
        for (objects, aperture) in [(half.clone(), 0.5), (passing.clone(), 0.0)] {
            let got = pixels(description(objects, aperture), precision);
            let mean = got.iter().map(|p| f64::from(p[0])).sum::<f64>() / 16.0;
            assert!((mean - 0.5).abs() < 0.03, "{precision}: {mean}");
        }
    }
}
