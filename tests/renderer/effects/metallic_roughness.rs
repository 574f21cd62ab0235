//! Metallic-roughness materials against the formulas of glTF 2.0, appendix B, written down once more.

use super::*;
use data_encoding::BASE64;
use image::{ImageFormat, RgbaImage};
use std::f64::consts::PI;
use std::io::Cursor;

pub(super) type V = [f64; 3];

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: V) -> V {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

/// A material as glTF has it.
#[derive(Clone, Copy)]
struct Plain {
    base: V,
    metallic: f64,
    roughness: f64,
    ior: f64,
    specular: f64,
    tint: V,
    coat: [f64; 2],
}

const PLAIN: Plain = Plain {
    base: [0.8, 0.5, 0.2],
    metallic: 0.0,
    roughness: 0.5,
    ior: 1.5,
    specular: 1.0,
    tint: [1.0; 3],
    coat: [0.0; 2],
};

impl Plain {
    fn json(&self) -> Value {
        json!({ "pbr": {
            "base_color": self.base, "metallic": self.metallic, "roughness": self.roughness, "ior": self.ior,
            "specular": self.specular, "specular_color": self.tint,
            "clearcoat": self.coat[0], "clearcoat_roughness": self.coat[1]
        } })
    }

    /// pi times the BRDF times the cosine of the light, on the plane z = 0. Where facets reflect `share` of white light without
    /// absorbing any, they pass the rest on to each other, and F0 of it gets on (Fdez-Agüera 2019). Those of clearcoat reflect
    /// `share_of_coat`, and all of the rest gets on.
    fn reflected(&self, light: V, view: V) -> V {
        let share = share_of(self.roughness, view);
        let share_of_coat = if self.coat[0] > 0.0 { share_of(self.coat[1], view) } else { 1.0 };
        let half = unit([light[0] + view[0], light[1] + view[1], light[2] + view[2]]);
        let grazing = (1.0 - dot(view, half)).powi(5);
        let specular = ggx(self.roughness, light[2], view[2], half[2]);
        let f0: V =
            self.tint.map(|tint| (((self.ior - 1.0) / (self.ior + 1.0)).powi(2) * tint).min(1.0) * self.specular);
        let fresnel = f0.map(|f0| f0 + (self.specular - f0) * grazing);
        let most = fresnel.iter().copied().fold(0.0, f64::max);
        let coat = self.coat[0] * (0.04 + 0.96 * (1.0 - view[2]).powi(5));
        let clearcoat = ggx(self.coat[1], light[2], view[2], half[2]);
        std::array::from_fn(|c| {
            let base = self.base[c];
            let more = |f0: f64| 1.0 + f0 * (1.0 / share - 1.0);
            let dielectric = base / PI * (1.0 - most) + specular * more(f0[c]) * fresnel[c];
            let metal = specular * more(base) * (base + (1.0 - base) * grazing);
            let below = dielectric * (1.0 - self.metallic) + metal * self.metallic;
            PI * light[2] * (below * (1.0 - coat) + clearcoat / share_of_coat * coat)
        })
    }
}

/// The share of white light from all around that facets which absorb nothing reflect to the eye once, by what the renderer shows of
/// a black metal, b, and of a grey one, (a/2 + b) (1 + (1/(a + b) - 1)/2).
fn share_of(roughness: f64, view: V) -> f64 {
    let [b, grey] = [0.0, 0.5].map(|base| {
        let metal = Plain { base: [base; 3], metallic: 1.0, roughness, ..PLAIN };
        let mut scene = onto(view, [0.0, 0.0, 1.0], json!({ "it": metal.json() }), json!([quad(0.0, "it")]));
        (scene["ambient"], scene["lights"]) = (json!(1), json!([]));
        f64::from(pixels(scene, "double")[0][0])
    });
    let middle = 4.0 * grey - 1.0 - b;
    (middle + (middle * middle - 4.0 * b).sqrt()) / 2.0
}

/// D V.
fn ggx(roughness: f64, nl: f64, nv: f64, nh: f64) -> f64 {
    let a = (roughness * roughness).max(1.0 / 1024.0).powi(2);
    let d = a / (PI * (nh * nh * (a - 1.0) + 1.0).powi(2));
    let v = |c: f64| 1.0 / (c + (a + (1.0 - a) * c * c).sqrt());
    d * v(nl) * v(nv)
}

fn direction(degrees: f64, around: f64) -> V {
    let ((sin, cos), (across, along)) = (degrees.to_radians().sin_cos(), around.to_radians().sin_cos());
    [sin * along, sin * across, cos]
}

pub(super) fn quad(z: f64, material: &str) -> Value {
    json!({ "quad": { "vertices": [[-99, -99, z], [99, -99, z], [99, 99, z], [-99, 99, z]], "material": material } })
}

/// One pixel that looks from a direction onto the plane z = 0, under a light from another one.
fn onto(view: V, light: V, materials: Value, objects: Value) -> Value {
    json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "orthographic": { "eye": view, "look_at": [0, 0, 0], "up": [0, 1, 0.1], "height": 1e-3 } },
        "ambient": 0,
        "lights": [{ "directional": { "direction": light.map(|x| -x), "color": [1, 0.5, 2] } }],
        "materials": materials,
        "objects": objects
    })
}

