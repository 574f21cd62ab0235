//! Light from the surroundings without samples, against integrals, and metallic-roughness materials in whole pictures.

use super::textures::url;
use super::*;
use crate::common::Random;
use fearless_simd::Level;
use image::{Rgb, RgbImage};
use std::f64::consts::PI;
use strahl::film::srgb::code8;
use strahl::render::{RenderOptions, render_with};

/// One pixel that looks from a direction onto a plane through the origin with a unit normal.
fn onto(normal: [f64; 3], view: [f64; 3], material: Value, environment: Value) -> Value {
    json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "orthographic": { "eye": view, "look_at": [0, 0, 0], "up": [0.3, 0.9, 0.1], "height": 1e-3 } },
        "ambient": 0, "lights": [], "environment": environment,
        "materials": { "it": material },
        "objects": [{ "disc": { "center": [0, 0, 0], "normal": normal, "radius": 9, "material": "it" } }]
    })
}

/// Radiance of the clear sky of these tests by the height of a direction.
fn sky(height: f64) -> f64 {
    let low = 1.0 - height.clamp(-1.0, 1.0).asin() / (PI / 2.0);
    if height < 0.0 { 0.2 } else { 0.3 + 0.7 * low.powi(3) }
}

const SKY: &str = r#"{ "sky": { "zenith": 0.3, "horizon": 1, "ground": 0.2 }, "light": "fast" }"#;

fn environment() -> Value {
    serde_json::from_str(SKY).unwrap()
}

/// The mean of the sky over directions, with a weight for each.
fn mean(weight: impl Fn([f64; 3]) -> f64) -> f64 {
    let (mut light, mut all) = (0.0, 0.0);
    for row in 0..360 {
        let height = (f64::from(row) + 0.5) / 180.0 - 1.0;
        for column in 0..360 {
            let (sin, cos) = f64::from(column).to_radians().sin_cos();
            let flat = (1.0 - height * height).sqrt();
            let w = weight([flat * sin, height, flat * cos]);
            (light, all) = (light + w * sky(height), all + w);
        }
    }
    light / all
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A round lamp at the zenith, 10.8 degrees wide, in pictures of any height. Nine coefficients show a small lamp overhead as 17/16 of
/// what it is.
#[test]
fn a_small_lamp_overhead_is_as_bright_whatever_the_height_of_the_picture() {
    let lamp = |height: u32| {
        let rows = 3 * height / 100;
        let picture = RgbImage::from_fn(2 * height, height, |_, y| Rgb([if y < rows { 255 } else { 0 }; 3]));
        json!({ "image": url(picture), "intensity": 50, "light": "fast" })
    };
    let up = [0.0, 1.0, 0.0];
    let seen = |material: Value, height: u32| f64::from(pixels(onto(up, up, material, lamp(height)), "double")[0][0]);
    let exact = 50.0 * (0.03 * PI).sin().powi(2);
    let metal = |roughness: f64| json!({ "pbr": { "base_color": 1, "metallic": 1, "roughness": roughness } });
    let rough = [0.4, 0.7].map(|roughness| seen(metal(roughness), 100));
    for height in [100, 200, 400, 600, 1000] {
        let white = seen(json!({ "diffuse": 1 }), height);
        assert!((white / exact / 1.0625 - 1.0).abs() < 0.04, "{height}: {white} for {exact}");
        for (roughness, expected) in [0.4, 0.7].into_iter().zip(rough) {
            let got = seen(metal(roughness), height);
            assert!((got / expected - 1.0).abs() < 0.08, "{height}, {roughness}: {got} for {expected}");
        }
    }
}

/// Nine coefficients are at most 3.1 % of the brightest off (Ramamoorthi and Hanrahan), of this sky far less.
#[test]
fn what_surfaces_scatter_is_the_integral() {
    for normal in [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.6, 0.8, 0.0], [0.0, -0.6, 0.8]] {
        let expected = mean(|dir| dot(dir, normal).max(0.0));
        for material in
            [json!({ "diffuse": 0.5 }), json!({ "pbr": { "metallic": 0, "base_color": 0.5, "specular": 0 } })]
        {
            for precision in ["single", "double"] {
                let [got, ..] = pixels(onto(normal, normal, material.clone(), environment()), precision)[0];
                let off = (f64::from(got) / 0.5 - expected).abs();
                assert!(off < 0.02, "{normal:?}: {got} for {expected}");
            }
        }
    }
}

