//! Pictures from all around in one answer, jobs of models, and settings of the film and of sizes.

use crate::common::BALL;
use crate::common::farm::wait_until;
use crate::common::service::{Answer, PROGRAM, Service};
use image::ImageFormat;
use serde_json::{Value, json};
use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

const GLB: (&str, &str) = ("Content-Type", "model/gltf-binary");

fn file(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/inputs/models").join(name)).unwrap()
}

fn of_model(service: &Service, query: &str, bytes: &[u8]) -> Answer {
    service.send("POST", &format!("/v1/render?{query}"), &[GLB], bytes)
}

/// The command keeps all of the model in each picture, too, and turns it around the vertical from above.
#[test]
fn the_command_turns_a_model_as_the_service_does() {
    let service = Service::start(&[]);
    let picture = std::env::temp_dir().join(format!("strahl-turned-{}.png", std::process::id()));
    for view in ["three_quarter", "top"] {
        let query = format!("turntable=3&width=40&height=32&view={view}");
        let expected = of_model(&service, &query, &file("BoxVertexColors.glb"));
        let mut command = Command::new(PROGRAM);
        command.arg("render").arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/inputs/models/BoxVertexColors.glb"));
        command.args(["--frames", "3", "--width", "40", "--height", "32", "--view", view, "-o"]).arg(&picture);
        assert!(command.output().unwrap().status.success());
        assert!(std::fs::read(&picture).unwrap() == expected.body, "{view}");
    }
    std::fs::remove_file(picture).unwrap();
}

/// Nobody else knows of its job.
#[test]
fn a_client_that_goes_away_deletes_its_turntable() {
    let service = Service::start(&["--timeout", "300"]);
    let states = || -> Vec<String> {
        let jobs = service.get("/v1/jobs").json();
        jobs["jobs"].as_array().unwrap().iter().map(|job| job["state"].as_str().unwrap().to_owned()).collect()
    };
    let is_begun = || states().iter().any(|state| state == "running");
    let path = "/v1/render?turntable=300&width=600&height=600&samples=16";
    let [first, second] = [(); 2].map(|()| service.begin(path, BALL));
    wait_until("it has begun", is_begun);
    // On a busy machine the second may only now ask for it.
    std::thread::sleep(Duration::from_millis(500));
    drop(first);
    std::thread::sleep(Duration::from_millis(300));
    wait_until("the other one waits for it", is_begun);
    drop(second);
    wait_until("it is gone", || states().is_empty());
    service.wait_for(0, 0);
    // With a key the client can come back.
    let named = service.begin_with(path, &[("Idempotency-Key", "mine")], BALL);
    wait_until("another one has begun", is_begun);
    drop(named);
    std::thread::sleep(Duration::from_millis(300));
    assert!(is_begun(), "{:?}", states());
}

/// Nobody has sent a key, so nobody is told of one.
#[test]
fn the_same_turntable_asked_for_by_several_at_once_is_one_job() {
    let service = Service::start(&[]);
    let cube = file("BoxVertexColors.glb");
    let ask = || of_model(&service, "turntable=4&width=90&height=70", &cube);
    let answers: Vec<Answer> = std::thread::scope(|scope| {
        let asking: Vec<_> = (0..6).map(|_| scope.spawn(ask)).collect();
        asking.into_iter().map(|asked| asked.join().unwrap()).collect()
    });
    for answer in &answers {
        assert!(answer.status == 200 && answer.body == answers[0].body, "{}", answer.text());
    }
    assert_eq!(service.get("/v1/jobs").json()["jobs"].as_array().unwrap().len(), 1);

    let preferred = [GLB, ("Prefer", "respond-async")];
    let answer = service.send("POST", "/v1/render?turntable=200&width=200&height=200", &preferred, &cube);
    assert_eq!((answer.status, answer.header("preference-applied")), (202, "respond-async"), "{}", answer.text());
}

