//! Bodies that absorb light, against the law of Beer and Lambert, and the shadows they cast.

use super::*;

/// One pixel that looks from (0, 0, 5) down the z axis at `objects` of an absorbing glass, under a white sky.
fn through(objects: Value, ior: f64) -> Value {
    json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "orthographic": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "height": 1e-3 } },
        "background": 1,
        "ambient": 0,
        "lights": [],
        "materials": {
            "ink": { "diffuse": 0, "transmission": 1, "ior": ior, "absorption": [0.25, 1, 0] },
            "milk": { "diffuse": 0, "transmission": 1, "ior": ior, "absorption": [0.5, 0, 2] },
            "matt": { "diffuse": 1 }
        },
        "objects": objects
    })
}

fn slab(from: f64, to: f64, material: &str) -> Value {
    json!({ "box": { "min": [-99, -99, from], "max": [99, 99, to], "material": material } })
}

#[track_caller]
fn shows(description: Value, expected: [f64; 3], what: &str) {
    for precision in ["single", "double"] {
        let pixel = pixels(description.clone(), precision)[0].map(f64::from);
        for (got, expected) in pixel.into_iter().zip(expected) {
            assert!((got - expected).abs() < 1e-6, "{what}, {precision}: {got} instead of {expected}");
        }
    }
}

/// e^-(sigma d) of ink and milk.
fn left(ink: f64, milk: f64) -> [f64; 3] {
    [0.25 * ink + 0.5 * milk, ink, 2.0 * milk].map(|depth| (-depth).exp())
}

#[test]
fn slabs_obey_beer_and_lambert() {
    for ior in [1.0, 1.5, 2.4] {
        for thick in [0.0625, 1.0, 3.5] {
            shows(through(json!([slab(-thick, 0.0, "ink")]), ior), left(thick, 0.0), &format!("{thick} of {ior}"));
        }
        let two = json!([slab(-1.0, 0.0, "ink"), slab(-4.0, -3.0, "milk")]);
        shows(through(two, ior), left(1.0, 1.0), &format!("two slabs of {ior}"));
    }
}

#[test]
fn oblique_rays_go_a_longer_way() {
    for degrees in [20.0f64, 60.0, 80.0] {
        let mut scene = through(json!([slab(-1.0, 0.0, "ink")]), 1.5);
        let (sin, cos) = degrees.to_radians().sin_cos();
        scene["camera"]["orthographic"]["eye"] = json!([sin, 0, cos]);
        let inside = (1.0 - (sin / 1.5).powi(2)).sqrt();
        shows(scene, left(1.0 / inside, 0.0), &format!("{degrees}"));
    }
}

#[test]
fn an_eye_inside_sees_the_rest_of_the_way() {
    let mut scene = through(json!([slab(-1.0, 20.0, "ink")]), 1.5);
    scene["camera"]["orthographic"]["eye"] = json!([0, 0, 0.5]);
    shows(scene, left(1.5, 0.0), "inside");
}

#[test]
fn the_smaller_body_decides_and_cavities_are_empty() {
    for ior in [1.0, 1.5] {
        let mut bubble = slab(-2.0, -1.5, "ink");
        bubble["box"]["hollow"] = json!(true);
        shows(through(json!([slab(-3.0, 0.0, "ink"), bubble]), ior), left(2.5, 0.0), "a bubble");
        let inside = json!([slab(-2.0, -1.0, "milk"), slab(-3.0, 0.0, "ink")]);
        shows(through(inside, ior), left(2.0, 1.0), "one in the other");
        let overlap = json!([slab(-2.0, 0.0, "ink"), slab(-2.5, -1.0, "milk")]);
        shows(through(overlap, ior), left(1.0, 1.5), "overlap");
        let touching = json!([slab(-1.0, 0.0, "ink"), slab(-2.0, -1.0, "milk")]);
        shows(through(touching, ior), left(1.0, 1.0), "touching");
    }
}

#[test]
fn an_endless_body_leaves_what_it_does_not_absorb() {
    let pool = json!([{ "plane": { "point": [0, 0, 0], "normal": [0, 0, 1], "material": "ink" } }]);
    shows(through(pool, 1.33), [0.0, 0.0, 1.0], "half of all space");
}

#[test]
fn lengths_are_those_of_the_world() {
    let placed = json!([{ "group": { "transform": { "scale": 4 }, "objects": [slab(-0.5, 0.0, "ink")] } }]);
    shows(through(placed, 1.5), left(2.0, 0.0), "four times as large");
}

