//! Jobs: accepted, watched, stopped, found again, and finished whatever happens to the process.

use super::job_events::Events;
use crate::common::farm::TestFarm;
use crate::common::service::{Answer, PATIENCE, Service};
use crate::common::{BALL, SLOW};
use image::GenericImageView;
use serde_json::Value;
use std::thread;
use std::time::{Duration, Instant};

/// A ball between two mirrors, lit: slow, and no two tiles are the same.
pub(crate) fn mirrors() -> String {
    let ball = r#"{ "sphere": { "center": [0.05, 0.02, -0.6], "radius": 0.1 } }"#;
    let light = r#""lights": [{ "point": { "position": [0.3, 0.5, -0.1] } }], "objects": ["#;
    SLOW.replace(r#""objects": ["#, &format!("{light} {ball},"))
}

/// Some seconds of work in a few dozen tiles.
pub(crate) const LONG: &str = r#""settings": { "width": 384, "height": 384, "samples": 4 }"#;
/// More work than any test waits for, within the limits of jobs.
pub(crate) const ENDLESS: &str = r#""settings": { "width": 1024, "height": 1024, "samples": 8 }"#;

pub(crate) fn body(scene: &str, rest: &str) -> String {
    if rest.is_empty() { format!("{{\"scene\": {scene}}}") } else { format!("{{\"scene\": {scene}, {rest}}}") }
}

pub(crate) fn submit(service: &Service, scene: &str, rest: &str) -> String {
    let answer = service.post_json("/v1/jobs", &body(scene, rest));
    assert_eq!(answer.status, 202, "{}", answer.text());
    let job = answer.json();
    assert_eq!(answer.header("location"), format!("/v1/jobs/{}", text(&job["id"])));
    text(&job["id"]).to_owned()
}

pub(crate) fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("{value} is no text"))
}

pub(crate) fn job(service: &Service, id: &str) -> Value {
    service.get(&format!("/v1/jobs/{id}")).json()
}

/// Waits until a job is as it should be.
pub(crate) fn until(service: &Service, id: &str, is_so: impl Fn(&Value) -> bool) -> Value {
    let started = Instant::now();
    loop {
        let job = job(service, id);
        if is_so(&job) {
            return job;
        }
        assert!(started.elapsed() < PATIENCE, "it never comes to pass: {job}\n{}", service.log());
        thread::sleep(Duration::from_millis(5));
    }
}

/// Waits until no job is worked on.
fn no_job_runs(service: &Service) {
    let started = Instant::now();
    while service.get("/readyz").json()["jobs"]["running"] != 0 {
        assert!(started.elapsed() < PATIENCE, "its work goes on");
        thread::sleep(Duration::from_millis(2));
    }
}

pub(crate) fn ended(service: &Service, id: &str) -> Value {
    until(service, id, |job| !matches!(text(&job["state"]), "queued" | "running"))
}

pub(crate) fn succeeded(service: &Service, id: &str) -> Value {
    let job = ended(service, id);
    assert_eq!(job["state"], "succeeded", "{job}\n{}", service.log());
    job
}

pub(crate) fn with(service: &Service, method: &str, path: &str, headers: &[(&str, &str)], body: &str) -> Answer {
    let json = [("Content-Type", "application/json")];
    service.send(method, path, &[&json, headers].concat(), body.as_bytes())
}

