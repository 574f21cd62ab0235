//! Hard cases with exact answers, asked in both precisions. See `ground_truth/README.md`.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use glam::{DMat3, DVec3};
use serde_json::{Value, json};
use strahl::camera::{Basis, Camera};
use strahl::lanes::{Lanes, MAX_LANES, Mask, Real, V3};
use strahl::scene::description::{self, Precision};
use strahl::scene::{Format, Overrides, Scene, load};
use strahl::shading::phong::{highlight_cosine, power};
use strahl::trace::query::{RayHit, RayQuery, answer};
use strahl::trace::tree::{Node, NodeKind, trace_pixel};

/// Queries that strahl is known to answer wrongly: file, query and precision. Each must still fail.
const KNOWN_GAPS: &[(&str, &str, Precision)] = &[];

/// One question.
struct Query<'a> {
    data: &'a Value,
    precision: Precision,
    /// Largest relative error of one rounding.
    u: f64,
}

/// Why an answer is wrong.
type Check = Result<(), String>;

/// Asks all queries of a file in both precisions.
fn ask_all(file: &str, check: impl Fn(&Query<'_>) -> Check) {
    let path = format!("{}/tests/ground_truth/{file}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let contents: Value = serde_json::from_str(&text).unwrap();
    let mut wrong = Vec::new();
    for data in contents["queries"].as_array().unwrap() {
        let name = data["name"].as_str().unwrap();
        for (precision, u) in
            [(Precision::Single, f64::from(f32::EPSILON) / 2.0), (Precision::Double, f64::EPSILON / 2.0)]
        {
            let outcome = check(&Query { data, precision, u });
            let known = KNOWN_GAPS.contains(&(file, name, precision));
            match outcome {
                Err(why) if !known => wrong.push(format!("{name} in {precision:?}: {why}")),
                Ok(()) if known => wrong.push(format!("{name} in {precision:?} is answered now: it is no gap")),
                _ => {}
            }
        }
    }
    assert!(wrong.is_empty(), "{file}:\n{}", wrong.join("\n"));
}

/// The question's scene: objects of one material `m`, without lights. `more` replaces keys.
fn scene(query: &Query<'_>, objects: Value, more: Value) -> Scene {
    let mut description = json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "pinhole": { "eye": [0, 0, 0], "look_at": [0, 0, -1] } },
        "lights": [],
        "objects": objects
    });
    for (key, value) in more.as_object().unwrap() {
        description[key] = value.clone();
    }
    let overrides = Overrides { precision: Some(query.precision), ..Overrides::default() };
    load(description.to_string().as_bytes(), Format::Json, &overrides).unwrap_or_else(|p| panic!("{p}")).scene
}

fn bare(query: &Query<'_>, object: Value) -> Scene {
    scene(query, json!([object]), json!({}))
}

impl Query<'_> {
    fn shape(&self, key: &str) -> &Value {
        &self.data["shape"][key]
    }

    fn tolerance(&self, what: &str) -> f64 {
        let format = if self.precision == Precision::Single { "f32" } else { "f64" };
        let key = format!("{what}_{format}");
        self.data["tol"][&key].as_f64().unwrap_or_else(|| panic!("no tolerance {key}"))
    }

    fn has_tolerance(&self) -> bool {
        self.data["tol"].is_object()
    }

    /// Whether hitting (or total reflection, or ...) is forced: the answer, or `None` for either.
    fn decision(&self, prefix: &str) -> Option<bool> {
        let format = if self.precision == Precision::Single { "f32" } else { "f64" };
        match &self.data["decision"][format!("{prefix}{format}")] {
            Value::String(word) if word == "either" => None,
            Value::String(word) => Some(word == "must_hit" || word == "true"),
            Value::Bool(yes) => Some(*yes),
            other => panic!("decision {other}"),
        }
    }

    fn ray(&self) -> RayQuery {
        let ray = &self.data["ray"];
        RayQuery { origin: vector(&ray["o"]).into(), direction: vector(&ray["d"]).into(), t_min: 0.0, t_max: None }
    }

    fn length(&self) -> f64 {
        vector(&self.data["ray"]["d"]).length()
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn vector(value: &Value) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|i| number(&value[i])))
}

