//! Bumps and normal maps: normals that closed forms give.

use super::textures::url;
use super::{picture, pixels, problems, scene};
use glam::{DMat3, DVec3};
use image::{ImageBuffer, Luma, Rgb, RgbImage};
use serde_json::{Value, json};
use strahl::scene::compile::Precise;

const LIGHT: DVec3 = DVec3::new(0.36, 0.48, 0.8);

/// Objects seen from the front, without perspective, x and y from -1 to 1; their color is the cosine of the light.
fn lit(material: Value, objects: Value) -> Value {
    let mut material = material;
    material["diffuse"] = json!(1);
    json!({
        "version": 1,
        "image": { "width": 8, "height": 8 },
        "camera": { "orthographic": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "height": 2 } },
        "ambient": 0,
        "lights": [{ "directional": { "direction": (-LIGHT).to_array() } }],
        "materials": { "rough": material },
        "objects": objects,
        "render": { "antialias": false }
    })
}

fn wall() -> Value {
    json!([{ "plane": { "point": [0, 0, 0], "normal": [0, 0, 1], "material": "rough" } }])
}

/// Heights that rise evenly by (x, y) codes of 65535 from texel to texel, 256 texels wide.
fn slope(x: u32, y: u32) -> String {
    url(ImageBuffer::from_fn(256, 256, |i, j| Luma([(i * x + (255 - j) * y) as u16])))
}

fn bump(source: String, height: f64, size: f64) -> Value {
    let mapping = json!({ "planar": { "axes": "xy", "size": size } });
    json!({ "bump": { "height": height, "texture": { "image": { "source": source, "mapping": mapping } } } })
}

fn cosine(normal: DVec3) -> f64 {
    normal.normalize().dot(LIGHT).max(0.0)
}

fn all_are(pixels: &[[f32; 3]], expected: f64, tolerance: f64) {
    for pixel in pixels {
        assert!(pixel.iter().all(|x| (f64::from(*x) - expected).abs() < tolerance), "{pixel:?}, not {expected}");
    }
}

#[test]
fn an_even_rise_is_a_tilted_plane() {
    // The picture is 16 wide; the wall shows its inside, away from where it begins again.
    let mut description = lit(bump(slope(100, 37), 5.0, 16.0), wall());
    description["camera"]["orthographic"]["eye"] = json!([8, 8, 5]);
    description["camera"]["orthographic"]["look_at"] = json!([8, 8, 0]);
    // Codes a texel, texels a unit.
    let rise = |codes: f64| 5.0 * codes / 65535.0 * 16.0;
    let expected = cosine(DVec3::new(-rise(100.0), -rise(37.0), 1.0));
    for precision in ["single", "double"] {
        all_are(&pixels(description.clone(), precision), expected, 2e-6);
    }
}

#[test]
fn placed_bumps_are_placed() {
    let material = || bump(slope(100, 37), 5.0, 16.0);
    let rise = |codes: f64| 5.0 * codes / 65535.0 * 16.0;
    let local = DVec3::new(-rise(100.0), -rise(37.0), 1.0);
    for (scale, degrees) in [([1.0, 1.0, 1.0], 30.0), ([3.0, 3.0, 3.0], -70.0), ([2.0, 0.5, 1.5], 110.0)] {
        let turn = DMat3::from_rotation_z(f64::to_radians(degrees));
        let stretch = DMat3::from_diagonal(DVec3::from_array(scale));
        // The middle of the picture comes to the origin.
        let to_world = turn * stretch;
        let shift = -(to_world * DVec3::new(8.0, 8.0, 0.0));
        let transform = json!({
            "scale": scale, "rotate_deg": { "axis": [0, 0, 1], "angle": degrees }, "translate": shift.to_array()
        });
        let objects = json!([{ "group": { "objects": wall(), "transform": transform } }]);
        let expected = cosine(to_world.inverse().transpose() * local);
        for precision in ["single", "double"] {
            all_are(&pixels(lit(material(), objects.clone()), precision), expected, 3e-6);
        }
    }
}

