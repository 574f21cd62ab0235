//! Jobs of frames: every frame the picture of its scene, in files, animations and on sheets, whatever happens to the process.

use super::job_events::Events;
use super::jobs::{body, ended, job, mirrors, submit, succeeded, text, until, with};
use crate::common::BALL;
use crate::common::service::{Answer, PATIENCE, Service};
use image::codecs::png::PngDecoder;
use image::codecs::webp::WebPDecoder;
use image::{AnimationDecoder, GenericImageView, RgbaImage};
use serde_json::{Value, json};
use std::io::Cursor;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// The ball, seen from a quarter of the way around it.
const QUARTERS: [[f64; 3]; 4] = [[0.0, 1.0, 5.0], [5.0, 1.0, 0.0], [0.0, 1.0, -5.0], [-5.0, 1.0, 0.0]];
const AROUND: &str = r#""frames": { "count": 4, "rate": 10, "turntable": {} }"#;

fn seen_from(eye: [f64; 3]) -> String {
    let mut scene: Value = serde_json::from_str(BALL).unwrap();
    scene["camera"]["pinhole"]["eye"] = json!(eye);
    scene.to_string()
}

fn frame(service: &Service, id: &str, number: u32) -> Answer {
    service.get(&format!("/v1/jobs/{id}/frames/{number}"))
}

fn pictures_of(animation: &[u8], media_type: &str) -> Vec<(RgbaImage, u32)> {
    let file = Cursor::new(animation);
    let frames = match media_type {
        "image/apng" => PngDecoder::new(file).unwrap().apng().unwrap().into_frames().collect_frames(),
        _ => WebPDecoder::new(file).unwrap().into_frames().collect_frames(),
    };
    let delay = |frame: &image::Frame| frame.delay().numer_denom_ms().0 / frame.delay().numer_denom_ms().1;
    frames.unwrap().into_iter().map(|frame| (frame.buffer().clone(), delay(&frame))).collect()
}

/// A GIF's frames as three codes for each pixel, with their milliseconds.
fn gif_frames(file: &[u8]) -> Vec<(Vec<u8>, u32)> {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(file).unwrap();
    let mut frames = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        let colors = frame.buffer.as_chunks::<4>().0.iter().flat_map(|[red, green, blue, _]| [*red, *green, *blue]);
        frames.push((colors.collect(), 10 * u32::from(frame.delay)));
    }
    frames
}