/// The number of frames that an animated PNG says it has.
fn frames(apng: &[u8]) -> u32 {
    let at = apng.windows(4).position(|window| window == b"acTL").expect("it is animated");
    u32::from_be_bytes(apng[at + 4..at + 8].try_into().unwrap())
}

#[test]
fn a_model_is_seen_from_all_around() {
    let service = Service::start(&[]);
    let cube = file("BoxVertexColors.glb");
    let query = "turntable=5&width=40&height=32";
    let turned = of_model(&service, query, &cube);
    assert_eq!((turned.status, turned.header("content-type")), (200, "image/apng"), "{}", turned.text());
    assert_eq!(frames(&turned.body), 5);
    let again = of_model(&service, query, &cube);
    assert!(again.body == turned.body);
    let jobs = service.get("/v1/jobs").json()["jobs"].as_array().unwrap().clone();
    assert_eq!(jobs.len(), 1, "the same request finds the job of the first");
    let first = format!("/v1/jobs/{}/frames/0", jobs[0]["id"].as_str().unwrap());
    let first = service.get(&first).picture();
    let last = service.get(&format!("/v1/jobs/{}/frames/3", jobs[0]["id"].as_str().unwrap())).picture();
    assert!(first != last);
    for picture in [&first, &last] {
        let seen = picture.to_rgba8();
        let edge = (0..40).flat_map(|x| [(x, 0), (x, 31)]).chain((0..32).flat_map(|y| [(0, y), (39, y)]));
        // The shadow on the floor may reach it, the cube may not.
        assert!(edge.into_iter().all(|(x, y)| seen.get_pixel(x, y)[3] < 200));
        assert!(seen.pixels().filter(|pixel| pixel[3] == 255).count() > 40);
    }

    // A sheet, or another format, is of the same frames.
    let webp = of_model(&service, &format!("{query}&format=webp"), &cube);
    assert_eq!((webp.status, webp.header("content-type")), (200, "image/webp"));
    assert_eq!(of_model(&service, &format!("{query}&sheet=5x1"), &cube).header("content-type"), "image/png");
    assert_eq!(service.get("/v1/jobs").json()["jobs"].as_array().unwrap().len(), 1);

    let webp = of_model(&service, "turntable=3&width=24&height=24&format=webp", &cube);
    assert_eq!((webp.status, webp.header("content-type")), (200, "image/webp"));
    let gif = of_model(&service, "turntable=3&width=64&height=64&view=front&format=gif", &cube);
    assert_eq!((gif.status, gif.header("content-type")), (200, "image/gif"));
    let warnings = gif.header("render-warnings");
    assert!(
        warnings.contains("GIF has 256 colors a picture: up to ") && warnings.contains(" in the mean"),
        "{warnings}"
    );
    let slow = of_model(&service, "turntable=2&width=16&height=16&rate=5", &cube).body;
    let control = slow.windows(4).position(|name| name == b"fcTL").unwrap() + 4;
    let delay = [20, 22].map(|at| u16::from_be_bytes([slow[control + at], slow[control + at + 1]]));
    assert_eq!(delay[0] * 5, delay[1], "frames are shown for a fifth of a second");
    let sheet = of_model(&service, "turntable=4&width=24&height=24&sheet=2x2", &cube);
    assert_eq!((sheet.status, sheet.header("content-type")), (200, "image/png"));
    let [width, height] = [sheet.picture().width(), sheet.picture().height()];
    assert!(width >= 48 && height >= 48, "{width} x {height}");
    let scene = service.post_json("/v1/render?turntable=2&width=16&height=16", BALL);
    assert_eq!(frames(&scene.body), 2, "scenes are turned, too");

    of_model(&service, "turntable=4&sheet=1x3", &cube).problem(400, "invalid-parameter");
    of_model(&service, "turntable=1000", &cube).problem(400, "invalid-parameter");
    let wrong = |query: &str| of_model(&service, query, &cube).problem(400, "invalid-parameter")["detail"].to_string();
    for alone in ["sheet=2x2", "rate=5"].map(wrong) {
        assert!(alone.contains("belongs to a turntable") && !alone.contains("no parameter"), "{alone}");
    }
    for other in ["bits=16", "quality=50", "layers=normal"] {
        let said = wrong(&format!("turntable=2&{other}"));
        assert!(said.contains("a turntable has none") && !said.contains("no parameter"), "{said}");
    }
    let webp = wrong("turntable=4&sheet=2x2&format=webp");
    assert!(webp.contains("format: a contact sheet is a PNG"), "{webp}");
    assert!(of_model(&service, "turntable=4&width=24&height=24&sheet=2x2&format=png", &cube).body == sheet.body);
}

