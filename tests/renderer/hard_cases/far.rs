//! F: far away, large, small, and placed by transforms.

use super::Case;
use super::evidence::Evidence;
use super::lab::{Lab, ask, ball, description, direction, from_front, hit, rows, square, truth, vector};
use super::solids::Mesh;
use crate::common::Random;
use crate::common::naive;
use glam::{DMat3, DQuat, DVec3};
use serde_json::{Value, json};
use strahl::film::srgb::code8;

pub const CASES: &[Case] = &[
    ("F01", moved),
    ("F02", scaled),
    ("F03", small_beside_large),
    ("F04", stretched),
    ("F05", mirrored),
    ("F06", singular),
    ("F07", nested),
    ("F08", baked),
];

/// Balls and a box on the ground, moved and scaled as a whole.
fn still_life(offset: DVec3, scale: f64) -> (Value, Value) {
    let at = |v: [f64; 3]| ((DVec3::from_array(v) + offset) * scale).to_array();
    let objects = json!([
        { "plane": { "point": at([0.0, -1.0, 0.0]), "normal": [0, 1, 0], "material": "matt" } },
        ball(at([0.0, 0.0, 0.0]), scale, "shiny"),
        ball(at([1.5, -0.5, 1.0]), 0.5 * scale, "glass"),
        { "box": { "min": at([-2.0, -1.0, 0.5]), "max": at([-1.25, 0.5, 1.5]), "material": "matt" } }
    ]);
    let more = json!({
        "image": square(48), "background": [0.3, 0.5, 0.8],
        "camera": { "pinhole": { "eye": at([0.0, 1.0, 6.0]), "look_at": at([0.0, 0.0, 0.0]) } },
        "materials": { "shiny": { "ambient": 0.1, "diffuse": 0.5, "reflection": 0.3 } },
        "lights": [{ "point": { "position": at([4.0, 6.0, 5.0]) } }]
    });
    (objects, more)
}

fn moved(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "camera_far", &[]);
    for row in rows("camera_far") {
        if let Some(t) = row["expect"]["t"].as_f64() {
            let (o, d) = (vector(&row["ray"]["o"]), vector(&row["ray"]["d"]));
            let (center, radius) = (vector(&row["shape"]["center"]), row["shape"]["radius"].as_f64().unwrap());
            let off = (naive::sphere_expanded(lab, o, d, center, radius) - t).abs() * d.length();
            e.twin(!(off <= row["tol"][lab.pick("dist_abs_f32", "dist_abs_f64")].as_f64().unwrap()));
        }
    }
    // The file's numbers have 24 bits, whose products are exact in double precision; so here is one further away.
    let away = DVec3::new(1.0, -0.5, 0.25) * lab.pick(2f64.powi(13), 2f64.powi(40));
    let (o, d) = (DVec3::Z * 8.0, DVec3::new(0.0625, 0.03125, -1.0));
    let [near, far] = [DVec3::ZERO, away].map(|at| {
        hit(&lab.scene(json!([ball(at.into(), 1.0, "red")]), json!({})), o + at, d).map_or(f64::NAN, |h| h.t)
    });
    e.check(near == far, || format!("t = {far} instead of {near}"));
    e.twin(!((naive::sphere_expanded(lab, o + away, d, away, 1.0) - near).abs() <= 16.0 * lab.u * 8.0));
    let film = |offset: DVec3| {
        let (objects, more) = still_life(offset, 1.0);
        lab.picture(objects, more).film.pixels
    };
    let here = film(DVec3::ZERO);
    let there = film(DVec3::new(1.0, -0.5, 0.25) * lab.pick(2f64.powi(13), 2f64.powi(40)));
    let differs = |a: &[f32; 3], b: &[f32; 3]| a.iter().zip(b).any(|(a, b)| code8(*a).abs_diff(code8(*b)) > 1);
    let count = here.iter().zip(&there).filter(|(a, b)| differs(a, b)).count();
    // Edges may fall on the other side of a pixel's centre.
    e.check(count <= here.len() / 50, || format!("{count} of {} pixels differ far away", here.len()));
    e
}

