//! A frame of a sequence is the scene that it says it is: the same pixels as that scene alone, whatever moves.

use serde_json::{Value, json};
use std::convert::Infallible;
use std::sync::Arc;
use strahl::film::Region;
use strahl::models::ModelFormat;
use strahl::render::{Control, render};
use strahl::scene::compile::{Original, Precise};
use strahl::scene::description::Camera;
use strahl::scene::model::{ModelOptions, import};
use strahl::scene::{Files, Format, Loaded, NoFiles, NotLoaded, Overrides, Problems, Scene, load, load_with};
use strahl::sequence::Sequence;

/// Bodies of which one moves while the shutter is open, and glass.
fn scene() -> Value {
    json!({
        "version": 1,
        "image": { "width": 32, "height": 20 },
        "camera": { "pinhole": { "eye": [0.3, 1.5, 6], "look_at": [0, 0.5, 0] } },
        "background": [0.3, 0.5, 0.8],
        "materials": {
            "glass": { "diffuse": 0.05, "transmission": 0.9, "reflection": 0.1, "ior": 1.5 },
            "red": { "diffuse": [0.8, 0.2, 0.1], "specular": 0.5 },
        },
        "definitions": { "ball": [{ "sphere": { "center": [0, 0, 0], "radius": 0.4, "material": "red" } }] },
        "objects": [
            { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0] } },
            { "sphere": { "center": [-1, 0.7, 0], "radius": 0.7, "material": "glass" } },
            { "box": { "min": [-0.5, 0, -2], "max": [1.5, 0.8, -1], "material": "red" } },
            { "instance": { "of": "ball", "transform": { "translate": [0.5, 0.4, 1] },
                            "motion": { "translate": [0.25, 0, 0], "rotate_deg": { "axis": [0, 1, 0], "angle": 90 } } } },
        ],
        "render": { "max_depth": 4, "samples": 2 },
    })
}

