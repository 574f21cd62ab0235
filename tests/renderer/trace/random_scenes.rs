//! Random scenes of glass and mirrors, on which proofs are tried.

use crate::common::Random;
use serde_json::{Value, json};
use strahl::film::Region;
use strahl::render::{Control, Picture, render};
use strahl::scene::description::{Accuracy, Fixed, Proved};
use strahl::scene::{Format, Loaded, Overrides, Scene, load};

pub(super) const WIDTH: u32 = 26;
pub(super) const HEIGHT: u32 = 18;

/// A room's worth of glass, mirrors and matt things, some of which amplify light with their neighbours.
pub(super) fn scene(seed: u64) -> Vec<u8> {
    let mut random = Random::new(seed);
    let r = &mut random;
    let color = |r: &mut Random, most: f64| -> [f64; 3] { std::array::from_fn(|_| r.between(0.0, most)) };
    let mut materials = serde_json::Map::new();
    for i in 0..4 {
        let reflection = [0.0, r.between(0.0, 0.9), r.between(0.0, 0.3)][r.below(3)];
        let transmission = if r.below(2) == 0 { 0.0 } else { r.between(0.0, 0.98 - reflection) };
        let fresnel = ["none", "none", "dielectric", "conductor"][r.below(4)];
        let material = json!({
            "diffuse": color(r, 0.9), "specular": r.between(0.0, 0.6), "shininess": r.between(1.0, 200.0),
            "reflection": reflection, "transmission": transmission, "ior": r.between(1.1, 2.0), "fresnel": fresnel,
            "emission": if r.below(6) == 0 { color(r, 0.5) } else { [0.0; 3] },
            "absorption": if r.below(4) == 0 { color(r, 1.0) } else { [0.0; 3] },
        });
        materials.insert(format!("m{i}"), material);
    }
    let name = |r: &mut Random| format!("m{}", r.below(4));
    let mut objects: Vec<Value> = (0..3 + r.below(6))
        .map(|_| json!({ "sphere": { "center": r.point(2.0), "radius": r.between(0.3, 1.0), "material": name(r) } }))
        .collect();
    for axis in 0..3 {
        let mut normal = [0.0; 3];
        normal[axis] = 1.0;
        let point = normal.map(|n| -3.0 * n);
        if r.below(2) == 0 {
            objects.push(json!({ "plane": { "point": point, "normal": normal, "material": name(r) } }));
        }
    }
    let lights: Vec<Value> = (0..1 + r.below(3))
        .map(|_| {
            let falloff = if r.below(3) == 0 { "inverse_square" } else { "none" };
            let intensity = if falloff == "none" { r.between(0.3, 3.0) } else { r.between(3.0, 30.0) };
            let position = [r.between(-2.5, 2.5), r.between(3.2, 6.0), r.between(3.2, 6.0)];
            json!({ "point": { "position": position, "intensity": intensity, "falloff": falloff } })
        })
        .collect();
    let fog = if r.below(5) == 0 { json!({ "color": color(r, 1.0), "density": 0.1 }) } else { Value::Null };
    let (shadows, precision) = (["opaque", "transmissive"][r.below(2)], ["single", "double"][r.below(2)]);
    let mut scene = json!({
        "version": 1, "image": { "width": WIDTH, "height": HEIGHT },
        "camera": { "pinhole": { "eye": [0.5, 0.8, 6.0], "look_at": [0, 0, 0], "vfov_deg": 50 } },
        "background": color(r, 1.0), "ambient": color(r, 0.3), "lights": lights, "materials": materials,
        "objects": objects,
        "render": { "antialias": false, "shadows": shadows, "precision": precision }
    });
    if !fog.is_null() {
        scene["fog"] = fog;
    }
    serde_json::to_vec(&scene).unwrap()
}

/// The same before nothing, of which alpha tells how much is seen.
pub(super) fn transparent(seed: u64) -> Vec<u8> {
    let mut scene: Value = serde_json::from_slice(&scene(seed)).unwrap();
    scene["film"] = json!({ "background": "transparent" });
    serde_json::to_vec(&scene).unwrap()
}

/// The same, where surfaces gather what others scatter.
pub(super) fn bleeding(seed: u64) -> Vec<u8> {
    let mut scene: Value = serde_json::from_slice(&scene(seed)).unwrap();
    scene["render"]["color_bleeding"] = json!(true);
    scene["render"]["samples"] = json!(1);
    serde_json::to_vec(&scene).unwrap()
}

/// The same, where light is traced between all surfaces and all of it comes from around: rays stand for others, and ceilings are low.
pub(super) fn traced(seed: u64) -> Vec<u8> {
    let mut scene: Value = serde_json::from_slice(&scene(seed)).unwrap();
    let materials = scene["materials"].as_object_mut().unwrap();
    for material in materials.values_mut() {
        // Surfaces send on no more than comes, in several ways or one.
        let kept = 1.0 - material["reflection"].as_f64().unwrap() - material["transmission"].as_f64().unwrap();
        let diffuse = material["diffuse"].as_array().unwrap().iter().map(|c| c.as_f64().unwrap() * kept);
        material["diffuse"] = diffuse.collect();
        material["emission"] = json!(0);
        material["fresnel"] = json!("none");
    }
    scene["background"] = json!(1);
    scene["lights"] = json!([]);
    scene["render"]["fidelity"] = json!("faithful");
    scene["render"]["samples"] = json!(1);
    serde_json::to_vec(&scene).unwrap()
}

pub(super) fn fixed(max_depth: u32, min_weight: f64) -> Overrides {
    Overrides {
        max_depth: Some(max_depth),
        min_weight: Some(min_weight),
        accuracy: Some(Accuracy::Fixed(Fixed {})),
        ..Overrides::default()
    }
}

pub(super) fn proved(max_codes: u8) -> Overrides {
    Overrides { accuracy: Some(Accuracy::Proved(Proved { max_codes })), ..Overrides::default() }
}

pub(super) fn loaded(text: &[u8], overrides: Overrides) -> Loaded {
    load(text, Format::Json, &overrides).unwrap_or_else(|problems| panic!("{problems}"))
}

pub(super) fn shoot(scene: &Scene) -> Picture {
    render(scene, Region::whole(scene.width, scene.height), &Control::default()).unwrap()
}
