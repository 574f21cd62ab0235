//! Gradients, noise and pictures on surfaces.

use super::{pixels, problems, scene};
use data_encoding::BASE64;
use image::{DynamicImage, ImageFormat, Rgb, RgbImage};
use serde_json::{Value, json};
use std::io::Cursor;
use strahl::scene::compile::Precise;
use strahl::scene::{Files, Format, Overrides, load_with};

/// A picture's file.
pub(super) fn png(picture: impl Into<DynamicImage>) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    picture.into().write_to(&mut file, ImageFormat::Png).unwrap();
    file.into_inner()
}

/// A picture as the source of a texture.
pub(super) fn url(picture: impl Into<DynamicImage>) -> String {
    format!("data:image/png;base64,{}", BASE64.encode(&png(picture)))
}

fn linear(code: u8) -> f64 {
    strahl::math::srgb_to_linear(f64::from(code) / 255.0)
}

/// A wall at z = 0, seen from the front without perspective: x from -2 to 2, y from -1 to 1, in its own colors.
fn wall(diffuse: Value) -> Value {
    json!({
        "version": 1,
        "image": { "width": 32, "height": 16 },
        "camera": { "orthographic": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "height": 2 } },
        "ambient": 1,
        "lights": [],
        "materials": { "wall": { "diffuse": diffuse } },
        "objects": [{ "plane": { "point": [0, 0, 0], "normal": [0, 0, 1], "material": "wall" } }],
        "render": { "antialias": false, "samples": 1 }
    })
}

/// Where on the wall a pixel's centre lies.
fn place(i: usize) -> [f64; 2] {
    [(i % 32) as f64 / 8.0 + 0.0625 - 2.0, 1.0 - (i / 32) as f64 / 8.0 - 0.0625]
}

fn close(pixel: [f32; 3], expected: [f64; 3], tolerance: f64) -> bool {
    pixel.iter().zip(expected).all(|(a, b)| (f64::from(*a) - b).abs() <= tolerance)
}

fn board(edge: u32) -> RgbImage {
    RgbImage::from_fn(edge, edge, |x, y| if (x + y) % 2 == 0 { Rgb([255, 230, 10]) } else { Rgb([0, 20, 200]) })
}

fn mean() -> [f64; 3] {
    [(255, 0), (230, 20), (10, 200)].map(|(a, b)| (linear(a) + linear(b)) / 2.0)
}

#[test]
fn gradients_are_linear_and_end() {
    let gradient =
        json!({ "gradient": { "from": [-1, -0.5, 3], "to": [1, 0.5, 3], "a": [1, 0, 0.5], "b": [0, 2, 0.5] } });
    for precision in ["single", "double"] {
        for (i, pixel) in pixels(wall(gradient.clone()), precision).into_iter().enumerate() {
            let [x, y] = place(i);
            let t = (((x + 1.0) * 2.0 + (y + 0.5)) / 5.0).clamp(0.0, 1.0);
            assert!(close(pixel, [1.0 - t, 2.0 * t, 0.5], 1e-6), "{precision} {i}: {pixel:?}");
        }
    }
}

fn noise(size: f64) -> Value {
    json!({ "noise": { "a": [0, 0.2, 1], "b": [1, 0.8, 0], "size": size, "octaves": 5 } })
}

#[test]
fn noise_stays_between_its_colors_and_fills_them() {
    let single = pixels(wall(noise(0.5)), "single");
    let double = pixels(wall(noise(0.5)), "double");
    for (a, b) in single.iter().zip(&double) {
        assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-4), "{a:?} {b:?}");
        assert!((a[0] + a[2] - 1.0).abs() < 1e-6 && (0.0..=1.0).contains(&a[0]) && (0.2..=0.8).contains(&a[1]));
    }
    let reds = || double.iter().map(|pixel| pixel[0]);
    assert!(reds().fold(1.0, f32::min) < 0.35 && reds().fold(0.0, f32::max) > 0.65);
    let mean = reds().sum::<f32>() / double.len() as f32;
    assert!((mean - 0.5).abs() < 0.1, "{mean}");
}

