//! Scenes small enough for paper: what rays hit and where, what surfaces and lights do with them, where cameras look.
//! Everything is asked in both precisions.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![allow(clippy::disallowed_methods, reason = "expected values come from another library than strahl's")]

use glam::DVec3;
use serde_json::{Value, json};
use strahl::film::Region;
use strahl::render::{Control, render};
use strahl::scene::description::Precision;
use strahl::scene::{Format, Overrides, Scene, load};
use strahl::trace::query::{RayHit, RayQuery, answer};
use strahl::trace::tree::{Node, NodeKind, Tree, trace_pixel};

/// A scene in one precision.
struct World {
    scene: Scene,
    /// What a handful of roundings of numbers around 1 may amount to.
    small: f64,
}

/// A scene without light under a grey sky, `more` replacing keys, in both precisions.
fn worlds(objects: Value, more: Value) -> [World; 2] {
    let mut description = json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "orthographic": { "eye": [0, 5, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "height": 1 } },
        "lights": [],
        "ambient": 0,
        "materials": {
            "glass": { "diffuse": 0, "transmission": 1, "ior": 1.5 },
            "water": { "diffuse": 0, "transmission": 1, "ior": 1.33 },
            "nothing": { "diffuse": 0, "transmission": 1, "ior": 1 },
            "front": { "one_sided": true },
            "mirror": { "diffuse": 0, "reflection": 0.5 }
        },
        "objects": objects
    });
    for (key, value) in more.as_object().unwrap() {
        match (&mut description[key], value) {
            (Value::Object(old), Value::Object(new)) if key == "materials" => old.extend(new.clone()),
            (old, new) => *old = new.clone(),
        }
    }
    [(Precision::Single, f32::EPSILON.into()), (Precision::Double, f64::EPSILON)].map(|(precision, epsilon)| {
        let overrides = Overrides { precision: Some(precision), ..Overrides::default() };
        let scene =
            load(description.to_string().as_bytes(), Format::Json, &overrides).unwrap_or_else(|p| panic!("{p}")).scene;
        World { scene, small: 16.0 * epsilon }
    })
}

fn bodies(objects: Value) -> [World; 2] {
    worlds(objects, json!({}))
}

fn one(object: Value) -> [World; 2] {
    bodies(json!([object]))
}

fn ray(origin: [f64; 3], direction: [f64; 3]) -> RayQuery {
    RayQuery { origin, direction, t_min: 0.0, t_max: None }
}

fn query(world: &World, origin: [f64; 3], direction: [f64; 3]) -> Option<RayHit> {
    answer(&world.scene, &ray(origin, direction)).at
}

#[track_caller]
fn assert_near(actual: f64, expected: f64, tolerance: f64) {
    assert!((actual - expected).abs() <= tolerance, "{actual} instead of {expected} (tolerance {tolerance:e})");
}

#[track_caller]
fn assert_vector(actual: [f64; 3], expected: [f64; 3], tolerance: f64) {
    for i in 0..3 {
        assert!((actual[i] - expected[i]).abs() <= tolerance, "{actual:?} instead of {expected:?} ({tolerance:e})");
    }
}

/// A ray hits at `t`, on a surface with this outward normal (of any length), which it goes into or comes out of.
#[track_caller]
fn hits(worlds: &[World; 2], origin: [f64; 3], direction: [f64; 3], t: f64, normal: [f64; 3], entering: bool) {
    for world in worlds {
        let hit = query(world, origin, direction).unwrap_or_else(|| panic!("{origin:?} along {direction:?} misses"));
        let (o, d) = (DVec3::from(origin), DVec3::from(direction));
        let size = world.small * (1.0 + o.abs().max_element() + (d * t).abs().max_element());
        assert_near(hit.t * d.length(), t * d.length(), size);
        assert_vector(hit.point, (o + d * t).into(), size);
        assert_vector(hit.normal, DVec3::from(normal).normalize().into(), size);
        assert_near(DVec3::from(hit.normal).length(), 1.0, world.small);
        assert_eq!(hit.entering, entering, "{origin:?} along {direction:?}");
    }
}

#[track_caller]
fn misses(worlds: &[World; 2], origin: [f64; 3], direction: [f64; 3]) {
    for world in worlds {
        assert_eq!(query(world, origin, direction), None, "{origin:?} along {direction:?}");
    }
}

/// Numbers in [0, 1), the same ones in every run (Knuth's linear congruential generator).
fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

fn minus(v: [f64; 3]) -> [f64; 3] {
    v.map(|x| 0.0 - x)
}

mod shapes {
    use super::*;

    #[test]
    fn a_sphere_is_hit_from_outside_from_inside_and_from_its_surface() {
        let ball = one(json!({ "sphere": { "center": [1, 0, 0], "radius": 2 } }));
        hits(&ball, [1.0, 0.0, 7.0], minus(Z), 5.0, Z, true);
        hits(&ball, [2.2, 0.0, 7.0], [0.0, 0.0, -2.0], 2.7, [1.2, 0.0, 1.6], true);
        hits(&ball, [1.0, 0.0, 0.0], [0.0, 4.0, 0.0], 0.5, Y, false);
        hits(&ball, [1.0, 0.0, 2.0], minus(Z), 4.0, minus(Z), false);
        hits(&ball, [1.0, 0.0, 2.0], [0.6, 0.0, -0.8], 3.2, [1.92, 0.0, -0.56], false);
        misses(&ball, [1.0, 0.0, 2.0], Z);
        misses(&ball, [1.0, 0.0, 2.0], X);
        misses(&ball, [1.0, 0.0, 7.0], Z);
        misses(&ball, [3.01, 0.0, 7.0], minus(Z));
    }

    #[test]
    fn a_plane_is_hit_from_both_sides_and_never_along_it() {
        let plane = one(json!({ "plane": { "point": [0, 1, 0], "normal": [0, 5, 0] } }));
        hits(&plane, [0.0, 3.0, 0.0], [1.0, -1.0, 0.0], 2.0, Y, true);
        hits(&plane, [0.0, 0.0, 0.0], [0.0, 0.5, 0.0], 2.0, Y, false);
        misses(&plane, [0.0, 3.0, 0.0], X);
        misses(&plane, [0.0, 1.0, 0.0], X);
        misses(&plane, [0.0, 1.0, 0.0], Y);
        misses(&plane, [0.0, 1.0, 0.0], minus(Y));
        let tilted = one(json!({ "plane": { "point": [2, 0, 0], "normal": [3, 4, 0] } }));
        hits(&tilted, [2.0, 5.0, 9.0], minus(Y), 5.0, [0.6, 0.8, 0.0], true);
    }

    #[test]
    fn a_disc_ends_at_its_rim() {
        let disc = one(json!({ "disc": { "center": [0, 0, 1], "normal": [0, 0, 2], "radius": 2 } }));
        hits(&disc, [1.2, 1.2, 5.0], minus(Z), 4.0, Z, true);
        hits(&disc, [0.0, 1.9, 0.0], Z, 1.0, Z, false);
        misses(&disc, [1.5, 1.5, 5.0], minus(Z));
        misses(&disc, [0.0, 0.0, 1.0], minus(Z));
    }

    #[test]
    fn the_front_of_a_triangle_sees_its_corners_counter_clockwise() {
        let triangle = one(json!({ "triangle": { "vertices": [[0, 0, 0], [4, 0, 0], [0, 4, 0]] } }));
        hits(&triangle, [1.0, 1.0, 3.0], minus(Z), 3.0, Z, true);
        hits(&triangle, [1.0, 1.0, -3.0], [0.0, 0.0, 2.0], 1.5, Z, false);
        hits(&triangle, [3.0, 3.0, 2.0], [-1.0, -1.0, -1.0], 2.0, Z, true);
        misses(&triangle, [2.1, 2.1, 3.0], minus(Z));
        misses(&triangle, [1.0, 1.0, 0.0], Z);
        misses(&triangle, [-1.0, 1.0, 0.0], X);
    }

