//! T, meshes: rays aimed at edges and vertices of closed meshes, and meshes as bodies.

use super::Case;
use super::evidence::Evidence;
use super::lab::{Lab, ask, from_front, hit, square, truth};
use super::solids::{Mesh, cube_mesh};
use crate::common::Random;
use crate::common::naive;
use glam::DVec3;
use serde_json::json;
use strahl::math::hypot;

pub const CASES: &[Case] = &[
    ("T01", edges),
    ("T02", vertices),
    ("T03", far_vertices),
    ("T04", diagonals),
    ("T06", contraction),
    ("T12", double_count),
    ("T13", silhouette),
    ("T16", shared),
    ("T17", terminator),
];

/// The scales and places of closed meshes.
const PLACES: [(f64, [f64; 3]); 4] =
    [(1.0, [0.0; 3]), (1e-6, [0.0; 3]), (1e6, [0.0; 3]), (2.0, [148_376.0, 1234.0, -223_423.0])];

/// Rays from inside at points of the surface; `sieve` is the naive test of one triangle.
fn leaks(
    lab: &Lab,
    e: &mut Evidence,
    (scale, offset): (f64, [f64; 3]),
    aims: fn(&Mesh, &Lab) -> Vec<DVec3>,
    sieve: impl Fn(DVec3, DVec3, [DVec3; 3]) -> bool,
) {
    let offset = DVec3::from_array(offset);
    let mesh = Mesh::icosphere(3).placed(lab, scale, offset);
    let scene = lab.scene(json!([mesh.json("red")]), json!({}));
    let mut random = Random::new(6);
    for _ in 0..4 {
        let o = lab.round3(offset + DVec3::from_array(random.point(0.4)) * scale);
        for (i, aim) in aims(&mesh, lab).into_iter().enumerate() {
            let d = lab.round3(aim - o);
            e.check(hit(&scene, o, d).is_some(), || format!("scale {scale}: from {o} along {d}"));
            if i % 4 == 0 {
                // A line meets the mesh behind the origin, too.
                let mut ahead = mesh.triangles().filter(|t| (t[0] - o).dot(d) > 0.0);
                e.twin(!ahead.any(|corners| sieve(o, d, corners)));
            }
        }
    }
}

fn corners(mesh: &Mesh, _: &Lab) -> Vec<DVec3> {
    mesh.vertices.clone()
}

fn edges(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "tri_shared_edge", &[]);
    for place in PLACES {
        leaks(lab, &mut e, place, Mesh::edges, |o, d, c| naive::triangle(lab, o, d, c, 0.0).is_some());
    }
    e
}

fn vertices(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "tri_vertex_fan", &[]);
    for place in PLACES {
        leaks(lab, &mut e, place, corners, |o, d, c| naive::triangle(lab, o, d, c, 0.0).is_some());
    }
    e
}

fn far_vertices(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays at vertices");
    // The small one has so few digits there that even naive products are exact.
    for scale in [2.0, 200.0, 20_000.0] {
        let place = (scale, PLACES[3].1);
        leaks(lab, &mut e, place, corners, |o, d, c| naive::triangle(lab, o, d, c, 0.0).is_some());
    }
    e
}

