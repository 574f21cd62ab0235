//! Variations of known scenes: a merge patch takes the place of a scene, and nobody can tell the answers apart.

use super::access::{KeyFile, keyed};
use crate::common::BALL;
use crate::common::service::{Answer, Service};
use serde_json::{Value, json};

const VARIATION: &str = "application/vnd.strahl.variation+json";

fn post(service: &Service, path: &str, variation: &Value) -> Answer {
    service.send("POST", path, &[("Content-Type", VARIATION)], variation.to_string().as_bytes())
}

fn stored(service: &Service, scene: &str) -> String {
    service.post_json("/v1/scenes", scene).json()["scene_id"].as_str().expect("an id").to_owned()
}

fn whole(patched: &str) -> String {
    BALL.replace(r#""eye": [0, 1, 5]"#, patched)
}

const MOVED: &str = r#""eye": [2, 1, 5]"#;

fn patch() -> Value {
    json!({ "camera": { "pinhole": { "eye": [2, 1, 5] } } })
}

#[test]
fn a_variation_takes_the_place_of_its_scene_everywhere() {
    let service = Service::start(&[]);
    let base = stored(&service, BALL);
    let (variation, scene) = (json!({ "base": base, "patch": patch() }), whole(MOVED));
    for path in [
        "/v1/render",
        "/v1/render?width=20&format=pfm",
        "/v1/render/tile?x=3&y=4&w=8&h=8",
        "/v1/map?of=rays&format=pfm",
        "/v1/tree?x=20&y=20",
        "/v1/scenes/validate",
        "/v1/scenes",
    ] {
        let (part, all) = (post(&service, path, &variation), service.post_json(path, &scene));
        assert!(part.status < 300 && all.status < 300, "{path}: {}", part.text());
        if path == "/v1/scenes" {
            let known = |answer: &Answer| [answer.json()["scene_id"].clone(), answer.json()["image_id"].clone()];
            assert_eq!(known(&part), known(&all));
        } else {
            assert!(part.body == all.body, "{path}");
        }
        assert_eq!(part.header("etag"), all.header("etag"), "{path}");
    }
    let plan = |answer: Answer| {
        let plan = answer.json();
        let states: Vec<Value> = plan["effects"].as_array().unwrap().iter().map(|row| row["state"].clone()).collect();
        (states, plan["depth"].clone(), plan["overlap"].clone(), plan["warnings"].clone())
    };
    assert_eq!(plan(post(&service, "/v1/explain", &variation)), plan(service.post_json("/v1/explain", &scene)));
    let tradeoff = post(&service, "/v1/tradeoff?seconds=0.5&width=16&height=16", &variation);
    assert_eq!(tradeoff.status, 200, "{}", tradeoff.text());

    // As a part of other bodies.
    let rays = json!([{ "origin": [0, 1, 5], "direction": [0, 0, -1] }]);
    let scene: Value = serde_json::from_str(&scene).unwrap();
    let asked = [&variation, &scene]
        .map(|scene| service.post_json("/v1/rays", &json!({ "scene": scene, "rays": rays }).to_string()).json());
    assert_eq!(asked[0], asked[1]);
    let jobs = [&variation, &scene].map(|scene| {
        let job = json!({ "scene": scene, "settings": { "width": 30 }, "output": { "format": "pfm" } }).to_string();
        let json = [("Content-Type", "application/json"), ("Prefer", "wait=20")];
        let job = service.send("POST", "/v1/jobs", &json, job.as_bytes()).json();
        service.get(&format!("/v1/jobs/{}/image", job["id"].as_str().unwrap())).body
    });
    assert!(jobs[0] == jobs[1] && jobs[0].starts_with(b"PF"));
    let waited = [("Content-Type", VARIATION), ("Prefer", "wait=20")];
    let picture = service.send("POST", "/v1/render", &waited, variation.to_string().as_bytes());
    assert_eq!(picture.status, 200, "{}", picture.text());
    assert!(picture.body == service.post_json("/v1/render", &scene.to_string()).body);
}

#[test]
fn a_variation_is_told_by_its_type_or_its_first_key() {
    let service = Service::start(&[]);
    let base = stored(&service, BALL);
    let text = format!(r#" {{ "patch": {}, "base": "{base}" }}"#, patch());
    let expected = service.post_json("/v1/render", &whole(MOVED)).body;
    for headers in [vec![("Content-Type", VARIATION)], vec![("Content-Type", "application/json")], vec![]] {
        assert!(service.send("POST", "/v1/render", &headers, text.as_bytes()).body == expected);
    }
    let send = |text: &str| service.send("POST", "/v1/render", &[("Content-Type", VARIATION)], text.as_bytes());
    for wrong in [BALL, "{}", r#"{"base": 1, "patch": {}}"#, r#"{"base": "s_a", "patch": {}, "more": 1}"#] {
        send(wrong).problem(422, "invalid-request");
    }
    send(r#"{"base": "s_a", "patch": {"#).problem(400, "invalid-json");
}

#[test]
fn a_second_variation_builds_no_geometry_and_the_same_one_nothing() {
    let service = Service::start(&[]);
    let base = stored(&service, BALL);
    let ask = |x: f64| {
        let variation = json!({ "base": base, "patch": { "camera": { "pinhole": { "eye": [x, 1, 5] } } } });
        post(&service, "/v1/render", &variation)
    };
    let scene = |answer: &Answer| answer.header("server-timing").split(',').next().unwrap_or_default().to_owned();
    let asked = [ask(1.0), ask(2.0), ask(2.0)];
    assert_eq!(asked.each_ref().map(scene), ["scene;desc=miss", "scene;desc=miss", "scene;desc=hit"]);
    assert!(asked[2].body == asked[1].body && asked[1].body == service.post_json("/v1/render", &whole(MOVED)).body);
    // Its image has an id that is known to be of the whole scene.
    let link = asked[1].header("content-location").to_owned();
    assert_eq!(service.post_json("/v1/render", &whole(MOVED)).header("content-location"), link);
}

#[test]
fn problems_point_into_the_scene_that_results() {
    let service = Service::start(&[]);
    let base = stored(&service, BALL);
    let errors = |patch: Value| {
        let problem =
            post(&service, "/v1/render", &json!({ "base": base, "patch": patch })).problem(422, "invalid-scene");
        problem["errors"].clone()
    };
    let found = errors(json!({ "camera": { "pinhole": { "vfov_deg": 500 } }, "materials": { "red": null } }));
    let pointers: Vec<&str> = found.as_array().unwrap().iter().filter_map(|error| error["pointer"].as_str()).collect();
    assert_eq!(pointers, ["#/camera/pinhole/vfov_deg", "#/objects/0/sphere/material"]);
    assert!(found[0].get("line").is_none_or(Value::is_null), "{found}");
    assert_eq!(errors(json!({ "camera": null }))[0]["code"], "missing-key");
    assert_eq!(errors(json!([]))[0]["code"], "wrong-type");
    let deep = format!(r#"{{"base": "{base}", "patch": {}0{}}}"#, "{\"fog\":".repeat(9_999), "}".repeat(9_999));
    let deep = service.send("POST", "/v1/render", &[("Content-Type", VARIATION)], deep.as_bytes());
    assert!(deep.problem(400, "invalid-json")["detail"].as_str().unwrap().contains("recursion"), "{}", deep.text());
    let long = json!({ "base": base, "patch": { "name": "a".repeat(5 << 20) } });
    assert_eq!(post(&service, "/v1/render", &long).problem(413, "cost-limit")["limit"]["name"], "patch_bytes");
    let inside = json!({ "scene": { "base": base, "patch": { "fog": 1 } }, "rays": [] }).to_string();
    let problem = service.post_json("/v1/rays", &inside).problem(422, "invalid-scene");
    assert_eq!(problem["errors"][0]["pointer"], "#/scene/fog");
    // Limits are those of the whole.
    let large = json!({ "base": base, "patch": { "image": { "width": 16000, "height": 4000 } } });
    post(&service, "/v1/render", &large).problem(413, "cost-limit");
}

#[test]
fn only_scenes_of_the_tenant_can_be_varied() {
    let file = KeyFile::new("variations", "");
    let scopes = "render,read,jobs";
    let (one, two) = (file.key("one", scopes), file.key("two", scopes));
    let service = file.serve(&[]);
    let send = |tenant: &str, path: &str, body: &str| {
        keyed(&service, if tenant == "one" { &one } else { &two }, "POST", path, body)
    };
    let base = send("one", "/v1/scenes", BALL).json()["scene_id"].as_str().unwrap().to_owned();
    let variation = json!({ "base": base, "patch": patch() }).to_string();
    assert_eq!(send("one", "/v1/render", &variation).status, 200);
    let rays = format!(r#"{{"scene": {variation}, "rays": []}}"#);
    let job = format!(r#"{{"scene": {variation}}}"#);
    for (path, body) in
        [("/v1/render", &variation), ("/v1/scenes", &variation), ("/v1/rays", &rays), ("/v1/jobs", &job)]
    {
        send("two", path, body).problem(404, "not-found");
    }
    let unknown = json!({ "base": format!("s_{}", "a".repeat(32)), "patch": {} }).to_string();
    for base in [&unknown, r#"{"base": "../../etc/passwd", "patch": {}}"#, r#"{"base": "", "patch": {}}"#] {
        send("one", "/v1/render", base).problem(404, "not-found");
    }
    // Who has sent it may vary it; who has deleted it may not.
    assert_eq!(send("two", "/v1/scenes", BALL).json()["scene_id"], base.as_str());
    assert_eq!(send("two", "/v1/render", &variation).status, 200);
    let deleted = keyed(&service, &one, "DELETE", &format!("/v1/scenes/{base}"), "");
    assert_eq!(deleted.status, 204);
    send("one", "/v1/render", &variation).problem(404, "not-found");
    assert_eq!(send("two", "/v1/render", &variation).status, 200);
}