    #[test]
    fn the_border_belongs_to_a_triangle() {
        // Sides at coordinate 0, along which a ray runs parallel to the sides of the bounding box.
        for corners in [
            json!([[-1, -1, 0], [0, -1, 0], [0, 1, 0]]),
            json!([[1, -1, 0], [0, 1, 0], [0, -1, 0]]),
            json!([[-1, 0, 0], [1, 0, 0], [0, 1, 0]]),
            json!([[-1, 0, 0], [0, -1, 0], [1, 0, 0]]),
        ] {
            let triangle = one(json!({ "triangle": { "vertices": corners } }));
            for z in [5.0, -5.0] {
                hits(&triangle, [0.0, 0.0, z], [0.0, 0.0, -z], 1.0, Z, z > 0.0);
                hits(&triangle, [-0.0, -0.0, z], [-0.0, -0.0, -z], 1.0, Z, z > 0.0);
            }
        }
    }

    #[test]
    fn a_triangle_is_hit_however_small_it_is_beside_its_distance() {
        for size in [1e-3, 1e-9, 1e-15, 1e-20, 1e-27] {
            let triangle = one(json!({ "triangle": { "vertices": [[0, 0, 0], [size, 0, 0], [0, size, 0]] } }));
            hits(&triangle, [0.25 * size, 0.25 * size, 1.0], minus(Z), 1.0, Z, true);
            misses(&triangle, [2.0 * size, 0.25 * size, 1.0], minus(Z));
        }
    }

    #[test]
    fn a_quad_is_two_triangles() {
        let quad = one(json!({ "quad": { "vertices": [[0, 0, 0], [2, 0, 0], [2, 0, -3], [0, 0, -3]] } }));
        hits(&quad, [1.9, 2.0, -0.1], minus(Y), 2.0, Y, true);
        hits(&quad, [0.1, -2.0, -2.9], Y, 2.0, Y, false);
        hits(&quad, [1.0, 2.0, -1.5], minus(Y), 2.0, Y, true);
        misses(&quad, [2.1, 2.0, -1.0], minus(Y));
    }

    #[test]
    fn a_box_is_hit_on_all_six_sides() {
        let cube = one(json!({ "box": { "min": [0, 0, 0], "max": [1, 2, 3] } }));
        let middle = DVec3::new(0.5, 1.0, 1.5);
        for (axis, half) in [(X, 0.5), (Y, 1.0), (Z, 1.5)] {
            for normal in [axis, minus(axis)] {
                let far = (middle + 10.0 * DVec3::from(normal)).into();
                hits(&cube, far, minus(normal), 10.0 - half, normal, true);
                hits(&cube, middle.into(), normal, half, normal, false);
                let on = (middle + half * DVec3::from(normal)).into();
                hits(&cube, on, minus(normal), 2.0 * half, minus(normal), false);
                misses(&cube, on, normal);
            }
        }
        hits(&cube, [2.0, 3.0, 1.5], [-1.0, -1.5, 0.0], 1.0, X, true);
        misses(&cube, [-1.0, 2.5, 1.0], X);
    }

    #[test]
    fn a_box_may_be_flat() {
        let flat = one(json!({ "box": { "min": [0, 1, 0], "max": [1, 1, 1] } }));
        hits(&flat, [0.5, 3.0, 0.5], minus(Y), 2.0, Y, true);
        misses(&flat, [1.5, 3.0, 0.5], minus(Y));
    }

    #[test]
    fn a_cylinder_has_a_side_and_two_caps() {
        let tube = one(json!({ "cylinder": { "base": [0, 0, 0], "top": [0, 2, 0], "radius": 1 } }));
        hits(&tube, [0.6, 1.0, 5.0], minus(Z), 4.2, [0.6, 0.0, 0.8], true);
        hits(&tube, [0.5, 5.0, 0.0], minus(Y), 3.0, Y, true);
        hits(&tube, [0.5, 1.0, 0.0], minus(Y), 1.0, minus(Y), false);
        hits(&tube, [0.0, -4.0, 0.0], [0.0, 8.0, 0.0], 0.5, minus(Y), true);
        hits(&tube, [0.0, 1.0, 0.0], X, 1.0, X, false);
        hits(&tube, [1.0, 1.0, 0.0], minus(X), 2.0, minus(X), false);
        misses(&tube, [1.0, 1.0, 0.0], X);
        misses(&tube, [0.5, 2.0, 0.0], Y);
        misses(&tube, [5.0, 2.1, 0.0], minus(X));
        misses(&tube, [1.1, 5.0, 0.0], minus(Y));
    }

    #[test]
    fn an_open_cylinder_lets_rays_in_at_its_ends() {
        let tube = one(json!({ "cylinder": { "base": [0, 0, 0], "top": [0, 2, 0], "radius": 1, "capped": false } }));
        misses(&tube, [0.5, 5.0, 0.0], minus(Y));
        hits(&tube, [0.0, 2.5, 0.0], [1.0, -1.0, 0.0], 1.0, X, false);
        hits(&tube, [2.0, 1.0, 0.0], minus(X), 1.0, X, true);
        misses(&tube, [-0.5, 3.0, 0.0], [0.3, -1.0, 0.0]);
    }

    #[test]
    fn a_long_thin_cylinder_is_as_sharp_as_a_short_one() {
        let tube = one(json!({ "cylinder": { "base": [0, 0, 0], "top": [0, 0, 1e6], "radius": 1, "capped": false } }));
        hits(&tube, [3.1, 0.6, 0.3], [-0.7, 0.0, 0.1], 2.3 / 0.7, [0.8, 0.6, 0.0], true);
        hits(&tube, [0.1, 0.6, 0.3], [0.7, 0.0, 0.1], 1.0, [0.8, 0.6, 0.0], false);
        misses(&tube, [3.0, 0.0, -0.01], minus(X));
        misses(&tube, [3.0, 0.0, -5.0], minus(X));
    }

    #[test]
    fn a_cone_comes_to_a_point_and_has_no_second_nappe() {
        let cone = one(json!({ "cone": { "base": [0, 0, 0], "base_radius": 1, "top": [0, 2, 0] } }));
        hits(&cone, [5.0, 1.0, 0.0], minus(X), 4.5, [2.0, 1.0, 0.0], true);
        hits(&cone, [0.5, 5.0, 0.0], minus(Y), 4.0, [2.0, 1.0, 0.0], true);
        hits(&cone, [0.5, -1.0, 0.0], Y, 1.0, minus(Y), true);
        hits(&cone, [0.0, 1.0, 0.0], X, 0.5, [2.0, 1.0, 0.0], false);
        // Parallel to the side.
        hits(&cone, [0.5, 2.0, 0.0], [-1.0, -2.0, 0.0], 0.25, [2.0, 1.0, 0.0], true);
        misses(&cone, [5.0, 3.0, 0.0], minus(X));
        misses(&cone, [0.25, 3.0, 0.0], [1.0, -2.0, 0.0]);
    }

    #[test]
    fn a_ray_onto_the_tip_of_a_cone_does_not_get_inside() {
        for (base, top) in [((0.0, 1.0), (2.0, 0.0)), ((2.0, 0.0), (0.0, 1.0))] {
            let cone =
                json!({ "base": [0, base.0, 0], "base_radius": base.1, "top": [0, top.0, 0], "top_radius": top.1 });
            let mut open = cone.clone();
            open["capped"] = false.into();
            let cone = one(json!({ "cone": cone }));
            hits(&cone, [0.0, 5.0, 0.0], minus(Y), 3.0, Y, true);
            hits(&cone, [0.0, 1.0, 0.0], Y, 1.0, Y, false);
            hits(&cone, [0.0, -1.0, 0.0], Y, 1.0, minus(Y), true);
            let open = one(json!({ "cone": open }));
            hits(&open, [0.0, 5.0, 0.0], minus(Y), 3.0, Y, true);
            hits(&open, [0.0, -1.0, 0.0], Y, 3.0, Y, false);
        }
    }

