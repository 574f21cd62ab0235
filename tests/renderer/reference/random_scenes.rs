//! Random scenes with coordinates over 16 orders of magnitude: no NaN, no infinity, no panic, no endless ray.

use crate::common::{Random, on_own_threads};
use rayon::prelude::*;
use serde_json::{Value, json};
use std::sync::atomic::{AtomicU64, Ordering};
use strahl::film::Region;
use strahl::render::{Control, render};
use strahl::scene::limits::RAYS_PER_SAMPLE;
use strahl::scene::{Format, Overrides, load};

const WIDTH: u32 = 6;
const HEIGHT: u32 = 4;

/// A number of either sign whose magnitude is 10^U(-8, 8); now and then 0.
fn wild(random: &mut Random) -> f64 {
    if random.below(20) == 0 {
        return [0.0, -0.0][random.below(2)];
    }
    length(random) * [1.0, -1.0][random.below(2)]
}

fn length(random: &mut Random) -> f64 {
    strahl::math::pow(10.0, random.between(-8.0, 8.0))
}

fn point(random: &mut Random) -> [f64; 3] {
    // Some share their magnitude, so that bodies meet.
    if random.below(2) == 0 {
        let size = length(random);
        return random.point(1.0).map(|x| x * size);
    }
    std::array::from_fn(|_| wild(random))
}

fn color(random: &mut Random) -> [f64; 3] {
    std::array::from_fn(|_| random.between(0.0, 1.0))
}

fn material(random: &mut Random) -> Value {
    let plain = json!(color(random));
    let tiles = json!({ "checker": { "a": color(random), "b": color(random), "size": length(random), "axes": "xyz" } });
    json!({
        "diffuse": if random.below(2) == 0 { plain } else { tiles },
        "specular": random.between(0.0, 1.0),
        "shininess": strahl::math::pow(10.0, random.between(-2.0, 6.0)),
        "reflection": if random.below(2) == 0 { 0.0 } else { random.between(0.0, 1.0) },
        "transmission": if random.below(2) == 0 { 0.0 } else { random.between(0.0, 1.0) },
        "ior": strahl::math::pow(10.0, random.between(-1.0, 1.0)),
        "one_sided": random.below(5) == 0
    })
}

fn object(random: &mut Random, level: u32) -> Value {
    let (p, q, size, name) = (point(random), point(random), length(random), ["a", "b", "c"][random.below(3)]);
    let (minor, hollow) = (size * random.between(1e-3, 0.999), random.below(5) == 0);
    let mut value = match random.below(if level == 0 { 13 } else { 11 }) {
        0 => json!({ "sphere": { "center": p, "radius": size, "hollow": hollow } }),
        1 => json!({ "plane": { "point": p, "normal": q } }),
        2 => json!({ "disc": { "center": p, "normal": q, "radius": size } }),
        3 => json!({ "triangle": { "vertices": [p, q, point(random)] } }),
        4 => json!({ "quad": { "vertices": [p, q, point(random), point(random)] } }),
        5 => {
            let max: [f64; 3] = std::array::from_fn(|i| if random.below(6) == 0 { p[i] } else { p[i].max(q[i]) });
            json!({ "box": { "min": std::array::from_fn::<f64, 3, _>(|i| p[i].min(max[i])), "max": max, "hollow": hollow } })
        }
        6 => json!({ "cylinder": { "base": p, "top": q, "radius": size, "capped": random.below(2) == 0 } }),
        7 => {
            let top = if random.below(2) == 0 { 0.0 } else { minor };
            json!({ "cone": { "base": p, "top": q, "base_radius": size, "top_radius": top, "capped": random.below(2) == 0 } })
        }
        8 => json!({ "torus": { "center": p, "axis": q, "major_radius": size, "minor_radius": minor } }),
        9 | 10 => {
            let points: Vec<_> = (0..5).map(|_| point(random)).collect();
            let faces: Vec<[usize; 3]> = (0..6).map(|_| std::array::from_fn(|_| random.below(5))).collect();
            let normals: Vec<_> = points.iter().map(|_| random.point(1.0)).collect();
            let smooth = random.below(2) == 0;
            let mut mesh = json!({ "mesh": { "vertices": points, "faces": faces } });
            if smooth {
                mesh["mesh"]["normals"] = json!(normals);
            }
            mesh
        }
        11 => {
            let scale: [f64; 3] = std::array::from_fn(|_| strahl::math::pow(10.0, random.between(-3.0, 3.0)));
            let transform =
                json!({ "translate": p, "rotate_deg": { "axis": q, "angle": wild(random) }, "scale": scale });
            return json!({ "group": { "transform": transform, "objects": [object(random, 1), object(random, 1)] } });
        }
        _ => return json!({ "instance": { "of": "thing", "transform": { "translate": p, "scale": wild(random) } } }),
    };
    for body in value.as_object_mut().unwrap().values_mut() {
        body["material"] = json!(name);
    }
    value
}

