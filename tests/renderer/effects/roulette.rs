//! Where light is traced, rays stand for others: they bring as much in the mean, and are few however often light is scattered.

use super::*;

fn room(render: Value) -> Value {
    let wall = |corners: [[i32; 3]; 4]| json!({ "quad": { "vertices": corners, "material": "white" } });
    let ball = |x: f64| json!({ "sphere": { "center": [x, -0.5, 0.3 * x], "radius": 0.5, "material": "white" } });
    json!({
        "version": 1, "image": { "width": 12, "height": 12 }, "ambient": 0, "background": 1, "render": render,
        "camera": { "pinhole": { "eye": [0, 0, 4.2], "look_at": [0, 0, 0], "vfov_deg": 35 } },
        "lights": [{ "directional": { "direction": [0.2, -0.4, -1], "area": { "angle_deg": 15 } } }],
        "materials": { "white": { "pbr": { "base_color": 0.8, "metallic": 0, "roughness": 0.5 } } },
        "objects": [
            wall([[-1, -1, -1], [-1, -1, 1], [-1, 1, 1], [-1, 1, -1]]), wall([[1, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]]),
            wall([[-1, -1, -1], [1, -1, -1], [1, -1, 1], [-1, -1, 1]]), wall([[-1, 1, -1], [-1, 1, 1], [1, 1, 1], [1, 1, -1]]),
            wall([[-1, -1, -1], [-1, 1, -1], [1, 1, -1], [1, -1, -1]]), ball(-0.5), ball(0.4)
        ]
    })
}

/// Each hit has a diffuse ray and a reflected one, again and again: without roulette samples of such rooms take hundreds of rays.
#[test]
fn a_white_room_takes_few_rays() {
    let layered = room(json!({ "fidelity": "faithful", "samples": 16 }));
    let mut whitted = layered.clone();
    whitted["materials"]["white"] = json!({ "diffuse": 0.4, "reflection": 0.2, "transmission": 0.3, "ior": 1.5 });
    for description in [layered, whitted] {
        let scene = scene(description, "single");
        let cost = picture(&scene).rays;
        let each = (cost.total() as f64) / (12.0 * 12.0 * 16.0);
        assert!(each < 60.0, "{each} rays for a sample");
    }
}

/// Inside of a ball that glows with e and scatters a share a of what comes, everything shines with e / (1 - a).
#[test]
fn in_the_mean_nothing_changes() {
    for (a, mirrored, glossy) in
        [(0.5, 0.0, false), (0.9, 0.0, false), (0.5, 0.3, false), (0.2, 0.7, false), (0.5, 0.0, true)]
    {
        let material = if glossy {
            json!({ "pbr": { "base_color": a, "metallic": 1, "roughness": 0.4, "emissive": 0.1 } })
        } else {
            json!({ "diffuse": a, "reflection": mirrored, "emission": 0.1 })
        };
        let a = a + mirrored;
        let description = json!({
            "version": 1, "image": { "width": 16, "height": 16 }, "ambient": 0, "background": 7, "lights": [],
            "camera": { "pinhole": { "eye": [0.2, 0.1, 0], "look_at": [0.2, 0.1, -1] } },
            "materials": { "it": material },
            "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "it", "hollow": true } }],
            "render": { "fidelity": "faithful", "samples": 64, "max_depth": 200, "min_weight": 1e-7 }
        });
        for precision in ["single", "double"] {
            let found = pixels(description.clone(), precision);
            let mean = found.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / found.len() as f64;
            // Rough metal of a base color of a half reflects a little less than that, since facets send light to others.
            let [low, high] = if glossy { [0.193, 0.203] } else { [0.995, 1.005].map(|part| part * 0.1 / (1.0 - a)) };
            assert!((low..high).contains(&mean), "{a} {glossy} {precision}: {mean}");
        }
    }
}

/// A mirror shows the lamp itself, with the radiance that lights white as brightly as it does. A narrow lobe shows it nearly so, and no
/// sample of it is another.
#[test]
fn a_soft_lamp_is_seen_in_what_is_smooth() {
    for (material, share) in [
        (json!({ "base_color": 1, "metallic": 1, "roughness": 0 }), 1.0),
        (json!({ "base_color": 1, "metallic": 1, "roughness": 0.05 }), 1.0),
        (
            json!({ "base_color": 0, "metallic": 0, "roughness": 1, "specular": 0, "clearcoat": 1, "clearcoat_roughness": 0 }),
            0.04,
        ),
        (
            json!({ "base_color": 0, "metallic": 0, "roughness": 1, "specular": 0, "clearcoat": 1, "clearcoat_roughness": 0.05 }),
            0.04,
        ),
    ] {
        let sheet = |samples: u32| {
            json!({
                "version": 1, "image": { "width": 8, "height": 8 }, "ambient": 0, "background": 0,
                "camera": { "orthographic": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "height": 1 } },
                "lights": [{ "directional": { "direction": [0, 0, -1], "area": { "angle_deg": 15 } } }],
                "materials": { "it": { "pbr": material } },
                "objects": [{ "quad": { "vertices": [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], "material": "it" } }],
                "render": { "fidelity": "faithful", "samples": samples }
            })
        };
        let tangent = 7.5_f64.to_radians().tan();
        let radiance = share / (tangent * tangent);
        let parts: Vec<f64> = pixels(sheet(16), "single").iter().map(|pixel| f64::from(pixel[0]) / radiance).collect();
        let mean = parts.iter().sum::<f64>() / parts.len() as f64;
        // A few per cent of a narrow lobe are left to points of the lamp.
        assert!((0.98..1.01).contains(&mean), "{material}: {mean}");
        assert!(parts.iter().all(|part| (0.9..1.2).contains(part)), "{material}: {parts:?}");
    }
}
