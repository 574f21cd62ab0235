//! Jobs: accepted, watched, stopped, found again, and finished whatever happens to the process.

use super::service::{Answer, Service, request};
use super::{BALL, SLOW};
use image::GenericImageView;
use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};

/// A ball between two mirrors, lit: slow, and no two tiles are the same.
pub(crate) fn mirrors() -> String {
    let ball = r#"{ "sphere": { "center": [0.05, 0.02, -0.6], "radius": 0.1 } }"#;
    let light = r#""lights": [{ "point": { "position": [0.3, 0.5, -0.1] } }], "objects": ["#;
    SLOW.replace(r#""objects": ["#, &format!("{light} {ball},"))
}

/// Some seconds of work in a few dozen tiles.
pub(crate) const LONG: &str = r#""settings": { "width": 384, "height": 384, "samples": 1 }"#;
/// More work than any test waits for, within the limits of jobs.
const ENDLESS: &str = r#""settings": { "width": 1024, "height": 1024, "samples": 8 }"#;

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

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("{value} is no text"))
}

fn job(service: &Service, id: &str) -> Value {
    service.get(&format!("/v1/jobs/{id}")).json()
}

/// Waits until a job is as it should be.
fn until(service: &Service, id: &str, is_so: impl Fn(&Value) -> bool) -> Value {
    let started = Instant::now();
    loop {
        let job = job(service, id);
        if is_so(&job) {
            return job;
        }
        assert!(started.elapsed() < Duration::from_secs(60), "it never comes to pass: {job}\n{}", service.log());
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn ended(service: &Service, id: &str) -> Value {
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
    assert_eq!(service.get("/v1/limits").json()["jobs"]["durable"], false);
}

#[test]
fn the_tiles_of_a_job_are_its_picture_and_looking_brings_them_forward() {
    let service = Service::start(&[]);
    let id = submit(&service, &mirrors(), LONG);
    let corner = service.get(&format!("/v1/jobs/{id}/tile?x=352&y=352&w=32&h=32"));
    let tile = corner.picture().to_rgb8();
    let then = job(&service, &id);
    let (done, total) = (&then["progress"]["tiles_done"], &then["progress"]["tiles_total"]);
    assert!(done.as_u64() < total.as_u64().map(|total| total / 2), "{then}: the corner would have been last");
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
fn killed_in_mid_render_it_goes_on_where_it_was_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let data = ["--data", folder.path().to_str().unwrap()];
    let service = Service::start(&data);
    let id = submit(&service, &mirrors(), LONG);
    let waiting = submit(&service, BALL, "");
    assert_eq!(service.get("/v1/limits").json()["jobs"]["durable"], true);
    let before = until(&service, &id, |job| job["progress"]["tiles_done"].as_u64() >= Some(4));
    drop(service);
    let service = Service::start(&data);
    let after = succeeded(&service, &id);
    let recovered = after["stats"]["tiles_recovered"].as_u64().unwrap();
    assert!(recovered >= before["progress"]["tiles_done"].as_u64().unwrap(), "{before} {after}");
    assert!(
        Some(recovered) < after["progress"]["tiles_total"].as_u64(),
        "{after}: it was killed too late to see anything"
    );
    succeeded(&service, &waiting);
    let picture = service.get(&format!("/v1/jobs/{id}/image"));
    let alone = Service::start(&[]).post_json("/v1/render?width=384&height=384&samples=1", &mirrors());
    assert_eq!(picture.body, alone.body, "the same bytes as without a kill");
    drop(service);
    let service = Service::start(&data);
    assert_eq!(job(&service, &id)["state"], "succeeded");
    assert_eq!(service.get(&format!("/v1/jobs/{id}/image")).body, alone.body, "also after another restart");
}

#[test]
fn a_folder_belongs_to_one_service() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().to_str().unwrap();
    let _service = Service::start(&["--data", data]);
    let other = std::process::Command::new(env!("CARGO_BIN_EXE_strahl"))
        .args(["serve", "--listen", "127.0.0.1:0", "--data", data])
        .output()
        .unwrap();
    assert_eq!(other.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&other.stderr).contains("Another process"), "{other:?}");
}