    #[test]
    fn a_frustum_may_widen_upwards_and_may_be_open() {
        let solid = json!({ "base": [0, 0, 0], "base_radius": 1, "top": [0, 2, 0], "top_radius": 2 });
        let mut hose = solid.clone();
        hose["capped"] = false.into();
        let solid = one(json!({ "cone": solid }));
        hits(&solid, [5.0, 1.0, 0.0], minus(X), 3.5, [2.0, -1.0, 0.0], true);
        hits(&solid, [1.9, 3.0, 0.0], minus(Y), 1.0, Y, true);
        hits(&solid, [0.9, -3.0, 0.0], Y, 3.0, minus(Y), true);
        hits(&solid, [1.5, -3.0, 0.0], Y, 4.0, [2.0, -1.0, 0.0], true);
        let hose = one(json!({ "cone": hose }));
        misses(&hose, [0.5, 3.0, 0.0], minus(Y));
        hits(&hose, [1.5, 3.0, 0.0], minus(Y), 2.0, [2.0, -1.0, 0.0], false);
    }

    #[test]
    fn a_torus_has_a_hole_and_up_to_four_crossings() {
        let ring =
            one(json!({ "torus": { "center": [0, 1, 0], "axis": [0, 3, 0], "major_radius": 2, "minor_radius": 0.5 } }));
        hits(&ring, [5.0, 1.0, 0.0], minus(X), 2.5, X, true);
        hits(&ring, [2.0, 1.0, 0.0], minus(X), 0.5, minus(X), false);
        hits(&ring, [0.0, 1.0, 0.0], [-2.0, 0.0, 0.0], 0.75, X, true);
        hits(&ring, [-2.0, 1.0, 0.0], minus(X), 0.5, minus(X), false);
        hits(&ring, [2.0, 4.0, 0.0], minus(Y), 2.5, Y, true);
        hits(&ring, [0.0, 4.0, 2.3], minus(Y), 2.6, [0.0, 0.4, 0.3], true);
        misses(&ring, [0.0, 4.0, 0.0], minus(Y));
        misses(&ring, [5.0, 1.6, 0.0], minus(X));
        misses(&ring, [2.5, 1.0, 0.0], X);
        hits(&ring, [2.5, 1.0, 0.0], minus(X), 1.0, minus(X), false);
    }

    /// A tetrahedron whose faces look outwards.
    fn tetrahedron() -> Value {
        json!({ "vertices": [[0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 3]],
                "faces": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] })
    }

    #[test]
    fn a_mesh_is_one_body() {
        let mesh = one(json!({ "mesh": tetrahedron() }));
        hits(&mesh, [2.0, 2.0, 2.0], [-1.0, -1.0, -1.0], 1.0, [1.0, 1.0, 1.0], true);
        hits(&mesh, [0.5, 0.5, 0.5], [1.0, 1.0, 1.0], 0.5, [1.0, 1.0, 1.0], false);
        hits(&mesh, [0.5, 0.5, -1.0], Z, 1.0, minus(Z), true);
        hits(&mesh, [0.5, 0.5, 0.5], minus(X), 0.5, minus(X), false);
        misses(&mesh, [2.0, 2.0, -1.0], Z);
    }

    #[test]
    fn interpolated_normals_do_not_change_the_geometric_one() {
        let mut mesh = tetrahedron();
        mesh["normals"] = json!([[-1, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]]);
        let mesh = one(json!({ "mesh": mesh }));
        hits(&mesh, [0.5, 0.5, -1.0], Z, 1.0, minus(Z), true);
    }

    #[test]
    fn a_polygon_may_be_concave() {
        // An L.
        let corners = json!([[0, 0, 0], [3, 0, 0], [3, 1, 0], [1, 1, 0], [1, 3, 0], [0, 3, 0]]);
        let polygon = one(json!({ "polygon": { "vertices": corners } }));
        for [x, y] in [[0.5, 0.5], [2.5, 0.5], [0.5, 2.5], [1.0, 0.5]] {
            hits(&polygon, [x, y, 2.0], minus(Z), 2.0, Z, true);
            hits(&polygon, [x, y, -2.0], Z, 2.0, Z, false);
        }
        for [x, y] in [[1.5, 1.5], [2.5, 2.5], [1.1, 1.1], [-0.1, 1.0]] {
            misses(&polygon, [x, y, 2.0], minus(Z));
        }
    }

    #[test]
    fn hollow_bodies_have_their_material_outside() {
        for (body, half) in [
            (json!({ "sphere": { "center": [0, 0, 0], "radius": 1, "hollow": true } }), 1.0),
            (json!({ "box": { "min": [-1, -1, -1], "max": [1, 1, 1], "hollow": true } }), 1.0),
            (json!({ "cylinder": { "base": [0, -1, 0], "top": [0, 1, 0], "radius": 1, "hollow": true } }), 1.0),
            (json!({ "cone": { "base": [0, 0, -1], "base_radius": 2, "top": [0, 0, 1], "hollow": true } }), 0.0),
            (json!({ "plane": { "point": [0, 0, 1], "normal": [0, 0, 1], "hollow": true } }), 1.0),
        ] {
            let hole = one(body);
            if half > 0.0 {
                hits(&hole, [0.0, 0.0, 5.0], minus(Z), 4.0, minus(Z), false);
                hits(&hole, [0.0, 0.0, 0.0], Z, 1.0, minus(Z), true);
            } else {
                hits(&hole, [0.0, 0.0, -5.0], Z, 4.0, Z, false);
            }
        }
        let mut mesh = tetrahedron();
        mesh["hollow"] = true.into();
        hits(&one(json!({ "mesh": mesh })), [2.0, 2.0, 2.0], [-1.0, -1.0, -1.0], 1.0, [-1.0, -1.0, -1.0], false);
        let torus = json!({ "center": [0, 0, 0], "major_radius": 2, "minor_radius": 0.5, "hollow": true });
        hits(&one(json!({ "torus": torus })), [2.0, 0.0, 0.0], X, 0.5, minus(X), true);
    }

    #[test]
    fn one_sided_surfaces_exist_only_for_rays_from_the_front() {
        let ball = one(json!({ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "front" } }));
        hits(&ball, [0.0, 0.0, 5.0], minus(Z), 4.0, Z, true);
        misses(&ball, [0.0, 0.0, 0.0], Z);
        let room = one(json!({ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "front", "hollow": true } }));
        hits(&room, [0.0, 0.0, 5.0], minus(Z), 6.0, Z, true);
        hits(&room, [0.0, 0.0, 0.0], Z, 1.0, minus(Z), true);
        for surface in [
            json!({ "triangle": { "vertices": [[-1, -1, 0], [1, -1, 0], [0, 1, 0]], "material": "front" } }),
            json!({ "disc": { "center": [0, 0, 0], "normal": [0, 0, 1], "radius": 1, "material": "front" } }),
            json!({ "plane": { "point": [0, 0, 0], "normal": [0, 0, 1], "material": "front" } }),
            json!({ "polygon": { "vertices": [[-1, -1, 0], [1, -1, 0], [0, 1, 0]], "material": "front" } }),
        ] {
            let surface = one(surface);
            hits(&surface, [0.0, 0.0, 5.0], minus(Z), 5.0, Z, true);
            misses(&surface, [0.0, 0.0, -5.0], Z);
        }
        let cube = one(json!({ "box": { "min": [-1, -1, -1], "max": [1, 1, 1], "material": "front" } }));
        misses(&cube, [0.0, 0.0, 0.0], Z);
        let tube = json!({ "base": [0, 0, 0], "top": [0, 2, 0], "radius": 1, "capped": false, "material": "front" });
        misses(&one(json!({ "cylinder": tube })), [0.0, 1.0, 0.0], X);
        let torus = json!({ "center": [0, 0, 0], "major_radius": 2, "minor_radius": 0.5, "material": "front" });
        misses(&one(json!({ "torus": torus })), [2.0, 0.0, 0.0], X);
    }
}

mod placement {
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
        let disc =
            |name: &str| json!({ "disc": { "center": [0, 0, 0], "normal": [0, 0, 1], "radius": 1, "name": name } });
        for world in &bodies(json!([disc("a"), disc("b"), disc("c")])) {
            assert_eq!(query(world, [0.3, 0.2, 1.0], minus(Z)).unwrap().name.as_deref(), Some("a"));
        }
    }
}

mod ranges {
    use super::*;

    fn t(world: &World, t_min: f64, t_max: Option<f64>, scale: f64) -> Option<f64> {
        let direction = [0.0, 0.0, -scale];
        answer(&world.scene, &RayQuery { origin: [0.0, 0.0, 5.0], direction, t_min, t_max }).at.map(|hit| hit.t)
    }