#[test]
fn scenes_scaled_by_a_power_of_two_look_the_same() {
    for diffuse in [
        noise(0.5),
        json!({ "image": { "source": url(board(4)), "mapping": { "planar": { "axes": "xy", "size": 0.5 } } } }),
    ] {
        let plain = wall(diffuse);
        let mut scaled = plain.clone();
        let factor = 1024.0;
        scaled["camera"]["orthographic"]["eye"] = json!([0, 0, 5.0 * factor]);
        scaled["camera"]["orthographic"]["height"] = json!(2.0 * factor);
        for pointer in ["/noise/size", "/image/mapping/planar/size"] {
            if let Some(size) = scaled["materials"]["wall"]["diffuse"].pointer_mut(pointer) {
                *size = json!(0.5 * factor);
            }
        }
        for precision in ["single", "double"] {
            assert_eq!(pixels(plain.clone(), precision), pixels(scaled.clone(), precision));
        }
    }
}

#[test]
fn what_is_the_same_everywhere_is_a_color() {
    let one = RgbImage::from_pixel(5, 3, Rgb([188, 188, 188]));
    let picture = json!({ "image": { "source": url(one), "mapping": { "planar": { "axes": "xy" } } } });
    let gradient = json!({ "gradient": { "from": [0, 0, 0], "to": [1, 0, 0], "a": "#bcbcbc", "b": "#bcbcbc" } });
    let clouds = json!({ "noise": { "a": "#bcbcbc", "b": "#bcbcbc" } });
    let plain = pixels(wall(json!("#bcbcbc")), "single");
    for diffuse in [picture, gradient, clouds] {
        let Precise::Single(world) = scene(wall(diffuse.clone()), "single").world else { panic!("asked for single") };
        assert!(!world.effects.has_textures() && !world.effects.has_details());
        assert_eq!(pixels(wall(diffuse), "single"), plain);
    }
    // Nor does a material count that no body has.
    let mut unused = wall(noise(1.0));
    unused["objects"][0]["plane"]["material"] = Value::Null;
    let Precise::Single(world) = scene(unused, "single").world else { panic!("asked for single") };
    assert!(!world.effects.has_textures());
}

#[test]
fn magnified_pictures_are_bilinear() {
    let picture = RgbImage::from_fn(4, 2, |x, y| Rgb([(x * 80) as u8, (y * 200) as u8, (250 - x * 50 - y * 90) as u8]));
    let source = url(picture.clone());
    for (wrap, repeats) in [("repeat", true), ("clamp", false)] {
        let diffuse = json!({ "image": {
            "source": source, "wrap": wrap, "mapping": { "planar": { "axes": "xy", "size": 2 } }
        } });
        let texel = |x: i64, y: i64, c: usize| {
            let at = if repeats { [x.rem_euclid(4), y.rem_euclid(2)] } else { [x.clamp(0, 3), y.clamp(0, 1)] };
            linear(picture.get_pixel(at[0] as u32, at[1] as u32)[c])
        };
        for precision in ["single", "double"] {
            for (i, pixel) in pixels(wall(diffuse.clone()), precision).into_iter().enumerate() {
                // The picture is 2 wide and 1 high: two texels in a unit. Rows go down.
                let [x, y] = place(i);
                let (x, y) = if repeats { (x, y) } else { (x.clamp(0.0, 2.0), y.clamp(0.0, 1.0)) };
                let (x, y) = (x * 2.0 - 0.5, (1.0 - y) * 2.0 - 0.5);
                let (left, up) = (x.floor(), y.floor());
                let (a, b) = (x - left, y - up);
                let (left, up) = (left as i64, up as i64);
                let expected = [0, 1, 2].map(|c| {
                    let row = |y: i64| texel(left, y, c) * (1.0 - a) + texel(left + 1, y, c) * a;
                    row(up) * (1.0 - b) + row(up + 1) * b
                });
                assert!(close(pixel, expected, 2e-6), "{wrap} {precision} {i}: {pixel:?} {expected:?}");
            }
        }
    }
}

