//! Names of scenes and pictures, conditional requests, caches, work that is shared.

use crate::common::service::{Answer, NO_TIMEOUT, Service, request};
use crate::common::{BALL, SLOW};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

/// An empty folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

fn ask(service: &Service, method: &str, path: &str, headers: &[(&str, &str)]) -> Answer {
    let headers = [&[("Content-Type", "application/json")], headers].concat();
    service.send(method, path, &headers, BALL.as_bytes())
}

fn add(service: &Service, path: &str, scene: &str) -> (Answer, String) {
    let answer = service.post_json(path, scene);
    assert!(matches!(answer.status, 200 | 201), "{}", answer.text());
    let image = answer.json()["image_id"].as_str().unwrap().to_owned();
    (answer, image)
}

fn timing(answer: &Answer) -> &str {
    answer.header("server-timing")
}

#[test]
fn a_client_that_has_the_picture_is_told_so_before_a_ray_is_traced() {
    let service = Service::start(&[]);
    let first = service.post_json("/v1/render", BALL);
    let etag = first.header("etag").to_owned();
    assert!(etag.starts_with("\"i_") && etag.ends_with(".png\""), "{etag}");

    // Another process knows the tag as well: it is a name, not a number of this one.
    let fresh = Service::start(&[]);
    let known = ask(&fresh, "QUERY", "/v1/render", &[("If-None-Match", &etag)]);
    assert_eq!((known.status, known.body.len(), known.header("etag")), (304, 0, etag.as_str()));
    let place = first.header("content-location");
    assert!(place.starts_with("/v1/images/i_") && place == known.header("content-location"), "{place}");
    let slow = service.send(
        "QUERY",
        "/v1/render",
        &[("Content-Type", "application/json"), ("If-None-Match", "*")],
        SLOW.as_bytes(),
    );
    assert_eq!(slow.status, 304, "nobody has rendered this one, and nobody has to");

    ask(&fresh, "POST", "/v1/render", &[("If-None-Match", &etag)]).problem(412, "precondition-failed");
    assert_eq!(ask(&fresh, "POST", "/v1/render", &[("If-Match", &etag)]).status, 200);
    ask(&fresh, "POST", "/v1/render", &[("If-Match", "\"i_other.png\"")]).problem(412, "precondition-failed");
    assert_eq!(ask(&fresh, "QUERY", "/v1/render?width=24", &[("If-None-Match", &etag)]).status, 200, "another picture");
    let tile = ask(&fresh, "POST", "/v1/render/tile?x=1&y=2&w=3&h=4", &[]);
    assert_ne!(tile.header("etag"), etag);
    assert_eq!(ask(&fresh, "POST", "/v1/render?format=webp", &[]).header("etag"), etag.replace(".png", ".webp"));
}

#[test]
fn query_is_a_safe_post() {
    let service = Service::start(&[]);
    let queried = ask(&service, "QUERY", "/v1/render", &[]);
    let posted = service.post_json("/v1/render", BALL);
    assert_eq!((queried.status, &queried.body), (200, &posted.body));
    assert_eq!(service.send("OPTIONS", "*", &[], b"").status, 204, "the service as a whole");
    let options = service.send("OPTIONS", "/v1/render", &[], b"");
    assert_eq!((options.status, options.header("allow")), (204, "OPTIONS, POST, QUERY"));
    assert!(options.header("accept-query").contains("application/json"));
    let refused = service.get("/v1/render");
    refused.problem(405, "method-not-allowed");
    assert_eq!(refused.header("allow"), "OPTIONS, POST, QUERY");
}

