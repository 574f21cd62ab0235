//! Highlights of lights with an area on smooth materials: as even as the light, and as bright as they are in any other way.

use super::*;

/// A ball of a material below a light.
fn lit(material: &Value, light: &Value, fidelity: &str, samples: u32) -> Value {
    json!({
        "version": 1, "image": { "width": 48, "height": 48 }, "ambient": 0,
        "camera": { "pinhole": { "eye": [0, 0.6, 2], "look_at": [0, 0.6, 0], "vfov_deg": 40 } },
        "objects": [ { "sphere": { "center": [0, 0.6, 0], "radius": 0.6, "material": "ball" } } ],
        "materials": { "ball": { "pbr": material } },
        "lights": [ light ],
        "render": { "fidelity": fidelity, "samples": samples }
    })
}

fn disc(radius: f64) -> Value {
    json!({ "point": { "position": [2, 4, 2], "area": { "disc": { "radius": radius } } } })
}

fn parallelogram(edge: f64) -> Value {
    json!({ "point": { "position": [2, 4, 2], "area": { "parallelogram": { "u": [edge, 0, -edge], "v": [0, edge, -edge] } } } })
}

fn sun(angle: f64) -> Value {
    json!({ "directional": { "direction": [-2, -3.4, -2], "area": { "angle_deg": angle } } })
}

fn materials() -> [Value; 5] {
    [
        json!({ "metallic": 0, "roughness": 0, "base_color": [0.2, 0.3, 0.6] }),
        json!({ "metallic": 1, "roughness": 0.1, "base_color": [0.8, 0.6, 0.3] }),
        json!({ "metallic": 0, "roughness": 0.2, "base_color": [0.2, 0.3, 0.6] }),
        json!({ "metallic": 0, "roughness": 0.05, "transmission": 1 }),
        json!({ "metallic": 0, "roughness": 0.8, "clearcoat": 1, "base_color": [0.2, 0.3, 0.6] }),
    ]
}

/// About what a display shows of linear light, in codes.
fn codes(pixels: &[[f32; 3]]) -> Vec<f64> {
    pixels.iter().flatten().map(|x| 255.0 * f64::from(x.clamp(0.0, 1.0)).sqrt()).collect()
}

/// Chosen by their area alone, places of the light left 4 to 14 pixels that were 50 to 167 codes off.
#[test]
fn smooth_materials_have_no_speckles() {
    for light in [disc(0.7), parallelogram(1.0), sun(12.0)] {
        for material in materials() {
            for fidelity in ["fast", "faithful"] {
                let [few, many] =
                    [256, 1024].map(|samples| codes(&pixels(lit(&material, &light, fidelity, samples), "single")));
                let furthest = few.iter().zip(&many).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(furthest < 40.0, "{material} {light} {fidelity}: {furthest}");
            }
        }
    }
}

/// A lamp in the plane of the eye is seen edge-on by the middle of the picture, and lights it all the same, at any scale.
#[test]
fn lamps_that_are_seen_edge_on_shine() {
    let mean = |size: f64, angle: f64, precision: &str, samples: u32| {
        let (sine, cosine) = strahl::math::sin_cos(angle);
        let turned = |[x, y, z]: [f64; 3]| [size * (cosine * x + sine * z), size * y, size * (cosine * z - sine * x)];
        let scene = json!({
            "version": 1, "image": { "width": 25, "height": 25 }, "ambient": 0,
            "camera": { "pinhole": { "eye": turned([0.0, 1.5, 6.0]), "look_at": turned([0.0, 0.0, 0.0]), "vfov_deg": 40 } },
            "objects": [ { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "metal" } } ],
            "materials": { "metal": { "pbr": { "metallic": 1, "roughness": 0.3, "base_color": [0.9, 0.9, 0.9] } } },
            "lights": [{ "point": { "position": turned([0.0, 3.0, -3.0]), "area": { "parallelogram": {
                "u": turned([0.0, 1.0, 0.0]), "v": turned([0.0, 0.0, 1.0]) } } } }],
            "render": { "samples": samples, "antialias": false }
        });
        let pixels = pixels(scene, precision);
        let column: Vec<f64> = pixels.iter().skip(12).step_by(25).map(|pixel| f64::from(pixel[1])).collect();
        column.iter().sum::<f64>() / 25.0
    };
    let usual = mean(1.0, 0.0, "double", 256);
    for (size, angle, precision) in
        [(1.0, 0.0, "single"), (1.0, 0.3, "single"), (1.0, 2.0, "double"), (1e-9, 0.3, "single"), (1e10, 0.0, "single")]
    {
        let other = mean(size, angle, precision, 256);
        assert!((other - usual).abs() < 0.05 * usual, "{size} {angle} {precision}: {other}, and {usual} of the usual");
        // The first sample is in the middle of its pixel, where the lamp has no width at all.
        assert!(mean(size, angle, precision, 1) > 0.3 * usual, "{size} {angle} {precision}");
    }
}

/// The lobes of a ball see as much of a small light as of a larger one, and rough ones as much as of a point.
#[test]
fn how_large_the_light_is_changes_no_mean() {
    // What glass mirrors inside has a limit, which small lights reach.
    for material in materials().into_iter().filter(|material| material["transmission"].is_null()) {
        let mean = |light: &Value| {
            let pixels = pixels(lit(&material, light, "fast", 1024), "double");
            pixels.iter().flatten().map(|x| f64::from(*x)).sum::<f64>() / pixels.len() as f64
        };
        let usual = mean(&disc(0.3));
        let mut lights = vec![disc(0.15), disc(0.6), parallelogram(0.4)];
        if material["roughness"] == json!(0.2) {
            lights.push(json!({ "point": { "position": [2, 4, 2] } }));
        }
        for light in lights {
            let mean = mean(&light);
            assert!((mean - usual).abs() < 0.01 * usual, "{material} {light}: {mean}, and {usual} of a disc");
        }
    }
}
