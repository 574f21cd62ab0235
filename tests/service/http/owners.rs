//! Whose scenes and jobs are whose, with keys of several tenants.

use super::access::{KeyFile, keyed};
use super::jobs::body;
use crate::common::BALL;
use crate::common::service::{PATIENCE, Service};
use std::thread;
use std::time::{Duration, Instant};

#[test]
fn a_scene_stays_as_long_as_somebody_who_sent_it_wants_it() {
    let file = KeyFile::new("scene_owners", "");
    let folder = tempfile::tempdir().unwrap();
    let scopes = "render,read";
    let (one, two, three) = (file.key("one", scopes), file.key("two", scopes), file.key("three", scopes));
    let admin = file.key("ops", "render,read,admin");
    let flags = ["--keys", file.path(), "--cache", folder.path().to_str().unwrap()];
    let service = Service::start(&flags);
    let add = |service: &Service, key: &str| keyed(service, key, "POST", "/v1/scenes", BALL);
    let first = add(&service, &one);
    let (place, image) = (first.header("location").to_owned(), first.json()["links"]["image"].clone());
    let image = image.as_str().unwrap();
    assert_eq!([first.status, add(&service, &one).status, add(&service, &two).status], [201, 200, 201]);
    keyed(&service, &three, "DELETE", &place, "").problem(404, "not-found");
    assert_eq!(keyed(&service, &one, "DELETE", &place, "").status, 204);
    keyed(&service, &one, "DELETE", &place, "").problem(404, "not-found");

    drop(service);
    let service = Service::start(&flags);
    assert_eq!(keyed(&service, &two, "GET", image, "").status, 200, "it is still wanted, also by another process");
    assert_eq!(keyed(&service, &two, "DELETE", &place, "").status, 204);
    for path in [place.as_str(), image] {
        keyed(&service, &two, "GET", path, "").problem(404, "not-found");
    }
    assert_eq!([add(&service, &one).status, add(&service, &two).status], [201, 201]);
    assert_eq!(keyed(&service, &admin, "DELETE", &place, "").status, 204, "operators remove it for all");
    keyed(&service, &two, "GET", image, "").problem(404, "not-found");
}

/// Whoever is told that a scene is there can have it, whatever others delete meanwhile.
#[test]
fn a_scene_that_is_posted_while_another_tenant_deletes_it_stays() {
    let file = KeyFile::new("posted_and_deleted", "");
    let (one, two) = (file.key("one", "render,read"), file.key("two", "render,read"));
    let service = file.serve(&[]);
    let add = |key: &str| keyed(&service, key, "POST", "/v1/scenes", BALL);
    for _ in 0..40 {
        let place = add(&one).header("location").to_owned();
        let posted = thread::scope(|scope| {
            scope.spawn(|| keyed(&service, &one, "DELETE", &place, ""));
            scope.spawn(|| add(&two)).join().unwrap()
        });
        assert_eq!(posted.status, 201, "{}", posted.text());
        assert_eq!(keyed(&service, &two, "GET", &place, "").status, 200);
        assert_eq!(keyed(&service, &two, "DELETE", &place, "").status, 204);
    }
}

