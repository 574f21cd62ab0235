//! A service without keys is not open to the web: names that lead to it, pages that send it requests, and what `Host` may say.

use super::access::KeyFile;
use super::jobs::submit;
use crate::common::service::{Answer, Service};
use crate::common::{BALL, SLOW};
use std::io::Write;

/// The answer to a request whose line and headers are these.
fn raw(service: &Service, lines: &[&str]) -> Answer {
    let mut stream = service.connect();
    write!(stream, "{}\r\nConnection: close\r\n\r\n", lines.join("\r\n")).unwrap();
    Answer::read(stream)
}

fn get(service: &Service, host: &str, path: &str) -> Answer {
    raw(service, &[&format!("GET {path} HTTP/1.1"), &format!("Host: {host}")])
}

fn store(service: &Service) -> String {
    service.post_json("/v1/scenes", BALL).json()["image_id"].as_str().unwrap().to_owned()
}

const OWN: [&str; 5] = ["localhost", "LocalHost:3000", "127.0.0.1:8080", "127.9.9.9", "[::1]:8080"];
const FOREIGN: [&str; 5] =
    ["evil.example", "evil.example:8080", "localhost.evil.example", "10.0.0.1", "127.0.0.1.nip.example"];

#[test]
fn without_keys_the_service_answers_to_its_own_names_only() {
    let service = Service::start(&["--cors-origin", "none", "--public-url", "https://render.example.org"]);
    let image = store(&service);
    let places = ["/livez", "/v1/jobs", "/docs", "/nothing"].map(str::to_owned);
    let tiles = ["/iiif/3/ID/info.json", "/dzi/ID.dzi", "/xyz/ID.json", "/v1/images/ID.png"];
    for path in places.into_iter().chain(tiles.map(|path| path.replace("ID", &image))) {
        for host in OWN.into_iter().chain(["render.example.org", "Render.Example.org:443"]) {
            assert!([200, 404].contains(&get(&service, host, &path).status), "{host} {path}");
        }
        for host in FOREIGN {
            let refused = get(&service, host, &path).problem(421, "misdirected-request");
            assert!(refused["detail"].as_str().unwrap().contains("--public-url"), "{refused}");
        }
    }
    raw(&service, &["GET http://evil.example/livez HTTP/1.1", "Host: localhost"]).problem(421, "misdirected-request");
    let keyed = KeyFile::new("hosts", "").serve(&[]);
    for host in FOREIGN {
        assert_eq!(get(&keyed, host, "/livez").status, 200, "{host}");
    }
}

#[test]
fn without_keys_pages_of_other_sites_read_nothing_and_change_nothing() {
    let service = Service::start(&[]);
    let image = store(&service);
    let job = submit(&service, SLOW, "");
    let cancel = format!("/v1/jobs/{job}/cancel");
    let allowed = "access-control-allow-origin";
    let preflight = [("Access-Control-Request-Method", "DELETE")];
    for origin in ["https://evil.example", "http://localhost.evil.example", "null"] {
        let tiles = ["/iiif/3/ID/info.json", "/dzi/ID.dzi", "/xyz/ID.json", "/iiif/3/ID/full/8,/0/default.png"];
        for path in ["/v1/jobs"].into_iter().chain(tiles).map(|path| path.replace("ID", &image)) {
            let answer = service.send("GET", &path, &[("Origin", origin)], b"");
            assert_eq!((answer.status, answer.header(allowed)), (200, ""), "{origin} {path}");
        }
        let headers = [&[("Origin", origin)], &preflight[..]].concat();
        let asked = service.send("OPTIONS", &format!("/v1/jobs/{job}"), &headers, b"");
        assert_eq!((asked.header(allowed), asked.header("access-control-allow-methods")), ("", ""), "{origin}");
        for (method, path) in
            [("POST", cancel.as_str()), ("DELETE", &format!("/v1/jobs/{job}")), ("POST", "/v1/render")]
        {
            let refused = service.send(method, path, &[("Origin", origin)], BALL.as_bytes());
            let refused = refused.problem(403, "forbidden");
            assert!(refused["detail"].as_str().unwrap().contains("--cors-origin"), "{refused}");
        }
    }
    for origin in ["http://localhost:5173", "http://127.0.0.1:8080", "http://[::1]"] {
        let answer = service.send("GET", "/v1/jobs", &[("Origin", origin)], b"");
        assert_eq!((answer.status, answer.header(allowed), answer.header("vary")), (200, origin, "Origin"));
    }
    let local = service.send("POST", &cancel, &[("Origin", "http://localhost:5173")], b"");
    assert_eq!(local.status, 202, "{}", local.text());
}

#[test]
fn own_pages_and_named_ones_may_do_everything() {
    let service = Service::start(&["--cors-origin", "https://a.org"]);
    let status = |origin: &str| service.send("POST", "/v1/render", &[("Origin", origin)], BALL.as_bytes()).status;
    assert_eq!(["https://a.org", "https://b.org", "http://localhost:1"].map(status), [200, 403, 403]);
    assert_eq!(status("http://localhost"), 200, "its own page at /docs, by the Host of the test's requests");
    let service = Service::start(&["--cors-origin", "*"]);
    assert_eq!(service.send("POST", "/v1/render", &[("Origin", "https://b.org")], BALL.as_bytes()).status, 200);
}

#[test]
fn a_request_has_one_host_that_can_be_one() {
    let service = KeyFile::new("one_host", "").serve(&[]);
    for lines in [
        &["GET /livez HTTP/1.1"][..],
        &["GET /livez HTTP/1.1", "Host: a.org", "Host: a.org"],
        &["GET /livez HTTP/1.1", "Host: "],
        &["GET /livez HTTP/1.1", "Host: a b"],
        &["GET /livez HTTP/1.1", "Host: user@a.org"],
        &["GET /livez HTTP/1.1", "Host: a.org:99999"],
        &["GET /livez HTTP/1.1", "Host: x>; rel=\"x\", <http://evil"],
    ] {
        raw(&service, lines).problem(400, "malformed-request");
    }
    assert_eq!(raw(&service, &["GET /livez HTTP/1.0"]).status, 200, "HTTP/1.0 knows no Host");
    assert_eq!(get(&service, "a.org:8080", "/livez").status, 200);
}

#[test]
fn addresses_in_answers_are_those_the_client_has_asked() {
    let service = Service::start(&[]);
    let image = store(&service);
    let info = get(&service, "localhost:81", &format!("/iiif/3/{image}/info.json")).json();
    assert_eq!(info["id"], format!("http://localhost:81/iiif/3/{image}"));
    let moved = get(&service, "127.0.0.1", &format!("/iiif/3/{image}"));
    let place = format!("http://127.0.0.1/iiif/3/{image}/info.json");
    assert_eq!((moved.status, moved.header("location")), (303, place.as_str()));
    for id in ["%0d%0aX", "nothing", "%3e"] {
        get(&service, "localhost", &format!("/iiif/3/{id}")).problem(404, "not-found");
    }
}
