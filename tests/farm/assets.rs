//! Assets of a farm: sent to one front, named in jobs at another, read by nodes from the store.

use crate::common::service::{Answer, Service};
use crate::fronts::Fronts;
use crate::harness::{new_key, wait_until};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::fs;
use std::path::Path;
use std::thread;

fn model(name: &str) -> Vec<u8> {
    fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/inputs/models").join(name)).unwrap()
}

fn hash(bytes: &[u8]) -> String {
    data_encoding::HEXLOWER.encode(&Sha256::digest(bytes))
}

/// A job whose scene has a model by its hash.
fn order(hash: &str, width: u32) -> String {
    json!({ "scene": {
        "version": 1,
        "image": { "width": width, "height": 96 },
        "camera": { "pinhole": { "eye": [2, 2, 4], "look_at": [0, 0, 0] } },
        "objects": [{ "model": { "asset": format!("sha256:{hash}") } }],
    } })
    .to_string()
}

/// A tenant that speaks with fronts.
struct Client(String);

impl Client {
    fn send(&self, front: &Service, method: &str, path: &str, body: &[u8]) -> Answer {
        front.send(method, path, &[("Authorization", &self.0), ("Content-Type", "application/json")], body)
    }

    fn submit(&self, front: &Service, order: &str) -> Answer {
        self.send(front, "POST", "/v1/jobs", order.as_bytes())
    }

    fn job(&self, front: &Service, id: &str) -> Value {
        self.send(front, "GET", &format!("/v1/jobs/{id}"), b"").json()
    }

    fn picture(&self, front: &Service, id: &str) -> Vec<u8> {
        wait_until("a job ends", || {
            let job = self.job(front, id);
            assert!(!["failed", "canceled"].contains(&job["state"].as_str().unwrap()), "{job}\n{}", front.log());
            job["state"] == "succeeded"
        });
        self.send(front, "GET", &format!("/v1/jobs/{id}/image"), b"").body
    }
}

fn id(answer: &Answer) -> String {
    assert_eq!(answer.status, 202, "{}", answer.text());
    answer.json()["id"].as_str().unwrap().to_owned()
}

/// Two fronts, and two tenants.
fn farm() -> Option<(Fronts, [Client; 2], tempfile::TempDir)> {
    let folder = tempfile::tempdir().unwrap();
    let keys = folder.path().join("keys.toml");
    let tenants = ["acme", "bolt"].map(|tenant| Client(new_key(&keys, tenant)));
    Some((Fronts::start(2, &["--keys", keys.to_str().unwrap()])?, tenants, folder))
}

#[test]
fn an_asset_of_one_front_is_rendered_in_jobs_of_another_and_stays_while_they_need_it() {
    let Some((farm, [acme, bolt], _keys)) = farm() else { return };
    let [here, there] = [&farm.fronts[0], &farm.fronts[1]];
    let cube = model("Box.glb");
    let (path, order) = (format!("/v1/assets/{}", hash(&cube)), order(&hash(&cube), 128));
    acme.submit(there, &order).problem(422, "assets-missing");
    assert_eq!(acme.send(here, "PUT", &path, &cube).status, 201);
    assert!(acme.send(there, "GET", &path, b"").body == cube);
    bolt.submit(there, &order).problem(422, "assets-missing");
    let job = id(&acme.submit(there, &order));
    // Nobody has rendered it.
    for front in [here, there] {
        let refused = acme.send(front, "DELETE", &path, b"").problem(409, "conflict");
        assert!(refused["detail"].as_str().unwrap().contains(&job), "{refused}");
    }
    let _node = farm.node();
    let alone = Service::start(&["--threads", "2"]);
    alone.send("PUT", &path, &[], &cube);
    let same = id(&alone.post_json("/v1/jobs", &order));
    assert!(acme.picture(here, &job) == Client(String::new()).picture(&alone, &same), "another picture");

    // The other front knows the scene, and has it built.
    assert_eq!(acme.send(here, "DELETE", &path, b"").status, 204);
    let other = order.replace("\"width\":128", "\"width\":120");
    for order in [&order.replace("96", "95"), &other] {
        let lacking = acme.submit(there, order).problem(422, "assets-missing");
        assert_eq!(lacking["missing"], json!([hash(&cube)]));
    }
    let left =
        || fs::read_dir(farm.store.path().join("assets")).unwrap().flatten().filter(|file| file.path().is_file());
    assert_eq!(left().count(), 0, "{:?}", left().collect::<Vec<_>>());
}

#[test]
fn who_sends_or_names_an_asset_while_others_delete_it_has_it_or_is_told() {
    let Some((farm, [acme, bolt], _keys)) = farm() else { return };
    let [here, there] = [&farm.fronts[0], &farm.fronts[1]];
    let _node = farm.node();
    let cube = model("Box.glb");
    let path = format!("/v1/assets/{}", hash(&cube));
    let mut jobs = Vec::new();
    for round in 0..40 {
        // The last claim of another goes while this one comes.
        bolt.send(here, "PUT", &path, &cube);
        thread::scope(|scope| {
            let delete = scope.spawn(|| bolt.send(here, "DELETE", &path, b"").status);
            assert!([200, 201].contains(&acme.send(there, "PUT", &path, &cube).status));
            assert_eq!(delete.join().unwrap(), 204);
        });
        for front in [here, there] {
            assert!(acme.send(front, "GET", &path, b"").body == cube, "round {round}: the bytes are lost");
        }
        // A job comes while its asset goes.
        let (deleted, submitted) = thread::scope(|scope| {
            let delete = scope.spawn(|| acme.send(here, "DELETE", &path, b""));
            let submitted = acme.submit(there, &order(&hash(&cube), 64 + round));
            (delete.join().unwrap(), submitted)
        });
        match (deleted.status, submitted.status) {
            (204, 422) => drop(submitted.problem(422, "assets-missing")),
            // It is deleted when the job has ended.
            (204 | 409, 202) => jobs.push(id(&submitted)),
            // Each has seen the other.
            (409, 422) => {}
            other => panic!("round {round}: {other:?} {} {}", deleted.text(), submitted.text()),
        }
    }
    for job in &jobs {
        acme.picture(here, job);
    }
}