fn diagonals(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays along diagonals");
    for scale in [1.0, 0.1, 1e5] {
        let cube = cube_mesh().placed(lab, scale, DVec3::ZERO);
        let scene = lab.scene(json!([cube.json("red")]), json!({}));
        let mut random = Random::new(7);
        for corner in &cube.vertices {
            for i in 0..50 {
                // Through the corner itself, and through edges and faces on the way.
                let d = corner.signum();
                let aside = if i == 0 { DVec3::ZERO } else { DVec3::from_array(random.point(0.9)) * scale };
                let o = lab.round3(aside);
                e.check(hit(&scene, o, d).is_some(), || format!("from {o} along {d}"));
                // A shear chosen anew for each triangle, here along its normal.
                let inside = |t: [DVec3; 3]| {
                    let axis = (t[1] - t[0]).cross(t[2] - t[0]).abs().max_position();
                    naive::woop_along(lab, o, d, t, true, axis)
                };
                e.twin(!cube.triangles().any(inside));
            }
        }
    }
    // From inside a ball of triangles along diagonals that meet vertices and the middles of edges to within a rounding.
    for (scale, offset) in PLACES {
        let offset = DVec3::from_array(offset);
        let mesh = Mesh::icosphere(3).placed(lab, scale, offset);
        let scene = lab.scene(json!([mesh.json("red")]), json!({}));
        let mut random = Random::new(70);
        for (i, aim) in mesh.vertices.iter().copied().chain(mesh.edges(lab)).enumerate() {
            // All three axes are as long, or two of them.
            let mut d = (aim - offset).signum();
            if i % 4 > 0 {
                d[i % 3] *= lab.round(random.between(0.1, 0.9));
            }
            let o = lab.round3(aim - d * 0.4 * scale);
            e.check(hit(&scene, o, d).is_some(), || format!("scale {scale}: from {o} along {d}"));
            // One of them for each triangle, as lanes do that are not told the same.
            let mut ahead = mesh.triangles().enumerate().filter(|(_, t)| (t[0] - o).dot(d) > 0.0);
            e.twin(!ahead.any(|(k, t)| naive::woop_along(lab, o, d, t, false, (i + 1 + k % 2) % 3)));
        }
    }
    e
}

fn contraction(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays at edges");
    for place in PLACES {
        leaks(lab, &mut e, place, Mesh::edges, |o, d, c| naive::woop(lab, o, d, c, true));
    }
    e
}

fn double_count(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pixels and crossings");
    let cube = cube_mesh();
    // Pixel centres lie on the diagonals of the faces.
    let more = json!({ "camera": from_front([0.0; 3], 4.0, 3.0), "image": square(32), "background": [0.2, 0.4, 0.8] });
    let picture = lab.picture(json!([cube.json("nothing")]), more);
    for pixel in &picture.film.pixels {
        e.check(*pixel == [0.2, 0.4, 0.8], || format!("a pixel of invisible glass is {pixel:?}"));
    }
    let rays = picture.rays;
    e.check(rays.transmitted == 2 * rays.camera_hits, || format!("{rays:?}"));
    for x in [-0.5, 0.0, 0.25, 0.75] {
        let (o, d) = (DVec3::new(x, x, 4.0), -DVec3::Z);
        let tree = lab.tree(o, d, json!([cube.json("glass")]), json!({}));
        let media: Vec<usize> = tree.rays.iter().map(|r| r.media.len()).collect();
        e.check(media == [0, 1, 0], || format!("media on the diagonal: {media:?}"));
        let crossed = cube.triangles().filter(|t| naive::triangle(lab, o, d, *t, 0.0).is_some()).count();
        e.twin(crossed != 2);
    }
    e
}

fn silhouette(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays past silhouettes");
    let mesh = Mesh::icosphere(1).placed(lab, 1.0, DVec3::ZERO);
    let scene = lab.scene(json!([mesh.json("red")]), json!({}));
    let mut random = Random::new(8);
    for _ in 0..60 {
        let o = lab.round3(super::lab::direction(&mut random) * 4.0);
        for aim in mesh.vertices.iter().copied().chain(mesh.edges(lab)) {
            let d = lab.round3(aim - o);
            // In through one face and out through another, or not at all: never in only.
            let mut sides = Vec::new();
            let mut after = 0.0;
            while let Some(found) = super::lab::hit_within(&scene, o, d, after, None) {
                sides.push(found.entering);
                after = found.t;
            }
            let pairs = sides.iter().filter(|s| **s).count() * 2 == sides.len() || sides.len() > 2;
            // At a vertex both sides of the outline may be met at one t, of which the first written answers.
            let touching = sides.len() == 1 && is_touching(&mesh, o, d);
            e.check(pairs || touching, || format!("{sides:?} from {o} along {d}"));
            let crossed = mesh.triangles().filter(|t| naive::triangle(lab, o, d, *t, 0.0).is_some()).count();
            e.twin(crossed % 2 == 1);
        }
    }
    e
}

/// Whether the aim lies on the outline: faces around it are seen from both sides.
fn is_touching(mesh: &Mesh, o: DVec3, d: DVec3) -> bool {
    let aim = o + d;
    let around = mesh.triangles().filter(|t| {
        let n = (t[1] - t[0]).cross(t[2] - t[0]).normalize();
        n.dot(aim - t[0]).abs() < 1e-6 && t.iter().any(|v| v.distance(aim) < 1.0)
    });
    let sides: Vec<bool> = around.map(|t| (t[1] - t[0]).cross(t[2] - t[0]).dot(d) < 0.0).collect();
    sides.contains(&true) && sides.contains(&false)
}