fn scaled(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pictures");
    let film = |scale: f64| {
        let (objects, more) = still_life(DVec3::ZERO, scale);
        lab.picture(objects, more).film.pixels
    };
    let expected = film(1.0);
    for power in [-20, -10, -3, 1, 7, 20] {
        let scale = 2f64.powi(power);
        e.check(film(scale) == expected, || format!("2^{power} gives another picture"));
        // From the middle of a ball to its wall, with an absolute epsilon.
        let t = naive::sphere(lab, DVec3::ZERO, DVec3::X, DVec3::ZERO, scale, 1e-4);
        e.twin(t.is_none());
    }
    e
}

fn small_beside_large(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays and pixels");
    let small = 1e-6;
    let large = json!({ "box": { "min": [-1e6, -1e6, -1e6], "max": [1e6, 0, 1e6], "material": "red" } });
    let objects = json!([large, ball([0.0, small, 0.0], small, "matt")]);
    let scene = lab.scene(objects.clone(), json!({}));
    let mut random = Random::new(50);
    for _ in 0..500 {
        let up = direction(&mut random);
        let o = lab.round3(DVec3::Y * small + up.with_y(up.y.abs()) * 5.0 * small);
        let d = lab.round3(DVec3::new(0.0, small, 0.0) - o);
        let found = hit(&scene, o, d);
        e.check(found.is_some_and(|h| h.object == "/objects/1" && (h.t - 0.8).abs() < 64.0 * lab.u), || {
            format!("from {o}")
        });
        // Epsilon as a millionth of the scene's size.
        e.twin(naive::sphere(lab, o, d, DVec3::Y * small, small, 1e-6 * 1e6 / d.length()).is_none());
    }
    let more = json!({
        "camera": { "orthographic": { "eye": [0, 9e-6, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "height": 4e-6 } },
        "image": square(24), "lights": [{ "directional": { "direction": [0.1, -1, 0.05] } }]
    });
    let film = lab.picture(objects, more).film.pixels;
    let lit = film.iter().filter(|p| p[0] > 0.0 && p[1] > 0.0).count();
    e.check((90..130).contains(&lit), || format!("{lit} pixels show the small ball"));
    e
}

/// The matrix of a row and its unit normal.
fn row_matrix(row: &Value) -> (DMat3, DVec3, DVec3) {
    let rows: [DVec3; 3] = std::array::from_fn(|i| vector(&row["shape"]["matrix3x3_rows"][i]));
    let matrix = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
    let local = matrix.inverse() * (vector(&row["expect"]["point"]) - vector(&row["shape"]["translation"]));
    (matrix, local, vector(&row["expect"]["normal_outward"]))
}

fn stretched(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "instance_normals", &[]);
    for row in rows("instance_normals") {
        let (matrix, local, normal) = row_matrix(&row);
        e.twin((matrix * local).normalize().dot(normal) < 0.99);
    }
    e
}

fn mirrored(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "instance_normals", &[]);
    for row in rows("instance_normals") {
        let (matrix, local, normal) = row_matrix(&row);
        if matrix.determinant() < 0.0 {
            // The normal as the cross product of two tangents that were moved along.
            let (a, b) = local.normalize().any_orthonormal_pair();
            e.twin((matrix * a).cross(matrix * b).dot(normal) * a.cross(b).dot(local) < 0.0);
        }
    }
    // A mirrored body of glass is entered from outside.
    let objects =
        json!([{ "group": { "objects": [ball([0.0; 3], 1.0, "glass")], "transform": { "scale": [-1, 2, 1] } } }]);
    let tree = lab.tree(DVec3::new(0.3, 0.4, 4.0), -DVec3::Z, objects, json!({}));
    let media: Vec<usize> = tree.rays.iter().map(|r| r.media.len()).collect();
    e.check(media == [0, 1, 0], || format!("media {media:?}"));
    e
}

