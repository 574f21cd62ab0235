//! Rays onto single shapes.

use super::*;
use glam::DMat3;
use strahl::inspect::query::answer;
use strahl::math::hypot;

pub fn sphere(query: &Query<'_>) -> Check {
    let (center, radius) = (vector(query.shape("center")), number(query.shape("radius")));
    let scene = bare(query, json!({ "sphere": { "center": center.to_array(), "radius": radius } }));
    let hit = answer(&scene, &query.ray()).at;
    match query.decision("") {
        Some(false) => return must_miss(hit),
        None if hit.is_none() => return Ok(()),
        _ => {}
    }
    let hit = must_hit(hit)?;
    unit("the normal", query, hit.normal)?;
    if query.data["expect"]["dist"].is_number() {
        distance(query, &hit, query.tolerance("dist_abs"))?;
    }
    let from_center = DVec3::from_array(hit.point) - center;
    near("the point's radius", from_center.length(), radius, query.tolerance("surface_residual_abs"))?;
    Ok(())
}

pub fn plane(query: &Query<'_>) -> Check {
    let (point, normal) = (vector(query.shape("point")), vector(query.shape("normal_unnormalised")));
    let scene = bare(query, json!({ "plane": { "point": point.to_array(), "normal": normal.to_array() } }));
    let hit = answer(&scene, &query.ray()).at;
    let expect = &query.data["expect"];
    let representable =
        query.precision == Precision::Double || expect["t"].as_f64().is_none_or(|t| (t as f32).is_finite());
    if expect["hit"] == false || !representable {
        return must_miss(hit);
    }
    let hit = must_hit(hit)?;
    distance(query, &hit, query.tolerance("dist_abs"))?;
    let off = (DVec3::from_array(hit.point) - point).dot(normal.normalize());
    let allowed = number(&query.data["tol"]["plane_residual_abs_f32"]) * query.u / (f64::from(f32::EPSILON) / 2.0);
    near("the point's distance from the plane", off, 0.0, allowed)
}

pub fn disc(query: &Query<'_>) -> Check {
    let disc = json!({ "disc": { "center": query.shape("center"), "normal": query.shape("normal"), "radius": query.shape("radius") } });
    let hit = answer(&bare(query, disc), &query.ray()).at;
    match query.decision("") {
        Some(false) => must_miss(hit),
        None if hit.is_none() => Ok(()),
        _ => near("t", must_hit(hit)?.t, number(&query.data["expect"]["t"]), 0.0),
    }
}

/// A box that a ray only touches may be hit or missed.
pub fn cuboid(query: &Query<'_>) -> Check {
    let scene = bare(query, json!({ "box": { "min": query.shape("lo"), "max": query.shape("hi") } }));
    let hit = answer(&scene, &query.ray()).at;
    let expect = &query.data["expect"];
    if expect["hit_closed_box"] == false {
        return must_miss(hit);
    }
    match hit {
        None if expect["on_boundary_only"] == true => Ok(()),
        hit => near("t", must_hit(hit)?.t, number(&expect["t_enter"]), 0.0),
    }
}

pub fn torus(query: &Query<'_>) -> Check {
    let (major, minor) = (number(query.shape("major_R")), number(query.shape("minor_r")));
    let torus = json!({ "center": [0, 0, 0], "axis": [0, 0, 1], "major_radius": major, "minor_radius": minor });
    let hit = answer(&bare(query, json!({ "torus": torus })), &query.ray()).at;
    if query.data["expect"]["hit"] == false {
        return must_miss(hit);
    }
    let hit = must_hit(hit)?;
    distance(query, &hit, query.tolerance("dist_abs"))?;
    let [x, y, z] = hit.point;
    let off = hypot(hypot(x, y) - major, z) - minor;
    near("the point's distance from the tube", off, 0.0, query.tolerance("surface_residual_abs"))?;
    unit("the normal", query, hit.normal)
}

/// No tolerance in the file: 8 roundings of the distance from the body's nearest end, over the cosine of incidence.
pub fn cylinder(query: &Query<'_>) -> Check {
    let (radius, low, high) = (number(query.shape("radius")), number(query.shape("zmin")), number(query.shape("zmax")));
    let cylinder =
        json!({ "base": [0, 0, low], "top": [0, 0, high], "radius": radius, "capped": query.shape("capped") });
    let ray = query.ray();
    let hit = answer(&bare(query, json!({ "cylinder": cylinder })), &ray).at;
    let expect = &query.data["expect"];
    if query.data["name"] == "axis_parallel_on_wall" {
        // Along the wall itself: the rim or nothing.
        return hit.map_or(Ok(()), |hit| finite(&hit));
    }
    if expect["hit"] == false {
        return must_miss(hit);
    }
    let hit = must_hit(hit)?;
    let (point, direction) = (vector(&expect["point"]), DVec3::from_array(ray.direction).normalize());
    let outward = if expect["part"] == "side" { DVec3::new(point.x, point.y, 0.0).normalize() } else { DVec3::Z };
    let size = number(&expect["dist"]) + DVec3::from_array(ray.origin).length() + radius;
    let allowed = 8.0 * query.u * size / outward.dot(direction).abs();
    distance(query, &hit, allowed)?;
    unit("the normal", query, hit.normal)?;
    let cosine = DVec3::from_array(hit.normal).dot(outward).abs();
    near("the cosine between the normals", cosine, 1.0, 1e-3)
}

