//! Light at interfaces: Snell, Fresnel and Fermat.

use super::*;
use strahl::inspect::query::answer;
use strahl::inspect::tree::{Node, NodeKind, trace_pixel};

/// The rays of the only pixel of an orthographic picture, which starts at `eye` along `direction`.
pub fn tree(
    query: &Query<'_>,
    eye: DVec3,
    direction: DVec3,
    objects: Value,
    materials: Value,
    render: Value,
) -> Vec<Node> {
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

pub fn hit_of(node: &Node) -> Result<DVec3, String> {
    node.hit.as_ref().map(|hit| DVec3::from_array(hit.point)).ok_or_else(|| format!("ray {} hits nothing", node.id))
}

pub fn glass_sphere(query: &Query<'_>) -> Check {
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

pub fn slab(query: &Query<'_>) -> Check {
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

pub fn critical(query: &Query<'_>) -> Check {
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

pub fn fermat(query: &Query<'_>) -> Check {
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
