//! T8: two versions of the program at one broker. Their pictures may differ, so none is made by both.

use crate::backends::{MIRRORS, alone};
use crate::common::service::{PROGRAM, Service};
use crate::harness::{Broker, Ear, LEASE, Node, job, wait_until};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A copy of the program that says it is of another version.
fn other_version(folder: &Path) -> PathBuf {
    let own = concat!("strahl ", env!("CARGO_PKG_VERSION"), " ").as_bytes();
    let other = [&own[..own.len() - 2], b"~ "].concat();
    let mut program = fs::read(PROGRAM).unwrap();
    let places: Vec<usize> = (0..program.len() - own.len()).filter(|at| program[*at..].starts_with(own)).collect();
    assert!(!places.is_empty(), "the program does not have its version as text any more");
    places.iter().for_each(|at| program[*at..*at + own.len()].copy_from_slice(&other));
    let path = folder.join("strahl-of-another-version");
    fs::copy(PROGRAM, &path).unwrap();
    fs::write(&path, program).unwrap();
    path
}

/// A broker, a store, and what both versions have there.
struct Both {
    results: Ear,
    other: PathBuf,
    folder: tempfile::TempDir,
    broker: Broker,
}

impl Both {
    fn start() -> Option<Self> {
        let broker = Broker::start()?;
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("store")).unwrap();
        Some(Self { results: Ear::at(&broker, "farm.r.>"), other: other_version(folder.path()), folder, broker })
    }

    fn store(&self) -> String {
        self.folder.path().join("store").to_str().unwrap().to_owned()
    }

    fn front(&self, program: &Path) -> Service {
        let (url, store) = (self.broker.url(), self.store());
        let flags = ["--farm", &url, "--store", &store, "--farm-lease", LEASE, "--threads", "1"];
        Service::try_start_program(program, Path::new("."), &flags).unwrap_or_else(|(_, said)| panic!("{said}"))
    }

    fn node(&self, program: &Path, name: &str) -> Node {
        Node::start_program(program, &self.broker.url(), &self.store(), name, &[])
    }

    /// Numbers of tiles that each version has made of a job.
    fn tiles(&self, id: &str) -> BTreeMap<String, BTreeSet<String>> {
        let mut tiles = BTreeMap::<String, BTreeSet<String>>::new();
        for message in self.results.heard() {
            let subject: Vec<&str> = message.subject.split('.').collect();
            if subject[2] == id {
                tiles.entry(subject[3].to_owned()).or_default().insert(subject[4].to_owned());
            }
        }
        tiles
    }
}

fn submit(front: &Service, members: &str) -> String {
    let answer = front.post_json("/v1/jobs", &job(members, MIRRORS));
    assert_eq!(answer.status, 202, "{}", answer.text());
    answer.json()["id"].as_str().unwrap().to_owned()
}

fn look(front: &Service, id: &str) -> Value {
    front.get(&format!("/v1/jobs/{id}")).json()
}

fn picture(front: &Service, id: &str) -> Vec<u8> {
    wait_until(&format!("{id} ends"), || {
        let job = look(front, id);
        assert_ne!(job["state"], "failed", "{job}");
        job["state"] == "succeeded"
    });
    front.get(&format!("/v1/jobs/{id}/image")).body
}

#[test]
fn no_picture_is_made_by_two_versions() {
    let Some(farm) = Both::start() else { return };
    let programs = [Path::new(PROGRAM), &farm.other];
    let fronts = programs.map(|program| farm.front(program));
    let _nodes = [farm.node(programs[0], "one"), farm.node(programs[1], "two")];
    let mut versions = BTreeSet::new();
    // Which front takes a job is chance. Jobs come until each version has made a picture.
    for round in 0..20 {
        let sizes: Vec<String> =
            (0..6).map(|at| format!(r#""settings": {{ "width": {} }}"#, 200 + 6 * round + at)).collect();
        let ids: Vec<String> = sizes.iter().enumerate().map(|(at, size)| submit(&fronts[at % 2], size)).collect();
        for (id, size) in ids.iter().zip(&sizes) {
            // Both versions make the same pixels here, or this could not be compared.
            assert!(picture(&fronts[0], id) == alone(size, MIRRORS), "another picture: {size}");
            let by: Vec<String> = farm.tiles(id).into_keys().collect();
            assert_eq!(by.len(), 1, "{size}: {by:?}");
            versions.extend(by);
        }
        if versions.len() == 2 {
            return;
        }
    }
    panic!("one version has made them all: {versions:?}");
}

#[test]
fn a_job_whose_version_is_gone_begins_again_with_the_new_one() {
    let Some(farm) = Both::start() else { return };
    let old = Path::new(PROGRAM);
    let (mut front, node) = (farm.front(old), farm.node(old, "old"));
    let id = submit(&front, "");
    wait_until("some tiles are there", || farm.tiles(&id).values().any(|tiles| tiles.len() >= 4));
    // The job does not end meanwhile.
    node.signal("-STOP");
    let next = farm.front(&farm.other);
    front.signal("-KILL");
    front.ended();
    node.kill();
    let _new = farm.node(&farm.other, "new");
    assert!(picture(&next, &id) == alone("", MIRRORS), "{}", next.log());
    let all = look(&next, &id)["progress"]["tiles_total"].as_u64().unwrap() as usize;
    let made: Vec<usize> = farm.tiles(&id).values().map(BTreeSet::len).collect();
    assert!(made.len() == 2 && made.contains(&all), "{made:?} of {all}");
}