/// The lobe of a rough mirror that is seen head on: the distribution of its facets, by the halfway vector.
#[test]
fn rough_metals_reflect_blurred_surroundings() {
    for (roughness, most) in [(0.2, 0.01), (0.5, 0.02), (0.8, 0.03), (1.0, 0.03)] {
        for normal in [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.6, 0.8, 0.0], [0.8, -0.6, 0.0], [1.0, 0.0, 0.0]] {
            let a = f64::powi(roughness, 4);
            let g1 = |c: f64| 2.0 * c / (c + (a + (1.0 - a) * c * c).sqrt());
            let expected = mean(|dir| {
                let nl = dot(dir, normal);
                let nh = ((1.0 + nl) / 2.0).max(0.0).sqrt();
                let d = a / (nh * nh * (a - 1.0) + 1.0).powi(2);
                if nl > 0.0 { d * g1(nl) } else { 0.0 }
            });
            let material = json!({ "pbr": { "roughness": roughness } });
            let mut white = onto(normal, normal, material.clone(), Value::Null);
            white["ambient"] = json!(1);
            for precision in ["single", "double"] {
                let reflected = f64::from(pixels(white.clone(), precision)[0][0]);
                let got = f64::from(pixels(onto(normal, normal, material.clone(), environment()), precision)[0][0]);
                let off = (got / reflected - expected).abs();
                assert!(off < most, "{roughness} {normal:?}: {} for {expected}", got / reflected);
            }
        }
    }
}

#[test]
fn surroundings_of_one_color_are_ambient_light() {
    let one = json!({ "image": url(RgbImage::from_pixel(2, 2, Rgb([188, 188, 188]))), "light": "fast" });
    let material = json!({ "pbr": { "metallic": 0.3, "roughness": 0.4, "base_color": [0.9, 0.5, 0.1] } });
    let up = [0.0, 1.0, 0.0];
    let lit = pixels(onto(up, up, material.clone(), one.clone()), "double")[0];
    let mut ambient = onto(up, up, material, Value::Null);
    ambient["ambient"] = json!("#bcbcbc");
    for (lit, expected) in lit.into_iter().zip(pixels(ambient, "double")[0]) {
        assert!((lit - expected).abs() < 1e-6, "{lit} for {expected}");
    }
    assert!(!effects(&onto(up, up, json!({}), one)).has(Effect::EnvironmentLight));
}

#[test]
fn an_environment_that_lights_nothing_is_as_before() {
    let up = [0.0, 1.0, 0.0];
    let mut dark = environment();
    dark["light"] = json!("none");
    let scene = onto(up, up, json!({ "pbr": {} }), dark);
    assert!(!effects(&scene).has(Effect::EnvironmentLight));
    assert_eq!(pixels(scene, "single")[0], [0.0; 3]);
    let both = json!({ "sky": {}, "studio": {} });
    assert_eq!(problems(&onto(up, up, json!({}), both)), ["/environment/studio"]);
    assert_eq!(problems(&onto(up, up, json!({}), json!({ "light": "fast" }))), ["/environment"]);
}

/// Balls and sheets of all kinds of materials in a studio, under two lamps.
pub(super) fn model(seed: u64) -> Value {
    let mut random = Random::new(seed);
    let r = &mut random;
    let mut materials = serde_json::Map::new();
    for i in 0..4 {
        let share = |r: &mut Random| [0.0, 1.0, r.between(0.0, 1.0)][r.below(3)];
        let color: [f64; 3] = std::array::from_fn(|_| r.between(0.0, 0.95));
        let mut pbr = json!({
            "base_color": color, "metallic": share(r), "roughness": ([0.0, 0.08, r.between(0.1, 1.0)][r.below(3)]),
            "clearcoat": ([0.0, 0.0, 1.0][r.below(3)]), "clearcoat_roughness": ([0.0, 0.4][r.below(2)]),
            "transmission": ([0.0, 0.0, 0.9][r.below(3)]), "thin": r.below(2) == 0
        });
        match r.below(6) {
            0 => pbr["opacity"] = json!({ "alpha": r.between(0.1, 0.9) }),
            1 => pbr["emissive"] = json!(color),
            2 => pbr["unlit"] = json!(true),
            _ => {}
        }
        materials.insert(format!("m{i}"), json!({ "pbr": pbr }));
    }
    let name = |r: &mut Random| format!("m{}", r.below(4));
    let mut objects: Vec<Value> = (0..5)
        .map(|_| json!({ "sphere": { "center": r.point(2.0), "radius": r.between(0.3, 1.0), "material": name(r) } }))
        .collect();
    objects.push(json!({ "disc": { "center": [0, -2, 0], "normal": [0, 1, 0], "radius": 5, "material": name(r) } }));
    json!({
        "version": 1, "image": { "width": 24, "height": 16 },
        "camera": { "pinhole": { "eye": [0.5, 0.8, 6.0], "look_at": [0, 0, 0], "vfov_deg": 50 } },
        "ambient": 0, "environment": { "studio": {}, "light": "fast" },
        "lights": [
            { "directional": { "direction": [1, -2, -1.5] } },
            { "point": { "position": [-2, 3, 4], "intensity": 9, "falloff": "inverse_square" } }
        ],
        "materials": materials, "objects": objects,
        "render": { "antialias": false }
    })
}

