//! Exposure, tone curves and transparent backgrounds.

use super::*;
use image::ImageFormat;
use strahl::film::{FileFormat, Film, encode};
use strahl::render::{Stop, render_until};

/// Bodies in front of nothing: an opaque ball, a ball and a sheet of grey glass, and fog.
fn scene_over(background: f64) -> Value {
    json!({
        "version": 1, "image": { "width": 40, "height": 30 }, "background": background,
        "camera": { "pinhole": { "eye": [0, 0.5, 6], "look_at": [0, 0.4, 0], "vfov_deg": 40 } },
        "fog": { "density": 0.02, "color": [0.2, 0.4, 0.3], "height": { "falloff": 1 } },
        "materials": {
            "red": { "diffuse": [0.9, 0.2, 0.1] },
            "glass": { "diffuse": 0.1, "transmission": 0.8, "ior": 1.5 },
            "sheet": { "diffuse": [0.1, 0.3, 0.1], "transmission": 0.5 }
        },
        "objects": [
            { "sphere": { "center": [-1.2, 0.4, 0], "radius": 1, "material": "red" } },
            { "sphere": { "center": [0.9, 0.8, 1], "radius": 0.7, "material": "glass" } },
            { "quad": { "vertices": [[0, -1, 2], [2, -1, 2], [2, 0.4, 2], [0, 0.4, 2]], "material": "sheet" } }
        ],
        "render": { "accuracy": { "fixed": {} }, "min_weight": 0, "max_depth": 20 }
    })
}

fn transparent(mut description: Value) -> Value {
    description["film"] = json!({ "background": "transparent" });
    description
}

/// The picture over black and over white differs by what alpha lets through (Smith and Blinn 1996).
#[test]
fn alpha_is_what_two_backgrounds_tell() {
    for precision in ["single", "double"] {
        for (samples, antialias) in [(1, false), (1, true), (16, false)] {
            let of = |mut description: Value| {
                description["render"]["samples"] = json!(samples);
                // Antialiasing looks at the picture itself, which differs.
                description["render"]["antialias"] = json!(antialias);
                picture(&scene(description, precision)).film
            };
            let [black, white] = [0.0, 1.0].map(|background| of(scene_over(background)));
            let film = of(transparent(scene_over(0.3)));
            assert_eq!(film.alpha.len(), film.pixels.len());
            let mut kinds = [0; 3];
            for (i, alpha) in film.alpha.iter().enumerate() {
                kinds[if *alpha <= 0.2 {
                    0
                } else if *alpha < 0.95 {
                    1
                } else {
                    2
                }] += 1;
                if antialias {
                    continue;
                }
                assert_eq!(film.pixels[i], black.pixels[i], "{precision} {samples} {i}");
                for c in 0..3 {
                    let shines = white.pixels[i][c] - black.pixels[i][c];
                    assert!((shines - (1.0 - alpha)).abs() < 3e-6, "{precision} {samples} {i}: {shines} {alpha}");
                }
            }
            assert!(kinds.iter().all(|kind| *kind > 60), "{kinds:?}");
        }
    }
}

/// A highlight on clear glass is brighter than its alpha, which straight colors cannot be.
#[test]
fn over_black_a_transparent_file_is_the_light_itself() {
    let description = transparent(json!({
        "version": 1, "image": { "width": 80, "height": 60 },
        "camera": { "pinhole": { "eye": [0, 1.2, 6], "look_at": [0, 0.9, 0] } },
        "materials": {
            "glass": { "diffuse": 0, "specular": 0.8, "shininess": 30, "transmission": 0.9, "reflection": 0.08, "ior": 1.3 }
        },
        "objects": [{ "sphere": { "center": [0, 1, 0], "radius": 1.2, "material": "glass" } }]
    }));
    let film = picture(&scene(description, "single")).film;
    let beyond = film.pixels.iter().zip(&film.alpha).filter(|(pixel, alpha)| pixel.iter().any(|c| c > alpha)).count();
    assert!(beyond > 10, "{beyond} pixels are brighter than their alpha");
    let decoded = image::load_from_memory_with_format(&encode(&film, FileFormat::Png16), ImageFormat::Png).unwrap();
    let linear = |code: f64| if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) };
    for (pixel, file) in film.pixels.iter().zip(decoded.to_rgba16().pixels()) {
        let [r, g, b, alpha] = file.0.map(|code| f64::from(code) / 65_535.0);
        for (light, code) in pixel.iter().zip([r, g, b]) {
            let over_black = linear(code) * alpha;
            assert!((over_black - f64::from(light.min(1.0))).abs() < 1e-3, "{pixel:?} {:?}", file.0);
        }
    }
}