/// Whether `actual` is within `tolerance` of `expected`; never for NaN.
fn near(what: &str, actual: f64, expected: f64, tolerance: f64) -> Check {
    if (actual - expected).abs() <= tolerance {
        return Ok(());
    }
    let off = (actual - expected).abs();
    Err(format!("{what} is {actual:e}, exactly {expected:e}: off by {off:.3e}, allowed {tolerance:.3e}"))
}

fn near_vector(what: &str, actual: DVec3, expected: DVec3, tolerance: f64) -> Check {
    for i in 0..3 {
        near(&format!("{what}[{i}]"), actual[i], expected[i], tolerance)?;
    }
    Ok(())
}

fn unit(what: &str, query: &Query<'_>, v: [f64; 3]) -> Check {
    near(&format!("the length of {what}"), DVec3::from_array(v).length(), 1.0, 4.0 * query.u)
}

fn finite(hit: &RayHit) -> Check {
    let numbers = [hit.t, hit.reflectance].into_iter().chain(hit.point).chain(hit.normal).chain(hit.reflected);
    if numbers.chain(hit.transmitted.into_iter().flatten()).all(f64::is_finite) {
        Ok(())
    } else {
        Err(format!("not finite: {hit:?}"))
    }
}

fn must_hit(hit: Option<RayHit>) -> Result<RayHit, String> {
    let hit = hit.ok_or("missed")?;
    finite(&hit)?;
    Ok(hit)
}

fn must_miss(hit: Option<RayHit>) -> Check {
    hit.map_or(Ok(()), |hit| Err(format!("hit at t = {:e}", hit.t)))
}

fn distance(query: &Query<'_>, hit: &RayHit, tolerance: f64) -> Check {
    near("the distance", hit.t * query.length(), number(&query.data["expect"]["dist"]), tolerance)
}