/// A triangle with one texture, of an image as glTF describes it; the third view has bytes of a picture.
fn textured(image: &Value, bytes: &[u8]) -> Vec<u8> {
    with_material(&json!({}), image, bytes)
}

/// The same with more in its material.
fn with_material(extensions: &Value, image: &Value, bytes: &[u8]) -> Vec<u8> {
    let positions: Vec<u8> =
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let uvs: Vec<u8> = [0.0_f32, 0.0, 1.0, 0.0, 0.0, 1.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let mut bin = [&positions[..], &uvs, bytes].concat();
    bin.resize((bin.len() + 4).next_multiple_of(4), 0);
    let gltf = json!({
        "asset": { "version": "2.0" },
        "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "material": 0 }] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } }, "extensions": extensions }],
        "textures": [{ "source": 0 }],
        "images": [image],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 24 },
            { "buffer": 0, "byteOffset": 60, "byteLength": bytes.len().max(1) },
        ],
        "buffers": [{ "byteLength": bin.len() }],
    });
    let mut text = gltf.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
    let chunks = [chunk(b"JSON", &text), chunk(b"BIN\0", &bin)].concat();
    [&b"glTF\x02\0\0\0"[..], &(chunks.len() as u32 + 12).to_le_bytes(), &chunks].concat()
}

fn picture_file(format: ImageFormat) -> Vec<u8> {
    let picture =
        image::RgbImage::from_fn(96, 96, |x, y| image::Rgb([(x * y) as u8, (x ^ y) as u8, (3 * x + y) as u8]));
    let mut file = std::io::Cursor::new(Vec::new());
    image::DynamicImage::from(picture).write_to(&mut file, format).unwrap();
    file.into_inner()
}

/// The problem says which of the file's pictures it is, and is none of our scene's.
#[test]
fn pictures_that_are_cut_off_are_named_as_the_file_has_them() {
    let service = Service::start(&[]);
    let inside = json!({ "bufferView": 2 });
    for format in [ImageFormat::Jpeg, ImageFormat::Png, ImageFormat::WebP] {
        let whole = picture_file(format);
        let good = of_model(&service, "width=16&height=16", &textured(&inside, &whole));
        assert_eq!(good.status, 200, "{format:?}: {}", good.text());
        for share in [2, 4] {
            let half = textured(&inside, &whole[..whole.len() / share]);
            let problem = of_model(&service, "width=16&height=16", &half).problem(422, "invalid-scene");
            assert_eq!(problem["errors"].as_array().unwrap().len(), 1, "{format:?}: {problem}");
            assert_eq!(problem["errors"][0]["pointer"], "#/images/0", "{format:?}: {problem}");
        }
    }
    // Where a scene places the model, the place is there, and the picture in the sentence.
    let jpeg = picture_file(ImageFormat::Jpeg);
    let cut = textured(&inside, &jpeg[..jpeg.len() / 2]);
    let sent = service.send("POST", "/v1/assets", &[], &cut).json();
    let scene = json!({
        "version": 1, "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
        "objects": [{ "model": { "asset": sent["asset"] } }],
    });
    let problem = service.post_json("/v1/render", &scene.to_string()).problem(422, "invalid-scene");
    assert_eq!(problem["errors"][0]["pointer"], "#/objects/0/model", "{problem}");
    let detail = problem["errors"][0]["detail"].as_str().unwrap();
    assert!(detail.starts_with("in the model: /images/0: the picture is cut off"), "{detail}");
}

