//! Fog, even and thinning out with height, against closed forms and quadrature.

use super::*;

const FOG: [f64; 3] = [0.5, 0.25, 0.125];

/// One pixel that looks from `eye` at `target`, where a large wall across the view shines with 1, in `fog`.
fn towards(eye: [f64; 3], target: [f64; 3], fog: Value) -> Value {
    let normal = [0, 1, 2].map(|i| eye[i] - target[i]);
    json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "orthographic": { "eye": eye, "look_at": target, "up": [0.3, 0.1, 1], "height": 1e-3 } },
        "ambient": 0,
        "lights": [],
        "fog": fog,
        "materials": { "lamp": { "diffuse": 0, "emission": 1 } },
        "objects": [{ "disc": { "center": target, "normal": normal, "radius": 1, "material": "lamp" } }]
    })
}

/// What is left of 1 at an optical depth, and the fog's own light.
fn faded(depth: f64) -> [f64; 3] {
    FOG.map(|fog| fog + (1.0 - fog) * (-depth).exp())
}

#[track_caller]
fn shows(description: Value, expected: [f64; 3], tolerance: f64, what: &str) {
    for (precision, tolerance) in [("single", tolerance), ("double", 2e-7)] {
        let pixel = pixels(description.clone(), precision)[0].map(f64::from);
        for (got, expected) in pixel.into_iter().zip(expected) {
            assert!((got - expected).abs() < tolerance, "{what}, {precision}: {got} instead of {expected}");
        }
    }
}

#[test]
fn even_fog_fades_by_the_distance() {
    for (density, distance) in [(0.125, 4.0), (1e-6, 2.0), (1e-9, 1.0), (3.0, 10.0)] {
        let scene = towards([distance, 0.0, 0.0], [0.0; 3], json!({ "color": FOG, "density": density }));
        shows(scene, faded(density * distance), 3e-7, &format!("{density} over {distance}"));
    }
}

#[test]
fn thin_fog_is_not_lost_to_rounding() {
    // Nothing but the fog's own light: 1 - e^-x for an x far below a rounding of 1.
    let mut scene = towards([1.0, 0.0, 0.0], [0.0; 3], json!({ "color": 1, "density": 1e-12 }));
    scene["materials"]["lamp"]["emission"] = json!(0);
    for precision in ["single", "double"] {
        let pixel = f64::from(pixels(scene.clone(), precision)[0][0]);
        assert!((pixel / 1e-12 - 1.0).abs() < 1e-6, "{precision}: {pixel}");
    }
}

#[test]
fn even_fog_hides_the_background_and_high_fog_does_not() {
    let sky = |eye: [f64; 3], to: [f64; 3], fog: Value| {
        let mut scene = towards(eye, to, fog);
        scene["background"] = json!(1);
        scene["objects"][0]["disc"]["center"] = json!([0, 0, 1e6]);
        scene
    };
    shows(sky([0.0; 3], [1.0, 0.5, 0.0], json!({ "color": FOG, "density": 1e-3 })), FOG, 1e-7, "even");
    let high = json!({ "color": FOG, "density": 0.5, "height": { "base": 1, "falloff": 2 } });
    // Straight up from the base: density times falloff. From below at slope 0.6: 1/0.6 more, and all of it by 1/0.6.
    shows(sky([0.0, 1.0, 0.0], [0.0, 2.0, 0.0], high.clone()), faded(1.0), 3e-7, "up");
    shows(sky([0.0, 0.0, 0.0], [0.8, 0.6, 0.0], high.clone()), faded(0.5 * 3.0 / 0.6), 3e-7, "sloping");
    shows(sky([0.0, 9.0, 0.0], [0.8, 8.4, 0.0], high.clone()), FOG, 1e-7, "down");
    shows(sky([0.0, 5.0, 0.0], [1.0, 5.0, 0.0], high), FOG, 1e-7, "level");
}

