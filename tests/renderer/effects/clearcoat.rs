//! Clearcoat with normals of its own, and clearcoat over a surface with bumps: two surfaces, each with its own light and mirror.

use super::textures::url;
use super::{picture, pixels, problems, scene};
use glam::DVec3;
use image::{Rgb, RgbImage};
use serde_json::{Value, json};
use strahl::film::Display;
use strahl::inspect::tree::trace_pixel;

/// A picture of one normal, and that normal.
fn normals(codes: [u8; 3]) -> (Value, DVec3) {
    // One texel far away differs, so that the picture is no constant.
    let source = url(RgbImage::from_fn(64, 64, |i, j| if i + j == 0 { Rgb([255, 128, 128]) } else { Rgb(codes) }));
    let normal = DVec3::from_array(codes.map(|code| (f64::from(code) - 128.0) / 127.0));
    (json!({ "image": source }), normal.normalize())
}

/// The plane through the origin with a normal. u grows along x and v along y where the normal is z.
fn wall(normal: DVec3) -> Value {
    let right = DVec3::Y.cross(normal).normalize();
    let up = normal.cross(right);
    let corner = |u: f64, v: f64| (right * u + up * v).to_array();
    json!([{ "mesh": {
        "vertices": [corner(-9.0, -9.0), corner(9.0, -9.0), corner(9.0, 9.0), corner(-9.0, 9.0)],
        "faces": [[0, 1, 2], [0, 2, 3]], "uvs": [[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9]], "material": "it"
    } }])
}

/// A material that is black but for its clearcoat, with more keys.
fn clearcoat(roughness: f64, more: Value) -> Value {
    let mut pbr = json!({
        "base_color": 0, "metallic": 0, "specular": 0, "clearcoat": 1, "clearcoat_roughness": roughness
    });
    pbr.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    json!({ "pbr": pbr })
}

/// One pixel that looks from a direction at the origin, in surroundings.
fn seen(view: DVec3, material: Value, objects: Value, around: Value) -> Value {
    let mut scene = json!({
        "version": 1, "image": { "width": 1, "height": 1 },
        "camera": { "orthographic": { "eye": (view * 5.0).to_array(), "look_at": [0, 0, 0], "up": [0, 1, 0.1], "height": 1e-3 } },
        "ambient": 0, "lights": [], "materials": { "it": material, "lamp": { "pbr": { "unlit": true } } },
        "objects": objects, "render": { "antialias": false }
    });
    scene.as_object_mut().unwrap().extend(around.as_object().unwrap().clone());
    scene
}

fn light(from: DVec3) -> Value {
    json!({ "lights": [{ "directional": { "direction": (-from).to_array(), "color": [1, 0.5, 2] } }] })
}

fn view(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec3::new(sin, 0.0, cos)
}

fn mirrored(view: DVec3, normal: DVec3) -> DVec3 {
    normal * (2.0 * view.dot(normal)) - view
}

/// What clearcoat reflects at an angle: Schlick's law.
fn share(cosine: f64) -> f64 {
    0.04 + 0.96 * (1.0 - cosine).powi(5)
}

fn value(description: &Value, precision: &str) -> [f64; 3] {
    pixels(description.clone(), precision)[0].map(f64::from)
}

#[track_caller]
fn alike(a: [f64; 3], b: [f64; 3], off: f64, what: &str) {
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= off * (1.0 + b)), "{what}: {a:?} and {b:?}");
}

/// By 27, 15 and 20 degrees.
const TILTS: [[u8; 3]; 3] = [[170, 100, 230], [128, 160, 250], [90, 128, 230]];

#[test]
fn clearcoat_that_leans_mirrors_where_its_normal_says() {
    for codes in TILTS {
        let (map, normal) = normals(codes);
        for (degrees, precision) in [(0.0, "single"), (20.0, "double"), (35.0, "single")] {
            let view = view(degrees);
            let to_lamp = mirrored(view, normal);
            let with_lamp = |dir: DVec3| {
                let mut objects = wall(DVec3::Z);
                let lamp =
                    json!({ "sphere": { "center": (dir * 40.0).to_array(), "radius": 0.5, "material": "lamp" } });
                objects.as_array_mut().unwrap().push(lamp);
                objects
            };
            let material = clearcoat(0.0, json!({ "clearcoat_normal": map.clone() }));
            let there = value(&seen(view, material.clone(), with_lamp(to_lamp), json!({})), precision);
            alike(there, [share(view.dot(normal)); 3], 1e-5, "the lamp");
            let beside = with_lamp(mirrored(view, DVec3::Z));
            alike(value(&seen(view, material, beside, json!({})), precision), [0.0; 3], 0.0, "beside it");
        }
    }
}