#[test]
fn mirrors_show_the_background_which_the_camera_does_not() {
    for precision in ["single", "double"] {
        let description = transparent(json!({
            "version": 1, "image": { "width": 9, "height": 9 }, "background": [0.25, 0.5, 1],
            "camera": { "orthographic": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "height": 3 } },
            "ambient": 0, "lights": [],
            "materials": { "mirror": { "diffuse": 0, "reflection": 1 } },
            "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "mirror" } }],
            "render": { "antialias": false }
        }));
        let film = picture(&scene(description, precision)).film;
        assert_eq!((film.pixels[40], film.alpha[40]), ([0.25, 0.5, 1.0], 1.0));
        assert_eq!((film.pixels[0], film.alpha[0]), ([0.0; 3], 0.0));
    }
}

/// Whatever makes the picture, and however it is cut.
#[test]
fn tiles_and_accuracies_have_the_same_alpha() {
    for precision in ["single", "double"] {
        let mut description = transparent(scene_over(0.3));
        description["film"]["tone"] = json!("agx");
        for samples in [1, 4] {
            description["render"]["samples"] = json!(samples);
            let scene = scene(description.clone(), precision);
            let whole = picture(&scene).film;
            let (whole8, whole16) = (encode(&whole, FileFormat::Png8), encode(&whole, FileFormat::Png16));
            assert!(image::load_from_memory_with_format(&whole16, ImageFormat::Png).unwrap().color().has_alpha());
            let whole8 = image::load_from_memory_with_format(&whole8, ImageFormat::Png).unwrap().to_rgba8();
            for region in whole.region.tiles(13) {
                let tile = render(&scene, region, &Control::default()).unwrap().film;
                let alpha: Vec<f32> = region.iter().map(|at| whole.alpha[whole.region.index(at)]).collect();
                assert_eq!(tile.alpha, alpha, "{region:?}");
                let tile = encode(&tile, FileFormat::WebP);
                let tile = image::load_from_memory_with_format(&tile, ImageFormat::WebP).unwrap().to_rgba8();
                for [x, y] in region.iter() {
                    assert_eq!(tile.get_pixel(x - region.x, y - region.y), whole8.get_pixel(x, y));
                }
            }
            let window = Window::whole(scene.width, scene.height);
            let until = |stop| render_until(&scene, &window, whole.region, &Control::default(), stop).unwrap();
            // A picture that had to stop has the alpha of the pixels that were traced, whose rays count.
            let few = until(Stop::Rays(50));
            assert!(few.rays.total() < 500, "{:?}", few.rays);
            let traced = [0, whole.region.index([32, 0])];
            assert!(samples > 1 || traced.iter().all(|index| few.film.alpha[*index] == whole.alpha[*index]));
            assert!(few.film.alpha.iter().all(|alpha| (0.0..=1.0).contains(alpha)));
            for (max_codes, most) in [(0, 0.5), (1, 1.0), (2, 2.0)] {
                description["render"]["accuracy"] = json!({ "proved": { "max_codes": max_codes } });
                let film = picture(&super::scene(description.clone(), precision)).film;
                for (alpha, exact) in film.alpha.iter().zip(&whole.alpha) {
                    assert!((alpha - exact).abs() * 255.0 < most, "{precision} {samples} {max_codes}: {alpha} {exact}");
                }
            }
            description["render"]["accuracy"] = json!({ "fixed": {} });
            description["render"]["antialias"] = json!(false);
            let whole = picture(&super::scene(description.clone(), precision)).film;
            let scene = super::scene(description.clone(), precision);
            let finished =
                render_until(&scene, &window, whole.region, &Control::default(), Stop::Rays(u64::MAX)).unwrap();
            assert!(finished.film.alpha == whole.alpha, "{precision} {samples}");
            description["render"]["antialias"] = json!(true);
        }
    }
}

