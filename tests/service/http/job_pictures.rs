//! What a finished job says of its picture, where else that is, and what it costs.

use super::access::{KeyFile, keyed};
use super::jobs::{LONG, body, mirrors, submit, succeeded, with};
use crate::common::BALL;
use crate::common::service::{Answer, PATIENCE, Service};
use serde_json::Value;
use std::time::{Duration, Instant};

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("{value} is no text"))
}

fn units_left(answer: &Answer) -> u64 {
    answer.header("ratelimit").split(';').find_map(|part| part.strip_prefix("r=")?.parse().ok()).unwrap()
}

#[test]
fn a_finished_job_says_what_a_render_says_and_links_to_its_picture_and_tiles() {
    let service = Service::start(&[]);
    let id = submit(&service, BALL, r#""settings": { "width": 700, "height": 300 }, "output": { "format": "webp" }"#);
    let done = succeeded(&service, &id);
    let fresh = Service::start(&[]);
    let at_once = fresh.post_json("/v1/render?width=700&height=300&format=webp", BALL);
    let picture = service.get(&format!("/v1/jobs/{id}/image"));
    for name in ["render-error", "render-rays", "render-plan", "repr-digest", "etag", "content-location"] {
        // Tiles and pieces are cut differently, and rays along cuts are traced for both sides.
        let same = picture.header(name) == at_once.header(name) || name == "render-rays";
        assert!(same && !picture.header(name).is_empty(), "{name}: {} {}", picture.header(name), at_once.header(name));
    }
    let report = &done["report"];
    assert_eq!(report["replay"]["image"], serde_json::json!([700, 300]));
    assert_eq!(report["error"]["proved"]["max_codes"], 1, "{report}");
    let rays = &report["cost"]["rays"];
    let counted: u64 = ["camera", "shadow", "reflected", "transmitted"].iter().filter_map(|k| rays[k].as_u64()).sum();
    assert_eq!(done["stats"]["rays"], counted, "{done}");
    assert!(report["cost"]["phases_ms"]["trace"].as_f64() > Some(0.0), "{report}");

    let links = &done["links"];
    assert_eq!(text(&links["picture"]), at_once.header("content-location"));
    assert_eq!(service.get(text(&links["picture"])).body, at_once.body);
    assert_eq!(service.get(text(&links["iiif"])).json()["width"], 700);
    let tile = service.get(&text(&links["dzi"]).replace(".dzi", "_files/10/1_0.png")).picture();
    let whole = service.post_json("/v1/render?width=700&height=300", BALL).picture();
    assert_eq!(tile.to_rgb8(), whole.crop_imm(512, 0, 188, 300).to_rgb8());
    let scene = service.get(text(&links["scene"]));
    assert_eq!((scene.status, &scene.json()["image"]["width"]), (200, &700.into()), "{}", scene.text());
    assert_eq!(service.send("DELETE", &format!("/v1/jobs/{id}"), &[], b"").status, 204);
    service.get(text(&links["scene"])).problem(404, "not-found");
}

#[test]
fn a_picture_that_is_there_already_makes_a_job_that_is_finished_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let flags = ["--data", folder.path().to_str().unwrap()];
    let service = Service::start(&flags);
    let rendered = service.post_json("/v1/render?width=1200&height=300", BALL);
    let rest = r#""settings": { "width": 1200, "height": 300 }"#;
    let answer = service.post_json("/v1/jobs", &body(BALL, rest));
    let job = answer.json();
    assert_eq!((answer.status, &job["state"], &job["stats"]["reused"]), (202, &"succeeded".into(), &true.into()));
    assert!(job["report"]["error"]["proved"].is_object() && job["progress"]["fraction"] == 1.0, "{job}");
    let at = |service: &Service, what: &str| service.get(&format!("/v1/jobs/{}/{what}", text(&job["id"])));
    assert_eq!(at(&service, "image").body, rendered.body);
    // It is the picture made smaller, not rendered again.
    std::fs::remove_dir_all(folder.path().join("scenes")).unwrap();
    let preview = at(&service, "preview").picture();
    assert_eq!((preview.width(), preview.height()), (600, 150));
    let codes = image::load_from_memory(&rendered.body).unwrap().thumbnail_exact(600, 150).to_rgb8();
    assert_eq!(preview.to_rgb8(), codes);
    let events = at(&service, "events").text();
    assert!(events.contains("event: snapshot") && events.contains("event: succeeded"), "{events}");

    drop(service);
    let service = Service::start(&flags);
    assert_eq!(at(&service, "image").body, rendered.body, "it outlasts the cache that it came from");
    let again = service.post_json("/v1/render?width=1200&height=300", BALL);
    assert!(again.header("server-timing").contains("picture;desc=hit"), "{}", again.header("server-timing"));
    assert_eq!((&again.body, again.header("render-error")), (&rendered.body, rendered.header("render-error")));
}

