//! Jobs on disk: killed and taken up again, expired, and gone where there is no room.

use super::job_events::Events;
use super::jobs::{LONG, body, job, mirrors, submit, succeeded, text, until};
use crate::common::service::{PATIENCE, Service};
use crate::common::{BALL, SLOW};
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

#[test]
fn killed_in_mid_render_it_goes_on_where_it_was_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let data = ["--data", folder.path().to_str().unwrap()];
    let service = Service::start(&data);
    let id = submit(&service, &mirrors(), LONG);
    let waiting = submit(&service, BALL, "");
    assert_eq!(service.get("/v1/limits").json()["jobs"]["durable"], true);
    let before = until(&service, &id, |job| job["progress"]["tiles_done"].as_u64() >= Some(4));
    drop(service);
    let service = Service::start(&data);
    let after = succeeded(&service, &id);
    let recovered = after["stats"]["tiles_recovered"].as_u64().unwrap();
    assert!(recovered >= before["progress"]["tiles_done"].as_u64().unwrap(), "{before} {after}");
    assert!(
        Some(recovered) < after["progress"]["tiles_total"].as_u64(),
        "{after}: it was killed too late to see anything"
    );
    succeeded(&service, &waiting);
    let picture = service.get(&format!("/v1/jobs/{id}/image"));
    let alone = Service::start(&[]).post_json("/v1/render?width=384&height=384&samples=4", &mirrors());
    assert_eq!(picture.body, alone.body, "the same bytes as without a kill");
    drop(service);
    let service = Service::start(&data);
    assert_eq!(job(&service, &id)["state"], "succeeded");
    assert_eq!(service.get(&format!("/v1/jobs/{id}/image")).body, alone.body, "also after another restart");
}

/// A ball that is doubled again and again: one ray takes longer than any test waits.
fn endless() -> String {
    let instance = |of: u32| format!(r#"{{ "instance": {{ "of": "d{of}" }} }}"#);
    let doubled = |level: u32| format!(r#""d{level}": [ {0}, {0} ]"#, instance(level - 1));
    let definitions: Vec<_> = (1..32).map(doubled).collect();
    format!(
        r#"{{ "version": 1, "image": {{ "width": 32, "height": 32 }},
            "camera": {{ "pinhole": {{ "eye": [0, 0, 5], "look_at": [0, 0, 0] }} }},
            "definitions": {{ "d0": [ {{ "sphere": {{ "center": [0, 0, 0], "radius": 1 }} }} ], {} }},
            "objects": [ {} ], "render": {{ "antialias": false }} }}"#,
        definitions.join(", "),
        instance(31)
    )
}

#[test]
fn a_job_that_never_gets_anywhere_fails_when_it_has_seen_the_process_end_three_times() {
    let folder = tempfile::tempdir().unwrap();
    let data = ["--data", folder.path().to_str().unwrap()];
    let plan = Service::start(&[]).post_json("/v1/explain", &endless()).json();
    assert_eq!(plan["overlap"], f64::from(1u32 << 31));

    let mut service = Service::start(&data);
    let id = submit(&service, &endless(), "");
    for _ in 0..3 {
        until(&service, &id, |job| job["state"] == "running");
        // A clean end does not count.
        service.terminate();
        assert!(service.ended().success());
        service = Service::start(&data);
    }
    let mut kills = 0;
    let failed = loop {
        let seen = until(&service, &id, |job| job["state"] == "running" || job["state"] == "failed");
        if seen["state"] == "failed" {
            break seen;
        }
        // A kill does not count if the disk does not know yet that the job runs.
        kills += 1;
        assert!(kills < 7, "{seen}");
        drop(service);
        service = Service::start(&data);
    };
    assert!(kills >= 3, "{kills}");
    assert!(text(&failed["problem"]["type"]).ends_with("/problems/abandoned"), "{failed}");
    succeeded(&service, &submit(&service, BALL, ""));
}

#[test]
fn a_folder_belongs_to_one_service() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().to_str().unwrap();
    let _service = Service::start(&["--data", data]);
    let other = std::process::Command::new(env!("CARGO_BIN_EXE_strahl"))
        .args(["serve", "--listen", "127.0.0.1:0", "--data", data])
        .output()
        .unwrap();
    assert_eq!(other.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&other.stderr).contains("Another process"), "{other:?}");
}

#[test]
fn pictures_and_records_expire() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().to_str().unwrap();
    let service = Service::start(&["--data", data, "--keep-pictures", "1", "--keep-records", "6"]);
    let id = submit(&service, BALL, "");
    until(&service, &id, |job| job["state"] == "expired");
    service.get(&format!("/v1/jobs/{id}/image")).problem(410, "gone");
    let started = Instant::now();
    while service.get(&format!("/v1/jobs/{id}")).status == 200 {
        assert!(started.elapsed() < PATIENCE, "the record stays");
        thread::sleep(Duration::from_millis(50));
    }
    service.get(&format!("/v1/jobs/{id}")).problem(410, "gone");
    let left = |name: &str| std::fs::read_dir(folder.path().join(name)).unwrap().count();
    assert_eq!(["tiles", "pictures", "scenes"].map(left), [0; 3], "nothing of it is left on disk");
}