/// Normals all alike, but for one texel far away, so that they are no constant.
pub(super) fn normals(x: u8, y: u8, z: u8) -> String {
    url(RgbImage::from_fn(64, 64, |i, j| if i + j == 0 { Rgb([255, 128, 128]) } else { Rgb([x, y, z]) }))
}

fn coordinate(code: u8) -> f64 {
    (f64::from(code) - 128.0) / 127.0
}

/// A quad around the origin whose corners have u and v of a part of the picture, u turned around or not.
fn sheet(uvs: [[f64; 2]; 4]) -> Value {
    json!([{ "mesh": {
        "vertices": [[-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]], "faces": [[0, 1, 2], [0, 2, 3]],
        "uvs": uvs, "material": "rough"
    } }])
}

#[test]
fn normal_maps_follow_their_uvs_mirrored_or_turned() {
    let material = json!({ "normal_map": { "image": { "source": normals(190, 100, 220) } } });
    let [x, y, z] = [190, 100, 220].map(coordinate);
    let (low, high) = (0.4, 0.6);
    let cases = [
        // As it is; mirrored; upside down; turned by a quarter, u up and v to the left.
        ([[low, low], [high, low], [high, high], [low, high]], DVec3::new(x, y, z)),
        ([[high, low], [low, low], [low, high], [high, high]], DVec3::new(-x, y, z)),
        ([[low, high], [high, high], [high, low], [low, low]], DVec3::new(x, -y, z)),
        ([[low, high], [low, low], [high, low], [high, high]], DVec3::new(-y, x, z)),
    ];
    for (uvs, normal) in cases {
        let expected = cosine(normal);
        for precision in ["single", "double"] {
            all_are(&pixels(lit(material.clone(), sheet(uvs)), precision), expected, 2e-6);
        }
    }
}

#[test]
fn a_flat_normal_map_changes_no_byte() {
    let ball = json!([
        { "group": {
            "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 0.8, "material": "rough" } }],
            "transform": { "rotate_deg": { "axis": [1, 2, 3], "angle": 40 }, "scale": [1, 1.2, 0.7] }
        } }
    ]);
    let map = |source: String| {
        let mapping = json!({ "planar": { "axes": "xy", "size": 64 } });
        json!({ "normal_map": { "image": { "source": source, "mapping": mapping, "wrap": "clamp" } } })
    };
    for precision in ["single", "double"] {
        let plain = pixels(lit(json!({}), ball.clone()), precision);
        // One texel far away is not flat, so the map is looked at.
        let looked_at = scene(lit(map(normals(128, 128, 255)), ball.clone()), precision);
        let called = match &looked_at.world {
            Precise::Single(world) => world.effects.has_textures(),
            Precise::Double(world) => world.effects.has_textures(),
        };
        assert!(called);
        assert_eq!(picture(&looked_at).film.pixels, plain);
        let uniform = url(RgbImage::from_pixel(2, 2, Rgb([128, 128, 255])));
        assert_eq!(pixels(lit(map(uniform), ball.clone()), precision), plain);
    }
}

#[test]
fn bumps_without_height_are_not_called_for() {
    let flat = json!({ "bump": { "height": 0, "texture": { "noise": {} } } });
    let Precise::Single(world) = scene(lit(flat.clone(), wall()), "single").world else { panic!("asked for single") };
    assert!(!world.effects.has_textures());
    assert_eq!(pixels(lit(flat, wall()), "single"), pixels(lit(json!({}), wall()), "single"));
}