#[test]
fn fog_hides_the_surroundings_from_rays_and_not_their_light_on_surfaces() {
    let mut clear = towards([3.0, 0.0, 0.0], [0.0; 3], json!({ "density": 0 }));
    clear["environment"] = json!({ "sky": {}, "light": "fast" });
    clear["materials"]["lamp"] = json!({ "diffuse": 0.8 });
    let lit = pixels(clear.clone(), "double")[0].map(f64::from);
    assert!(lit[0] > 0.1, "{lit:?}");
    let mut foggy = clear.clone();
    foggy["fog"] = json!({ "color": 0, "density": 0.1 });
    for materials in [json!({}), json!({ "unused": { "transmission": 0.5 } })] {
        foggy["materials"].as_object_mut().unwrap().extend(materials.as_object().unwrap().clone());
        shows(foggy.clone(), lit.map(|light| light * (-0.3_f64).exp()), 1e-6, "a wall in fog under a sky");
    }
    assert!(effects(&foggy).has(Effect::EnvironmentLight));
    let past = json!({ "orthographic": { "eye": [3, 0, 0], "look_at": [9, 0, 0], "height": 1e-3 } });
    foggy["camera"] = past;
    shows(foggy, [0.0; 3], 1e-6, "the sky in fog");
}

#[test]
fn fog_that_thins_out_agrees_with_quadrature() {
    let fog = json!({ "color": FOG, "density": 0.25, "height": { "base": 0.5, "falloff": 1.5 } });
    let ends: [[f64; 3]; 5] = [[0.0, 3.0, 1.0], [4.0, 0.5, 0.0], [-2.0, -3.0, 5.0], [3.0, 3.0, -4.0], [1.0, 0.25, 2.0]];
    for eye in ends {
        for target in ends {
            if eye == target {
                continue;
            }
            let length = [0, 1, 2].map(|i| (eye[i] - target[i]).powi(2)).iter().sum::<f64>().sqrt();
            let steps = 200_000;
            let density = |i: i32| {
                let y = eye[1] + (target[1] - eye[1]) * (f64::from(i) + 0.5) / f64::from(steps);
                0.25 * (-((y - 0.5) / 1.5).max(0.0)).exp()
            };
            let depth = (0..steps).map(density).sum::<f64>() * length / f64::from(steps);
            shows(towards(eye, target, fog.clone()), faded(depth), 1e-6, &format!("{eye:?} to {target:?}"));
        }
    }
}

#[test]
fn mirrored_ways_add_up_and_glass_is_clear_inside() {
    let fog = json!({ "color": FOG, "density": 0.25 });
    let mut scene = towards([0.0, 0.0, 3.0], [0.0; 3], fog.clone());
    scene["materials"]["mirror"] = json!({ "diffuse": 0, "reflection": 1 });
    scene["objects"] = json!([
        { "plane": { "point": [0, 0, 0], "normal": [0, 0, 1], "material": "mirror" } },
        { "plane": { "point": [0, 0, 4], "normal": [0, 0, -1], "material": "lamp" } }
    ]);
    shows(scene, faded(0.25 * 7.0), 3e-7, "in a mirror");
    let mut scene = towards([0.0, 0.0, 5.0], [0.0; 3], fog);
    scene["materials"]["glass"] = json!({ "diffuse": 0, "transmission": 1 });
    let block = json!({ "box": { "min": [-9, -9, 1], "max": [9, 9, 3], "material": "glass" } });
    scene["objects"].as_array_mut().unwrap().push(block);
    shows(scene, faded(0.25 * 3.0), 3e-7, "through glass");
}

#[test]
fn fog_of_density_0_is_not_called_for() {
    for (density, calls) in [(0.0, false), (1e-60, false), (1e-3, true)] {
        let scene = towards([1.0, 0.0, 0.0], [0.0; 3], json!({ "density": density }));
        let world = match super::scene(scene, "single").world {
            Precise::Single(world) => world.effects.has(Effect::Fog),
            Precise::Double(_) => unreachable!(),
        };
        assert_eq!(world, calls, "{density}");
    }
}

#[test]
fn broken_fog_is_refused() {
    for (fog, pointer) in [
        (json!({}), "/fog"),
        (json!({ "density": -1 }), "/fog/density"),
        (json!({ "density": 1e16 }), "/fog/density"),
        (json!({ "density": 1, "color": [1, -1, 1] }), "/fog/color"),
        (json!({ "density": 1, "colour": 1 }), "/fog/colour"),
        (json!({ "density": 1, "height": {} }), "/fog/height"),
        (json!({ "density": 1, "height": { "falloff": 0 } }), "/fog/height/falloff"),
        (json!({ "density": 1, "height": { "falloff": 1, "base": 1e16 } }), "/fog/height/base"),
    ] {
        assert_eq!(problems(&towards([1.0, 0.0, 0.0], [0.0; 3], fog)), [pointer]);
    }
}
