//! Frames over nodes: whoever renders their tiles, and whichever front goes on with them, they are the same.

use crate::backends::MIRRORS;
use crate::common::BALL;
use crate::common::service::Service;
use crate::harness::{Broker, Ear, LEASE, Node, wait_until};
use serde_json::{Value, json};
use std::collections::BTreeSet;

const FRAMES: u32 = 12;

/// A camera between mirrors, and a ball that changes.
fn order() -> String {
    let patches: Vec<Value> =
        (0..FRAMES).map(|n| json!({ "materials": { "red": { "reflection": 0.05 * f64::from(n) } } })).collect();
    let camera = json!([{ "t": 0, "vfov_deg": 50 }, { "t": 1, "vfov_deg": 40 }]);
    let scene: Value = serde_json::from_str(MIRRORS).unwrap();
    let settings = json!({ "width": 200, "height": 150, "samples": 2 });
    json!({ "scene": scene, "settings": settings, "frames": { "patches": patches, "camera": camera } }).to_string()
}

fn submit(front: &Service) -> String {
    let answer = front.post_json("/v1/jobs", &order());
    assert_eq!(answer.status, 202, "{}", answer.text());
    answer.json()["id"].as_str().unwrap().to_owned()
}

fn job(front: &Service, id: &str) -> Value {
    front.get(&format!("/v1/jobs/{id}")).json()
}

fn frames(front: &Service, id: &str) -> Vec<Vec<u8>> {
    wait_until(&format!("{id} succeeds: {}", job(front, id)), || job(front, id)["state"] == "succeeded");
    let frame = |number| {
        let answer = front.get(&format!("/v1/jobs/{id}/frames/{number}"));
        assert_eq!(answer.status, 200, "{number}: {}", answer.text());
        answer.body
    };
    (0..FRAMES).map(frame).collect()
}

fn front(broker: &Broker, store: &str) -> Service {
    Service::start(&["--farm", &broker.url(), "--store", store, "--farm-lease", LEASE, "--threads", "1"])
}

#[test]
fn frames_over_nodes_are_those_of_one_machine_even_if_the_front_is_killed() {
    let Some(broker) = Broker::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().to_str().unwrap();
    let alone = Service::start(&["--threads", "2"]);
    let expected = frames(&alone, &submit(&alone));
    let fronts = [front(&broker, store), front(&broker, store)];
    let nodes = ["one", "two"].map(|name| Node::start(&broker.url(), store, name, &[]));
    let id = submit(&fronts[0]);
    assert!(frames(&fronts[0], &id) == expected, "other pictures\n{}", nodes[0].log());
    assert!(frames(&fronts[1], &id) == expected, "other pictures at another front");
    let animation = |service: &Service, id: &str| service.get(&format!("/v1/jobs/{id}/animation")).body;
    let of_one_machine = animation(&alone, &submit_again(&alone));
    assert!(animation(&fronts[1], &id) == of_one_machine);

    let second = submit(&fronts[0]);
    wait_until("two frames are finished", || job(&fronts[1], &second)["frames"]["done"].as_u64() >= Some(2));
    let begun = format!("this front begins job=\"{second}\"");
    let owner = fronts.iter().position(|front| front.log().contains(&begun)).expect("a front works on it");
    let mut fronts = Vec::from(fronts);
    drop(fronts.remove(owner));
    assert!(frames(&fronts[0], &second) == expected, "other pictures after a kill\n{}", fronts[0].log());
    let after = job(&fronts[0], &second);
    assert!(after["stats"]["tiles_recovered"].as_u64() > Some(0), "{after}\n{}", fronts[0].log());
    assert_eq!(broker.messages("FARM_T"), 0, "work is left behind");
}

/// Small frames have fewer tiles than a farm has slots.
#[test]
fn several_frames_are_rendered_at_a_time() {
    let Some(broker) = Broker::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().to_str().unwrap();
    let front = front(&broker, store);
    let nodes = ["one", "two", "three"].map(|name| Node::start(&broker.url(), store, name, &["--slots", "2"]));
    wait_until("the front knows its nodes", || front.get("/v1/farm").json()["farm"]["slots"].as_u64() == Some(6));
    let work = Ear::at(&broker, "farm.t.>");
    nodes.iter().for_each(|node| node.signal("-STOP"));
    let order = json!({ "scene": serde_json::from_str::<Value>(BALL).unwrap(), "frames": { "count": FRAMES, "turntable": {} } });
    let answer = front.post_json("/v1/jobs", &order.to_string());
    assert_eq!(answer.status, 202, "{}", answer.text());
    // Nothing is finished: what is published now is rendered at the same time.
    work.wait_for(6);
    let names: BTreeSet<String> = work.heard().iter().map(|message| message.subject.to_string()).collect();
    assert!(names.len() >= 6, "{names:?}");
    nodes.iter().for_each(|node| node.signal("-CONT"));
    let id = answer.json()["id"].as_str().unwrap().to_owned();
    let pictures = frames(&front, &id);
    let alone = Service::start(&["--threads", "2"]);
    let same = alone.post_json("/v1/jobs", &order.to_string()).json()["id"].as_str().unwrap().to_owned();
    assert!(pictures == frames(&alone, &same), "other pictures\n{}", nodes[0].log());
    assert_eq!(broker.messages("FARM_T"), 0, "work is left behind");
}

/// The same once more on one machine, finished.
fn submit_again(alone: &Service) -> String {
    let id = submit(alone);
    frames(alone, &id);
    id
}
