//! Pictures of the surroundings.

use super::textures::url;
use super::{picture, pixels, problems, scene};
use image::{Rgb, RgbImage};
use serde_json::{Value, json};
use strahl::film::{FileFormat, encode};
use strahl::scene::compile::Precise;
use strahl::scene::effects::Effect;

/// A panorama of an environment, in which there is next to nothing.
fn panorama(environment: Value, width: u32) -> Value {
    json!({
        "version": 1,
        "image": { "width": width, "height": width / 2 },
        "camera": { "panorama": { "eye": [0, 0, 0], "look_at": [0, 0, -1], "hfov_deg": 360, "vfov_deg": 180 } },
        "environment": environment,
        "objects": [{ "sphere": { "center": [0, -1, 0], "radius": 1e-12 } }],
        "render": { "antialias": false }
    })
}

fn around() -> RgbImage {
    RgbImage::from_fn(64, 32, |x, y| Rgb([(x * 4) as u8, (y * 8) as u8, ((x * 7 + y * 13) % 256) as u8]))
}

fn codes(description: Value, precision: &str) -> RgbImage {
    let film = picture(&scene(description, precision)).film;
    image::load_from_memory(&encode(&film, FileFormat::Png8)).unwrap().to_rgb8()
}

fn furthest(a: &RgbImage, b: &RgbImage) -> u8 {
    a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

#[test]
fn a_panorama_in_its_own_surroundings_comes_back() {
    let mut room: Value = serde_json::from_str(include_str!("../../../scenes/cameras/panorama.json")).unwrap();
    room["image"] = json!({ "width": 128, "height": 64 });
    room["render"]["antialias"] = json!(false);
    let seen = codes(room, "double");
    for precision in ["single", "double"] {
        let again = codes(panorama(json!({ "image": url(seen.clone()) }), 128), precision);
        let off = furthest(&seen, &again);
        assert!(off <= if precision == "single" { 1 } else { 0 }, "{precision}: {off} codes");
    }
}

#[test]
fn it_turns_counter_clockwise_seen_from_above() {
    let plain = around();
    for (degrees, columns) in [(90.0, 16), (-90.0, 48), (180.0, 32), (360.0, 0)] {
        let turned = codes(panorama(json!({ "image": url(plain.clone()), "rotate_deg": degrees }), 64), "double");
        let expected = RgbImage::from_fn(64, 32, |x, y| *plain.get_pixel((x + columns) % 64, y));
        assert!(furthest(&turned, &expected) == 0, "{degrees}");
    }
}

#[test]
fn directions_are_those_of_the_convention() {
    // Four walls and two lids, each of its own color.
    let colors = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0], [255, 255, 255], [0, 255, 255]];
    let map = RgbImage::from_fn(64, 32, |x, y| {
        Rgb(colors[match (y, (x + 8) / 16 % 4) {
            (0..8, _) => 4,
            (24.., _) => 5,
            (_, side) => side as usize,
        }])
    });
    // The left edge of the picture is behind, a quarter is the left, the middle is in front.
    let looks = [([0, 0, 1], 0), ([-1, 0, 0], 1), ([0, 0, -1], 2), ([1, 0, 0], 3), ([0, 1, 0], 4), ([0, -1, 0], 5)];
    for (at, color) in looks {
        let mut description = panorama(json!({ "image": url(map.clone()) }), 4);
        description["camera"] =
            json!({ "pinhole": { "eye": [0, 0, 0], "look_at": at, "up": [0.3, 0.4, 0.5], "vfov_deg": 10 } });
        let all = pixels(description, "single");
        let expected = colors[color].map(|code: u8| f32::from(code) / 255.0);
        assert!(all.iter().all(|pixel| *pixel == expected), "{at:?}: {all:?}");
    }
}