#[test]
fn a_canceled_job_stops_within_100_ms() {
    let service = Service::start(&[]);
    let fastest = (0..3)
        .map(|_| {
            let id = submit(&service, SLOW, ENDLESS);
            until(&service, &id, |job| job["state"] == "running" && !job["started_at"].is_null());
            std::thread::sleep(Duration::from_millis(50));
            let asked = Instant::now();
            assert_eq!(service.send("POST", &format!("/v1/jobs/{id}/cancel"), &[], b"").status, 202);
            until(&service, &id, |job| job["state"] == "canceled");
            while service.get("/readyz").json()["jobs"]["running"] != 0 {}
            let took = asked.elapsed();
            service.send("POST", &format!("/v1/jobs/{id}/cancel"), &[], b"").problem(409, "conflict");
            service.get(&format!("/v1/jobs/{id}/image")).problem(409, "job-failed");
            took
        })
        .min();
    assert!(fastest < Some(Duration::from_millis(100)), "{fastest:?}");
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
    service.get("/v1/jobs?state=done").problem(400, "invalid-parameter");
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
    assert_eq!(service.send("DELETE", &path, &[], b"").status, 204);
    service.get(&path).problem(404, "not-found");
    assert_eq!(service.get("/readyz").json()["jobs"]["running"], 0);
}

#[test]
fn renders_become_jobs_when_the_client_prefers_it() {
    let service = Service::start(&[]);
    let later = with(&service, "POST", "/v1/render?width=40&height=30", &[("Prefer", "respond-async")], BALL);
    assert_eq!((later.status, later.header("preference-applied")), (202, "respond-async"), "{}", later.text());
    let id = later.header("location").rsplit('/').next().unwrap().to_owned();
    succeeded(&service, &id);
    let picture = service.get(&format!("{}/image", later.header("location"))).picture();
    assert_eq!(picture.dimensions(), (40, 30));
    let in_time = with(&service, "POST", "/v1/render?width=50&height=30", &[("Prefer", "wait=20")], BALL);
    assert_eq!(in_time.picture().dimensions(), (50, 30));
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
fn pictures_and_records_expire() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().to_str().unwrap();
    let service = Service::start(&["--data", data, "--keep-pictures", "1", "--keep-records", "2"]);
    let id = submit(&service, BALL, "");
    succeeded(&service, &id);
    until(&service, &id, |job| job["state"] == "expired");
    service.get(&format!("/v1/jobs/{id}/image")).problem(410, "gone");
    let started = Instant::now();
    while service.get(&format!("/v1/jobs/{id}")).status == 200 {
        assert!(started.elapsed() < Duration::from_secs(10), "the record stays");
        std::thread::sleep(Duration::from_millis(50));
    }
    service.get(&format!("/v1/jobs/{id}")).problem(410, "gone");
    let left = |name: &str| std::fs::read_dir(folder.path().join(name)).unwrap().count();
    assert_eq!((left("jobs"), left("scenes")), (0, 0), "nothing of it is left on disk");
}

/// Bytes of all files in a folder and below it.
fn bytes_in(folder: &Path) -> u64 {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    entries
        .map(|entry| if entry.path().is_dir() { bytes_in(&entry.path()) } else { entry.metadata().unwrap().len() })
        .sum()
}

