//! Answers known on paper, scene by scene.

use super::*;
use glam::DVec3;
use serde_json::{Value, json};

/// A scene of objects under no light but the ambient, which each material's `ambient` turns into what it shows.
fn scene(objects: Value, more: Value) -> Reference {
    let mut description = json!({
        "version": 1,
        "image": { "width": 2, "height": 2 },
        "camera": { "pinhole": { "eye": [0, 0, 10], "look_at": [0, 0, 0] } },
        "ambient": 1,
        "lights": [],
        "background": [0, 0, 1],
        "materials": {
            "black": { "diffuse": 0 },
            "red": { "ambient": [1, 0, 0], "diffuse": 0 },
            "mirror": { "diffuse": 0, "reflection": 0.5 },
            "glass": { "diffuse": 0, "transmission": 1, "ior": 1.5 },
            "dense": { "diffuse": 0, "transmission": 1, "ior": 3 },
            "front": { "ambient": [1, 0, 0], "diffuse": 0, "one_sided": true }
        },
        "objects": objects,
        "render": { "max_depth": 20, "min_weight": 0 }
    });
    for (key, value) in more.as_object().unwrap() {
        description[key] = value.clone();
    }
    Reference::new(&serde_json::from_value(description).unwrap())
}

fn shape(objects: Value) -> Reference {
    scene(objects, json!({}))
}

fn assert_hit(reference: &Reference, origin: [f64; 3], dir: [f64; 3], t: f64, normal: [f64; 3]) {
    let hit = reference.closest_hit(origin, dir, 0.0).expect("a hit");
    assert!((hit.t - t).abs() <= 1e-13 * t.abs().max(1.0), "t = {} instead of {t}", hit.t);
    let expected = DVec3::from(normal).normalize();
    assert!(DVec3::from(hit.normal).abs_diff_eq(expected, 1e-13), "{:?} instead of {expected}", hit.normal);
}

fn assert_miss(reference: &Reference, origin: [f64; 3], dir: [f64; 3]) {
    assert_eq!(reference.closest_hit(origin, dir, 0.0), None);
}

/// What a ray from `origin` along `dir` brings.
fn radiance(reference: &Reference, origin: [f64; 3], dir: [f64; 3]) -> [f64; 3] {
    let ray = Ray { origin: origin.into(), dir: DVec3::from(dir).normalize() };
    whitted::primary_radiance(reference, ray).to_array()
}

fn assert_close(actual: [f64; 3], expected: [f64; 3]) {
    assert!(DVec3::from(actual).abs_diff_eq(expected.into(), 1e-12), "{actual:?} instead of {expected:?}");
}