#[test]
fn mirrors_and_glass_show_it() {
    let map = url(around());
    let look = |objects: Value, eye: [f64; 3], at: [f64; 3]| {
        let description = json!({
            "version": 1,
            "image": { "width": 16, "height": 16 },
            "camera": { "pinhole": { "eye": eye, "look_at": at, "vfov_deg": 30 } },
            "environment": { "image": map },
            "ambient": 0, "lights": [],
            "materials": {
                "mirror": { "diffuse": 0, "reflection": 1 },
                "nothing": { "diffuse": 0, "transmission": 1, "ior": 1 }
            },
            "objects": objects,
            "render": { "antialias": false }
        });
        pixels(description, "double")
    };
    let far = json!([{ "sphere": { "center": [0, -9, 0], "radius": 1e-9 } }]);
    let away = look(far.clone(), [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    // A mirror in front shows what is behind, turned around.
    let mirror = json!([{ "disc": { "center": [0, 0, -3], "normal": [0, 0, 1], "radius": 9, "material": "mirror" } }]);
    let mirrored = look(mirror, [0.0, 0.0, 0.0], [0.0, 0.0, -1.0]);
    for (i, pixel) in mirrored.iter().enumerate() {
        let other = away[i / 16 * 16 + 15 - i % 16];
        assert!((0..3).all(|c| (pixel[c] - other[c]).abs() < 1e-6), "{pixel:?} {other:?}");
    }
    let clear = json!([{ "sphere": { "center": [0, 0, 3], "radius": 1, "material": "nothing" } }]);
    assert_eq!(look(clear, [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]), away);
}

#[test]
fn intensity_is_a_factor_and_one_color_is_a_background() {
    let map = url(around());
    let one = pixels(panorama(json!({ "image": map }), 64), "double");
    let three = pixels(panorama(json!({ "image": map, "intensity": 3 }), 64), "double");
    for (a, b) in one.iter().zip(&three) {
        assert!((0..3).all(|c| (3.0 * a[c] - b[c]).abs() <= 1e-6), "{a:?} {b:?}");
    }
    for environment in [
        json!({ "image": map, "intensity": 0 }),
        json!({ "image": url(RgbImage::from_pixel(3, 2, Rgb([188, 0, 255]))), "intensity": 0.5 }),
    ] {
        let scene = scene(panorama(environment, 8), "single");
        let Precise::Single(world) = &scene.world else { panic!("asked for single") };
        assert!(!world.effects.has(Effect::EnvironmentMap) && world.environment.is_none());
        let color = world.background;
        assert!(picture(&scene).film.pixels.iter().all(|pixel| *pixel == color));
    }
}

#[test]
fn around_a_dome_it_is_dark() {
    for image in [around(), RgbImage::new(2, 2)] {
        let mut description = panorama(json!({ "image": url(image) }), 16);
        description["image"]["height"] = json!(16);
        description["background"] = json!([7, 8, 9]);
        description["camera"] = json!({ "fisheye": { "eye": [0, 0, 0], "look_at": [0, 0, -1], "fov_deg": 180 } });
        let all = pixels(description, "single");
        assert!(all[0] == [0.0; 3] && all[8 * 16 + 8].iter().all(|x| *x <= 1.0));
    }
}

#[test]
fn broken_surroundings_are_named() {
    let map = url(around());
    let cases = [
        (json!({ "image": "sky.png" }), "/environment/image"),
        (json!({}), "/environment"),
        (json!({ "image": map, "sky": {} }), "/environment/sky"),
        (json!({ "sky": { "zenith": -1 } }), "/environment/sky/zenith"),
        (json!({ "image": map, "rotate_deg": 361 }), "/environment/rotate_deg"),
        (json!({ "image": map, "intensity": -1 }), "/environment/intensity"),
        (json!({ "image": map, "intensity": 1e16 }), "/environment/intensity"),
    ];
    for (environment, pointer) in cases {
        assert_eq!(problems(&panorama(environment, 8)), [pointer]);
    }
}

#[test]
fn a_sky_has_its_colors_above_and_at_the_horizon_and_ground_below() {
    let sky = json!({ "sky": { "zenith": [0, 0, 1], "horizon": 1, "ground": [0.5, 0, 0] }, "intensity": 2 });
    let width = 128;
    let all = pixels(panorama(sky, width), "double");
    let row = |row: u32| all[(row * width + width / 3) as usize];
    let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.1);
    assert!(close(row(0), [0.0, 0.0, 2.0]), "{:?}", row(0));
    assert!(close(row(31), [1.95, 1.95, 2.0]), "{:?}", row(31));
    assert!(close(row(32), [1.0, 0.0, 0.0]) && close(row(63), [1.0, 0.0, 0.0]), "{:?}", row(32));
    // It is the same all around, and grows paler towards the horizon.
    assert!((0..width).all(|column| all[(10 * width + column) as usize] == row(10)));
    assert!((0..31).all(|y| row(y)[0] <= row(y + 1)[0]));
}

#[test]
fn a_sky_of_one_color_is_a_background() {
    let sky = json!({ "sky": { "zenith": 0.5, "horizon": 0.5, "ground": 0.5 } });
    let scene = scene(panorama(sky, 8), "single");
    let Precise::Single(world) = &scene.world else { unreachable!() };
    assert!(!world.effects.has(Effect::EnvironmentMap) && world.environment.is_none());
}

#[test]
fn pictures_without_pixels_are_refused() {
    for size in ["-Y 0 +X 0", "-Y 5 +X 0", "-Y 0 +X 5"] {
        let hdr = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n");
        let source = format!("data:image/vnd.radiance;base64,{}", data_encoding::BASE64.encode(hdr.as_bytes()));
        let scene = serde_json::json!({
            "version": 1, "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
            "environment": { "image": source }, "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1 } }],
        });
        let loaded =
            strahl::scene::load(scene.to_string().as_bytes(), strahl::scene::Format::Json, &Default::default());
        assert!(loaded.is_err_and(|problems| problems.0[0].pointer == "/environment/image"), "{size}");
    }
}
