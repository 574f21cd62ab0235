//! Answers against the schemas that the contract promises, to the last key.

use super::access::{KeyFile, keyed};
use super::jobs::{submit, succeeded};
use crate::common::BALL;
use crate::common::service::Service;
use serde_json::{Value, json};

/// The contract, stricter than it is: keys that it does not name are not allowed either.
struct Contract(Value);

impl Contract {
    fn of(service: &Service) -> Self {
        let mut document = service.get("/openapi.json").json();
        close(&mut document["components"]["schemas"]);
        Self(document)
    }

    /// Checks an answer of an operation against its schema.
    fn check(&self, operation: &str, status: &str, media_type: &str, answer: &Value) {
        let paths = self.0["paths"].as_object().unwrap();
        let operations = paths.values().flat_map(|item| item.as_object().unwrap().values());
        let described = operations.into_iter().find(|described| described["operationId"] == operation).unwrap();
        let promised = &described["responses"][status]["content"][media_type]["schema"];
        assert!(promised["$ref"].is_string(), "{operation} {status} promises {promised}");
        let mut schema = promised.clone();
        schema["components"] = self.0["components"].clone();
        let validator = jsonschema::validator_for(&schema).unwrap();
        let errors: Vec<String> =
            validator.iter_errors(answer).map(|error| format!("{}: {error}", error.instance_path())).collect();
        assert!(errors.is_empty(), "{operation}: {errors:#?}\n{answer:#}");
    }
}

/// Objects have no keys but those that are described.
fn close(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            object.values_mut().for_each(close);
            let is_open = object.get("properties").is_some_and(Value::is_object) && object["type"] == "object";
            if is_open {
                object.entry("additionalProperties").or_insert(false.into());
            }
        }
        Value::Array(all) => all.iter_mut().for_each(close),
        _ => {}
    }
}

/// Mirrors, glass in glass, a group, a name: a bit of everything that answers speak of.
const RICH: &str = r#"{
  "version": 1, "name": "rich",
  "image": { "width": 60, "height": 40 },
  "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0.5, 0] } },
  "lights": [{ "point": { "position": [3, 5, 4] } }],
  "materials": {
    "glass": { "diffuse": 0, "reflection": 0.1, "transmission": 0.9, "ior": 1.5 },
    "bright": { "reflection": 0.8, "transmission": 0.7 }
  },
  "objects": [
    { "group": { "objects": [{ "sphere": { "center": [0, 1, 0], "radius": 1, "material": "glass", "name": "ball" } }] } },
    { "sphere": { "center": [2, 1, 0], "radius": 0.5, "material": "bright" } },
    { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0] } }
  ]
}"#;