    #[test]
    fn hits_lie_between_t_min_and_t_max() {
        for world in &one(json!({ "sphere": { "center": [0, 0, 0], "radius": 1 } })) {
            assert_eq!(t(world, 0.0, None, 1.0), Some(4.0));
            assert_eq!(t(world, 3.9, None, 1.0), Some(4.0));
            assert_eq!(t(world, 4.0, None, 1.0), Some(6.0));
            assert_eq!(t(world, 4.1, Some(5.9), 1.0), None);
            assert_eq!(t(world, 0.0, Some(3.9), 1.0), None);
            assert_eq!(t(world, 0.0, Some(4.1), 1.0), Some(4.0));
            assert_eq!(t(world, 6.0, None, 1.0), None);
        }
    }

    #[test]
    fn t_counts_in_lengths_of_the_direction() {
        for world in &one(json!({ "sphere": { "center": [0, 0, 0], "radius": 1 } })) {
            for scale in [0, -2, 3, 40, -40, 126, -126, 149, -149, 600, -600].map(|n| 2f64.powi(n)) {
                assert_eq!(t(world, 0.0, None, scale), Some(4.0 / scale));
                assert_eq!(t(world, 5.0 / scale, None, scale), Some(6.0 / scale));
                assert_eq!(t(world, 0.0, Some(3.0 / scale), scale), None);
            }
        }
    }
}

mod optics {
    use super::*;

    fn degrees(angle: f64) -> [f64; 3] {
        [angle.to_radians().sin(), -angle.to_radians().cos(), 0.0]
    }

    /// From one unit away onto the middle of a surface, `angle` degrees from its normal, which is y.
    #[track_caller]
    fn onto_floor(world: &World, angle: f64) -> RayHit {
        let d = degrees(angle);
        query(world, minus(d), d).unwrap()
    }

    fn floor(material: &str) -> [World; 2] {
        one(json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": material } }))
    }

    #[test]
    fn the_mirror_direction_has_the_same_angle_on_the_other_side() {
        for world in &floor("mirror") {
            let hit = query(world, [-3.0, 4.0, 0.0], [6.0, -8.0, 0.0]).unwrap();
            assert_vector(hit.reflected, [0.6, 0.8, 0.0], world.small);
            assert_eq!(hit.transmitted, None);
            assert!(!hit.tir);
            let below = query(world, [0.0, -2.0, 0.0], [1.0, 1.0, 0.0]).unwrap();
            assert_vector(below.reflected, [0.5f64.sqrt(), -0.5f64.sqrt(), 0.0], world.small);
        }
    }

    #[test]
    fn snells_law_holds_into_glass_and_out_of_it() {
        for world in &floor("glass") {
            for angle in [0.0, 1.0, 30.0, 60.0, 89.0] {
                let hit = onto_floor(world, angle);
                let sine = angle.to_radians().sin() / 1.5;
                let inside = hit.transmitted.unwrap();
                assert_vector(inside, [sine, -(1.0 - sine * sine).sqrt(), 0.0], world.small);
                let back = query(world, [inside[0] * 2.0, inside[1] * 2.0, 0.0], minus(inside)).unwrap();
                assert!(!back.entering);
                // Close to the critical angle a rounding of the sine counts more than once.
                let steep = 1.0 / angle.to_radians().cos();
                assert_vector(back.transmitted.unwrap(), minus(degrees(angle)), world.small * steep);
            }
        }
    }

    #[test]
    fn fresnels_reflectance_at_normal_incidence_at_brewsters_angle_and_at_grazing() {
        for world in &floor("glass") {
            assert_near(onto_floor(world, 0.0).reflectance, 0.04, world.small);
            let brewster = onto_floor(world, 1.5f64.atan().to_degrees());
            assert_near(brewster.reflectance, (1.25f64 / 3.25).powi(2) / 2.0, world.small);
            // There the two directions are perpendicular.
            let dot = DVec3::from(brewster.reflected).dot(brewster.transmitted.unwrap().into());
            assert_near(dot, 0.0, world.small);
            assert!(onto_floor(world, 89.999).reflectance > 0.99);
            let out = query(world, [0.0, -1.0, 0.0], Y).unwrap();
            assert_near(out.reflectance, 0.04, world.small);
        }
    }

    #[test]
    fn opaque_bodies_have_a_reflectance_but_transmit_nothing() {
        let pool = json!({ "materials": { "ink": { "ior": 3 } } });
        for world in &worlds(json!([{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "ink" } }]), pool) {
            let hit = query(world, [0.0, 4.0, 0.0], minus(Y)).unwrap();
            assert_near(hit.reflectance, 0.25, world.small);
            assert_eq!(hit.transmitted, None);
            assert!(!hit.tir);
        }
    }

    #[test]
    fn total_reflection_begins_at_the_critical_angle() {
        let critical = (1.0f64 / 1.5).asin().to_degrees();
        for world in &floor("glass") {
            for (angle, total) in
                [(0.0, false), (critical - 0.01, false), (critical + 0.01, true), (45.0, true), (89.0, true)]
            {
                let [x, y, _] = degrees(angle);
                let hit = query(world, [-x, y, 0.0], [x, -y, 0.0]).unwrap();
                assert_eq!(hit.tir, total, "{angle}");
                assert_eq!(hit.transmitted.is_none(), total);
                assert_eq!(hit.reflectance == 1.0, total);
                assert_vector(hit.reflected, [x, y, 0.0], world.small);
            }
            for angle in [80.0, 89.99] {
                assert!(!onto_floor(world, angle).tir, "never into the denser medium");
            }
        }
    }

    #[test]
    fn matched_indices_are_invisible() {
        for world in &floor("nothing") {
            for angle in [0.0, 45.0, 89.9] {
                let hit = onto_floor(world, angle);
                assert_eq!(hit.reflectance, 0.0);
                assert_vector(hit.transmitted.unwrap(), degrees(angle), 0.25 * world.small);
            }
        }
    }

