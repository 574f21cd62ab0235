//! Random scenes that ask for many effects, a good part of them in vain.

use crate::common::Random;
use data_encoding::BASE64;
use image::{ImageFormat, Rgb, RgbImage};
use serde_json::{Value, json};
use std::io::Cursor;
use std::sync::LazyLock;

/// Pictures of two colors, of one, and a flat normal map.
static IMAGES: LazyLock<[String; 3]> = LazyLock::new(|| {
    [
        RgbImage::from_fn(4, 4, |x, y| Rgb([(x * 60) as u8, (y * 60) as u8, 200])),
        RgbImage::from_pixel(2, 2, Rgb([255, 0, 255])),
        RgbImage::from_pixel(2, 2, Rgb([128, 128, 255])),
    ]
    .map(|image| in_url(&image))
});

fn in_url(image: &RgbImage) -> String {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).unwrap();
    format!("data:image/png;base64,{}", BASE64.encode(bytes.get_ref()))
}

/// A picture of two columns.
pub(super) fn picture([left, right]: [[u8; 3]; 2]) -> String {
    in_url(&RgbImage::from_fn(2, 2, |x, _| Rgb(if x == 0 { left } else { right })))
}

fn one_of(r: &mut Random, values: &[Value]) -> Value {
    values[r.below(values.len())].clone()
}

/// A color that is black more often than chance would have it.
fn gray(r: &mut Random) -> Value {
    if r.below(3) == 0 { json!(0) } else { json!(r.between(0.1, 0.9)) }
}

fn diffuse(r: &mut Random) -> Value {
    let (a, b) = (gray(r), gray(r));
    let b = if r.below(3) == 0 { a.clone() } else { b };
    let image = |k: usize| json!({ "image": { "source": IMAGES[k], "mapping": { "planar": { "axes": "xy" } } } });
    match r.below(8) {
        0 => json!({ "checker": { "a": a, "b": b, "size": 0.5, "axes": "xyz" } }),
        1 => json!({ "gradient": { "from": [-1, 0, 0], "to": [1, 0.5, 0], "a": a, "b": b } }),
        2 => json!({ "noise": { "a": a, "b": b } }),
        3 => image(0),
        4 => image(1),
        _ => gray(r),
    }
}

fn material(r: &mut Random) -> Value {
    let mut material = json!({
        "diffuse": diffuse(r), "specular": gray(r), "reflection": gray(r), "transmission": gray(r),
        "ior": one_of(r, &[json!(1), json!(1.5)]),
        "fresnel": one_of(r, &[json!("none"), json!("none"), json!("dielectric"), json!("conductor")]),
        "absorption": one_of(r, &[json!(0), json!(0.5)]), "emission": one_of(r, &[json!(0), json!(0), json!(0.3)]),
        "roughness": one_of(r, &[json!(0), json!(0), json!(0.3)]),
        "dispersion": one_of(r, &[json!(0), json!(0), json!(0.02)])
    });
    if r.below(3) == 0 {
        material["ambient"] = diffuse(r);
    }
    let image = |k: usize| json!({ "source": IMAGES[k], "mapping": { "planar": { "axes": "xy" } } });
    let image = image(one_of(r, &[json!(0), json!(1), json!(2)]).as_u64().unwrap() as usize);
    match r.below(5) {
        0 => {
            let texture = one_of(r, &[json!({ "noise": {} }), json!({ "image": image })]);
            material["bump"] = json!({ "height": one_of(r, &[json!(0), json!(0.1)]), "texture": texture });
        }
        1 => material["normal_map"] = json!({ "image": image }),
        _ => {}
    }
    material
}

