//! Whose scenes and jobs are whose, with keys of several tenants.

use super::access::{KeyFile, keyed};
use super::jobs::body;
use crate::common::BALL;
use crate::common::service::Service;

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
