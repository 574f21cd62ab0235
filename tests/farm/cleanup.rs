//! What no job needs leaves the store.

use crate::common::BALL;
use crate::fronts::{Fronts, submit, wait_for};
use crate::harness::wait_until;
use serde_json::json;
use std::fs;

/// Pictures and scenes go once no job needs them, whichever front has accepted, finished or deleted the jobs.
#[test]
fn nothing_stays_in_the_store_that_no_job_needs() {
    let Some(farm) = Fronts::start(2, &[]) else { return };
    let _node = farm.node();
    let ids: Vec<String> = (0..2).map(|at| submit(&farm.fronts[at], BALL, &json!({ "width": 48 + at }))).collect();
    for id in &ids {
        wait_for(&farm.fronts[0], id, "succeeded");
    }
    let files = |folder: &str| fs::read_dir(farm.store.path().join(folder)).map_or(0, Iterator::count);
    assert!(files("scenes") == 1 && files("pictures") >= 2, "they share their scene");
    for (id, front) in ids.iter().zip(farm.fronts.iter().rev()) {
        assert_eq!(front.send("DELETE", &format!("/v1/jobs/{id}"), &[], b"").status, 204);
    }
    let records = || {
        farm.broker.ask(async |broker| {
            let bucket = broker.get_key_value("farm_jobs").await.unwrap();
            futures_util::StreamExt::count(bucket.keys().await.unwrap()).await
        })
    };
    wait_until("the store is empty, and no record stays", || files("scenes") + files("pictures") + records() == 0);
    assert!(farm.fronts.iter().all(|front| !front.log().contains("ERROR") && !front.log().contains("WARN")));
}