/// A material as in glTF, much of which asks for nothing: numbers alone, since bodies without coordinates take no pictures.
fn pbr(r: &mut Random) -> Value {
    let share = |r: &mut Random| one_of(r, &[json!(0), json!(0), json!(0.4), json!(1)]);
    let mut pbr = json!({
        "base_color": gray(r), "metallic": share(r), "roughness": share(r), "transmission": share(r),
        "specular": share(r), "specular_color": gray(r), "clearcoat": share(r), "clearcoat_roughness": share(r),
        "ior": one_of(r, &[json!(1), json!(1.5)]), "thin": r.below(3) == 0,
        "emissive": one_of(r, &[json!(0), json!(0), json!(0.3)]),
        "dispersion": one_of(r, &[json!(0), json!(0), json!(0.2)])
    });
    match r.below(8) {
        0 => pbr["unlit"] = json!(true),
        1 => (pbr["shadow_catcher"], pbr["edge_fade"]) = (json!(true), one_of(r, &[json!(0), json!(0.2)])),
        2 | 3 => {
            let mode = one_of(r, &[json!("blend"), json!("mask")]);
            pbr["opacity"] = json!({ "alpha": share(r), "mode": mode, "cutoff": one_of(r, &[json!(0), json!(0.5)]) });
        }
        4 => pbr["attenuation"] = json!({ "color": one_of(r, &[json!(1), json!(0.4)]), "distance": 0.5 }),
        _ => {}
    }
    json!({ "pbr": pbr, "one_sided": r.below(4) == 0 })
}

fn body(r: &mut Random) -> Value {
    let (p, q, size) = (r.point(1.5), r.point(1.5), r.between(0.2, 1.2));
    let min: [f64; 3] = std::array::from_fn(|i| p[i].min(q[i]));
    let mut max: [f64; 3] = std::array::from_fn(|i| p[i].max(q[i]));
    if r.below(4) == 0 {
        max[1] = min[1];
    }
    let tilted = r.point(1.0);
    let upright = one_of(r, &[json!([0, 1, 0]), json!(tilted)]);
    let mut body = match r.below(7) {
        0 | 1 => json!({ "sphere": { "center": p, "radius": size } }),
        // Of surfaces in the same place another one may be met where light passes.
        2 => json!({ "plane": { "point": [0, r.between(-2.0, -1.0), 0], "normal": upright } }),
        3 => json!({ "box": { "min": min, "max": max } }),
        4 => json!({ "disc": { "center": p, "normal": q, "radius": size } }),
        5 => json!({ "cylinder": { "base": p, "top": q, "radius": 0.3, "capped": r.below(2) == 0 } }),
        _ => {
            let normals: Vec<_> = (0..3).map(|_| r.point(1.0)).collect();
            json!({ "mesh": { "vertices": [p, q, r.point(1.5)], "faces": [[0, 1, 2]], "normals": normals } })
        }
    };
    let (kind, keys) = body.as_object_mut().unwrap().iter_mut().next().unwrap();
    if !["disc", "mesh"].contains(&kind.as_str()) && r.below(6) == 0 {
        keys["hollow"] = json!(true);
    }
    if r.below(8) > 0 {
        keys["material"] = one_of(r, &[json!("a"), json!("b")]);
    }
    body
}

fn object(r: &mut Random) -> Value {
    let object = body(r);
    let motion = one_of(r, &[json!({}), json!({ "translate": [0, 0, 0] }), json!({ "translate": [0.2, 0.1, 0] })]);
    let transform = one_of(r, &[json!({}), json!({ "translate": [0.1, 0, 0], "scale": 0.9 })]);
    match r.below(10) {
        0 => json!({ "group": { "objects": [object], "transform": transform, "motion": motion } }),
        1 => json!({ "instance": { "of": "thing", "transform": transform } }),
        _ => object,
    }
}

fn light(r: &mut Random) -> Value {
    let size = one_of(r, &[json!(0), json!(0.5)]);
    let color = gray(r);
    let at = [r.between(-3.0, 3.0), r.between(0.5, 4.0), r.between(-3.0, 3.0)];
    let mut light = match r.below(3) {
        0 => json!({ "point": { "position": at, "color": color } }),
        1 => json!({ "directional": { "direction": [0.3, -1, at[2]], "color": color } }),
        _ => json!({ "spot": { "position": at, "direction": at.map(|x| -x), "outer_deg": 60, "color": color } }),
    };
    let (kind, keys) = light.as_object_mut().unwrap().iter_mut().next().unwrap();
    let directional = kind == "directional";
    if r.below(4) == 0 {
        keys["area"] = if directional { json!({ "angle_deg": size }) } else { json!({ "disc": { "radius": size } }) };
    }
    if !directional && r.below(3) == 0 {
        keys["falloff"] = json!("inverse_square");
    }
    light
}