/// Mirrors and glass, much of whose light is left out at first.
fn deep() -> Value {
    json!({
        "version": 1, "image": { "width": 32, "height": 24 }, "background": [0.5, 0.7, 1.4],
        "camera": { "pinhole": { "eye": [0, 1.5, 6], "look_at": [0, 0.7, 0], "vfov_deg": 40 } },
        "lights": [{ "point": { "position": [4, 6, 5], "intensity": 3 } }],
        "materials": {
            "mirror": { "diffuse": [0.1, 0.3, 0.2], "reflection": [0.9, 0.8, 0.6], "specular": 0.8, "shininess": 20 },
            "glass": { "diffuse": 0.02, "reflection": 0.2, "transmission": 0.75, "ior": 1.5 },
            "floor": { "diffuse": { "checker": { "a": [0.8, 0.1, 0.1], "b": 0.9 } }, "reflection": 0.4 }
        },
        "objects": [
            { "plane": { "point": [0, -0.3, 0], "normal": [0, 1, 0], "material": "floor" } },
            { "sphere": { "center": [-1.2, 0.7, 0], "radius": 1, "material": "mirror" } },
            { "sphere": { "center": [0.9, 0.5, 1], "radius": 0.8, "material": "glass" } },
            { "sphere": { "center": [0.9, 0.5, 1], "radius": 0.4, "material": "mirror" } }
        ]
    })
}

#[test]
fn what_is_proved_holds_for_the_codes_shown() {
    let films = [
        json!({ "tone": "khronos_pbr_neutral" }),
        json!({ "tone": "agx" }),
        json!({ "exposure": -1.5, "tone": "agx", "background": "transparent" }),
        json!({ "exposure": 2.5 }),
        json!({ "exposure": 1, "tone": "khronos_pbr_neutral", "background": "transparent" }),
    ];
    for film in films {
        let codes = |film: &Film| -> Vec<u8> {
            film.shown().as_flattened().iter().map(|c| strahl::film::srgb::code8(*c)).collect()
        };
        let mut description = deep();
        description["film"] = film.clone();
        description["render"] =
            json!({ "accuracy": { "fixed": {} }, "min_weight": 1e-7, "max_depth": 200, "antialias": false });
        let truth = codes(&picture(&scene(description.clone(), "double")).film);
        for (accuracy, most) in [
            (json!({ "proved": { "max_codes": 0 } }), 0),
            (json!({ "proved": { "max_codes": 1 } }), 1),
            (json!({ "proved": { "max_codes": 2 } }), 2),
            (json!({ "fixed": {} }), 255),
            (json!({ "rays": { "count": 4000 } }), 255),
        ] {
            description["render"] = json!({ "accuracy": accuracy, "antialias": false });
            let scene = scene(description.clone(), "double");
            let found = match accuracy.get("rays") {
                None => picture(&scene),
                Some(_) => {
                    let window = Window::whole(scene.width, scene.height);
                    let region = Region::whole(scene.width, scene.height);
                    render_until(&scene, &window, region, &Control::default(), Stop::Rays(4000)).unwrap()
                }
            };
            let proof = found.proof();
            // Where light is divided by alpha before a curve, a pixel may need more than a packet of rays can know of.
            let curved = film.get("background").is_some();
            assert!(proof.max_codes <= if curved { 255 } else { most }, "{film} {accuracy}: {proof:?}");
            let off = codes(&found.film).iter().zip(&truth).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            assert!(off <= proof.max_codes, "{film} {accuracy}: {off} of {proof:?}");
            assert!(accuracy.get("fixed").is_none() || proof.max_codes > 0, "there is something to prove");
        }
    }
}

/// The codes of files, alpha included where they have it.
fn file_codes(film: &Film) -> Vec<u8> {
    let png = encode(film, FileFormat::Png8);
    let picture = image::load_from_memory_with_format(&png, ImageFormat::Png).unwrap();
    let mut codes: Vec<u8> = film.shown().as_flattened().iter().map(|c| strahl::film::srgb::code8(*c)).collect();
    if picture.color().has_alpha() {
        codes.extend(picture.to_rgba8().pixels().map(|pixel| pixel.0[3]));
    }
    codes
}

