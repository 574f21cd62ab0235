//! Shadow rays that are not traced, since cells of space say what they would meet, change no pixel.

use crate::common::Random;
use serde_json::{Value, json};
use strahl::accel::BvhKind;
use strahl::film::Region;
use strahl::render::{Control, Picture, render};
use strahl::scene::compile::{CompileOptions, compile_with};
use strahl::scene::{Format, Overrides, load};

/// A place in a scene that lies anywhere, at any size.
struct Place {
    size: f64,
    far: f64,
}

impl Place {
    fn at(&self, x: f64, y: f64, z: f64) -> Value {
        let Self { size, far } = self;
        json!([size * (x + far), size * (y - far), size * (z + 0.5 * far)])
    }
}

/// A number from 0 to 1.
fn unit(random: &mut Random) -> f64 {
    random.below(1_000) as f64 / 1_000.0
}

/// A body of one of seven kinds.
fn body(random: &mut Random, place: &Place, kind: usize) -> Value {
    let [x, y, z] = [4.0 * unit(random) - 2.0, 1.5 * unit(random), 4.0 * unit(random) - 2.0];
    let wide = 0.2 + 0.5 * unit(random);
    let (low, radius) = (place.at(x, y, z), place.size * wide);
    let (kind, mut body) = match kind {
        0 | 1 => ("sphere", json!({ "center": low, "radius": radius })),
        2 => ("box", json!({ "min": low, "max": place.at(x + wide, y + 0.7, z + 0.3) })),
        3 => ("disc", json!({ "center": low, "normal": [x, 1, z], "radius": radius })),
        4 => ("cylinder", json!({ "base": low, "top": place.at(x, y + 1.0, z), "radius": 0.3 * radius })),
        _ => ("torus", json!({ "center": low, "major_radius": radius, "minor_radius": 0.3 * radius })),
    };
    let material = ["matt", "mirror", "glass", "shiny"][random.below(4)];
    body["material"] = json!(material);
    json!({ (kind): body })
}

fn objects(random: &mut Random, place: &Place) -> Vec<Value> {
    let corners = [[-3.0, 0.0], [3.0, 0.0], [3.0, 3.0], [-3.0, 3.0]].map(|[x, y]| place.at(x, y, -3.0));
    let mut objects = vec![
        json!({ "plane": { "point": place.at(0.0, 0.0, 0.0), "normal": [0, 1, 0], "material": "matt" } }),
        json!({ "quad": { "vertices": corners, "material": "matt" } }),
    ];
    objects.extend((0..7).map(|kind| body(random, place, kind)));
    let turned = json!({ "rotate_deg": { "axis": [0, 1, 0], "angle": 30 } });
    objects.push(json!({ "group": { "transform": turned, "objects": [body(random, place, 0)] } }));
    if random.below(3) == 0 {
        // The eye is inside of it.
        let center = place.at(0.0, 1.0, 0.0);
        objects.push(json!({ "sphere": { "center": center, "radius": 9.0 * place.size, "material": "matt" } }));
    }
    objects
}

fn lights(random: &mut Random, place: &Place) -> Value {
    let (wide, high) = (place.size * (0.1 + unit(random)), 3.0 + 4.0 * unit(random));
    let window = json!({ "parallelogram": { "u": [wide, 0, 0], "v": [0, 0.3 * wide, wide] } });
    let disc = json!({ "disc": { "radius": 0.4 * wide } });
    json!([
        { "point": { "position": place.at(2.0, high, 2.0 * unit(random)), "intensity": 0.5, "area": window } },
        { "spot": { "position": place.at(-2.0, high, 2.0), "direction": [1, -2, -1], "inner_deg": 20, "outer_deg": 60,
            "intensity": 0.4, "area": disc } },
        { "directional": { "direction": [unit(random) - 0.5, -1, -0.3], "intensity": 0.3,
            "area": { "angle_deg": 1.0 + 20.0 * unit(random) } } }
    ])
}

/// Bodies of all kinds, some of them in each other, in the light of areas.
fn random_scene(random: &mut Random) -> Value {
    let place = Place { size: [0.01, 1.0, 1e3][random.below(3)], far: [0.0, 3.0, 200.0][random.below(3)] };
    let shadows = ["transmissive", "opaque"][random.below(2)];
    json!({
        "version": 1, "image": { "width": 48, "height": 36 }, "ambient": 0.1, "background": [0.2, 0.3, 0.5],
        "camera": { "pinhole": { "eye": place.at(0.5, 1.8, 6.0), "look_at": place.at(0.0, 0.7, 0.0) } },
        "lights": lights(random, &place), "objects": objects(random, &place),
        "materials": {
            "matt": { "diffuse": 0.7 }, "mirror": { "diffuse": 0.1, "reflection": 0.8 },
            "glass": { "diffuse": 0.05, "transmission": 0.9, "ior": 1.5 },
            "shiny": { "diffuse": [0.6, 0.2, 0.1], "specular": 0.5, "shininess": 40 }
        },
        "render": { "samples": 4, "max_depth": 4, "shadows": shadows }
    })
}

/// The slow twin has no hierarchy and no cells.
#[test]
fn spared_shadow_rays_change_nothing() {
    let mut random = Random::new(18);
    let (mut spared, mut all) = (0, 0);
    for number in 0..80 {
        let mut scene = random_scene(&mut random);
        for precision in ["single", "double"] {
            scene["render"]["precision"] = json!(precision);
            let text = serde_json::to_vec(&scene).unwrap();
            let description = load(&text, Format::Json, &Overrides::default())
                .unwrap_or_else(|problems| panic!("{number}: {problems}"))
                .description;
            let picture = |bvh| -> Picture {
                let scene = compile_with(&description, CompileOptions { bvh, ..CompileOptions::default() }).unwrap();
                render(&scene, Region::whole(scene.width, scene.height), &Control::default()).unwrap()
            };
            let [quick, slow] = [BvhKind::Sah, BvhKind::Flat].map(picture);
            assert!(quick.film.pixels == slow.film.pixels, "scene {number} in {precision}: {scene}");
            let camera = |picture: &Picture| (picture.rays.camera, picture.rays.reflected, picture.rays.transmitted);
            assert_eq!(camera(&quick), camera(&slow), "scene {number} in {precision}");
            (spared, all) = (spared + slow.rays.shadow - quick.rays.shadow, all + slow.rays.shadow);
        }
    }
    let share = spared as f64 / all as f64;
    println!("{share:.2} of {all} shadow rays spared");
    assert!(share > 0.1);
}
