//! Requests that are wrong, hostile or too much: each is refused early, with the reason and the limit's name.

use super::jobs::submit;
use crate::common::service::{Answer, NO_TIMEOUT, Service, request};
use crate::common::{BALL, SLOW};
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::{ErrorKind, Read, Write};
use std::time::Duration;

#[test]
fn every_mistake_has_its_problem() {
    let service = Service::start(&[]);
    let json = "application/json";
    let cases = [
        // method, path, content type, body, status, slug, a part of the text
        ("GET", "/v1", "", "", 404, "not-found", "nothing at /v1"),
        ("GET", "/v1/nothing", "", "", 404, "not-found", "/v1/nothing"),
        ("GET", "/problems/nothing", "", "", 404, "not-found", ""),
        ("GET", "/problems/%ff", "", "", 404, "not-found", "UTF-8"),
        ("GET", "/iiif/3/%ff/full/max/0/default.png", "", "", 404, "not-found", "UTF-8"),
        ("GET", "/v1/images/%ff", "", "", 404, "not-found", "UTF-8"),
        ("GET", "/v1/render", "", "", 405, "method-not-allowed", ""),
        ("POST", "/livez", json, "{}", 405, "method-not-allowed", ""),
        ("POST", "/v1/render", "", "v", 415, "unsupported-media-type", "application/json"),
        ("POST", "/v1/render", "text/html", BALL, 415, "unsupported-media-type", "application/json"),
        ("POST", "/v1/render", "application/x-www-form-urlencoded", "a=1", 415, "unsupported-media-type", "text/x-nff"),
        ("POST", "/v1/rays", "text/x-nff", "v", 415, "unsupported-media-type", "application/json"),
        ("POST", "/v1/render?widht=3", json, BALL, 400, "invalid-parameter", "did you mean"),
        ("POST", "/v1/render?width=-3", json, BALL, 400, "invalid-parameter", "width"),
        ("POST", "/v1/render?width=%ff", json, BALL, 400, "invalid-parameter", ""),
        ("POST", "/v1/render?two_sided=true", json, BALL, 400, "invalid-parameter", "NFF"),
        ("POST", "/v1/render/tile?x=0&y=0&w=4", json, BALL, 400, "invalid-parameter", "\"h\""),
        ("POST", "/v1/render/tile?x=48&y=0&w=1&h=1", json, BALL, 400, "invalid-parameter", "48 x 32"),
        ("POST", "/v1/render/tile?x=0&y=0&w=0&h=1", json, BALL, 400, "invalid-parameter", "48 x 32"),
        ("POST", "/v1/render/tile?x=4294967295&y=0&w=2&h=1", json, BALL, 400, "invalid-parameter", "48 x 32"),
        ("POST", "/v1/tree?x=0&y=32", json, BALL, 400, "invalid-parameter", "48 x 32"),
        ("POST", "/v1/tree?x=0&y=0&format=png", json, BALL, 400, "invalid-parameter", "svg"),
        ("POST", "/v1/render", json, "", 400, "invalid-json", ""),
        ("POST", "/v1/render", json, "{\"version\": 1,", 400, "invalid-json", ""),
        ("POST", "/v1/scenes/validate", json, "nonsense", 400, "invalid-json", ""),
        ("POST", "/v1/scenes/validate", json, "{}", 422, "invalid-scene", ""),
        ("POST", "/v1/rays", json, "{\"scene\": {}", 400, "invalid-json", ""),
        ("POST", "/v1/rays", json, "{\"rays\": []}", 422, "invalid-rays", "scene"),
        (
            "POST",
            "/v1/rays",
            json,
            "{\"scene\": {}, \"rays\": [{\"origin\": [0,0,0]}]}",
            422,
            "invalid-rays",
            "#/rays/0",
        ),
        ("POST", "/v1/rays", json, "{\"scene\": {}, \"rays\": []}", 422, "invalid-scene", "#/scene"),
        (
            "POST",
            "/v1/rays",
            json,
            "{\"scene\": {}, \"rays\": [{\"origin\": [0,0,0], \"direction\": [0,0,1e-320]}]}",
            422,
            "invalid-rays",
            "too short",
        ),
        ("POST", "/v1/render", "text/x-nff", "what is this", 400, "invalid-nff", ""),
    ];
    for (method, path, content_type, body, status, slug, part) in cases {
        let headers = [("Content-Type", content_type)];
        let headers = if content_type.is_empty() { &headers[..0] } else { &headers[..] };
        let answer = service.send(method, path, headers, body.as_bytes());
        assert_eq!(answer.status, status, "{method} {path} {body}: {}", answer.text());
        answer.problem(status, slug);
        assert!(
            answer.text().contains(part) || answer.text().contains(&part.replace('"', "\\\"")),
            "{part} in {}",
            answer.text()
        );
    }
    assert_eq!(service.get("/v1/render").header("allow"), "OPTIONS, POST, QUERY");
}

