//! What a tenant learns of itself: its limits, the queue, its texts, and all its jobs in one stream.

use super::access::{KeyFile, keyed};
use super::job_events::Events;
use super::jobs::{body, submit, text};
use crate::common::service::Service;
use crate::common::{BALL, SLOW};
use std::collections::HashSet;

#[test]
fn a_key_says_whose_it_is_and_what_is_left() {
    let file = KeyFile::new("me", "");
    let key = file.key("acme", "render,read");
    let service = file.serve(&[]);
    let me = keyed(&service, &key, "GET", "/v1/me", "").json();
    assert_eq!((&me["tenant"], &me["needs_keys"]), (&"acme".into(), &true.into()));
    assert_eq!(me["scopes"], serde_json::json!(["render", "read"]));
    assert!(me["most_jobs"].is_u64() && me["units"].is_null(), "{me}");
    for path in ["/v1/me", "/v1/queue"] {
        service.get(path).problem(401, "unauthorized");
    }
    let open = Service::start(&[]).get("/v1/me").json();
    assert_eq!((&open["tenant"], &open["needs_keys"]), (&"anonymous".into(), &false.into()));
}

#[test]
fn the_queue_says_who_waits() {
    let service = Service::start(&["--threads", "2"]);
    let idle = service.get("/v1/queue").json();
    assert_eq!(
        (&idle["threads"], &idle["renders"]["running"], &idle["seconds_ahead"]),
        (&2.into(), &0.into(), &0.into())
    );
    let client = service.begin("/v1/render", SLOW);
    service.wait_for(1, 0);
    let busy = service.get("/v1/queue").json();
    assert_eq!((&busy["renders"]["running"], &busy["tiles"]["waiting"]), (&1.into(), &0.into()));
    assert!(busy["seconds_ahead"].as_u64().unwrap() >= 1);
    drop(client);
}

