//! Clients that go away, probes under load, and the end of the service.

use super::jobs::{job, submit, succeeded};
use crate::common::service::{Answer, NO_TIMEOUT, Service, request};
use crate::common::{BALL, SLOW};
use std::collections::BTreeSet;
use std::fs;
use std::io::{Read, Write};
use std::net::Shutdown;
use std::process::Command;

#[test]
fn a_client_that_goes_away_frees_the_pool() {
    let service = Service::start(&NO_TIMEOUT);
    let client = service.begin("/v1/render", SLOW);
    service.wait_for(1, 0);
    drop(client);
    service.wait_for(0, 0);
    service.wait_for_log("the client went away");
    assert!(!service.log().contains("ERROR"), "{}", service.log());
}

#[test]
fn a_client_that_sends_no_more_gets_its_answer() {
    let service = Service::start(&[]);
    let ask = |path: &str, scene: &str| {
        let mut client = service.begin(path, scene);
        client.shutdown(Shutdown::Write).unwrap();
        let mut bytes = Vec::new();
        client.read_to_end(&mut bytes).unwrap();
        bytes
    };
    let interim = b"HTTP/1.1 100 Continue\r\n\r\n";
    let quick = ask("/v1/scenes/validate", BALL);
    // On a busy machine it is not that quick.
    let quick = quick.strip_prefix(interim).unwrap_or(&quick);
    assert!(quick.starts_with(b"HTTP/1.1 200 OK\r\n"), "{}", String::from_utf8_lossy(quick));
    // One that waits for longer is asked whether it is still there.
    let slow = ask("/v1/render?width=256&height=256&samples=2", SLOW);
    let answer = slow.strip_prefix(interim).unwrap_or_else(|| panic!("{}", String::from_utf8_lossy(&slow)));
    assert!(answer.starts_with(b"HTTP/1.1 200 OK\r\n"), "{}", String::from_utf8_lossy(answer));
    let picture = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap() + 4;
    image::load_from_memory(&answer[picture..]).expect("all of the picture");
}

#[test]
fn probes_do_not_wait_for_requests() {
    let service = Service::start(&NO_TIMEOUT);
    let _busy: Vec<_> = (0..4).map(|i| service.begin(&format!("/v1/render?max_depth={}", 900 + i), SLOW)).collect();
    service.wait_for_all(4);
    for _ in 0..50 {
        assert_eq!(service.get("/livez").status, 200);
    }
    service.wait_for_all(4);
}

#[test]
fn sigterm_lets_the_running_finish_and_takes_nothing_new() {
    let mut service = Service::start(&["--drain-timeout", "600"]);
    // Long enough to be seen running, short enough to wait for.
    let client = service.begin("/v1/render?width=256&height=256&samples=4", SLOW);
    service.wait_for(1, 0);
    service.terminate();
    let refused = loop {
        let answer = service.get("/readyz");
        if answer.status == 503 {
            break answer;
        }
    };
    assert_eq!(refused.json()["status"], "draining");
    let refused = service.post_json("/v1/render", BALL);
    refused.problem(503, "draining");
    assert!(!refused.header("retry-after").is_empty());
    assert_eq!(service.get("/livez").status, 200);
    Answer::read(client).picture();
    assert!(service.ended().success());
}

/// Daemons read their files again; this one does so by itself.
#[test]
fn sighup_ends_nothing_without_a_terminal() {
    let service = Service::start(&["--log-format", "text"]);
    service.signal("-HUP");
    service.wait_for_log("SIGHUP changes nothing");
    assert_eq!(service.get("/livez").status, 200);
}

#[test]
fn draining_ends_even_if_a_render_does_not() {
    let mut service = Service::start(&[&NO_TIMEOUT[..], &["--drain-timeout", "0.3"]].concat());
    let client = service.begin("/v1/render", SLOW);
    service.wait_for(1, 0);
    service.terminate();
    let given_up = Answer::read(client);
    assert!(given_up.problem(503, "draining").to_string().contains("send it again"), "{}", given_up.text());
    assert!(service.ended().success());
}