#[track_caller]
pub(super) fn shows(description: &Value, expected: V, off: f64, what: &str) {
    for precision in ["single", "double"] {
        let pixel = pixels(description.clone(), precision)[0].map(f64::from);
        for (got, expected) in pixel.into_iter().zip(expected) {
            assert!(
                (got - expected).abs() <= off * (1.0 + expected),
                "{what}, {precision}: {got} instead of {expected}"
            );
        }
    }
}

#[test]
fn lights_are_reflected_as_the_formulas_say() {
    let materials = [
        PLAIN,
        Plain { metallic: 1.0, roughness: 0.3, ..PLAIN },
        Plain { metallic: 0.4, roughness: 1.0, ..PLAIN },
        Plain { specular: 0.5, tint: [1.0, 0.2, 0.0], ior: 2.0, roughness: 0.2, ..PLAIN },
        Plain { coat: [0.7, 0.3], roughness: 0.6, ..PLAIN },
        Plain { coat: [1.0, 0.5], metallic: 1.0, roughness: 0.8, ..PLAIN },
        Plain { base: [0.0; 3], tint: [25.0, 5.0, 0.5], roughness: 0.7, ..PLAIN },
    ];
    for (i, material) in materials.iter().enumerate() {
        for (degrees, light, around) in [(0.0, 30.0, 0.0), (40.0, 45.0, 180.0), (40.0, 60.0, 90.0), (75.0, 70.0, 175.0)]
        {
            let (view, light) = (direction(degrees, 0.0), direction(light, around));
            let scene = onto(view, light, json!({ "it": material.json() }), json!([quad(0.0, "it")]));
            let reflected = material.reflected(light, view);
            let expected = [reflected[0], reflected[1] * 0.5, reflected[2] * 2.0];
            shows(&scene, expected, 1e-5, &format!("material {i} from {degrees}"));
        }
    }
}

#[test]
fn narrow_highlights_lose_no_digits() {
    // At roughness 0.1 the lobe is 0.6 degrees wide.
    let material = Plain { roughness: 0.1, metallic: 1.0, ..PLAIN };
    let view = direction(30.0, 0.0);
    for off in [0.0, 0.2, 0.6, 1.5] {
        let light = direction(30.0 + off, 180.0);
        let scene = onto(view, light, json!({ "it": material.json() }), json!([quad(0.0, "it")]));
        let reflected = material.reflected(light, view);
        shows(&scene, [reflected[0], reflected[1] * 0.5, reflected[2] * 2.0], 2e-3, &format!("{off} degrees off"));
    }
}

/// White furnace: light of 1 from everywhere leaves a white surface as it came, and is never more.
#[test]
fn white_surfaces_neither_lose_nor_make_light() {
    for (metallic, roughness, coat) in
        [(0.0, 0.3, 0.0), (0.0, 1.0, 0.0), (0.0, 0.6, 1.0), (1.0, 0.4, 0.0), (1.0, 1.0, 0.0), (0.5, 0.8, 0.5)]
    {
        for degrees in [0.0, 45.0, 80.0] {
            let material = Plain { base: [1.0; 3], metallic, roughness, coat: [coat, 0.5], ..PLAIN };
            let mut scene = onto(
                direction(degrees, 0.0),
                [0.0, 0.0, 1.0],
                json!({ "it": material.json() }),
                json!([quad(0.0, "it")]),
            );
            (scene["ambient"], scene["lights"]) = (json!(1), json!([]));
            for precision in ["single", "double"] {
                let [red, ..] = pixels(scene.clone(), precision)[0];
                assert!(red <= 1.0 + 1e-6, "{metallic} {roughness} {coat} at {degrees}: {red}");
                assert!(red > 1.0 - 1e-6, "{metallic} {roughness} {coat} at {degrees}: {red}");
            }
        }
    }
}

