//! Layers: numbers against formulas, ids that lead back to the scene, shares in mirrors and through glass, the same numbers
//! however the work is cut, and the files as other programs read them.

use crate::common::{load_scene, read, root, scene_names};
use exr::prelude::{AttributeValue, FlatSamples, ReadChannels, ReadLayers, Text};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::Cursor;
use strahl::camera::Window;
use strahl::film::cryptomatte::id;
use strahl::film::{FileFormat, Layer, Region, encode_exr_with};
use strahl::inspect::query::{RayQuery, answer};
use strahl::render::{Control, LayerKind, Layers, RayCounts, render_layers, render_window};
use strahl::scene::{Format, Overrides, Scene, load};

const ALL: &str = "distance,position,normal,albedo,object,material,share:/objects/0";

/// The tangent of half of the field of view: 25 degrees.
const HALF_VIEW: f64 = 0.466_307_658_154_999;

/// A ball over a floor in front of the eye; `more` are other objects and keys of the scene.
fn scene(more: &Value, objects: &[Value]) -> Scene {
    let mut scene = json!({
        "version": 1,
        "image": { "width": 60, "height": 40 },
        "camera": { "pinhole": { "eye": [0, 1, 6], "look_at": [0, 1, 0], "vfov_deg": 50 } },
        "lights": [{ "point": { "position": [3, 8, 5], "intensity": 1 } }],
        "materials": {
            "red": { "diffuse": [0.75, 0.25, 0.125] },
            "a/b": { "diffuse": 0.5 },
            "mirror": { "diffuse": 0, "reflection": [0.75, 0.75, 0.75] },
            "half": { "diffuse": 0, "transmission": 0.5 }
        },
        "objects": objects
    });
    for (key, value) in more.as_object().unwrap() {
        scene[key] = value.clone();
    }
    let text = scene.to_string();
    load(text.as_bytes(), Format::Json, &Overrides::default())
        .unwrap_or_else(|wrong| panic!("{wrong:?} in {text}"))
        .scene
}

fn ball_and_floor() -> [Value; 2] {
    [
        json!({ "sphere": { "center": [0, 1, 0], "radius": 1, "material": "red" } }),
        json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "a/b" } }),
    ]
}

fn layers_in(scene: &Scene, region: Region, layers: &str) -> Vec<(LayerKind, Layer)> {
    let window = Window::whole(scene.width, scene.height);
    render_layers(scene, &window, region, &Control::default(), layers.parse().unwrap()).unwrap().0
}

fn layers(scene: &Scene, layers: &str) -> Vec<Layer> {
    let region = Region::whole(scene.width, scene.height);
    layers_in(scene, region, layers).into_iter().map(|(_, layer)| layer).collect()
}

fn floats(layer: &Layer) -> &[f32] {
    match layer {
        Layer::Distance(values) | Layer::Share(_, values) => values,
        other => panic!("{other:?}"),
    }
}

fn vectors(layer: &Layer) -> &[[f32; 3]] {
    match layer {
        Layer::Position(values) | Layer::Normal(values) | Layer::Albedo(values) => values,
        other => panic!("{other:?}"),
    }
}

/// The shares of a name in each pixel.
fn shares(layer: &Layer, name: &str) -> Vec<f32> {
    let Layer::Ids(ids) = layer else { panic!("{layer:?}") };
    let wanted = id(name);
    assert_eq!(ids.manifest.get(name), Some(&wanted), "{name} in {:?}", ids.manifest);
    let of = |ranks: &[(u32, f32); 6]| ranks.iter().filter(|(id, _)| *id == wanted).map(|(_, share)| *share).sum();
    ids.pixels.iter().map(of).collect()
}

/// The direction of the ray through the middle of a pixel.
fn direction(scene: &Scene, [x, y]: [u32; 2]) -> [f64; 3] {
    let height = f64::from(scene.height);
    let across = (f64::from(x) + 0.5 - 0.5 * f64::from(scene.width)) / (0.5 * height) * HALF_VIEW;
    let up = (0.5 * height - f64::from(y) - 0.5) / (0.5 * height) * HALF_VIEW;
    let length = (across * across + up * up + 1.0).sqrt();
    [across / length, up / length, -1.0 / length]
}