    #[test]
    fn thin_surfaces_do_not_bend_light() {
        for surface in [
            json!({ "disc": { "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 1, "material": "glass" } }),
            json!({ "quad": { "vertices": [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], "material": "glass" } }),
            json!({ "polygon": { "vertices": [[-1, 0, 1], [1, 0, 1], [0, 0, -1]], "material": "glass" } }),
        ] {
            for world in &one(surface) {
                let hit = onto_floor(world, 50.0);
                assert_vector(hit.transmitted.unwrap(), degrees(50.0), world.small);
                assert_eq!(hit.reflectance, 0.0);
            }
        }
    }

    /// Sine of the angle behind an interface of a ray that comes `sine` in from a normal along z.
    fn sine_behind(world: &World, origin: [f64; 3], direction: [f64; 3]) -> Option<f64> {
        let hit = query(world, origin, direction).unwrap();
        let normal = DVec3::from(hit.normal);
        hit.transmitted.map(|d| DVec3::from(d).cross(normal).length())
    }

    #[test]
    fn rays_know_the_media_they_start_in() {
        // Glass in water, both around the origin; 0.6 off the axis the sine on the glass ball is 0.6.
        let glass_in_water = json!([
            { "sphere": { "center": [0, 0, 0], "radius": 1, "material": "glass" } },
            { "sphere": { "center": [0, 0, 0], "radius": 5, "material": "water" } }
        ]);
        for world in &bodies(glass_in_water) {
            let into_water = sine_behind(world, [3.0, 0.0, 9.0], minus(Z)).unwrap();
            assert_near(into_water, 0.6 / 1.33, world.small);
            let into_glass = sine_behind(world, [0.6, 0.0, 3.0], minus(Z)).unwrap();
            assert_near(into_glass, 0.6 * 1.33 / 1.5, world.small);
            let out_of_glass = sine_behind(world, [0.6, 0.0, 0.0], minus(Z)).unwrap();
            assert_near(out_of_glass, 0.6 * 1.5 / 1.33, world.small);
            let out_of_water = sine_behind(world, [3.0, 0.0, 2.0], Z).unwrap();
            assert_near(out_of_water, 0.6 * 1.33, world.small);
            assert!(sine_behind(world, [0.0, 4.0, 0.1], Z).is_none(), "0.8 * 1.33 > 1");
        }
    }

    #[test]
    fn an_air_bubble_in_glass_bends_away() {
        let bubble = json!([
            { "sphere": { "center": [0, 0, 0], "radius": 4, "material": "glass" } },
            { "sphere": { "center": [0, 0, 0], "radius": 1, "material": "glass", "hollow": true, "name": "bubble" } }
        ]);
        for world in &bodies(bubble) {
            let into_air = query(world, [0.6, 0.0, 3.0], minus(Z)).unwrap();
            assert_eq!((into_air.name.as_deref(), into_air.entering), (Some("bubble"), false));
            assert_near(sine_behind(world, [0.6, 0.0, 3.0], minus(Z)).unwrap(), 0.9, world.small);
            assert!(query(world, [0.7, 0.0, 3.0], minus(Z)).unwrap().tir, "0.7 * 1.5 > 1");
            let into_glass = query(world, [0.6, 0.0, 0.0], Z).unwrap();
            assert!(into_glass.entering);
            assert_near(sine_behind(world, [0.6, 0.0, 0.0], Z).unwrap(), 0.4, world.small);
            assert_near(query(world, [0.0, 0.0, 0.0], Z).unwrap().reflectance, 0.04, world.small);
        }
    }

    #[test]
    fn overlapping_bodies_are_left_in_any_order() {
        // Along z: glass from -2 to 1, water from -1 to 2. The one entered last decides.
        let overlap = json!([
            { "box": { "min": [-9, -9, -2], "max": [9, 9, 1], "material": "glass" } },
            { "box": { "min": [-9, -9, -1], "max": [9, 9, 2], "material": "water" } }
        ]);
        let camera = json!({ "orthographic": { "eye": [-2.4, 0, -5], "look_at": [-1.8, 0, -4.2], "height": 1 } });
        for world in &worlds(overlap, json!({ "camera": camera })) {
            let tree = trace_pixel(&world.scene, 0, 0);
            let steps: Vec<(f64, f64)> = tree.rays.iter().filter_map(|r| r.snell).map(|s| (s.n1, s.n2)).collect();
            let expected = [(1.0, 1.5), (1.5, 1.33), (1.33, 1.33), (1.33, 1.0)];
            assert_eq!(steps.len(), expected.len());
            for (step, expected) in steps.iter().zip(expected) {
                assert_near(step.0, expected.0, world.small);
                assert_near(step.1, expected.1, world.small);
            }
            let last = tree.rays.last().unwrap();
            assert_vector(last.direction, [0.6, 0.0, 0.8], world.small);
            assert!(last.media.is_empty() && last.hit.is_none());
        }
    }

    /// Fermat: light takes the way of least time. From A above the water the tracer finds the ray to B below it; the
    /// way over any other point of the surface is longer.
    #[test]
    fn refracted_light_takes_the_way_of_least_time() {
        let mut random = uniform(1);
        let [_, world] = floor("water");
        for _ in 0..200 {
            let a = DVec3::new(4.0 * random() - 2.0, 0.1 + 3.0 * random(), 4.0 * random() - 2.0);
            let b = DVec3::new(4.0 * random() - 2.0, -0.1 - 3.0 * random(), 4.0 * random() - 2.0);
            // Where the ray from a through x arrives at the depth of b, seen along the line from a to b.
            let along = DVec3::new(b.x - a.x, 0.0, b.z - a.z).normalize();
            let crossing = |s: f64| DVec3::new(a.x, 0.0, a.z) + along * s;
            let arrival = |s: f64| {
                let hit = query(&world, a.into(), (crossing(s) - a).into()).unwrap();
                let (p, d) = (DVec3::from(hit.point), DVec3::from(hit.transmitted.unwrap()));
                (p, p + d * ((b.y - p.y) / d.y))
            };
            let reach = (b - a).dot(along);
            let (mut low, mut high) = (0.0, reach);
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                if (arrival(middle).1 - a).dot(along) < reach { low = middle } else { high = middle }
            }
            let (p, end) = arrival(low);
            assert!(end.distance(b) < 1e-12, "the ray arrives at {end} instead of {b}");
            let time = |x: DVec3| a.distance(x) + 1.33 * x.distance(b);
            for h in [1e-1, 1e-3, 1e-5] {
                for step in [along, -along, along.cross(DVec3::Y), -along.cross(DVec3::Y)] {
                    assert!(time(p + step * h) > time(p) - 1e-15, "a step of {h} is shorter");
                }
            }
            // Stationary: the derivative is sin(theta1) - n sin(theta2).
            assert_near((time(p + along * 1e-6) - time(p - along * 1e-6)) / 2e-6, 0.0, 1e-8);
        }
    }
}

/// The pixel of a scene of one pixel, rendered; the ray tree must agree with it.
fn pixels(objects: Value, more: Value) -> Vec<([f64; 3], f64)> {
    worlds(objects, more)
        .iter()
        .map(|world| {
            let picture = render(&world.scene, Region::whole(1, 1), &Control::default()).unwrap();
            (picture.film.pixels[0].map(f64::from), f64::from(f32::EPSILON) * 4.0)
        })
        .collect()
}

#[track_caller]
fn shows(objects: Value, more: Value, expected: [f64; 3]) {
    for (pixel, small) in pixels(objects, more) {
        assert_vector(pixel, expected, small * (1.0 + expected.into_iter().fold(0.0, f64::max)));
    }
}

mod light {
    use super::*;

    /// A floor at the origin, seen from straight above.
    fn floor() -> Value {
        json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "m" } })
    }

    #[track_caller]
    fn floor_shows(material: Value, lights: Value, expected: [f64; 3]) {
        shows(json!([floor()]), json!({ "materials": { "m": material }, "lights": lights }), expected);
    }

    /// 3-4-5: five away, N.L = 0.8, R.V = 0.8.
    fn point(more: Value) -> Value {
        let mut light = json!({ "position": [3, 4, 0] });
        light.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        json!([{ "point": light }])
    }

    #[test]
    fn rays_that_hit_nothing_show_the_background() {
        let away = json!([{ "sphere": { "center": [0, 50, 0], "radius": 1 } }]);
        shows(away, json!({ "background": [0.25, 0.5, 2] }), [0.25, 0.5, 2.0]);
    }

    #[test]
    fn ambient_light_is_a_product_and_defaults_to_the_diffuse_colour() {
        let more = |material: Value| json!({ "ambient": [0.5, 1, 2], "materials": { "m": material } });
        shows(json!([floor()]), more(json!({ "diffuse": [0.1, 0.2, 0.3] })), [0.05, 0.2, 0.6]);
        shows(json!([floor()]), more(json!({ "diffuse": 0.1, "ambient": [1, 0, 0.25] })), [0.5, 0.0, 0.5]);
    }

    #[test]
    fn diffuse_light_falls_with_the_cosine() {
        floor_shows(json!({ "diffuse": [0.5, 0.25, 0] }), point(json!({})), [0.4, 0.2, 0.0]);
        floor_shows(json!({ "diffuse": 0.5 }), point(json!({ "color": [1, 0.5, 0], "intensity": 3 })), [1.2, 0.6, 0.0]);
        let directional = json!([{ "directional": { "direction": [6, -8, 0], "intensity": 2 } }]);
        floor_shows(json!({ "diffuse": 0.5 }), directional, [0.8; 3]);
        let below = json!([{ "point": { "position": [3, -4, 0] } }, { "directional": { "direction": [0, 1, 0] } }]);
        floor_shows(json!({ "diffuse": 0.5, "specular": 1 }), below, [0.0; 3]);
    }

    #[test]
    fn highlights_are_powers_of_the_cosine() {
        for (shininess, power) in
            [(0.0, 1.0), (1.0, 0.8), (2.0, 0.64), (3.5, 0.8f64.powf(3.5)), (32.0, 0.8f64.powi(32))]
        {
            let shiny = json!({ "diffuse": 0, "specular": [1, 0.5, 0], "shininess": shininess });
            floor_shows(shiny, point(json!({ "intensity": 2 })), [2.0 * power, power, 0.0]);
        }
        let mirror_direction = json!([{ "point": { "position": [0, 4, 0] } }]);
        floor_shows(json!({ "diffuse": 0, "specular": 0.7, "shininess": 1e6 }), mirror_direction, [0.7; 3]);
        floor_shows(json!({ "diffuse": 0.5, "specular": 0.5, "shininess": 2 }), point(json!({})), [0.72; 3]);
    }

    #[test]
    fn lights_add_up() {
        let lights = json!([
            { "point": { "position": [3, 4, 0], "color": [1, 0, 0] } },
            { "point": { "position": [0, 4, 3], "color": [0, 1, 0] } },
            { "directional": { "direction": [0, -1, 0], "color": [0, 0, 1] } }
        ]);
        floor_shows(json!({ "diffuse": 0.5 }), lights, [0.4, 0.4, 0.5]);
    }

    #[test]
    fn three_falloffs() {
        let diffuse = json!({ "diffuse": 1 });
        floor_shows(diffuse.clone(), point(json!({ "falloff": "none" })), [0.8; 3]);
        floor_shows(diffuse.clone(), point(json!({ "falloff": "inverse_square" })), [0.8 / 25.0; 3]);
        floor_shows(diffuse.clone(), point(json!({ "falloff": { "linear": { "reach": 20 } } })), [0.6; 3]);
        floor_shows(diffuse, point(json!({ "falloff": { "linear": { "reach": 4.9 } } })), [0.0; 3]);
    }

    #[test]
    fn spots_fade_between_two_angles() {
        // The axis misses the point on the floor by `off` degrees.
        let spot = |off: f64, inner: f64, outer: f64| {
            let angle = 4f64.atan2(3.0) + off.to_radians();
            let direction = [-angle.cos(), -angle.sin(), 0.0];
            json!([{ "spot": { "position": [3, 4, 0], "direction": direction, "inner_deg": inner, "outer_deg": outer } }])
        };
        let diffuse = json!({ "diffuse": 1 });
        for (off, inner, outer, part) in [
            (0.0, 10.0, 20.0, 1.0),
            (9.0, 10.0, 20.0, 1.0),
            (-9.0, 10.0, 20.0, 1.0),
            (21.0, 10.0, 20.0, 0.0),
            (19.0, 20.0, 20.0, 1.0),
            (21.0, 20.0, 20.0, 0.0),
        ] {
            floor_shows(diffuse.clone(), spot(off, inner, outer), [0.8 * part; 3]);
        }
        let cosine = |degrees: f64| degrees.to_radians().cos();
        let x = (cosine(15.0) - cosine(20.0)) / (cosine(10.0) - cosine(20.0));
        let expected = 0.8 * x * x * (3.0 - 2.0 * x);
        // Differences of cosines magnify a rounding twentyfold.
        for (pixel, small) in
            pixels(json!([floor()]), json!({ "materials": { "m": diffuse }, "lights": spot(15.0, 10.0, 20.0) }))
        {
            assert_vector(pixel, [expected; 3], 20.0 * small);
        }
    }

    #[test]
    fn checkers_are_even_where_the_tiles_add_up_to_an_even_number() {
        let axes = ["x", "y", "z", "xy", "xz", "yz", "xyz"];
        for name in axes {
            for (i, x) in [-0.75, -0.25, 0.25, 0.75].into_iter().enumerate() {
                for (k, z) in [-0.25, 0.25, 0.75].into_iter().enumerate() {
                    for (j, y) in [0.25, 0.75].into_iter().enumerate() {
                        let tiles = [i as i32 - 2, j as i32, k as i32 - 1];
                        let sum: i32 = (0..3).filter(|&a| name.contains(["x", "y", "z"][a])).map(|a| tiles[a]).sum();
                        let floor = json!({ "plane": { "point": [0, y, 0], "normal": [0, 1, 0], "material": "m" } });
                        let checker =
                            json!({ "checker": { "a": [1, 0, 0], "b": [0, 0, 1], "size": 0.5, "axes": name } });
                        let camera = json!({ "orthographic": { "eye": [x, 5, z], "look_at": [x, 0, z], "up": [0, 0, -1], "height": 1 } });
                        let more =
                            json!({ "materials": { "m": { "diffuse": checker } }, "ambient": 1, "camera": camera });
                        let expected = if sum.rem_euclid(2) == 0 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] };
                        shows(json!([floor]), more, expected);
                    }
                }
            }
        }
    }

    #[test]
    fn checkers_move_with_their_body() {
        let checker = json!({ "checker": { "a": 1, "b": 0 } });
        let group = |transform: Value| json!([{ "group": { "objects": [floor()], "transform": transform } }]);
        let more = |x: f64| {
            let camera = json!({ "orthographic": { "eye": [x, 5, 0.5], "look_at": [x, 0, 0.5], "up": [0, 0, -1], "height": 1 } });
            json!({ "materials": { "m": { "diffuse": checker } }, "ambient": 1, "camera": camera })
        };
        shows(group(json!({})), more(1.5), [0.0; 3]);
        shows(group(json!({ "scale": 2 })), more(1.5), [1.0; 3]);
        shows(group(json!({ "translate": [1, 0, 0] })), more(1.5), [1.0; 3]);
        shows(group(json!({ "translate": [1, 0, 0] })), more(0.5), [0.0; 3]);
    }

    fn shadowed(blocker: Value, shadows: &str, expected: [f64; 3]) {
        let more = json!({
            "materials": { "m": { "diffuse": 1, "ambient": 0.25 }, "filter": { "diffuse": 0, "transmission": [0.5, 0.25, 0] } },
            "ambient": 0.4,
            "lights": [{ "point": { "position": [3, 4, 0] } }],
            "render": { "shadows": shadows }
        });
        shows(json!([floor(), blocker]), more, expected);
    }

    #[test]
    fn shadows_are_opaque_transmissive_or_absent() {
        let pane =
            json!({ "disc": { "center": [1.5, 2, 0], "normal": [3, 4, 0], "radius": 0.5, "material": "filter" } });
        let ball = json!({ "sphere": { "center": [1.5, 2, 0], "radius": 0.5, "material": "filter" } });
        let wall = json!({ "sphere": { "center": [1.5, 2, 0], "radius": 0.5 } });
        for blocker in [&pane, &ball, &wall] {
            shadowed(blocker.clone(), "opaque", [0.1; 3]);
            shadowed(blocker.clone(), "none", [0.9; 3]);
        }
        shadowed(pane, "transmissive", [0.1 + 0.4, 0.1 + 0.2, 0.1]);
        shadowed(ball, "transmissive", [0.1 + 0.2, 0.1 + 0.05, 0.1]);
        shadowed(wall, "transmissive", [0.1; 3]);
    }

    #[test]
    fn what_stands_behind_the_light_casts_no_shadow() {
        let behind = json!({ "sphere": { "center": [6, 8, 0], "radius": 1 } });
        shadowed(behind, "opaque", [0.9; 3]);
        let beside = json!({ "sphere": { "center": [1.5, 2, 3], "radius": 1 } });
        shadowed(beside, "opaque", [0.9; 3]);
    }
}