#[test]
fn where_there_is_no_room_on_disk_the_oldest_pictures_go_first() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().to_str().unwrap();
    let used = || ["jobs", "scenes"].map(|part| bytes_in(&folder.path().join(part))).into_iter().sum::<u64>();
    let service = Service::start(&["--data", data, "--data-bytes", "3000000"]);
    assert_eq!(service.get("/v1/limits").json()["jobs"]["data_bytes"], 3_000_000);
    // A third of a megabyte each, and no two the same.
    let ids: Vec<String> = (0..6)
        .map(|i| {
            let settings = format!(r#"{{ "width": 200, "height": 150, "min_weight": 0.00{i} }}"#);
            let id = submit(&service, BALL, &format!(r#""settings": {settings}, "output": {{ "format": "pfm" }}"#));
            succeeded(&service, &id);
            assert!(used() <= 3_000_000, "{} bytes", used());
            id
        })
        .collect();
    let states = |service: &Service| ids.iter().map(|id| job(service, id)["state"].clone()).collect::<Vec<_>>();
    let first = states(&service);
    assert_eq!((&first[0], &first[4], &first[5]), (&"expired".into(), &"succeeded".into(), &"succeeded".into()));
    service.get(&format!("/v1/jobs/{}/image", ids[0])).problem(410, "gone");
    let newest = service.get(&format!("/v1/jobs/{}/image", ids[5]));
    assert_eq!((newest.status, newest.body.len() > 200 * 150 * 12), (200, true));
    drop(service);

    let service = Service::start(&["--data", data, "--data-bytes", "500000"]);
    until(&service, &ids[4], |job| job["state"] == "expired");
    assert_eq!(states(&service)[5], "succeeded", "what fits stays");
    assert!(used() <= 500_000, "{} bytes", used());
}

#[test]
fn what_cannot_fit_on_disk_is_refused() {
    let service = Service::start(&["--data-bytes", "2000000"]);
    let send = |scene: &str, settings: &str| service.post_json("/v1/jobs", &body(scene, settings));
    let padded = |space: usize| SLOW.replacen('{', &format!("{{{}", " ".repeat(space)), 1);
    let small = r#""settings": { "width": 64, "height": 64 }"#;
    for refused in
        [send(SLOW, r#""settings": { "width": 400, "height": 300, "samples": 1 }"#), send(&padded(1_100_000), small)]
    {
        let problem = refused.problem(413, "cost-limit");
        assert_eq!(problem["limit"]["name"], "data_bytes", "{problem}");
        assert_eq!(refused.header("retry-after"), "");
    }
    let first = submit(&service, &padded(600_000), small);
    let refused = send(&padded(700_000), small);
    assert!(text(&refused.problem(503, "saturated")["detail"]).contains("data_bytes"), "{}", refused.text());
    assert!(refused.header("retry-after").parse::<u32>().is_ok_and(|seconds| seconds > 0), "{refused:?}");
    // The same scene again takes no more room, and one that is no longer needed none.
    submit(&service, &padded(600_000), small);
    for job in service.get("/v1/jobs").json()["jobs"].as_array().unwrap() {
        service.send("DELETE", &format!("/v1/jobs/{}", text(&job["id"])), &[], b"");
    }
    service.get(&format!("/v1/jobs/{first}")).problem(404, "not-found");
    submit(&service, &padded(700_000), small);
}

#[test]
fn sigterm_with_a_job_and_a_watcher_ends_in_time_and_the_job_goes_on_later() {
    let folder = tempfile::tempdir().unwrap();
    let data = ["--data", folder.path().to_str().unwrap()];
    let mut service = Service::start(&data);
    let id = submit(&service, SLOW, LONG);
    let mut events = Events::of(&service, &id, &[]);
    assert_eq!(events.next().map(|(name, ..)| name).as_deref(), Some("snapshot"));
    until(&service, &id, |job| job["progress"]["tiles_done"].as_u64() >= Some(1));
    service.terminate();
    assert!(service.ended(Duration::from_secs(10)).success(), "{}", service.log());
    let last = events.all().pop().unwrap();
    assert_eq!((last.0.as_str(), &last.2["reason"]), ("shutdown", &"draining".into()));
    let service = Service::start(&data);
    let job = succeeded(&service, &id);
    assert!(job["stats"]["tiles_recovered"].as_u64() >= Some(1), "{job}");
}

#[test]
fn a_page_follows_a_job_by_its_events_and_comes_back_where_it_was() {
    let service = Service::start(&[]);
    let id = submit(&service, SLOW, LONG);
    let mut events = Events::of(&service, &id, &[]);
    assert_eq!(events.header("content-type"), "text/event-stream");
    let (name, first, snapshot) = events.next().unwrap();
    assert_eq!((name.as_str(), &snapshot["width"]), ("snapshot", &384.into()));
    let mut seen = vec![first];
    // It breaks off in the middle.
    while seen.len() < 6 {
        seen.push(events.next().unwrap().1);
    }
    drop(events);
    let last = seen.last().unwrap().to_string();
    let rest = Events::of(&service, &id, &[("Last-Event-ID", &last)]).all();
    assert_eq!(rest[0].1, seen[5] + 1, "nothing is missed, nothing comes twice");
    assert!(rest.windows(2).all(|two| two[1].1 == two[0].1 + 1));
    let count = |name: &str| rest.iter().filter(|(known, ..)| known == name).count();
    assert!(count("tile") > 3 && count("progress") > 0 && count("succeeded") == 1, "{rest:?}");
    let (name, seq, end) = rest.last().unwrap();
    assert_eq!((name.as_str(), &end["url"]), ("succeeded", &format!("/v1/jobs/{id}/image").into()));
    let over = service.send("GET", &format!("/v1/jobs/{id}/events"), &[("Last-Event-ID", &seq.to_string())], b"");
    assert_eq!(over.status, 204, "EventSource stops");
    let late = Events::of(&service, &id, &[]).all();
    assert_eq!(late.iter().map(|(name, ..)| name.as_str()).collect::<Vec<_>>(), ["snapshot", "succeeded"]);
}

#[test]
fn previews_come_coarse_to_fine_and_wait_for_who_asks() {
    let service = Service::start(&[]);
    let busy = submit(&service, &mirrors(), LONG);
    let id = submit(&service, &mirrors(), LONG);
    let events = Events::of(&service, &id, &[]);
    service.get(&format!("/v1/jobs/{id}/preview"));
    let first = service.get(&format!("/v1/jobs/{id}/preview?wait=20"));
    assert_eq!(first.picture().dimensions(), (384, 384));
    let tag = first.header("etag");
    let next =
        service.send("GET", &format!("/v1/jobs/{id}/preview"), &[("If-None-Match", tag), ("Prefer", "wait=20")], b"");
    assert!(next.status == 200 && next.header("etag") != tag && next.body != first.body, "{}", next.status);
    let events = events.all();
    let scales: Vec<_> =
        events.iter().filter(|(name, ..)| name == "preview").filter_map(|(.., data)| data["scale"].as_u64()).collect();
    assert_eq!(scales, [8, 4, 2], "somebody watches, so the finest pass is made, too");
    succeeded(&service, &busy);
    let last = service.get(&format!("/v1/jobs/{id}/preview"));
    assert_eq!(last.picture().to_rgb8(), service.get(&format!("/v1/jobs/{id}/image")).picture().to_rgb8());
    let same = service.send("GET", &format!("/v1/jobs/{id}/preview"), &[("If-None-Match", last.header("etag"))], b"");
    assert_eq!((same.status, same.body.len()), (304, 0));
}

#[test]
fn one_stream_tells_of_several_jobs_and_goes_on_where_it_broke_off() {
    let service = Service::start(&[]);
    // Of one tenant's jobs of the same priority the oldest goes first.
    let urgent = r#""priority": 90"#;
    let ids = [submit(&service, SLOW, ENDLESS), submit(&service, BALL, urgent), submit(&service, BALL, urgent)];
    let path = format!("/v1/events?job={}&job={}&job={}", ids[0], ids[1], ids[2]);
    let mut events = Events::at(&service, &path, &[]);
    let mut broken_off = String::new();
    // All but the endless one end.
    let mut ended = Vec::new();
    while ended.len() < 2 {
        let (name, id, data) = events.next_of_several().unwrap();
        let job = text(&data["job"]).to_owned();
        assert!(ids.contains(&job), "{data}");
        if name == "succeeded" {
            assert_eq!(data["url"], format!("/v1/jobs/{job}/image"));
            ended.push(job);
        }
        broken_off = id;
    }
    drop(events);
    let mut events = Events::at(&service, &path, &[("Last-Event-ID", &broken_off)]);
    assert_eq!(service.send("POST", &format!("/v1/jobs/{}/cancel", ids[0]), &[], b"").status, 202);
    let mut last = (String::new(), String::new());
    while let Some((name, id, data)) = events.next_of_several() {
        assert_eq!((&data["job"], name == "snapshot"), (&ids[0].as_str().into(), false), "{name}: {data}");
        last = (name, id);
    }
    assert_eq!(last.0, "canceled");
    assert_eq!(service.get(&format!("{path}&since={}", last.1)).status, 204, "nothing more will come");
    let fresh = Events::at(&service, &path, &[("Last-Event-ID", "7")]).all_names();
    let all = ["snapshot", "canceled", "snapshot", "succeeded", "snapshot", "succeeded"];
    assert_eq!(fresh, all, "numbers of one job say nothing about three");
    service.get("/v1/events").problem(400, "invalid-parameter");
    service.get(&format!("/v1/events?{}", "job=a&".repeat(33))).problem(400, "invalid-parameter");
    service.get(&format!("{path}&job=a")).problem(404, "not-found");
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
    let asked = Instant::now();
    assert_eq!(service.post_json("/v1/render", BALL).body, alone.body);
    assert!(asked.elapsed() < Duration::from_secs(2), "{:?}", asked.elapsed());
    let list = service.get("/v1/jobs?state=queued&limit=200").json();
    let last = &list["jobs"][0];
    assert!(last["position"].as_u64() > Some(35) && last["eta_ms"].as_f64() > Some(1_000.0), "{last}");
}

/// A job's events over a socket of their own.
struct Events {
    lines: BufReader<TcpStream>,
    headers: Vec<String>,
}

impl Events {
    fn of(service: &Service, id: &str, headers: &[(&str, &str)]) -> Self {
        Self::at(service, &format!("/v1/jobs/{id}/events"), headers)
    }

    fn at(service: &Service, path: &str, headers: &[(&str, &str)]) -> Self {
        let mut stream = service.connect();
        stream.write_all(&request("GET", path, headers, b"")).unwrap();
        let mut lines = BufReader::new(stream);
        let mut headers = Vec::new();
        loop {
            let mut line = String::new();
            lines.read_line(&mut line).unwrap();
            if line.trim().is_empty() {
                break;
            }
            headers.push(line.trim().to_lowercase());
        }
        assert!(headers[0].contains(" 200 "), "{headers:?}");
        Self { lines, headers }
    }

    fn header(&self, name: &str) -> &str {
        let find = |line: &'_ String| line.strip_prefix(name).is_some_and(|rest| rest.starts_with(": "));
        self.headers.iter().find(|line| find(line)).map_or("", |line| &line[name.len() + 2..])
    }

    /// Name, number and data of the next event; none at the end.
    fn next(&mut self) -> Option<(String, u64, Value)> {
        let (name, id, data) = self.next_of_several()?;
        let seq = if id.is_empty() { 0 } else { id.parse().unwrap() };
        Some((name, seq, data))
    }

    /// Likewise, with the numbers of the last events of all jobs.
    fn next_of_several(&mut self) -> Option<(String, String, Value)> {
        let (mut name, mut id, mut data) = (String::new(), String::new(), Value::Null);
        loop {
            let mut line = String::new();
            if self.lines.read_line(&mut line).unwrap_or(0) == 0 {
                return None;
            }
            // Lengths of chunks stand between the lines.
            match line.trim().split_once(": ").or_else(|| line.trim().split_once(':')) {
                Some(("event", value)) => name = value.to_owned(),
                Some(("id", value)) => id = value.to_owned(),
                Some(("data", value)) => data = serde_json::from_str(value).unwrap(),
                _ if line.trim().is_empty() && !data.is_null() => return Some((name, id, data)),
                _ => {}
            }
        }
    }

    fn all_names(mut self) -> Vec<String> {
        std::iter::from_fn(|| self.next_of_several()).map(|(name, ..)| name).collect()
    }

    fn all(mut self) -> Vec<(String, u64, Value)> {
        std::iter::from_fn(|| self.next()).collect()
    }
}
