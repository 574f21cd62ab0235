//! What is not ready in time.

use super::jobs::with;
use crate::common::service::Service;
use crate::common::{BALL, SLOW};
use serde_json::{Value, json};

#[test]
fn a_render_past_its_deadline_is_given_up() {
    // Time for a first tile, after which its rays are counted, also where other tests run.
    let service = Service::start(&["--timeout", "6"]);
    let problem = service.post_json("/v1/render", SLOW).problem(504, "render-deadline");
    // It names what was dear, and the ways out.
    let detail = problem["detail"].as_str().unwrap_or_default();
    for part in ["6 s (timeout)", " rays were traced", " pixels, ", "Prefer: respond-async", "accuracy=time:", "`step`"]
    {
        assert!(detail.contains(part), "{part} in {detail}");
    }
    service.wait_for(0, 0);
    assert_eq!(service.post_json("/v1/render", BALL).status, 200);
}

#[test]
fn a_job_whose_scene_is_not_built_in_time_is_not_taken() {
    let service = Service::start(&["--timeout", "1"]);
    let scene = dear_to_price().to_string();
    let job = format!(r#"{{"scene": {scene}}}"#);
    for (path, prefer, body) in [
        ("/v1/jobs", "wait=0", &job),
        ("/v1/render", "respond-async", &scene),
        ("/v1/render?turntable=4", "wait=0", &scene),
    ] {
        let answer = with(&service, "POST", path, &[("Prefer", prefer)], body);
        // To send a job is no help to one who did.
        let problem = answer.problem(503, "saturated");
        let detail = problem["detail"].as_str().unwrap_or_default();
        assert!(detail.contains("nothing was submitted") && !detail.contains("Prefer"), "{path}: {detail}");
        assert_eq!(answer.header("retry-after"), "30", "{path}");
    }
    assert_eq!(service.get("/v1/jobs").json()["jobs"], json!([]));
    service.wait_for(0, 0);
}

/// A scene of a few lines in which each ray meets 2^31 balls, so that its pilot takes minutes.
fn dear_to_price() -> Value {
    let mut scene: Value = serde_json::from_str(BALL).unwrap();
    let material = scene["materials"].as_object().unwrap().keys().next().unwrap().clone();
    let ball = json!({ "sphere": { "center": [0, 0, 0], "radius": 1, "material": material } });
    let mut definitions = json!({ "level 0": [ball] });
    for level in 1..32 {
        let half = |x: f64| json!({ "instance": { "of": format!("level {}", level - 1), "transform": { "translate": [x, 0, 0] } } });
        let shift = 0.01 * f64::from(level);
        definitions[format!("level {level}")] = json!([half(shift), half(-shift)]);
    }
    scene["definitions"] = definitions;
    scene["objects"] = json!([{ "instance": { "of": "level 31" } }]);
    scene
}
