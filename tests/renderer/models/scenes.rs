//! Models as scenes: what is written for them, and that their parts may come in one body.

use super::files::format_of;
use crate::common::read as file;
use data_encoding::BASE64;
use serde_json::{Value, json};
use std::collections::HashMap;
use strahl::models::ModelFormat;
use strahl::scene::description::Object;
use strahl::scene::model::{Imported, ModelOptions, import};
use strahl::scene::{Files, Format, NoFiles, Overrides, load};

fn imported(name: &str, model: ModelOptions) -> Imported {
    let overrides = Overrides { model, ..Overrides::default() };
    import(format_of(name), &file(&format!("tests/inputs/models/{name}")), &overrides, &NoFiles).unwrap()
}

#[test]
fn instances_stay_instances() {
    let description = imported("own_instances_1000.glb", ModelOptions::default()).description;
    assert_eq!(description.definitions.len(), 1);
    let instances = description.objects.iter().filter(|object| matches!(object, Object::Instance(_))).count();
    assert_eq!(instances, 1_000);
}

/// What `strahl import` prints is the scene that is rendered.
#[test]
fn the_printed_scene_is_the_model() {
    for name in ["Box.glb", "UnlitTest.glb", "LightsPoint.glb", "Cameras.glb"] {
        let bytes = file(&format!("tests/inputs/models/{name}"));
        let description = imported(name, ModelOptions::default()).description;
        let text = serde_json::to_vec(&description).unwrap();
        let again =
            load(&text, Format::Json, &Overrides::default()).unwrap_or_else(|problems| panic!("{name}: {problems}"));
        let direct = load(&bytes, Format::Gltf, &Overrides::default()).unwrap();
        assert_eq!(again.description, direct.description, "{name}");
    }
}

/// The floor passes light on, which takes a ray.
#[test]
fn a_floor_that_is_black_since_chains_end_there_is_warned_of() {
    let bytes = file("tests/inputs/models/Box.glb");
    let warns = |max_depth: u32| {
        let overrides = Overrides { max_depth: Some(max_depth), ..Overrides::default() };
        let scene = load(&bytes, Format::Gltf, &overrides).unwrap().scene;
        scene.warnings.iter().any(|warning| warning.pointer == "/render/max_depth")
    };
    assert!(warns(1) && !warns(2));
    // Where nothing is of it, there is no floor.
    let text = r#"{ "version": 1, "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } }, "ambient": 1,
        "materials": { "floor": { "pbr": { "shadow_catcher": true } } }, "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1 } }],
        "render": { "max_depth": 1 } }"#;
    let scene = load(text.as_bytes(), Format::Json, &Overrides::default()).unwrap().scene;
    assert!(scene.warnings.iter().all(|warning| warning.pointer != "/render/max_depth"), "{:?}", scene.warnings);
}

/// As many characters as the schema allows, of two bytes each.
#[test]
fn warnings_of_a_scene_are_counted_in_characters() {
    let scene = |characters: usize| {
        let mut scene = serde_json::to_value(imported("Box.glb", ModelOptions::default()).description).unwrap();
        scene["import_warnings"] = json!([{ "code": "assumed", "detail": "é".repeat(characters) }]);
        load(scene.to_string().as_bytes(), Format::Json, &Overrides::default())
    };
    assert_eq!(scene(1_024).unwrap().description.import_warnings[0].detail.chars().count(), 1_024);
    let problems = scene(1_025).unwrap_err();
    assert!(problems.0[0].pointer == "/import_warnings/0/detail", "{problems}");
    assert!(problems.to_string().contains("import_warning_characters"), "{problems}");
}

#[test]
fn options_are_for_models_alone() {
    let options = ModelOptions { view: Some("top".parse().unwrap()), ..ModelOptions::default() };
    let overrides = Overrides { model: options, ..Overrides::default() };
    let problems = load(b"{}", Format::Json, &overrides).unwrap_err();
    assert!(problems.to_string().contains("are for models"), "{problems}");
    let camera = |view: &str| {
        let options = ModelOptions { view: Some(view.parse().unwrap()), ..ModelOptions::default() };
        imported("Box.glb", options).description.camera.view().eye
    };
    let [front, left, top] = ["front", "left", "top"].map(camera);
    assert!(front[2] > 1.0 && front[0].abs() < 0.01 && front[1].abs() < 1e-9, "{front:?}");
    assert!(left[0] > 1.0 && top[1] > 1.0, "{left:?} {top:?}");
}

