//! Bodies, fog and light of many kinds in one scene: nothing but the scene decides what a pixel shows.

use super::*;
use strahl::render::{RenderOptions, render_with};

/// Balls and boxes of colored glass that overlap, over a floor, all lengths times `scale`.
fn jumble(seed: u64, scale: f64) -> Value {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1u64 << 24) as f64
    };
    let mut objects =
        vec![json!({ "plane": { "point": [0, -1.5 * scale, 0], "normal": [0, 1, 0], "material": "floor" } })];
    for i in 0..14 {
        let material = ["red", "blue", "pane", "gold", "lamp"][i % 5];
        let [x, y, z, size] = [0.0; 4].map(|_: f64| uniform());
        let at = [x, y, z].map(|x| (x * 4.0 - 2.0) * scale);
        let size = (size + 0.25) * scale;
        objects.push(match i % 3 {
            0 => {
                json!({ "box": { "min": at, "max": at.map(|x| x + size), "material": material, "hollow": i % 6 == 0 } })
            }
            _ => json!({ "sphere": { "center": at, "radius": size, "material": material } }),
        });
    }
    let glass = |absorption: [f64; 3], fresnel: &str| {
        let absorption = absorption.map(|sigma| sigma / scale);
        json!({ "diffuse": 0.01, "specular": 0.5, "reflection": 0.9, "transmission": 0.9, "ior": 1.4,
                "fresnel": fresnel, "absorption": absorption })
    };
    json!({
        "version": 1,
        "image": { "width": 40, "height": 30 },
        "camera": { "pinhole": { "eye": [0.3 * scale, 0.8 * scale, 6.0 * scale], "look_at": [0, 0, 0], "vfov_deg": 50 } },
        "background": [0.3, 0.4, 0.6],
        "fog": { "color": 0.4, "density": 0.125 / scale, "height": { "base": -scale, "falloff": 0.75 * scale } },
        "lights": [
            { "point": { "position": [5.0 * scale, 8.0 * scale, 6.0 * scale], "color": 0.7 } },
            { "directional": { "direction": [1, -2, -1], "color": 0.4 } }
        ],
        "materials": {
            "red": glass([0.1, 1.5, 1.5], "dielectric"),
            "blue": glass([1.5, 0.75, 0.0], "none"),
            "pane": glass([0.0, 0.0, 0.0], "dielectric"),
            "gold": { "diffuse": 0, "reflection": [0.9, 0.7, 0.3], "fresnel": "conductor" },
            "lamp": { "diffuse": 0.2, "emission": [0.3, 0.1, 0.5] },
            "floor": { "diffuse": 0.7 }
        },
        "objects": objects,
        "render": { "max_depth": 7, "antialias": false, "shadows": "transmissive" }
    })
}

fn bits(pixels: &[[f32; 3]]) -> Vec<[u32; 3]> {
    pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

/// The inside of a sheet is lit through the sheet itself, also where a light has an area and all rays to it are asked at once.
#[test]
fn a_thin_ball_has_the_shadow_of_its_own_back() {
    let ball = json!({ "sphere": { "center": [0, 1, 0], "radius": 1, "material": "pane" } });
    let plane = json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0] } });
    let seen = |light: &Value, objects: Value| {
        let description = json!({
            "version": 1, "image": { "width": 48, "height": 36 }, "lights": [light],
            "camera": { "pinhole": { "eye": [0, 1.2, 5], "look_at": [0, 0.9, 0] } },
            "materials": { "pane": { "pbr": { "metallic": 0, "roughness": 0, "transmission": 0.5, "thin": true } } },
            "objects": objects, "render": { "samples": 16, "antialias": false, "max_depth": 6 }
        });
        pixels(description, "double")
    };
    let point = |radius: f64| {
        let area = json!({ "disc": { "radius": radius } });
        let mut light = json!({ "point": { "position": [3, 5, 3], "area": area } });
        if radius == 0.0 {
            light["point"].as_object_mut().unwrap().remove("area");
        }
        light
    };
    let sun = json!({ "directional": { "direction": [-3, -5, -3], "area": { "angle_deg": 1 } } });
    for light in [point(0.1), sun] {
        let placed = json!({ "group": { "objects": [ball], "transform": { "translate": [0, 0, 0] } } });
        let [bare, placed] = [&ball, &placed].map(|object| seen(&light, json!([object, plane])));
        assert!(bare == placed, "{light}");
    }
    let [tiny, none] = [point(1e-4), point(0.0)].map(|light| seen(&light, json!([ball, plane])));
    let off = tiny.iter().flatten().zip(none.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off < 0.02, "{off}");
}

#[test]
fn neither_order_nor_scale_nor_packets_nor_kernels_change_a_byte() {
    for seed in 0..12 {
        let description = jumble(seed, 1.0);
        for precision in ["single", "double"] {
            let expected = bits(&pixels(description.clone(), precision));
            let mut turned = description.clone();
            turned["objects"].as_array_mut().unwrap().reverse();
            assert_eq!(bits(&pixels(turned, precision)), expected, "seed {seed}, {precision}: reversed");
            for power in [-12, 9] {
                let scaled = jumble(seed, 2f64.powi(power));
                assert_eq!(bits(&pixels(scaled, precision)), expected, "seed {seed}, {precision}: times 2^{power}");
            }
            let scene = scene(description.clone(), precision);
            let whole = Region::whole(scene.width, scene.height);
            for cut in [
                RenderOptions { specialised: false, ..RenderOptions::default() },
                RenderOptions { tile: 3, ..RenderOptions::default() },
            ] {
                let film = render_with(&scene, whole, &Control::default(), cut).unwrap().film;
                assert_eq!(bits(&film.pixels), expected, "seed {seed}, {precision}: {cut:?}");
            }
        }
    }
}

#[test]
fn the_tree_of_rays_adds_up_to_the_pixel() {
    for precision in ["single", "double"] {
        let scene = scene(jumble(3, 1.0), precision);
        let film = picture(&scene).film;
        for (x, y) in [(0, 0), (20, 15), (9, 21), (33, 12), (25, 8)] {
            let tree = strahl::inspect::tree::trace_pixel(&scene, x, y);
            assert_eq!(tree.value.map(|c| c as f32), film.pixels[(y * 40 + x) as usize], "{precision} {x} {y}");
            let mut sum = [0.0f64; 3];
            for ray in &tree.rays {
                for c in 0..3 {
                    sum[c] += ray.contribution[c];
                }
            }
            for c in 0..3 {
                assert!((sum[c] - tree.value[c]).abs() < 1e-6, "{precision} {x} {y}");
            }
        }
    }
}

#[test]
fn extreme_numbers_give_finite_pixels() {
    for extreme in [0.0, 1e-15, 1e15] {
        for density in [1e-15, 1e15] {
            let mut description = jumble(5, 1.0);
            for material in ["red", "blue"] {
                description["materials"][material]["absorption"] = json!([extreme, 0, 1]);
            }
            description["materials"]["lamp"]["emission"] = json!(extreme);
            description["materials"]["red"]["ior"] = json!(if extreme > 1.0 { 100.0 } else { 0.01 });
            description["fog"] =
                json!({ "color": extreme, "density": density, "height": { "base": 0, "falloff": 1.0 / density } });
            for precision in ["single", "double"] {
                let pixels = pixels(description.clone(), precision);
                assert!(pixels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0), "{extreme} {density} {precision}");
            }
        }
    }
}
