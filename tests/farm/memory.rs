//! Fronts and nodes with little memory leave what is too large for them to others.

use crate::common::service::{Answer, Service};
use crate::harness::{Broker, LEASE, Node, job, wait_until};
use serde_json::Value;

/// Enough for the program and small scenes.
const LITTLE: [&str; 2] = ["--memory-bytes", "134217728"];

/// A scene that takes more than that while it is built.
fn large(seed: usize) -> String {
    let ball = |i: usize| format!(r#"{{"sphere":{{"center":[{i},{seed},0],"radius":1}}}}"#);
    let objects = (0..120_000).map(ball).collect::<Vec<_>>().join(",");
    let image = r#""image":{"width":64,"height":64}"#;
    format!(
        r#"{{"version":1,{image},"camera":{{"pinhole":{{"eye":[0,0,5],"look_at":[0,0,0]}}}},"objects":[{objects}]}}"#
    )
}

fn ended(front: &Service, submitted: &Answer) -> Value {
    assert_eq!(submitted.status, 202, "{}", submitted.text());
    let path = format!("/v1/jobs/{}", submitted.json()["id"].as_str().unwrap());
    let mut job = Value::Null;
    wait_until("a job ends", || {
        job = front.get(&path).json();
        !["queued", "running"].contains(&job["state"].as_str().unwrap())
    });
    job
}

#[test]
fn what_is_too_large_for_one_is_done_by_another() {
    let Some(broker) = Broker::start() else { return };
    let store = tempfile::tempdir().unwrap();
    let (url, folder) = (broker.url(), store.path().to_str().unwrap().to_owned());
    let farm = ["--farm", &url, "--store", &folder, "--farm-lease", LEASE, "--threads", "1"];
    let (large_front, small_front) = (Service::start(&farm), Service::start(&[&farm[..], &LITTLE].concat()));
    let small_node = Node::start(&url, &folder, "small", &[&LITTLE[..], &["--slots", "2"]].concat());

    let others = ["a", "b", "c", "d", "e"].map(|name| Node::start(&url, &folder, name, &LITTLE));

    // No node can do it.
    let refused = ended(&large_front, &large_front.post_json("/v1/jobs", &job("", &large(0))));
    assert_eq!(refused["state"], "failed", "{refused}");
    assert!(refused["problem"]["type"].as_str().unwrap().ends_with("/cost-limit"), "{refused}");
    assert!(refused["problem"]["detail"].as_str().unwrap().contains("more memory than any node has"), "{refused}");

    let large_node = Node::start(&url, &folder, "large", &[]);
    // Which front begins is chance.
    for seed in (1..40).take_while(|seed| *seed < 4 || !small_front.log().contains("leaves it to others")) {
        let done = ended(&large_front, &large_front.post_json("/v1/jobs", &job("", &large(seed))));
        let logs = [large_front.log(), small_front.log(), small_node.log(), large_node.log()];
        assert_eq!(done["state"], "succeeded", "{done}\n{}", logs.join("\n"));
    }
    assert!(small_front.log().contains("leaves it to others"), "{}", small_front.log());
    assert!(others.iter().any(|node| node.log().contains("a job is left to nodes with more memory")));
    assert!(small_node.log().contains("a job is left to nodes with more memory"), "{}", small_node.log());
    assert!(!small_node.log().contains("this node takes no work"), "{}", small_node.log());
}