fn loaded(text: &Value) -> Loaded {
    load(text.to_string().as_bytes(), Format::Json, &Overrides::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn sequence(json: Value) -> Sequence {
    let sequence = unchecked(&json);
    sequence.check().unwrap_or_else(|error| panic!("{error}"));
    sequence
}

fn unchecked(json: &Value) -> Sequence {
    serde_json::from_str(&json.to_string()).unwrap()
}

fn frame(base: &Loaded, sequence: &Sequence, number: u32) -> Result<Loaded, Problems> {
    let original = Original { description: &base.description, scene: &base.scene };
    let accept = |_: &_| Ok::<_, Infallible>(());
    let loaded = sequence.frame(number).load_if(original, &Overrides::default(), &NoFiles, &accept);
    loaded.map_err(|NotLoaded::Problems(problems)| problems)
}

/// The models of the tests.
struct Models;

impl Files for Models {
    fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/inputs/models/");
        std::fs::read(format!("{folder}{name}")).map_err(|why| why.to_string())
    }
}

/// A model, in a group and as a definition, that was so long in motion.
fn with_models(t: [Option<f64>; 2]) -> Value {
    let model = |t: Option<f64>| {
        let mut model = json!({ "asset": "RiggedFigure.glb" });
        if let Some(t) = t {
            model["t"] = json!(t);
        }
        json!({ "model": model })
    };
    let mut scene = scene();
    scene["definitions"]["morphed"] = json!([model(t[0])]);
    scene["objects"] = json!([
        { "group": { "objects": [model(t[1])], "transform": { "translate": [-1, 1, 0] } } },
        { "instance": { "of": "morphed", "transform": { "translate": [1, 0.5, 0] } } },
    ]);
    scene
}

fn pixels(scene: &Scene) -> Vec<[u32; 3]> {
    let picture = render(scene, Region::whole(scene.width, scene.height), &Control::default()).unwrap();
    picture.film.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

fn camera(loaded: &Loaded) -> Camera {
    loaded.description.camera.clone()
}

#[test]
fn a_frame_is_its_scene_alone_to_the_last_bit() {
    let base = loaded(&scene());
    let keys = json!([
        { "t": 0, "eye": [0, 1, 6], "vfov_deg": 40 },
        { "t": 0.4, "eye": [3, 2, 4], "look_at": [0, 0.5, 0], "ease": "in_out" },
        { "t": 1, "eye": [4, 1, -3], "vfov_deg": 60 },
    ]);
    let patches: Vec<Value> =
        (0..4).map(|n| json!({ "materials": { "red": { "diffuse": 0.2 * f64::from(n) } } })).collect();
    for told in [
        json!({ "count": 5, "turntable": {} }),
        json!({ "count": 4, "turntable": { "axis": [1, 2, 0], "center": [0.5, 0, 0], "degrees": -100 } }),
        json!({ "count": 6, "camera": keys }),
        json!({ "count": 6, "camera": keys, "turntable": {}, "shutter": 0.5 }),
        json!({ "patches": patches, "turntable": {} }),
        json!({ "patches": [{}, { "objects": [{ "sphere": { "center": [0, 1, 0], "radius": 1 } }] }] }),
    ] {
        let sequence = unchecked(&told);
        let all: Vec<_> = (0..sequence.count()).map(|number| frame(&base, &sequence, number).unwrap()).collect();
        let pictures: Vec<_> = all.iter().map(|loaded| pixels(&loaded.scene)).collect();
        for (loaded_frame, picture) in all.iter().zip(&pictures) {
            let alone = loaded(&serde_json::to_value(&loaded_frame.description).unwrap());
            assert_eq!(pixels(&alone.scene), *picture, "{told}");
        }
        assert!(pictures.windows(2).all(|two| two[0] != two[1]), "{told}: each is another picture");
    }
}

#[test]
fn without_anything_that_moves_all_frames_are_the_scene() {
    let base = loaded(&scene());
    for told in [json!({ "count": 3 }), json!({ "count": 1, "turntable": {}, "shutter": 1 })] {
        let sequence = sequence(told);
        for number in 0..sequence.count() {
            assert_eq!(frame(&base, &sequence, number).unwrap().description, base.description);
        }
    }
}

#[test]
fn keys_are_met_exactly_and_what_no_key_says_stays() {
    let base = loaded(&scene());
    let keys = json!([
        { "t": 0, "eye": [0.1, 1.7, 6.3], "vfov_deg": 33.3, "ease": "out" },
        { "t": 0.25, "eye": [3.3, 2.2, 4.1], "ease": "in" },
        { "t": 0.5, "look_at": [0.7, 0.1, 0.2] },
        { "t": 1, "eye": [-4.4, 1.9, -3.7], "vfov_deg": 61.7 },
    ]);
    let moved = sequence(json!({ "count": 9, "camera": keys }));
    let at = |number: u32| camera(&frame(&base, &moved, number).unwrap());
    let expected = |eye: [f64; 3], vfov: Option<f64>, found: Camera| {
        let Camera::Pinhole(found) = found else { panic!("it is a pinhole camera") };
        assert_eq!((found.eye, found.look_at, found.up), (eye, [0.7, 0.1, 0.2], [0.0, 1.0, 0.0]));
        assert!(vfov.is_none_or(|vfov| vfov == found.vfov_deg), "{found:?}");
    };
    expected([0.1, 1.7, 6.3], Some(33.3), at(0));
    expected([3.3, 2.2, 4.1], None, at(2));
    expected([-4.4, 1.9, -3.7], Some(61.7), at(8));

    // A closed path comes back: the frame after the last one would be the first.
    let keys = json!([{ "t": 0, "eye": [0, 1, 6] }, { "t": 0.5, "eye": [0, 2, 3] }]);
    let closed = sequence(json!({ "count": 8, "closed": true, "camera": keys }));
    let heights: Vec<f64> = (0..8).map(|n| camera(&frame(&base, &closed, n).unwrap()).view().eye[1]).collect();
    assert_eq!((heights[0], heights[4]), (1.0, 2.0));
    for n in 1..4 {
        assert!((heights[n] - heights[8 - n]).abs() < 1e-12, "there and back: {heights:?}");
    }
}

/// The shutter is open for half of the time: two shutters from one frame to the next.
#[test]
fn moving_bodies_go_on_where_the_shutter_would_have_them() {
    let base = loaded(&scene());
    let moved = sequence(json!({ "count": 3, "shutter": 0.5 }));
    let mut there = scene();
    // Half a turn around the origin, and twice the shift.
    let body = &mut there["objects"][3]["instance"];
    body["transform"] = json!({ "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0.4, -1, 1] });
    body["motion"]["center"] = json!([0.5, 0, 0]);
    let found = frame(&base, &moved, 1).unwrap();
    let objects = &serde_json::to_value(&found.description).unwrap()["objects"];
    assert_eq!(objects[3]["instance"]["motion"]["center"], json!([0.5, 0.0, 0.0]));
    assert_eq!(pixels(&found.scene), pixels(&loaded(&there).scene));
}

#[test]
fn moving_cameras_share_the_geometry() {
    let base = loaded(&scene());
    let geometries = |scene: &Scene| match &scene.world {
        Precise::Single(world) => Arc::clone(&world.geometries),
        Precise::Double(_) => panic!("it is in single precision"),
    };
    let around = sequence(json!({ "count": 12, "turntable": {} }));
    for number in 0..12 {
        let frame = frame(&base, &around, number).unwrap();
        assert!(Arc::ptr_eq(&geometries(&frame.scene), &geometries(&base.scene)), "{number}");
    }
}

/// A second of frames is two of the animation.
#[test]
fn animations_of_models_go_on() {
    let with =
        |t| load_with(with_models(t).to_string().as_bytes(), Format::Json, &Overrides::default(), &Models).unwrap();
    let accept = |_: &_| Ok::<_, Infallible>(());
    let sequence = sequence(json!({ "count": 4, "rate": 10, "play": 2 }));
    let frame = |base: &Loaded, number| {
        let original = Original { description: &base.description, scene: &base.scene };
        sequence.frame(number).load_if(original, &Overrides::default(), &Models, &accept)
    };
    let base = with([Some(0.5), Some(0.0)]);
    let mut pictures = Vec::new();
    for number in 0..4 {
        let seconds = f64::from(number) / 10.0 * 2.0;
        let alone = with([Some(0.5 + seconds), Some(seconds)]);
        pictures.push(pixels(&frame(&base, number).unwrap().scene));
        assert_eq!(pictures.last(), Some(&pixels(&alone.scene)), "frame {number}");
    }
    assert!(pictures.windows(2).all(|two| two[0] != two[1]), "the figure walks");

    let at_rest = with([None, None]);
    let Err(NotLoaded::Problems(Problems(problems))) = frame(&at_rest, 1) else { panic!("nothing plays") };
    assert!(problems[0].pointer == "/objects" && problems[0].detail.contains("nothing here plays"), "{problems:?}");
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let key = |t: f64| json!({ "t": t, "eye": [0, 0, 1] });
    for (told, pointer) in [
        (json!({}), "/frames/count"),
        (json!({ "count": 0 }), "/frames/count"),
        (json!({ "count": 1_000_000_000 }), "/frames/count"),
        (json!({ "count": 2, "rate": 0 }), "/frames/rate"),
        (json!({ "count": 2, "rate": 1e300 }), "/frames/rate"),
        (json!({ "count": 2, "shutter": 0 }), "/frames/shutter"),
        (json!({ "count": 2, "shutter": 1.5 }), "/frames/shutter"),
        (json!({ "count": 2, "play": 0 }), "/frames/play"),
        (json!({ "count": 2, "play": 1e9 }), "/frames/play"),
        (json!({ "count": 2, "turntable": { "degrees": 1e9 } }), "/frames/turntable/degrees"),
        (json!({ "count": 2, "turntable": { "axis": [0, 0, 0] } }), "/frames/turntable/axis"),
        (json!({ "count": 2, "turntable": { "center": [1e300, 0, 0] } }), "/frames/turntable/center"),
        (json!({ "count": 2, "camera": [key(0.0), key(0.5), key(0.5)] }), "/frames/camera/2/t"),
        (json!({ "count": 2, "camera": [key(0.6), key(0.5)] }), "/frames/camera/1/t"),
        (json!({ "count": 2, "camera": [key(-0.1)] }), "/frames/camera/0/t"),
        (json!({ "count": 2, "closed": true, "camera": [key(0.0), key(1.0)] }), "/frames/camera/1/t"),
        (json!({ "count": 2, "camera": [{ "t": 0 }] }), "/frames/camera/0"),
        (json!({ "count": 2, "camera": [{ "t": 0, "eye": [0, 1e300, 0] }] }), "/frames/camera/0/eye"),
        (json!({ "count": 2, "camera": vec![key(0.0); 2_000] }), "/frames/camera"),
        (json!({ "count": 3, "patches": [{}, {}] }), "/frames/patches"),
    ] {
        let Problems(problems) = unchecked(&told).check().unwrap_err();
        assert!(problems.iter().any(|problem| problem.pointer == pointer), "{told}: {problems:?}");
    }
    for no_json in [r#"{"count": 2, "camera": [{"t": NaN}]}"#, r#"{"count": 1e9999}"#, r#"{"count": 2, "shuter": 1}"#] {
        assert!(serde_json::from_str::<Sequence>(no_json).is_err(), "{no_json}");
    }
}

#[test]
fn a_problem_of_a_frame_names_the_frame() {
    let base = loaded(&scene());
    for (told, number, pointer) in [
        (json!({ "count": 3, "camera": [{ "t": 0, "height": 1 }] }), 0, "/camera/pinhole"),
        (
            json!({ "count": 3, "camera": [{ "t": 0, "vfov_deg": 20 }, { "t": 1, "vfov_deg": 200 }] }),
            2,
            "/camera/pinhole/vfov_deg",
        ),
        (json!({ "patches": [{}, { "materials": { "red": { "diffuse": -1 } } }] }), 1, "/materials/red/diffuse"),
        (json!({ "patches": [{}, []] }), 1, ""),
    ] {
        let Problems(problems) = frame(&base, &unchecked(&told), number).unwrap_err();
        assert!(problems[0].detail.starts_with(&format!("in frame {number}: ")), "{told}: {problems:?}");
        assert_eq!(problems[0].pointer, pointer, "{told}: {problems:?}");
    }
}

/// Also where the camera looks down, and its own up direction lies flat.
#[test]
fn a_model_is_turned_around_the_vertical() {
    let bytes = Models.read("Box.glb").unwrap();
    for view in ["top", "front", "-20,30"] {
        let model = ModelOptions { view: Some(view.parse().unwrap()), around: Some(true), ..ModelOptions::NONE };
        let overrides = Overrides { model, ..Overrides::default() };
        let start = import(ModelFormat::Gltf, &bytes, &overrides, &NoFiles).unwrap().description;
        let sequence = Sequence::turntable(8).of_model();
        let mut ups = Vec::new();
        for number in 0..8 {
            let mut turned = start.clone();
            sequence.frame(number).place(&mut turned).unwrap();
            let [first, now] = [start.camera.view(), turned.camera.view()];
            assert!((now.eye[1] - first.eye[1]).abs() < 1e-9 * first.eye[1].abs().max(1.0), "{view} {number}");
            ups.push(now.up);
        }
        assert_eq!(ups.iter().any(|up| *up != ups[0]), view == "top", "{view}: {ups:?}");
    }
}