#[test]
fn what_is_proved_holds_for_alpha_and_backdrops() {
    let sheets = |diffuse: f64, transmission: Value| {
        json!({
            "version": 1, "image": { "width": 24, "height": 18 }, "background": 0.3,
            "camera": { "pinhole": { "eye": [0, 0.5, 5], "look_at": [0, 0, 0] } },
            "lights": [{ "point": { "position": [4, 6, 5], "intensity": 2 } }],
            "materials": { "glass": {
                "diffuse": diffuse, "reflection": 0.25, "transmission": transmission, "ior": 1.4,
                // Brighter than what of the glass is not background.
                "specular": 1, "shininess": 20
            } },
            "objects": [
                { "sphere": { "center": [-0.6, 0, 0], "radius": 1, "material": "glass" } },
                { "sphere": { "center": [0.8, 0.2, 0.5], "radius": 0.7, "material": "glass" } }
            ]
        })
    };
    let films = [
        json!({ "background": "transparent" }),
        json!({ "background": "transparent", "exposure": -3 }),
        json!({ "background": "transparent", "exposure": 2 }),
        json!({ "background": "transparent", "tone": "khronos_pbr_neutral" }),
        json!({ "background": "transparent", "tone": "agx" }),
        json!({ "background": { "color": [1, 1, 1] } }),
        json!({ "background": { "color": [1, 1, 1] }, "exposure": -3, "tone": "agx" }),
    ];
    let transmissions = |share: f64| [json!(share), json!([share, 0.3 * share, 0.8 * share])];
    let mut differing = 0;
    let materials = [[0.0, 0.7], [0.3, 0.5]].map(|[diffuse, share]| transmissions(share).map(|share| (diffuse, share)));
    for (film, (diffuse, transmission)) in
        films.iter().flat_map(|film| materials.as_flattened().iter().map(move |material| (film, material)))
    {
        let mut description = sheets(*diffuse, transmission.clone());
        description["film"] = film.clone();
        let render = |accuracy: Value, depth: u32, weight: f64| {
            let fixed = accuracy.get("fixed").is_some();
            json!({ "accuracy": accuracy, "antialias": false,
                "max_depth": if fixed { json!(depth) } else { Value::Null }, "min_weight": if fixed { json!(weight) } else { Value::Null } })
        };
        let mut of = |accuracy: Value, depth: u32, weight: f64| {
            description["render"] = render(accuracy, depth, weight);
            description["render"].as_object_mut().unwrap().retain(|_, value| !value.is_null());
            picture(&scene(description.clone(), "double"))
        };
        let truth = file_codes(&of(json!({ "fixed": {} }), 60, 1e-8).film);
        let mut settings: Vec<(Value, u32, f64)> =
            (0..3).map(|codes| (json!({ "proved": { "max_codes": codes } }), 0, 0.0)).collect();
        settings.extend(
            [(1, 0.0), (3, 0.0), (9, 0.3), (9, 0.03)].map(|(depth, weight)| (json!({ "fixed": {} }), depth, weight)),
        );
        for (accuracy, depth, weight) in settings {
            let found = of(accuracy.clone(), depth, weight);
            let (codes, proof) = (file_codes(&found.film), found.proof());
            let off = codes.iter().zip(&truth).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            assert!(off <= proof.max_codes, "{film} {accuracy} {depth} {weight}: {off} of {proof:?}");
            // Proofs are given up because they are too dear, and for no other reason.
            if let Some(most) = accuracy["proved"]["max_codes"].as_u64() {
                assert!(proof.beyond[most as usize] <= found.rays.given_up, "{film} {accuracy}: {proof:?}");
            }
            differing += usize::from(off > 2);
        }
    }
    assert!(differing > 20, "{differing}");
}