#[test]
fn a_picture_has_an_address_where_it_stays() {
    let service = Service::start(&[]);
    for (query, ending) in
        [("", "png"), ("?bits=16", "png?bits=16"), ("?format=jpg&quality=40", "jpg?quality=40"), ("?format=exr", "exr")]
    {
        let posted = service.post_json(&format!("/v1/render{query}"), BALL);
        let place = posted.header("content-location").to_owned();
        assert!(place.starts_with("/v1/images/i_") && place.ends_with(ending), "{place}");
        assert_eq!(
            (posted.header("cache-control"), posted.header("vary").contains("Accept")),
            ("no-cache", !query.contains("format"))
        );
        let got = service.get(&place);
        assert_eq!((got.status, &got.body), (200, &posted.body), "{place}");
        assert_eq!(got.header("cache-control"), "public, max-age=31536000, immutable");
        for name in ["etag", "repr-digest", "render-rays", "content-type"] {
            assert_eq!(got.header(name), posted.header(name), "{name} of {place}");
        }
        let again = service.send("GET", &place, &[("If-None-Match", got.header("etag"))], b"");
        assert_eq!((again.status, again.body.len()), (304, 0));
    }
    let posted = service.post_json("/v1/render", BALL);
    let digest = posted.header("repr-digest");
    assert!(digest.starts_with("sha-256=:") && digest.ends_with("=:"), "{digest}");
    service.get("/v1/images/i_nobody.png").problem(404, "not-found");
    service.get(&posted.header("content-location").replace(".png", ".gif")).problem(404, "not-found");
}

#[test]
fn the_same_scene_has_the_same_name_however_it_is_written() {
    let service = Service::start(&[]);
    let (answer, image) = add(&service, "/v1/scenes", BALL);
    assert_eq!(answer.status, 201);
    let about = answer.json();
    let place = about["links"]["self"].as_str().unwrap().to_owned();
    assert_eq!(answer.header("location"), place);
    assert!(about["estimate"]["rays"].as_u64() > Some(0), "{about}");

    let value: serde_json::Value = serde_json::from_str(BALL).unwrap();
    let entries: Vec<String> =
        value.as_object().unwrap().iter().rev().map(|(key, value)| format!("\"{key}\": {value}")).collect();
    let reordered = format!("{{ {} }}", entries.join(",\n"));
    let (answer, other) = add(&service, "/v1/scenes", &reordered);
    assert_eq!((answer.status, &other), (200, &image));
    let canonical = service.get(&place);
    assert_eq!(canonical.status, 200);
    let (answer, other) = add(&Service::start(&[]), "/v1/scenes", &canonical.text());
    assert_eq!((answer.status, other), (201, image.clone()), "the canonical text is the scene");
    assert_ne!(add(&service, "/v1/scenes?max_depth=3", BALL).1, image);
    assert_ne!(add(&service, "/v1/scenes?zoom=2", BALL).1, image);

    let picture = format!("/v1/images/{image}.png");
    assert_eq!(service.get(&picture).body, service.post_json("/v1/render", BALL).body);
    service.send("DELETE", &place, &[("If-Match", "\"other\"")], b"").problem(412, "precondition-failed");
    service.send("DELETE", &place, &[("If-None-Match", "*")], b"").problem(412, "precondition-failed");
    service.send("DELETE", "/v1/scenes/s_none", &[("If-None-Match", "*")], b"").problem(404, "not-found");
    let own = format!("\"{}\"", place.rsplit('/').next().unwrap());
    assert_eq!(service.send("DELETE", &place, &[("If-Match", &own)], b"").status, 204);
    for path in [place.as_str(), picture.as_str()] {
        service.get(path).problem(404, "not-found");
    }
    service.send("DELETE", &place, &[], b"").problem(404, "not-found");
}

#[test]
fn what_is_known_outlasts_the_process() {
    let folder = folder("what_is_known_outlasts_the_process");
    let flags = ["--cache", folder.to_str().unwrap()];
    let service = Service::start(&flags);
    let (_, image) = add(&service, "/v1/scenes", BALL);
    let path = format!("/v1/images/{image}.png");
    let first = service.get(&path);
    assert_eq!(first.status, 200);
    drop(service);

    let service = Service::start(&[&flags[..], &["--threads", "1"]].concat());
    let kept = service.get(&path);
    assert_eq!((&kept.body, kept.header("render-rays")), (&first.body, first.header("render-rays")));
    assert!(timing(&kept).contains("picture;desc=hit"), "{}", timing(&kept));
    let tile = service.get(&format!("/iiif/3/{image}/0,0,10,10/max/0/default.png"));
    assert_eq!(tile.status, 200, "the scene is built again from its text: {}", tile.text());
    drop(service);

    // Half a file is as good as none, and the picture is rendered again, to the same bytes.
    for entry in std::fs::read_dir(folder.join("pictures")).unwrap() {
        let path = entry.unwrap().path();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    }
    let service = Service::start(&flags);
    let again = service.get(&path);
    assert_eq!(again.body, first.body);
    assert!(timing(&again).contains("trace;dur="), "{}", timing(&again));
}