#[test]
fn smooth_metals_mirror_by_schlick_and_rough_ones_do_not() {
    for degrees in [0.0, 50.0, 80.0] {
        let view = direction(degrees, 0.0);
        let grazing = (1.0 - view[2]).powi(5);
        let scene = |roughness: f64| {
            let material = Plain { metallic: 1.0, roughness, ..PLAIN };
            let mut scene = onto(view, [0.0, 0.0, 1.0], json!({ "it": material.json() }), json!([quad(0.0, "it")]));
            (scene["background"], scene["lights"]) = (json!([1, 0.5, 0.25]), json!([]));
            scene
        };
        let mirrored = PLAIN.base.map(|base| base + (1.0 - base) * grazing);
        shows(&scene(0.04), [mirrored[0], mirrored[1] * 0.5, mirrored[2] * 0.25], 2e-6, "smooth");
        shows(&scene(0.2), [0.0; 3], 0.0, "rough");
    }
}

/// A color above 1 makes a dielectric reflect more than its index of refraction, at most all.
#[test]
fn bright_colors_of_reflections_mirror_as_metals_do() {
    for degrees in [0.0, 60.0] {
        let view = direction(degrees, 0.0);
        let material = Plain { base: [0.0; 3], roughness: 0.0, tint: [25.0, 12.5, 100.0], ..PLAIN };
        let mut scene = onto(view, [0.0, 0.0, 1.0], json!({ "it": material.json() }), json!([quad(0.0, "it")]));
        (scene["background"], scene["lights"]) = (json!([1, 0.5, 0.25]), json!([]));
        let grazing = (1.0 - view[2]).powi(5);
        shows(&scene, [1.0, 0.5 * (0.5 + 0.5 * grazing), 0.25], 2e-6, "spec-gloss chrome");
    }
}

/// Between a mirror and blurred surroundings clearcoat fades, and switches nowhere.
#[test]
fn clearcoat_fades_from_mirror_to_blur() {
    let mirrored = |roughness: f64| {
        let material = Plain { base: [0.0; 3], specular: 0.0, coat: [1.0, roughness], ..PLAIN };
        let view = [0.0, 0.0, 1.0];
        let mut scene = onto(view, view, json!({ "it": material.json() }), json!([quad(0.0, "it")]));
        (scene["background"], scene["lights"]) = (json!(1), json!([]));
        f64::from(pixels(scene, "double")[0][0])
    };
    for (roughness, share) in [(0.0, 1.0), (0.08, 1.0), (0.0975, 0.84375), (0.115, 0.5), (0.15, 0.0), (0.5, 0.0)] {
        let shown = mirrored(roughness);
        assert!((shown - 0.04 * share).abs() < 1e-7, "{roughness}: {shown}");
    }
}

pub(super) fn in_url(picture: &RgbaImage) -> String {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
    format!("data:image/png;base64,{}", BASE64.encode(bytes.get_ref()))
}

/// One pixel of unlit or glowing surfaces, straight in front of (x, y).
pub(super) fn in_front_of(x: f64, y: f64, materials: Value, objects: Value) -> Value {
    json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "orthographic": { "eye": [x, y, 5], "look_at": [x, y, 0], "height": 1e-3 } },
        "ambient": 0, "lights": [], "materials": materials, "objects": objects
    })
}

#[test]
fn layers_that_are_partly_there_need_no_order() {
    let glow =
        |color: V, alpha: f64| json!({ "pbr": { "unlit": true, "base_color": color, "opacity": { "alpha": alpha } } });
    let materials = json!({
        "near": glow([1.0, 0.0, 0.0], 0.25), "middle": glow([0.0, 1.0, 0.0], 0.5), "far": { "pbr": { "unlit": true } }
    });
    let layers = [quad(2.0, "near"), quad(1.0, "middle"), quad(0.0, "far")];
    let expected = [0.25 + 0.75 * 0.5, 0.75 * 0.5 + 0.75 * 0.5, 0.75 * 0.5];
    for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
        let objects = order.map(|i: usize| layers[i].clone());
        shows(&in_front_of(0.0, 0.0, materials.clone(), json!(objects)), expected, 1e-6, &format!("{order:?}"));
    }
    // Where only camera rays are followed, what lies behind is missing, and the bound says so.
    let mut cut = in_front_of(0.0, 0.0, materials, json!(layers));
    cut["render"] = json!({ "accuracy": { "fixed": {} }, "max_depth": 1, "antialias": false });
    shows(&cut, [0.25, 0.0, 0.0], 1e-6, "cut");
}