/// Highlights, mirrors and blurred surroundings, fast and faithful.
#[test]
fn clearcoat_that_leans_looks_as_a_plane_that_does() {
    let studio = || json!({ "studio": {}, "light": "fast" });
    for codes in TILTS {
        let (map, normal) = normals(codes);
        for degrees in [0.0, 20.0, 35.0] {
            let view = view(degrees);
            let near = (mirrored(view, normal) + DVec3::new(0.05, 0.1, 0.0)).normalize();
            let faithful = json!({
                "environment": { "studio": {} },
                "render": { "fidelity": "faithful", "max_depth": 2, "samples": 4, "antialias": false }
            });
            for (roughness, around, what) in [
                (0.3, light(near), "highlight"),
                (0.0, json!({ "environment": studio() }), "mirror"),
                (0.12, json!({ "environment": studio() }), "some of both"),
                (0.5, json!({ "environment": studio() }), "blurred"),
                (0.0, faithful, "faithful"),
            ] {
                for precision in ["single", "double"] {
                    let leans = clearcoat(roughness, json!({ "clearcoat_normal": map.clone() }));
                    let leans = value(&seen(view, leans, wall(DVec3::Z), around.clone()), precision);
                    let even = seen(view, clearcoat(roughness, json!({})), wall(normal), around.clone());
                    alike(
                        leans,
                        value(&even, precision),
                        2e-5,
                        &format!("{what}, {codes:?} from {degrees}, {precision}"),
                    );
                }
            }
        }
    }
}

/// The specification: where clearcoat has no normals of its own it is even, whatever those of the surface below are.
#[test]
fn clearcoat_over_bumps_is_even() {
    // The surface turns away from the light, which the clearcoat faces.
    let (bumps, tilt) = normals([30, 128, 190]);
    let view = DVec3::new(-0.3, 0.0, 0.9).normalize();
    let from = mirrored(view, DVec3::new(0.4, 0.1, 1.0).normalize());
    assert!(tilt.dot(from) < 0.0 && from.z > 0.0);
    for (roughness, around) in [
        (0.5, light(from)),
        (0.0, json!({ "environment": { "sky": {} } })),
        (0.4, json!({ "environment": { "sky": {}, "light": "fast" } })),
    ] {
        for precision in ["single", "double"] {
            let seen =
                |more: Value| value(&seen(view, clearcoat(roughness, more), wall(DVec3::Z), around.clone()), precision);
            let even = seen(json!({}));
            assert!(even[0] > 0.001, "{even:?}");
            alike(seen(json!({ "normal": bumps.clone() })), even, 1e-6, "over bumps");
        }
    }
}

/// Each mirrors by its own ray, and below there is what the clearcoat leaves.
#[test]
fn surface_and_clearcoat_mirror_apart() {
    let (bumps, tilt) = normals([190, 100, 220]);
    let view = view(20.0);
    let sky = json!({ "environment": { "sky": {} } });
    let glossy = json!({ "specular": 1, "roughness": 0, "ior": 2 });
    let bare = |more: Value| {
        let mut material = clearcoat(0.0, glossy.clone());
        material["pbr"]["clearcoat"] = json!(0);
        material["pbr"].as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        material
    };
    for precision in ["single", "double"] {
        let of = |material: Value| value(&seen(view, material, wall(DVec3::Z), sky.clone()), precision);
        let (below, above) = (of(bare(json!({ "normal": bumps.clone() }))), of(clearcoat(0.0, json!({}))));
        let mut both = glossy.clone();
        both["normal"] = bumps.clone();
        let left = 1.0 - share(view.z);
        let expected = std::array::from_fn(|c| above[c] + left * below[c]);
        alike(of(clearcoat(0.0, both)), expected, 1e-6, "bumps below");
        // And the other way round.
        let mut both = glossy.clone();
        both["clearcoat_normal"] = bumps.clone();
        let above = value(&seen(view, clearcoat(0.0, json!({})), wall(tilt), sky.clone()), precision);
        let (left, below) = (1.0 - share(view.dot(tilt)), of(bare(json!({}))));
        let expected = std::array::from_fn(|c| above[c] + left * below[c]);
        alike(of(clearcoat(0.0, both)), expected, 1e-5, "bumps above");
    }
}