#[test]
fn a_board_far_away_is_its_mean() {
    for size in [0.3, 0.01, 1e-5] {
        let diffuse = json!({ "image": {
            "source": url(board(8)), "mapping": { "planar": { "axes": "xy", "size": size } }
        } });
        for precision in ["single", "double"] {
            for pixel in pixels(wall(diffuse.clone()), precision) {
                assert!(close(pixel, mean(), if size < 0.1 { 1e-6 } else { 0.02 }), "{size}: {pixel:?}");
            }
        }
    }
}

/// A floor to the horizon, laid with boards.
fn floor(samples: u32) -> Value {
    json!({
        "version": 1,
        "image": { "width": 96, "height": 48 },
        "camera": { "pinhole": { "eye": [0, 1, 0], "look_at": [1, 0.8, -4], "vfov_deg": 40 } },
        "background": mean(),
        "ambient": 1,
        "lights": [],
        "materials": { "floor": { "diffuse": { "image": { "source": url(board(2)), "mapping": { "planar": {} } } } } },
        "objects": [{ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor" } }],
        "render": { "antialias": false, "samples": samples }
    })
}

#[test]
fn a_floor_to_the_horizon_does_not_alias() {
    let many = pixels(floor(256), "double");
    let difference = |one: &[[f32; 3]]| {
        let squares = one.iter().zip(&many).flat_map(|(a, b)| (0..3).map(move |c| f64::from(a[c] - b[c]).powi(2)));
        (squares.sum::<f64>() / (3 * many.len()) as f64).sqrt()
    };
    let filtered = difference(&pixels(floor(1), "double"));
    // The same board without filter: what a single sample makes of it.
    let mut unfiltered = floor(1);
    let (a, b) = ("#ffe60a", "#0014c8");
    unfiltered["materials"]["floor"]["diffuse"] = json!({ "checker": { "a": a, "b": b, "size": 0.5 } });
    unfiltered["render"]["filter_checkers"] = json!(false);
    let unfiltered = difference(&pixels(unfiltered, "double"));
    println!("{filtered} instead of {unfiltered}");
    assert!(filtered < 0.06 && unfiltered > 3.0 * filtered, "{filtered} instead of {unfiltered}");
    // Towards the horizon there is nothing left to see.
    let one = pixels(floor(1), "single");
    let horizon = one.chunks(96).position(|row| row.iter().any(|pixel| !close(*pixel, mean(), 1e-6))).unwrap();
    assert!(horizon > 21, "the horizon lies in row 20, and row {horizon} is the first to show the board");
}

#[test]
fn globes_have_no_seam_and_no_spot_at_the_pole() {
    // A picture that closes: its colors follow cos(longitude).
    let wave = |x: u32| 0.5 + 0.5 * ((f64::from(x) + 0.5) / 64.0 * std::f64::consts::TAU).cos();
    let picture = RgbImage::from_fn(64, 32, |x, y| Rgb([(wave(x) * 255.0) as u8, (y * 8) as u8, 128]));
    let source = url(picture);
    let ball = |eye: [f64; 3]| {
        json!({
            "version": 1,
            "image": { "width": 64, "height": 64 },
            "camera": { "orthographic": { "eye": eye, "look_at": [0, 0, 0], "up": [0, 1, 0.01], "height": 0.5 } },
            "ambient": 1,
            "lights": [],
            "materials": { "globe": { "diffuse": { "image": { "source": source, "mapping": { "spherical": {} } } } } },
            "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "globe" } }],
            "render": { "antialias": false }
        })
    };
    // The back, where the picture's edges meet.
    for row in pixels(ball([0.0, 0.0, -5.0]), "single").chunks(64) {
        for two in row.windows(2) {
            assert!((two[0][0] - two[1][0]).abs() < 0.02, "{two:?}");
        }
    }
    let pole = pixels(ball([0.0, 5.0, 0.0]), "single");
    assert!(pole.iter().flatten().all(|x| x.is_finite() && (0.0..=1.0).contains(x)));
}

#[test]
fn meshes_show_pictures_by_their_uvs() {
    // A ramp in u, and a triangle that shows half of it, mirrored, in a turned and stretched instance.
    let ramp = RgbImage::from_fn(64, 2, |x, _| Rgb([(x * 4) as u8, 0, 0]));
    let description = json!({
        "version": 1,
        "image": { "width": 32, "height": 16 },
        "camera": { "orthographic": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "height": 2 } },
        "background": [0, 0, 9],
        "ambient": 1,
        "lights": [],
        "materials": { "map": { "diffuse": { "image": { "source": url(ramp), "wrap": "clamp" } } } },
        "definitions": { "sheet": [{ "mesh": {
            "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]],
            "faces": [[0, 1, 2], [1, 3, 2]],
            "uvs": [[1, 0], [0, 0], [1, 1], [0, 1]],
            "material": "map"
        } }] },
        "objects": [{ "instance": { "of": "sheet", "transform": { "scale": [4, 2, 1], "translate": [-2, -1, 0] } } }],
        "render": { "antialias": false }
    });
    for (precision, tolerance) in [("single", 1e-5), ("double", 1e-6)] {
        for (i, pixel) in pixels(description.clone(), precision).into_iter().enumerate() {
            let u = 0.5 - place(i)[0] / 4.0;
            let x = (u * 64.0 - 0.5).clamp(0.0, 63.0);
            // Two texels are averaged where the pixel is two texels wide.
            let value = |x: f64| {
                let (left, part) = (x.floor(), x - x.floor());
                linear((left * 4.0) as u8) * (1.0 - part) + linear(((left + 1.0).min(63.0) * 4.0) as u8) * part
            };
            let expected = (value((x - 0.5).max(0.0)) + value((x + 0.5).min(63.0))) / 2.0;
            assert!((f64::from(pixel[0]) - expected).abs() < tolerance, "{precision} {i}: {} {expected}", pixel[0]);
        }
    }
}

#[test]
fn mirrors_and_clear_bodies_do_not_change_what_is_filtered() {
    // Through a mirror at z = -2 the eye at z = 2 sees what one at z = -6 sees straight ahead, turned around.
    let room = |eye: [f64; 3], at: [f64; 3], more: Value| {
        let mut description = floor(1);
        description["camera"] = json!({ "pinhole": { "eye": eye, "look_at": at, "vfov_deg": 40 } });
        description["materials"]["mirror"] = json!({ "diffuse": 0, "reflection": 1 });
        description["materials"]["air"] = json!({ "diffuse": 0, "transmission": 1, "ior": 1 });
        description["objects"].as_array_mut().unwrap().push(more);
        pixels(description, "double")
    };
    let nothing = json!({ "sphere": { "center": [0, 50, 0], "radius": 1 } });
    let mirror = json!({ "disc": { "center": [0, 0, -2], "normal": [0, 0, 1], "radius": 99, "material": "mirror" } });
    let mirrored = room([0.0, 1.0, 2.0], [0.0, 0.9, -2.0], mirror);
    let straight = room([0.0, 1.0, -6.0], [0.0, 0.9, -2.0], nothing.clone());
    for (i, pixel) in mirrored.iter().enumerate() {
        let other = straight[i / 96 * 96 + 95 - i % 96];
        // In front of the mirror the floor is seen as it is.
        if i / 96 < 36 {
            assert!((0..3).all(|c| (pixel[c] - other[c]).abs() < 1e-5), "{i}: {pixel:?} {other:?}");
        }
    }
    let air = json!({ "sphere": { "center": [0, 1, 0], "radius": 1.5, "material": "air" } });
    let (eye, at) = ([0.0, 1.0, 4.0], [0.0, 0.8, 0.0]);
    assert_eq!(room(eye, at, air), room(eye, at, nothing));
}

/// A mirror that is placed widens cones as much as the same one that is not.
#[test]
fn placed_mirrors_filter_as_others_do() {
    let ball = |size: f64| json!({ "sphere": { "center": [0, size, 0], "radius": size, "material": "mirror" } });
    let placed = |scale: f64| json!({ "group": { "transform": { "scale": scale }, "objects": [ball(1.0 / scale)] } });
    let seen = |ball: Value| {
        let mut scene = floor(1);
        scene["camera"] = json!({ "pinhole": { "eye": [0, 1.5, 4], "look_at": [0, 0.8, 0], "vfov_deg": 40 } });
        scene["materials"]["mirror"] = json!({ "diffuse": 0, "reflection": 0.9 });
        scene["objects"].as_array_mut().unwrap().push(ball);
        pixels(scene, "double")
    };
    let direct = seen(ball(1.0));
    for scale in [0.125, 8.0] {
        let other = seen(placed(scale));
        let off = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).any(|c| (a[c] - b[c]).abs() > 1e-3);
        let count = direct.iter().zip(&other).filter(|pair| off(*pair)).count();
        assert!(count * 500 < direct.len(), "scale {scale}: {count} of {} pixels", direct.len());
    }
}