/// Colored glass over a color that is known shows the color of its own background, not a grey.
#[test]
fn glass_colors_what_is_behind_it() {
    for material in [
        json!({ "pbr": { "base_color": [0.9, 0.8, 0.2], "metallic": 0, "roughness": 0, "transmission": 1, "thin": true } }),
        json!({ "diffuse": [0.1, 0, 0], "transmission": [0.8, 0.5, 0.1] }),
    ] {
        let pane = |background: Value, film: Value| {
            json!({
                "version": 1, "image": { "width": 4, "height": 4 }, "ambient": 1, "lights": [], "background": background, "film": film,
                "camera": { "orthographic": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "height": 1 } },
                "materials": { "it": material },
                "objects": [{ "quad": { "vertices": [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], "material": "it" } }]
            })
        };
        for (color, stops) in [([1.0, 1.0, 1.0], 0), ([1.0, 0.0, 0.0], 0), ([0.2, 0.7, 0.4], 1)] {
            for precision in ["single", "double"] {
                let over = pane(json!(0), json!({ "background": { "color": color }, "exposure": stops }));
                let seen =
                    pane(json!(color.map(|channel| channel / f64::from(1 << stops))), json!({ "exposure": stops }));
                let [over, seen] = [over, seen].map(|it| picture(&scene(it, precision)).film.shown().into_owned());
                let is_pbr = material.get("pbr").is_some();
                for (a, b) in over.iter().zip(&seen) {
                    for c in 0..3 {
                        // What the sheet itself mirrors of a background, 4 %, is black in the one.
                        let mirrored = if is_pbr { 0.04 * color[c] as f32 } else { 0.0 };
                        assert!((a[c] + mirrored - b[c]).abs() < 1e-3, "{material} {color:?}: {over:?} {seen:?}");
                    }
                }
            }
        }
    }
}

/// A lamp that clear glass mirrors is brighter than the glass is opaque. Over black it is as bright as without alpha, over a color
/// no darker, with every tone curve; a part of the glass that mirrors nothing stays clear.
#[test]
fn highlights_on_clear_glass_are_whole() {
    let sheet = |film: Value| {
        let description = json!({
            "version": 1, "image": { "width": 33, "height": 33 }, "background": 0, "lights": [], "film": film,
            "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
            "materials": {
                "glass": { "diffuse": 0, "reflection": 0.05, "transmission": 0.95 },
                "lamp": { "diffuse": 0, "emission": 400 }
            },
            "objects": [
                { "quad": { "vertices": [[-4, -4, 0], [4, -4, 0], [4, 4, 0], [-4, 4, 0]], "material": "glass" } },
                { "sphere": { "center": [0, 0, 9], "radius": 3, "material": "lamp" } }
            ],
            "render": { "antialias": false }
        });
        picture(&scene(description, "double")).film
    };
    let (middle, corner) = (16 * 33 + 16, 0);
    for tone in ["none", "khronos_pbr_neutral", "agx"] {
        let opaque = sheet(json!({ "tone": tone, "background": { "color": [0, 0, 0] } }));
        let clear = sheet(json!({ "tone": tone, "background": "transparent" }));
        let blue = sheet(json!({ "tone": tone, "background": { "color": [0, 0, 1] } }));
        assert!((0.04..0.06).contains(&clear.alpha[middle]), "{tone}: {}", clear.alpha[middle]);
        let codes = |film: &Film, pixel: usize| film.shown()[pixel].map(strahl::film::srgb::code8);
        for shown in [codes(&opaque, middle), codes(&clear, middle)] {
            assert!(shown.iter().all(|code| *code > 240), "{tone}: {shown:?}");
        }
        assert!(codes(&blue, middle)[2] == 255 && codes(&blue, middle)[0] > 240, "{tone}: {:?}", codes(&blue, middle));
        assert!(codes(&blue, corner)[2] > 245 && codes(&clear, corner) == [0; 3], "{tone}");
        // The file, put over black.
        let png = encode(&clear, FileFormat::Png8);
        let file = image::load_from_memory_with_format(&png, ImageFormat::Png).unwrap().to_rgba8();
        let [r, g, b, alpha] = file.get_pixel(16, 16).0;
        assert!(alpha > 240 && [r, g, b].iter().all(|code| *code > 240), "{tone}: {:?}", file.get_pixel(16, 16));
        assert!(file.get_pixel(0, 0).0[3] < 16, "{tone}: {:?}", file.get_pixel(0, 0));
    }
}