/// A part of a body.
fn part(name: &str, bytes: &[u8]) -> Vec<u8> {
    let head = format!("--cut\r\nContent-Disposition: form-data; name=\"file\"; filename=\"{name}\"\r\n\r\n");
    [head.as_bytes(), bytes, b"\r\n"].concat()
}

#[test]
fn the_parts_of_a_model_come_in_one_body() {
    let [obj, mtl] = ["obj/cube.obj", "obj/cube.mtl"].map(|name| file(&format!("tests/inputs/models/{name}")));
    let body = [part("cube.mtl", &mtl), part("cube.obj", &obj), b"--cut--\r\n".to_vec()].concat();
    let loaded = load(&body, Format::Parts, &Overrides::default()).unwrap_or_else(|problems| panic!("{problems}"));
    assert!(!loaded.scene.from_files && loaded.description.materials.len() >= 3);
    // Without its materials it is grey, and says so.
    let alone = [part("cube.obj", &obj), b"--cut--\r\n".to_vec()].concat();
    let grey = load(&alone, Format::Parts, &Overrides::default()).unwrap();
    assert!(grey.scene.warnings.iter().any(|warning| warning.detail.starts_with("skipped: materials")));
    // A field of the form is no part of the model, and no setting.
    let field = b"--cut\r\nContent-Disposition: form-data; name=\"width\"\r\n\r\n64\r\n".to_vec();
    let with_field = [part("cube.mtl", &mtl), field, part("cube.obj", &obj), b"--cut--\r\n".to_vec()].concat();
    let skipped = load(&with_field, Format::Parts, &Overrides::default()).unwrap().scene;
    let details: Vec<&str> = skipped.warnings.iter().map(|warning| warning.detail.as_str()).collect();
    assert!(
        details.iter().any(|detail| detail.starts_with("skipped: form-fields: \"width\" is no file")),
        "{details:?}"
    );
    assert!(
        skipped.width == 512 && !loaded.scene.warnings.iter().any(|warning| warning.detail.contains("form-fields"))
    );
    // Nor is what the model does not name.
    let with_scene =
        [part("cube.mtl", &mtl), part("scene.json", b"{}"), part("cube.obj", &obj), b"--cut--\r\n".to_vec()].concat();
    let skipped = load(&with_scene, Format::Parts, &Overrides::default()).unwrap().scene;
    assert!(skipped.warnings.iter().any(|warning| warning.detail.starts_with("skipped: parts: \"scene.json\"")));
    assert!(!loaded.scene.warnings.iter().any(|warning| warning.detail.starts_with("skipped: parts")));
    // A buffer that is missing is named.
    let gltf = br#"{"asset":{"version":"2.0"},"buffers":[{"uri":"a b.bin","byteLength":4}]}"#;
    let lonely = [part("a.gltf", gltf), b"--cut--\r\n".to_vec()].concat();
    let problems = load(&lonely, Format::Parts, &Overrides::default()).unwrap_err();
    assert!(problems.0[0].pointer == "/buffers/0/uri" && problems.to_string().contains("a b.bin"), "{problems}");
    assert_eq!(format_of("cube.obj"), ModelFormat::Obj);
}

/// Files in memory, by their exact names.
struct Known<'a>(HashMap<&'a str, &'a [u8]>);

impl Files for Known<'_> {
    fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        self.0.get(name).map(|bytes| bytes.to_vec()).ok_or_else(|| "is not there".into())
    }
}

