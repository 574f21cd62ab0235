//! What is delivered after jobs of a farm: by one of the fronts, whichever that is, and by another if it is gone.

use crate::common::BALL;
use crate::common::receiver::{Receiver, secret};
use crate::common::service::Service;
use crate::harness::{Broker, LEASE, Node, wait_until};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::Path;

fn front(broker: &Broker, store: &Path, secret: &Path) -> Service {
    let (url, [store, secret]) = (broker.url(), [store, secret].map(|path| path.to_str().unwrap()));
    let farm = ["--farm", &url, "--store", store, "--farm-lease", LEASE, "--threads", "1"];
    let hooks = ["--webhook-http", "--webhook-allow", "127.0.0.1", "--webhook-secret-file", secret];
    Service::start(&[&farm[..], &hooks, &["--webhook-retry", "0.05", "--webhook-timeout", "60"]].concat())
}

/// Submits a ball of some width, with a message about its end and its picture to the store.
fn submit(front: &Service, receiver: &Receiver, width: u64) -> String {
    let scene: Value = serde_json::from_str(BALL).unwrap();
    let order = json!({
        "scene": scene, "settings": { "width": width }, "webhook": { "url": receiver.url() }, "store": {}
    });
    let answer = front.post_json("/v1/jobs", &order.to_string());
    assert_eq!(answer.status, 202, "{}", answer.text());
    answer.json()["id"].as_str().unwrap().to_owned()
}

fn job(front: &Service, id: &str) -> Value {
    front.get(&format!("/v1/jobs/{id}")).json()
}

fn wait_until_delivered(front: &Service, id: &str) {
    let is_delivered = |job: &Value| ["store", "webhook"].iter().all(|what| job[what]["state"] == "delivered");
    wait_until(&format!("{id} is delivered: {}", job(front, id)), || is_delivered(&job(front, id)));
}

#[test]
fn one_front_delivers_and_another_one_if_it_is_killed() {
    let Some(broker) = Broker::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (file, secret) = secret(&folder);
    let store = folder.path().join("store");
    let mut fronts: Vec<_> = (0..3).map(|_| front(&broker, &store, &file)).collect();
    let _node = Node::start(&broker.url(), store.to_str().unwrap(), "node", &[]);

    let receiver = Receiver::start(&["204 No Content"]);
    let ids: Vec<_> = (0..12).map(|at| submit(&fronts[at % 3], &receiver, 40 + at as u64)).collect();
    for id in &ids {
        fronts.iter().for_each(|front| wait_until_delivered(front, id));
        assert_eq!(job(&fronts[0], id)["webhook"]["attempts"], 1);
        let picture = fronts[1].get(&format!("/v1/jobs/{id}/image")).body;
        assert!(std::fs::read(store.join(format!("results/anonymous/{id}.png"))).unwrap() == picture);
    }
    let seen = receiver.seen();
    let told: BTreeSet<_> = seen.iter().map(|message| message.header("webhook-id").to_owned()).collect();
    assert_eq!((seen.len(), told), (12, ids.iter().map(|id| format!("msg_{id}")).collect()), "each message came once");

    // The first attempt is never answered, and its front does not live to see that.
    let silent = Receiver::start(&["", "204 No Content"]);
    let id = submit(&fronts[0], &silent, 99);
    silent.wait_for(1);
    let mut sender = None;
    wait_until("a front says that it sends", || {
        sender = fronts.iter().position(|front| front.log().contains(&format!("a message is sent job=\"{id}\"")));
        sender.is_some()
    });
    let sender = fronts.remove(sender.unwrap());
    sender.signal("-KILL");
    drop(sender);
    wait_until_delivered(&fronts[0], &id);
    let seen = silent.seen();
    assert_eq!(seen.len(), 2);
    assert_eq!(seen[0].header("webhook-id"), seen[1].header("webhook-id"));
    assert_eq!(seen[0].body, seen[1].body, "it has one text");
    assert!(seen.iter().all(|message| message.is_signed_with(&secret)));
}
