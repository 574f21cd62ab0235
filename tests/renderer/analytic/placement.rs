//! Shapes in groups and instances.

use super::*;

fn placed(transform: Value) -> [World; 2] {
    let more = json!({ "definitions": { "ball": [{ "sphere": { "center": [0, 0, 0], "radius": 1 } }] } });
    worlds(json!([{ "instance": { "of": "ball", "transform": transform } }]), more)
}

#[test]
fn normals_of_stretched_instances_are_those_of_the_ellipsoid() {
    let ellipsoid = placed(json!({ "scale": [2, 1, 1] }));
    hits(&ellipsoid, [5.0, 0.0, 0.0], minus(X), 3.0, X, true);
    hits(&ellipsoid, [1.2, 5.0, 0.0], minus(Y), 4.2, [0.3, 0.8, 0.0], true);
    hits(&ellipsoid, [0.0, 0.0, 0.0], X, 2.0, X, false);
    misses(&ellipsoid, [0.0, 5.0, 1.1], minus(Y));
}

#[test]
fn mirrored_instances_keep_their_outside() {
    let mirrored = placed(json!({ "scale": [-2, 1, 1], "translate": [1, 0, 0] }));
    hits(&mirrored, [2.2, 5.0, 0.0], minus(Y), 4.2, [0.3, 0.8, 0.0], true);
    hits(&mirrored, [1.0, 0.0, 0.0], X, 2.0, X, false);
    let more = json!({ "definitions": { "sheet": [
        { "triangle": { "vertices": [[0, 0, 0], [4, 0, 0], [0, 4, 0]], "material": "front" } }
    ] } });
    let sheet = worlds(json!([{ "instance": { "of": "sheet", "transform": { "scale": [-1, 1, 1] } } }]), more);
    hits(&sheet, [-1.0, 1.0, 3.0], minus(Z), 3.0, Z, true);
    misses(&sheet, [-1.0, 1.0, -3.0], Z);
}

#[test]
fn scale_comes_before_rotation_and_rotation_before_translation() {
    let turned = placed(json!({
        "scale": [3, 1, 1], "rotate_deg": { "axis": [0, 0, 2], "angle": 90 }, "translate": [10, 0, 0]
    }));
    hits(&turned, [10.0, 5.0, 0.0], minus(Y), 2.0, Y, true);
    hits(&turned, [15.0, 0.0, 0.0], minus(X), 4.0, X, true);
    // Columns: x to 3y, y to -x, z to z, and the place.
    let same = placed(json!({ "matrix": [0, 3, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1] }));
    hits(&same, [10.0, 5.0, 0.0], minus(Y), 2.0, Y, true);
    hits(&same, [15.0, 0.0, 0.0], minus(X), 4.0, X, true);
}

#[test]
fn placements_nest_and_answers_point_at_the_object_and_at_the_body() {
    let more = json!({ "definitions": {
        "ball": [
            { "sphere": { "center": [0, 9, 0], "radius": 1, "name": "other" } },
            { "sphere": { "center": [1, 0, 0], "radius": 1 } }
        ],
        "pair": [{ "instance": { "of": "ball", "name": "right", "transform": { "translate": [2, 0, 0] } } }]
    } });
    let objects = json!([
        { "sphere": { "center": [0, 0, 50], "radius": 1, "name": "alone" } },
        { "group": { "transform": { "translate": [0, 0, -5] }, "name": "outer", "objects": [
            { "group": { "objects": [
                { "instance": { "of": "pair", "transform": { "scale": 2 } } },
                { "disc": { "center": [0, -9, 0], "normal": [0, 1, 0], "radius": 1 } }
            ] } }
        ] } }
    ]);
    let nested = worlds(objects, more);
    // Centre (1 + 2) * 2 = 6, radius 2.
    hits(&nested, [6.0, 0.0, 0.0], minus(Z), 3.0, Z, true);
    hits(&nested, [6.0, 0.0, -5.0], X, 2.0, X, false);
    for world in &nested {
        let names = |origin: [f64; 3], direction| {
            let hit = query(world, origin, direction).unwrap();
            (hit.object, hit.body.unwrap_or_default(), hit.name.unwrap_or_default())
        };
        let expected = |object: &str, body: &str, name: &str| (object.to_owned(), body.to_owned(), name.to_owned());
        assert_eq!(names([0.0, 0.0, 50.0], X), expected("/objects/0", "", "alone"));
        assert_eq!(names([6.0, 0.0, 0.0], minus(Z)), expected("/objects/1", "/definitions/ball/1", "right"));
        assert_eq!(names([4.0, 18.0, 0.0], minus(Z)), expected("/objects/1", "/definitions/ball/0", "other"));
        let disc = expected("/objects/1", "/objects/1/group/objects/0/group/objects/1", "outer");
        assert_eq!(names([0.0, -8.0, -5.0], minus(Y)), disc);
    }
}

#[test]
fn planes_may_be_placed_too() {
    let more = json!({ "definitions": { "floor": [{ "plane": { "point": [0, 1, 0], "normal": [0, 1, 0] } }] } });
    let floor = worlds(json!([{ "instance": { "of": "floor", "transform": { "scale": 3 } } }]), more);
    hits(&floor, [7.0, 5.0, 7.0], minus(Y), 2.0, Y, true);
}

#[test]
fn of_two_bodies_in_one_place_the_first_one_written_is_hit() {
    let disc = |name: &str| json!({ "disc": { "center": [0, 0, 0], "normal": [0, 0, 1], "radius": 1, "name": name } });
    for world in &bodies(json!([disc("a"), disc("b"), disc("c")])) {
        assert_eq!(query(world, [0.3, 0.2, 1.0], minus(Z)).unwrap().name.as_deref(), Some("a"));
    }
}