mod recursion {
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
}

mod cameras {
    use super::*;

    /// First rays of pixels of a picture of 4 x 2 pixels, in single and double.
    fn first_rays(camera: Value, x: u32, y: u32) -> Vec<(Node, f64)> {
        let more = json!({ "camera": camera, "image": { "width": 4, "height": 2 }, "background": 1 });
        let objects = json!([{ "sphere": { "center": [0, 0, 1e6], "radius": 1 } }]);
        let first = |tree: Tree| tree.rays[0].clone();
        worlds(objects, more).iter().map(|w| (first(trace_pixel(&w.scene, x, y)), w.small)).collect()
    }

    #[track_caller]
    fn looks(camera: &Value, [x, y]: [u32; 2], origin: [f64; 3], direction: [f64; 3]) {
        for (ray, small) in first_rays(camera.clone(), x, y) {
            assert_vector(ray.origin, origin, small * 4.0);
            assert_vector(ray.direction, DVec3::from(direction).normalize().into(), small);
        }
    }

    #[track_caller]
    fn sees_only_background(camera: &Value, [x, y]: [u32; 2]) {
        for (ray, _) in first_rays(camera.clone(), x, y) {
            assert_eq!((ray.direction, ray.contribution), ([0.0; 3], [1.0; 3]));
        }
    }