/// Any changes to a picture's file make another picture or a problem, nothing worse.
#[test]
fn broken_pictures_are_problems() {
    let mut jpeg = Cursor::new(Vec::new());
    DynamicImage::from(board(16)).write_to(&mut jpeg, ImageFormat::Jpeg).unwrap();
    for file in [png(board(16)), jpeg.into_inner()] {
        let scene = |file: &[u8]| {
            let source = format!("data:image/any;base64,{}", BASE64.encode(file));
            wall(json!({ "image": { "source": source, "mapping": { "planar": { "axes": "xy", "size": 1e-3 } } } }))
        };
        let whole = pixels(scene(&file), "double");
        assert!(whole.iter().all(|pixel| close(*pixel, whole[0].map(f64::from), 1e-6)));
        for i in 0..400 {
            let mut broken = file.clone();
            let at = i * 7919 % broken.len();
            broken[at] ^= 1 << (i % 8);
            broken.truncate(if i % 5 == 0 { at } else { broken.len() });
            assert!(problems(&scene(&broken)).iter().all(|pointer| pointer == "/materials/wall/diffuse/image/source"));
        }
    }
}

struct Shelf;

impl Files for Shelf {
    fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        if name == "board.png" { Ok(png(board(8))) } else { Err("is not on the shelf".into()) }
    }
}

