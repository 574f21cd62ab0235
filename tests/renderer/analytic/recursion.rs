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

/// What is gathered and what goes straight on end at the greatest depth, too, and trees say so.
#[test]
fn trees_name_every_kind_of_ray_that_the_depth_ends() {
    let holes = json!({ "pbr": { "unlit": true, "opacity": { "alpha": 0.5 } } });
    for (material, render, kind) in [
        (json!({ "diffuse": 0.5 }), json!({ "max_depth": 2, "fidelity": "faithful", "samples": 1 }), "gathered"),
        (holes, json!({ "max_depth": 2 }), "transmitted"),
    ] {
        let plane = |y: f64| json!({ "plane": { "point": [0, y, 0], "normal": [0, 1, 0], "material": "it" } });
        let more = json!({ "materials": { "it": material }, "background": 1, "render": render });
        for world in &worlds(json!([plane(0.0), plane(-1.0), plane(20.0)]), more) {
            let tree = trace_pixel(&world.scene, 0, 0);
            assert_eq!(tree.rays.iter().filter(|ray| ray.hit.is_some()).count(), 2, "one for each depth");
            let ended: Vec<_> = tree.rays.iter().flat_map(|ray| &ray.not_followed).collect();
            let names: Vec<_> = ended.iter().map(|end| (serde_json::to_value(end.kind).unwrap(), end.why)).collect();
            assert_eq!(names, [(json!(kind), "depth")]);
            assert_eq!(ended[0].weight, [0.25; 3]);
        }
    }
}

/// Light that goes on for thousands of rays is followed to the depth that pictures are held against: they were black, and
/// beyond 4,096 rays nothing was proved.
#[test]
fn nearly_lossless_mirrors_are_followed_to_the_depth_of_their_scene() {
    let mirror = |x: f64| json!({ "plane": { "point": [x, 0, 0], "normal": [-x, 0, 0], "material": "mirror" } });
    for depth in [300, 1_000, 6_000] {
        let settings = json!({ "max_depth": depth, "antialias": false, "accuracy": { "proved": { "max_codes": 1 } } });
        let more = json!({
            "materials": { "mirror": { "diffuse": 0, "ambient": 0.0001, "reflection": 0.9999 } },
            "camera": { "pinhole": { "eye": [0, 0, 0], "look_at": [1, 0, 0] } },
            "ambient": 1, "render": settings
        });
        for World { scene, .. } in &worlds(json!([mirror(1.0), mirror(-1.0)]), more) {
            let picture = render(scene, Region::whole(scene.width, scene.height), &Control::default()).unwrap();
            let sum = 1.0 - 0.9999f64.powi(depth);
            let (shown, proof) = (f64::from(picture.film.pixels[0][0]), picture.proof());
            assert!(proof.max_linear.is_some(), "depth {depth}: {proof:?}");
            // Rays get more room where a proof needs them: trees do not say that they were dropped.
            let tree = trace_pixel(scene, 0, 0);
            assert!(
                tree.rays.len() > 250
                    && tree.rays.iter().all(|ray| ray.not_followed.iter().all(|end| end.why != "budget"))
            );
            let missing = f64::from(proof.max_linear.unwrap()[0]);
            // Thousands of weights in a chain are rounded, and so is 0.9999.
            let rounded = 1e-8 * f64::from(depth);
            assert!(
                shown > 0.8 * sum && (shown..=shown + missing + rounded).contains(&sum) || (shown - sum).abs() < 0.005,
                "depth {depth}: {shown} of {sum}, {proof:?}"
            );
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