fn shared(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays at vertices and edges");
    let mesh = Mesh::icosphere(2).placed(lab, 1.0, DVec3::ZERO);
    let apart = Mesh {
        vertices: mesh.triangles().flatten().collect(),
        faces: (0..mesh.faces.len()).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    };
    let transform = json!({ "translate": [3.3, -1.7, 0.9], "rotate_deg": { "axis": [1, 2, 3], "angle": 33 }, "scale": [1.1, 0.7, 1.9] });
    let scenes = [&mesh, &apart].map(|m| {
        let placed = json!([{ "group": { "objects": [m.json("red")], "transform": transform } }]);
        lab.scene(placed, json!({}))
    });
    let o = lab.round3(DVec3::new(3.3, -1.7, 0.9));
    let turn = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 33f64.to_radians());
    for aim in mesh.vertices.iter().copied().chain(mesh.edges(lab)) {
        let d = lab.round3(turn * (aim * DVec3::new(1.1, 0.7, 1.9)));
        let [a, b] = scenes.each_ref().map(|scene| hit(scene, o, d).map(|h| h.t));
        e.check(a.is_some() && a == b, || format!("{a:?} and {b:?} along {d}"));
    }
    // Copies of the vertices that were rounded on different ways: a few units in the last place apart.
    let o = DVec3::new(0.25, 0.125, -0.375);
    for aim in mesh.edges(lab) {
        let apart = |(i, t): (usize, [DVec3; 3])| t.map(|v| lab.round3(v * (1.0 - 4.0 * lab.u * (i % 3) as f64)));
        let mut copies = mesh.triangles().enumerate().map(apart);
        let d = lab.round3(aim - o);
        e.twin(!copies.any(|t| (t[0] - o).dot(d) > 0.0 && naive::woop(lab, o, d, t, false)));
    }
    e
}

fn terminator(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pixels the smooth normal turns to the light");
    let coarse = Mesh::icosphere(1);
    let mut object = coarse.json("matt");
    object["mesh"]["normals"] = object["mesh"]["vertices"].clone();
    let more = json!({
        "camera": from_front([0.0; 3], 4.0, 2.0), "image": square(96),
        "lights": [{ "directional": { "direction": [-1, -0.3, -0.2] } }]
    });
    let film = lab.picture(json!([object]), more).film;
    let light = DVec3::new(1.0, 0.3, 0.2).normalize();
    for (i, pixel) in film.pixels.iter().enumerate() {
        let at = |k: usize| (k as f64 + 0.5) / 48.0 - 1.0;
        let (x, y) = (at(i % 96), -at(i / 96));
        // The interpolated normals are nearly those of the sphere.
        if hypot(x, y) < 0.85 && DVec3::new(x, y, (1.0 - x * x - y * y).sqrt()).dot(light) > 0.1 {
            e.check(pixel[0] > 0.0, || {
                format!("a facet is dark at ({x:.2}, {y:.2}), where its normals face the light")
            });
        }
    }
    // Shadow rays from the flat facets, where the normals between the corners face the light.
    let facets: Vec<[DVec3; 3]> = coarse.placed(lab, 1.0, DVec3::ZERO).triangles().collect();
    for k in 0..96 * 96 {
        let at = |k: i32| (f64::from(k) + 0.5) / 48.0 - 1.0;
        let o = DVec3::new(at(k % 96), at(k / 96), 4.0);
        let front = |t: &&[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).z > 0.0;
        let met = facets.iter().filter(front).find_map(|t| naive::triangle(lab, o, -DVec3::Z, *t, 0.0).map(|h| (t, h)));
        let Some((corners, [t, u, v])) = met else { continue };
        let normal = (corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v).normalize();
        if normal.z > 0.5 && normal.dot(light) > 0.1 {
            let p = naive::point(lab, o, -DVec3::Z, t);
            let mut hits = facets.iter().filter_map(|t| naive::triangle(lab, p, lab.round3(light), *t, 0.0));
            e.twin(hits.any(|[t, ..]| t > 1e-4));
        }
    }
    e
}