#[test]
fn files_are_read_only_where_there_are_any() {
    let named = |name: &str| {
        wall(json!({ "image": { "source": name, "mapping": { "planar": { "axes": "xy", "size": 0.01 } } } }))
            .to_string()
    };
    let load = |name: &str| load_with(named(name).as_bytes(), Format::Json, &Overrides::default(), &Shelf);
    let scene = load("board.png").unwrap().scene;
    assert!(scene.from_files && scene.bytes() > 8 * 8 * 12);
    assert!(!super::scene(wall(noise(1.0)), "single").from_files);
    let said = load("other.png").unwrap_err().to_string();
    assert!(said.contains("/materials/wall/diffuse/image/source") && said.contains("not on the shelf"), "{said}");
    assert!(load("https://example.org/a.png").unwrap_err().to_string().contains("never fetched"));
    let broken: Value = serde_json::from_str(&named("board.png")).unwrap();
    assert_eq!(problems(&broken), ["/materials/wall/diffuse/image/source"]);
}

#[test]
fn broken_textures_are_named() {
    let cases = [
        (json!({ "noise": { "a": 0, "b": 1, "octaves": 13 } }), "/noise/octaves"),
        (json!({ "noise": { "a": 0, "b": 1, "size": 0 } }), "/noise/size"),
        (json!({ "noise": { "a": -1, "b": 1 } }), "/noise/a"),
        (json!({ "gradient": { "from": [1, 2, 3], "to": [1, 2, 3], "a": 0, "b": 1 } }), "/gradient/to"),
        (json!({ "gradient": { "from": [1e300, 2, 3], "to": [1, 2, 3], "a": 0, "b": 1 } }), "/gradient/from/0"),
        (
            json!({ "image": { "source": url(board(2)), "mapping": { "planar": { "size": -1 } } } }),
            "/image/mapping/planar/size",
        ),
        (
            json!({ "image": { "source": url(board(2)), "mapping": { "spherical": { "axis": [0, 0, 0] } } } }),
            "/image/mapping/spherical/axis",
        ),
        (json!({ "image": { "source": "data:image/png;base64,AAAA", "mapping": { "planar": {} } } }), "/image/source"),
        (json!({ "image": { "source": "data:image/png;base64,A*", "mapping": { "planar": {} } } }), "/image/source"),
        (json!({ "image": { "source": "data:x", "mapping": { "planar": {} } } }), "/image/source"),
        (json!({ "image": { "source": "", "mapping": { "planar": {} } } }), "/image/source"),
    ];
    for (diffuse, pointer) in cases {
        let scene = wall(diffuse);
        assert_eq!(problems(&scene), [format!("/materials/wall/diffuse{pointer}")], "{scene:#}");
    }
    // A plane has no uvs.
    assert_eq!(problems(&wall(json!({ "image": { "source": url(board(2)) } }))), ["/objects/0/plane/material"]);
}