#[test]
fn data_uris_have_all_of_their_forms() {
    let service = Service::start(&[]);
    let png = picture_file(ImageFormat::Png);
    let base64 = data_encoding::BASE64.encode(&png);
    let percent: String = png.iter().map(|byte| format!("%{byte:02x}")).collect();
    let picture = |uri: String| {
        let answer = of_model(&service, "width=24&height=24&format=png", &textured(&json!({ "uri": uri }), b""));
        assert_eq!(answer.status, 200, "{}", answer.text());
        answer.body
    };
    let scene = |uri: &str| {
        let scene = json!({
            "version": 1, "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
            "image": { "width": 24, "height": 24 },
            "ambient": 1,
            "materials": { "red": { "diffuse": { "image": { "source": uri, "mapping": { "spherical": {} } } } } },
            "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "red" } }],
        });
        let answer = service.post_json("/v1/render?format=png", &scene.to_string());
        assert_eq!(answer.status, 200, "{}", answer.text());
        answer.body
    };
    let usual = format!("data:image/png;base64,{base64}");
    let forms = [
        format!("DATA:image/png;BASE64,{base64}"),
        format!("data:image/png;charset=utf-8;base64,{}", base64.trim_end_matches('=')),
        format!("data:image/png,{percent}"),
    ];
    let (of_file, of_scene) = (picture(usual.clone()), scene(&usual));
    for form in forms {
        assert!(scene(&form) == of_scene, "{}", &form[..40]);
        assert!(picture(form.clone()) == of_file, "{}", &form[..40]);
    }
}

