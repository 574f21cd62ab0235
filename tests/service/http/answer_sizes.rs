//! Answers stay small whatever is sent: names are limited, texts are quoted in part, problems are counted.

use crate::common::service::Service;
use serde_json::{Value, json};

/// Bytes of a problem document, however much is wrong.
const PROBLEM_BYTES: usize = 128 << 10;

fn scene(materials: Value, objects: Vec<Value>) -> String {
    json!({
        "version": 1, "image": { "width": 8, "height": 8 },
        "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
        "materials": materials, "objects": objects,
    })
    .to_string()
}

fn ball(material: &str) -> Value {
    json!({ "sphere": { "center": [0, 0, 0], "radius": 1, "material": material } })
}

#[test]
fn long_names_are_refused_and_not_repeated() {
    let service = Service::start(&[]);
    let long = |i: usize| format!("{i}{}", "x".repeat(100_000));
    let names = json!((0..20).map(|i| (long(i), json!({ "diffus": 1 }))).collect::<serde_json::Map<_, _>>());
    for body in [scene(json!({}), (0..20).map(|i| ball(&long(i))).collect()), scene(names, vec![ball("")])] {
        for path in ["/v1/render", "/v1/explain", "/v1/scenes/validate", "/v1/tree?x=0&y=0"] {
            let answer = service.post_json(path, &body);
            let problem = answer.problem(422, "invalid-scene");
            assert!(answer.body.len() < PROBLEM_BYTES, "{} bytes", answer.body.len());
            assert!(problem["errors"][0]["detail"].as_str().unwrap().contains("name_bytes"), "{problem}");
        }
    }
    // Keys that no schema knows, in a text too large to be searched for all its mistakes.
    let filler = vec![json!({ "sphere": { "center": [0, 0, 0], "radius": 1 } }); 200_000];
    let unknown = scene(json!({}), filler).replacen("\"version\"", &format!("\"{}\":1,\"version\"", long(0)), 1);
    let answer = service.post_json("/v1/render", &unknown);
    assert_eq!(answer.status, 422);
    assert!(answer.body.len() < 4_096, "{}", answer.text());
    let rays = format!("{{\"scene\": {{}}, \"rays\": [{{\"{}\": 1}}]}}", long(0));
    assert!(service.post_json("/v1/rays", &rays).body.len() < 8_192);
}

#[test]
fn of_many_problems_the_first_are_reported_and_the_others_counted() {
    let service = Service::start(&[]);
    let wrong = vec![json!({ "sphere": { "center": [0, 0, 0], "radius": -1 } }); 80];
    let problem = service.post_json("/v1/render", &scene(json!({}), wrong)).problem(422, "invalid-scene");
    assert_eq!((problem["errors"].as_array().map(Vec::len), &problem["more"]), (Some(50), &json!(30)));
    // Long pointers leave room for fewer.
    let keys: serde_json::Map<_, _> =
        (0..60).map(|i| (format!("{:0<256}", i).replace('0', "/"), json!({ "ior": -1 }))).collect();
    let answer = service.post_json("/v1/render", &scene(json!(keys), vec![ball("")]));
    assert!(answer.body.len() < PROBLEM_BYTES, "{} bytes", answer.body.len());
    let query: String = (0..5_000).map(|i| format!("&k{i}")).collect();
    let answer = service.post_json(&format!("/v1/render?a=1{query}"), &scene(json!({}), vec![ball("")]));
    assert!(answer.problem(400, "invalid-parameter")["more"].as_u64() >= Some(4_900));
}

/// Each of these names would be compared with each other one.
#[test]
fn suggestions_among_many_names_take_no_time() {
    let service = Service::start(&[]);
    let name = |i: usize| format!("{:x}", i * 2_654_435_761).repeat(8)[..64].to_owned();
    let known: serde_json::Map<_, _> = (1..=100_000).map(|i| (name(i), json!({}))).collect();
    let unknown = (1..=60).map(|i| ball(&format!("z{}", &name(i)[1..]))).collect();
    let problem = service.post_json("/v1/render", &scene(json!(known), unknown)).problem(422, "invalid-scene");
    assert_eq!(problem["errors"].as_array().map(Vec::len), Some(50));
}

#[test]
fn textures_are_read_until_ten_are_broken() {
    let service = Service::start(&[]);
    let broken =
        |i: usize| format!("data:image/png;base64,{}", data_encoding::BASE64.encode(format!("{i}").as_bytes()));
    let image = |i: usize| json!({ "diffuse": { "image": { "source": broken(i), "mapping": { "planar": {} } } } });
    let materials: serde_json::Map<_, _> = (0..800).map(|i| (i.to_string(), image(i))).collect();
    let problem =
        service.post_json("/v1/render", &scene(json!(materials), vec![ball("0")])).problem(422, "invalid-scene");
    assert_eq!(problem["errors"].as_array().map(Vec::len), Some(10), "{problem}");
}
