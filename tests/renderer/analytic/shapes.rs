//! Shapes: what rays hit of each, and where.

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
        let cone = json!({ "base": [0, base.0, 0], "base_radius": base.1, "top": [0, top.0, 0], "top_radius": top.1 });
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