/// Where nothing but alpha is to be found out.
#[test]
fn black_bodies_have_as_many_samples_as_their_alpha_asks_for() {
    let ball = |accuracy: Value| {
        json!({
            "version": 1, "image": { "width": 32, "height": 24 }, "film": { "background": "transparent" }, "lights": [], "ambient": 0,
            "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
            "materials": { "black": { "diffuse": 0 } },
            "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "black" } }],
            "render": { "accuracy": accuracy }
        })
    };
    let mut exact = ball(json!({ "fixed": {} }));
    exact["render"]["samples"] = json!(1024);
    let exact = picture(&scene(exact, "single")).film;
    let worst =
        |film: &Film| film.alpha.iter().zip(&exact.alpha).map(|(a, b)| 255.0 * (a - b).abs()).fold(0.0, f32::max);
    let sampled = picture(&scene(ball(json!({ "statistical": { "half_width": 2, "confidence": 0.99 } })), "single"));
    assert!(worst(&sampled.film) < 6.0, "{}", worst(&sampled.film));
    // An edge of 16 samples.
    let antialiased = picture(&scene(ball(json!({ "proved": { "max_codes": 1 } })), "single"));
    assert!(worst(&antialiased.film) < 24.0, "{}", worst(&antialiased.film));
    let scene = scene(ball(json!({ "rays": { "count": 200 } })), "single");
    let (window, region) = (Window::whole(scene.width, scene.height), Region::whole(scene.width, scene.height));
    let stopped = render_until(&scene, &window, region, &Control::default(), Stop::Rays(200)).unwrap();
    assert!(stopped.sampling.widths.at_share(0.95).unwrap() > 4, "the estimate knows of alpha");
}

/// Where there is no light, what rays have missed of the background is said all the same.
#[test]
fn without_light_what_alpha_may_lack_is_known() {
    let ball = |render: Value| {
        let description = json!({
            "version": 1, "image": { "width": 16, "height": 12 }, "film": { "background": "transparent" }, "lights": [], "ambient": 0,
            "background": 0, "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
            "materials": { "glass": { "diffuse": 0, "reflection": 0.2, "transmission": 0.7, "ior": 1.4 } },
            "objects": [
                { "sphere": { "center": [0, 0, 0], "radius": 1, "material": "glass" } },
                { "sphere": { "center": [0.3, 0, -3], "radius": 1, "material": "glass" } }
            ],
            "render": render
        });
        scene(description, "double")
    };
    let fixed = |max_depth: u32, samples: u32| {
        ball(
            json!({ "accuracy": { "fixed": {} }, "max_depth": max_depth, "min_weight": 0, "antialias": false, "samples": samples }),
        )
    };
    let hold = |found: &Picture, truth: &Picture, least: f32| {
        let (found_alpha, alpha) = (&found.film.alpha, &truth.film.alpha);
        let off = found_alpha.iter().zip(alpha).map(|(a, b)| 255.0 * (a - b).abs()).fold(0.0, f32::max);
        let proof = found.proof();
        assert!(off > least && off < f32::from(proof.max_codes) + 0.5, "{off} {proof:?}");
    };
    let truth = picture(&fixed(40, 1));
    hold(&picture(&fixed(1, 1)), &truth, 100.0);
    hold(&picture(&fixed(2, 1)), &truth, 100.0);
    hold(&picture(&fixed(3, 1)), &truth, 2.0);
    hold(&picture(&fixed(3, 16)), &picture(&fixed(40, 16)), 2.0);
    let shortened = ball(json!({ "accuracy": { "rays": { "count": 60 } }, "antialias": false }));
    let (window, region) = (Window::whole(16, 12), Region::whole(16, 12));
    let stopped = render_until(&shortened, &window, region, &Control::default(), Stop::Rays(60)).unwrap();
    hold(&stopped, &truth, 100.0);
}

#[test]
fn a_film_that_asks_for_nothing_costs_nothing() {
    let mut plain = scene_over(0.3);
    let before = picture(&scene(plain.clone(), "single"));
    plain["film"] = json!({ "exposure": 0, "tone": "none", "background": "scene" });
    let after = picture(&scene(plain.clone(), "single"));
    assert_eq!((&before.film, before.rays), (&after.film, after.rays));
    assert!(after.film.alpha.is_empty());
    let effects = effects(&plain);
    assert!(!effects.has(Effect::ToneMapping) && !effects.has(Effect::AlphaChannel));
}

#[test]
fn broken_films_are_refused() {
    let mut wrong = scene_over(0.0);
    wrong["film"] = json!({ "exposure": 40 });
    assert_eq!(problems(&wrong), ["/film/exposure"]);
    wrong["film"] = json!({ "tone": "aces", "backgrund": "transparent" });
    assert_eq!(problems(&wrong), ["/film/backgrund", "/film/tone"]);
}