/// With the same normals there is one mirror ray for both, and two without.
#[test]
fn the_same_normals_need_one_ray() {
    let (map, _) = normals([190, 100, 220]);
    let sky = json!({ "environment": { "sky": {} } });
    let rays = |more: Value| {
        let material = clearcoat(0.0, more);
        let scene = scene(seen(view(10.0), material, wall(DVec3::Z), sky.clone()), "single");
        picture(&scene).rays.reflected
    };
    assert_eq!(rays(json!({ "specular": 1, "roughness": 0 })), 1);
    assert_eq!(rays(json!({ "specular": 1, "roughness": 0, "normal": map, "clearcoat_normal": map })), 1);
    assert_eq!(rays(json!({ "specular": 1, "roughness": 0, "normal": map })), 2);
}

/// A cube of which each side has the whole picture.
fn cube() -> Value {
    let (mut vertices, mut uvs, mut faces) = (vec![], vec![], vec![]);
    for normal in [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z] {
        let (right, first) = (normal.any_orthonormal_vector(), vertices.len());
        let up = normal.cross(right);
        for (u, v) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            vertices.push((normal + right * u + up * v).to_array());
            uvs.push([0.5 + 0.4 * u, 0.5 + 0.4 * v]);
        }
        faces.extend([[0, 1, 2], [0, 2, 3]].map(|face| face.map(|i| first + i)));
    }
    json!([{ "mesh": { "vertices": vertices, "uvs": uvs, "faces": faces, "material": "it" } }])
}

/// Of total reflection inside of a body nothing is lost to clearcoat that leans, nor to its mirror rays.
#[test]
fn glass_reflects_totally_below_clearcoat_that_leans() {
    // Seen from inside at 60 degrees, where clearcoat that leans by 60 degrees would be seen edge on.
    let (map, _) = normals([20, 128, 190]);
    let glass = json!({ "metallic": 0, "roughness": 0, "specular": 1, "base_color": 1, "transmission": 1, "ior": 1.5 });
    let of = |eye: DVec3, towards: DVec3, precision: &str, fidelity: &str, leans: bool| {
        let mut material = clearcoat(0.0, glass.clone());
        if leans {
            material["pbr"]["clearcoat_normal"] = map.clone();
        }
        let mut scene = seen(DVec3::Z, material, cube(), json!({ "environment": { "sky": {} } }));
        scene["camera"] = json!({ "pinhole": {
            "eye": eye.to_array(), "look_at": (eye + towards).to_array(), "up": [0, 1, 0], "vfov_deg": 0.1
        } });
        scene["render"]["fidelity"] = json!(fidelity);
        value(&scene, precision)
    };
    for precision in ["single", "double"] {
        for fidelity in ["fast", "faithful"] {
            for x in [1.0, -1.0] {
                let towards = DVec3::new(0.866 * x, 0.0, 0.5);
                let inside = |leans| of(DVec3::Z * 0.9, towards, precision, fidelity, leans);
                let even = inside(false);
                assert!(even.iter().all(|channel| *channel > 0.2), "{even:?}");
                alike(inside(true), even, 1e-6, &format!("inside, {precision}, {fidelity}"));
            }
            // From outside the normals count.
            let eye = DVec3::new(0.0, 3.2, 4.0);
            let outside = |leans| of(eye, DVec3::Z - eye, precision, fidelity, leans);
            let (even, leans) = (outside(false), outside(true));
            assert!((even[0] - leans[0]).abs() > 0.001, "{even:?} {leans:?}");
        }
    }
}

/// A cube with bumps of both kinds: its trees are its picture, whatever a packet holds beside them.
#[test]
fn trees_are_pictures_of_clearcoat_that_leans() {
    let bumps = |x: u32| {
        let wave = |i: u32| (100 + 7 * (i * x % 8)) as u8;
        json!({ "image": url(RgbImage::from_fn(16, 16, |i, j| Rgb([wave(i), wave(j), 220]))) })
    };
    let more = json!({
        "normal": bumps(3), "clearcoat_normal": bumps(5), "specular": 1, "roughness": 0, "base_color": [0.5, 0.2, 0.1]
    });
    let around =
        json!({ "environment": { "sky": {}, "light": "fast" }, "lights": light(DVec3::new(0.3, 0.5, 0.8))["lights"] });
    for precision in ["single", "double"] {
        let mut description = seen(view(15.0), clearcoat(0.02, more.clone()), cube(), around.clone());
        description["image"] = json!({ "width": 12, "height": 9 });
        description["camera"]["orthographic"]["height"] = json!(3);
        let scene = scene(description, precision);
        let film = picture(&scene).film;
        for (i, pixel) in film.pixels.iter().enumerate() {
            let tree = trace_pixel(&scene, i as u32 % 12, i as u32 / 12);
            assert_eq!(tree.value.map(|channel| channel as f32), *pixel, "pixel {i}, {precision}");
        }
    }
}