#[test]
fn light_goes_through_holes() {
    let materials = json!({
        "floor": { "diffuse": 1 },
        "veil": { "pbr": { "base_color": 0, "opacity": { "alpha": 0.25 } } },
        "mask": { "pbr": { "opacity": { "alpha": 0.25, "mode": "mask" } } },
        "solid": { "pbr": { "opacity": { "alpha": 0.75, "mode": "mask" } } }
    });
    for (above, share) in
        [(vec!["veil"], 0.75), (vec!["veil", "veil"], 0.5625), (vec!["mask"], 1.0), (vec!["mask", "solid"], 0.0)]
    {
        let shades: Vec<Value> = (1..)
            .zip(&above)
            .map(|(z, name)| {
                let z = f64::from(z);
                json!({ "quad": { "vertices": [[1, -1, z], [9, -1, z], [9, 1, z], [1, 1, z]], "material": name } })
            })
            .collect();
        // Light comes from the right, by way of the shades, which the camera does not look through.
        let light = unit([2.0, 0.0, 1.0]);
        let mut objects = vec![quad(0.0, "floor")];
        objects.extend(shades);
        let scene = onto([0.0, 0.0, 1.0], light, materials.clone(), json!(objects));
        let lit = share * light[2];
        shows(&scene, [lit, lit * 0.5, lit * 2.0], 1e-5, &format!("{above:?}"));
    }
}

#[test]
fn thin_walls_let_light_straight_through() {
    let wall = |extra: Value| {
        let mut pbr =
            json!({ "metallic": 0, "roughness": 0, "transmission": 1, "base_color": [1, 0.5, 0.25], "thin": true });
        pbr.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
        json!({ "it": { "pbr": pbr }, "behind": { "pbr": { "unlit": true } } })
    };
    // Through both walls of a closed box, which a body would bend.
    let objects =
        json!([{ "box": { "min": [-3, -3, 0.2], "max": [3, 3, 0.5], "material": "it" } }, quad(0.0, "behind")]);
    let view = direction(30.0, 0.0);
    let through = |materials: Value| {
        let mut scene = onto(view, [0.0, 0.0, 1.0], materials, objects.clone());
        scene["lights"] = json!([]);
        scene["render"] = json!({ "accuracy": { "fixed": {} }, "max_depth": 3 });
        scene
    };
    let reflectance = |degrees: f64, ior: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let inner = (1.0 - (sin / ior).powi(2)).sqrt();
        let (s, p) = ((cos - ior * inner) / (cos + ior * inner), (ior * cos - inner) / (ior * cos + inner));
        0.5 * (s * s + p * p)
    };
    let once = 1.0 - reflectance(30.0, 1.5);
    let twice = [1.0, 0.5, 0.25].map(|color: f64| (color * once).powi(2));
    shows(&through(wall(json!({}))), twice, 1e-5, "straight");
    assert!(!effects(&through(wall(json!({})))).has(Effect::Refraction));
    assert!(effects(&through(wall(json!({ "thin": false })))).has(Effect::Refraction));
}

#[test]
fn a_body_lets_its_attenuation_color_pass_over_its_distance() {
    let materials = json!({
        "it": { "pbr": {
            "metallic": 0, "roughness": 0, "transmission": 1, "ior": 1,
            "attenuation": { "color": [0.9, 0.5, 0.1], "distance": 2 }
        } },
        "behind": { "pbr": { "unlit": true } }
    });
    let objects = json!([{ "box": { "min": [-3, -3, 1], "max": [3, 3, 4], "material": "it" } }, quad(0.0, "behind")]);
    let expected = [0.9f64, 0.5, 0.1].map(|color| color.powf(1.5));
    shows(&in_front_of(0.0, 0.0, materials, objects), expected, 1e-5, "three units of it");
}