/// Warnings of a turntable, of jobs of frames and of the command are those of the model that is turned.
#[test]
fn pictures_from_all_around_have_the_warnings_of_the_model() {
    let service = Service::start(&[]);
    let query = "width=16&height=16";
    let extensions = json!({ "KHR_materials_anisotropy": { "anisotropyStrength": 0.5 } });
    let brushed = with_material(&extensions, &json!({ "bufferView": 2 }), &picture_file(ImageFormat::Png));
    let warned = of_model(&service, query, &brushed);
    let expected = warned.header("render-warnings");
    assert!(expected.contains("anisotropy"), "{warned:?}");
    for more in ["turntable=3", "turntable=3&format=webp", "turntable=4&sheet=2x2"] {
        let turned = of_model(&service, &format!("{query}&{more}"), &brushed);
        assert_eq!((turned.status, turned.header("render-warnings")), (200, expected), "{more}");
    }
    let headers = [GLB, ("Prefer", "wait=20")];
    let job = service.send("POST", &format!("/v1/jobs?{query}&turntable=3"), &headers, &brushed).json();
    // The job has each once, with its code.
    let told = job["sequence"]["warnings"].as_array().unwrap();
    let of_header = |warning: &&Value| expected.contains(warning["detail"].as_str().unwrap());
    assert!(!told.is_empty() && told.iter().all(|warning| of_header(&warning)), "{job}");
    assert_eq!(told.iter().filter(|warning| warning["code"] == "not-simulated").count(), 1, "{job}");
    for what in ["animation", "sheet", "frames/1"] {
        let answer = service.get(&format!("/v1/jobs/{}/{what}", job["id"].as_str().unwrap()));
        assert_eq!((answer.status, answer.header("render-warnings")), (200, expected), "{what}");
    }
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("brushed.glb");
    std::fs::write(&model, &brushed).unwrap();
    let turn = folder.path().join("turn.json");
    std::fs::write(&turn, r#"{ "count": 3, "turntable": {} }"#).unwrap();
    let all = ["render", "--frames", "3"].map(OsStr::new);
    let one = ["frame", "--frame", "1", "--sequence"].map(OsStr::new);
    for arguments in [&all[..], &[&one[..], &[turn.as_os_str()]].concat()] {
        let mut command = Command::new(PROGRAM);
        command.args(arguments).arg(&model).args(["--width", "16", "--height", "16", "-o"]);
        let output = command.arg(folder.path().join("a.png")).output().unwrap();
        let printed = String::from_utf8(output.stderr).unwrap();
        let told = |line: &&str| line.starts_with("warning: ") && line.contains("anisotropy");
        assert_eq!(printed.lines().filter(told).count(), 1, "{arguments:?}: {printed}");
    }
    let silent = of_model(&service, "turntable=2&width=16&height=16", &file("BoxVertexColors.glb"));
    assert_eq!((silent.status, silent.header("render-warnings")), (200, ""));
}

/// Also in frames, in variations and beside other settings, which have the settings of the scene once more.
#[test]
fn pixels_of_a_device_are_multiplied_once() {
    let service = Service::start(&[]);
    let size = |picture: &image::DynamicImage| [picture.width(), picture.height()];
    let twice = service.post_json("/v1/render?dpr=2&format=png", BALL).picture();
    assert!(twice == service.post_json("/v1/render?width=96&height=64&format=png", BALL).picture());
    let wide = service.post_json("/v1/render?width=10&dpr=2&format=png", BALL).picture();
    assert_eq!(size(&wide), [20, 64]);
    let around = service.post_json("/v1/render?turntable=2&dpr=2&sheet=2x1", BALL);
    assert_eq!(around.status, 200, "{}", around.text());

    let scene: Value = serde_json::from_str(BALL).unwrap();
    let base = service.post_json("/v1/scenes", BALL).json()["scene_id"].clone();
    let varied = json!({ "base": base, "patch": {} });
    for (scene, frames) in [(&scene, None), (&varied, None), (&scene, Some(2)), (&varied, Some(2))] {
        let mut body = json!({ "scene": scene, "settings": { "dpr": 2 } });
        if let Some(count) = frames {
            body["frames"] = json!({ "count": count, "turntable": {} });
        }
        let headers = [("Content-Type", "application/json"), ("Prefer", "wait=20")];
        let job = service.send("POST", "/v1/jobs", &headers, body.to_string().as_bytes()).json();
        assert_eq!((&job["state"], &job["width"], &job["height"]), (&"succeeded".into(), &96.into(), &64.into()));
        let path = if frames.is_some() { "frames/0" } else { "image" };
        let picture = service.get(&format!("/v1/jobs/{}/{path}", job["id"].as_str().unwrap())).picture();
        assert!(picture == twice, "{frames:?}: {:?}", size(&picture));
    }
    let settings = json!({ "scene": scene, "settings": [{}, { "width": 48 }, { "width": 24, "dpr": 4 }] });
    let plans = service.post_json("/v1/explain?dpr=2", &settings.to_string()).json();
    let ids: Vec<_> = plans["estimates"].as_array().unwrap().iter().map(|one| &one["image_id"]).collect();
    let expected = service.post_json("/v1/scenes?width=96&height=64", BALL).json()["image_id"].clone();
    assert_eq!(ids[..2], [&expected; 2], "{plans}");
    let expected = service.post_json("/v1/scenes?width=96&height=128", BALL).json()["image_id"].clone();
    assert_eq!(ids[2], &expected, "{plans}");

    let large = BALL.replacen("\"width\": 48", "\"width\": 4096", 1);
    let problem = service.post_json("/v1/render?dpr=8", &large).problem(422, "invalid-scene");
    let error = &problem["errors"][0];
    assert!(error["pointer"] == "#/image/width" && error["line"].is_null(), "{problem}");
}

#[test]
fn jobs_take_models_as_their_bodies() {
    let service = Service::start(&[]);
    let cube = file("Box.glb");
    let headers = [GLB, ("Prefer", "wait=20")];
    let done = service.send("POST", "/v1/jobs?width=32&height=32&format=png&priority=70", &headers, &cube).json();
    assert_eq!((&done["state"], &done["priority"]), (&json!("succeeded"), &json!(70)), "{done}");
    let image = service.get(&format!("/v1/jobs/{}/image", done["id"].as_str().unwrap()));
    assert!(image.body == of_model(&service, "width=32&height=32&format=png", &cube).body);
    let around = service.send("POST", "/v1/jobs?turntable=3&width=16&height=16&format=png", &headers, &cube).json();
    assert_eq!(around["state"], "succeeded", "{around}");
    assert_eq!(
        service.get(&format!("/v1/jobs/{}/frames", around["id"].as_str().unwrap())).json()["frames"]
            .as_array()
            .unwrap()
            .len(),
        3
    );
    service.send("POST", "/v1/jobs?size=1", &headers, &cube).problem(400, "invalid-parameter");
    let json = json!({ "scene": serde_json::from_str::<Value>(BALL).unwrap() }).to_string();
    let beside = service.post_json("/v1/jobs?width=32", &json).problem(400, "invalid-parameter")["detail"].to_string();
    assert!(beside.contains("width: a job in JSON says this in its body"), "{beside}");
}

#[test]
fn the_film_and_the_size_are_settings() {
    let service = Service::start(&[]);
    let cube = file("Box.glb");
    let picture = |query: &str| of_model(&service, &format!("{query}&format=png"), &cube).picture();
    let plain = picture("width=32&height=24");
    let clear = picture("width=32&height=24&background=transparent");
    assert!(plain == clear && plain.color().has_alpha());
    let red = picture("width=32&height=24&background=ff8000");
    assert!(!red.color().has_alpha());
    assert_eq!(red.to_rgb8().get_pixel(0, 0).0, [255, 128, 0]);
    let shown = |picture: &image::DynamicImage| -> u64 {
        picture.to_rgba8().pixels().filter(|pixel| pixel[3] == 255).map(|pixel| u64::from(pixel[0])).sum()
    };
    assert!(shown(&picture("width=32&height=24&exposure=1")) > shown(&plain));
    assert!(picture("width=32&height=24&tone=agx") != plain);
    let og = picture("size=og&dpr=0.5&antialias=false&samples=1");
    assert_eq!([og.width(), og.height()], [600, 315]);
    let twice = picture("width=20&height=16&dpr=2");
    assert!(twice == picture("width=40&height=32"));
    for wrong in ["dpr=9", "dpr=8&width=4000", "size=og&width=3", "background=blue", "exposure=99", "tone=film"] {
        of_model(&service, wrong, &cube).problem(400, "invalid-parameter");
    }
    let small = picture("dpr=0.25&antialias=false");
    assert!(small == picture("width=128&height=128&antialias=false"), "{} x {}", small.width(), small.height());
    let scene = service.post_json("/v1/render?background=00ff00&width=16&height=12&format=png", BALL).picture();
    assert_eq!(scene.to_rgb8().get_pixel(0, 0).0, [0, 255, 0]);
}

#[test]
fn animations_and_variants_are_named() {
    let service = Service::start(&[]);
    let cube = file("AnimatedMorphCube_quantized.glb");
    let picture = |query: &str| of_model(&service, &format!("width=32&height=32&format=png&{query}"), &cube);
    let by_place = picture("animation=0&t=1");
    assert_eq!(by_place.status, 200, "{}", by_place.text());
    assert!(by_place.body == picture("animation=Square&t=1").body);
    let unknown = picture("animation=Jump").problem(422, "invalid-scene");
    assert!(unknown["errors"][0]["detail"].as_str().unwrap().contains("Square"), "{unknown}");
}