#[test]
fn all_problems_of_a_scene_are_reported_with_their_places() {
    let service = Service::start(&[]);
    let scene =
        BALL.replace("\"radius\": 1", "\"radius\": -1").replace("\"normal\": [0, 1, 0]", "\"normal\": [0, 0, 0]");
    let problem = service.post_json("/v1/render", &scene).problem(422, "invalid-scene");
    let errors = problem["errors"].as_array().expect("a list");
    assert_eq!(errors.len(), 2, "{problem}");
    assert_eq!(errors[0]["pointer"], "#/objects/0/sphere/radius");
    assert_eq!(errors[0]["line"], 8);
    assert!(errors[0]["column"].is_u64() && errors[0]["code"].is_string() && errors[0]["detail"].is_string());
}

#[test]
fn all_problems_of_other_bodies_are_reported_with_their_places() {
    let service = Service::start(&[]);
    for (path, body, kind, expected) in [
        (
            "/v1/jobs",
            format!(r#"{{"scene": {BALL}, "priority": 300, "labels": [1], "framez": {{}}}}"#),
            "invalid-request",
            &["#/priority", "#/labels/0", "#/framez"][..],
        ),
        (
            "/v1/jobs",
            format!(r#"{{"scene": {BALL}, "frames": {{"count": 0, "turntable": {{"axes": [0, 1, 0]}}}}}}"#),
            "invalid-request",
            &["#/frames/count", "#/frames/turntable/axes"],
        ),
        ("/v1/jobs", BALL.to_owned(), "invalid-request", &["#", "#/version", "#/image"]),
        ("/v1/rays", format!(r#"{{"scene": {BALL}, "rays": {{"origin": [0, 0, 0]}}}}"#), "invalid-rays", &["#/rays"]),
        // Lists of fields in the places of objects.
        (
            "/v1/rays",
            format!(r#"{{"scene": {BALL}, "rays": [[[0, 0, 0], [0, 0, 1]]]}}"#),
            "invalid-rays",
            &["#/rays/0"],
        ),
        (
            "/v1/rays",
            format!(r#"{{"scene": {BALL}, "rays": [{{"origin": [0, 0, 0], "direction": [0, 0, 0]}}]}}"#),
            "invalid-rays",
            &["#/rays/0/direction"],
        ),
        ("/v1/rays", format!(r#"[{BALL}, []]"#), "invalid-rays", &["#"]),
        (
            "/v1/jobs",
            format!(
                r#"{{"scene": {BALL}, "frames": {{"count": 2, "turntable": [[0, 1, 0]]}}, "webhook": ["http://a"]}}"#
            ),
            "invalid-request",
            &["#/frames/turntable", "#/webhook"],
        ),
        (
            "/v1/compare",
            format!(r#"{{"a": {{"scene": {BALL}}}, "b": ["i_a", null, {{}}]}}"#),
            "invalid-request",
            &["#/b"],
        ),
        ("/v1/compare", r#"{"a": {"image": 1}, "b": {}}"#.to_owned(), "invalid-request", &["#/a/image"]),
        ("/v1/assets/missing", r#"{"sha256": "abc"}"#.to_owned(), "invalid-request", &["#/sha256"]),
        ("/v1/assets/missing", r#"{"sha256": [], "a": 1}"#.to_owned(), "invalid-request", &["#/a"]),
        ("/v1/assets/missing", "{}".to_owned(), "invalid-request", &["#"]),
        (
            "/v1/jobs",
            format!(r#"{{"scene": {BALL}, "webhook": {{"url": "http://a", "key": 1}}}}"#),
            "invalid-request",
            &["#/webhook/key"],
        ),
        ("/v1/explain", format!(r#"{{"scene": {BALL}, "settings": 1}}"#), "invalid-request", &["#/settings"]),
    ] {
        let problem = service.post_json(path, &body).problem(422, kind);
        let errors = problem["errors"].as_array().unwrap_or_else(|| panic!("{path}: {problem}"));
        let pointers: Vec<_> = errors.iter().map(|error| error["pointer"].as_str().unwrap()).collect();
        assert_eq!(pointers[..expected.len()], *expected, "{path}: {problem}");
        assert!(errors.iter().all(|error| error["line"].is_u64()), "{path}: {problem}");
        let detail = problem["detail"].as_str().unwrap();
        assert!(
            ["struct", "u8", "expected a map", "invalid type"].iter().all(|word| !detail.contains(word)),
            "{detail}"
        );
    }
}

#[test]
fn hostile_scenes_are_refused_with_the_limits_name() {
    let service = Service::start(&[]);
    let deep = format!("{}{}", "[".repeat(100_000), "]".repeat(100_000));
    let answer = service.post_json("/v1/render", &deep);
    assert!(matches!(answer.status, 400 | 422) && answer.text().contains("json_depth"), "{}", answer.text());
    assert!(answer.text().len() < 600, "{}", answer.text());
    let deep_inside = format!("{{\"scene\": {deep}, \"rays\": []}}");
    let answer = service.post_json("/v1/rays", &deep_inside);
    assert!(matches!(answer.status, 400 | 422) && answer.text().contains("json_depth"), "{}", answer.text());

    let answer = service.post_json("/v1/render?width=4000000000&height=4000000000", BALL);
    assert!(answer.status == 400 && answer.text().contains("image_side"), "{}", answer.text());
    let absurd = BALL.replacen('{', "{ \"image\": { \"width\": 4000000000 },", 1);
    let answer = service.post_json("/v1/render", &absurd);
    assert!(answer.status == 422 && answer.text().contains("image"), "{}", answer.text());
    let problem = service.post_json("/v1/render?width=16000&height=4000", BALL).problem(413, "cost-limit");
    assert_eq!(problem["limit"]["name"], "max_pixels");
    let problem = service.post_json("/v1/render?width=2000&height=2000&samples=100", BALL).problem(413, "cost-limit");
    assert_eq!(problem["limit"]["name"], "max_samples_total");
    let tile = service.post_json("/v1/render/tile?width=16000&height=4000&x=15990&y=3990&w=10&h=10", BALL);
    assert_eq!(tile.status, 200, "a small part of a large picture is fine: {}", tile.text());

    let rays = vec![r#"{"origin":[0,0,0],"direction":[0,0,1]}"#; 100_001].join(",");
    let many = service.post_json("/v1/rays", &format!("{{\"scene\": {BALL}, \"rays\": [{rays}]}}"));
    assert_eq!(many.problem(413, "too-large")["limit"]["name"], "max_rays");
}

/// A body may be of several members of gzip, one after the other (RFC 1952, section 2.2). What comes out is limited in all.
#[test]
fn all_members_of_a_gzip_body_are_read() {
    let service = Service::start(&["--max-body-bytes", "100000"]);
    let gzip = |bytes: &[u8]| {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    let headers = [("Content-Type", "application/json"), ("Content-Encoding", "gzip")];
    let send = |body: &[u8]| service.send("POST", "/v1/render", &headers, body);
    let (first, second) = BALL.as_bytes().split_at(BALL.len() / 2);
    let both = [gzip(first), gzip(second)].concat();
    let answer = send(&both);
    assert_eq!(answer.status, 200, "{}", answer.text());
    assert!(answer.body == service.post_json("/v1/render", BALL).body);
    send(&both[..both.len() - 9]).problem(400, "invalid-encoding");
    send(&[&both[..], b"more"].concat()).problem(400, "invalid-encoding");
    let large = gzip(&[b' '; 60_000]);
    assert_eq!(send(&[&large[..], &large].concat()).problem(413, "too-large")["limit"]["name"], "max_body_bytes");
}

/// Parts of a model that cannot be told apart.
#[test]
fn parts_of_the_same_name_and_two_models_are_refused() {
    let service = Service::start(&[]);
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let send = |names: &[&str]| {
        let part = |name: &&str| {
            format!("--X\r\nContent-Disposition: form-data; name=\"f\"; filename=\"{name}\"\r\n\r\n{triangle}\r\n")
        };
        let body = names.iter().map(part).collect::<String>() + "--X--\r\n";
        let headers = [("Content-Type", "multipart/form-data; boundary=X")];
        service.send("POST", "/v1/render?width=16&height=16", &headers, body.as_bytes())
    };
    assert_eq!(send(&["a.obj", "b.txt"]).status, 200);
    for (names, expected) in [
        (&["a.obj", "notes.txt", "b.stl"][..], "\"a.obj\" and \"b.stl\" are both models"),
        (&["a.obj", "b.txt", "b.txt"], "parts 2 and 3 have the same name, \"b.txt\""),
        (&["a.obj", "x//b.txt", "./x/b.txt"], "parts 2 and 3 have the same name, \"x/b.txt\""),
        (&[], "the body has no parts"),
    ] {
        let problem = send(names).problem(422, "invalid-scene");
        assert!(problem["detail"].as_str().unwrap().contains(expected), "{problem}");
    }
}

#[test]
fn a_material_library_alone_says_what_it_is() {
    let service = Service::start(&[]);
    let library = b"# Blender MTL File\nnewmtl red\nKd 1 0 0\n";
    for headers in [&[][..], &[("Content-Type", "model/obj")], &[("Content-Type", "text/x-nff")]] {
        let answer = service.send("POST", "/v1/render", headers, library);
        assert!((400..=422).contains(&answer.status), "{}", answer.text());
        let said = answer.text();
        assert!(said.contains("material library of Wavefront OBJ") && said.contains("send its .obj"), "{said}");
    }
}

#[test]
fn a_large_body_is_refused_before_it_is_sent() {
    let service = Service::start(&["--max-body-bytes", "10000"]);
    let mut stream = service.connect();
    let head = "POST /v1/render HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nExpect: 100-continue\r\n\
                Content-Length: 10000000000\r\nConnection: close\r\n\r\n";
    stream.write_all(head.as_bytes()).unwrap();
    assert_eq!(Answer::read(stream).problem(413, "too-large")["limit"]["name"], "max_body_bytes");

    // Without an announced length it is refused as soon as it is too long.
    let mut stream = service.connect();
    let head = "POST /v1/render HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n\
                Transfer-Encoding: chunked\r\nConnection: close\r\n\r\n";
    stream.write_all(head.as_bytes()).unwrap();
    stream.write_all(format!("2711\r\n{}\r\n", " ".repeat(10_001)).as_bytes()).unwrap();
    Answer::read(stream).problem(413, "too-large");
}

#[test]
fn bodies_come_in_no_transfer_coding_but_chunks() {
    let service = Service::start(&[]);
    let send = |codings: &[&str]| {
        let mut stream = service.connect();
        let lines: String = codings.iter().map(|coding| format!("Transfer-Encoding: {coding}\r\n")).collect();
        let head =
            "POST /v1/render HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nConnection: close\r\n";
        let body = format!("{:x}\r\n{BALL}\r\n0\r\n\r\n", BALL.len());
        stream.write_all(format!("{head}{lines}\r\n{body}").as_bytes()).unwrap();
        Answer::read(stream)
    };
    for codings in [&["gzip, chunked"][..], &["gzip", "chunked"], &["chunked, chunked"]] {
        send(codings).problem(501, "not-implemented");
    }
    send(&["gzip"]).problem(400, "malformed-request");
    send(&["Chunked"]).picture();
}

#[test]
fn a_body_that_breaks_off_is_no_request() {
    let service = Service::start(&[]);
    let mut stream = service.connect();
    let head = "POST /v1/render HTTP/1.1\r\nHost: localhost\r\nContent-Type: model/gltf-binary\r\n\
                Transfer-Encoding: chunked\r\nConnection: close\r\n\r\n";
    stream.write_all(format!("{head}4\r\nglTF\r\nno length\r\n").as_bytes()).unwrap();
    let problem = Answer::read(stream).problem(400, "malformed-request");
    assert!(problem["detail"].as_str().unwrap().contains("broke off"), "{problem}");
}

#[test]
fn changes_have_to_arrive_in_time_and_are_small() {
    let service = Service::start(&["--body-timeout", "0.5"]);
    let job = submit(&service, BALL, "");
    let path = format!("/v1/jobs/{job}");
    let whole = request("PATCH", &path, &[], br#"{"priority": 1}"#);
    let mut slow = service.connect();
    slow.write_all(&whole[..whole.len() - 5]).unwrap();
    Answer::read(slow).problem(408, "body-timeout");
    let long = format!(r#"{{"priority": 1{}}}"#, " ".repeat(4_096));
    service.send("PATCH", &path, &[], long.as_bytes()).problem(422, "invalid-request");
}

#[test]
fn slow_clients_are_cut_off() {
    let service = Service::start(&["--header-timeout", "0.3", "--body-timeout", "0.3"]);
    let mut idle = service.connect();
    let mut half = service.connect();
    half.write_all(b"GET /livez HTTP/1.1\r\nHo").unwrap();
    for stream in [&mut idle, &mut half] {
        let mut rest = Vec::new();
        let read = stream.read_to_end(&mut rest);
        // The service ends the connection, by an end or a reset.
        assert!(!read.is_err_and(|error| matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)));
        assert!(!rest.starts_with(b"HTTP/1.1 200"));
    }
    let mut body = service.connect();
    let whole = request("POST", "/v1/render", &[("Content-Type", "application/json")], BALL.as_bytes());
    body.write_all(&whole[..whole.len() - 10]).unwrap();
    let problem = Answer::read(body).problem(408, "body-timeout");
    assert!(problem["detail"].as_str().unwrap().contains("body_timeout"), "{problem}");
}

#[test]
fn a_client_that_does_not_read_is_cut_off() {
    let service = Service::start(&["--write-timeout", "0.3"]);
    let mut stream = service.begin("/v1/render?width=2048&height=2048&samples=1&max_depth=1&format=pfm", SLOW);
    service.wait_for(1, 0);
    service.wait_for(0, 0);
    std::thread::sleep(Duration::from_secs(3));
    let mut got = Vec::new();
    let _ = stream.read_to_end(&mut got);
    assert!(got.len() < 2048 * 2048 * 12, "all {} bytes came", got.len());
}

#[test]
fn a_refused_body_is_listened_to_so_that_its_sender_hears_why() {
    let service = Service::start(&[]);
    let large = " ".repeat(8 << 20);
    service.post_json("/v1/render?widht=3", &large).problem(400, "invalid-parameter");
    service.send("POST", "/v1/render", &[], large.as_bytes()).problem(415, "unsupported-media-type");
}

#[test]
fn endless_headers_are_refused() {
    let service = Service::start(&[]);
    let mut stream = service.connect();
    let head = format!("GET /livez HTTP/1.1\r\nX-Long: {}\r\n\r\n", "x".repeat(1 << 20));
    // It may hang up while the rest is still being sent, and then the answer may get lost: what counts is that no
    // such request is served.
    let _ = stream.write_all(head.as_bytes());
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    assert!(answer.is_empty() || answer.starts_with(b"HTTP/1.1 431"), "{}", String::from_utf8_lossy(&answer));
}

#[test]
fn a_full_queue_says_when_to_come_back() {
    let service = Service::start(&[&NO_TIMEOUT[..], &["--queue", "1"]].concat());
    // Two take turns (one renders while the other would encode), one waits. The same picture would be rendered once.
    let busy: Vec<_> = (0..3).map(|i| service.begin(&format!("/v1/render?max_depth={}", 900 + i), SLOW)).collect();
    service.wait_for_all(3);
    let answer = service.post_json("/v1/render", BALL);
    answer.problem(503, "saturated");
    assert!(answer.header("retry-after").parse::<u32>().is_ok_and(|s| (1..=120).contains(&s)));
    // It was refused at once: it has not waited for any of them.
    service.wait_for_all(3);
    assert_eq!(service.get("/livez").status, 200);
    assert_eq!(service.get("/readyz").status, 200, "busy is not the same as not ready");
    drop(busy);
    service.wait_for(0, 0);
    assert_eq!(service.post_json("/v1/render", BALL).status, 200);
}

/// In memory they would take 16 times their bytes.
#[test]
fn settings_and_lists_of_bodies_are_bounded() {
    let service = Service::start(&[]);
    let long = format!(r#"{{"width": [{}0]}}"#, "0,".repeat(1 << 17));
    for (path, body) in [
        ("/v1/jobs", format!(r#"{{"scene": {BALL}, "settings": {long}}}"#)),
        ("/v1/jobs", format!(r#"{{"scene": {BALL}, "output": {long}}}"#)),
        ("/v1/explain", format!(r#"{{"scene": {BALL}, "settings": [{long}]}}"#)),
        ("/v1/compare", format!(r#"{{"a": {{"scene": {BALL}, "settings": {long}}}, "b": {{"scene": {BALL}}}}}"#)),
    ] {
        let problem = service.post_json(path, &body).problem(422, "invalid-request").to_string();
        assert!(problem.contains("at most 65536 bytes"), "{path}: {problem}");
    }
    let labels = format!(r#"{{"scene": {BALL}, "labels": [{}"z"]}}"#, r#""a","#.repeat(100_000));
    let problem = service.post_json("/v1/jobs", &labels).problem(422, "invalid-request").to_string();
    assert!(problem.contains("at most 16 labels"), "{problem}");
    let hashes = format!(r#"{{"sha256": [{}""]}}"#, r#""","#.repeat(10_000));
    let problem = service.post_json("/v1/assets/missing", &hashes).problem(422, "invalid-request").to_string();
    assert!(problem.contains("at most 10000 hashes"), "{problem}");
}