#[test]
fn clients_that_are_still_sending_do_not_delay_the_end() {
    let mut service = Service::start(&["--drain-timeout", "600", "--body-timeout", "600"]);
    let whole = request("POST", "/v1/render", &[("Content-Type", "application/json")], BALL.as_bytes());
    let mut client = service.connect();
    client.write_all(&whole[..whole.len() - 10]).unwrap();
    service.get("/livez");
    service.terminate();
    Answer::read(client).problem(503, "draining");
    assert!(service.ended().success());
}

#[test]
fn an_idle_service_does_not_wait_for_connections() {
    let mut service = Service::start(&["--drain-timeout", "600", "--header-timeout", "600"]);
    let _idle = service.connect();
    service.terminate();
    assert!(service.ended().success());
}

#[test]
fn the_healthcheck_command_knows_alive_from_dead() {
    let mut service = Service::start(&[]);
    let check = |path: &str| {
        let url = format!("http://{}{path}", service.address);
        let check = Command::new(env!("CARGO_BIN_EXE_strahl")).args(["healthcheck", "--url", &url]).output();
        check.expect("the binary starts").status.code()
    };
    assert_eq!(check("/livez"), Some(0));
    assert_eq!(check("/nothing"), Some(1));
    service.terminate();
    service.ended();
    let url = format!("http://{}/livez", service.address);
    let dead = Command::new(env!("CARGO_BIN_EXE_strahl")).args(["healthcheck", "--url", &url]).output().unwrap();
    assert_eq!(dead.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&dead.stderr).starts_with("error: "), "{dead:?}");
}

/// Without `--data` the folder of a service that was killed goes with the start of the next one, and nothing else does.
#[test]
fn the_temporary_folder_of_a_killed_service_is_removed_by_the_next() {
    let root = tempfile::tempdir().unwrap();
    let start = |flags: &[&str]| Service::start_with_temporary(root.path(), flags);
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    let folders = || fs::read_dir(root.path()).unwrap().map(name).collect::<BTreeSet<_>>();
    let new_since = |before: &BTreeSet<String>| folders().difference(before).cloned().collect::<Vec<_>>();
    let kill = |mut service: Service| {
        service.signal("-KILL");
        service.ended();
    };

    let live = start(&[]);
    let kept = submit(&live, BALL, "");
    succeeded(&live, &kept);
    // A folder that somebody names is theirs, wherever it is; so is what is not the service's.
    let named = root.path().join("strahl-named");
    kill(start(&["--data", named.to_str().unwrap()]));
    let before = folders();
    kill(start(&[]));
    let left = new_since(&before);
    assert_eq!(left.len(), 1, "{left:?}");
    // Who names one that was left keeps it.
    let left = root.path().join(&left[0]);
    let again = start(&["--data", left.to_str().unwrap()]);
    assert_eq!(again.get("/v1/jobs").status, 200);
    kill(again);
    let before = folders();
    let strange = start(&[]);
    let with_notes = root.path().join(&new_since(&before)[0]);
    fs::write(with_notes.join("notes.txt"), "mine").unwrap();
    kill(strange);
    fs::create_dir(root.path().join("strahl-empty")).unwrap();
    let others = folders();

    let killed = start(&[]);
    succeeded(&killed, &submit(&killed, BALL, ""));
    let gone = new_since(&others);
    assert_eq!(gone.len(), 1, "{gone:?}");
    kill(killed);
    assert!(root.path().join(&gone[0]).is_dir(), "nobody has removed it yet");
    let next = start(&[]);
    assert!(!root.path().join(&gone[0]).exists());
    assert!(others.is_subset(&folders()), "{others:?} {:?}", folders());
    assert_eq!(job(&live, &kept)["state"], "succeeded");
    assert_eq!(live.get(&format!("/v1/jobs/{kept}/image")).status, 200);
    next.terminate();
}
