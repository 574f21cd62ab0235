//! Closed rooms, from which no ray leaves: what is around them lights nothing and costs nothing, however they are written.

use super::*;
use strahl::scene::effects::Effect;

/// A ball in a room, below a sky that lights surfaces.
fn in_a_room(room: Value) -> Value {
    json!({
        "version": 1, "image": { "width": 48, "height": 36 },
        "camera": { "pinhole": { "eye": [0, 1, 4], "look_at": [0, 0.7, 0], "vfov_deg": 60 } },
        "environment": { "sky": {}, "light": "fast" },
        "lights": [{ "point": { "position": [1, 3, 2], "intensity": 0.5 } }],
        "materials": { "glass": { "transmission": 0.9 } },
        "objects": [{ "sphere": { "center": [0, 0.7, 0], "radius": 0.7 } }, room]
    })
}

fn cuboid() -> Value {
    json!({ "box": { "min": [-5, 0, -5], "max": [5, 5, 5] } })
}

fn group(transform: Value, objects: &[Value]) -> Value {
    json!({ "group": { "transform": transform, "objects": objects } })
}

/// The same box in triangles, of which some are left out.
fn mesh(left_out: usize) -> Value {
    let vertices: Vec<[f64; 3]> = (0..8)
        .map(|i| {
            [
                if i & 1 == 0 { -5.0 } else { 5.0 },
                if i & 2 == 0 { 0.0 } else { 5.0 },
                if i & 4 == 0 { -5.0 } else { 5.0 },
            ]
        })
        .collect();
    let mut faces = vec![
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    faces.truncate(12 - left_out);
    json!({ "mesh": { "vertices": vertices, "faces": faces } })
}

fn is_lit_from_around(room: Value) -> bool {
    let on = effects(&in_a_room(room));
    assert_eq!(on.has(Effect::EnvironmentMap), on.has(Effect::EnvironmentLight));
    on.has(Effect::EnvironmentLight)
}

/// A turn by a thousandth of a degree changed the mean of a picture by 65 codes.
#[test]
fn closed_rooms_are_dark_however_they_are_written() {
    let turned = |angle: f64| json!({ "rotate_deg": { "axis": [0, 1, 0], "angle": angle } });
    let rooms = [
        cuboid(),
        group(json!({}), &[cuboid()]),
        group(turned(0.001), &[cuboid()]),
        group(
            turned(30.0),
            &[
                group(json!({ "scale": 1.5 }), &[cuboid()]),
                json!({ "plane": { "point": [0, -20, 0], "normal": [0, 1, 0] } }),
            ],
        ),
        mesh(0),
        group(turned(30.0), &[mesh(0)]),
        group(json!({ "scale": [2, 1, 2] }), &[json!({ "sphere": { "center": [0, 1, 0], "radius": 4 } })]),
    ];
    for room in rooms {
        assert!(!is_lit_from_around(room.clone()), "{room}");
    }
}

/// Neither many other objects before the room, some of which hold the eye, nor a face of its mesh whose plane runs through the eye.
#[test]
fn what_else_there_is_does_not_matter() {
    let dust = |i: usize| json!({ "sphere": { "center": [i % 100, -50, i / 100], "radius": 0.1 } });
    let many: Vec<Value> = (0..5_000).map(dust).collect();
    let shells: Vec<Value> = (0..30).map(|_| mesh(1)).collect();
    let crowd = [many.clone(), shells, vec![group(json!({}), &many), mesh(0)]].concat();
    assert!(!is_lit_from_around(group(json!({}), &crowd)));
    let mut scene = in_a_room(mesh(0));
    scene["objects"] = json!([many, vec![cuboid()]].concat());
    assert!(!effects(&scene).has(Effect::EnvironmentLight));
    let mut finned = mesh(0);
    let fin = [[-4.0, 1.0, 4.5], [-4.0, 1.0, -4.0], [4.0, 1.0, -4.0], [-3.0, 0.5, -3.0]];
    finned["mesh"]["vertices"].as_array_mut().unwrap().extend(fin.map(|point| json!(point)));
    let faces = [[8, 9, 10], [8, 11, 9], [9, 11, 10], [10, 11, 8]];
    finned["mesh"]["faces"].as_array_mut().unwrap().extend(faces.map(|face| json!(face)));
    assert!(!is_lit_from_around(finned));
}

#[test]
fn rooms_with_a_hole_or_a_window_or_beside_the_eye_are_not_closed() {
    let beside = json!({ "translate": [20, 0, 0] });
    let mut glass = cuboid();
    glass["box"]["material"] = json!("glass");
    let rooms = [
        mesh(1),
        group(beside.clone(), &[cuboid()]),
        group(beside, &[mesh(0)]),
        group(json!({}), &[glass]),
        json!({ "cylinder": { "base": [0, 0, 0], "top": [0, 9, 0], "radius": 9, "capped": false } }),
    ];
    for room in rooms {
        assert!(is_lit_from_around(room.clone()), "{room}");
    }
}

/// Rays say so, too: what they see where they hit nothing is in no pixel.
#[test]
fn no_ray_leaves_a_closed_room() {
    for room in [group(json!({ "rotate_deg": { "axis": [1, 2, 3], "angle": 10 } }), &[cuboid()]), mesh(0)] {
        assert!(!is_lit_from_around(room.clone()));
        let mut scene = in_a_room(room);
        scene.as_object_mut().unwrap().remove("environment");
        scene["materials"]["mirror"] = json!({ "reflection": 0.9 });
        scene["objects"][0]["sphere"]["material"] = json!("mirror");
        let [dark, bright] = [0, 100].map(|background| {
            scene["background"] = json!(background);
            pixels(scene.clone(), "single")
        });
        assert!(dark == bright);
        scene["objects"].as_array_mut().unwrap().pop();
        assert!(dark != pixels(scene, "single"), "without the room they see it");
    }
}