fn camera(random: &mut Random) -> Value {
    let (eye, look_at, up) = (point(random), point(random), point(random));
    let angle = |random: &mut Random, most: f64| strahl::math::pow(10.0, random.between(-6.0, 0.0)) * most;
    let kind = ["pinhole", "orthographic", "fisheye", "omnimax", "panorama", "cylinder"][random.below(6)];
    let mut view = json!({ "eye": eye, "look_at": look_at, "up": up });
    match kind {
        "pinhole" => view["vfov_deg"] = json!(angle(random, 179.999)),
        "orthographic" => view["height"] = json!(length(random)),
        "fisheye" | "omnimax" => view["fov_deg"] = json!(angle(random, 360.0)),
        "panorama" => view["hfov_deg"] = json!(angle(random, 360.0)),
        _ => view["vfov_deg"] = json!(angle(random, 179.999)),
    }
    json!({ kind: view })
}

fn light(random: &mut Random) -> Value {
    let (p, d) = (point(random), point(random));
    let falloff = [json!("none"), json!("inverse_square"), json!({ "linear": { "reach": length(random) } })];
    let falloff = falloff[random.below(3)].clone();
    let intensity = length(random);
    match random.below(3) {
        0 => json!({ "point": { "position": p, "intensity": intensity, "falloff": falloff } }),
        1 => json!({ "directional": { "direction": d, "intensity": intensity } }),
        _ => {
            json!({ "spot": { "position": p, "direction": d, "inner_deg": 10, "outer_deg": 60, "intensity": intensity, "falloff": falloff } })
        }
    }
}

fn scene(seed: u64) -> Value {
    let mut random = Random::new(seed);
    let random = &mut random;
    let count = 1 + random.below(8);
    json!({
        "version": 1,
        "image": { "width": WIDTH, "height": HEIGHT },
        "camera": camera(random),
        "background": color(random),
        "lights": (0..random.below(4)).map(|_| light(random)).collect::<Vec<_>>(),
        "materials": { "a": material(random), "b": material(random), "c": material(random) },
        "definitions": { "thing": [object(random, 1)] },
        "objects": (0..count).map(|_| object(random, 0)).collect::<Vec<_>>(),
        "render": {
            "filter_checkers": false,
            "max_depth": 1 + random.below(7), "antialias": false,
            "precision": (["single", "double"][random.below(2)]),
            "shadows": (["opaque", "transmissive", "none"][random.below(3)])
        }
    })
}

/// Renders at least `count` scenes, always the same ones, and says what went wrong with which.
fn render_scenes(count: u64) {
    let (accepted, lit) = (AtomicU64::new(0), AtomicU64::new(0));
    let wrong_with = |seed| {
        let text = scene(seed).to_string();
        let outcome = std::panic::catch_unwind(|| {
            // Some are refused: triangles without area, views along the up direction, singular transforms.
            let loaded = load(text.as_bytes(), Format::Json, &Overrides::default()).ok()?;
            accepted.fetch_add(1, Ordering::Relaxed);
            let picture = render(&loaded.scene, Region::whole(WIDTH, HEIGHT), &Control::default()).unwrap();
            lit.fetch_add(u64::from(picture.rays.camera_hits > 0), Ordering::Relaxed);
            let bad = picture.film.pixels.iter().flatten().filter(|c| !c.is_finite() || **c < 0.0).count();
            let rays = picture.rays;
            let followed = rays.camera + rays.reflected + rays.transmitted;
            let most = u64::from(WIDTH * HEIGHT) * RAYS_PER_SAMPLE.max;
            (bad > 0 || rays.dropped > 0 || followed > most).then(|| format!("{bad} channels, {rays:?}"))
        });
        match outcome {
            Ok(None) => None,
            Ok(Some(why)) => Some(format!("seed {seed}: {why}")),
            Err(_) => Some(format!("seed {seed}: a panic")),
        }
    };
    let wrong: Vec<String> = on_own_threads(|| (0..count * 2).into_par_iter().filter_map(wrong_with).collect());
    let (accepted, lit) = (accepted.into_inner(), lit.into_inner());
    println!("{accepted} random scenes rendered, in {lit} of them something is seen");
    assert!(
        accepted >= count && lit * 4 > accepted,
        "too few scenes: {accepted} accepted, {lit} with anything in view"
    );
    assert!(wrong.is_empty(), "{} scenes:\n{}", wrong.len(), wrong[..wrong.len().min(20)].join("\n"));
}

#[test]
fn ten_thousand_random_scenes() {
    render_scenes(10_000);
}

#[test]
#[ignore = "minutes"]
fn a_million_random_scenes() {
    render_scenes(1_000_000);
}
