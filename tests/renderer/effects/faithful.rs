//! Light that rays bring to each lobe: against closed forms, against the light without rays, and against itself without the search
//! for what is bright.

use super::*;
use data_encoding::BASE64;
use fearless_simd::Level;
use image::codecs::hdr::HdrEncoder;
use image::{ImageFormat, Rgb, Rgb32FImage};
use std::f64::consts::PI;
use std::io::Cursor;
use strahl::film::srgb::code8;
use strahl::render::{RenderOptions, render_with};
use strahl::scene::effects::State;

/// The mean of a picture.
pub(super) fn mean(pixels: &[[f32; 3]]) -> [f64; 3] {
    std::array::from_fn(|c| pixels.iter().map(|pixel| f64::from(pixel[c])).sum::<f64>() / pixels.len() as f64)
}

pub(super) fn faithful(depth: u32, samples: u32) -> Value {
    json!({ "fidelity": "faithful", "max_depth": depth, "min_weight": 1e-5, "samples": samples, "antialias": false })
}

/// A ball that fills the picture, alone in surroundings.
pub(super) fn ball(material: Value, around: Value, render: Value) -> Value {
    let mut scene = json!({
        "version": 1, "image": { "width": 16, "height": 16 },
        "camera": { "orthographic": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "height": 1.3 } },
        "ambient": 0, "lights": [], "materials": { "it": material },
        "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "it" } }],
        "render": render
    });
    scene.as_object_mut().unwrap().extend(around.as_object().unwrap().clone());
    scene
}

/// What glows is looked for in a definition as often as it is placed, but only if it holds any lamp, and at most some million times:
/// ten instances of ten instances, and so on, would never end.
#[test]
fn lamps_are_not_looked_for_in_each_of_many_instances() {
    let with = |innermost: Value| {
        let mut definitions = json!({ "d0": [innermost] });
        for level in 1..=15 {
            let below = json!({ "instance": { "of": format!("d{}", level - 1), "transform": { "translate": [0, 0, -level] } } });
            definitions[format!("d{level}")] = json!(vec![below; 10]);
        }
        json!({
            "version": 1, "image": { "width": 4, "height": 4 },
            "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0, 0] } }, "lights": [],
            "materials": { "glow": { "diffuse": 0, "emission": 2 }, "dark": { "diffuse": 0.5 } },
            "definitions": definitions,
            "objects": [
                { "instance": { "of": "d15" } },
                { "triangle": { "vertices": [[-1, 2, 0], [1, 2, 0], [0, 2, 1]], "material": "glow" } }
            ],
            "render": { "fidelity": "faithful" }
        })
    };
    let looks_for_lamps = |innermost: Value| {
        let scene = scene(with(innermost), "single");
        scene.effects.iter().find(|entry| entry.effect.name() == "emitter_sampling").unwrap().state == State::On
    };
    let ball = |material: &str| json!({ "sphere": { "center": [0, 0, 0], "radius": 0.1, "material": material } });
    assert!(looks_for_lamps(ball("dark")));
    assert!(!looks_for_lamps(ball("glow")), "too many");
}

