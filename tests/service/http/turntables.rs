//! Pictures from all around in one answer, jobs of models, and settings of the film and of sizes.

use crate::common::BALL;
use crate::common::service::{Answer, PROGRAM, Service};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;

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

    let webp = of_model(&service, "turntable=3&width=24&height=24&format=webp", &cube);
    assert_eq!((webp.status, webp.header("content-type")), (200, "image/webp"));
    let sheet = of_model(&service, "turntable=4&width=24&height=24&sheet=2x2", &cube);
    assert_eq!((sheet.status, sheet.header("content-type")), (200, "image/png"));
    let [width, height] = [sheet.picture().width(), sheet.picture().height()];
    assert!(width >= 48 && height >= 48, "{width} x {height}");
    let scene = service.post_json("/v1/render?turntable=2&width=16&height=16", BALL);
    assert_eq!(frames(&scene.body), 2, "scenes are turned, too");

    of_model(&service, "turntable=4&sheet=1x3", &cube).problem(400, "invalid-parameter");
    of_model(&service, "turntable=1000", &cube).problem(400, "invalid-parameter");
    of_model(&service, "sheet=2x2", &cube).problem(400, "invalid-parameter");
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
    service.post_json("/v1/jobs?width=32", &json).problem(400, "invalid-parameter");
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
    for wrong in ["dpr=2", "size=og&width=3", "background=blue", "exposure=99", "tone=film"] {
        of_model(&service, wrong, &cube).problem(400, "invalid-parameter");
    }
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