fn sphere(query: &Query<'_>) -> Check {
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

fn plane(query: &Query<'_>) -> Check {
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

fn disc(query: &Query<'_>) -> Check {
    let disc = json!({ "disc": { "center": query.shape("center"), "normal": query.shape("normal"), "radius": query.shape("radius") } });
    let hit = answer(&bare(query, disc), &query.ray()).at;
    match query.decision("") {
        Some(false) => must_miss(hit),
        None if hit.is_none() => Ok(()),
        _ => near("t", must_hit(hit)?.t, number(&query.data["expect"]["t"]), 0.0),
    }
}

/// A box that a ray only touches may be hit or missed.
fn cuboid(query: &Query<'_>) -> Check {
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

fn torus(query: &Query<'_>) -> Check {
    let (major, minor) = (number(query.shape("major_R")), number(query.shape("minor_r")));
    let torus = json!({ "center": [0, 0, 0], "axis": [0, 0, 1], "major_radius": major, "minor_radius": minor });
    let hit = answer(&bare(query, json!({ "torus": torus })), &query.ray()).at;
    if query.data["expect"]["hit"] == false {
        return must_miss(hit);
    }
    let hit = must_hit(hit)?;
    distance(query, &hit, query.tolerance("dist_abs"))?;
    let [x, y, z] = hit.point;
    let off = (x.hypot(y) - major).hypot(z) - minor;
    near("the point's distance from the tube", off, 0.0, query.tolerance("surface_residual_abs"))?;
    unit("the normal", query, hit.normal)
}

/// No tolerance in the file: 8 roundings of the distance from the body's nearest end, over the cosine of incidence.
fn cylinder(query: &Query<'_>) -> Check {
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

fn triangles(query: &Query<'_>) -> Check {
    let hit = must_hit(mesh(query, query.shape("tris")))?;
    distance(query, &hit, query.tolerance("dist_abs"))
}

/// Triangles without area, or seen from their edge. Slivers stay in a mesh, where they fill the gap between their
/// neighbours, so one may be hit, at a point of it and with a normal.
fn degenerate(query: &Query<'_>) -> Check {
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
fn normalised(query: &Query<'_>) -> Check {
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

fn instance(query: &Query<'_>) -> Check {
    let rows: [DVec3; 3] = std::array::from_fn(|i| vector(&query.shape("matrix3x3_rows")[i]));
    let matrix = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
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
    // An error e of the local point turns the normal by at most |M^-T e| / |M^-T p|.
    let normal = vector(&query.data["expect"]["normal_outward"]);
    let transposed = inverse.transpose();
    let local_exact = inverse * (vector(&query.data["expect"]["point"]) - offset);
    let stretch = (0..3).map(|i| transposed.col(i).length()).fold(0.0, f64::max);
    let turn = 2.0 * residual * stretch / (transposed * local_exact).length();
    near_vector("the normal", DVec3::from_array(hit.normal), normal, (turn + 8.0 * query.u).min(0.5))
}

/// The rays of the only pixel of an orthographic picture, which starts at `eye` along `direction`.
fn tree(query: &Query<'_>, eye: DVec3, direction: DVec3, objects: Value, materials: Value, render: Value) -> Vec<Node> {
    let up = if direction.x == 0.0 && direction.z == 0.0 { [1, 0, 0] } else { [0, 1, 0] };
    let look_at = (eye + direction).to_array();
    let camera = json!({ "orthographic": { "eye": eye.to_array(), "look_at": look_at, "up": up, "height": 1 } });
    let more = json!({ "camera": camera, "materials": materials, "render": render });
    trace_pixel(&scene(query, objects, more), 0, 0).rays
}

/// The rays that go straight on: the camera ray and those transmitted from it.
fn transmitted(rays: &[Node]) -> Result<Vec<&Node>, String> {
    let mut chain = vec![&rays[0]];
    while let Some(next) = rays.iter().find(|r| r.parent == Some(chain[chain.len() - 1].id)) {
        if next.kind != NodeKind::Transmitted {
            return Err(format!("ray {} is {:?}", next.id, next.kind));
        }
        chain.push(next);
    }
    Ok(chain)
}

fn clear(ior: &Value) -> Value {
    json!({ "glass": { "diffuse": 0, "transmission": 1, "ior": ior } })
}

fn hit_of(node: &Node) -> Result<DVec3, String> {
    node.hit.as_ref().map(|hit| DVec3::from_array(hit.point)).ok_or_else(|| format!("ray {} hits nothing", node.id))
}

fn glass_sphere(query: &Query<'_>) -> Check {
    let ball = json!([{ "sphere": { "center": query.shape("center"), "radius": query.shape("radius"), "material": "glass" } }]);
    let (o, d) = (vector(&query.data["ray"]["o"]), vector(&query.data["ray"]["d"]));
    let rays = tree(query, o, d, ball, clear(query.shape("n_inside")), json!({}));
    let chain = transmitted(&rays)?;
    if chain.len() != 3 {
        return Err(format!("{} rays instead of 3", chain.len()));
    }
    let expect = &query.data["expect"];
    let tolerance = query.tolerance("exit_direction_abs");
    let direction = |i: usize| DVec3::from_array(chain[i].direction);
    near_vector("the entry point", hit_of(chain[0])?, vector(&expect["entry_point"]), tolerance)?;
    near_vector("the direction inside", direction(1), vector(&expect["inside_unit"]), tolerance)?;
    near_vector("the exit point", hit_of(chain[1])?, vector(&expect["exit_point"]), tolerance)?;
    near_vector("the direction behind", direction(2), vector(&expect["exit_unit"]), tolerance)?;
    for (i, place) in ["entry", "exit"].into_iter().enumerate() {
        let snell = chain[i].snell.ok_or("no refraction")?;
        if snell.tir {
            return Err("total reflection".to_owned());
        }
        near(&format!("R at the {place}"), snell.reflectance, number(&expect["R_first"]), 8.0 * tolerance)?;
    }
    if chain[1].media.len() == 1 && chain[2].media.is_empty() { Ok(()) } else { Err("wrong media".to_owned()) }
}

fn slab(query: &Query<'_>) -> Check {
    let input = &query.data["in"];
    let d = vector(&input["d"]);
    let slab = json!([{ "box": { "min": [-256, -number(&input["thickness"]), -256], "max": [256, 0, 256], "material": "glass" } }]);
    let rays = tree(query, -d, d, slab, clear(&input["n_slab"]), json!({}));
    let chain = transmitted(&rays)?;
    if chain.len() != 3 {
        return Err(format!("{} rays instead of 3", chain.len()));
    }
    let expect = &query.data["expect"];
    let exit = DVec3::from_array(chain[2].direction);
    let tolerance = query.tolerance("exit_direction_abs");
    near_vector("the direction behind", exit, vector(&expect["exit_direction_unit_equals_entry"]), tolerance)?;
    let (entry, exit) = (hit_of(chain[0])?, hit_of(chain[1])?);
    // Roundings of the direction move the entry along the face, over the way to it.
    let steep = (d.length() / d.y).abs();
    near_vector("the entry point", entry, DVec3::ZERO, 8.0 * query.u * d.length() * steep)?;
    let thickness = number(&input["thickness"]);
    let allowed = 16.0 * query.u * thickness * steep + 4.0 * query.u * entry.abs().max_element();
    near_vector("the way through", exit - entry, vector(&expect["exit_point"]), allowed)?;
    if chain[1].media.len() == 1 && chain[2].media.is_empty() { Ok(()) } else { Err("wrong media".to_owned()) }
}

/// A half-space of one medium inside a half-space of the other.
fn two_media(n1: &Value, n2: &Value) -> (Value, Value) {
    let objects = json!([
        { "plane": { "point": [0, 64, 0], "normal": [0, 1, 0], "material": "above" } },
        { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "below", "name": "interface" } }
    ]);
    let medium = |ior: &Value| json!({ "diffuse": 0, "transmission": 1, "ior": ior });
    (objects, json!({ "above": medium(n1), "below": medium(n2) }))
}

fn critical(query: &Query<'_>) -> Check {
    let input = &query.data["in"];
    let d = vector(&input["d"]);
    let (objects, materials) = two_media(&input["n1_incident"], &input["n2_transmitted"]);
    let scene = scene(query, objects, json!({ "materials": materials }));
    let ray = RayQuery { origin: (-d).into(), direction: d.into(), t_min: 0.0, t_max: None };
    let hit = must_hit(answer(&scene, &ray).at)?;
    if hit.name.as_deref() != Some("interface") {
        return Err(format!("hit {}", hit.object));
    }
    let expect = &query.data["expect"];
    let (direction, reflectance) = if query.has_tolerance() {
        (query.tolerance("direction_abs"), query.tolerance("R_abs"))
    } else {
        (8.0 * query.u, 8.0 * query.u)
    };
    near_vector(
        "the mirror direction",
        DVec3::from_array(hit.reflected),
        vector(&expect["reflected_unit"]),
        8.0 * query.u,
    )?;
    let forced = query.decision("TIR_");
    if forced.is_some_and(|tir| tir != hit.tir) {
        return Err(format!("tir is {}", hit.tir));
    }
    if let (Some(refracted), true) = (hit.transmitted, expect["refracted_unit"].is_array()) {
        near_vector(
            "the refracted direction",
            DVec3::from_array(refracted),
            vector(&expect["refracted_unit"]),
            direction,
        )?;
    }
    if hit.transmitted.is_some() == hit.tir {
        return Err("a transmitted ray under total reflection, or none without".to_owned());
    }
    // Near the critical angle a format that cannot decide may answer from the other side, where R is almost 1 as well.
    let undecided = if forced.is_none() { 32.0 * query.u.sqrt() } else { 0.0 };
    near("R", hit.reflectance, number(&expect["R_unpolarised"]), reflectance + undecided)
}

fn fermat(query: &Query<'_>) -> Check {
    let input = &query.data["in"];
    let (a, d) = (vector(&input["A"]), vector(&input["d"]));
    let (n1, n2) = (number(&input["n1"]), number(&input["n2"]));
    let (objects, materials) = two_media(&input["n1"], &input["n2"]);
    let rays = tree(query, a, d, objects, materials, json!({}));
    let chain = transmitted(&rays)?;
    let expect = &query.data["expect"];
    let point = hit_of(chain[0])?;
    let steep = d.length() / d.y.abs();
    let size = a.distance(vector(&expect["interface_point"])) * steep;
    near_vector("the crossing", point, vector(&expect["interface_point"]), 16.0 * query.u * size)?;
    let (start, way) = (DVec3::from_array(chain[1].origin), DVec3::from_array(chain[1].direction));
    let receiver = start + way * ((number(&input["receiver_plane_y"]) - start.y) / way.y);
    let expected = vector(&expect["receiver_point"]);
    near_vector("the arrival", receiver, expected, 64.0 * query.u * (size + receiver.distance(point) / way.y.abs()))?;
    let length = n1 * a.distance(point) + n2 * point.distance(receiver);
    near("the optical path", length, number(&expect["optical_path_length"]), 64.0 * query.u * (n1 + n2) * size)
}

fn fisheye(query: &Query<'_>) -> Check {
    match query.precision {
        Precision::Single => fisheye_with::<f32>(query),
        Precision::Double => fisheye_with::<f64>(query),
    }
}

fn fisheye_with<L: Lanes<Simd = ()>>(query: &Query<'_>) -> Check {
    let input = &query.data["in"];
    // One pixel wide, so that the circle's radius is one half.
    let (x, y) = (0.5 + 0.5 * number(&input["ndc_x"]), 0.5 - 0.5 * number(&input["ndc_y"]));
    let narrow = |x: f64| L::Real::from_f64(x);
    // The circle's border passes between points that only double tells apart.
    let on_the_border =
        [&input["ndc_x"], &input["ndc_y"]].into_iter().map(number).map(|x| x * x).sum::<f64>() > 1.0 - 1e-6;
    if on_the_border && (narrow(x).to_f64() != x || narrow(y).to_f64() != y) {
        return Ok(());
    }
    for fov in ["fov180", "fov360"] {
        let degrees: f64 = fov[3..].parse().unwrap();
        for kind in ["fisheye", "omnimax"] {
            let camera: description::Camera = serde_json::from_value(
                json!({ kind: { "eye": [0, 0, 0], "look_at": [0, 0, -1], "fov_deg": degrees } }),
            )
            .unwrap();
            let basis = Basis::new(&camera.view()).unwrap();
            let camera = Camera::<L::Real>::new(&camera, &basis, 1, 1);
            let primary = camera.primary::<L>((), L::splat((), narrow(x)), L::splat((), narrow(y)));
            let inside = query.data["expect"]["inside_image_circle"] == true;
            if primary.seen.any() != inside {
                return Err(format!("{kind} {fov}: inside the circle: {}", primary.seen.any()));
            }
            if !inside {
                continue;
            }
            let d = DVec3::from_array(primary.dir.lane(0).map(Real::to_f64));
            let theta = degrees.to_radians() / 2.0;
            let expected = vector(&query.data["expect"]["unit_direction_right_up_forward"][fov]);
            near_vector(&format!("{kind} {fov}"), DVec3::new(d.x, d.y, -d.z), expected, 4.0 * query.u * (1.0 + theta))?;
            unit("the direction", query, d.to_array())?;
        }
    }
    Ok(())
}

fn corridor(query: &Query<'_>) -> Check {
    let (o, d) = (vector(&query.data["ray"]["o"]), vector(&query.data["ray"]["d"]));
    let mirrors = json!([
        { "plane": { "point": [0, 0, 0], "normal": [1, 0, 0], "material": "mirror" } },
        { "plane": { "point": [1, 0, 0], "normal": [-1, 0, 0], "material": "mirror" } }
    ]);
    let materials = json!({ "mirror": { "diffuse": 0, "reflection": 0.999 } });
    let rays = tree(query, o, d, mirrors, materials, json!({ "max_depth": 10_000, "min_weight": 0 }));
    if rays.len() != 10_000 {
        return Err(format!("{} rays", rays.len()));
    }
    let mut total = 0.0;
    let mut walk = rays.iter();
    let mut seen = 0;
    for expected in query.data["expect"]["hits"].as_array().unwrap() {
        let k = number(&expected["k"]);
        let mut last = None;
        while (seen as f64) < k {
            let node = walk.next().ok_or("the chain ends")?;
            total += node.hit.as_ref().ok_or(format!("ray {seen} leaves the corridor"))?.t;
            seen += 1;
            last = Some(node);
        }
        let Some(node) = last else { continue };
        let relative = 8.0 * k * query.u;
        near(&format!("way {k}"), total / number(&expected["dist_total"]), 1.0, relative)?;
        let (point, exact) = (hit_of(node)?, vector(&expected["hit_point"]));
        near(&format!("x of hit {k}"), point.x, exact.x, 4.0 * query.u)?;
        near_vector(&format!("hit {k}"), point, exact, relative * exact.length().max(1.0))?;
        let weight = number(&expected["weight_if_reflectance_0.999"]);
        near(&format!("weight {k}"), node.weight[0] * 0.999 / weight, 1.0, 2.0 * k * query.u)?;
    }
    Ok(())
}

fn phong(query: &Query<'_>) -> Check {
    match query.precision {
        Precision::Single => phong_with::<f32>(query),
        Precision::Double => phong_with::<f64>(query),
    }
}

/// Looking straight down onto a surface lit from straight above, along a vector whose length makes up the cosine.
fn phong_with<L: Lanes<Simd = ()>>(query: &Query<'_>) -> Check {
    let (cosine, exponent) = (number(&query.data["in"]["r_dot_v"]), number(&query.data["in"]["exponent"]));
    let narrow = |v: [f64; 3]| V3::<L>::splat((), v.map(L::Real::from_f64));
    let up = narrow([0.0, 1.0, 0.0]);
    let base = highlight_cosine((), up, up, narrow([0.0, cosine, 0.0]));
    let exponents = [L::Real::from_f64(exponent); MAX_LANES];
    let value = power((), base, &exponents, L::mask((), 1)).lane(0).to_f64();
    let expected = number(&query.data["expect"]["value"]);
    let relative = number(&query.data["tol"]["rel_f32"]) * query.u / (f64::from(f32::EPSILON) / 2.0);
    let smallest = if query.precision == Precision::Single { f64::from(f32::MIN_POSITIVE) } else { 0.0 };
    near("the power", value, expected, relative * expected + 2.0 * query.u * smallest)?;
    if (0.0..=1.0).contains(&value) { Ok(()) } else { Err(format!("{value} is beyond [0, 1]")) }
}

macro_rules! ask {
    ($($file:ident: $check:expr;)*) => {
        $(
            #[test]
            fn $file() {
                ask_all(stringify!($file), $check);
            }
        )*
    };
}

ask! {
    sphere_far: sphere;
    sphere_grazing: sphere;
    sphere_origin_on_surface: sphere;
    camera_far: sphere;
    plane_far: plane;
    plane_grazing: plane;
    disc_rim: disc;
    torus_quartic: torus;
    cylinder_parallel_axis: cylinder;
    aabb_slab_nan: cuboid;
    normalize_extreme: normalised;
    tri_degenerate: degenerate;
    tri_shared_edge: triangles;
    tri_vertex_fan: triangles;
    tri_tiny: triangles;
    instance_normals: instance;
    glass_sphere_deviation: glass_sphere;
    refract_slab: slab;
    refract_critical: critical;
    fermat_plane: fermat;
    fisheye_directions: fisheye;
    mirror_corridor: corridor;
    phong_exponent: phong;
}