#[test]
fn wild_bumps_on_glass_and_mirrors_stay_finite() {
    for noise in [json!({ "size": 0.1, "octaves": 8 }), json!({ "size": 1e-9 }), json!({ "size": 1e12 })] {
        for height in [0.1, 10.0, 1e12] {
            let material = json!({
                "bump": { "height": height, "texture": { "noise": noise } },
                "specular": 0.5, "reflection": 0.5, "transmission": 0.5, "ior": 1.4
            });
            let objects = json!([
                { "sphere": { "center": [0, 0, 0], "radius": 0.9, "material": "rough" } },
                { "plane": { "point": [0, 0, -2], "normal": [0, 0.3, 1], "material": "rough" } }
            ]);
            let mut description = lit(material, objects);
            description["render"]["max_depth"] = json!(8);
            for precision in ["single", "double"] {
                let all = pixels(description.clone(), precision);
                assert!(all.iter().flatten().all(|x| x.is_finite() && (0.0..100.0).contains(x)));
            }
        }
    }
}

#[test]
fn broken_bumps_are_named() {
    let both = json!({
        "bump": { "height": 1, "texture": { "noise": {} } },
        "normal_map": { "image": { "source": normals(128, 128, 255), "mapping": { "planar": {} } } }
    });
    assert_eq!(problems(&lit(both, wall())), ["/materials/rough/normal_map"]);
    let negative = json!({ "bump": { "height": -1, "texture": { "noise": { "octaves": 0 } } } });
    assert_eq!(
        problems(&lit(negative, wall())),
        ["/materials/rough/bump/height", "/materials/rough/bump/texture/noise/octaves"]
    );
}

/// Normals of `pbr` lean in a stretched instance as those of the same mesh with moved vertices; those of `normal_map` are relief, which
/// is stretched.
#[test]
fn normals_of_gltf_lean_in_instances_as_in_moved_meshes() {
    let corners = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]];
    let mesh = |scale: [f64; 2], tangents: bool| {
        let moved: Vec<[f64; 3]> = corners.iter().map(|[x, y]| [x * scale[0], y * scale[1], 0.0]).collect();
        let hand = scale[0].signum() * scale[1].signum();
        // What a mirroring turns around shows its back.
        let faces = if hand > 0.0 { [[0, 1, 2], [0, 2, 3]] } else { [[0, 2, 1], [0, 3, 2]] };
        let mut mesh = json!({
            "vertices": moved, "faces": faces, "uvs": [[0.4, 0.4], [0.6, 0.4], [0.6, 0.6], [0.4, 0.6]], "material": "rough"
        });
        if tangents {
            mesh["tangents"] = json!(vec![[scale[0].signum(), 0.0, 0.0, hand]; 4]);
        }
        json!([{ "mesh": mesh }])
    };
    let image = normals(190, 100, 220);
    let of_pbr = json!({ "pbr": { "metallic": 0, "roughness": 1, "normal": { "image": image, "factor": 1 } } });
    let material = |form: &Value| {
        let mut description = lit(json!({}), json!([]));
        description["materials"]["rough"] = form.clone();
        description
    };
    for (scale, tangents) in [([2.0, 0.5], false), ([2.0, 0.5], true), ([-1.0, 3.0], false), ([-1.0, 3.0], true)] {
        let shown = |objects: Value, form: &Value, precision: &str| {
            let mut description = material(form);
            description["objects"] = objects;
            pixels(description, precision)
        };
        let transform = json!({ "scale": [scale[0], scale[1], 1] });
        let placed = json!([{ "group": { "objects": mesh([1.0, 1.0], tangents), "transform": transform } }]);
        let apart = |form: &Value, precision: &str| {
            let [placed, moved] =
                [placed.clone(), mesh(scale, tangents)].map(|objects| shown(objects, form, precision));
            let off = placed.as_flattened().iter().zip(moved.as_flattened()).map(|(a, b)| (a - b).abs());
            off.fold(0.0, f32::max)
        };
        for precision in ["single", "double"] {
            assert!(apart(&of_pbr, precision) < 1e-5, "{scale:?} {tangents} {precision}");
        }
        let relief = json!({ "diffuse": 1, "normal_map": { "image": { "source": image } } });
        assert!(apart(&relief, "double") > 0.02, "{scale:?}");
    }
}