#[test]
fn distances_points_and_normals_are_those_of_the_formulas() {
    let scene = scene(&json!({}), &ball_and_floor());
    let made = layers(&scene, "distance,position,normal");
    let (distances, points, normals) = (floats(&made[0]), vectors(&made[1]), vectors(&made[2]));
    let region = Region::whole(scene.width, scene.height);
    let mut met = [0; 3];
    for at in region.iter() {
        let (index, dir) = (region.index(at), direction(&scene, at));
        // The ball is 6 away, and the floor 1 below.
        let half = -6.0 * dir[2];
        let root = half * half - 35.0;
        let (what, t) = match () {
            () if root > 0.0 => (0, half - root.sqrt()),
            () if dir[1] < 0.0 => (1, -1.0 / dir[1]),
            () => (2, f64::INFINITY),
        };
        met[what] += 1;
        if what == 2 {
            assert_eq!((distances[index], points[index], normals[index]), (f32::INFINITY, [0.0; 3], [0.0; 3]));
            continue;
        }
        let point = [dir[0] * t, 1.0 + dir[1] * t, 6.0 + dir[2] * t];
        let normal = if what == 0 { [point[0], point[1] - 1.0, point[2]] } else { [0.0, 1.0, 0.0] };
        let room = 2e-5 * (1.0 + t * t);
        assert!((f64::from(distances[index]) - t).abs() < room, "{at:?}: {} {t}", distances[index]);
        for c in 0..3 {
            assert!((f64::from(points[index][c]) - point[c]).abs() < room, "{at:?}: {:?} {point:?}", points[index]);
            assert!((f64::from(normals[index][c]) - normal[c]).abs() < 1e-3, "{at:?}: {:?} {normal:?}", normals[index]);
        }
    }
    assert!(met.iter().all(|count| *count > 100), "{met:?}");
}

/// The same ray, asked for alone.
#[test]
fn the_middle_of_a_pixel_is_what_a_single_ray_meets() {
    for precision in ["single", "double"] {
        let scene = scene(&json!({ "render": { "precision": precision } }), &ball_and_floor());
        let made = layers(&scene, "distance,position");
        for at in [[30, 20], [28, 13], [5, 35]] {
            let index = Region::whole(60, 40).index(at);
            let ray = RayQuery { origin: [0.0, 1.0, 6.0], direction: direction(&scene, at), t_min: 0.0, t_max: None };
            let hit = answer(&scene, &ray).at.unwrap();
            assert!((f64::from(floats(&made[0])[index]) / hit.t - 1.0).abs() < 1e-5);
            let near = |(a, b): (&f32, &f64)| (f64::from(*a) - b).abs() < 1e-4;
            assert!(vectors(&made[1])[index].iter().zip(&hit.point).all(near));
        }
    }
}

#[test]
fn normals_face_the_eye_and_albedo_is_diffuse_color() {
    // Inside of a hollow room, from below a floor, and of a smooth mesh.
    let scene = scene(
        &json!({ "camera": { "pinhole": { "eye": [0, -1, 6], "look_at": [0, 0, 0], "vfov_deg": 50 } } }),
        &ball_and_floor(),
    );
    let made = layers(&scene, "normal,albedo");
    let middle = Region::whole(60, 40).index([30, 20]);
    assert_eq!(vectors(&made[0])[middle], [0.0, -1.0, 0.0]);
    assert_eq!(vectors(&made[1])[middle], [0.5; 3]);
}