/// Two walls that mirror each other, with a ray for the surface and one for its clearcoat at each: what a proof leaves out of both is
/// within its codes, and a picture without the rays that a depth cuts off says so.
#[test]
fn proofs_hold_for_clearcoat_that_leans() {
    let wavy = |x: u32| {
        let wave = |i: u32| (108 + 5 * (i * x % 8)) as u8;
        json!({ "image": url(RgbImage::from_fn(16, 16, |i, j| Rgb([wave(i), wave(j), 240]))) })
    };
    let more = json!({
        "normal": wavy(3), "clearcoat_normal": wavy(5), "metallic": 1, "specular": 1, "roughness": 0, "base_color": 0.9
    });
    let wall = |z: f64, facing: [u32; 3], other: [u32; 3]| {
        json!({ "mesh": {
            "vertices": [[-9, -9, z], [9, -9, z], [9, 9, z], [-9, 9, z]], "faces": [facing, other],
            "uvs": [[0, 0], [1, 0], [1, 1], [0, 1]], "material": "it"
        } })
    };
    let between = json!([wall(-2.0, [0, 1, 2], [0, 2, 3]), wall(2.0, [2, 1, 0], [3, 2, 0])]);
    let rendered = |precision: &str, render: Value| {
        let around = json!({ "environment": { "sky": {}, "light": "fast" }, "lights": light(DVec3::new(0.3, 0.5, 0.8))["lights"] });
        let mut description = seen(DVec3::Z, clearcoat(0.0, more.clone()), between.clone(), around);
        description["image"] = json!({ "width": 16, "height": 12 });
        description["camera"] = json!({ "pinhole": { "eye": [0, 0.3, 1], "look_at": [3, 0, -1], "vfov_deg": 60 } });
        description["render"] = render;
        description["render"]["antialias"] = json!(false);
        picture(&scene(description, precision))
    };
    let code = |channel: f32| i32::from(Display::default().codes([channel; 3])[0]);
    for precision in ["single", "double"] {
        let truth = rendered(precision, json!({ "max_depth": 12, "min_weight": 0 }));
        let proved = rendered(precision, json!({ "accuracy": { "proved": { "max_codes": 1 } }, "max_depth": 12 }));
        let cut = rendered(precision, json!({ "max_depth": 2, "min_weight": 0 }));
        let pairs = |other: &[[f32; 3]]| -> Vec<(f32, f32)> {
            other.as_flattened().iter().copied().zip(truth.film.pixels.as_flattened().iter().copied()).collect()
        };
        let off = |other: &[[f32; 3]]| pairs(other).iter().map(|(a, b)| (code(*a) - code(*b)).abs()).max().unwrap();
        assert!(off(&proved.film.pixels) <= 1, "{precision}: {}", off(&proved.film.pixels));
        assert!(proved.rays.reflected < truth.rays.reflected, "the proof spares nothing");
        assert!(off(&cut.film.pixels) > 3, "{precision}: depth 2 is no different");
    }
}

#[test]
fn what_is_written_wrong_is_said_with_its_place() {
    let with = |map: Value| {
        problems(&seen(DVec3::Z, clearcoat(0.0, json!({ "clearcoat_normal": map })), wall(DVec3::Z), json!({})))
    };
    let (map, _) = normals(TILTS[0]);
    assert_eq!(with(map.clone()), [""; 0]);
    let mut strong = map.clone();
    strong["factor"] = json!(101);
    assert_eq!(with(strong), ["/materials/it/pbr/clearcoat_normal/factor"]);
    let mut channel = map;
    channel["channel"] = json!("g");
    assert_eq!(with(channel), ["/materials/it/pbr/clearcoat_normal/channel"]);
    assert_eq!(with(json!({ "image": "data:image/png;base64,AAAA" })), ["/materials/it/pbr/clearcoat_normal/image"]);
}