    /// From (1, 2, 3) along x with z up: right is -y.
    fn aside(kind: &str, more: Value) -> Value {
        let mut camera = json!({ "eye": [1, 2, 3], "look_at": [8, 2, 3], "up": [1, 0, 2] });
        camera.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        json!({ kind: camera })
    }

    const EYE: [f64; 3] = [1.0, 2.0, 3.0];

    /// Forward, right and up parts of a direction of [`aside`].
    fn toward(forward: f64, right: f64, up: f64) -> [f64; 3] {
        [forward, -right, up]
    }

    #[test]
    fn pinhole() {
        let camera = aside("pinhole", json!({ "vfov_deg": 90 }));
        looks(&camera, [0, 0], EYE, toward(1.0, -1.5, 0.5));
        looks(&camera, [3, 0], EYE, toward(1.0, 1.5, 0.5));
        looks(&camera, [0, 1], EYE, toward(1.0, -1.5, -0.5));
        looks(&camera, [3, 1], EYE, toward(1.0, 1.5, -0.5));
        looks(&camera, [2, 1], EYE, toward(1.0, 0.5, -0.5));
    }

    #[test]
    fn orthographic() {
        let camera = aside("orthographic", json!({ "height": 4 }));
        for (pixel, [right, up]) in [
            ([0, 0], [-3.0, 1.0]),
            ([3, 0], [3.0, 1.0]),
            ([0, 1], [-3.0, -1.0]),
            ([3, 1], [3.0, -1.0]),
            ([2, 1], [1.0, -1.0]),
        ] {
            looks(&camera, pixel, [1.0, 2.0 - right, 3.0 + up], X);
        }
    }

    /// `r` of half the angle, in the direction (right, up).
    fn equidistant(r: f64, half_angle: f64, right: f64, up: f64) -> [f64; 3] {
        let (sin, cos) = (r * half_angle.to_radians()).sin_cos();
        let length = right.hypot(up);
        toward(cos, sin * right / length, sin * up / length)
    }

    #[test]
    fn fisheye() {
        // The circle touches the upper and the lower edge.
        for angle in [180.0, 360.0] {
            let camera = aside("fisheye", json!({ "fov_deg": angle }));
            let r = 0.5f64.sqrt();
            looks(&camera, [1, 0], EYE, equidistant(r, angle / 2.0, -1.0, 1.0));
            looks(&camera, [2, 0], EYE, equidistant(r, angle / 2.0, 1.0, 1.0));
            looks(&camera, [1, 1], EYE, equidistant(r, angle / 2.0, -1.0, -1.0));
            looks(&camera, [2, 1], EYE, equidistant(r, angle / 2.0, 1.0, -1.0));
            for corner in [[0, 0], [3, 0], [0, 1], [3, 1]] {
                sees_only_background(&camera, corner);
            }
        }
    }

    #[test]
    fn omnimax() {
        // The circle is as wide as the picture and twice as high: its lower half is cut off.
        let camera = aside("omnimax", json!({ "fov_deg": 180 }));
        looks(&camera, [1, 0], EYE, equidistant(0.25f64.hypot(0.75), 90.0, -1.0, 3.0));
        looks(&camera, [2, 0], EYE, equidistant(0.25f64.hypot(0.75), 90.0, 1.0, 3.0));
        looks(&camera, [0, 1], EYE, equidistant(0.75f64.hypot(0.25), 90.0, -3.0, 1.0));
        looks(&camera, [3, 1], EYE, equidistant(0.75f64.hypot(0.25), 90.0, 3.0, 1.0));
        looks(&camera, [2, 1], EYE, equidistant(0.25f64.hypot(0.25), 90.0, 1.0, 1.0));
        sees_only_background(&camera, [0, 0]);
        sees_only_background(&camera, [3, 0]);
    }

    #[test]
    fn panorama() {
        let camera = aside("panorama", json!({}));
        let h = 0.5f64.sqrt();
        looks(&camera, [0, 0], EYE, toward(-0.5, -0.5, h));
        looks(&camera, [1, 0], EYE, toward(0.5, -0.5, h));
        looks(&camera, [3, 0], EYE, toward(-0.5, 0.5, h));
        looks(&camera, [0, 1], EYE, toward(-0.5, -0.5, -h));
        looks(&camera, [2, 1], EYE, toward(0.5, 0.5, -h));
        looks(&camera, [3, 1], EYE, toward(-0.5, 0.5, -h));
        let narrow = aside("panorama", json!({ "hfov_deg": 80, "vfov_deg": 40 }));
        let (sin, cos) = 30f64.to_radians().sin_cos();
        let (sin_up, cos_up) = 10f64.to_radians().sin_cos();
        looks(&narrow, [3, 0], EYE, toward(cos * cos_up, sin * cos_up, sin_up));
    }

    #[test]
    fn cylinder() {
        let camera = aside("cylinder", json!({ "hfov_deg": 240, "vfov_deg": 90 }));
        for (x, degrees) in [(0, -90.0f64), (1, -30.0), (2, 30.0), (3, 90.0)] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            looks(&camera, [x, 0], EYE, toward(cos, sin, 0.5));
            looks(&camera, [x, 1], EYE, toward(cos, sin, -0.5));
        }
    }
}

mod trees {
    use super::*;

    /// Glass, mirrors, three lights and a checked floor: all kinds of rays.
    fn still_life(camera: Value, render: Value) -> [World; 2] {
        let objects = json!([
            { "plane": { "point": [0, -1, 0], "normal": [0, 1, 0], "material": "floor" } },
            { "sphere": { "center": [-0.8, 0, 0], "radius": 1, "material": "crystal" } },
            { "sphere": { "center": [-0.8, 0, 0], "radius": 0.9, "material": "crystal", "hollow": true } },
            { "box": { "min": [0.6, -1, -1], "max": [1.6, 0.4, 0.2], "material": "chrome" } },
            { "torus": { "center": [0.2, -0.7, 1.2], "major_radius": 0.5, "minor_radius": 0.2, "material": "solid" } },
            { "quad": { "vertices": [[-3, -1, -3], [3, -1, -3], [3, 3, -3], [-3, 3, -3]], "material": "chrome" } }
        ]);
        worlds(
            objects,
            json!({
                "image": { "width": 24, "height": 16 },
                "camera": camera,
                "ambient": 0.2,
                "background": [0.3, 0.5, 0.9],
                "materials": {
                    "floor": { "diffuse": { "checker": { "a": 0.9, "b": [0.6, 0.1, 0.1] } }, "reflection": 0.1 },
                    "crystal": { "diffuse": 0.05, "specular": 0.6, "shininess": 50, "reflection": 0.15, "transmission": 0.8, "ior": 1.5 },
                    "solid": { "diffuse": 0.05, "reflection": 0.1, "transmission": [0.9, 0.6, 0.3], "ior": 2.4 },
                    "chrome": { "diffuse": 0.2, "specular": 0.5, "reflection": 0.6 }
                },
                "lights": [
                    { "point": { "position": [4, 6, 3], "color": [1, 0.9, 0.8], "falloff": { "linear": { "reach": 30 } } } },
                    { "directional": { "direction": [1, -2, -1.5], "intensity": 0.4 } },
                    { "spot": { "position": [-3, 5, 4], "direction": [2, -5, -4], "inner_deg": 5, "outer_deg": 30, "falloff": "inverse_square", "intensity": 20 } }
                ],
                "render": render
            }),
        )
    }

    fn pinhole() -> Value {
        json!({ "pinhole": { "eye": [0.5, 1.2, 5], "look_at": [0, -0.2, 0], "vfov_deg": 40 } })
    }

    /// The contributions, added in the tree's order and precision.
    fn sum(tree: &Tree) -> [f64; 3] {
        std::array::from_fn(|i| {
            let parts = tree.rays.iter().map(|ray| ray.contribution[i]);
            match tree.precision {
                "single" => parts.fold(0.0f32, |sum, part| sum + part as f32).into(),
                _ => parts.fold(0.0, |sum, part| sum + part),
            }
        })
    }