#[test]
fn sphere() {
    let unit = shape(json!([{ "sphere": { "center": [0, 0, 0], "radius": 1 } }]));
    assert_hit(&unit, [0.6, 0.0, 5.0], [0.0, 0.0, -2.0], 2.1, [0.6, 0.0, 0.8]);
    assert_hit(&unit, [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1.0, [0.0, 1.0, 0.0]);
    assert_miss(&unit, [1.001, 0.0, 5.0], [0.0, 0.0, -1.0]);
    let far = unit.closest_hit([0.6, 0.0, 5.0], [0.0, 0.0, -1.0], 4.2).unwrap();
    assert!((far.t - 5.8).abs() < 1e-14);
    assert_eq!(far.object, "/objects/0");
}

#[test]
fn plane_and_disc() {
    let plane = shape(json!([{ "plane": { "point": [0, 1, 0], "normal": [0, 3, 0] } }]));
    assert_hit(&plane, [0.0, 3.0, 0.0], [1.0, -1.0, 0.0], 2.0, [0.0, 1.0, 0.0]);
    assert_hit(&plane, [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1.0, [0.0, 1.0, 0.0]);
    assert_miss(&plane, [0.0, 3.0, 0.0], [1.0, 0.0, 0.0]);
    let disc = shape(json!([{ "disc": { "center": [0, 0, 0], "normal": [0, 0, 1], "radius": 2 } }]));
    assert_hit(&disc, [1.9, 0.0, 1.0], [0.0, 0.0, -1.0], 1.0, [0.0, 0.0, 1.0]);
    assert_miss(&disc, [1.5, 1.5, 1.0], [0.0, 0.0, -1.0]);
}

#[test]
fn axis_box() {
    let cube = shape(json!([{ "box": { "min": [0, 0, 0], "max": [1, 2, 3] } }]));
    assert_hit(&cube, [-1.0, 1.0, 1.0], [1.0, 0.0, 0.0], 1.0, [-1.0, 0.0, 0.0]);
    assert_hit(&cube, [0.5, 1.0, 1.0], [0.0, 0.0, 1.0], 2.0, [0.0, 0.0, 1.0]);
    assert_hit(&cube, [2.0, 3.0, 1.5], [-1.0, -1.5, 0.0], 1.0, [1.0, 0.0, 0.0]);
    assert_miss(&cube, [-1.0, 2.5, 1.0], [1.0, 0.0, 0.0]);
    let flat = shape(json!([{ "box": { "min": [0, 1, 0], "max": [1, 1, 1] } }]));
    assert_hit(&flat, [0.5, 3.0, 0.5], [0.0, -1.0, 0.0], 2.0, [0.0, 1.0, 0.0]);
    assert_hit(&flat, [0.5, 0.0, 0.5], [0.0, 1.0, 0.0], 1.0, [0.0, -1.0, 0.0]);
}

#[test]
fn cylinder() {
    let closed = shape(json!([{ "cylinder": { "base": [0, 0, 0], "top": [0, 2, 0], "radius": 1 } }]));
    assert_hit(&closed, [0.6, 1.0, 5.0], [0.0, 0.0, -1.0], 4.2, [0.6, 0.0, 0.8]);
    assert_hit(&closed, [0.5, 5.0, 0.0], [0.0, -1.0, 0.0], 3.0, [0.0, 1.0, 0.0]);
    assert_hit(&closed, [0.5, 1.0, 0.0], [0.0, -1.0, 0.0], 1.0, [0.0, -1.0, 0.0]);
    let open = shape(json!([{ "cylinder": { "base": [0, 0, 0], "top": [0, 2, 0], "radius": 1, "capped": false } }]));
    assert_miss(&open, [0.5, 5.0, 0.0], [0.0, -1.0, 0.0]);
    // Through the open top onto the inner wall: the normal stays outward.
    assert_hit(&open, [0.0, 2.5, 0.0], [1.0, -1.0, 0.0], 1.0, [1.0, 0.0, 0.0]);
}

#[test]
fn cone() {
    let pointed = shape(json!([{ "cone": { "base": [0, 0, 0], "base_radius": 1, "top": [0, 2, 0] } }]));
    assert_hit(&pointed, [5.0, 1.0, 0.0], [-1.0, 0.0, 0.0], 4.5, [2.0, 1.0, 0.0]);
    assert_hit(&pointed, [0.5, 5.0, 0.0], [0.0, -1.0, 0.0], 4.0, [2.0, 1.0, 0.0]);
    assert_hit(&pointed, [0.5, -1.0, 0.0], [0.0, 1.0, 0.0], 1.0, [0.0, -1.0, 0.0]);
    // Parallel to the side: the quadratic is linear.
    assert_hit(&pointed, [0.5, 2.0, 0.0], [-1.0, -2.0, 0.0], 0.25, [2.0, 1.0, 0.0]);
    // The second nappe is no part of it.
    assert_miss(&pointed, [5.0, 3.0, 0.0], [-1.0, 0.0, 0.0]);
    let frustum =
        shape(json!([{ "cone": { "base": [0, 0, 0], "base_radius": 1, "top": [0, 2, 0], "top_radius": 2 } }]));
    assert_hit(&frustum, [5.0, 1.0, 0.0], [-1.0, 0.0, 0.0], 3.5, [2.0, -1.0, 0.0]);
    assert_hit(&frustum, [1.9, 3.0, 0.0], [0.0, -1.0, 0.0], 1.0, [0.0, 1.0, 0.0]);
}

#[test]
fn torus() {
    let ring = shape(json!([{ "torus": { "center": [0, 0, 0], "major_radius": 3, "minor_radius": 1 } }]));
    for (t_min, t, normal) in [(0.0, 6.0, 1.0), (7.0, 8.0, -1.0), (9.0, 12.0, 1.0), (13.0, 14.0, -1.0)] {
        let hit = ring.closest_hit([10.0, 0.0, 0.0], [-1.0, 0.0, 0.0], t_min).unwrap();
        assert!((hit.t - t).abs() < 1e-13, "{}", hit.t);
        // Out of the tube: away from its circle of radius 3.
        assert!((hit.normal[0] - normal).abs() < 1e-13, "{:?}", hit.normal);
    }
    assert_hit(&ring, [3.6, 5.0, 0.0], [0.0, -1.0, 0.0], 4.2, [0.6, 0.8, 0.0]);
    assert_miss(&ring, [1.9, 5.0, 0.0], [0.0, -1.0, 0.0]);
    assert_miss(&ring, [4.001, 5.0, 0.0], [0.0, -1.0, 0.0]);
}

#[test]
fn triangle_quad_and_polygon() {
    let triangle = shape(json!([{ "triangle": { "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]] } }]));
    assert_hit(&triangle, [0.25, 0.25, 2.0], [0.0, 0.0, -1.0], 2.0, [0.0, 0.0, 1.0]);
    assert_miss(&triangle, [0.6, 0.6, 2.0], [0.0, 0.0, -1.0]);
    let quad = shape(json!([{ "quad": { "vertices": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]] } }]));
    assert_hit(&quad, [0.9, 0.9, -1.0], [0.0, 0.0, 1.0], 1.0, [0.0, 0.0, 1.0]);
    // An L, seen from above: its front counter-clockwise around +y.
    let concave = shape(json!([{ "polygon": { "vertices":
        [[0, 0, 0], [0, 0, 2], [1, 0, 2], [1, 0, 1], [2, 0, 1], [2, 0, 0]] } }]));
    assert_hit(&concave, [0.5, 1.0, 1.5], [0.0, -1.0, 0.0], 1.0, [0.0, 1.0, 0.0]);
    assert_hit(&concave, [1.5, 1.0, 0.5], [0.0, -1.0, 0.0], 1.0, [0.0, 1.0, 0.0]);
    assert_miss(&concave, [1.5, 1.0, 1.5], [0.0, -1.0, 0.0]);
}

/// A regular tetrahedron around the origin whose vertex normals are its vertices.
fn tetrahedron() -> Value {
    let vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
    json!({ "vertices": vertices, "normals": vertices, "faces": [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
            "material": "glass" })
}

#[test]
fn mesh_is_closed_even_at_its_vertices() {
    let reference = shape(json!([{ "mesh": tetrahedron() }]));
    assert_hit(&reference, [3.0, 3.0, -3.0], [-1.0, -1.0, 1.0], 8.0 / 3.0, [1.0, 1.0, -1.0]);
    let vertices = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    for i in 0..1000 {
        // Weyl sequences spread the start points over the inside.
        let spread = |irrational: f64| (f64::from(i) * irrational).fract() * 0.4 - 0.2;
        let start = DVec3::new(spread(0.414), spread(0.732), spread(0.236));
        for a in vertices.map(DVec3::from) {
            for b in vertices.map(DVec3::from) {
                let dir = a.midpoint(b) - start;
                assert!(reference.closest_hit(start.to_array(), dir.to_array(), 0.0).is_some(), "{start} {dir}");
            }
        }
    }
}

#[test]
fn mesh_knows_its_inside() {
    let reference = shape(json!([{ "mesh": tetrahedron() }]));
    let inside = |x: f64| {
        let ray = Ray { origin: DVec3::splat(x), dir: DVec3::X };
        reference.world.containers(&ray).len() == 1
    };
    assert!(inside(0.0) && inside(0.99) && inside(-0.33));
    assert!(!inside(1.01) && !inside(-0.34));
}

#[test]
fn shading_normals_light_but_do_not_bend_the_surface() {
    // Flat, but its normals lean over to +x: along (1, 0, 1) it is lit as if it faced there.
    let leaning = json!({ "vertices": [[-9, -9, 0], [9, -9, 0], [0, 9, 0]], "faces": [[0, 1, 2]],
                          "normals": [[1, 0, 1], [1, 0, 1], [1, 0, 1]], "material": "matt" });
    let more = json!({
        "ambient": 0,
        "materials": { "matt": { "diffuse": 1 } },
        "lights": [{ "directional": { "direction": [-1, 0, -1] } }]
    });
    let reference = scene(json!([{ "mesh": leaning }]), more);
    assert_close(radiance(&reference, [0.0, 0.0, 5.0], [0.0, 0.0, -1.0]), [1.0; 3]);
    assert_hit(&reference, [0.0, 0.0, 5.0], [0.0, 0.0, -1.0], 5.0, [0.0, 0.0, 1.0]);
}

#[test]
fn instances_keep_t_and_turn_normals_by_the_inverse_transpose() {
    let more = json!({ "definitions": { "ball": [{ "sphere": { "center": [0, 0, 0], "radius": 1 } }] } });
    // (x/2)^2 + y^2 = 1 at x = 1.2: y = 0.8, gradient (x/2, 2y) = (0.6, 1.6).
    for scale in [2.0, -2.0] {
        let objects = json!([{ "sphere": { "center": [99, 0, 0], "radius": 1 } },
            { "instance": { "of": "ball", "transform": { "scale": [scale, 1, 1], "translate": [0, 7, 0] } } }]);
        let reference = scene(objects, more.clone());
        assert_hit(&reference, [1.2, 10.0, 0.0], [0.0, -2.0, 0.0], 1.1, [0.6, 1.6, 0.0]);
        let hit = reference.closest_hit([1.2, 10.0, 0.0], [0.0, -2.0, 0.0], 0.0).unwrap();
        assert_eq!(hit.object, "/objects/1");
    }
    let mirrored = shape(json!([{ "group": { "transform": { "scale": [-1, 1, 1] },
        "objects": [{ "triangle": { "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]] } }] } }]));
    assert_hit(&mirrored, [-0.2, 0.2, 1.0], [0.0, 0.0, -1.0], 1.0, [0.0, 0.0, 1.0]);
}

#[test]
fn nested_definitions_stay_cheap() {
    // Nine levels of nine children around the ball: 4e8 balls.
    let mut definitions = json!({ "level0": [{ "sphere": { "center": [0, 0, 0], "radius": 1 } }] });
    for level in 1..=9 {
        let children = (0..9).map(|i| {
            let place = json!({ "scale": 1.0 / 3.0, "translate": [4.0 / 3.0, 0, 0] });
            let child = json!({ "instance": { "of": format!("level{}", level - 1), "transform": place } });
            let turn = json!({ "rotate_deg": { "axis": [i % 3, 1, 0], "angle": 40 * i } });
            json!({ "group": { "objects": [child], "transform": turn } })
        });
        let ball = json!({ "sphere": { "center": [0, 0, 0], "radius": 1 } });
        definitions[format!("level{level}")] = std::iter::once(ball).chain(children).collect();
    }
    let flake = scene(json!([{ "instance": { "of": "level9" } }]), json!({ "definitions": definitions }));
    for i in 0..1000 {
        let x = f64::from(i) / 250.0 - 2.0;
        flake.closest_hit([x, 0.3, 9.0], [0.0, 0.0, -1.0], 0.0);
    }
    // The chain of first children ends in x = 1 + 2 (1/3 + ... + 1/3^9).
    let tip = 2.0 - 3f64.powi(-9);
    assert_hit(&flake, [9.0, 0.0, 0.0], [-1.0, 0.0, 0.0], 9.0 - tip, [1.0, 0.0, 0.0]);
}

#[test]
fn checker_lives_in_object_space() {
    let more = json!({ "materials": { "tiles": { "diffuse": { "checker": { "a": 1, "b": 0 } } } } });
    let floor = json!([{ "group": { "transform": { "translate": [0.5, 0, 0] }, "objects": [
        { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "tiles" } }] } }]);
    let reference = scene(floor, more);
    let below = |x: f64| radiance(&reference, [x, 1.0, 0.5], [0.0, -1.0, 0.0])[0];
    assert_eq!((below(0.6), below(1.4), below(1.6), below(0.4)), (1.0, 1.0, 0.0, 0.0));
}

#[test]
fn shadows() {
    let objects = json!([
        { "plane": { "point": [0, 0, 0], "normal": [0, 0, 1], "material": "matt" } },
        { "sphere": { "center": [0, 0, 3], "radius": 1, "material": "tinted" } },
        { "sphere": { "center": [0, 0, 9], "radius": 1, "material": "tinted" } }
    ]);
    let lit = |shadows: &str| {
        let more = json!({
            "ambient": 0,
            "materials": { "matt": { "diffuse": 1 }, "tinted": { "transmission": [1, 0.5, 0] } },
            "lights": [{ "point": { "position": [0, 0, 6] } }],
            "render": { "shadows": shadows }
        });
        radiance(&scene(objects.clone(), more), [5.0, 0.0, 5.0], [-1.0, 0.0, -1.0])
    };
    assert_close(lit("none"), [1.0; 3]);
    assert_close(lit("opaque"), [0.0; 3]);
    // Two surfaces of the first ball; the second lies behind the light.
    assert_close(lit("transmissive"), [1.0, 0.25, 0.0]);
}

#[test]
fn recursion_ends_at_depth_and_weight() {
    // Two mirrors face to face; each adds the ambient 0.25 and halves what comes after.
    let mirrors = json!([
        { "plane": { "point": [0, 0, -1], "normal": [0, 0, 1], "material": "m" } },
        { "plane": { "point": [0, 0, 1], "normal": [0, 0, -1], "material": "m" } }
    ]);
    let seen = |render: Value| {
        let materials = json!({ "m": { "ambient": 0.25, "diffuse": 0, "reflection": 0.5 } });
        let reference = scene(mirrors.clone(), json!({ "materials": materials, "render": render }));
        radiance(&reference, [0.0, 0.0, 0.0], [0.0, 0.0, 1.0])[0]
    };
    assert_eq!(seen(json!({ "max_depth": 1 })), 0.25);
    assert_eq!(seen(json!({ "max_depth": 3, "min_weight": 0 })), 0.25 * 1.75);
    // 1/4 is still followed, 1/8 is not.
    assert_eq!(seen(json!({ "max_depth": 99, "min_weight": 0.25 })), 0.25 * 1.75);
}

/// A red target that a ray meets only if it arrives within 1e-9 of `at`.
fn target(at: [f64; 3], normal: [f64; 3]) -> Value {
    json!({ "disc": { "center": at, "normal": normal, "radius": 1e-9, "material": "red" } })
}

const RED: [f64; 3] = [1.0, 0.0, 0.0];

#[test]
fn a_box_of_glass_shifts_the_ray() {
    // In at 45 degrees, sin = sqrt(1/2)/1.5, so tan = 1/sqrt(3.5); the slab is 2 thick.
    let aside = 1.0 + 2.0 / 3.5f64.sqrt() + 1.0;
    let slab = json!({ "box": { "min": [-9, -1, -9], "max": [9, 1, 9], "material": "glass" } });
    let reference = shape(json!([slab, target([aside, -2.0, 0.0], [0.0, 1.0, 0.0])]));
    assert_close(radiance(&reference, [0.0, 2.0, 0.0], [1.0, -1.0, 0.0]), RED);
}

#[test]
fn the_eye_may_stand_in_glass_or_water() {
    // From within the half-space: sin(out) = 1.5 sin(in), with sin(in) = 0.6 that is 0.9.
    let block = json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "glass" } });
    let aside = 0.75 + 0.9 / (1.0f64 - 0.81).sqrt();
    let reference = shape(json!([block, target([aside, 1.0, 0.0], [0.0, 1.0, 0.0])]));
    assert_close(radiance(&reference, [0.0, -1.0, 0.0], [0.6, 0.8, 0.0]), RED);
    // An eye in a dense ball in the glass: 3 sin = 1.5 sin' bends at the ball's surface too, except along its radius.
    let ball = json!({ "sphere": { "center": [0, -1, 0], "radius": 0.5, "material": "dense" } });
    let reference = shape(json!([ball, block, target([aside, 1.0, 0.0], [0.0, 1.0, 0.0])]));
    assert_close(radiance(&reference, [0.0, -1.0, 0.0], [0.6, 0.8, 0.0]), RED);
}

#[test]
fn total_reflection_takes_over_the_transmission() {
    // In the block at sin = 0.8 > 1/1.5: all goes back down, at reflection + transmission = 0.5 + 1.
    let more = json!({ "materials": {
        "red": { "ambient": [1, 0, 0], "diffuse": 0 },
        "glass": { "diffuse": 0, "transmission": 1, "reflection": 0.5, "ior": 1.5 }
    } });
    let block = json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "glass" } });
    let reference = scene(json!([block, target([8.0, -3.0, 0.0], [0.0, 1.0, 0.0])]), more);
    assert_close(radiance(&reference, [0.0, -3.0, 0.0], [0.8, 0.6, 0.0]), [1.5, 0.0, 0.0]);
}

#[test]
fn a_thin_hollow_sphere_hardly_bends() {
    let hollow = |inner: f64| {
        shape(json!([
            { "sphere": { "center": [0, 0, 0], "radius": 1, "material": "glass" } },
            { "sphere": { "center": [0, 0, 0], "radius": inner, "material": "glass", "hollow": true } },
            { "disc": { "center": [0.5, 0, -2], "normal": [0, 0, 1], "radius": 1e-3, "material": "red" } }
        ]))
    };
    assert_close(radiance(&hollow(0.9999), [0.5, 0.0, 3.0], [0.0, 0.0, -1.0]), RED);
    // The solid ball focuses: the ray crosses the axis.
    let blue = [0.0, 0.0, 1.0];
    assert_close(radiance(&hollow(1e-3), [0.5, 0.0, 3.0], [0.0, 0.0, -1.0]), blue);
    // The normal points out of the glass: into the cavity.
    assert_hit(&hollow(0.5), [0.0, 0.0, 0.6], [0.0, 0.0, -1.0], 0.1, [0.0, 0.0, -1.0]);
}

#[test]
fn equal_media_do_not_bend() {
    // Overlapping balls of the same glass as the block around them, the eye in two of them.
    let ball = |x: f64| json!({ "sphere": { "center": [x, 0, 0], "radius": 1, "material": "glass" } });
    let block = json!({ "box": { "min": [-9, -9, -9], "max": [9, 9, 9], "material": "glass" } });
    let reference = shape(json!([ball(0.0), ball(0.7), ball(1.4), block, target([8.0, 4.0, 0.0], [1.0, 0.0, 0.0])]));
    assert_close(radiance(&reference, [0.2, 0.1, 0.0], [7.8, 3.9, 0.0]), RED);
}

#[test]
fn thin_surfaces_pass_light_straight() {
    let reference = shape(json!([
        { "quad": { "vertices": [[-9, 0, -9], [-9, 0, 9], [9, 0, 9], [9, 0, -9]], "material": "glass" } },
        { "cylinder": { "base": [-9, -1, 0], "top": [9, -1, 0], "radius": 0.5, "capped": false, "material": "glass" } },
        { "box": { "min": [-9, -2, -9], "max": [9, -2, 9], "material": "glass" } },
        target([4.0, -3.0, 0.0], [0.0, 1.0, 0.0])
    ]));
    assert_close(radiance(&reference, [0.0, 1.0, 0.0], [1.0, -1.0, 0.0]), RED);
}

#[test]
fn one_sided_surfaces_are_not_there_from_behind() {
    let square = json!([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]);
    let reference = shape(json!([{ "quad": { "vertices": square, "material": "front" } }]));
    assert_hit(&reference, [0.5, 0.5, 1.0], [0.0, 0.0, -1.0], 1.0, [0.0, 0.0, 1.0]);
    assert_miss(&reference, [0.5, 0.5, -1.0], [0.0, 0.0, 1.0]);
    let room = shape(json!([{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "front", "hollow": true } }]));
    assert_hit(&room, [0.0, 0.0, 3.0], [0.0, 0.0, -1.0], 4.0, [0.0, 0.0, 1.0]);
}

#[test]
fn a_picture_has_a_radiance_for_each_pixel() {
    let reference = scene(
        json!([{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "red" } }]),
        json!({ "image": { "width": 3, "height": 1 },
                "camera": { "orthographic": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "height": 2 } } }),
    );
    assert_eq!(reference.render(), [[0.0, 0.0, 1.0], RED, [0.0, 0.0, 1.0]]);
}
