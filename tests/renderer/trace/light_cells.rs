//! Shadow rays that are not traced, since cells of space say what they would meet, change no pixel.

use crate::common::Random;
use serde_json::{Value, json};
use strahl::accel::BvhKind;
use strahl::film::Region;
use strahl::render::{Control, Picture, render};
use strahl::scene::compile::{CompileOptions, compile_with};
use strahl::scene::{Format, Overrides, load};

/// Bodies of all kinds, some of them in each other, in the light of areas. Scenes lie anywhere, at any size.
fn random_scene(random: &mut Random) -> Value {
    let size = [0.01, 1.0, 1e3][random.below(3)];
    let far = [0.0, 3.0, 200.0][random.below(3)];
    let at = |x: f64, y: f64, z: f64| json!([size * (x + far), size * (y - far), size * (z + 0.5 * far)]);
    let mut unit = || random.below(1_000) as f64 / 1_000.0;
    let materials = ["matt", "mirror", "glass", "shiny"];
    let mut objects = vec![
        json!({ "plane": { "point": at(0.0, 0.0, 0.0), "normal": [0, 1, 0], "material": "matt" } }),
        json!({ "quad": { "vertices": [at(-3.0, 0.0, -3.0), at(3.0, 0.0, -3.0), at(3.0, 3.0, -3.0), at(-3.0, 3.0, -3.0)] } }),
    ];
    for number in 0..7 {
        let [x, y, z] = [4.0 * unit() - 2.0, 1.5 * unit(), 4.0 * unit() - 2.0];
        let (radius, material) = (0.2 + 0.5 * unit(), materials[(4.0 * unit()) as usize]);
        let reach = size * radius;
        objects.push(match number {
            0 | 1 => json!({ "sphere": { "center": at(x, y, z), "radius": reach, "material": material } }),
            2 => {
                json!({ "box": { "min": at(x, y, z), "max": at(x + radius, y + 0.7, z + 0.3), "material": material } })
            }
            3 => {
                json!({ "disc": { "center": at(x, y, z), "normal": [x, 1, z], "radius": reach, "material": material } })
            }
            4 => json!({ "cylinder": { "base": at(x, y, z), "top": at(x, y + 1.0, z), "radius": 0.3 * reach,
                "material": material } }),
            5 => json!({ "torus": { "center": at(x, y, z), "major_radius": reach, "minor_radius": 0.3 * reach,
                "material": material } }),
            _ => json!({ "group": { "transform": { "rotate_deg": { "axis": [0, 1, 0], "angle": 30 } }, "objects": [
                { "sphere": { "center": at(x, y, z), "radius": reach, "material": material } } ] } }),
        });
    }
    if unit() < 0.3 {
        // The eye is inside of it.
        objects.push(json!({ "sphere": { "center": at(0.0, 1.0, 0.0), "radius": 9.0 * size, "material": "matt" } }));
    }
    let (wide, high) = (size * (0.1 + unit()), 3.0 + 4.0 * unit());
    let lights = json!([
        { "point": { "position": at(2.0, high, 2.0 * unit()), "intensity": 0.5,
            "area": { "parallelogram": { "u": [wide, 0, 0], "v": [0, 0.3 * wide, wide] } } } },
        { "spot": { "position": at(-2.0, high, 2.0), "direction": [1, -2, -1], "inner_deg": 20, "outer_deg": 60, "intensity": 0.4,
            "area": { "disc": { "radius": 0.4 * wide } } } },
        { "directional": { "direction": [unit() - 0.5, -1, -0.3], "intensity": 0.3,
            "area": { "angle_deg": 1.0 + 20.0 * unit() } } }
    ]);
    json!({
        "version": 1, "image": { "width": 48, "height": 36 }, "ambient": 0.1, "background": [0.2, 0.3, 0.5],
        "camera": { "pinhole": { "eye": at(0.5, 1.8, 6.0), "look_at": at(0.0, 0.7, 0.0) } },
        "lights": lights, "objects": objects,
        "materials": {
            "matt": { "diffuse": 0.7 }, "mirror": { "diffuse": 0.1, "reflection": 0.8 },
            "glass": { "diffuse": 0.05, "transmission": 0.9, "ior": 1.5 },
            "shiny": { "diffuse": [0.6, 0.2, 0.1], "specular": 0.5, "shininess": 40 }
        },
        "render": { "samples": 4, "max_depth": 4, "shadows": if unit() < 0.5 { "transmissive" } else { "opaque" } }
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