#[test]
fn parts_and_files_are_found_by_paths_as_windows_writes_them() {
    const RED: &[u8] = b"newmtl red\nKd 1 0 0\n";
    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
    let warnings = |named: &str, stored: &str| {
        let obj = format!("mtllib {named}\n{TRIANGLE}");
        let files = Known(HashMap::from([(stored, RED)]));
        let of_files = import(ModelFormat::Obj, obj.as_bytes(), &Overrides::default(), &files).unwrap();
        let body = [part("a.obj", obj.as_bytes()), part(stored, RED), b"--cut--\r\n".to_vec()].concat();
        let of_parts = load(&body, Format::Parts, &Overrides::default()).unwrap();
        [of_files.description, of_parts.description]
            .map(|scene| scene.import_warnings.iter().any(|warning| warning.detail.starts_with("skipped: materials")))
    };
    for named in ["mats/red.mtl", "mats\\red.mtl", ".\\mats\\red.mtl", "./mats//red.mtl"] {
        assert_eq!(warnings(named, "mats/red.mtl"), [false; 2], "{named}");
    }
    // Names of parts may be written so, too; a folder on disk has no such file.
    assert_eq!(warnings("mats/red.mtl", ".\\mats\\red.mtl"), [true, false]);
    assert_eq!(warnings("mats\\red.mtl", "mats\\red.mtl"), [false; 2]);
    for outside in
        ["..\\mats\\red.mtl", "/mats/red.mtl", "\\mats\\red.mtl", "C:\\mats\\red.mtl", "mats\\..\\mats\\red.mtl"]
    {
        assert_eq!(warnings(outside, "mats/red.mtl"), [true; 2], "{outside}");
    }
}

/// A triangle that stands at x = k from k/24 s on.
fn stepping(frames: u16) -> Vec<u8> {
    let mut bytes: Vec<u8> =
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend((0..frames).flat_map(|k| (f32::from(k) / 24.0).to_le_bytes()));
    bytes.extend((0..frames).flat_map(|k| [f32::from(k), 0.0, 0.0]).flat_map(f32::to_le_bytes));
    let uri = format!("data:application/octet-stream;base64,{}", BASE64.encode(&bytes));
    let view = |offset: usize, length: usize| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    let frames = usize::from(frames);
    json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "buffers": [{ "uri": uri, "byteLength": bytes.len() }],
        "bufferViews": [view(0, 36), view(36, 4 * frames), view(36 + 4 * frames, 12 * frames)],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "count": frames, "type": "SCALAR", "min": [0], "max": [frames] },
            { "bufferView": 2, "componentType": 5126, "count": frames, "type": "VEC3" }
        ],
        "animations": [{
            "samplers": [{ "input": 1, "output": 2, "interpolation": "STEP" }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }]
        }]
    })
    .to_string()
    .into_bytes()
}

/// Times of key frames are in single precision, those of pictures in double.
#[test]
fn a_picture_at_a_key_frame_shows_it() {
    let file = stepping(25);
    for k in 0..25 {
        let model = ModelOptions { t: Some(f64::from(k) / 24.0), ..ModelOptions::default() };
        let overrides = Overrides { model, ..Overrides::default() };
        let objects = import(ModelFormat::Gltf, &file, &overrides, &NoFiles).unwrap().description.objects;
        let Object::Mesh(mesh) = &objects[0] else { panic!("a triangle is a mesh") };
        assert_eq!(mesh.vertices[0][0], f64::from(k), "frame {k}");
    }
}

/// The picture of a file's camera has its shape, unless its size is asked for.
#[test]
fn pictures_have_the_shape_of_their_camera() {
    for (camera, shape) in [
        (json!({ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1, "aspectRatio": 4 } }), [512, 128]),
        (json!({ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }), [512, 512]),
        (
            json!({ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 2, "znear": 0.1, "zfar": 9 } }),
            [256, 512],
        ),
    ] {
        let mut file: Value = serde_json::from_slice(&stepping(1)).unwrap();
        file["cameras"] = json!([camera]);
        file["nodes"] = json!([{ "mesh": 0 }, { "camera": 0, "translation": [0, 0, 5] }]);
        file["scenes"][0]["nodes"] = json!([0, 1]);
        let size = |width: Option<u32>, height: Option<u32>| {
            let model = ModelOptions { camera: Some(0), ..ModelOptions::default() };
            let overrides = Overrides { model, width, height, ..Overrides::default() };
            let image =
                import(ModelFormat::Gltf, file.to_string().as_bytes(), &overrides, &NoFiles).unwrap().description.image;
            [image.width, image.height]
        };
        assert_eq!(size(None, None), shape, "{camera}");
        let [wide, tall] = shape;
        assert_eq!(size(Some(2 * wide), None), [2 * wide, 2 * tall], "{camera}");
        assert_eq!(size(Some(300), Some(200)), [300, 200], "{camera}");
    }
}
