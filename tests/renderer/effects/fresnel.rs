//! Reflection and transmission by the angle of incidence, held against Fresnel's formulas as textbooks write them.

use super::*;

/// Fresnel's reflectance of unpolarised light that comes at `degrees` from n1 to n2.
fn reflectance(degrees: f64, n1: f64, n2: f64) -> f64 {
    let (sin1, cos1) = degrees.to_radians().sin_cos();
    let sin2 = sin1 * n1 / n2;
    if sin2 >= 1.0 {
        return 1.0;
    }
    let cos2 = (1.0 - sin2 * sin2).sqrt();
    let perpendicular = (n1 * cos1 - n2 * cos2) / (n1 * cos1 + n2 * cos2);
    let parallel = (n2 * cos1 - n1 * cos2) / (n2 * cos1 + n1 * cos2);
    (perpendicular * perpendicular + parallel * parallel) / 2.0
}

/// One pixel that looks `degrees` from the normal onto the plane z = 0, where `body` lies, between two walls that shine:
/// the one in front with 1, the one behind with `behind`.
fn onto(degrees: f64, body: Value, material: Value, behind: f64) -> Value {
    let (sin, cos) = degrees.to_radians().sin_cos();
    json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "orthographic": { "eye": [sin, 0, cos], "look_at": [0, 0, 0], "height": 1e-3 } },
        "ambient": 0,
        "lights": [],
        "materials": {
            "it": material,
            "front": { "diffuse": 0, "emission": 1 },
            "back": { "diffuse": 0, "emission": behind }
        },
        "objects": [
            body,
            { "plane": { "point": [0, 0, 9], "normal": [0, 0, -1], "material": "front" } },
            { "plane": { "point": [0, 0, -9], "normal": [0, 0, 1], "material": "back" } }
        ]
    })
}

fn quad() -> Value {
    json!({ "quad": { "vertices": [[-99, -9, 0], [99, -9, 0], [99, 9, 0], [-99, 9, 0]], "material": "it" } })
}

#[track_caller]
fn shows(description: Value, expected: [f64; 3], what: &str) {
    for precision in ["single", "double"] {
        let pixel = pixels(description.clone(), precision)[0].map(f64::from);
        for (got, expected) in pixel.into_iter().zip(expected) {
            assert!((got - expected).abs() < 2e-6, "{what}, {precision}: {got} instead of {expected}");
        }
    }
}

#[test]
fn a_varnish_mirrors_what_fresnel_says_from_both_sides() {
    for ior in [1.33, 1.5, 2.42, 0.8] {
        for degrees in [0.0, 30.0, 50.0, f64::atan(ior).to_degrees(), 75.0, 89.0] {
            let material = json!({ "diffuse": 0, "reflection": [1, 0.5, 0], "fresnel": "dielectric", "ior": ior });
            let f = reflectance(degrees, 1.0, ior);
            shows(onto(degrees, quad(), material.clone(), 0.0), [f, f / 2.0, 0.0], &format!("{ior} at {degrees}"));
            let mut behind = onto(degrees, quad(), material, 0.0);
            let eye = &mut behind["camera"]["orthographic"]["eye"];
            eye[2] = json!(-eye[2].as_f64().unwrap());
            behind["materials"]["back"]["emission"] = json!(1);
            shows(behind, [f, f / 2.0, 0.0], &format!("{ior} at {degrees} from behind"));
        }
    }
    // (n - 1)^2 / (n + 1)^2, and at Brewster's angle half of ((n^2 - 1)/(n^2 + 1))^2.
    assert!((reflectance(0.0, 1.0, 1.5) - 0.04).abs() < 1e-15);
    assert!((reflectance(1.5f64.atan().to_degrees(), 1.0, 1.5) - (1.25f64 / 3.25).powi(2) / 2.0).abs() < 1e-15);
}

#[test]
fn what_a_sheet_does_not_reflect_it_transmits() {
    for degrees in [0.0, 20.0, 56.0, 80.0, 89.0] {
        let material = json!({ "diffuse": 0, "reflection": 1, "transmission": 1, "fresnel": "dielectric" });
        shows(onto(degrees, quad(), material, 1.0), [1.0; 3], &format!("energy at {degrees}"));
        let material = json!({ "diffuse": 0, "reflection": 1, "transmission": 0.5, "fresnel": "dielectric" });
        let f = reflectance(degrees, 1.0, 1.5);
        shows(onto(degrees, quad(), material, 4.0), [f + (1.0 - f) * 2.0; 3], &format!("{degrees}"));
    }
}

#[test]
fn a_glass_block_shows_the_wall_in_front_by_the_square_of_what_passes() {
    // Depth 4: into the block, out of it behind, and one reflection inside that comes out in front.
    let material = json!({ "diffuse": 0, "reflection": 1, "transmission": 1, "fresnel": "dielectric", "ior": 1.5 });
    let block = json!({ "box": { "min": [-99, -99, -1], "max": [99, 99, 0], "material": "it" } });
    for degrees in [0.0f64, 40.0, 70.0] {
        let mut scene = onto(degrees, block.clone(), material.clone(), 10.0);
        scene["render"] = json!({ "max_depth": 4, "min_weight": 0 });
        let f = reflectance(degrees, 1.0, 1.5);
        // Stokes: the same share at both surfaces.
        let expected = f + (1.0 - f) * (1.0 - f) * (10.0 + f);
        for precision in ["single", "double"] {
            let pixel = f64::from(pixels(scene.clone(), precision)[0][0]);
            assert!((pixel - expected).abs() < 1e-5, "{precision} at {degrees}: {pixel} instead of {expected}");
        }
    }
}

