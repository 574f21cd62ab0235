//! What leaves hold is tested 16 at a time, line by line or body by body, and bodies that are placed alone are met without a
//! search: all find what tests of one body after the other find.

use crate::common::Random;
use serde_json::{Value, json};
use strahl::accel::BvhKind;
use strahl::film::Region;
use strahl::render::{Control, render};
use strahl::scene::compile::{CompileOptions, compile_with};
use strahl::scene::{Format, Overrides, load};

/// Pipes, cones, balls and placed bodies of each kind, close to each other.
fn crowd(seed: u64, material: &str, one_sided: bool) -> Value {
    let mut random = Random::new(seed);
    let mut objects = vec![json!({ "plane": { "point": [0, -4, 0], "normal": [0, 1, 0], "material": "wall" } })];
    for i in 0..160 {
        let (base, step) = (random.point(3.0), random.point(1.0));
        let top = [0, 1, 2].map(|axis| base[axis] + step[axis]);
        let radius = random.between(0.05, 0.3);
        let placed = json!({ "translate": base, "scale": radius, "rotate_deg": { "axis": [1, 2, 3], "angle": 2 * i } });
        objects.push(match i % 8 {
            0 | 1 => json!({ "sphere": { "center": base, "radius": radius, "material": material } }),
            2 => json!({ "cylinder": { "base": base, "top": top, "radius": radius, "material": material } }),
            3 => json!({ "cylinder": { "base": base, "top": top, "radius": radius, "capped": false, "material": material } }),
            4 => json!({ "cone": { "base": base, "base_radius": radius, "top": top, "top_radius": 0, "material": material } }),
            5 => json!({ "cone": { "base": base, "base_radius": radius, "top": top, "top_radius": 0.1, "capped": false,
                "material": material } }),
            6 => json!({ "instance": { "of": "ball", "transform": placed } }),
            _ => json!({ "instance": { "of": if i % 16 == 7 { "pipe" } else { "block" }, "transform": placed } }),
        });
    }
    json!({
        "version": 1,
        "image": { "width": 48, "height": 32 },
        "camera": { "pinhole": { "eye": [0, 1, 9], "look_at": [0, 0, 0] } },
        "lights": [{ "point": { "position": [3, 8, 5] } }, { "point": { "position": [-6, 2, 4], "color": [0.5, 0.5, 0.5] } }],
        "materials": {
            "wall": { "diffuse": 0.7 },
            "glass": { "diffuse": 0.1, "transmission": [0.8, 0.7, 0.6], "reflection": 0.1, "ior": 1.3 },
            "metal": { "diffuse": 0.3, "reflection": 0.5, "one_sided": one_sided }
        },
        "definitions": {
            "ball": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": material } }],
            "pipe": [{ "cylinder": { "base": [0, -1, 0], "top": [0, 1, 0], "radius": 0.4, "material": material } }],
            "block": [{ "box": { "min": [-1, -1, -1], "max": [1, 0.5, 1], "material": material } }]
        },
        "objects": objects,
        "render": { "max_depth": 5, "antialias": false }
    })
}

/// The pixels of a scene, with each of some hierarchies.
fn pictures<const N: usize>(scene: &Value, kinds: [BvhKind; N]) -> [Vec<[f32; 3]>; N] {
    let bytes = serde_json::to_vec(scene).unwrap();
    let description = load(&bytes, Format::Json, &Overrides::default()).unwrap_or_else(|e| panic!("{e}")).description;
    kinds.map(|bvh| {
        let scene = compile_with(&description, CompileOptions { bvh, ..CompileOptions::default() }).unwrap();
        let region = Region::whole(scene.width, scene.height);
        render(&scene, region, &Control::default()).unwrap().film.pixels
    })
}

#[test]
fn leaves_find_what_body_after_body_finds() {
    for (seed, (material, one_sided)) in [("glass", false), ("metal", false), ("metal", true)].into_iter().enumerate() {
        for precision in ["single", "double"] {
            for shadows in ["opaque", "transmissive"] {
                let mut scene = crowd(seed as u64, material, one_sided);
                scene["render"]["precision"] = json!(precision);
                scene["render"]["shadows"] = json!(shadows);
                let [brute, sah, median] = pictures(&scene, [BvhKind::Flat, BvhKind::Sah, BvhKind::Median]);
                assert!(brute == sah && brute == median, "{material} {one_sided} {precision} {shadows}");
            }
        }
    }
}

/// Few bodies of two kinds are one leaf, or one for each kind with a box of its own where the boxes have little surface.
#[test]
fn a_few_bodies_on_a_floor_are_found() {
    for (seed, spread) in [(1, 0.4), (2, 1.5), (3, 6.0)] {
        let mut random = Random::new(seed);
        let mut scene = crowd(seed, "glass", false);
        let floor = [[-9, -2, 9], [9, -2, 9], [9, -2, -9], [-9, -2, -9]];
        let mut objects = vec![json!({ "quad": { "vertices": floor, "material": "metal" } })];
        for _ in 0..5 {
            let (at, step) = (random.point(spread), random.point(1.0));
            let top = [0, 1, 2].map(|axis| at[axis] + step[axis]);
            objects.push(if seed == 2 {
                json!({ "cylinder": { "base": at, "top": top, "radius": 0.3, "material": "glass" } })
            } else {
                json!({ "sphere": { "center": at, "radius": 0.5, "material": "glass" } })
            });
        }
        scene["objects"] = json!(objects);
        let [brute, sah, median] = pictures(&scene, [BvhKind::Flat, BvhKind::Sah, BvhKind::Median]);
        assert!(brute == sah && brute == median, "spread over {spread}");
    }
}

/// Large meshes are built of runs of triangles: some lie side by side, others do not, and some have no area.
#[test]
fn a_large_mesh_is_found_in_runs_as_triangle_by_triangle() {
    let mut random = Random::new(4);
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for i in 0..34_000_u32 {
        let [x, y] = [f64::from(i / 2 % 130) / 16.0 - 4.0, f64::from(i / 260) / 16.0 - 4.0];
        let [near, far] = [0.07, if i % 50 == 0 { 1.0 } else { 0.07 }];
        let corners =
            if i % 2 == 0 { [[0.0, 0.0], [near, 0.0], [0.0, far]] } else { [[near, 0.0], [near, far], [0.0, far]] };
        vertices.extend(corners.map(|[a, b]| [x + a, y + b, 0.3 * random.between(0.0, 1.0)]));
        faces.push(if i % 97 == 0 { [3 * i, 3 * i, 3 * i + 1] } else { [3 * i, 3 * i + 1, 3 * i + 2] });
    }
    for precision in ["single", "double"] {
        let mut scene = crowd(4, "metal", false);
        scene["render"]["precision"] = json!(precision);
        scene["objects"] = json!([
            { "mesh": { "vertices": vertices, "faces": faces, "material": "metal" } },
            { "sphere": { "center": [0, 0, 2], "radius": 0.7, "material": "glass" } }
        ]);
        let [sah, median] = pictures(&scene, [BvhKind::Sah, BvhKind::Median]);
        assert!(sah == median, "{precision}");
        assert!(sah.iter().any(|pixel| pixel[0] > 0.1), "the mesh is seen");
    }
}
