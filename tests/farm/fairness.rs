//! Fronts share what a tenant may have, and nobody waits for all that another one has ordered.

use crate::backends::{MIRRORS, alone};
use crate::common::BALL;
use crate::fronts::{Fronts, id_of, image, order, state, submit, wait_for, wait_for_tiles};
use crate::harness::{new_key, wait_until};
use serde_json::json;
use std::fs;
use std::thread;
use std::time::Duration;

/// T10.
#[test]
fn a_short_job_does_not_wait_for_a_long_one() {
    let Some(farm) = Fronts::start(2, &[]) else { return };
    let _node = farm.node();
    let long = submit(&farm.fronts[0], MIRRORS, &json!({ "width": 1600, "height": 1200 }));
    wait_for_tiles(&farm.fronts[1], &long, 0.01);
    let short = submit(&farm.fronts[1], BALL, &json!({}));
    wait_for(&farm.fronts[0], &short, "succeeded");
    assert_eq!(state(&farm.fronts[0], &long), "running");
    assert!(image(&farm.fronts[0], &short) == alone("", BALL));
}

/// T10: who asks for much has half of the farm, not all of it, while somebody else asks for something.
#[test]
fn one_tenant_does_not_wait_for_all_jobs_of_another() {
    let folder = tempfile::tempdir().unwrap();
    let keys = folder.path().join("keys.toml");
    let [much, little] = ["much", "little"].map(|tenant| new_key(&keys, tenant));
    let Some(farm) = Fronts::start(2, &["--keys", keys.to_str().unwrap()]) else { return };
    let ask = |front: usize, key: &str, method: &str, path: &str, body: &str| {
        let headers = [("Content-Type", "application/json"), ("Authorization", key)];
        farm.fronts[front].send(method, path, &headers, body.as_bytes())
    };
    let submit = |front: usize, key: &str, width: u32| {
        let answer = ask(front, key, "POST", "/v1/jobs", &order(MIRRORS, &json!({ "width": width })));
        assert_eq!(answer.status, 202, "{}", answer.text());
        id_of(&answer)
    };
    let job = |key: &str, id: &str| ask(0, key, "GET", &format!("/v1/jobs/{id}"), "").json();
    let many: Vec<String> = (0..6).map(|at| submit(at % 2, &much, 600 + at as u32)).collect();
    let _node = farm.node();
    wait_until("the first has begun", || many.iter().any(|id| job(&much, id)["progress"]["fraction"] != 0.0));
    let few: Vec<String> = (0..2).map(|at| submit(at, &little, 200 + at as u32)).collect();
    for id in &few {
        wait_until("a job of who asks for little ends", || job(&little, id)["state"] == "succeeded");
    }
    let waiting = many.iter().filter(|id| job(&much, id)["state"] != "succeeded").count();
    assert!(waiting >= 3, "{waiting} of 6 were not finished when the two small ones were");
    assert_eq!(
        ask(1, &little, "GET", &format!("/v1/jobs/{}", many[0]), "").status,
        404,
        "it belongs to another tenant"
    );
}

#[test]
fn a_rate_limit_is_that_of_all_fronts() {
    let folder = tempfile::tempdir().unwrap();
    let keys = folder.path().join("keys.toml");
    fs::write(&keys, "[tenants.acme]\nunits_per_minute = 60\n").unwrap();
    let key = new_key(&keys, "acme");
    let Some(farm) = Fronts::start(2, &["--keys", keys.to_str().unwrap()]) else { return };
    let left = |front: usize| {
        let answer = farm.fronts[front].send("GET", "/v1/jobs", &[("Authorization", &key)], b"");
        assert_eq!(answer.status, 200, "{}", answer.text());
        let units = answer.header("ratelimit").split("r=").nth(1).unwrap().split(';').next().unwrap();
        units.parse::<u32>().unwrap()
    };
    (0..30).for_each(|_| _ = left(0));
    // Each look costs a unit itself: so few of them cannot have spent what is missing.
    let seen: Vec<u32> = (0..5)
        .map(|_| {
            thread::sleep(Duration::from_secs(1));
            left(1)
        })
        .collect();
    assert!(seen.iter().any(|left| *left < 50), "{seen:?}");
}