#[test]
fn total_internal_reflection_keeps_r_s_only() {
    // From inside the block, at 60 degrees, beyond the critical angle of 41.8.
    let (sin, cos) = 60f64.to_radians().sin_cos();
    for (fresnel, expected) in [("dielectric", 0.75), ("none", 1.0)] {
        let material =
            json!({ "diffuse": 0, "reflection": 0.75, "transmission": 0.25, "fresnel": fresnel, "ior": 1.5 });
        let mut scene = onto(0.0, json!(null), material, 0.0);
        scene["camera"]["orthographic"]["eye"] = json!([sin, 0, cos]);
        scene["objects"] = json!([
            { "box": { "min": [-99, -99, 0], "max": [99, 99, 9], "material": "it" } },
            { "sphere": { "center": [-sin, 0, cos], "radius": 0.25, "material": "front" } }
        ]);
        shows(scene, [expected; 3], fresnel);
    }
}

#[test]
fn between_equal_media_a_dielectric_is_invisible() {
    let material = json!({ "diffuse": 0, "reflection": 1, "transmission": 1, "fresnel": "dielectric", "ior": 1 });
    for degrees in [0.0, 45.0, 89.9] {
        let block = json!({ "box": { "min": [-99, -99, -1], "max": [99, 99, 0], "material": "it" } });
        shows(onto(degrees, block, material.clone(), 0.5), [0.5; 3], &format!("block at {degrees}"));
        shows(onto(degrees, quad(), material.clone(), 0.5), [0.5; 3], &format!("sheet at {degrees}"));
    }
}

#[test]
fn conductors_follow_schlick() {
    for degrees in [0.0f64, 30.0, 60.0, 85.0] {
        let material = json!({ "diffuse": 0, "reflection": [0.9, 0.5, 0], "fresnel": "conductor" });
        let k = (1.0 - degrees.to_radians().cos()).powi(5);
        let expected = [0.9, 0.5, 0.0].map(|r: f64| r + (1.0 - r) * k);
        shows(onto(degrees, quad(), material, 0.0), expected, &format!("at {degrees}"));
        let gold_leaf = json!({ "diffuse": 0, "reflection": 0.75, "transmission": 0.25, "fresnel": "conductor" });
        shows(onto(degrees, quad(), gold_leaf, 1.0), [1.0; 3], &format!("energy at {degrees}"));
    }
}

#[test]
fn materials_that_ask_for_nothing_are_left_alone() {
    let call = |material: Value| effects(&onto(0.0, quad(), material, 0.0)).has(Effect::Fresnel);
    assert!(!call(json!({ "fresnel": "none", "reflection": 1 })));
    assert!(!call(json!({ "fresnel": "dielectric" })), "nothing to share out");
    assert!(call(json!({ "fresnel": "dielectric", "reflection": 1 })));
    assert!(call(json!({ "fresnel": "conductor" })));
    let mut shallow = onto(0.0, quad(), json!({ "fresnel": "conductor" }), 0.0);
    shallow["render"] = json!({ "max_depth": 1 });
    assert!(!effects(&shallow).has(Effect::Fresnel));
}

#[test]
fn other_names_are_refused() {
    assert_eq!(problems(&onto(0.0, quad(), json!({ "fresnel": "schlick" }), 0.0)), ["/materials/it/fresnel"]);
}

/// Normals that lean around the rim of a pane and are upright far below, as files of other programs have them, shut no light in: in
/// surroundings of one color clear glass shows that color. Light that did not leave the pane would be cut off after ten rays.
#[test]
fn glass_with_leaning_normals_shuts_no_light_in() {
    let (mut vertices, mut normals, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    for (height, lean) in [(-3.0, 0.0), (0.0, 0.0), (1.0, 0.45_f64)] {
        for (x, side) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            vertices.push([x, height, 0.03 * side]);
            normals.push([0.0, lean, (1.0 - lean * lean).sqrt() * side]);
        }
    }
    let mut quad = |[a, b, c, d]: [u32; 4]| faces.extend([[a, b, c], [a, c, d]]);
    for row in [0, 4] {
        for side in [[1, 3, 7, 5], [2, 0, 4, 6], [0, 1, 5, 4], [3, 2, 6, 7]] {
            quad(side.map(|corner: u32| corner + row));
        }
    }
    quad([9, 11, 10, 8]);
    quad([0, 2, 3, 1]);
    for material in [
        json!({ "diffuse": 0, "transmission": 1, "reflection": 1, "ior": 1.5, "fresnel": "dielectric" }),
        json!({ "pbr": { "metallic": 0, "roughness": 0, "transmission": 1 } }),
    ] {
        let scene = json!({
            "version": 1, "image": { "width": 24, "height": 24 },
            "camera": { "pinhole": { "eye": [0, 3, 6], "look_at": [0, 0.5, 0], "vfov_deg": 8 } },
            "background": 1, "ambient": 0, "lights": [], "materials": { "glass": material },
            "objects": [{ "mesh": { "vertices": vertices, "normals": normals, "faces": faces, "material": "glass" } }],
            "render": { "max_depth": 10, "min_weight": 0.001, "antialias": false }
        });
        for precision in ["single", "double"] {
            for pixel in pixels(scene.clone(), precision) {
                assert!(pixel[0] > 0.9, "{pixel:?}");
            }
        }
    }
}
