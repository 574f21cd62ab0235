//! The shadow terminator: where light grazes a mesh with interpolated normals, its facets must not show in the shadow
//! line, and no light may leak, neither on such meshes nor on flat ones.

use crate::common::meshes::Closed;
use glam::DVec3;
use serde_json::{Value, json};
use strahl::film::{Film, Region};
use strahl::math::hypot;
use strahl::render::{Control, render};
use strahl::scene::{Format, Overrides, load};

const EDGE: u32 = 96;
const TO_LIGHT: DVec3 = DVec3::new(1.0, 0.3, 0.2);

/// A picture, 2 units high, of what is seen along -z.
fn picture(objects: &Value, lights: &Value, precision: &str) -> Film {
    let scene = json!({
        "version": 1,
        "image": { "width": EDGE, "height": EDGE },
        "camera": { "orthographic": { "eye": [0, 0, 4], "look_at": [0, 0, 0], "height": 2 } },
        "ambient": 0,
        "lights": lights,
        "materials": { "matt": { "ambient": 0, "diffuse": 1 } },
        "objects": objects,
        "render": { "antialias": false, "precision": precision }
    });
    let scene = load(scene.to_string().as_bytes(), Format::Json, &Overrides::default()).unwrap().scene;
    render(&scene, Region::whole(EDGE, EDGE), &Control::default()).unwrap().film
}

fn sun() -> Value {
    json!([{ "directional": { "direction": (-TO_LIGHT).to_array() } }])
}

fn smooth(mesh: &Closed) -> Value {
    let mut object = mesh.json("matt");
    object["mesh"]["normals"] = mesh.vertices.iter().map(|v| v.normalize().to_array()).collect();
    object
}

/// x and y of the middle of a pixel.
fn place(index: usize) -> (f64, f64) {
    let at = |k: usize| (k as f64 + 0.5) / f64::from(EDGE) * 2.0 - 1.0;
    (at(index % EDGE as usize), -at(index / EDGE as usize))
}

#[test]
fn a_coarse_smooth_sphere_is_lit_like_a_sphere() {
    for precision in ["single", "double"] {
        for levels in [1, 2, 3] {
            let film = picture(&json!([smooth(&Closed::icosphere(levels))]), &sun(), precision);
            for (index, pixel) in film.pixels.iter().enumerate() {
                let (x, y) = place(index);
                if hypot(x, y) > 0.85 {
                    continue;
                }
                let normal = DVec3::new(x, y, (1.0 - x * x - y * y).sqrt());
                let cosine = normal.dot(TO_LIGHT.normalize()).max(0.0);
                // Interpolated normals of 80 facets are those of the sphere but for a few degrees.
                let off = (f64::from(pixel[0]) - cosine).abs();
                assert!(off < 0.1, "{precision}, level {levels}: {} instead of {cosine} at ({x:.2}, {y:.2})", pixel[0]);
            }
        }
    }
}

#[test]
fn brightness_falls_monotonically_into_the_shadow() {
    let film = picture(&json!([smooth(&Closed::icosphere(1))]), &sun(), "single");
    let (middle, radius) = (EDGE as usize / 2, EDGE as usize * 2 / 5);
    for row in [middle - 12, middle, middle + 12] {
        let line: Vec<f32> = (middle - radius..middle + 16).map(|x| film.pixels[row * EDGE as usize + x][0]).collect();
        assert!(line[0] == 0.0 && line[line.len() - 1] > 0.1, "no terminator on this line: {line:?}");
        // Brightness interpolated from normals may waver a little where facets meet, but never jumps.
        for pair in line.windows(2) {
            assert!(pair[1] - pair[0] > -0.02 && pair[1] - pair[0] < 0.12, "row {row}: {line:?}");
        }
    }
}

#[test]
fn flat_facets_with_normals_are_flat_facets() {
    let cube = Closed::cube().placed(0.6, DVec3::ZERO);
    let turn = glam::DQuat::from_rotation_y(0.5) * glam::DQuat::from_rotation_x(0.3);
    let corners: Vec<DVec3> = cube.faces.iter().flatten().map(|&i| turn * cube.vertices[i]).collect();
    let faces: Vec<[usize; 3]> = (0..cube.faces.len()).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let normals: Vec<[f64; 3]> =
        corners.chunks(3).flat_map(|t| [((t[1] - t[0]).cross(t[2] - t[0])).normalize().to_array(); 3]).collect();
    let flat = Closed { vertices: corners, faces }.json("matt");
    let mut with_normals = flat.clone();
    with_normals["mesh"]["normals"] = json!(normals);
    let neighbour = json!({ "sphere": { "center": [0.75, 0.3, 0.4], "radius": 0.15, "material": "matt" } });
    for light in [sun(), json!([{ "directional": { "direction": [-1, 0.05, 0.3] } }])] {
        let [flat, with_normals] =
            [&flat, &with_normals].map(|cube| picture(&json!([cube, neighbour]), &light, "double"));
        for (a, b) in flat.pixels.iter().zip(&with_normals.pixels) {
            assert!((a[0] - b[0]).abs() < 1e-6, "{a:?} and {b:?}");
        }
    }
}

#[test]
fn a_smooth_room_lets_no_light_in() {
    // Seen from inside, normals turned inwards: the walls are hollow, and no shadow ray may start behind them.
    for scale in [1.5, -1.5] {
        let room = Closed::icosphere(1);
        let mut object = smooth(&room);
        object["mesh"]["vertices"] =
            room.vertices.iter().map(|v| (*v * f64::abs(scale) + DVec3::Z * 4.0).to_array()).collect();
        if scale < 0.0 {
            object["mesh"]["normals"] = room.vertices.iter().map(|v| (-*v).to_array()).collect();
        }
        let lights: Vec<Value> = room
            .vertices
            .iter()
            .flat_map(|v| {
                let outside = *v * 3.0 + DVec3::Z * 4.0;
                [
                    json!({ "directional": { "direction": v.to_array() } }),
                    json!({ "point": { "position": outside.to_array() } }),
                ]
            })
            .collect();
        for precision in ["single", "double"] {
            let film = picture(&json!([object]), &json!(lights), precision);
            let lit = film.pixels.iter().filter(|p| **p != [0.0; 3]).count();
            assert_eq!(lit, 0, "{lit} pixels of the room are lit from outside in {precision}");
        }
    }
}

#[test]
fn what_stands_before_a_smooth_sphere_still_shadows_it() {
    let ball = smooth(&Closed::icosphere(1).placed(0.8, DVec3::ZERO));
    let screen = json!({ "disc": { "center": (TO_LIGHT * 0.9).to_array(), "normal": TO_LIGHT.to_array(), "radius": 0.9, "material": "matt" } });
    let film = picture(&json!([ball, screen]), &sun(), "single");
    let lit = film.pixels.iter().enumerate().filter(|(index, pixel)| {
        let (x, y) = place(*index);
        hypot(x, y) < 0.7 && x < 0.5 && pixel[0] > 0.0
    });
    assert_eq!(lit.count(), 0);
}
