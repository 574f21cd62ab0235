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

/// Those that rays find, and those that are points, also where no number holds the square of their angle.
#[test]
fn the_light_of_narrow_discs_does_not_depend_on_their_angle() {
    let mean = |angle: f64| {
        let pixels = pixels(lit(angle, 0.4, 64), "single");
        pixels.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / pixels.len() as f64
    };
    let wide = mean(0.53);
    for angle in [0.1, 0.03, 0.012, 0.011, 1e-3, 1e-6, 1e-18, 1e-30, 0.0] {
        let narrow = mean(angle);
        assert!((narrow - wide).abs() < 1e-3 * wide, "{angle} degrees: {narrow}, and {wide} of 0.53");
    }
}

/// How much light a ball of polished metal below the sun reflects, with something out of sight between them.
fn highlight(between: Option<&str>, change: fn(&mut Value)) -> f64 {
    let mut scene = json!({
        "version": 1, "image": { "width": 40, "height": 40 }, "ambient": 0,
        "camera": { "pinhole": { "eye": [0, 0, 6], "look_at": [0, 0, 0], "vfov_deg": 22 } },
        "objects": [
            { "sphere": { "center": [0, 0, 0], "radius": 1, "material": "metal" } },
            { "sphere": { "center": [0, -50, 0], "radius": 1, "material": "black" } }
        ],
        "materials": {
            "metal": { "pbr": { "base_color": [0.9, 0.9, 0.9], "metallic": 1, "roughness": 0.17 } },
            "black": { "diffuse": 0, "specular": 0 },
            "hole": { "pbr": { "opacity": { "alpha": 0 } } },
            "veil": { "pbr": { "opacity": { "alpha": 0.5 }, "base_color": [0, 0, 0], "specular": 0 } },
            "veiled": { "pbr": { "transmission": 1, "specular": 0, "thin": true, "metallic": 0, "roughness": 0, "opacity": { "alpha": 0.5 } } },
            "pane": { "pbr": { "transmission": 1, "specular": 0, "thin": true, "metallic": 0, "roughness": 0 } }
        },
        "lights": [{ "directional": { "direction": [0, -1, -1], "color": 1, "area": { "angle_deg": 10 } } }],
        "render": { "fidelity": "faithful", "samples": 256, "shadows": "transmissive" }
    });
    if let Some(material) = between {
        let vertices = json!([[-3, 4.4, 1.6], [3, 4.4, 1.6], [3, 1.6, 4.4], [-3, 1.6, 4.4]]);
        scene["objects"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "quad": { "vertices": vertices, "material": material } }));
    }
    change(&mut scene);
    let all = pixels(scene, "single");
    all.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / all.len() as f64
}

/// What shadow rays let pass and rays of lobes do not see counts all the same, and nothing counts twice.
#[test]
fn highlights_are_seen_through_whatever_lets_light_pass() {
    let as_it_is: fn(&mut Value) = |_| {};
    let opaque: fn(&mut Value) = |scene| scene["render"]["shadows"] = json!("opaque");
    let shallow: fn(&mut Value) = |scene| scene["render"]["max_depth"] = json!(1);
    let fog: fn(&mut Value) = |scene| scene["fog"] = json!({ "color": 0, "density": 1e-6 });
    let free = highlight(None, as_it_is);
    assert!(free > 0.01, "{free}");
    for (what, between, change, share) in [
        ("a hole", Some("hole"), as_it_is, 1.0),
        ("a hole, opaque", Some("hole"), opaque, 1.0),
        ("a veil", Some("veil"), as_it_is, 0.5),
        ("a pane", Some("pane"), as_it_is, 1.0),
        ("a pane that is half there", Some("veiled"), as_it_is, 1.0),
        ("a pane, opaque", Some("pane"), opaque, 0.0),
        ("one reflection", None, shallow, 1.0),
        ("fog", None, fog, 1.0),
    ] {
        let seen = highlight(between, change);
        assert!((seen - share * free).abs() < 0.03 * free, "{what}: {seen}, and {free} without");
    }
}
