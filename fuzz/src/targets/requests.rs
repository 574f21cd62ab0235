//! Parts of requests that clients write freely: each has an answer, and none is a failure of the service.

use crate::http::in_process::InProcess;
use axum::body::Body;
use axum::extract::Request;
use axum::http::Response;
use serde_json::Value;
use std::sync::LazyLock;

pub(super) const SCENE: &str = r#"{ "version": 1, "image": { "width": 40, "height": 24 },
    "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
    "objects": [ { "sphere": { "center": [0, 0, 0], "radius": 1 } } ] }"#;

/// A service with one picture and two jobs that have ended.
struct Asked {
    service: InProcess,
    image: String,
    jobs: [String; 2],
}

static ASKED: LazyLock<Asked> = LazyLock::new(|| {
    let service = InProcess::start(&["--max-pixels", "5000"]).expect("it starts");
    let known = json(&service.ask(post("/v1/scenes?zoom=2", SCENE.to_owned())));
    let jobs = [1, 2].map(|samples| {
        let job = format!(r#"{{ "scene": {SCENE}, "settings": {{ "samples": {samples} }} }}"#);
        let job = word(&json(&service.ask(post("/v1/jobs", job))), "id");
        let ended = json(&service.ask(get(&format!("/v1/jobs/{job}"), ("Prefer", b"wait=20")).expect("a request")));
        assert_eq!(ended["state"], "succeeded", "{ended}");
        job
    });
    Asked { image: word(&known, "image_id"), service, jobs }
});

pub(super) fn accept(header: &[u8]) {
    for path in [format!("/v1/images/{}", ASKED.image), format!("/iiif/3/{}/info.json", ASKED.image)] {
        let Some(request) = get(&path, ("Accept", header)) else { return };
        answer(request);
    }
}

/// The canonical address of an answer is one that gives the same.
pub(super) fn iiif(path: &[u8]) {
    let Ok(path) = std::str::from_utf8(path) else { return };
    let Some(request) = get(&format!("/iiif/3/{}/{path}", ASKED.image), ("Accept", b"*/*")) else { return };
    let given = answer(request);
    let Some(link) = given.headers().get("Link").filter(|_| given.status() == 200) else { return };
    let link = link.to_str().expect("text").split(['<', '>']).nth(1).expect("an address");
    let canonical = link.strip_prefix("http://localhost").expect("an address of this service");
    let again = answer(get(canonical, ("Accept", b"*/*")).expect("an address"));
    assert_eq!((again.status(), again.headers().get("Link")), (given.status(), given.headers().get("Link")));
    assert!(again.body() == given.body(), "{path} and {canonical} differ");
}

/// Events come in order, each once.
pub(super) fn events(last: &[u8]) {
    let [one, other] = &ASKED.jobs;
    for path in [format!("/v1/jobs/{one}/events"), format!("/v1/events?job={one}&job={other}")] {
        let Some(request) = get(&path, ("Last-Event-ID", last)) else { return };
        let given = answer(request);
        let text = String::from_utf8_lossy(given.body());
        let ids: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("id: ")).collect();
        let mut once = ids.clone();
        once.dedup();
        assert_eq!(ids, once, "{path}");
        assert!(given.status() == 204 || text.contains("event: succeeded") || given.status() == 400, "{text}");
    }
}

/// A request, if there can be one of this path and header.
pub(super) fn get(path: &str, (name, value): (&str, &[u8])) -> Option<Request<Body>> {
    Request::get(path).header("Host", "localhost").header(name, value).body(Body::empty()).ok()
}

pub(super) fn post(path: &str, body: String) -> Request<Body> {
    Request::post(path)
        .header("Host", "localhost")
        .header("Content-Type", "application/json")
        .body(body.into())
        .expect("a request")
}

/// What is not an answer is a problem document of the client's making.
fn answer(request: Request<Body>) -> Response<Vec<u8>> {
    let asked = format!("{request:?}");
    let given = ASKED.service.ask(request);
    let status = given.status();
    assert!(!status.is_server_error(), "{status} to {asked}: {}", String::from_utf8_lossy(given.body()));
    if status.is_client_error() {
        assert_eq!(json(&given)["status"], status.as_u16(), "{asked}");
    }
    given
}

pub(super) fn json(answer: &Response<Vec<u8>>) -> Value {
    serde_json::from_slice(answer.body()).expect("JSON")
}

pub(super) fn word(value: &Value, key: &str) -> String {
    value[key].as_str().unwrap_or_else(|| panic!("no {key} in {value}")).to_owned()
}
