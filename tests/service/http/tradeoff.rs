//! What accuracy costs, asked over HTTP.

use crate::common::service::{NO_TIMEOUT, Service};
use crate::common::{BALL, SLOW};
use std::time::Duration;

#[test]
fn a_tradeoff_is_json_or_a_page() {
    let service = Service::start(&[]);
    let answer = service.post_json("/v1/tradeoff?seconds=10", BALL);
    assert_eq!((answer.status, answer.header("content-type")), (200, "application/json"), "{}", answer.text());
    assert_eq!(answer.header("vary"), "Accept");
    let json = answer.json();
    assert!(json["points"].as_array().is_some_and(|points| points.len() >= 24), "{json}");
    assert_eq!(json["circumstances"]["size"], serde_json::json!([48, 32]), "{json}");
    assert_eq!(json["circumstances"]["seconds"], 10.0);

    let headers = [("Content-Type", "application/json"), ("Accept", "text/html,*/*;q=0.1")];
    let page = service.send("POST", "/v1/tradeoff?seconds=2", &headers, BALL.as_bytes());
    assert_eq!((page.status, page.header("content-type")), (200, "text/html; charset=utf-8"), "{}", page.text());
    assert!(page.text().starts_with("<!doctype html>"));
    // The page may show the pictures it contains, and nothing else.
    assert!(page.header("content-security-policy").contains("default-src 'none'; img-src data:"));
    let named = service.post_json("/v1/tradeoff?seconds=1&format=html", BALL);
    assert_eq!(named.header("content-type"), "text/html; charset=utf-8");
}

#[test]
fn a_tradeoff_has_limits() {
    let service = Service::start(&["--timeout", "9", "--max-pixels", "2000"]);
    assert_eq!(service.get("/v1/limits").json()["request"]["max_tradeoff_seconds"], 6.0);
    for seconds in ["0", "7", "NaN", "soon"] {
        let refused =
            service.post_json(&format!("/v1/tradeoff?seconds={seconds}"), BALL).problem(400, "invalid-parameter");
        assert!(refused["detail"].as_str().is_some_and(|s| s.contains("max_tradeoff_seconds")), "{refused}");
    }
    service.post_json("/v1/tradeoff?width=100&height=100", BALL).problem(413, "cost-limit");
    let headers = [("Content-Type", "application/json"), ("Accept", "image/png")];
    service.send("POST", "/v1/tradeoff", &headers, BALL.as_bytes()).problem(406, "not-acceptable");
    service.post_json("/v1/tradeoff", r#"{"version": 1}"#).problem(422, "invalid-scene");
}

#[test]
fn a_scene_that_the_time_does_not_suffice_for_says_what_was_not_measured() {
    let service = Service::start(&[]);
    let json = service.post_json("/v1/tradeoff?seconds=6&max_depth=100000&width=1024&height=1024", SLOW).json();
    let points = json["points"].as_array().map(Vec::as_slice).unwrap_or_default();
    assert!(points.iter().any(|point| point["time"].is_null() && point["rays"].is_null()), "{json}");
    assert!(points.iter().any(|point| point["time"]["median_ms"].is_f64()), "{json}");
}

#[test]
fn a_client_that_goes_away_stops_its_tradeoff() {
    let service = Service::start(&NO_TIMEOUT);
    let client = service.begin("/v1/tradeoff?seconds=300", SLOW);
    service.wait_for(1, 0);
    // Long enough that it measures.
    std::thread::sleep(Duration::from_millis(500));
    drop(client);
    service.wait_for(0, 0);
}

/// Points appear as they are measured, not after all of the time.
#[test]
fn what_is_found_comes_as_it_is_found() {
    let service = Service::start(&NO_TIMEOUT);
    let headers = [("Content-Type", "application/json"), ("Accept", "text/event-stream")];
    let answer = service.send("POST", "/v1/tradeoff?seconds=10", &headers, BALL.as_bytes());
    assert_eq!((answer.status, answer.header("content-type")), (200, "text/event-stream"), "{}", answer.text());
    let text = answer.text();
    let names: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("event: ")).collect();
    let first =
        |name: &str| names.iter().position(|known| *known == name).unwrap_or_else(|| panic!("{name}: {names:?}"));
    assert!(first("reference") < first("point") && first("point") < first("front"), "{names:?}");
    assert_eq!((names.last(), first("done")), (Some(&"done"), names.len() - 1));
    let data: Vec<serde_json::Value> =
        text.lines().filter_map(|line| serde_json::from_str(line.strip_prefix("data: ")?).ok()).collect();
    let point = &data[first("point")];
    assert!(point["part"] == "choices" && point["time_ms"].is_f64() && point["settings"].is_object(), "{point}");
    assert!(data.last().unwrap()["points"].as_array().unwrap().len() >= 24);

    service.send("POST", "/v1/tradeoff", &headers, br#"{"version": 1}"#).problem(422, "invalid-scene");
    let mut stream = service.connect();
    let request = crate::common::service::request("POST", "/v1/tradeoff?seconds=300", &headers, SLOW.as_bytes());
    std::io::Write::write_all(&mut stream, &request).unwrap();
    service.wait_for(1, 0);
    drop(stream);
    service.wait_for(0, 0);
}