#[test]
fn what_is_written_wrong_is_said_with_its_place() {
    let with = |pbr: Value, more: Value| {
        let mut material = json!({ "pbr": pbr });
        material.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        problems(&in_front_of(0.0, 0.0, json!({ "it": material }), json!([quad(0.0, "it")])))
    };
    let none = json!({});
    assert_eq!(with(json!({}), json!({ "one_sided": true })), [""; 0]);
    assert_eq!(with(json!({}), json!({ "diffuse": 0.5 })), ["/materials/it/pbr"]);
    assert_eq!(with(json!({ "metallic": 2 }), none.clone()), ["/materials/it/pbr/metallic"]);
    assert_eq!(with(json!({ "base_color": [1, 2, 0] }), none.clone()), ["/materials/it/pbr/base_color"]);
    assert_eq!(with(json!({ "roughnes": 1 }), none.clone()), ["/materials/it/pbr/roughnes"]);
    let url = in_url(&RgbaImage::new(1, 1));
    let channel = json!({ "base_color": { "image": url, "channel": "g" } });
    assert!(with(channel, none.clone()).contains(&"/materials/it/pbr/base_color/channel".to_owned()));
    let without_uvs = with(json!({ "roughness": { "image": url } }), none.clone());
    assert_eq!(without_uvs, ["/objects/0/quad/material"]);
    let absorbs_all = json!({ "attenuation": { "color": 0, "distance": 1 } });
    assert_eq!(with(absorbs_all, none), ["/materials/it/pbr/attenuation/color"]);
}

#[test]
fn lights_with_a_range_fade_as_gltf_says() {
    for (distance, range) in [(1.0, 2.0), (1.9, 2.0), (3.0, 2.0), (0.5, 100.0)] {
        let mut scene =
            onto([0.0, 0.0, 0.1], [0.0, 0.0, 1.0], json!({ "it": { "diffuse": 1 } }), json!([quad(0.0, "it")]));
        let falloff = json!({ "windowed": { "range": range } });
        scene["lights"] = json!([{ "point": { "position": [0, 0, distance], "falloff": falloff } }]);
        let expected = f64::max(0.0, 1.0 - f64::powi(distance / range, 4)) / (distance * distance);
        shows(&scene, [expected; 3], 1e-5, &format!("{distance} of {range}"));
    }
    let mut scene = onto([0.0, 0.0, 0.1], [0.0, 0.0, 1.0], json!({ "it": {} }), json!([quad(0.0, "it")]));
    scene["lights"] = json!([{ "point": { "position": [0, 0, 1], "falloff": { "windowed": { "range": 0 } } } }]);
    assert_eq!(problems(&scene), ["/lights/0/point/falloff/windowed/range"]);
}

/// Gathered light takes the place of the ambient light that surfaces scatter. What the wide lobes of metal reflect is not gathered,
/// so it stays, beside a surface that scatters and alone.
#[test]
fn rough_metal_keeps_ambient_light_where_light_is_gathered() {
    let metal = json!({ "pbr": { "base_color": [0.8, 0.5, 0.2], "metallic": 1, "roughness": 1 } });
    let scene = |gathers: bool, beside: &Value| {
        json!({
            "version": 1, "image": { "width": 2, "height": 1 }, "ambient": 0.5, "lights": [],
            "camera": { "orthographic": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "height": 1 } },
            "materials": { "metal": metal, "beside": beside },
            "objects": [
                { "disc": { "center": [-0.5, 0, 0], "normal": [0, 0, 1], "radius": 0.4, "material": "metal" } },
                { "disc": { "center": [0.5, 0, 0], "normal": [0, 0, 1], "radius": 0.4, "material": "beside" } }
            ],
            "render": { "antialias": false, "color_bleeding": gathers, "samples": 4 }
        })
    };
    for (beside, precision) in
        [&metal, &json!({ "diffuse": 0.5 })].iter().flat_map(|b| ["single", "double"].map(|p| (*b, p)))
    {
        let [ambient, gathered] = [false, true].map(|gathers| pixels(scene(gathers, beside), precision)[0]);
        assert!(ambient[0] > 0.2 && ambient[0] > ambient[1] && ambient[1] > ambient[2], "{precision}: {ambient:?}");
        let same = ambient.iter().zip(gathered).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(same, "{precision}, beside {beside}: {ambient:?} {gathered:?}");
    }
}