pub fn triangles(query: &Query<'_>) -> Check {
    let hit = must_hit(mesh(query, query.shape("tris")))?;
    distance(query, &hit, query.tolerance("dist_abs"))
}

/// Triangles without area, or seen from their edge. Slivers stay in a mesh, where they fill the gap between their
/// neighbours, so one may be hit, at a point of it and with a normal.
pub fn degenerate(query: &Query<'_>) -> Check {
    let mut triangles = query.shape("tris").clone();
    // A mesh without any area is refused, so there is some beside it.
    triangles.as_array_mut().unwrap().push(json!([[1e9, 0, 0], [1e9, 1, 0], [1e9, 0, 1]]));
    let Some(hit) = mesh(query, &triangles) else { return Ok(()) };
    if query.data["name"] != "pbrt_badcases" {
        return must_miss(Some(hit));
    }
    let hit = must_hit(Some(hit))?;
    unit("the normal", query, hit.normal)?;
    let corners: Vec<DVec3> = (0..3).map(|i| vector(&query.shape("tris")[0][i])).collect();
    let (low, high) = (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
    let outside = DVec3::from_array(hit.point) - DVec3::from_array(hit.point).clamp(low, high);
    near_vector("the way to the sliver", outside, DVec3::ZERO, 8.0 * query.u * high.abs().max(low.abs()).max_element())
}

/// Directions of any length, from the middle of a ball: the normal there is the unit direction.
pub fn normalised(query: &Query<'_>) -> Check {
    let v = vector(&query.data["in"]["v"]);
    if v == DVec3::ZERO {
        return Ok(());
    }
    let scene = bare(query, json!({ "sphere": { "center": [0, 0, 0], "radius": 1 } }));
    let ray = RayQuery { origin: [0.0; 3], direction: v.into(), t_min: 0.0, t_max: None };
    let hit = must_hit(answer(&scene, &ray).at)?;
    let expected = vector(&query.data["expect"]["unit"]);
    near_vector("the normal", DVec3::from_array(hit.normal), expected, 3.0 * query.u)?;
    near_vector("the mirror direction", -DVec3::from_array(hit.reflected), expected, 8.0 * query.u)
}

fn mesh(query: &Query<'_>, triangles: &Value) -> Option<RayHit> {
    let corners: Vec<&Value> = triangles.as_array().unwrap().iter().flat_map(|t| t.as_array().unwrap()).collect();
    let faces: Vec<[usize; 3]> = (0..corners.len() / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let scene = bare(query, json!({ "mesh": { "vertices": corners, "faces": faces } }));
    answer(&scene, &query.ray()).at
}

pub fn instance(query: &Query<'_>) -> Check {
    let matrix = matrix(query);
    let offset = vector(query.shape("translation"));
    let columns: Vec<f64> =
        (0..3).flat_map(|i| matrix.col(i).extend(0.0).to_array()).chain(offset.extend(1.0).to_array()).collect();
    let more = json!({ "definitions": { "ball": [{ "sphere": { "center": [0, 0, 0], "radius": 1 } }] } });
    let scene = scene(query, json!([{ "instance": { "of": "ball", "transform": { "matrix": columns } } }]), more);
    let hit = must_hit(answer(&scene, &query.ray()).at)?;
    unit("the normal", query, hit.normal)?;
    let residual = query.tolerance("object_space_surface_residual");
    // A point in the world is rounded to the format there.
    let inverse = matrix.inverse();
    let spacing = query.u * (DVec3::from_array(hit.point).abs() + offset.abs()).max_element();
    let rounding = 2.0 * spacing * (0..3).map(|i| inverse.row(i).length()).fold(0.0, f64::max);
    let local = inverse * (DVec3::from_array(hit.point) - offset);
    near("the local radius", local.length(), 1.0, residual + rounding)?;
    let normal = vector(&query.data["expect"]["normal_outward"]);
    near_vector("the normal", DVec3::from_array(hit.normal), normal, turn(query, inverse))
}

/// How far an instance's normal may be off: an error e of the local point turns it by at most |M^-T e| / |M^-T p|.
pub fn turn(query: &Query<'_>, inverse: DMat3) -> f64 {
    let residual = query.tolerance("object_space_surface_residual");
    let transposed = inverse.transpose();
    let local = inverse * (vector(&query.data["expect"]["point"]) - vector(query.shape("translation")));
    let stretch = (0..3).map(|i| transposed.col(i).length()).fold(0.0, f64::max);
    let turn = 2.0 * residual * stretch / (transposed * local).length();
    (turn + 8.0 * query.u).min(0.5)
}

/// Matrix of an instance.
pub fn matrix(query: &Query<'_>) -> DMat3 {
    let rows: [DVec3; 3] = std::array::from_fn(|i| vector(&query.shape("matrix3x3_rows")[i]));
    DMat3::from_cols(rows[0], rows[1], rows[2]).transpose()
}
