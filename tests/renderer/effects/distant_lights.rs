//! Lights in the sky that have an angle, where light is traced: places of their discs are chosen, and rays of lobes find them.

use super::*;

/// A rough ball on a floor below a light of an angle, in degrees.
fn lit(angle: f64, roughness: f64, samples: u32) -> Value {
    json!({
        "version": 1, "image": { "width": 48, "height": 48 },
        "camera": { "pinhole": { "eye": [0, 1.5, 6], "look_at": [0, 0.8, 0], "vfov_deg": 40 } },
        "objects": [
            { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "rough" } },
            { "sphere": { "center": [0, 1, 0], "radius": 1, "material": "rough" } }
        ],
        "materials": { "rough": { "pbr": { "base_color": [0.8, 0.8, 0.8], "metallic": 0, "roughness": roughness } } },
        "lights": [ { "directional": { "direction": [-0.37, -1, -0.53], "color": 1, "area": { "angle_deg": angle } } } ],
        "render": { "fidelity": "faithful", "samples": samples }
    })
}

/// Single precision puts some places of a rim beside the disc. A place that rays cannot find had a share of 0/0, and was 10^25.
#[test]
fn places_at_the_rim_are_not_infinitely_bright() {
    for angle in [0.1, 0.53] {
        for precision in ["single", "double"] {
            let brightest = pixels(lit(angle, 0.4, 256), precision).into_iter().flatten().fold(0.0, f32::max);
            assert!(brightest < 4.0, "{angle} degrees, {precision}: {brightest}");
        }
    }
}

/// Down to the narrowest that rays find; and those that are points, also where no number holds the square of their angle.
#[test]
fn the_light_of_narrow_discs_does_not_depend_on_their_angle() {
    let mean = |angle: f64| {
        let pixels = pixels(lit(angle, 0.4, 64), "single");
        pixels.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / pixels.len() as f64
    };
    for (expected, angles) in [(0.53, &[0.1, 0.03, 0.012][..]), (0.0, &[0.011, 1e-3, 1e-6, 1e-18, 1e-30])] {
        let wide = mean(expected);
        for angle in angles {
            let narrow = mean(*angle);
            assert!((narrow - wide).abs() < 1e-3 * wide, "{angle} degrees: {narrow}, and {wide} of {expected}");
        }
    }
}