#[test]
fn every_frame_is_the_picture_of_its_scene() {
    let service = Service::start(&[]);
    let alone = Service::start(&[]);
    for (output, query) in
        [("{}", ""), (r#"{ "format": "webp" }"#, "?format=webp"), (r#"{ "format": "exr" }"#, "?format=exr")]
    {
        let id = submit(&service, BALL, &format!("{AROUND}, \"output\": {output}"));
        let job = succeeded(&service, &id);
        assert_eq!((&job["frames"]["count"], &job["frames"]["done"]), (&json!(4), &json!(4)), "{job}");
        assert_eq!((&job["progress"]["fraction"], &job["image_id"]), (&json!(1.0), &Value::Null), "{job}");
        for (number, eye) in (0..).zip(QUARTERS) {
            let expected = alone.post_json(&format!("/v1/render{query}"), &seen_from(eye));
            let found = frame(&service, &id, number);
            assert_eq!(found.status, 200, "{}", found.text());
            assert_eq!(found.body, expected.body, "frame {number}{query}");
            assert_eq!(found.header("render-error"), expected.header("render-error"));
            assert_eq!(found.header("etag"), expected.header("etag"), "it has the id of that picture");
            assert_eq!(found.header("content-location"), "", "nobody has sent its scene");
        }
        frame(&service, &id, 4).problem(404, "not-found");
    }
}

#[test]
fn animations_and_sheets_show_the_frames() {
    let service = Service::start(&[]);
    for (output, first) in [("png", "image/apng"), ("webp", "image/webp")] {
        let id = submit(&service, BALL, &format!("{AROUND}, \"output\": {{ \"format\": \"{output}\" }}"));
        let path = format!("/v1/jobs/{id}/animation");
        service.get(&path).problem(409, "job-not-finished");
        succeeded(&service, &id);
        let singles: Vec<_> = (0..4).map(|n| image::load_from_memory(&frame(&service, &id, n).body).unwrap()).collect();
        let usual = service.get(&path);
        assert_eq!(usual.header("content-type"), first, "{}", usual.text());
        for (accept, media_type) in
            [("image/webp", "image/webp"), ("image/png", "image/apng"), ("image/apng", "image/apng")]
        {
            let answer = service.send("GET", &path, &[("Accept", accept)], b"");
            assert_eq!((answer.status, answer.header("content-type")), (200, media_type), "{}", answer.text());
            let shown = pictures_of(&answer.body, media_type);
            assert_eq!(shown.len(), 4);
            for ((picture, delay), single) in shown.iter().zip(&singles) {
                assert_eq!((picture, *delay), (&single.to_rgba8(), 100));
            }
            let format = if media_type == "image/webp" { "webp" } else { "png" };
            let named = service.get(&format!("{path}?format={format}"));
            assert_eq!(named.body, answer.body);
            let again =
                with(&service, "GET", &path, &[("Accept", accept), ("If-None-Match", answer.header("etag"))], "");
            assert_eq!(again.status, 304);
        }
        let gif = service.get(&format!("{path}?format=gif"));
        assert_eq!((gif.status, gif.header("content-type")), (200, "image/gif"), "{}", gif.text());
        assert_eq!(service.send("GET", &path, &[("Accept", "image/gif")], b"").body, gif.body);
        let shown = gif_frames(&gif.body);
        assert_eq!(shown.len(), 4);
        let off = |(shown, single): (&(Vec<u8>, u32), &image::DynamicImage)| {
            assert_eq!(shown.1, 100);
            shown.0.iter().zip(single.to_rgb8().into_raw()).map(|(a, b)| a.abs_diff(b)).max().unwrap()
        };
        let largest = shown.iter().zip(&singles).map(off).max().unwrap();
        // The ball has fewer colors than a GIF, so nothing is off and nothing is said.
        assert_eq!((largest, gif.header("render-warnings")), (0, usual.header("render-warnings")));
        service.get(&format!("{path}?format=exr")).problem(400, "invalid-parameter");
        assert_eq!(service.get(&format!("/v1/jobs/{id}/image")).body, usual.body);
        let sheet = service.get(&format!("/v1/jobs/{id}/sheet"));
        assert_eq!(sheet.picture().dimensions(), (96, 64), "two by two");
        let row = service.get(&format!("/v1/jobs/{id}/sheet?columns=4")).picture().to_rgba8();
        for (n, single) in singles.iter().enumerate() {
            let there = image::imageops::crop_imm(&row, 48 * n as u32, 0, 48, 32).to_image();
            assert_eq!(there, single.to_rgba8(), "small pictures stay as they are");
        }
        assert_eq!(service.get(&format!("/v1/jobs/{id}/preview")).body, sheet.body);
        service.get(&format!("/v1/jobs/{id}/tile?x=0&y=0&w=8&h=8")).problem(404, "not-found");
    }
    let floats = submit(&service, BALL, &format!("{AROUND}, \"output\": {{ \"format\": \"exr\" }}"));
    succeeded(&service, &floats);
    service.get(&format!("/v1/jobs/{floats}/animation")).problem(406, "not-acceptable");
    assert_eq!(service.get(&format!("/v1/jobs/{floats}/sheet")).picture().dimensions(), (96, 64));
    let single = submit(&service, BALL, "");
    for what in ["frames", "frames/0", "animation", "sheet"] {
        service.get(&format!("/v1/jobs/{single}/{what}")).problem(404, "not-found");
    }
}

#[test]
fn frames_are_reported_as_they_come() {
    let service = Service::start(&[]);
    let id =
        submit(&service, BALL, r#""frames": { "count": 7, "turntable": {} }, "settings": { "accuracy": "proved:0" }"#);
    let events = Events::of(&service, &id, &[]).all();
    let frames: Vec<_> = events.iter().filter(|(name, ..)| name == "frame").map(|(.., data)| data).collect();
    assert_eq!(
        frames.iter().map(|data| data["number"].as_u64().unwrap()).collect::<Vec<_>>(),
        (0..7).collect::<Vec<_>>()
    );
    assert_eq!(frames[6]["frames_done"], 7);
    let progress = events.iter().rfind(|(name, ..)| name == "progress").unwrap();
    assert_eq!(progress.2["fraction"], 1.0);
    let job = succeeded(&service, &id);
    let list = service.get(text(&job["links"]["frames"])).json();
    let all = list["frames"].as_array().unwrap();
    assert_eq!(all.len(), 7);
    let rays: u64 = all.iter().map(|frame| frame["rays"].as_u64().unwrap()).sum();
    assert_eq!((&list["sequence"]["rays"], &job["stats"]["rays"]), (&json!(rays), &json!(rays)));
    assert!(all.iter().all(|frame| frame["proved_codes"] == 0 && frame["image_id"].is_string()), "{list}");
    assert_eq!((&job["sequence"]["proved_codes"], &job["sequence"]["frames"]), (&json!(0), &json!(7)));
    assert_eq!(service.get(text(&all[3]["path"])).status, 200);
}

#[test]
fn rays_of_frames_are_predicted() {
    let service = Service::start(&[]);
    let ratio = |i: u32| {
        let more = format!(
            r#""frames": {{ "count": 7, "turntable": {{}} }}, "settings": {{ "width": {}, "accuracy": "proved:0" }}"#,
            64 + i
        );
        let job = succeeded(&service, &submit(&service, BALL, &more));
        let [predicted, traced] =
            [&job["sequence"]["predicted_rays"], &job["stats"]["rays"]].map(|n| n.as_f64().unwrap());
        predicted / traced
    };
    // Some pilots get no processor for their few milliseconds, and know little.
    let mut ratios: Vec<f64> = (0..9).map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    assert!((0.8..1.25).contains(&ratios[4]), "{ratios:?}");
}

#[test]
fn finished_frames_survive_a_kill() {
    let folder = tempfile::tempdir().unwrap();
    let data = ["--data", folder.path().to_str().unwrap()];
    let rest = r#""settings": { "width": 96, "height": 96, "samples": 1 },
        "frames": { "count": 12, "camera": [{ "t": 0, "vfov_deg": 20 }, { "t": 1, "vfov_deg": 30 }] }"#;
    let service = Service::start(&data);
    let id = submit(&service, &mirrors(), rest);
    let before = until(&service, &id, |job| job["frames"]["done"].as_u64() >= Some(3));
    let kept = frame(&service, &id, 0);
    drop(service);
    let service = Service::start(&data);
    let after = succeeded(&service, &id);
    let done = before["frames"]["done"].as_u64().unwrap();
    assert!(done < 12, "{before}: it was killed too late to see anything");
    assert_eq!(after["frames"]["done"], 12);
    let tiles = after["progress"]["tiles_total"].as_u64().unwrap();
    assert!(after["stats"]["tiles_recovered"].as_u64() >= Some(done * tiles / 12), "{before} {after}");
    let alone = Service::start(&[]);
    let whole = submit(&alone, &mirrors(), rest);
    let expected = succeeded(&alone, &whole);
    assert_eq!(after["stats"]["rays"], expected["stats"]["rays"]);
    for number in 0..12 {
        assert_eq!(frame(&service, &id, number).body, frame(&alone, &whole, number).body, "{number}");
    }
    assert_eq!(frame(&service, &id, 0).body, kept.body);
    drop(service);
    let service = Service::start(&data);
    assert_eq!(job(&service, &id)["state"], "succeeded");
    assert_eq!(frame(&service, &id, 11).status, 200, "also after another restart");
}

fn files_in(folder: &Path) -> usize {
    std::fs::read_dir(folder).unwrap().count()
}

#[test]
fn canceled_and_old_sequences_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().to_str().unwrap();
    let service = Service::start(&["--data", data, "--keep-pictures", "1", "--keep-records", "6"]);
    let long = r#""settings": { "width": 128, "height": 128, "samples": 1 }, "frames": { "count": 500, "turntable": { "degrees": 10, "axis": [0, 0, 1] } }"#;
    let id = submit(&service, &mirrors(), long);
    until(&service, &id, |job| job["frames"]["done"].as_u64() >= Some(1));
    assert!(files_in(&folder.path().join("pictures")) >= 2);
    assert_eq!(frame(&service, &id, 0).status, 200, "while others are rendered");
    frame(&service, &id, 499).problem(409, "job-not-finished");
    service.send("POST", &format!("/v1/jobs/{id}/cancel"), &[], b"");
    assert_eq!(ended(&service, &id)["state"], "canceled");
    frame(&service, &id, 0).problem(409, "job-failed");
    let short = submit(&service, BALL, AROUND);
    until(&service, &short, |job| job["state"] == "expired");
    frame(&service, &short, 0).problem(410, "gone");
    let expired = Instant::now();
    while service.get(&format!("/v1/jobs/{short}")).status == 200 {
        assert!(expired.elapsed() < PATIENCE, "the record stays");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    assert_eq!(["tiles", "pictures", "scenes"].map(|name| files_in(&folder.path().join(name))), [0; 3]);
}

#[test]
fn every_frame_is_checked_before_the_job_is_accepted() {
    let service = Service::start(&["--data-bytes", "200000000"]);
    let refused = |frames: Value, status: u16, slug: &str| {
        let answer = service.post_json("/v1/jobs", &body(BALL, &format!("\"frames\": {frames}")));
        answer.problem(status, slug)
    };
    let problem =
        refused(json!({ "patches": [{}, {}, { "materials": { "red": { "ior": -1 } } }] }), 422, "invalid-scene");
    let error = &problem["errors"][0];
    assert_eq!(error["pointer"], "#/materials/red/ior", "{problem}");
    assert!(text(&error["detail"]).contains("frame 2"), "{problem}");
    let problem = refused(json!({ "count": 1_000_000_000 }), 422, "invalid-scene");
    assert_eq!(problem["errors"][0]["pointer"], "#/frames/count", "{problem}");
    let keys = json!([{ "t": 0, "eye": [0, 1, 5] }, { "t": 0, "eye": [1, 1, 5] }]);
    let problem = refused(json!({ "count": 2, "camera": keys }), 422, "invalid-scene");
    assert_eq!(problem["errors"][0]["pointer"], "#/frames/camera/1/t", "{problem}");
    refused(json!({ "patches": [{}, { "image": { "width": 64 } }] }), 422, "invalid-scene");
    refused(json!({ "patches": [{}, { "film": { "background": "transparent" } }] }), 422, "invalid-scene");
    refused(json!({ "count": 3, "turntabel": {} }), 422, "invalid-request");
    let large = r#""settings": { "width": 2000, "height": 2000 }, "frames": { "count": 60, "turntable": {} }"#;
    service.post_json("/v1/jobs", &body(BALL, large)).problem(413, "cost-limit");
    let nan = body(BALL, r#""frames": { "count": 2, "rate": NaN }"#);
    service.post_json("/v1/jobs", &nan).problem(400, "invalid-json");
}

#[test]
fn sequences_of_a_known_scene_and_of_frames_that_a_clock_ends() {
    let service = Service::start(&[]);
    let known = text(&service.post_json("/v1/scenes", BALL).json()["scene_id"]).to_owned();
    let varied = json!({ "base": known, "patch": { "background": [1, 0, 0] } }).to_string();
    let id = submit(&service, &varied, AROUND);
    succeeded(&service, &id);
    let corner = image::load_from_memory(&frame(&service, &id, 2).body).unwrap().get_pixel(0, 0);
    assert_eq!(corner.0, [255, 0, 0, 255]);
    let timed = submit(&service, BALL, &format!("{AROUND}, \"settings\": {{ \"accuracy\": \"rays:5000\" }}"));
    let job = succeeded(&service, &timed);
    assert_eq!((&job["tile"], &job["progress"]["tiles_done"]), (&json!(0), &json!(4)), "{job}");
    assert_eq!(frame(&service, &timed, 3).status, 200);
}

#[test]
fn the_command_line_makes_the_same_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let frames = r#"{ "count": 4, "rate": 10, "turntable": {} }"#;
    std::fs::write(path.join("ball.json"), BALL).unwrap();
    std::fs::write(path.join("around.json"), frames).unwrap();
    let strahl = |args: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_strahl")).args(args).current_dir(path).output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    for target in ["f-##.png", "all.png", "all.webp", "all.GIF", "f-####.exr"] {
        let (code, said) = strahl(&["render", "ball.json", "--frames", "around.json", "-o", target]);
        assert_eq!(code, Some(0), "{said}");
        assert!(said.contains("4 frames of 48 x 32 pixels"), "{said}");
    }
    let service = Service::start(&[]);
    let id = submit(&service, BALL, AROUND);
    succeeded(&service, &id);
    let file = |name: &str| std::fs::read(path.join(name)).unwrap();
    for number in 0..4 {
        assert_eq!(file(&format!("f-0{number}.png")), frame(&service, &id, number).body);
        assert!(file(&format!("f-000{number}.exr")).starts_with(b"\x76\x2f\x31\x01"));
    }
    let animation = |format: &str| service.get(&format!("/v1/jobs/{id}/animation?format={format}")).body;
    assert_eq!(file("all.png"), animation("png"));
    assert_eq!(file("all.webp"), animation("webp"));
    assert_eq!(file("all.GIF"), animation("gif"));
    let (code, said) = strahl(&["render", "ball.json", "--frames", "4", "-o", "four.png"]);
    assert_eq!(code, Some(0), "{said}");
    for (args, what) in [
        (["--frames", "around.json", "-o", "a.exr"], "#"),
        (["--frames", "around.json", "-o", "f-#.gif"], "names no format"),
        (["--frames", "0", "-o", "a.png"], "/frames/count"),
        (["--frames", "nothing.json", "-o", "a.png"], "cannot be read"),
    ] {
        let (code, said) = strahl(&[&["render", "ball.json"], &args[..]].concat());
        assert!(code != Some(0) && said.contains(what), "{said}");
    }
}