#[test]
fn a_tenants_jobs_are_its_own_and_operators_see_all() {
    let file = KeyFile::new("job_owners", "");
    let (mine, other, admin) =
        (file.key("acme", "jobs,read"), file.key("other", "jobs,read"), file.key("ops", "read,admin"));
    let service = file.serve(&[]);
    let place = keyed(&service, &mine, "POST", "/v1/jobs", &body(BALL, "")).header("location").to_owned();
    for (method, path) in [
        ("GET", place.clone()),
        ("GET", format!("{place}/image")),
        ("GET", format!("{place}/preview")),
        ("GET", format!("{place}/events")),
        ("GET", format!("{place}/tile?x=0&y=0&w=8&h=8")),
        ("POST", format!("{place}/look?x=0&y=0&w=8&h=8")),
        ("POST", format!("{place}/cancel")),
        ("PATCH", place.clone()),
        ("DELETE", place.clone()),
    ] {
        let change = if method == "PATCH" { r#"{"priority": 1}"# } else { "" };
        keyed(&service, &other, method, &path, change).problem(404, "not-found");
    }
    let count = |key: &str| keyed(&service, key, "GET", "/v1/jobs", "").json()["jobs"].as_array().map(Vec::len);
    assert_eq!((count(&mine), count(&other), count(&admin)), (Some(1), Some(0), Some(1)));
    assert_eq!(keyed(&service, &admin, "GET", &place, "").json()["tenant"], "acme");
    keyed(&service, &admin, "DELETE", &place, "").problem(403, "forbidden");
    assert_eq!(keyed(&service, &mine, "DELETE", &place, "").status, 204);
}

#[test]
fn the_text_of_a_scene_is_for_those_who_have_sent_it() {
    let file = KeyFile::new("scene_readers", "");
    let scopes = "render,jobs,read";
    let [acme, bolt, carl] = ["acme", "bolt", "carl"].map(|tenant| file.key(tenant, scopes));
    let admin = file.key("ops", "read,admin");
    let service = file.serve(&[]);
    let known = keyed(&service, &acme, "POST", "/v1/scenes", BALL).json();
    let (id, place) = (known["scene_id"].as_str().unwrap(), known["links"]["self"].as_str().unwrap());
    let image = known["links"]["image"].as_str().unwrap();
    let status = |key: &str| keyed(&service, key, "GET", place, "").status;
    assert_eq!([&acme, &bolt, &carl, &admin].map(|key| status(key)), [200, 404, 404, 200]);
    keyed(&service, &bolt, "GET", place, "").problem(404, "not-found");
    assert_eq!(keyed(&service, &bolt, "GET", image, "").status, 200, "who has the name of a picture may see it");

    let capability = |key: &str| {
        let minted = keyed(&service, key, "POST", "/v1/capabilities", &format!(r#"{{"scene_id": "{id}"}}"#));
        service.get(&format!("{}{place}", minted.json()["prefix"].as_str().unwrap())).status
    };
    assert_eq!([&acme, &bolt].map(|key| capability(key)), [200, 404]);
    let both = format!(r#"{{"scene_id": "{id}", "job_id": "{id}"}}"#);
    keyed(&service, &acme, "POST", "/v1/capabilities", &both).problem(422, "invalid-request");

    assert_eq!(keyed(&service, &bolt, "POST", "/v1/scenes", BALL).status, 201);
    keyed(&service, &carl, "POST", "/v1/jobs", &body(BALL, ""));
    assert_eq!([&acme, &bolt, &carl].map(|key| status(key)), [200, 200, 200]);
}

#[test]
fn timing_tells_nothing_of_other_tenants() {
    let file = KeyFile::new("timing", "");
    let [acme, bolt] = ["acme", "bolt"].map(|tenant| file.key(tenant, "render,read"));
    let service = file.serve(&[]);
    let timing = |key: &str, method: &str, path: &str, scene: &str| {
        let answer = keyed(&service, key, method, path, scene);
        assert_eq!(answer.status, 200, "{}", answer.text());
        answer.header("server-timing").to_owned()
    };
    let is_new = |timing: &str| {
        let phases = ["queue", "parse", "bvh", "trace", "png"].map(|phase| format!("{phase};dur="));
        !timing.contains("hit") && phases.iter().all(|phase| timing.contains(phase))
    };
    let known = keyed(&service, &acme, "POST", "/v1/scenes", BALL).json();
    let image = known["links"]["image"].as_str().unwrap().to_owned();
    let tile = format!("/iiif/3/{}/0,0,8,8/max/0/default.png", known["image_id"].as_str().unwrap());
    let other_size = "/v1/render?width=47";
    for (method, path, scene) in
        [("POST", "/v1/render", BALL), ("GET", &image, ""), ("GET", &tile, ""), ("POST", other_size, BALL)]
    {
        timing(&acme, method, path, scene);
        let own = timing(&acme, method, path, scene);
        assert!(own.contains("picture;desc=hit"), "{path}: {own}");
    }
    for (method, path, scene) in [("POST", "/v1/render", BALL), ("GET", &tile, ""), ("POST", other_size, BALL)] {
        let first = timing(&bolt, method, path, scene);
        assert!(is_new(&first), "{path}: {first}");
        let second = timing(&bolt, method, path, scene);
        assert!(second.contains("scene;desc=hit, picture;desc=hit"), "{path}: {second}");
    }
    // The scene is built, but by others.
    timing(&acme, "POST", "/v1/render?width=46", BALL);
    let half = timing(&bolt, "POST", "/v1/render?width=46&format=webp", BALL);
    assert!(is_new(&half), "{half}");
}

/// A job that has ended, and its path.
fn done(service: &Service, key: &str, more: &str) -> String {
    let headers = [("Content-Type", "application/json"), ("Authorization", key), ("Prefer", "wait=60")];
    let answer = service.send("POST", "/v1/jobs", &headers, body(BALL, more).as_bytes());
    assert_eq!(answer.json()["state"], "succeeded", "{}", answer.text());
    answer.header("location").to_owned()
}

#[test]
fn no_tenant_expires_pictures_of_another_that_keeps_to_its_part() {
    let file = KeyFile::new("disk_shares", "");
    let [acme, bolt] = ["acme", "bolt"].map(|tenant| file.key(tenant, "jobs,read"));
    let service = file.serve(&["--data-bytes", "600000"]);
    let size = |width: u32| format!(r#""settings": {{ "width": {width} }}"#);
    let acmes: Vec<String> = (40..44).map(|width| done(&service, &acme, &size(width))).collect();
    let bolts: Vec<String> = (0..50).map(|number| done(&service, &bolt, &size(44 + number))).collect();
    let state = |key: &str, path: &str| keyed(&service, key, "GET", path, "").json()["state"].clone();
    for path in &acmes {
        assert_eq!(state(&acme, path), "succeeded");
        assert_eq!(keyed(&service, &acme, "GET", &format!("{path}/image"), "").status, 200);
    }
    assert_eq!([state(&bolt, &bolts[0]), state(&bolt, &bolts[49])], ["expired", "succeeded"]);
}

#[test]
fn ended_jobs_of_a_tenant_are_limited() {
    let file = KeyFile::new("keep_jobs", "");
    let [acme, bolt] = ["acme", "bolt"].map(|tenant| file.key(tenant, "jobs,read"));
    let service = file.serve(&["--keep-jobs", "5"]);
    assert_eq!(service.get("/v1/limits").json()["jobs"]["keep_jobs"], 5);
    let acmes = done(&service, &acme, "");
    let bolts: Vec<String> = (0..20).map(|_| done(&service, &bolt, "")).collect();
    let count = |key: &str| keyed(&service, key, "GET", "/v1/jobs", "").json()["jobs"].as_array().map_or(0, Vec::len);
    let started = Instant::now();
    while count(&bolt) > 5 {
        assert!(started.elapsed() < PATIENCE, "{} jobs are kept", count(&bolt));
        thread::sleep(Duration::from_millis(20));
    }
    let status = |path: &str| keyed(&service, &bolt, "GET", path, "").status;
    assert_eq!([status(&bolts[14]), status(&bolts[15]), status(&bolts[19])], [404, 200, 200]);
    assert_eq!(keyed(&service, &bolt, "GET", &format!("{}/image", bolts[19]), "").status, 200);
    assert_eq!(keyed(&service, &acme, "GET", &acmes, "").status, 200);
}