/// Facets send no sample more than what comes: between rough metals it would grow with each bounce, and no ceiling would hold.
#[test]
fn proofs_hold_between_rough_surfaces() {
    let wall = |corners: [[i32; 3]; 4]| json!({ "quad": { "vertices": corners, "material": "it" } });
    for (metallic, roughness) in [(1.0, 1.0), (1.0, 0.6), (0.0, 1.0)] {
        for light in [0.02, 0.1] {
            let scene = |accuracy: Value, weight: Value| {
                let mut scene = json!({
                    "version": 1, "image": { "width": 40, "height": 30 },
                    "camera": { "pinhole": { "eye": [0, 1, 3.5], "look_at": [0, 1, 0], "vfov_deg": 50 } },
                    "background": light, "lights": [],
                    "materials": {
                        "it": { "pbr": { "metallic": metallic, "roughness": roughness } },
                        "glow": { "diffuse": 0, "emission": 0.001 }
                    },
                    "objects": [
                        wall([[-4, 0, -4], [4, 0, -4], [4, 0, 4], [-4, 0, 4]]),
                        wall([[-4, 2, -4], [4, 2, -4], [4, 2, 4], [-4, 2, 4]]),
                        wall([[-2, 0, -4], [-2, 2, -4], [-2, 2, 4], [-2, 0, 4]]),
                        wall([[2, 0, -4], [2, 2, -4], [2, 2, 4], [2, 0, 4]]),
                        { "sphere": { "center": [0, 0.6, 0], "radius": 0.5, "material": "it" } },
                        { "sphere": { "center": [1, 0.3, 0], "radius": 0.1, "material": "glow" } }
                    ],
                    "render": { "samples": 4, "antialias": false, "fidelity": "faithful", "accuracy": accuracy }
                });
                scene["render"].as_object_mut().unwrap().extend(weight.as_object().unwrap().clone());
                super::scene(scene, "double")
            };
            let proved = picture(&scene(json!({ "proved": { "max_codes": 1 } }), json!({})));
            assert!(proved.proof().max_codes <= 1, "metallic {metallic}, roughness {roughness}: {:?}", proved.proof());
            let proved = proved.film.pixels;
            let whole = picture(&scene(json!({ "fixed": {} }), json!({ "max_depth": 10, "min_weight": 0 })));
            let whole = whole.film.pixels;
            let code = |x: f32| i32::from(code8(x));
            let off = proved.iter().flatten().zip(whole.iter().flatten()).map(|(a, b)| (code(*a) - code(*b)).abs());
            let most = off.max().unwrap();
            assert!(most <= 1, "metallic {metallic}, roughness {roughness}, light {light}: {most} codes");
        }
    }
}

/// In a closed box that glows and is grey all over, each wall sends E / (1 - a): what it emits and what it scatters of all others,
/// again and again. 16 rays leave out a^16 of it.
#[test]
fn a_closed_grey_box_is_as_bright_as_the_series_says() {
    let walls = [
        json!({ "diffuse": 0.5, "emission": 0.2 }),
        json!({ "pbr": { "base_color": 0.5, "metallic": 0, "specular": 0, "emissive": 0.2 } }),
    ];
    for wall in walls {
        let scene = json!({
            "version": 1, "image": { "width": 12, "height": 8 },
            "camera": { "pinhole": { "eye": [0.2, 0.1, 0.3], "look_at": [1, 0.4, -1], "vfov_deg": 80 } },
            "lights": [], "materials": { "wall": wall },
            "objects": [{ "box": { "min": [-1, -1, -1], "max": [1, 1, 1], "material": "wall", "hollow": true } }],
            "render": faithful(16, 64)
        });
        assert!(effects(&scene).has(Effect::EmitterSampling));
        for precision in ["single", "double"] {
            let all = pixels(scene.clone(), precision);
            for pixel in &all {
                assert!((pixel[0] - 0.4).abs() < 0.04, "{pixel:?}");
            }
            let [got, ..] = mean(&all);
            assert!((got - 0.4).abs() < 0.002, "{got}");
        }
    }
}