#[test]
fn shares_of_ids_add_up_and_lead_back_to_the_scene() {
    let scene = scene(&json!({}), &ball_and_floor());
    let made = layers(&scene, "albedo,object,material");
    let [ball, floor] = ["/objects/0", "/objects/1"].map(|name| shares(&made[1], name));
    let [red, gray] = ["/materials/red", "/materials/a~1b"].map(|name| shares(&made[2], name));
    assert_eq!((&ball, &floor), (&red, &gray));
    let mut mixed = 0;
    for (index, albedo) in vectors(&made[0]).iter().enumerate() {
        let all = ball[index] + floor[index];
        assert!((0.0..=1.0).contains(&all) && (all * 16.0).fract() == 0.0);
        let expected = [0.75, 0.25, 0.125].map(|c| c * ball[index] + 0.5 * floor[index]);
        assert!(albedo.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{albedo:?} {expected:?}");
        mixed += u32::from(ball[index] > 0.0 && floor[index] > 0.0);
    }
    let covered = ball.iter().sum::<f32>() / ball.len() as f32;
    // The ball's picture is a disc, for the sine of its half angle is 1/6.
    let tangent = 1.0 / 35.0_f64.sqrt() / HALF_VIEW;
    let disc = std::f64::consts::PI * (20.0 * tangent) * (20.0 * tangent) / 2400.0;
    assert!((f64::from(covered) - disc).abs() < 0.003, "{covered} {disc}");
    assert!(mixed > 20, "{mixed} pixels at edges");
}

/// Everything that a group or a definition places belongs to the object that stands in `objects`.
#[test]
fn ids_of_groups_and_instances_are_those_of_the_scenes_own_objects() {
    let ball = |x: f64| json!({ "sphere": { "center": [x, 1, 0], "radius": 0.5, "material": "red" } });
    let objects = [
        json!({ "group": { "objects": [ball(-2.0), { "group": { "objects": [ball(-1.0)] } }] } }),
        json!({ "instance": { "of": "thing", "transform": { "translate": [1, 0, 0] } } }),
        json!({ "instance": { "of": "thing", "transform": { "translate": [2, 0, 0] } } }),
        json!({ "sphere": { "center": [0, 1, 0], "radius": 0.3 } }),
    ];
    let more =
        json!({ "definitions": { "thing": [{ "group": { "transform": { "scale": 0.9 }, "objects": [ball(0.0)] } }] } });
    let scene = scene(&more, &objects);
    let made = layers(&scene, "object,material");
    let sum = |name: &str| shares(&made[0], name).iter().sum::<f32>();
    assert!(sum("/objects/0") > 1.8 * sum("/objects/1") && sum("/objects/2") > 10.0);
    assert!(shares(&made[1], "default").iter().sum::<f32>() > 1.0);
    // And so for the share of one: another one of the same definition stays dark.
    for (object, name) in ["/objects/0", "/objects/1", "/objects/2"].iter().enumerate() {
        let share = layers(&scene, &format!("share:/objects/{object}"));
        assert_eq!(floats(&share[0]), shares(&made[0], name), "{name}");
    }
}

#[test]
fn a_share_counts_mirrors_and_glass_by_their_weight() {
    // The wall behind the eye is seen in a mirror; another half covers a pane.
    let wall = json!({ "box": { "min": [-90, -90, 8], "max": [90, 90, 9], "material": "red" } });
    let mirror = json!({ "triangle": { "vertices": [[-50, -50, 0], [50, -50, 0], [0, 90, 0]], "material": "mirror" } });
    let mirrored = scene(&json!({}), &[wall, mirror]);
    let share = layers(&mirrored, "share:/objects/0,object");
    // The mirror is what is seen, and the wall is three quarters of it.
    assert!(shares(&share[0], "/objects/1").iter().all(|share| *share == 1.0));
    assert!(floats(&share[1]).iter().all(|share| (share - 0.75).abs() < 1e-6), "{:?}", floats(&share[1]));
    assert!(floats(&layers(&mirrored, "share:/objects/1")[0]).iter().all(|share| *share == 1.0));

    let pane = json!({ "triangle": { "vertices": [[-50, -50, 3], [50, -50, 3], [0, 90, 3]], "material": "half" } });
    let [ball, floor] = ball_and_floor();
    let behind = scene(&json!({}), &[ball.clone(), floor.clone(), pane]);
    let plain = layers(&scene(&json!({}), &[ball, floor]), "share:/objects/0,object");
    assert_eq!(floats(&plain[1]), shares(&plain[0], "/objects/0"));
    let halves: Vec<f32> = floats(&plain[1]).iter().map(|share| 0.5 * share).collect();
    // The rays that go on from the pane are rounded, so a sample on an edge may fall to the other side.
    let made = layers(&behind, "share:/objects/0");
    let seen = floats(&made[0]);
    let off: Vec<f32> = seen.iter().zip(&halves).map(|(a, b)| (a - b).abs()).filter(|off| *off > 0.0).collect();
    assert!(off.len() <= 2 && off.iter().all(|off| *off <= 0.5 / 16.0), "{off:?}");
}

#[test]
fn what_is_partly_there_counts_as_much_as_is_there() {
    // Two veils one behind the other cover the picture, in front of a wall.
    let sheet = |z: f64, material: &str| json!({ "triangle": { "vertices": [[-50, -50, z], [50, -50, z], [0, 90, z]], "material": material } });
    let veil = |alpha: f64| json!({ "pbr": { "base_color": 0.5, "metallic": 0, "opacity": { "alpha": alpha } } });
    let hole = json!({ "pbr": { "base_color": 1, "opacity": { "alpha": 0.3, "mode": "mask" } } });
    let materials = json!({
        "thin": veil(0.25), "thick": veil(0.75), "hole": hole, "wall": { "diffuse": 1 },
        "catcher": { "pbr": { "shadow_catcher": true } }
    });
    let objects =
        [sheet(5.0, "hole"), sheet(4.0, "thin"), sheet(3.0, "thick"), sheet(0.0, "wall"), sheet(5.5, "catcher")];
    let scene = scene(&json!({ "materials": materials }), &objects);
    let made = layers(&scene, "distance,normal,albedo,object,material");
    let [distance, normal, albedo, objects, _] = &made[..] else { panic!("{made:?}") };
    for (i, name, share) in
        [(1, "thin", 0.25), (2, "thick", 0.75 * 0.75), (3, "wall", 0.75 * 0.25), (0, "hole", 0.0), (4, "catcher", 0.0)]
    {
        let alone = layers(&scene, &format!("share:/objects/{i}"));
        assert!(floats(&alone[0]).iter().all(|seen| (f64::from(*seen) - share).abs() < 1e-6), "{name}: {alone:?}");
        let Layer::Ids(ids) = objects else { panic!("{objects:?}") };
        assert_eq!(ids.manifest.contains_key(&format!("/objects/{i}")), share > 0.0, "{name}");
        if share > 0.0 {
            for (layer, path) in made[3..].iter().zip([format!("/objects/{i}"), format!("/materials/{name}")]) {
                let seen = shares(layer, &path);
                assert!(seen.iter().all(|seen| (f64::from(*seen) - share).abs() < 1e-6), "{path}: {seen:?}");
            }
        }
    }
    // The wall counts with its color, and both veils with theirs, less what a dielectric mirrors.
    let [red, ..] = vectors(albedo)[30 * 60 + 30];
    assert!(red > 0.1875 && red < 0.1875 + 0.5 * 0.8125, "{red}");
    // Half of the thick veil and more is there, so the middle of a pixel shows it.
    let middle = floats(distance)[20 * 60 + 30];
    assert!((middle - 3.0).abs() < 1e-3, "{middle}");
    assert!(vectors(normal).iter().all(|n| *n == [0.0, 0.0, 1.0]));
}

/// A quarter of a picture's texels is there, and there are eight of them in each pixel and direction: also of a mask a quarter
/// of each pixel, with one sample as with many.
#[test]
fn ids_see_textures_as_pictures_do() {
    let mut texels = image::RgbaImage::from_pixel(64, 64, image::Rgba([255, 255, 255, 0]));
    texels.enumerate_pixels_mut().for_each(|(x, y, pixel)| pixel.0[3] = if x % 2 == 0 && y % 2 == 0 { 255 } else { 0 });
    let mut png = Cursor::new(Vec::new());
    texels.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let source = format!("data:image/png;base64,{}", data_encoding::BASE64.encode(png.get_ref()));
    for (mode, samples) in [("blend", 16), ("mask", 16), ("blend", 1), ("mask", 1)] {
        let alpha = json!({ "image": source.as_str(), "channel": "a" });
        let more = json!({
            "image": { "width": 8, "height": 8 },
            "camera": { "orthographic": { "eye": [0.5, 0.5, 5], "look_at": [0.5, 0.5, 0], "height": 1 } },
            "film": { "background": "transparent" },
            "render": { "samples": samples },
            "materials": { "leaf": { "pbr": { "unlit": true, "opacity": { "alpha": alpha, "mode": mode } } } }
        });
        let leaf = json!({ "mesh": {
            "vertices": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "faces": [[0, 1, 2], [0, 2, 3]],
            "uvs": [[0, 0], [1, 0], [1, 1], [0, 1]], "material": "leaf"
        } });
        let scene = scene(&more, &[leaf]);
        let picture = render_window(&scene, &Window::whole(8, 8), Region::whole(8, 8), &Control::default()).unwrap();
        let made = layers(&scene, "object,share:/objects/0");
        let Layer::Ids(ids) = &made[0] else { panic!("{made:?}") };
        for ((alpha, ranks), share) in picture.film.alpha.iter().zip(&ids.pixels).zip(floats(&made[1])) {
            let of_ids = ranks[0].1;
            assert!((alpha - 0.25).abs() < 0.01 && (share - of_ids).abs() < 1e-6, "{mode}: {alpha} {of_ids} {share}");
            assert!(samples == 1 || (alpha - of_ids).abs() < 1e-6, "{mode}: {alpha} {of_ids}");
        }
    }
}

#[test]
fn layers_are_the_same_however_the_work_is_cut() {
    for name in ["effects/depth_of_field", "effects/motion_blur", "effects/bump", "refraction/glass_of_water"] {
        let scene = load_scene(name, 90, Overrides::default()).scene;
        let (whole, part) = (Region::whole(scene.width, scene.height), Region { x: 13, y: 9, width: 37, height: 22 });
        let all = layers_in(&scene, whole, ALL);
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert!(alone.install(|| layers_in(&scene, whole, ALL)) == all, "{name}");
        for ((_, whole_layer), (kind, layer)) in all.iter().zip(layers_in(&scene, part, ALL)) {
            assert!(crop(whole_layer, whole, part) == crop(&layer, part, part), "{name}: {kind:?}");
        }
    }
}

/// The bits of a part of a layer, without its manifest.
fn crop(layer: &Layer, from: Region, part: Region) -> Vec<u32> {
    let of = |index: usize| -> Vec<u32> {
        match layer {
            Layer::Distance(values) | Layer::Share(_, values) => vec![values[index].to_bits()],
            Layer::Position(v) | Layer::Normal(v) | Layer::Albedo(v) => v[index].map(f32::to_bits).to_vec(),
            Layer::Ids(ids) => ids.pixels[index].iter().flat_map(|(id, share)| [*id, share.to_bits()]).collect(),
        }
    };
    part.iter().flat_map(|at| of(from.index(at))).collect()
}

#[test]
fn single_lanes_meet_what_packets_meet() {
    let scene = load_scene("shapes/all", 64, Overrides::default()).scene;
    let whole = layers_in(&scene, Region::whole(scene.width, scene.height), ALL);
    for at in [[3, 30], [31, 17], [40, 25]] {
        let one = Region { x: at[0], y: at[1], width: 1, height: 1 };
        for ((_, all), (kind, alone)) in whole.iter().zip(layers_in(&scene, one, ALL)) {
            assert!(
                crop(all, Region::whole(scene.width, scene.height), one) == crop(&alone, one, one),
                "{kind:?} {at:?}"
            );
        }
    }
}

#[test]
fn every_scene_has_layers() {
    for name in scene_names() {
        let scene = load_scene(&name, 48, Overrides::default()).scene;
        for layer in layers(&scene, ALL) {
            if let Layer::Ids(ids) = &layer {
                let sums = ids.pixels.iter().map(|ranks| ranks.iter().map(|(_, share)| share).sum::<f32>());
                assert!(sums.into_iter().all(|sum| sum <= 1.0), "{name}");
                assert!(ids.pixels.iter().all(|ranks| ranks.is_sorted_by(|a, b| a.1 >= b.1)), "{name}");
            } else {
                let bits =
                    crop(&layer, Region::whole(scene.width, scene.height), Region::whole(scene.width, scene.height));
                assert!(bits.iter().all(|bits| !f32::from_bits(*bits).is_nan()), "{name}: {layer:?}");
            }
        }
    }
}

/// Pictures without layers trace what they did.
#[test]
fn no_layers_are_no_rays() {
    let scene = scene(&json!({}), &ball_and_floor());
    let window = Window::whole(60, 40);
    let made = render_layers(&scene, &window, Region::whole(60, 40), &Control::default(), Layers::default()).unwrap();
    assert_eq!(made, (Vec::new(), RayCounts::default()));
}

#[test]
fn names_of_layers_are_checked() {
    let wrong = |text: &str| text.parse::<Layers>().unwrap_err();
    let complaint = wrong("distance,normals");
    for part in ["normals", "did you mean \"normal\"", "distance, position, normal, albedo, object, material and share"]
    {
        assert!(complaint.contains(part), "{complaint}");
    }
    assert!(wrong("share").contains("share:/objects/3") && wrong("share:ball").contains("share:/objects/3"));
    assert!(wrong("share:/objects/1,share:/objects/2").contains("one of it"));
    assert!(wrong("object:/objects/1").contains("only share") && wrong("").contains("no layer"));
    let share: Layers = "share:/objects/2".parse().unwrap();
    assert!(share.check(&scene(&json!({}), &ball_and_floor())).unwrap_err().contains("2 objects"));
    assert_eq!(" normal, distance ".parse::<Layers>().unwrap().to_string(), "distance-normal");
}

/// The channels and texts of an EXR file.
fn read_exr(file: &[u8]) -> (BTreeMap<String, Vec<f32>>, BTreeMap<String, String>) {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(file))
        .unwrap();
    let channel = |channel: &exr::prelude::AnyChannel<FlatSamples>| {
        let FlatSamples::F32(values) = &channel.sample_data else { panic!("not floats") };
        (channel.name.to_string(), values.clone())
    };
    let channels = image.layer_data.channel_data.list.iter().map(channel).collect();
    let text = |(name, value): (&Text, &AttributeValue)| match value {
        AttributeValue::Text(text) => Some((name.to_string(), text.to_string())),
        _ => None,
    };
    let attributes = &image.layer_data.attributes.other;
    (channels, attributes.iter().chain(&image.attributes.other).filter_map(text).collect())
}