#[test]
fn every_answer_about_a_scene_is_what_the_contract_promises() {
    let service = Service::start(&[]);
    let contract = Contract::of(&service);
    let ask = |path: &str, body: &str| service.post_json(path, body).json();
    let check = |operation: &str, answer: &Value| contract.check(operation, "200", "application/json", answer);
    check("explain", &ask("/v1/explain", RICH));
    check("explain", &ask("/v1/explain?analyze=1", RICH));
    for query in ["x=30&y=14", "x=30&y=30", "x=0&y=0", "x=30&y=14&max_depth=2&antialias=false"] {
        check("tree", &ask(&format!("/v1/tree?{query}"), RICH));
    }
    check("tradeoff", &ask("/v1/tradeoff?seconds=2&width=24&height=16", RICH));
    check("validateScene", &ask("/v1/scenes/validate", RICH));
    let rays = r#"[{"origin": [0, 1, 5], "direction": [0, 0, -1]}, {"origin": [0, 9, 0], "direction": [0, 1, 0]}]"#;
    check("rays", &ask("/v1/rays", &format!(r#"{{"scene": {RICH}, "rays": {rays}}}"#)));
    let known = ask("/v1/scenes", RICH);
    contract.check("addScene", "201", "application/json", &known);
    for (operation, link) in [("iiifInfo", "iiif"), ("xyz", "xyz")] {
        check(operation, &service.get(known["links"][link].as_str().unwrap()).json());
    }
    for (operation, path) in
        [("limits", "/v1/limits"), ("version", "/v1/version"), ("formats", "/v1/formats"), ("readyz", "/readyz")]
    {
        check(operation, &service.get(path).json());
    }
    // A validator that takes anything would take this, too.
    let mut changed = ask("/v1/explain", RICH);
    changed["efects"] = json!([]);
    let taken = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| check("explain", &changed)));
    assert!(taken.is_err(), "an unknown key is noticed");
}

#[test]
fn jobs_are_what_the_contract_promises_in_every_state() {
    let service = Service::start(&[]);
    let contract = Contract::of(&service);
    let check = |operation: &str, answer: &Value| contract.check(operation, "200", "application/json", answer);
    let at = |id: &str| service.get(&format!("/v1/jobs/{id}")).json();
    let settings =
        r#""settings": { "width": 90, "accuracy": "proved:0" }, "output": { "format": "jpg", "quality": 80 }"#;
    let id = submit(&service, RICH, settings);
    check("job", &at(&id));
    check("job", &succeeded(&service, &id));
    // It ends by a clock, so it has no name and says how far it came.
    let timed = submit(&service, BALL, r#""settings": { "accuracy": "time:5" }"#);
    check("job", &succeeded(&service, &timed));
    let slow = submit(&service, crate::common::SLOW, r#""settings": { "width": 512, "height": 512 }"#);
    let canceled = service.send("POST", &format!("/v1/jobs/{slow}/cancel"), &[], b"");
    contract.check("cancelJob", "202", "application/json", &canceled.json());
    check("jobs", &service.get("/v1/jobs?limit=2").json());
}

#[test]
fn a_job_that_fails_says_why_as_the_contract_promises() {
    let textures = tempfile::tempdir().unwrap();
    let wall = textures.path().join("wall.png");
    image::RgbImage::from_pixel(2, 2, image::Rgb([9, 99, 199])).save(&wall).unwrap();
    let service = Service::start(&["--textures", textures.path().to_str().unwrap()]);
    let contract = Contract::of(&service);
    // Two of a tenant's jobs are open at one time, so the third is built when its picture has gone.
    let others = [256, 257]
        .map(|width| submit(&service, crate::common::SLOW, &format!(r#""settings": {{ "width": {width} }}"#)));
    let id = submit(&service, super::scene_cache::WALL, "");
    std::fs::remove_file(wall).unwrap();
    for other in others {
        service.send("DELETE", &format!("/v1/jobs/{other}"), &[], b"");
    }
    let failed = service.send("GET", &format!("/v1/jobs/{id}"), &[("Prefer", "wait=20")], b"").json();
    assert_eq!((&failed["state"], &failed["problem"]["type"]), (&"failed".into(), &"/problems/invalid-scene".into()));
    contract.check("job", "200", "application/json", &failed);
    let listed = service.get("/v1/jobs?state=failed").json();
    contract.check("jobs", "200", "application/json", &listed);
}

#[test]
fn problems_and_capabilities_are_what_the_contract_promises() {
    let file = KeyFile::new("schemas", "");
    let key = file.key("acme", "read,render");
    let service = file.serve(&[]);
    let contract = Contract::of(&service);
    let minted = keyed(&service, &key, "POST", "/v1/capabilities", r#"{"job_id": "a"}"#).json();
    contract.check("mintCapability", "201", "application/json", &minted);
    let problem = |answer: &Value| {
        let schema = json!({ "$ref": "#/components/schemas/ProblemDocument", "components": contract.0["components"] });
        let validator = jsonschema::validator_for(&schema).unwrap();
        let errors: Vec<String> = validator.iter_errors(answer).map(|error| error.to_string()).collect();
        assert!(errors.is_empty(), "{errors:#?} {answer:#}");
    };
    for (path, body) in [
        ("/v1/render", r#"{"version": 2, "lights": 3}"#),
        ("/v1/render?width=0&widht=1", BALL),
        ("/v1/render?width=16384&height=16384", BALL),
        ("/v1/jobs", "{}"),
        ("/v1/rays", r#"{"scene": {}, "rays": [{"origin": 1}]}"#),
    ] {
        problem(&keyed(&service, &key, "POST", path, body).json());
    }
    let headers = [("Content-Type", "application/json"), ("Accept", "image/tiff"), ("Authorization", key.as_str())];
    let unacceptable = service.send("POST", "/v1/render", &headers, BALL.as_bytes());
    assert_eq!(unacceptable.status, 406);
    problem(&unacceptable.json());
}