#[test]
fn an_author_gets_the_own_text_back() {
    let file = KeyFile::new("sources", "");
    let (one, two) = (file.key("one", "render,read"), file.key("two", "render,read"));
    let service = file.serve(&[]);
    let spaced = BALL.replace(", ", " ,\t");
    let place = keyed(&service, &one, "POST", "/v1/scenes", BALL).header("location").to_owned();
    assert_eq!(keyed(&service, &two, "POST", "/v1/scenes", &spaced).header("location"), place);
    let source = |key: &str| keyed(&service, key, "GET", &format!("{place}/source"), "");
    assert_eq!((source(&one).text().as_str(), source(&two).text().as_str()), (BALL, spaced.as_str()));
    assert_eq!(source(&one).header("content-type"), "application/json");
    // The last text that was posted counts.
    keyed(&service, &one, "POST", "/v1/scenes", &spaced);
    assert_eq!(source(&one).text(), spaced);
    assert_ne!(keyed(&service, &one, "GET", &place, "").text(), spaced, "the canonical text is another one");
    let three = file.key("three", "read");
    service.wait_for_log("the keys were read again");
    source(&three).problem(404, "not-found");
    assert_eq!(keyed(&service, &one, "DELETE", &place, "").status, 204);
    source(&one).problem(404, "not-found");
    // A link for somebody without a key.
    let id = place.rsplit('/').next().unwrap();
    let wanted = format!(r#"{{"scene_id": "{id}"}}"#);
    let minted = keyed(&service, &two, "POST", "/v1/capabilities", &wanted).json();
    let link = format!("{}{place}/source", minted["prefix"].as_str().unwrap());
    assert_eq!(service.get(&link).text(), spaced);
}

/// Files of one shape are one picture, but what is said of a file is said to who has sent it.
#[test]
fn warnings_are_of_the_own_file() {
    let file = KeyFile::new("warnings", "");
    let (one, two) = (file.key("one", "render,read"), file.key("two", "render,read"));
    let service = file.serve(&[]);
    let model = |library: &str| format!("{library}v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let render = |key: &str, path: &str, library: &str| {
        let headers = [("Content-Type", "model/obj"), ("Authorization", key)];
        service.send("POST", path, &headers, model(library).as_bytes())
    };
    let path = "/v1/render?width=16&height=16";
    let first = render(&one, path, "mtllib secret.mtl\n");
    assert!(first.header("render-warnings").contains("secret.mtl"), "{}", first.header("render-warnings"));
    let (second, third) = (render(&two, path, "mtllib other.mtl\n"), render(&two, path, ""));
    let said = second.header("render-warnings");
    assert!(said.contains("other.mtl") && !said.contains("secret"), "{said}");
    assert!(!third.header("render-warnings").contains(".mtl"), "{}", third.header("render-warnings"));
    assert!(first.body == second.body && second.body == third.body);
    // The same of another view, and of the scene that is kept.
    let seen = render(&two, &format!("{path}&view=left"), "mtllib other.mtl\n");
    assert!(seen.header("render-warnings").contains("other.mtl"));
    let kept = |key: &str, library: &str| {
        let headers = [("Content-Type", "model/obj"), ("Authorization", key)];
        let posted = service.send("POST", "/v1/scenes", &headers, model(library).as_bytes());
        let id = posted.json()["image_id"].as_str().unwrap().to_owned();
        let image = keyed(&service, key, "GET", &format!("/v1/images/{id}.png"), "");
        let text = keyed(&service, key, "GET", posted.header("location"), "").json();
        (text["import_warnings"].to_string(), image.header("render-warnings").to_owned())
    };
    let (text, warnings) = kept(&one, "mtllib secret.mtl\n");
    assert!(text.contains("secret.mtl") && warnings.contains("secret.mtl"), "{text}: {warnings}");
    let (text, warnings) = kept(&two, "mtllib other.mtl\n");
    assert!(!text.contains("secret") && warnings.contains("other.mtl"), "{text}: {warnings}");
}

#[test]
fn one_stream_tells_of_all_jobs_that_come_and_go() {
    let service = Service::start(&[]);
    let first = submit(&service, SLOW, "");
    let mut events = Events::at(&service, "/v1/events", &[]);
    let (name, _, data) = events.next_of_several().unwrap();
    assert_eq!((name.as_str(), &data["job"]), ("snapshot", &first.as_str().into()));
    let second = submit(&service, BALL, r#""labels": ["mine"]"#);
    let mut of_second = Vec::new();
    let removed = loop {
        let (name, _, data) = events.next_of_several().unwrap();
        if data["job"] == second.as_str() {
            of_second.push(name.clone());
            if name == "succeeded" {
                let path = format!("/v1/jobs/{second}");
                assert_eq!(service.send("DELETE", &path, &[], b"").status, 204);
            }
        }
        if name == "removed" {
            break data;
        }
    };
    assert_eq!(removed["job"], second.as_str());
    assert_eq!((of_second[0].as_str(), of_second[1].as_str()), ("created", "snapshot"), "{of_second:?}");
    assert!(of_second.contains(&"succeeded".to_owned()), "{of_second:?}");
    assert_eq!(service.send("POST", &format!("/v1/jobs/{first}/cancel"), &[], b"").status, 202);
    while events.next_of_several().unwrap().0 != "canceled" {}

    // Only those with a label; one that ends at once is told of, too.
    let mut labelled = Events::at(&service, "/v1/events?label=mine", &[]);
    submit(&service, BALL, "");
    let third = submit(&service, BALL, r#""labels": ["mine"]"#);
    let (name, _, data) = labelled.next_of_several().unwrap();
    assert_eq!((name.as_str(), &data["job"]), ("created", &third.as_str().into()));
}

#[test]
fn a_stream_of_all_tells_how_a_job_ended_before_it_tells_that_it_is_gone() {
    let service = Service::start(&[]);
    let mut events = Events::at(&service, "/v1/events", &[]);
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                for _ in 0..40 {
                    // The more tiles, the longer a job's files take to go before its end is told.
                    let id = submit(&service, BALL, r#""settings": { "width": 200, "height": 200 }"#);
                    let path = format!("/v1/jobs/{id}");
                    service.send("GET", &path, &[("Prefer", "wait=60")], b"");
                    assert_eq!(service.send("DELETE", &path, &[], b"").status, 204);
                }
            });
        }
    });
    let last = submit(&service, BALL, "");
    let (mut succeeded, mut removed) = (HashSet::new(), 0);
    loop {
        let (name, _, data) = events.next_of_several().unwrap();
        let job = text(&data["job"]).to_owned();
        match name.as_str() {
            "created" if job == last => break,
            "succeeded" => drop(succeeded.insert(job)),
            "removed" => {
                assert!(succeeded.contains(&job), "{job} is gone, and it was not told how it ended");
                removed += 1;
            }
            _ => {}
        }
    }
    assert!(removed > 0);
}

#[test]
fn a_stream_of_all_is_of_the_own_jobs() {
    let file = KeyFile::new("all_events", "");
    let (one, two) = (file.key("one", "jobs,read"), file.key("two", "jobs,read"));
    let service = file.serve(&[]);
    let mut events = Events::at(&service, "/v1/events", &[("Authorization", &one)]);
    keyed(&service, &two, "POST", "/v1/jobs", &body(BALL, ""));
    let mine = keyed(&service, &one, "POST", "/v1/jobs", &body(BALL, "")).json()["id"].clone();
    let (name, _, data) = events.next_of_several().unwrap();
    assert_eq!((name.as_str(), &data["job"]), ("created", &mine));
}
