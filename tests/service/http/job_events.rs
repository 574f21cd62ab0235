//! Jobs watched: events, previews, several jobs in one stream.

use super::jobs::{ENDLESS, LONG, mirrors, submit, succeeded, text};
use crate::common::service::{Service, request};
use crate::common::{BALL, SLOW};
use image::GenericImageView;
use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;

/// A job's events over a socket of their own.
pub(crate) struct Events {
    lines: BufReader<TcpStream>,
    headers: Vec<String>,
}

impl Events {
    pub(crate) fn of(service: &Service, id: &str, headers: &[(&str, &str)]) -> Self {
        Self::at(service, &format!("/v1/jobs/{id}/events"), headers)
    }

    pub(crate) fn at(service: &Service, path: &str, headers: &[(&str, &str)]) -> Self {
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

    pub(crate) fn header(&self, name: &str) -> &str {
        let find = |line: &'_ String| line.strip_prefix(name).is_some_and(|rest| rest.starts_with(": "));
        self.headers.iter().find(|line| find(line)).map_or("", |line| &line[name.len() + 2..])
    }

    /// Name, number and data of the next event; none at the end.
    pub(crate) fn next(&mut self) -> Option<(String, u64, Value)> {
        let (name, id, data) = self.next_of_several()?;
        let seq = if id.is_empty() { 0 } else { id.parse().unwrap() };
        Some((name, seq, data))
    }

    /// Likewise, with the numbers of the last events of all jobs.
    pub(crate) fn next_of_several(&mut self) -> Option<(String, String, Value)> {
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

    pub(crate) fn all_names(mut self) -> Vec<String> {
        std::iter::from_fn(|| self.next_of_several()).map(|(name, ..)| name).collect()
    }

    pub(crate) fn all(mut self) -> Vec<(String, u64, Value)> {
        std::iter::from_fn(|| self.next()).collect()
    }
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
    // Also where a proxy has weakened the tag, and has others.
    let tags = format!("\"other\", W/{}", last.header("etag"));
    let same = service.send("GET", &format!("/v1/jobs/{id}/preview"), &[("If-None-Match", &tags)], b"");
    assert_eq!((same.status, same.body.len()), (304, 0));
}

/// An `<img>` of a page that has just submitted the job shows a coarse picture of it all.
#[test]
fn a_preview_of_a_new_job_is_its_first_coarse_picture() {
    let service = Service::start(&[]);
    let busy = submit(&service, &mirrors(), r#""settings": { "width": 384, "height": 384, "samples": 1 }"#);
    let id = submit(&service, &mirrors(), LONG);
    let path = format!("/v1/jobs/{id}/preview");
    let at_once = service.get(&format!("{path}?wait=0"));
    assert!(at_once.status == 409 || at_once.status == 200, "{}", at_once.status);
    let first = service.get(&path);
    assert_eq!((first.status, first.header("content-type")), (200, "image/png"));
    let state = service.get(&format!("/v1/jobs/{id}")).json();
    assert!(state["state"] == "running", "it does not wait for the end: {state}");
    let picture = first.picture().to_rgb8();
    let colors: std::collections::HashSet<[u8; 3]> = picture.pixels().map(|pixel| pixel.0).collect();
    let black = picture.pixels().filter(|pixel| pixel.0 == [0; 3]).count();
    assert!(colors.len() > 100 && black < 384 * 384 / 2, "{} colors, {black} black", colors.len());
    for job in [busy, id] {
        service.send("POST", &format!("/v1/jobs/{job}/cancel"), &[], b"");
    }
}

/// Coarse pictures and the first tiles, in the centre, say little about the rest.
#[test]
fn the_first_eta_of_a_job_is_its_estimate() {
    let service = Service::start(&[]);
    let id = submit(&service, &mirrors(), LONG);
    let mut events = Events::of(&service, &id, &[]);
    let job = service.get(&format!("/v1/jobs/{id}")).json();
    let estimate = job["estimate_ms"].as_f64().unwrap();
    assert!(job["eta_ms"].as_f64().is_some_and(|eta| eta <= 2.0 * estimate), "{job}");
    let (.., first) = std::iter::from_fn(|| events.next()).find(|(name, ..)| name == "progress").unwrap();
    let eta = first["eta_ms"].as_f64().unwrap();
    assert!(eta <= 4.0 * estimate, "{eta} ms left of {estimate}: {first}");
    service.send("POST", &format!("/v1/jobs/{id}/cancel"), &[], b"");
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
    let twice = Events::at(&service, &format!("{path}&job={}&job={}", ids[2], ids[0]), &[]).all_names();
    assert_eq!(twice, all, "a job that is named twice counts once");
    service.get("/v1/events?job=a&label=b").problem(400, "invalid-parameter");
    service.get(&format!("/v1/events?{}", "job=a&".repeat(33))).problem(400, "invalid-parameter");
    service.get(&format!("{path}&job=a")).problem(404, "not-found");
}
