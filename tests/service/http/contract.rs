//! What the service says about itself, and the answers that no handler gives.

use crate::common::BALL;
use crate::common::service::{Answer, Service};
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn raw(service: &Service, bytes: &[u8]) -> Answer {
    let mut stream = service.connect();
    stream.write_all(bytes).unwrap();
    Answer::read(stream)
}

#[test]
fn the_documentation_needs_no_network() {
    let service = Service::start(&[]);
    let page = service.get("/docs");
    assert!(page.header("content-security-policy").contains("default-src 'none'; script-src 'self'"));
    assert!(!page.text().contains("http://") && !page.text().contains("https://"), "{}", page.text());
    for path in page.text().split('"').filter(|part| part.starts_with('/')) {
        assert_eq!(service.get(path).status, 200, "{path}");
    }
    let viewer = service.get("/docs/rapidoc.js");
    assert!(viewer.text().contains("RapiDoc 9.3.8"), "the viewer has no banner");
    let compressed = service.send("GET", "/docs/rapidoc.js", &[("Accept-Encoding", "br, gzip")], b"");
    assert_eq!(compressed.header("content-encoding"), "gzip");
    assert!(compressed.body.len() < viewer.body.len() / 3);
    assert_eq!(service.get("/openapi.json").json()["openapi"], "3.1.0");
}

#[test]
fn every_problem_has_a_page_for_people_and_one_for_programs() {
    let service = Service::start(&[]);
    let list = service.get("/problems").text();
    let paths: Vec<_> = list.lines().filter_map(|line| line.split(' ').nth(1)).collect();
    assert!(paths.len() >= 20, "{list}");
    for path in paths {
        let text = service.get(path);
        assert_eq!((text.status, text.header("content-type")), (200, "text/plain; charset=utf-8"), "{path}");
        let page = service.send("GET", path, &[("Accept", "text/html,application/xhtml+xml,*/*;q=0.8")], b"");
        assert_eq!((page.status, page.header("content-type")), (200, "text/html; charset=utf-8"), "{path}");
        assert!(page.text().contains("<h1>"), "{path}");
    }
}

#[test]
fn what_is_no_http_is_a_problem_like_any_other() {
    let service = Service::start(&[]);
    raw(&service, b"this is not HTTP\r\n\r\n").problem(400, "malformed-request");
    raw(&service, b"GET / HTTP/1.1\r\nbad header\r\n\r\n").problem(400, "malformed-request");
    let many: String = (0..200).map(|i| format!("X-{i}: 1\r\n")).collect();
    raw(&service, format!("GET / HTTP/1.1\r\n{many}\r\n").as_bytes()).problem(431, "headers-too-large");
    assert_eq!(service.get("/livez").status, 200);
}

#[test]
fn bodies_may_come_compressed_within_the_same_limits() {
    let service = Service::start(&["--max-body-bytes", "100000"]);
    let send = |path: &str, encoding: &str, body: &[u8]| {
        service.send("POST", path, &[("Content-Type", "application/json"), ("Content-Encoding", encoding)], body)
    };
    let plain = service.post_json("/v1/render", BALL);
    assert_eq!(send("/v1/render", "gzip", &gzip(BALL.as_bytes())).picture(), plain.picture());
    let bomb = gzip(&vec![b' '; 50_000_000]);
    assert!(bomb.len() < 100_000);
    let refused = send("/v1/render", "gzip", &bomb);
    refused.problem(413, "too-large");
    assert_eq!(refused.header("connection"), "close");
    let whole = gzip(BALL.as_bytes());
    send("/v1/render", "gzip", &whole[..whole.len() - 9]).problem(400, "invalid-encoding");
    send("/v1/render", "gzip", BALL.as_bytes()).problem(400, "invalid-encoding");
    let unknown = send("/v1/render", "br", BALL.as_bytes());
    let problem = unknown.problem(415, "unsupported-media-type");
    assert!(problem["detail"].as_str().unwrap().contains("Content-Encoding br"), "{problem}");
    assert_eq!(unknown.header("accept-encoding"), "gzip");
    // Where a media type is the reason, the header would mislead.
    let html = service.send("POST", "/v1/render", &[("Content-Type", "text/html")], BALL.as_bytes());
    html.problem(415, "unsupported-media-type");
    assert_eq!(html.header("accept-encoding"), "");
}

#[test]
fn warnings_come_with_the_picture() {
    let service = Service::start(&[]);
    assert_eq!(service.post_json("/v1/render", BALL).header("render-warnings"), "");
    let bright = BALL.replace("\"reflection\": 0.2", "\"reflection\": 0.8, \"transmission\": 0.7");
    let warned = service.post_json("/v1/render", &bright);
    warned.picture();
    assert!(warned.header("render-warnings").starts_with("\"/materials/red"), "{warned:?}");
    let listed = service.post_json("/v1/scenes/validate", &bright).json();
    assert_eq!(listed["warnings"].as_array().unwrap().len(), 1, "{listed}");
    // What the picture lacks, too.
    let mirror = BALL.replace("\"reflection\": 0.2", "\"reflection\": 0.8");
    assert_eq!(service.post_json("/v1/render", &mirror).header("render-warnings"), "");
    let shallow = service.post_json("/v1/render?max_depth=1", &mirror);
    assert!(shallow.header("render-warnings").starts_with("\"max_depth or min_weight cut off up to "), "{shallow:?}");
}

#[test]
fn a_scene_with_too_many_problems_says_how_many_more_there_are() {
    let service = Service::start(&[]);
    let spheres = vec![r#"{ "sphere": { "center": [0, 0, 0], "radius": -1 } }"#; 80].join(",");
    let scene = format!(
        r#"{{ "version": 1, "camera": {{ "pinhole": {{ "eye": [0, 0, 5], "look_at": [0, 0, 0] }} }}, "objects": [{spheres}] }}"#
    );
    let problem = service.post_json("/v1/scenes/validate", &scene).problem(422, "invalid-scene");
    assert_eq!(problem["errors"].as_array().unwrap().len(), 50);
    assert_eq!(problem["limit"]["name"], "problems");
    assert_eq!(problem["more"], 30);
    assert!(problem["detail"].as_str().unwrap().starts_with("80 problems"), "{problem}");
}

#[test]
fn mistakes_in_a_scene_count_even_where_the_query_overrides_them() {
    let service = Service::start(&[]);
    let scene = BALL.replace("\"version\": 1,", "\"version\": 1, \"render\": { \"samples\": 0 },");
    let problem = service.post_json("/v1/render?samples=1", &scene).problem(422, "invalid-scene");
    assert_eq!(problem["errors"][0]["pointer"], "#/render/samples");
    assert_eq!(problem["errors"][0]["line"], 2);
}