#[test]
fn one_exr_holds_them_all() {
    let scene = scene(&json!({}), &ball_and_floor());
    let region = Region { x: 7, y: 5, width: 40, height: 30 };
    let window = Window::whole(60, 40);
    let film = render_window(&scene, &window, region, &Control::default()).unwrap().film;
    let file = || encode_exr_with(&film, layers_in(&scene, region, ALL).into_iter().map(|(_, layer)| layer).collect());
    let (channels, texts) = read_exr(&file());
    assert!((0..8).all(|_| file() == file()), "the bytes are the same each time");

    let names: Vec<&str> = channels.keys().map(String::as_str).collect();
    for name in ["R", "G", "B", "Z", "P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z", "albedo.R", "share.Y"] {
        assert!(names.contains(&name), "{name} in {names:?}");
    }
    assert_eq!(names.len(), 3 + 1 + 3 + 3 + 3 + 12 + 12 + 1, "{names:?}");
    assert_eq!(channels["G"], film.pixels.iter().map(|pixel| pixel[1]).collect::<Vec<_>>());
    let made = layers_in(&scene, region, ALL);
    assert_eq!(channels["Z"], floats(&made[0].1));
    assert_eq!(channels["N.Y"], vectors(&made[2].1).iter().map(|n| n[1]).collect::<Vec<_>>());

    // As a compositing program does it: the names from the manifest, their ids as floats, and the shares beside these.
    for (what, value) in [("/conversion", "uint32_to_float32"), ("/hash", "MurmurHash3_32")] {
        assert_eq!(texts.iter().filter(|(name, text)| name.ends_with(what) && *text == value).count(), 2, "{texts:?}");
    }
    let manifests: Vec<Value> = texts
        .iter()
        .filter(|(name, _)| name.ends_with("/manifest"))
        .map(|(_, text)| serde_json::from_str(text).unwrap())
        .collect();
    assert_eq!((manifests.len(), &texts["share/object"]), (2, &"/objects/0".to_owned()));
    let manifest = manifests.iter().find(|manifest| manifest["/objects/1"].is_string()).unwrap();
    let wanted = f32::from_bits(u32::from_str_radix(manifest["/objects/1"].as_str().unwrap(), 16).unwrap());
    let mut found = vec![0.0; film.pixels.len()];
    for layer in ["crypto_object00", "crypto_object01", "crypto_object02"] {
        for [id, share] in [["R", "G"], ["B", "A"]].map(|pair| pair.map(|c| &channels[&format!("{layer}.{c}")])) {
            let matching = found.iter_mut().zip(id.iter().zip(share)).filter(|(_, (id, _))| **id == wanted);
            matching.for_each(|(sum, (_, share))| *sum += share);
        }
    }
    assert_eq!(found, shares(&made[4].1, "/objects/1"));
}