fn singular(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("transforms");
    let placed = |transform: Value| {
        description(
            json!([{ "group": { "objects": [ball([0.0; 3], 1.0, "red")], "transform": transform } }]),
            json!({}),
        )
    };
    let flat = |z: f64| json!({ "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 1, 1, z, 0, 0, 0, 0, 1] });
    for transform in
        [json!({ "scale": 0 }), json!({ "scale": [1, 0, 1] }), flat(0.0), flat(1e-14), json!({ "matrix": vec![0; 16] })]
    {
        let refused = lab.load(&placed(transform.clone())).err();
        let named = refused.is_some_and(|p| p.0.iter().any(|p| p.pointer.starts_with("/objects/0/group/transform")));
        e.check(named, || format!("{transform} is taken"));
    }
    for transform in [flat(1e-3), json!({ "scale": [1e-6, 1, 1e6] }), json!({ "scale": 1e-9 })] {
        let scene = lab.load(&placed(transform.clone())).unwrap_or_else(|p| panic!("{p}")).scene;
        let found = hit(&scene, DVec3::Z * 0.5e-12, DVec3::new(0.1, 0.2, 1.0));
        e.check(found.is_some_and(|h| super::lab::finite(&h)), || format!("{transform}"));
    }
    // Taken as it is: the ray goes through the adjugate over the determinant.
    for matrix in [
        DMat3::ZERO,
        DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0)),
        DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0]),
    ] {
        let over = lab.round(1.0 / matrix.determinant());
        let (x, y, z) = (matrix.x_axis, matrix.y_axis, matrix.z_axis);
        let rows = [y.cross(z), z.cross(x), x.cross(y)].map(|row| lab.round3(row * over));
        let [o, d] = [DVec3::new(0.25, 0.125, 4.0), -DVec3::Z].map(|v| DVec3::from_array(rows.map(|r| r.dot(v))));
        e.twin(naive::sphere_roots(lab, o, d, DVec3::ZERO, 1.0)[0].is_nan());
    }
    e
}

fn nested(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pixels of nested mirrors");
    let step = DVec3::new(1000.0, -300.0, 200.0) * lab.pick(1.0, 2f64.powi(24));
    for scale in [0.5, 2.0] {
        let mut object = ball([0.0; 3], 1.0, "mirror");
        let mut middle = DVec3::ZERO;
        let mut size = 1.0;
        for _ in 0..10 {
            object = json!({ "group": { "objects": [object], "transform": { "translate": step.to_array(), "scale": scale } } });
            middle = middle * scale + step;
            size *= scale;
        }
        let more = json!({
            "camera": from_front(middle.to_array(), 4.0 * size, 1.8 * size), "image": square(32), "background": 1,
            "render": { "max_depth": 2 }
        });
        for pixel in lab.picture(json!([object]), more).film.pixels {
            e.check(pixel == [1.0; 3], || format!("scale {scale}: {pixel:?}"));
        }
        // An offset in the ball's own space, carried outside.
        let p = lab.round3(middle + DVec3::Z * size);
        e.twin(naive::add(lab, p, DVec3::Z * lab.pick(1e-4, 1e-7) * size) == p);
    }
    e
}

fn baked(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("rays at vertices and edges");
    let mesh = Mesh::icosphere(2).placed(lab, 1.0, DVec3::ZERO);
    let (scale, axis, offset) =
        (DVec3::new(2.0, 0.5, 1.25), DVec3::new(1.0, 1.0, -1.0).normalize(), DVec3::new(40.0, -7.0, 3.0));
    let turn = DQuat::from_axis_angle(axis, 40f64.to_radians());
    let place = |v: DVec3| turn * (v * scale) + offset;
    let ready =
        Mesh { vertices: mesh.vertices.iter().map(|v| lab.round3(place(*v))).collect(), faces: mesh.faces.clone() };
    let transform = json!({ "scale": scale.to_array(), "rotate_deg": { "axis": axis.to_array(), "angle": 40 }, "translate": offset.to_array() });
    let instance =
        lab.scene(json!([{ "group": { "objects": [mesh.json("red")], "transform": transform } }]), json!({}));
    let plain = lab.scene(json!([ready.json("red")]), json!({}));
    let o = lab.round3(place(DVec3::new(0.2, -0.1, 0.3)));
    for aim in ready.vertices.iter().copied().chain(ready.edges(lab)) {
        let d = lab.round3(aim - o);
        let [a, b] = [&instance, &plain].map(|s| hit(s, o, d).map(|h| h.t));
        let close = a.zip(b).is_some_and(|(a, b)| (a - b).abs() <= 1024.0 * lab.u * offset.length());
        e.check(close, || format!("{a:?} and {b:?} along {d}"));
        let mut ahead = ready.triangles().filter(|t| (t[0] - o).dot(d) > 0.0);
        e.twin(!ahead.any(|t| naive::triangle(lab, o, d, t, 0.0).is_some()));
    }
    e
}