#[test]
fn pictures_that_claim_to_be_huge_are_refused_unread() {
    let mut bomb = png(RgbImage::new(1, 1));
    for (width, height) in [(16_385, 1), (16_384, 16_384), (u32::MAX >> 1, u32::MAX >> 1)] {
        bomb[16..20].copy_from_slice(&u32::to_be_bytes(width));
        bomb[20..24].copy_from_slice(&u32::to_be_bytes(height));
        let crc = crc(&bomb[12..29]);
        bomb[29..33].copy_from_slice(&crc.to_be_bytes());
        let source = format!("data:image/png;base64,{}", BASE64.encode(&bomb));
        let scene = wall(json!({ "image": { "source": source, "mapping": { "planar": {} } } }));
        assert_eq!(problems(&scene), ["/materials/wall/diffuse/image/source"]);
    }
}

fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| (c >> 1) ^ (0xedb8_8320 & (c & 1).wrapping_neg()))
    };
    !bytes.iter().fold(u32::MAX, step)
}

#[test]
fn explanations_say_what_is_on_removed_or_off() {
    let states = |description: &Value| {
        let loaded =
            strahl::scene::load(description.to_string().as_bytes(), Format::Json, &Overrides::default()).unwrap();
        let explained = strahl::plan::explain::explain(&loaded.scene);
        // What a description says reads back as the same.
        let written = serde_json::to_value(&loaded.description).unwrap();
        assert_eq!(serde_json::from_value::<strahl::scene::Description>(written).unwrap(), loaded.description);
        let names =
            ["gradient_texture", "noise_texture", "image_texture", "bump_mapping", "normal_mapping", "environment_map"];
        names.map(|name| {
            let effect = explained.effects.iter().find(|effect| effect.effect == name).unwrap();
            serde_json::to_value(effect.state).unwrap().as_str().unwrap().to_owned()
        })
    };
    let mut description = wall(json!(1));
    assert_eq!(states(&description), ["off"; 6]);
    let source = url(board(2));
    // Without a light nothing would show diffuse colors and bumps.
    description["lights"] = json!([{ "point": { "position": [0, 0, 5] } }]);
    description["environment"] = json!({ "image": source });
    description["materials"]["wall"] = json!({
        "ambient": noise(1.0),
        "diffuse": { "gradient": { "from": [0, 0, 0], "to": [1, 0, 0], "a": 0, "b": 1 } },
        "bump": { "height": 0.1, "texture": { "image": { "source": source, "mapping": { "planar": {} } } } }
    });
    description["materials"]["unused"] = json!({
        "diffuse": { "image": { "source": source, "mapping": "uv", "wrap": "repeat" } },
        "normal_map": { "image": { "source": source } }
    });
    assert_eq!(states(&description), ["on", "on", "removed", "on", "removed", "on"]);
    description["environment"]["intensity"] = json!(0);
    description["materials"]["wall"]["bump"]["height"] = json!(0);
    assert_eq!(states(&description), ["on", "on", "removed", "removed", "removed", "removed"]);
}