    fn trees_are_pictures(worlds: &[World; 2]) {
        for World { scene, .. } in worlds {
            let whole = Region::whole(scene.width, scene.height);
            let picture = render(scene, whole, &Control::default()).unwrap();
            for ([x, y], pixel) in whole.iter().zip(&picture.film.pixels) {
                let tree = trace_pixel(scene, x, y);
                assert!(!tree.truncated);
                assert_eq!(sum(&tree), tree.value, "pixel {x}, {y}: the contributions");
                assert_eq!(tree.value.map(|c| c as f32), *pixel, "pixel {x}, {y}: the picture");
            }
        }
    }

    #[test]
    fn contributions_add_up_to_the_rendered_pixel_bit_for_bit() {
        trees_are_pictures(&still_life(pinhole(), json!({ "antialias": false, "shadows": "transmissive" })));
    }

    #[test]
    fn so_they_do_with_several_samples() {
        trees_are_pictures(&still_life(pinhole(), json!({ "antialias": false, "samples": 3, "max_depth": 5 })));
    }

    #[test]
    fn so_they_do_where_antialiasing_refines() {
        let worlds = still_life(pinhole(), json!({ "antialias": true, "max_depth": 4 }));
        trees_are_pictures(&worlds);
        let whole = Region::whole(24, 16).iter();
        let samples: Vec<u32> = whole.map(|[x, y]| trace_pixel(&worlds[0].scene, x, y).samples).collect();
        assert!(samples.contains(&1) && samples.contains(&16), "{samples:?}");
    }

    #[test]
    fn so_they_do_outside_the_image_circle_and_inside_glass() {
        let fisheye = json!({ "fisheye": { "eye": [-0.8, 0.1, 0.95], "look_at": [0, 0, 0] } });
        trees_are_pictures(&still_life(fisheye, json!({ "antialias": false, "min_weight": 0.01 })));
    }

    /// A glass body of unit size, placed and scaled.
    fn glass(kind: &str, place: DVec3, scale: f64) -> Value {
        let at = |x: f64, y: f64, z: f64| (place + DVec3::new(x, y, z) * scale).to_array();
        let mut body = match kind {
            "sphere" => json!({ "center": at(0.0, 0.0, 0.0), "radius": scale }),
            "box" => json!({ "min": at(-0.7, -0.5, -0.6), "max": at(0.6, 0.4, 0.7) }),
            "cylinder" => json!({ "base": at(0.3, -0.8, 0.1), "top": at(-0.2, 0.7, 0.3), "radius": 0.5 * scale }),
            "cone" => json!({ "base": at(0.3, -0.8, 0.1), "base_radius": 0.7 * scale, "top": at(-0.2, 0.9, 0.3) }),
            "torus" => json!({ "center": at(0.0, 0.0, 0.0), "axis": [0.3, 0.5, 0.8],
                               "major_radius": 0.8 * scale, "minor_radius": 0.3 * scale }),
            _ => {
                json!({ "vertices": [at(-0.8, -0.7, -0.6), at(0.9, -0.8, -0.5), at(0.1, 0.9, -0.4), at(0.0, 0.0, 0.9)],
                         "faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] })
            }
        };
        body["material"] = "crystal".into();
        json!([{ kind: body }])
    }

    #[test]
    fn rays_enter_bodies_from_outside_and_leave_them_from_inside_at_any_scale() {
        let mut random = uniform(7);
        let mut point = move || DVec3::new(2.0 * random() - 1.0, 2.0 * random() - 1.0, 2.0 * random() - 1.0);
        for kind in ["sphere", "box", "cylinder", "cone", "torus", "mesh"] {
            for (scale, away) in [(1e-6, 0.0), (1.0, 0.0), (1.0, 30.0), (1e6, 0.0)] {
                for _ in 0..60 {
                    let place = point() * away * scale;
                    let (eye, target) = (place + point().normalize() * (4.0 * scale), place + point() * (0.5 * scale));
                    let more = json!({
                        "camera": { "orthographic": { "eye": eye.to_array(), "look_at": target.to_array(), "height": scale } },
                        "materials": { "crystal": { "diffuse": 0, "reflection": 0.3, "transmission": 0.7, "ior": 1.5 } },
                        "render": { "max_depth": 6, "min_weight": 0 }
                    });
                    for World { scene, .. } in &worlds(glass(kind, place, scale), more) {
                        for ray in &trace_pixel(scene, 0, 0).rays {
                            let inside = !ray.media.is_empty();
                            let entering = ray.hit.as_ref().map(|hit| hit.entering);
                            let expected = if inside { entering == Some(false) } else { entering != Some(false) };
                            assert!(expected, "{kind} of size {scale}, inside: {inside}: {ray:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn every_ray_comes_from_the_one_it_names() {
        for &World { ref scene, small } in &still_life(pinhole(), json!({ "antialias": false })) {
            for [x, y] in Region::whole(scene.width, scene.height).iter() {
                let tree = trace_pixel(scene, x, y);
                for ray in &tree.rays {
                    let Some(parent) = ray.parent.map(|p| &tree.rays[p as usize]) else {
                        assert_eq!((ray.kind, ray.depth), (NodeKind::Camera, 1));
                        continue;
                    };
                    assert!(parent.id < ray.id && ray.depth == parent.depth + 1);
                    assert!(ray.weight.iter().zip(parent.weight).all(|(w, p)| *w <= p * 1.000_001));
                    let from = parent.hit.as_ref().unwrap();
                    assert_vector(ray.origin, from.point, 64.0 * small);
                    let (d, n) = (DVec3::from(ray.direction), DVec3::from(from.normal));
                    let before = DVec3::from(parent.direction).dot(n);
                    assert_near(d.length(), 1.0, small);
                    match ray.kind {
                        NodeKind::Reflected => assert_near(d.dot(n), -before, small),
                        NodeKind::Transmitted => assert!(d.dot(n) * before > 0.0),
                        NodeKind::Shadow => assert!(d.dot(n) * before < 0.0),
                        NodeKind::Camera => unreachable!("camera rays have no parent"),
                    }
                    if let (NodeKind::Transmitted, Some(snell)) = (ray.kind, parent.snell) {
                        let sine = |d: DVec3| d.cross(n).length();
                        assert_near(snell.n2 * sine(d), snell.n1 * sine(parent.direction.into()), 4.0 * small);
                    }
                }
            }
        }
    }
}

#[test]
fn extreme_scales_cancel_out() {
    // A body of any size under the inverse scale is a body of size 1, seen at the same distances.
    for precision in [Precision::Single, Precision::Double] {
        let overrides = Overrides { precision: Some(precision), ..Overrides::default() };
        for power in [-14, -10, -5, 5, 10, 14] {
            let size = 10f64.powi(power);
            for body in [
                json!({ "sphere": { "center": [0, 0, 0], "radius": size } }),
                json!({ "cylinder": { "base": [0, -size, 0], "top": [0, size, 0], "radius": size } }),
                json!({ "cone": { "base": [0, -size, 0], "top": [0, size, 0], "base_radius": 2.0 * size } }),
                json!({ "torus": { "center": [0, 0, 0], "axis": [0, 1, 0], "major_radius": 0.75 * size, "minor_radius": 0.25 * size } }),
                json!({ "box": { "min": [-size, -size, -size], "max": [size, size, size] } }),
            ] {
                let scene = json!({
                    "version": 1,
                    "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
                    "definitions": { "body": [body] },
                    "objects": [{ "instance": { "of": "body", "transform": { "scale": 1.0 / size } } }]
                });
                let loaded = load(&serde_json::to_vec(&scene).unwrap(), Format::Json, &overrides).unwrap();
                let ray = RayQuery { origin: [0.0, 0.0, 5.0], direction: [0.0, 0.0, -1.0], t_min: 0.0, t_max: None };
                let hit = answer(&loaded.scene, &ray).at.unwrap_or_else(|| panic!("{precision:?} misses {body}"));
                assert!((hit.t - 4.0).abs() < 1e-5, "{precision:?}: t = {} for {body}", hit.t);
                let ray = RayQuery { direction: [0.0, 2.0, -1.0], ..ray };
                assert!(!answer(&loaded.scene, &ray).hit, "{precision:?} meets {body} beside it");
            }
        }
    }
}