#[test]
fn kept_pictures_stay_within_their_bytes_and_are_made_again() {
    let service = Service::start(&["--picture-cache-bytes", "20000", "--known-scene-bytes", "100000"]);
    let (_, image) = add(&service, "/v1/scenes", BALL);
    let path = format!("/v1/images/{image}.png");
    let first = service.get(&path);
    // With its cost report, each of these takes between a third and the half of the budget.
    assert!(timing(&service.get(&path)).contains("picture;desc=hit"));
    for depth in [1, 2] {
        assert_eq!(service.post_json(&format!("/v1/render?max_depth={depth}"), BALL).status, 200);
    }
    let again = service.get(&path);
    assert!(timing(&again).contains("trace;dur="), "{}", timing(&again));
    assert_eq!(again.body, first.body);
    let limits = service.get("/v1/limits").json();
    assert_eq!(limits["request"]["picture_cache_bytes"], 20_000);
}

#[test]
fn the_same_work_is_done_once_and_given_up_with_the_last_who_waits() {
    let service = Service::start(&NO_TIMEOUT);
    let mut waiting: Vec<_> = (0..4).map(|_| service.begin("/v1/render", SLOW)).collect();
    service.wait_for(1, 0);
    thread::sleep(Duration::from_millis(200));
    service.wait_for(1, 0);
    let last = waiting.pop();
    drop(waiting);
    thread::sleep(Duration::from_millis(200));
    service.wait_for(1, 0);
    drop(last);
    service.wait_for(0, 0);

    // Those who stay get the same picture from one render.
    let scene = BALL.replace(r#""width": 48, "height": 32"#, r#""width": 900, "height": 600"#);
    let answers: Vec<Answer> = thread::scope(|scope| {
        let ask = || Answer::read(service.begin("/v1/render?samples=16", &scene));
        let asked: Vec<_> = (0..4).map(|_| scope.spawn(ask)).collect();
        asked.into_iter().map(|asked| asked.join().unwrap()).collect()
    });
    for answer in &answers {
        assert_eq!((answer.status, &answer.body), (200, &answers[0].body));
    }
}

#[test]
fn pictures_that_files_decide_on_have_no_name() {
    let folder = folder("pictures_that_files_decide_on_have_no_name");
    std::fs::create_dir_all(&folder).unwrap();
    image::RgbImage::from_pixel(2, 2, image::Rgb([9, 99, 199])).save(folder.join("wall.png")).unwrap();
    let service = Service::start(&["--textures", folder.to_str().unwrap()]);
    let wall = super::scene_cache::WALL;
    let answer = service.post_json("/v1/render", wall);
    assert_eq!((answer.status, answer.header("etag"), answer.header("cache-control")), (200, "", "no-store"));
    service.post_json("/v1/scenes", wall).problem(422, "invalid-scene");
}

#[test]
fn a_head_request_says_what_a_get_would() {
    let service = Service::start(&[]);
    let (_, image) = add(&service, "/v1/scenes", BALL);
    let path = format!("/v1/images/{image}.png");
    let get = service.get(&path);
    let mut stream = service.connect();
    stream.write_all(&request("HEAD", &path, &[], b"")).unwrap();
    let head = Answer::read(stream);
    assert_eq!((head.status, head.body.len()), (200, 0));
    assert_eq!(head.header("content-length"), get.body.len().to_string());
    assert_eq!(head.header("etag"), get.header("etag"));
}