/// A scene that asks for many things, a good part of them in vain.
pub(super) fn random_scene(seed: u64) -> Value {
    let mut random = Random::new(seed);
    let r = &mut random;
    let eye = [r.between(-1.0, 1.0), r.between(0.2, 2.0), 5.0];
    let view = json!({ "eye": eye, "look_at": [0, 0, 0] });
    let with = |key: &str, value: Value| {
        let mut view = view.clone();
        view[key] = value;
        view
    };
    let camera = match r.below(8) {
        0 => json!({ "orthographic": with("height", json!(4)) }),
        1 => json!({ "fisheye": with("fov_deg", json!(120)) }),
        2 => json!({ "pinhole": with("focus_distance", json!(4)) }),
        3 => json!({ "pinhole": with("aperture", json!(0.2)) }),
        _ => json!({ "pinhole": view }),
    };
    // Single bodies may hide no light.
    let count = [1, 1, 2, 4, 6][r.below(5)];
    let mut scene = json!({
        "version": 1, "image": { "width": 16, "height": 10 }, "camera": camera,
        "background": gray(r), "ambient": gray(r),
        "lights": (0..r.below(4)).map(|_| light(r)).collect::<Vec<_>>(),
        "materials": { "a": material(r), "b": material(r), "unused": material(r) },
        "definitions": { "thing": [body(r)], "unplaced": [body(r)] },
        "objects": (0..count).map(|_| object(r)).collect::<Vec<_>>(),
        "render": {
            "shadows": one_of(r, &[json!("opaque"), json!("opaque"), json!("transmissive"), json!("none")]),
            "precision": one_of(r, &[json!("single"), json!("double")]),
            "antialias": r.below(2) == 0
        }
    });
    let render = scene["render"].as_object_mut().unwrap();
    let mut ask = |key: &str, value: Value| render.insert(key.to_owned(), value);
    match r.below(5) {
        0 => ask("max_depth", json!(1)),
        1 => ask("min_weight", one_of(r, &[json!(1), json!(0.95), json!(0.3)])),
        2 => ask("max_depth", json!(6)),
        3 => ask("accuracy", one_of(r, &[json!({ "proved": { "max_codes": 0 } }), json!({ "fixed": {} })])),
        _ => None,
    };
    if r.below(6) == 0 {
        ask("color_bleeding", json!(true));
    }
    if r.below(3) > 0 {
        ask("samples", one_of(r, &[json!(2), json!(16)]));
    }
    if r.below(5) == 0 {
        scene["fog"] = json!({ "density": one_of(r, &[json!(0), json!(0.1)]) });
    }
    if r.below(4) == 0 {
        let image = &IMAGES[r.below(2)];
        scene["environment"] = json!({ "image": image, "intensity": one_of(r, &[json!(0), json!(0.5)]) });
    }
    if r.below(4) == 0 {
        scene["film"] = json!({
            "exposure": one_of(r, &[json!(0), json!(1.5)]),
            "tone": one_of(r, &[json!("none"), json!("khronos_pbr_neutral"), json!("agx")]),
            "background": one_of(r, &[json!("scene"), json!("transparent")])
        });
    }
    if r.below(4) == 0 {
        for name in ["a", "b"].into_iter().take(1 + r.below(2)) {
            scene["materials"][name] = pbr(r);
        }
        if r.below(2) == 0 {
            let image = &IMAGES[r.below(2)];
            let around = [json!({ "image": image }), json!({ "studio": {} }), json!({ "sky": {} })];
            scene["environment"] = one_of(r, &around);
            scene["environment"]["light"] = one_of(r, &[json!("none"), json!("fast")]);
            scene["environment"]["intensity"] = one_of(r, &[json!(0), json!(0.5)]);
        }
        if r.below(3) == 0 {
            scene["render"]["fidelity"] = json!("faithful");
            scene["render"]["samples"] = json!(2);
            scene["render"]["max_depth"] = json!(4);
            scene["render"].as_object_mut().unwrap().remove("accuracy");
            scene["render"].as_object_mut().unwrap().remove("min_weight");
        }
    }
    scene
}