#[test]
fn ages_are_what_services_have_run_and_no_difference_of_dates() {
    let folder = tempfile::tempdir().unwrap();
    let flags = ["--data", folder.path().to_str().unwrap(), "--keep-pictures", "6", "--keep-records", "60"];
    let service = Service::start(&flags);
    let id = submit(&service, BALL, "");
    succeeded(&service, &id);
    drop(service);
    // To the service this looks like a clock that is put right.
    thread::sleep(Duration::from_secs(7));
    let service = Service::start(&flags);
    assert_eq!(job(&service, &id)["state"], "succeeded");
    assert_eq!(service.get(&format!("/v1/jobs/{id}/image")).status, 200);
    until(&service, &id, |job| job["state"] == "expired");
}

/// Bytes of all files in a folder and below it.
fn bytes_in(folder: &Path) -> u64 {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    entries
        .map(|entry| if entry.path().is_dir() { bytes_in(&entry.path()) } else { entry.metadata().unwrap().len() })
        .sum()
}

#[test]
fn where_there_is_no_room_on_disk_the_oldest_pictures_go_first() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().to_str().unwrap();
    let used =
        || ["tiles", "pictures", "scenes"].map(|part| bytes_in(&folder.path().join(part))).into_iter().sum::<u64>();
    let service = Service::start(&["--data", data, "--data-bytes", "3000000"]);
    assert_eq!(service.get("/v1/limits").json()["jobs"]["data_bytes"], 3_000_000);
    // A third of a megabyte each, and no two the same.
    let ids: Vec<String> = (0..6)
        .map(|i| {
            let settings = format!(r#"{{ "width": 200, "height": 150, "min_weight": 0.00{i} }}"#);
            let id = submit(&service, BALL, &format!(r#""settings": {settings}, "output": {{ "format": "pfm" }}"#));
            succeeded(&service, &id);
            assert!(used() <= 3_000_000, "{} bytes", used());
            id
        })
        .collect();
    let states = |service: &Service| ids.iter().map(|id| job(service, id)["state"].clone()).collect::<Vec<_>>();
    let first = states(&service);
    assert_eq!((&first[0], &first[4], &first[5]), (&"expired".into(), &"succeeded".into(), &"succeeded".into()));
    service.get(&format!("/v1/jobs/{}/image", ids[0])).problem(410, "gone");
    let newest = service.get(&format!("/v1/jobs/{}/image", ids[5]));
    assert_eq!((newest.status, newest.body.len() > 200 * 150 * 12), (200, true));
    drop(service);

    let service = Service::start(&["--data", data, "--data-bytes", "500000"]);
    until(&service, &ids[4], |job| job["state"] == "expired");
    assert_eq!(states(&service)[5], "succeeded", "what fits stays");
    assert!(used() <= 500_000, "{} bytes", used());
}

#[test]
fn what_cannot_fit_on_disk_is_refused() {
    let service = Service::start(&["--data-bytes", "2000000"]);
    let send = |scene: &str, settings: &str| service.post_json("/v1/jobs", &body(scene, settings));
    let padded = |space: usize| SLOW.replacen('{', &format!("{{{}", " ".repeat(space)), 1);
    let small = r#""settings": { "width": 64, "height": 64 }"#;
    for refused in
        [send(SLOW, r#""settings": { "width": 400, "height": 300, "samples": 1 }"#), send(&padded(1_100_000), small)]
    {
        let problem = refused.problem(413, "cost-limit");
        assert_eq!(problem["limit"]["name"], "data_bytes", "{problem}");
        assert_eq!(refused.header("retry-after"), "");
    }
    let first = submit(&service, &padded(600_000), small);
    let refused = send(&padded(700_000), small);
    assert!(text(&refused.problem(503, "saturated")["detail"]).contains("data_bytes"), "{}", refused.text());
    assert!(refused.header("retry-after").parse::<u32>().is_ok_and(|seconds| seconds > 0), "{refused:?}");
    // The same scene again takes no more room, and one that is no longer needed none.
    submit(&service, &padded(600_000), small);
    for job in service.get("/v1/jobs").json()["jobs"].as_array().unwrap() {
        service.send("DELETE", &format!("/v1/jobs/{}", text(&job["id"])), &[], b"");
    }
    service.get(&format!("/v1/jobs/{first}")).problem(404, "not-found");
    // The scene of a job that was running goes when its last ray has stopped.
    let deleted = Instant::now();
    while send(&padded(700_000), small).status != 202 {
        assert!(deleted.elapsed() < PATIENCE, "{}", send(&padded(700_000), small).text());
        thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn sigterm_with_a_job_and_a_watcher_ends_in_time_and_the_job_goes_on_later() {
    let folder = tempfile::tempdir().unwrap();
    let data = ["--data", folder.path().to_str().unwrap()];
    let mut service = Service::start(&data);
    let id = submit(&service, SLOW, LONG);
    let mut events = Events::of(&service, &id, &[]);
    assert_eq!(events.next().map(|(name, ..)| name).as_deref(), Some("snapshot"));
    until(&service, &id, |job| job["progress"]["tiles_done"].as_u64() >= Some(1));
    service.terminate();
    assert!(service.ended().success(), "{}", service.log());
    let last = events.all().pop().unwrap();
    assert_eq!((last.0.as_str(), &last.2["reason"]), ("shutdown", &"draining".into()));
    let service = Service::start(&data);
    let job = succeeded(&service, &id);
    assert!(job["stats"]["tiles_recovered"].as_u64() >= Some(1), "{job}");
}
