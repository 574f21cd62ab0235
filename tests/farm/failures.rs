//! Nodes, brokers and messages that fail: no job is lost, no tile is stored twice, and every picture is the one that one machine
//! makes.

use crate::backends::{MIRRORS, alone};
use crate::common::{BALL, SLOW};
use crate::harness::{Broker, Ear, Farm, LEASE, wait_until};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::io::{Read, Write};
use std::net::TcpListener;
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

/// One tile of `SLOW` that takes some seconds.
const DEAR_TILE: &str = r#""settings": { "width": 32, "height": 32, "samples": 400 }"#;

/// T1.
#[test]
fn a_node_that_is_killed_costs_only_time() {
    let Some(farm) = Farm::start(&[]) else { return };
    let results = Ear::at(&farm.broker, "farm.r.>");
    let (victim, _other) = (farm.node("victim"), farm.node("other"));
    let id = farm.submit("", MIRRORS);
    farm.wait_for_share(&id, 0.3);
    victim.kill();
    assert!(farm.picture(&id).body == alone("", MIRRORS));
    // Every tile was rendered; of those that were on their way when the node ended, some twice.
    let mut tiles: Vec<_> = results.heard().into_iter().map(|result| result.subject).collect();
    let sent = tiles.len();
    tiles.sort();
    tiles.dedup();
    assert_eq!(tiles.len() as u64, farm.job(&id)["progress"]["tiles_total"].as_u64().unwrap());
    assert!(sent - tiles.len() <= 2, "{sent} results of {} tiles", tiles.len());
    assert_eq!(farm.broker.messages("FARM_T"), 0);
}

/// T2.
#[test]
fn all_nodes_end_and_new_ones_go_on() {
    let Some(farm) = Farm::start(&[]) else { return };
    let nodes = ["one", "two"].map(|name| farm.node(name));
    let id = farm.submit("", MIRRORS);
    farm.wait_for_share(&id, 0.2);
    nodes.into_iter().for_each(crate::harness::Node::kill);
    let _new = farm.node("new");
    assert!(farm.picture(&id).body == alone("", MIRRORS));
}