#[test]
fn a_job_of_so_many_rays_is_the_picture_that_a_request_gets() {
    let service = Service::start(&[]);
    let id = submit(&service, BALL, r#""settings": { "width": 300, "height": 200, "accuracy": "rays:50000" }"#);
    let done = succeeded(&service, &id);
    assert_eq!(done["report"]["replay"]["render"]["accuracy"]["rays"]["count"], done["stats"]["rays"], "{done}");
    let fresh = Service::start(&[]).post_json("/v1/render?width=300&height=200&accuracy=rays:50000", BALL);
    assert_eq!(service.get(&format!("/v1/jobs/{id}/image")).body, fresh.body);
}

/// `<img src=".../preview">` shows something long before the time is up.
#[test]
fn a_job_of_so_much_time_is_seen_while_it_is_rendered() {
    let service = Service::start(&[]);
    let rest = r#""settings": { "width": 1600, "height": 900, "samples": 1024, "accuracy": "time:8000" }"#;
    let id = submit(&service, BALL, rest);
    let preview = service.get(&format!("/v1/jobs/{id}/preview"));
    assert_eq!((preview.status, preview.header("content-type")), (200, "image/png"), "{}", preview.text());
    let first = preview.picture().to_rgb8();
    assert_eq!(first.dimensions(), (800, 450));
    let job = service.get(&format!("/v1/jobs/{id}")).json();
    assert_eq!(job["state"], "running", "{job}");
    // The ball is in the middle.
    assert_ne!(first.get_pixel(400, 225), first.get_pixel(0, 0));
    let done = succeeded(&service, &id);
    assert_eq!(done["state"], "succeeded");
    let last = service.get(&format!("/v1/jobs/{id}/preview")).picture().to_rgb8();
    assert_ne!(first, last, "it became finer");
}

#[test]
fn jobs_are_charged_as_renders_are_also_by_the_process_that_ends_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = KeyFile::new("job_cost", "[tenants.acme]\nunits_per_minute = 60\n");
    let key = file.key("acme", "jobs,read");
    let flags = ["--keys", file.path(), "--data", folder.path().to_str().unwrap()];
    let service = Service::start(&flags);
    let submitted = keyed(&service, &key, "POST", "/v1/jobs", &body(&mirrors(), LONG));
    assert_eq!(submitted.status, 202, "{}", submitted.text());
    let place = submitted.header("location").to_owned();
    let job = |service: &Service| keyed(service, &key, "GET", &place, "");
    let started = Instant::now();
    while job(&service).json()["progress"]["tiles_done"].as_u64() < Some(2) {
        assert!(started.elapsed() < PATIENCE);
        // Looking costs a unit each time.
        std::thread::sleep(Duration::from_millis(300));
    }
    drop(service);
    let service = Service::start(&flags);
    let done = with(&service, "GET", &place, &[("Authorization", &key), ("Prefer", "wait=60")], "").json();
    assert_eq!(done["state"], "succeeded", "{done}");
    assert!(done["stats"]["tiles_recovered"].as_u64() >= Some(2), "{done}");
    assert!(done["stats"]["rays"].as_u64() > Some(100_000_000), "{done}: too few rays to be seen");
    let refused = job(&service);
    refused.problem(429, "rate-limited");
    assert_eq!(units_left(&refused), 0, "a debt that is waited for");
}