/// What the fixed mode says that it cuts off at most is held against pictures whose rays were followed far further.
#[test]
fn bounds_hold_for_models() {
    for seed in 0..60 {
        let with = |depth: u32, weight: f64| {
            let mut scene = model(seed);
            scene["render"]["max_depth"] = json!(depth);
            scene["render"]["min_weight"] = json!(weight);
            scene
        };
        let proved = |depth: u32| {
            let mut scene = model(seed);
            scene["render"]["max_depth"] = json!(depth);
            scene["render"]["accuracy"] = json!({ "proved": { "max_codes": 1 } });
            picture(&super::scene(scene, "double")).film.pixels
        };
        let truth = pixels(with(6, 0.0), "double");
        for (got, truth) in proved(6).iter().zip(&truth) {
            for c in 0..3 {
                let off = code8(got[c]).abs_diff(code8(truth[c]));
                assert!(off <= 1, "seed {seed}: {got:?} for {truth:?}");
            }
        }
    }
}

#[test]
fn models_are_the_same_bytes_in_any_tiles_and_on_any_instructions() {
    for seed in 0..8 {
        for precision in ["single", "double"] {
            let scene = scene(model(seed), precision);
            let region = Region::whole(scene.width, scene.height);
            let as_cut = |tile: u32, level: Level, specialised: bool| {
                let options = RenderOptions { tile, level, specialised };
                render_with(&scene, region, &Control::default(), options).unwrap().film.pixels
            };
            let whole = as_cut(32, Level::new(), true);
            assert_eq!(as_cut(5, Level::new(), false), whole, "{seed} {precision}");
            if let Some(least) = Level::new().as_sse2() {
                assert_eq!(as_cut(7, Level::Sse2(least), true), whole, "{seed} {precision}");
            }
        }
    }
}

/// Alpha by its definition: over any background the picture is what it would be with that background.
#[test]
fn the_picture_of_a_model_lies_over_any_background() {
    let materials = json!({
        "veil": { "pbr": { "roughness": 0.5, "base_color": [0.2, 0.5, 0.9], "opacity": { "alpha": 0.4 } } },
        "glass": { "pbr": { "metallic": 0, "roughness": 0.3, "transmission": 1, "thin": true, "specular": 0.5 } },
        "solid": { "pbr": { "metallic": 0, "roughness": 0.5 } }
    });
    let objects = json!([
        { "sphere": { "center": [-1.2, 0, 0], "radius": 0.9, "material": "veil" } },
        { "sphere": { "center": [1.2, 0, 0], "radius": 0.9, "material": "glass" } },
        { "box": { "min": [-3, -1, -2], "max": [0, -0.2, -1], "material": "solid" } }
    ]);
    let over = |background: Value, film: Value| {
        json!({
            "version": 1, "image": { "width": 48, "height": 24 },
            "camera": { "pinhole": { "eye": [0, 0, 6], "look_at": [0, 0, 0], "vfov_deg": 30 } },
            "background": background, "film": film, "materials": materials, "objects": objects,
            "render": { "samples": 16 }
        })
    };
    for background in [1.0, 0.3] {
        let opaque = pixels(over(json!(background), json!({})), "single");
        let film = picture(&scene(over(json!(0), json!({ "background": "transparent" })), "single")).film;
        let mut between = 0;
        for ((pixel, alpha), expected) in film.pixels.iter().zip(&film.alpha).zip(&opaque) {
            between += u32::from(*alpha > 0.05 && *alpha < 0.95);
            for c in 0..3 {
                let shown = pixel[c] + (1.0 - alpha) * background as f32;
                let off = code8(shown).abs_diff(code8(expected[c]));
                assert!(off <= 1, "{shown} for {}", expected[c]);
            }
        }
        assert!(between > 100, "{between} pixels are partly there");
    }
}