#[test]
fn a_job_becomes_the_picture_that_a_request_gets() {
    let service = Service::start(&[]);
    let query = "?width=300&height=200&bits=16";
    // Of another process: this one would take the picture that it has.
    let at_once = Service::start(&[]).post_json(&format!("/v1/render{query}"), BALL);
    let rest =
        r#""settings": { "width": 300, "height": 200 }, "output": { "format": "png", "bits": 16 }, "labels": ["a"]"#;
    let id = submit(&service, BALL, rest);
    let job = succeeded(&service, &id);
    assert_eq!(job["progress"]["fraction"], 1.0, "{job}");
    assert!(job["progress"]["tiles_total"].as_u64() > Some(1) && job["stats"]["rays"].as_u64() > Some(60_000), "{job}");
    assert!(job["position"].is_null() && job["eta_ms"].is_null() && job["finished_at"].is_string(), "{job}");
    let picture = service.get(&format!("/v1/jobs/{id}/image"));
    assert_eq!(picture.body, at_once.body, "the same bytes");
    assert_eq!(picture.header("content-type"), "image/png");
    let preview = service.get(&format!("/v1/jobs/{id}/preview"));
    assert_eq!(preview.picture().dimensions(), (300, 200));
    let part = service.get(&format!("/v1/jobs/{id}/tile?x=100&y=50&w=64&h=32"));
    let crop = service.post_json("/v1/render/tile?x=100&y=50&w=64&h=32&width=300&height=200", BALL);
    assert_eq!(part.picture().to_rgb8(), crop.picture().to_rgb8());
    // Without a folder they end with the service, but for those of a farm.
    assert_eq!(service.get("/v1/limits").json()["jobs"]["durable"], TestFarm::is_wanted());
}

#[test]
fn looking_brings_tiles_forward() {
    let service = Service::start(&[]);
    let id = submit(&service, &mirrors(), ENDLESS);
    service.get(&format!("/v1/jobs/{id}/tile?x=992&y=992&w=32&h=32")).picture();
    let then = job(&service, &id);
    let (done, total) = (&then["progress"]["tiles_done"], &then["progress"]["tiles_total"]);
    assert!(done.as_u64() < total.as_u64().map(|total| total / 2), "{then}: the corner would have been last");
    service.send("POST", &format!("/v1/jobs/{id}/cancel"), &[], b"");
}

/// A part with as many rays for itself would be another picture.
#[test]
fn so_are_they_where_a_number_of_rays_or_a_time_has_ended_it() {
    let service = Service::start(&[]);
    for (accuracy, format) in [("rays:20000", "png"), ("time:30", "png"), ("rays:20000", "pfm"), ("time:30", "webp")] {
        let rest = format!(
            r#""settings": {{ "width": 120, "height": 90, "accuracy": "{accuracy}" }}, "output": {{ "format": "{format}" }}"#
        );
        let id = submit(&service, &mirrors(), &rest);
        succeeded(&service, &id);
        let part = service.get(&format!("/v1/jobs/{id}/tile?x=33&y=20&w=40&h=30")).picture().to_rgb8();
        let all = service.get(&format!("/v1/jobs/{id}/tile?x=0&y=0&w=120&h=90")).picture().to_rgb8();
        assert_eq!(part, all.view(33, 20, 40, 30).to_image(), "{accuracy}, {format}");
        if format != "pfm" {
            let whole = image::load_from_memory(&service.get(&format!("/v1/jobs/{id}/image")).body).unwrap();
            assert_eq!(all, whole.to_rgb8(), "{accuracy}, {format}");
        }
    }
}

#[test]
fn the_tiles_of_a_job_are_its_picture() {
    let service = Service::start(&[]);
    let id = submit(&service, &mirrors(), LONG);
    let tile = service.get(&format!("/v1/jobs/{id}/tile?x=352&y=352&w=32&h=32")).picture().to_rgb8();
    assert_eq!(service.send("POST", &format!("/v1/jobs/{id}/look?x=0&y=0&w=9&h=9"), &[], b"").status, 204);
    let outside = service.send("POST", &format!("/v1/jobs/{id}/look?x=380&y=0&w=9&h=9"), &[], b"");
    outside.problem(400, "invalid-parameter");
    let events = Events::of(&service, &id, &[]).all();
    succeeded(&service, &id);
    let whole = service.get(&format!("/v1/jobs/{id}/image")).picture();
    assert_eq!(tile, whole.crop_imm(352, 352, 32, 32).to_rgb8());
    let (_, _, last) = events.last().unwrap();
    assert_eq!(last["url"], format!("/v1/jobs/{id}/image"));
}

