//! What operators rely on: a listener of their own, numbers, logs, configuration.

use super::service::{Answer, Service, address_in};
use super::{BALL, SLOW};
use std::io::Write;
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::thread;
use std::time::{Duration, Instant};

/// A service with an admin listener on a free port, and that port's address.
fn with_admin(flags: &[&str]) -> (Service, SocketAddr) {
    // Port 0 takes a free one, which is announced first.
    let flags = [&["--admin-listen", "127.0.0.1:0"], flags].concat();
    let service = Service::start(&flags);
    let address = address_in(service.said_first()).expect("an admin address");
    (service, address)
}

fn get(address: SocketAddr, path: &str) -> Answer {
    let mut stream = TcpStream::connect(address).expect("it accepts connections");
    stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: strahl\r\nConnection: close\r\n\r\n").unwrap();
    Answer::read(stream)
}

fn strahl(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_strahl")).args(args).output().expect("the binary starts")
}

fn file(name: &str, text: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn operators_are_answered_on_their_own_listener_until_the_end() {
    let (mut service, admin) = with_admin(&["--drain-timeout", "60"]);
    assert_eq!(get(admin, "/livez").status, 200);
    assert_eq!(get(admin, "/readyz").json()["status"], "ready");
    assert_eq!(get(admin, "/healthz").status, 200);
    assert_eq!(service.get("/metrics").status, 404, "numbers are not for clients");
    assert_eq!(get(admin, "/v1/limits").status, 404, "clients' requests are not for operators");
    let check = strahl(&["healthcheck", "--url", &format!("http://{admin}/livez")]);
    assert!(check.status.success(), "{check:?}");

    let client = service.begin("/v1/render?width=256&height=256&samples=4", SLOW);
    service.wait_for(1, 0);
    service.terminate();
    while get(admin, "/readyz").status != 503 {
        thread::sleep(Duration::from_millis(2));
    }
    assert_eq!(get(admin, "/livez").status, 200);
    Answer::read(client).picture();
    assert!(service.ended(Duration::from_secs(5)).success());
}

#[test]
fn numbers_follow_what_happens() {
    let (service, admin) = with_admin(&["--queue", "0"]);
    service.post_json("/v1/render", BALL).picture();
    service.post_json("/v1/render", "{}").problem(422, "invalid-scene");
    service.get("/nowhere").problem(404, "not-found");
    let busy: Vec<_> = (0..2).map(|i| service.begin(&format!("/v1/render?max_depth={}", 900 + i), SLOW)).collect();
    service.wait_for_all(2);
    service.post_json("/v1/render?max_depth=3", BALL).problem(503, "saturated");
    let text = get(admin, "/metrics").text();
    for line in [
        "strahl_http_requests_total{route=\"/v1/render\",method=\"POST\",status=\"200\"} 1",
        "strahl_http_requests_total{route=\"/v1/render\",method=\"POST\",status=\"422\"} 1",
        "strahl_http_requests_total{route=\"unmatched\",method=\"GET\",status=\"404\"} 1",
        "strahl_renders_total{lane=\"interactive\",outcome=\"ok\"} 1",
        "strahl_shed_total{reason=\"saturated\"} 1",
        "strahl_renders_running ",
        "strahl_render_seconds_count 1",
        "strahl_encode_seconds_count{format=\"png\"} 1",
        "strahl_build_info{version=",
        "# EOF",
    ] {
        assert!(text.contains(line), "{line} in\n{text}");
    }
    let rays = text.lines().find_map(|line| line.strip_prefix("strahl_rays_total ")?.parse::<u64>().ok());
    assert!(rays.is_some_and(|rays| rays >= 48 * 32), "{rays:?}");
    drop(busy);
    service.wait_for(0, 0);
    let started = Instant::now();
    while !get(admin, "/metrics").text().contains("strahl_renders_total{lane=\"interactive\",outcome=\"canceled\"} 2") {
        assert!(started.elapsed() < Duration::from_secs(5), "{}", get(admin, "/metrics").text());
    }
}

/// T6: whoever probes never waits for renders. The bound is generous, since other tests share the machine; the worst of
/// 200 that is not an outlier counts.
#[test]
fn probes_do_not_wait_for_renders() {
    let (service, admin) = with_admin(&[]);
    let _busy: Vec<_> = (0..8).map(|i| service.begin(&format!("/v1/render?max_depth={}", 900 + i), SLOW)).collect();
    service.wait_for_all(8);
    let mut times: Vec<_> = (0..200)
        .map(|_| {
            let asked = Instant::now();
            assert_eq!(get(admin, "/livez").status, 200);
            asked.elapsed()
        })
        .collect();
    times.sort();
    println!("/livez beside 8 renders: median {:?}, p99 {:?}", times[100], times[197]);
    assert!(times[190] < Duration::from_millis(250), "{:?}", times[190]);
}

#[test]
fn logs_are_objects_with_the_request_and_its_trace() {
    let service = Service::start(&["--log-format", "json"]);
    let trace = "4bf92f3577b34da6a3ce929d0e0e4736";
    let parent = format!("00-{trace}-00f067aa0ba902b7-01");
    let headers = [("Traceparent", parent.as_str()), ("X-Request-Id", "mine-1")];
    assert_eq!(service.send("GET", "/v1/limits", &headers, b"").status, 200);
    service.wait_for_log("mine-1");
    let log = service.log();
    let line = log.lines().find(|line| line.contains("mine-1")).unwrap();
    let line: serde_json::Value = serde_json::from_str(line).unwrap_or_else(|_| panic!("not JSON: {line}"));
    assert_eq!((&line["request"], &line["trace"]), (&"mine-1".into(), &trace.into()), "{line}");
    assert_eq!((&line["path"], &line["status"]), (&"/v1/limits".into(), &200.into()), "{line}");
}

#[test]
fn the_file_comes_after_flags_and_environment() {
    let path = file("strahl.toml", "max_pixels = 1000\nqueue = 7\ntimeout = 12.5\ncors_origin = [\"https://a.org\"]\n");
    let config = path.to_str().unwrap();
    let printed = Command::new(env!("CARGO_BIN_EXE_strahl"))
        .args(["config", "print", "--config", config, "--queue", "9"])
        .env("STRAHL_TIMEOUT", "3")
        .output()
        .unwrap();
    let text = String::from_utf8(printed.stdout).unwrap();
    for line in [
        "max_pixels = 1000  # file",
        "queue = 9  # flag",
        "timeout = 3  # environment",
        "drain_timeout = 20  # default",
    ] {
        assert!(text.contains(line), "{line} in\n{text}");
    }
    // What is printed is a file that says the same.
    let again = file("printed.toml", &text);
    assert!(strahl(&["config", "check", again.to_str().unwrap()]).status.success(), "{text}");

    let service = Service::start(&["--config", config]);
    assert_eq!(service.get("/v1/limits").json()["request"]["max_pixels"], 1000);
    service.post_json("/v1/render?width=100&height=11", BALL).problem(413, "cost-limit");
}

#[test]
fn mistakes_in_the_file_are_named() {
    for (text, part) in [
        ("max_pixel = 3\n", "did you mean \"max_pixels\""),
        ("queue = \"many\"\n", "many"),
        ("queue = {}\n", "queue"),
        ("queue = \n", "line 1"),
        ("listen = \"everywhere\"\n", "everywhere"),
    ] {
        let path = file("wrong.toml", text);
        for args in [&["config", "check", path.to_str().unwrap()][..], &["serve", "--config", path.to_str().unwrap()]] {
            let refused = strahl(args);
            let said = String::from_utf8_lossy(&refused.stderr).into_owned();
            assert_eq!(refused.status.code(), Some(2), "{said}");
            assert!(said.contains(part), "{part} in {said}");
        }
    }
}