/// A floor under a glowing ball, and what stands far away.
fn under_a_ball(place: f64, more: &[Value], samples: u32) -> Value {
    let mut objects = vec![
        json!({ "sphere": { "center": [0, 4, 0], "radius": 1, "material": "lamp" } }),
        json!({ "disc": { "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 20, "material": "floor" } }),
    ];
    objects.extend_from_slice(more);
    json!({
        "version": 1, "image": { "width": 4, "height": 4 },
        "camera": { "orthographic": { "eye": [place + 6.0, 6, 9], "look_at": [place, 0, 0], "height": 0.01 } },
        "lights": [],
        "materials": { "lamp": { "diffuse": 0, "emission": [5, 4, 3] }, "floor": { "diffuse": 0.8 } },
        "objects": objects, "render": faithful(3, samples)
    })
}

/// The irradiance below a ball is pi L (R/d)^2 cos; with the search for points of it, and by chance alone.
#[test]
fn a_glowing_ball_lights_a_floor_by_the_closed_form() {
    // A ring is no lamp that is looked for, and then neither is the ball.
    let ring = json!({ "torus": { "center": [0, -50, 0], "axis": [0, 1, 0], "major_radius": 1, "minor_radius": 0.1,
        "material": "lamp" } });
    for (place, samples, more, most) in
        [(0.0, 256, vec![], 0.004), (3.0, 256, vec![], 0.004), (2.0, 1024, vec![ring], 0.08)]
    {
        let scene = under_a_ball(place, &more, samples);
        assert_eq!(effects(&scene).has(Effect::EmitterSampling), more.is_empty());
        let squared = 16.0 + place * place;
        let expected = 0.8 / squared * 4.0 / squared.sqrt();
        for precision in ["single", "double"] {
            let got = mean(&pixels(scene.clone(), precision));
            for (got, radiance) in got.into_iter().zip([5.0, 4.0, 3.0]) {
                let off = got / (radiance * expected) - 1.0;
                assert!(off.abs() < most, "{place}: {got} for {}", radiance * expected);
            }
        }
    }
}

/// A grey sky with a small sun, as Radiance HDR: 2 of 64 x 32 texels are as bright as all others together, many times.
fn sky_with_sun() -> String {
    let texel = |x: u32, y: u32| if y == 6 && (20..22).contains(&x) { Rgb([900.0; 3]) } else { Rgb([0.25; 3]) };
    let picture = Rgb32FImage::from_fn(64, 32, texel);
    let mut bytes = Vec::new();
    let pixels: Vec<_> = picture.pixels().copied().collect();
    HdrEncoder::new(&mut bytes).encode(&pixels, 64, 32).unwrap();
    format!("data:image/vnd.radiance;base64,{}", BASE64.encode(&bytes))
}

/// The light of the sun on a floor is that of its texels, and the samples that find it are not at the mercy of chance.
#[test]
fn the_sun_of_a_picture_of_high_dynamic_range_lights_a_floor() {
    // The lookup between texels is linear, so each texel counts as much as its own solid angle, to first order.
    let (row, width) = ((6.5 / 32.0) * PI, PI / 32.0);
    let sun = 2.0 * 900.0 * row.cos() * row.sin() * width * (2.0 * PI / 64.0);
    let expected = 0.8 / PI * (sun + 0.25 * PI);
    for (material, most) in [
        (json!({ "diffuse": 0.8 }), 0.02),
        (json!({ "pbr": { "base_color": 0.8, "metallic": 0, "specular": 0 } }), 0.02),
    ] {
        let scene = json!({
            "version": 1, "image": { "width": 8, "height": 8 },
            "camera": { "orthographic": { "eye": [3, 5, 4], "look_at": [0, 0, 0], "height": 1 } },
            "lights": [], "environment": { "image": sky_with_sun() }, "materials": { "it": material },
            "objects": [{ "disc": { "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 9, "material": "it" } }],
            "render": faithful(2, 64)
        });
        assert!(effects(&scene).has(Effect::EnvironmentSampling));
        for precision in ["single", "double"] {
            let all = pixels(scene.clone(), precision);
            let [got, ..] = mean(&all);
            assert!((got / expected - 1.0).abs() < most, "{got} for {expected}");
            // By chance, one ray of 500 would meet the sun: pixels would be off by as much as they are bright.
            let spread = all.iter().map(|pixel| (f64::from(pixel[0]) / got - 1.0).powi(2)).sum::<f64>() / 64.0;
            assert!(spread.sqrt() < 0.12, "{}", spread.sqrt());
        }
    }
}

#[test]
fn pictures_of_high_dynamic_range_are_for_surroundings_and_must_hold_light() {
    let scene = |image: String| ball(json!({ "pbr": {} }), json!({ "environment": { "image": image } }), json!({}));
    assert_eq!(problems(&scene(sky_with_sun())), Vec::<String>::new());
    let mut on_a_surface = scene(sky_with_sun());
    on_a_surface["materials"]["it"] =
        json!({ "diffuse": { "image": { "source": sky_with_sun(), "mapping": { "planar": {} } } } });
    assert_eq!(problems(&on_a_surface), ["/materials/it/diffuse/image/source"]);
    let exr = |value: f32| {
        let mut bytes = Cursor::new(Vec::new());
        let picture = Rgb32FImage::from_fn(4, 2, |x, _| Rgb([if x == 1 { value } else { 0.5 }; 3]));
        image::DynamicImage::from(picture).write_to(&mut bytes, ImageFormat::OpenExr).unwrap();
        format!("data:image/x-exr;base64,{}", BASE64.encode(bytes.get_ref()))
    };
    assert_eq!(problems(&scene(exr(40.0))), Vec::<String>::new());
    for wrong in [f32::NAN, f32::INFINITY, 1e12] {
        assert_eq!(problems(&scene(exr(wrong))), ["/environment/image"], "{wrong}");
    }
}

/// Alone in the studio, light without rays is close to that by rays: 8-bit codes of a mean over the ball.
#[test]
fn without_rays_the_light_of_a_studio_is_nearly_the_same() {
    let studio = json!({ "environment": { "studio": {}, "light": "fast" }, "film": { "tone": "khronos_pbr_neutral" } });
    for (metallic, roughness, most) in [
        (0.0, 0.2, 1.2),
        (0.0, 0.3, 1.2),
        (0.0, 0.5, 1.2),
        (0.0, 0.8, 1.2),
        (0.0, 1.0, 1.2),
        (1.0, 0.3, 7.0),
        (1.0, 0.8, 7.0),
    ] {
        let material =
            json!({ "pbr": { "metallic": metallic, "roughness": roughness, "base_color": [0.6, 0.4, 0.2] } });
        let fast = pixels(ball(material.clone(), studio.clone(), json!({ "samples": 16 })), "single");
        let slow = pixels(ball(material, studio.clone(), faithful(3, 256)), "single");
        let (mut off, mut count) = (0.0, 0.0);
        for (fast, slow) in fast.iter().zip(&slow) {
            for c in 0..3 {
                off += f64::from(code8(fast[c]).abs_diff(code8(slow[c])));
                count += 1.0;
            }
        }
        assert!(off / count < most, "{metallic} {roughness}: {} codes", off / count);
    }
}

/// A ball over a floor darkens it, and colors it: neither is there without rays.
#[test]
fn bodies_hide_and_color_each_others_light() {
    let scene = |fidelity: &str, color: Value| {
        json!({
            "version": 1, "image": { "width": 4, "height": 4 },
            "camera": { "orthographic": { "eye": [0, 3, 9], "look_at": [0, 0, 1.02], "height": 0.02 } },
            "ambient": 0, "lights": [], "background": 0,
            "environment": { "sky": { "zenith": 1, "horizon": 0.9, "ground": 0.5 }, "light": "fast" },
            "materials": {
                "floor": { "pbr": { "metallic": 0, "specular": 0 } },
                "ball": { "pbr": { "metallic": 0, "specular": 0, "base_color": color } }
            },
            "objects": [
                { "disc": { "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 50, "material": "floor" } },
                { "sphere": { "center": [0, 1, 0], "radius": 1, "material": "ball" } }
            ],
            "render": { "fidelity": fidelity, "samples": 256, "max_depth": 6, "min_weight": 1e-4 }
        })
    };
    let fast = mean(&pixels(scene("fast", json!(0)), "single"));
    let black = mean(&pixels(scene("faithful", json!(0)), "single"));
    let red = mean(&pixels(scene("faithful", json!([0.9, 0, 0])), "single"));
    assert!(black[0] < 0.85 * fast[0], "{black:?} {fast:?}");
    assert!(red[0] > 1.05 * black[0] && (red[1] / black[1] - 1.0).abs() < 0.02, "{red:?} {black:?}");
}

/// Rough glass spreads what is behind it, as a sheet and as a body, and keeps its light.
#[test]
fn rough_glass_spreads_light() {
    for thin in [true, false] {
        let glass = |roughness: f64| {
            let object = json!({ "box": { "min": [-9, -9, 0], "max": [9, 9, 0.2], "material": "glass" } });
            json!({
                "version": 1, "image": { "width": 8, "height": 1 },
                "camera": { "orthographic": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "height": 0.5 } },
                "lights": [], "background": 0,
                "materials": {
                    "glass": { "pbr": { "metallic": 0, "transmission": 1, "roughness": roughness, "thin": thin } },
                    "lamp": { "diffuse": 0, "emission": 1 }
                },
                "objects": [object, { "quad": {
                    "vertices": [[0, -50, -1], [50, -50, -1], [50, 50, -1], [0, 50, -1]], "material": "lamp"
                } }],
                "render": faithful(8, 256)
            })
        };
        let row =
            |roughness: f64| pixels(glass(roughness), "single").iter().map(|p| f64::from(p[0])).collect::<Vec<_>>();
        let (clear, frosted) = (row(0.0), row(0.5));
        assert!(clear[3] < 0.02 && clear[4] > 0.9, "{thin} {clear:?}");
        assert!(frosted[3] > 0.1 && frosted[4] < 0.8 && frosted[4] > frosted[3], "{thin} {frosted:?}");
    }
}

/// What is looked for and what rays find by chance are one light: a metal of any roughness in a sky with a sun is as bright with the
/// search as without.
#[test]
fn the_search_changes_no_mean() {
    let scene = |roughness: f64| {
        let material = json!({ "pbr": { "roughness": roughness, "base_color": [0.9, 0.7, 0.5] } });
        ball(material, json!({ "environment": { "studio": {} } }), faithful(3, 256))
    };
    for roughness in [0.15, 0.4, 1.0] {
        let with = super::scene(scene(roughness), "single");
        let without = with.without(Effect::EnvironmentSampling).unwrap();
        let (with, without) = (picture(&with).film.pixels, picture(&without).film.pixels);
        let (with, without) = (mean(&with), mean(&without));
        assert!((with[0] / without[0] - 1.0).abs() < 0.01, "{roughness}: {with:?} {without:?}");
    }
}

#[test]
fn what_is_faithful_is_the_same_bytes_in_any_tiles_and_on_any_instructions() {
    let mut description = under_a_ball(1.0, &[], 4);
    description["image"] = json!({ "width": 24, "height": 16 });
    description["camera"]["orthographic"]["height"] = json!(9);
    description["environment"] = json!({ "studio": {} });
    description["materials"]["floor"] =
        json!({ "pbr": { "metallic": 0.5, "roughness": 0.4, "clearcoat": 1, "opacity": { "alpha": 0.8 } } });
    description["render"]["max_depth"] = json!(5);
    for precision in ["single", "double"] {
        let scene = scene(description.clone(), precision);
        let region = Region::whole(scene.width, scene.height);
        let as_cut = |tile: u32, level: Level| {
            let options = RenderOptions { tile, level, specialised: true };
            render_with(&scene, region, &Control::default(), options).unwrap().film.pixels
        };
        let whole = as_cut(32, Level::new());
        assert_eq!(as_cut(5, Level::new()), whole, "{precision}");
        if let Some(least) = Level::new().as_sse2() {
            assert_eq!(as_cut(7, Level::Sse2(least)), whole, "{precision}");
        }
    }
}

#[test]
fn who_does_not_ask_for_it_has_none_of_it() {
    let studio = json!({ "environment": { "studio": {}, "light": "fast" } });
    let all = [Effect::GlobalIllumination, Effect::EnvironmentSampling, Effect::EmitterSampling];
    let material = || json!({ "pbr": { "emissive": 1 } });
    let fast = effects(&ball(material(), studio.clone(), json!({})));
    assert!(all.iter().all(|effect| !fast.has(*effect)) && fast.has(Effect::EnvironmentLight));
    let slow = effects(&ball(material(), studio.clone(), json!({ "fidelity": "faithful" })));
    assert!(all.iter().all(|effect| slow.has(*effect)) && !slow.has(Effect::EnvironmentLight));
    let flat = effects(&ball(material(), studio, json!({ "fidelity": "faithful", "max_depth": 1 })));
    assert!(all.iter().all(|effect| !flat.has(*effect)) && flat.has(Effect::EnvironmentLight));
}

/// What is proved of a picture holds: it is within a code of the picture of the same samples whose rays are all followed.
#[test]
fn bounds_hold_where_light_is_traced() {
    for seed in 0..24 {
        let with = |accuracy: Value, weight: Value| {
            let mut scene = environment_light::model(seed);
            scene["image"] = json!({ "width": 12, "height": 8 });
            scene["render"] = json!({
                "fidelity": "faithful", "samples": 2, "antialias": false, "max_depth": 4, "accuracy": accuracy
            });
            if !weight.is_null() {
                scene["render"]["min_weight"] = weight;
            }
            scene
        };
        let truth = pixels(with(json!({ "fixed": {} }), json!(0)), "double");
        let picture = picture(&scene(with(json!({ "proved": { "max_codes": 1 } }), Value::Null), "double"));
        for (got, truth) in picture.film.pixels.iter().zip(&truth) {
            for c in 0..3 {
                let off = code8(got[c]).abs_diff(code8(truth[c]));
                assert!(off <= 1, "seed {seed}: {got:?} for {truth:?}");
            }
        }
    }
}

/// Without rays surfaces have ambient light, which is another picture than that of recursion without end, brighter or darker.
#[test]
fn at_a_depth_of_1_the_picture_is_held_against_itself() {
    let depth = |render: Value| {
        let floor = json!({ "diffuse": 0.5 });
        scene(ball(floor, json!({ "environment": { "sky": {} }, "ambient": 0.5 }), render), "single")
            .ceiling()
            .reach
            .max_depth
    };
    for accuracy in [json!({ "proved": { "max_codes": 1 } }), json!({ "fixed": {} })] {
        assert_eq!(depth(json!({ "fidelity": "faithful", "max_depth": 1, "accuracy": accuracy })), Some(1));
        assert_eq!(depth(json!({ "color_bleeding": true, "max_depth": 1, "accuracy": accuracy })), Some(1));
    }
    assert_eq!(depth(json!({ "fidelity": "faithful" })), None);
}

#[test]
fn nobody_is_warned_of_darkness_where_rays_bring_the_light_of_the_surroundings() {
    let dark = |around: Value, render: Value| {
        let description = ball(json!({ "diffuse": 0.5 }), around, render);
        let loaded = load(description.to_string().as_bytes(), Format::Json, &Overrides::default()).unwrap();
        loaded.scene.warnings.iter().any(|warning| warning.pointer == "/lights")
    };
    let (faithful, bleeding) = (json!({ "fidelity": "faithful" }), json!({ "color_bleeding": true }));
    for render in [&faithful, &bleeding] {
        for around in [json!({ "environment": { "sky": {} } }), json!({ "background": 0.5 })] {
            assert!(!dark(around.clone(), render.clone()), "{around} {render}");
            assert!(dark(around.clone(), json!({})), "{around}");
        }
        assert!(dark(json!({ "background": 0 }), render.clone()), "{render}");
    }
}