#[test]
fn a_canceled_job_stops() {
    let service = Service::start(&[]);
    let id = submit(&service, SLOW, ENDLESS);
    until(&service, &id, |job| job["state"] == "running" && !job["started_at"].is_null());
    assert_eq!(service.send("POST", &format!("/v1/jobs/{id}/cancel"), &[], b"").status, 202);
    until(&service, &id, |job| job["state"] == "canceled");
    no_job_runs(&service);
    service.send("POST", &format!("/v1/jobs/{id}/cancel"), &[], b"").problem(409, "conflict");
    service.get(&format!("/v1/jobs/{id}/image")).problem(409, "job-failed");
}

#[test]
fn an_idempotency_key_makes_one_job_of_many_submissions() {
    let service = Service::start(&[]);
    let send =
        |key: &str, scene: &str| with(&service, "POST", "/v1/jobs", &[("Idempotency-Key", key)], &body(scene, ""));
    let first = send("k1", BALL);
    let again = send("k1", BALL);
    assert_eq!((first.status, again.status), (202, 202), "{}", again.text());
    assert_eq!(first.header("location"), again.header("location"));
    assert_eq!((first.header("idempotency-replayed"), again.header("idempotency-replayed")), ("", "true"));
    send("k1", &BALL.replace("0.8", "0.7")).problem(422, "idempotency-key-reused");
    assert_ne!(send("k2", BALL).header("location"), first.header("location"));
    // A submission that was refused leaves its key free.
    send("k3", "{}").problem(422, "invalid-scene");
    assert_eq!(send("k3", BALL).status, 202);
    // Who sends it again waits as the first time.
    let wait = [("Idempotency-Key", "k4"), ("Prefer", "wait=60")];
    let pictures = [(); 2].map(|()| with(&service, "POST", "/v1/render", &wait, BALL));
    assert!(pictures.iter().all(|picture| picture.status == 200 && picture.body == pictures[0].body), "{pictures:?}");
    let jobs = [(); 2].map(|()| with(&service, "POST", "/v1/jobs", &wait[1..], &body(BALL, "")).json());
    assert!(jobs.iter().all(|job| job["state"] == "succeeded"), "{jobs:?}");
    let again = [("Idempotency-Key", "k1"), ("Prefer", "wait=60")];
    assert_eq!(with(&service, "POST", "/v1/jobs", &again, &body(BALL, "")).json()["state"], "succeeded");
}