/// A store that is not there for a while, as a folder that is mounted late.
#[test]
fn a_store_that_fails_and_comes_back_loses_nothing() {
    let Some(farm) = Farm::start(&[]) else { return };
    let _node = farm.node("one");
    let before = farm.submit("", BALL);
    farm.picture(&before);
    let id = farm.submit("", MIRRORS);
    farm.wait_for_share(&id, 0.1);
    let (store, away) = (farm.store.path().to_owned(), farm.store.path().with_extension("away"));
    std::fs::rename(&store, &away).unwrap();
    wait_until("the job waits", || farm.front.log().contains("a job waits until its files can be read and written"));
    assert_eq!(farm.job(&id)["state"], "running");
    for answer in [
        farm.front.get(&format!("/v1/jobs/{before}/image")),
        farm.front.post_json("/v1/jobs", &crate::harness::job(r#""labels": ["new"]"#, SLOW)),
    ] {
        assert_eq!((answer.status, answer.header("retry-after")), (503, "5"), "{}", answer.text());
    }
    assert_eq!(farm.job(&before)["state"], "succeeded", "what is known without the store is answered");
    assert!(!store.exists(), "nothing is put where the store was");
    std::fs::rename(&away, &store).unwrap();
    assert!(farm.picture(&id).body == alone("", MIRRORS));
    farm.picture(&before);
}

/// T3, one broker.
#[test]
fn a_broker_that_is_killed_and_comes_back_loses_nothing() {
    let Some(mut farm) = Farm::start(&[]) else { return };
    let _nodes = ["one", "two"].map(|name| farm.node(name));
    let id = farm.submit("", MIRRORS);
    farm.wait_for_share(&id, 0.3);
    farm.broker.kill();
    thread::sleep(Duration::from_secs(1));
    farm.broker.restart();
    assert!(farm.picture(&id).body == alone("", MIRRORS));
    wait_until("the queue is empty", || farm.broker.messages("FARM_T") == 0);
}

#[test]
fn what_is_asked_without_a_broker_does_not_happen_and_can_be_asked_again() {
    let Some(mut farm) = Farm::start(&[]) else { return };
    let id = farm.submit("", SLOW);
    farm.broker.kill();
    let json = [("Content-Type", "application/json"), ("Idempotency-Key", "once")];
    let send =
        |farm: &Farm, method: &str, path: &str, body: &str| farm.front.send(method, path, &json, body.as_bytes());
    let job = crate::harness::job("", BALL);
    for (method, path, body) in [
        ("POST", "/v1/jobs", job.as_str()),
        ("PATCH", &format!("/v1/jobs/{id}"), r#"{"priority": 7}"#),
        ("DELETE", &format!("/v1/jobs/{id}"), ""),
    ] {
        let answer = send(&farm, method, path, body);
        assert_eq!((answer.status, answer.header("retry-after")), (503, "5"), "{method} {path}: {}", answer.text());
    }
    farm.broker.restart();
    wait_until("the key can be used", || send(&farm, "POST", "/v1/jobs", &job).status == 202);
    // What had been refused would have come before what was accepted: over the same connection, and in order.
    assert_eq!(farm.job(&id)["priority"], 50);
    assert_eq!(farm.front.get("/v1/jobs").json()["jobs"].as_array().unwrap().len(), 2);
    wait_until("the job can be deleted", || send(&farm, "DELETE", &format!("/v1/jobs/{id}"), "").status == 204);
}

/// T5 and T14: the same work twice is stored once, and work that the broker has lost is sent again within its window for
/// duplicates.
#[test]
fn doubled_and_lost_messages_change_nothing() {
    let Some(farm) = Farm::start(&[]) else { return };
    let (work, results) = (Ear::at(&farm.broker, "farm.t.>"), Ear::at(&farm.broker, "farm.r.>"));
    let doubled = farm.submit("", MIRRORS);
    work.wait_for(1);
    // A rogue front sends it once more.
    let twice = work.heard()[0].clone();
    farm.broker.ask(async |broker| {
        broker.publish(twice.subject.clone(), twice.payload.clone()).await.unwrap().await.unwrap();
    });
    let _node = farm.node("one");
    wait_until("a tile is rendered twice", || {
        let mut of_tiles: HashMap<String, usize> = HashMap::new();
        results.heard().into_iter().for_each(|result| *of_tiles.entry(result.subject.to_string()).or_default() += 1);
        of_tiles.values().any(|count| *count > 1)
    });
    assert!(farm.picture(&doubled).body == alone("", MIRRORS));
    // Another one takes all away.
    let lost = farm.submit("", MIRRORS);
    farm.wait_for_share(&lost, 0.3);
    farm.broker.ask(async |broker| broker.get_stream("FARM_T").await.unwrap().purge().await.unwrap());
    assert!(farm.picture(&lost).body == alone("", MIRRORS));
    assert!(!farm.front.log().contains("DETERMINISM"), "{}", farm.front.log());
}

/// A node that makes other pixels than the one before it: the alarm.
#[test]
fn results_that_differ_raise_an_alarm() {
    let Some(farm) = Farm::start(&[]) else { return };
    let results = Ear::at(&farm.broker, "farm.r.>");
    let node = farm.node("one");
    let first = farm.submit("", MIRRORS);
    farm.picture(&first);
    node.kill();
    let work = Ear::at(&farm.broker, "farm.t.>");
    let second = farm.submit(r#""output": { "format": "png", "bits": 16 }"#, MIRRORS);
    work.wait_for(1);
    // A tile of the piece that waits, with one bit of one pixel changed, by a node that is somehow wrong.
    let piece: Value = serde_json::from_slice(&work.heard()[0].payload).unwrap();
    let tile = format!(".{}", piece["tiles"][0][0]);
    let result = results.heard().into_iter().find(|result| result.subject.ends_with(&tile)).unwrap();
    let subject = result.subject.replace(&first, &second);
    let kid = subject.split('.').nth(3).unwrap();
    let mut bytes = result.payload.to_vec();
    let contents = bytes.len() - 16;
    bytes[contents - 3] ^= 1;
    let owner = format!("{second} {kid}\n");
    let hash = Sha256::new().chain_update(owner).chain_update(&bytes[..contents]).finalize();
    bytes[contents..].copy_from_slice(&hash[..16]);
    farm.broker.ask(async |broker| broker.publish(subject.clone(), bytes.into()).await.unwrap().await.unwrap());
    let node = farm.node("two");
    farm.front.wait_for_log("DETERMINISM");
    wait_until("the node says so, too", || node.log().contains("other pixels of the same tile"));
    assert_eq!(farm.broker.messages("FARM_DLQ"), 1);
}

/// T6, a scene that no node can build, and T13, a damaged one.
#[test]
fn a_damaged_scene_is_a_failed_job_with_a_reason_and_no_picture() {
    let Some(farm) = Farm::start(&[]) else { return };
    let work = Ear::at(&farm.broker, "farm.t.>");
    let id = farm.submit("", MIRRORS);
    work.wait_for(1);
    let scene = serde_json::from_slice::<Value>(&work.heard()[0].payload).unwrap()["scene"]["text"].clone();
    let path = farm.store.path().join("scenes").join(scene.as_str().unwrap());
    let mut text = std::fs::read(&path).unwrap();
    let digit = text.windows(4).position(|four| four == b"0.2,").unwrap();
    text[digit + 2] = b'3';
    std::fs::write(&path, text).unwrap();
    let node = farm.node("one");
    assert_eq!(farm.wait(&id), "failed");
    let detail = farm.job(&id)["problem"]["detail"].as_str().unwrap_or_default().to_owned();
    assert!(detail.contains("damaged") && detail.contains("3 tries"), "{}", farm.job(&id));
    assert_eq!((farm.broker.messages("FARM_DLQ") >= 1, farm.broker.messages("FARM_T")), (true, 0));
    // The node renders other jobs.
    let other = farm.submit("", BALL);
    assert!(farm.picture(&other).body == alone("", BALL), "{}", node.log());
}

/// T6: a tile that ends every node.
#[test]
fn work_that_ends_five_nodes_fails_its_job_and_no_other() {
    let Some(farm) = Farm::start(&[]) else { return };
    let begun = Ear::at(&farm.broker, "farm.b.>");
    let id = farm.submit(DEAR_TILE, SLOW);
    for count in 1..=5 {
        let node = farm.node("victim");
        begun.wait_for(count);
        node.kill();
    }
    let node = farm.node("survivor");
    assert_eq!(farm.wait(&id), "failed");
    let failure = farm.job(&id)["problem"].clone();
    assert!(failure["detail"].as_str().unwrap().contains("5 nodes that began with tile 0"), "{failure}");
    assert_eq!((farm.broker.messages("FARM_DLQ"), farm.broker.messages("FARM_T")), (1, 0));
    let other = farm.submit("", BALL);
    assert!(farm.picture(&other).body == alone("", BALL), "{}", node.log());
}

/// T7: a tile of several leases is rendered once.
#[test]
fn a_slow_tile_keeps_its_lease() {
    let Some(farm) = Farm::start(&[]) else { return };
    let _nodes = ["one", "two"].map(|name| farm.node(name));
    let lease: u64 = LEASE.parse().unwrap();
    // A fast machine needs a dearer one.
    for samples in [400, 1_600, 6_400] {
        let tile = format!(r#""settings": {{ "width": 32, "height": 32, "samples": {samples} }}"#);
        let begun = Ear::at(&farm.broker, "farm.b.>");
        let began = Instant::now();
        let picture = farm.picture(&farm.submit(&tile, SLOW)).body;
        let leases = began.elapsed().as_secs() / lease;
        assert_eq!(begun.heard().len(), 1, "it was given to several nodes");
        if leases >= 2 {
            assert!(picture == alone(&tile, SLOW));
            return;
        }
    }
    panic!("all tiles are too cheap for this test");
}

/// T7: a node that stands still, and goes on when nobody needs it any more.
#[test]
fn work_of_a_stopped_node_goes_to_another_and_its_late_result_is_ignored() {
    let Some(farm) = Farm::start(&[]) else { return };
    let begun = Ear::at(&farm.broker, "farm.b.>");
    let id = farm.submit(DEAR_TILE, SLOW);
    let sleeper = farm.node("sleeper");
    begun.wait_for(1);
    sleeper.signal("-STOP");
    let _other = farm.node("other");
    let picture = farm.picture(&id).body;
    assert!(begun.heard().len() >= 2);
    sleeper.signal("-CONT");
    assert!(picture == alone(DEAR_TILE, SLOW));
    // It takes work again.
    drop(_other);
    let next = farm.submit("", BALL);
    assert!(farm.picture(&next).body == alone("", BALL), "{}", sleeper.log());
}

/// T8: queues of other versions are not touched, and messages of other versions stay.
#[test]
fn work_of_other_versions_is_left_alone() {
    let Some(farm) = Farm::start(&[]) else { return };
    let work = Ear::at(&farm.broker, "farm.t.>");
    let first = farm.submit("", BALL);
    work.wait_for(1);
    let subject = work.heard()[0].subject.to_string();
    let kid = subject.split('.').nth(3).unwrap().to_owned();
    let node = farm.node("one");
    assert!(farm.picture(&first).body == alone("", BALL));
    farm.broker.ask(async |broker| {
        for subject in [format!("farm.t.norm.{kid}.acme.newer"), "farm.t.norm.aaaaaa.acme.older".to_owned()] {
            let payload = json!({ "v": 99, "tiles": "in another way" }).to_string();
            broker.publish(subject, payload.into()).await.unwrap().await.unwrap();
        }
    });
    wait_until("the newer one is handed back", || node.log().contains("work of another version"));
    let second = farm.submit(r#""settings": { "width": 60 }"#, BALL);
    assert!(farm.picture(&second).body == alone(r#""settings": { "width": 60 }"#, BALL));
    assert_eq!(farm.broker.messages("FARM_T"), 2);
}

/// T9.
#[test]
fn a_cancelled_job_leaves_the_queue() {
    let Some(farm) = Farm::start(&[]) else { return };
    let node = farm.node("one");
    let long = farm.submit(r#""settings": { "width": 2000, "height": 1500 }"#, MIRRORS);
    farm.wait_for_share(&long, 0.001);
    let short = farm.submit("", BALL);
    assert_eq!(farm.front.post_json(&format!("/v1/jobs/{long}/cancel"), "").status, 202);
    let of_long = format!("farm.t.*.*.*.{long}");
    wait_until("its work is gone", || {
        let filter = of_long.clone();
        farm.broker.ask(async |broker| {
            let stream = broker.get_stream("FARM_T").await.unwrap();
            let info =
                futures_util::TryStreamExt::try_collect::<Vec<_>>(stream.info_with_subjects(&filter).await.unwrap());
            info.await.unwrap().is_empty()
        })
    });
    assert!(farm.picture(&short).body == alone("", BALL), "{}", node.log());
    assert_eq!(farm.wait(&long), "canceled");
}

/// A node that is told to end finishes what it has, and says goodbye.
#[test]
fn a_node_drains() {
    let Some(farm) = Farm::start(&[]) else { return };
    let mut node = farm.node("one");
    let id = farm.submit("", MIRRORS);
    farm.wait_for_share(&id, 0.1);
    node.signal("-TERM");
    assert_eq!(node.ended(), Some(0), "{}", node.log());
    assert!(!node.log().contains("giving back"), "{}", node.log());
    assert_eq!(farm.nodes(), [""; 0]);
    let _new = farm.node("two");
    assert!(farm.picture(&id).body == alone("", MIRRORS));
}

/// T15: the newest one that is too old.
#[test]
fn an_old_server_is_refused() {
    let Some(broker) = Broker::start_old() else { return };
    is_refused(&broker.url(), "2.11.11");
}

/// T15: what an old server says of itself suffices.
#[test]
fn who_says_that_it_is_an_old_server_is_refused() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("nats://{}", listener.local_addr().unwrap());
    thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let info = json!({ "server_id": "old", "version": "2.9.10", "proto": 1, "headers": true, "max_payload": 1048576, "jetstream": true });
            stream.write_all(format!("INFO {info}\r\n").as_bytes()).unwrap();
            let mut said = [0; 4096];
            while matches!(stream.read(&mut said), Ok(1..)) {
                stream.write_all(b"PONG\r\n").unwrap();
            }
        }
    });
    is_refused(&url, "2.9.10");
}

fn is_refused(url: &str, version: &str) {
    for command in ["serve", "node"] {
        let store = tempfile::tempdir().unwrap();
        let ended = Command::new(env!("CARGO_BIN_EXE_strahl"))
            .args([command, "--farm", url, "--store"])
            .arg(store.path())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert_eq!(ended.status.code(), Some(1), "{said}");
        assert!(said.contains(version) && said.contains("2.12 or newer"), "{said}");
    }
}

/// A broker that is not there, and one that keeps no messages.
#[test]
fn a_broker_that_cannot_be_used_is_refused_with_advice() {
    let Some(broker) = Broker::start_with(&["--user", "me", "--pass", "secret"]) else { return };
    let store = tempfile::tempdir().unwrap();
    let ended = Command::new(env!("CARGO_BIN_EXE_strahl"))
        .args(["node", "--farm", &broker.url(), "--store"])
        .arg(store.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(ended.status.code() == Some(1) && said.contains("--farm-credentials"), "{said}");
}