/// A floor at z = 0 seen along the z axis from under `objects`, and lit by the sun at 60 degrees from the zenith.
fn shadow(objects: Value) -> Value {
    let mut scene = through(objects, 1.5);
    scene["camera"]["orthographic"]["eye"] = json!([0, 0, 0.5]);
    let (sin, cos) = 60f64.to_radians().sin_cos();
    scene["lights"] = json!([{ "directional": { "direction": [sin, 0, -cos] } }]);
    scene["render"] = json!({ "shadows": "transmissive" });
    let floor = json!({ "plane": { "point": [0, 0, 0], "normal": [0, 0, 1], "material": "matt" } });
    scene["objects"].as_array_mut().unwrap().push(floor);
    scene
}

/// Half of it is left by the cosine.
fn halved(ink: f64, milk: f64) -> [f64; 3] {
    left(ink, milk).map(|c| c / 2.0)
}

#[test]
fn shadows_take_the_color_of_what_light_passes() {
    // At 60 degrees the way through a slab is twice its thickness; light is not bent on its way.
    shows(shadow(json!([slab(1.0, 1.5, "ink")])), halved(1.0, 0.0), "one slab");
    shows(shadow(json!([slab(1.0, 1.5, "ink"), slab(2.0, 2.25, "milk")])), halved(1.0, 0.5), "two slabs");
    let mut bubble = slab(1.5, 2.0, "ink");
    bubble["box"]["hollow"] = json!(true);
    shows(shadow(json!([slab(1.0, 3.0, "ink"), bubble.clone()])), halved(3.0, 0.0), "a bubble");
    shows(shadow(json!([bubble, slab(1.5, 1.75, "milk"), slab(1.0, 3.0, "ink")])), halved(3.0, 0.5), "and milk in it");
    let overlap = json!([slab(1.0, 2.5, "ink"), slab(2.0, 3.0, "milk")]);
    shows(shadow(overlap), halved(2.0, 2.0), "overlap: the smaller one decides");
}

#[test]
fn light_from_inside_a_body_and_to_a_floor_inside_it() {
    // A lamp 2 above the floor in the middle of a ball of radius 1: 1 of its way is inside.
    let mut scene = shadow(json!([{ "sphere": { "center": [0, 0, 2], "radius": 1, "material": "ink" } }]));
    scene["lights"] = json!([{ "point": { "position": [0, 0, 2] } }]);
    shows(scene, left(1.0, 0.0), "a lamp in a ball");
    // The floor under a pool 1 deep, whose light comes 2 and whose look goes 1 through it.
    let mut scene = shadow(json!([slab(-5.0, 1.0, "ink")]));
    scene["camera"]["orthographic"]["eye"] = json!([0, 0, 5]);
    shows(scene, halved(3.0, 0.0), "under water");
}

#[test]
fn opaque_shadows_stay_black() {
    let mut scene = shadow(json!([slab(1.0, 1.5, "ink")]));
    scene["render"]["shadows"] = json!("opaque");
    assert!(effects(&scene).has(Effect::Absorption) && !effects(&scene).has(Effect::ColoredShadows));
    shows(scene, [0.0; 3], "opaque");
}

#[test]
fn only_bodies_that_light_gets_into_call_for_it() {
    let opaque = json!({ "absorption": 1 });
    let mut scene = through(json!([slab(-1.0, 0.0, "ink")]), 1.5);
    assert!(effects(&scene).has(Effect::Absorption));
    scene["materials"]["ink"] = opaque;
    assert!(!effects(&scene).has_details());
    let mut hollow = slab(-1.0, 0.0, "ink");
    hollow["box"]["hollow"] = json!(true);
    assert!(!effects(&through(json!([hollow]), 1.5)).has_details());
    let disc = json!({ "disc": { "center": [0, 0, 0], "normal": [0, 0, 1], "radius": 1, "material": "ink" } });
    assert!(!effects(&through(json!([disc]), 1.5)).has_details());
}

#[test]
fn broken_absorption_is_refused() {
    for wrong in [json!(-1), json!([0, 0, 1e16])] {
        let mut scene = through(json!([slab(-1.0, 0.0, "ink")]), 1.5);
        scene["materials"]["ink"]["absorption"] = wrong;
        assert_eq!(problems(&scene), ["/materials/ink/absorption"]);
    }
}