#[test]
fn lists_have_pages_and_filters() {
    let service = Service::start(&[]);
    let ids: Vec<String> = (0..5).map(|i| submit(&service, BALL, &format!(r#""labels": ["n{i}", "all"]"#))).collect();
    ids.iter().for_each(|id| drop(succeeded(&service, id)));
    let names = |list: &Value| -> Vec<String> {
        list["jobs"].as_array().unwrap().iter().map(|job| text(&job["id"]).to_owned()).collect()
    };
    let first = service.get("/v1/jobs?limit=3&label=all&state=succeeded");
    assert_eq!(names(&first.json()), [&ids[4], &ids[3], &ids[2]].map(String::clone), "the newest first");
    let link = first.header("link");
    let next = link.strip_prefix('<').and_then(|link| link.split('>').next()).unwrap_or_else(|| panic!("{link}"));
    let second = service.get(next);
    assert_eq!(names(&second.json()), [&ids[1], &ids[0]].map(String::clone));
    assert!(second.header("link").is_empty() && second.json()["next"].is_null());
    assert_eq!(names(&service.get("/v1/jobs?label=n2").json()), [ids[2].clone()]);
    assert!(names(&service.get("/v1/jobs?state=failed").json()).is_empty());
    for wrong in ["/v1/jobs?state=done", "/v1/jobs?cursor=abc", "/v1/events?job=x&since=abc"] {
        service.get(wrong).problem(400, "invalid-parameter");
    }
}

#[test]
fn priorities_change_and_deleted_jobs_are_gone() {
    let service = Service::start(&[]);
    let id = submit(&service, SLOW, ENDLESS);
    let path = format!("/v1/jobs/{id}");
    let tag = service.get(&path).header("etag").to_owned();
    let changed = with(&service, "PATCH", &path, &[("If-Match", &tag)], r#"{"priority": 90}"#);
    assert_eq!((changed.status, &changed.json()["priority"]), (200, &90.into()), "{}", changed.text());
    with(&service, "PATCH", &path, &[("If-Match", &tag)], r#"{"priority": 10}"#).problem(412, "precondition-failed");
    with(&service, "PATCH", &path, &[], r#"{"priority": 101}"#).problem(422, "invalid-request");
    with(&service, "PATCH", &path, &[], r#"{"prio": 1}"#).problem(422, "invalid-request");
    let typed = |kind: &str| service.send("PATCH", &path, &[("Content-Type", kind)], br#"{"priority": 20}"#);
    let refused = typed("text/plain");
    refused.problem(415, "unsupported-media-type");
    assert_eq!(refused.header("accept-patch"), "application/merge-patch+json, application/json");
    for kind in ["application/merge-patch+json", "Application/JSON; charset=utf-8"] {
        assert_eq!(typed(kind).json()["priority"], 20, "{kind}");
    }
    let cancel = format!("{path}/cancel");
    for (method, path) in [("DELETE", &path), ("POST", &cancel)] {
        for condition in [("If-Match", "\"other\""), ("If-None-Match", "*")] {
            service.send(method, path, &[condition], b"").problem(412, "precondition-failed");
        }
    }
    assert!(!["canceled", "failed"].contains(&text(&service.get(&path).json()["state"])));
    assert_eq!(service.send("DELETE", &path, &[("If-Match", "*")], b"").status, 204);
    service.get(&path).problem(404, "not-found");
    // The answer does not wait for the end of the work.
    no_job_runs(&service);
}

#[test]
fn renders_become_jobs_when_the_client_prefers_it() {
    let service = Service::start(&[]);
    let later = with(&service, "POST", "/v1/render?width=40&height=30", &[("Prefer", "respond-async")], BALL);
    assert_eq!((later.status, later.header("preference-applied")), (202, "respond-async"), "{}", later.text());
    let id = later.header("location").rsplit('/').next().unwrap().to_owned();
    succeeded(&service, &id);
    // One tag stands for one text.
    let path = later.header("location");
    let tag = service.get(path).header("etag").to_owned();
    let first = later.header("etag");
    assert!(first != tag && first.split('-').next() == tag.split('-').next(), "{first} {tag}");
    let known = service.send("GET", path, &[("If-None-Match", &tag)], b"");
    assert_eq!((known.status, known.body.len(), known.header("etag")), (304, 0, tag.as_str()));
    assert_eq!(service.send("GET", path, &[("If-None-Match", first), ("If-Match", &tag)], b"").status, 200);
    service.send("GET", path, &[("If-Match", first)], b"").problem(412, "precondition-failed");
    let picture = service.get(&format!("{}/image", later.header("location"))).picture();
    assert_eq!(picture.dimensions(), (40, 30));
    let in_time = with(&service, "POST", "/v1/render?width=50&height=30", &[("Prefer", "wait=20")], BALL);
    assert_eq!(in_time.picture().dimensions(), (50, 30));
    let other = [("Prefer", "foo=\"a,respond-async,b\"; respond-async")];
    let at_once = with(&service, "POST", "/v1/render?width=60&height=30", &other, BALL);
    assert_eq!(at_once.picture().dimensions(), (60, 30));
    assert_eq!(at_once.header("preference-applied"), "");
    assert_eq!((in_time.header("preference-applied"), in_time.header("vary")), ("wait=20", "Accept"));
    let too_late =
        with(&service, "POST", "/v1/render?width=1024&height=1024", &[("Prefer", "respond-async, wait=1")], SLOW);
    assert_eq!((too_late.status, too_late.header("preference-applied")), (202, "respond-async, wait=1"));
    let waited = Instant::now();
    let waits = with(&service, "GET", too_late.header("location"), &[("Prefer", "wait=1")], "");
    assert!(waits.status == 200 && waited.elapsed() > Duration::from_millis(900));
}

#[test]
fn what_can_never_be_done_is_refused_at_once() {
    let service = Service::start(&[
        "--job-timeout",
        "60",
        "--job-memory-bytes",
        "100000000",
        "--job-max-pixels",
        "5000000",
        "--jobs",
        "1",
    ]);
    let refused =
        |settings: &str| service.post_json("/v1/jobs", &body(SLOW, &format!(r#""settings": {{ {settings} }}"#)));
    let problem = refused(r#""width": 3000, "height": 2000, "samples": 1"#).problem(413, "cost-limit");
    assert_eq!(problem["limit"]["name"], "job_max_pixels", "{problem}");
    let problem = refused(r#""width": 2000, "height": 2000, "samples": 1024"#).problem(413, "cost-limit");
    assert_eq!(problem["limit"]["name"], "job_timeout", "{problem}");
    let large = service.post_json("/v1/jobs", &body(BALL, r#""settings": { "width": 2200, "height": 2200 }"#));
    assert_eq!(large.problem(413, "cost-limit")["limit"]["name"], "job_memory_bytes");
    submit(&service, SLOW, LONG);
    let full = service.post_json("/v1/jobs", &body(BALL, ""));
    full.problem(503, "saturated");
    assert!(full.header("retry-after").parse::<u32>().is_ok_and(|seconds| (1..=120).contains(&seconds)));
    service.post_json("/v1/jobs", r#"{"scene": {}, "webhook": "x"}"#).problem(422, "invalid-request");
    service.post_json("/v1/jobs", &body(BALL, r#""settings": { "widht": 3 }"#)).problem(400, "invalid-parameter");
}

#[test]
fn a_process_that_was_stopped_does_not_take_pictures_for_slow() {
    let service = Service::start(&["--job-timeout", "86400"]);
    let estimate = |width: u32| {
        let id =
            submit(&service, SLOW, &format!(r#""settings": {{ "width": {width}, "height": 400, "samples": 256 }}"#));
        let estimate = job(&service, &id)["estimate_ms"].as_f64().unwrap();
        service.send("DELETE", &format!("/v1/jobs/{id}"), &[], b"");
        estimate
    };
    let undisturbed = estimate(400);
    let disturbed = thread::scope(|scope| {
        // Its pilot takes about a second.
        let asked = scope.spawn(|| estimate(401));
        thread::sleep(Duration::from_millis(100));
        service.signal("-STOP");
        thread::sleep(Duration::from_secs(4));
        service.signal("-CONT");
        asked.join().unwrap()
    });
    assert!(disturbed < 4.0 * undisturbed, "{disturbed} ms, {undisturbed} where nothing stopped it");
}

#[test]
fn many_jobs_do_not_hold_up_a_request() {
    let service = Service::start(&[]);
    let alone = service.post_json("/v1/render", BALL);
    let first = submit(&service, SLOW, ENDLESS);
    let text = body(SLOW, LONG);
    for _ in 0..40 {
        assert_eq!(service.post_json("/v1/jobs", &text).status, 202);
    }
    assert_eq!(job(&service, &first)["state"], "running");
    assert_eq!(service.post_json("/v1/render", BALL).body, alone.body);
    // It has not waited for them.
    let list = service.get("/v1/jobs?state=queued&limit=200").json();
    let last = &list["jobs"][0];
    assert!(last["position"].as_u64() > Some(35) && last["eta_ms"].as_f64() > Some(1_000.0), "{last}");
    // Who is next does not count itself.
    let next = job(&service, list["jobs"].as_array().unwrap().last().unwrap()["id"].as_str().unwrap());
    assert!(next["position"] == 1 || next["state"] != "queued", "{next}");
}