#[test]
fn pictures_of_layers_say_what_their_codes_mean() {
    let scene = scene(&json!({}), &ball_and_floor());
    let region = Region::whole(60, 40);
    let at = |name: &str, format: FileFormat| {
        let png = layers_in(&scene, region, name).swap_remove(0).1.png(region, format);
        // The text begins where the first brace stands, and is followed by the next chunk.
        let start = png.iter().position(|byte| *byte == b'{').unwrap();
        let note: Value = serde_json::Deserializer::from_slice(&png[start..]).into_iter().next().unwrap().unwrap();
        (image::load_from_memory(&png).unwrap().to_rgb8(), note)
    };
    let (picture, note) = at("object", FileFormat::Png8);
    let [r, g, b] = picture.get_pixel(30, 20).0;
    assert_eq!(note["colors"]["/objects/0"], format!("#{r:02x}{g:02x}{b:02x}"), "{note}");
    assert_eq!(picture.get_pixel(0, 0).0, [0; 3]);
    // The front of the ball is 5 away. What the text says is enough to read that from the code.
    let (picture, note) = at("distance", FileFormat::Png8);
    let [near, far] = ["white", "darkest"].map(|end| note[end].as_f64().unwrap());
    let part = (f64::from(picture.get_pixel(30, 20).0[0]) - 1.0) / 254.0;
    let distance = 1.0 / (1.0 / far + part * (1.0 / near - 1.0 / far));
    assert!((distance - 5.0).abs() < 0.05 && note["steps"] == "1/distance", "{distance}: {note}");
    assert!(picture.get_pixel(0, 22).0[0] >= 1 && picture.get_pixel(0, 0).0 == [0; 3]);
    let (picture, _) = at("normal", FileFormat::Png16);
    assert_eq!(picture.get_pixel(0, 39).0, [128, 255, 128]);
}

/// A person has looked at these pictures.
#[test]
fn pictures_of_layers_look_as_they_did() {
    let scene = load_scene("shapes/all", 240, Overrides::default()).scene;
    let region = Region::whole(scene.width, scene.height);
    for (kind, layer) in layers_in(&scene, region, "distance,position,normal,albedo,object,material,share:/objects/11")
    {
        let path = format!("docs/pictures/layer-{}.png", kind.name());
        let png = layer.png(region, FileFormat::Png8);
        if std::env::var_os("UPDATE_GOLDEN").is_some() {
            std::fs::write(root().join(&path), &png).unwrap();
        }
        let pixels = |png: &[u8]| image::load_from_memory(png).unwrap().to_rgb8();
        assert!(pixels(&png) == pixels(&read(&path)), "{path}");
    }
}
