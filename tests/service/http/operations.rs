//! What operators rely on: a listener of their own, numbers, logs, configuration.

use super::access::KeyFile;
use super::jobs::submit;
use crate::common::service::{Answer, NO_TIMEOUT, PATIENCE, Service, address_in};
use crate::common::{BALL, SLOW};
use std::io::Write;
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::thread;
use std::time::{Duration, Instant};

/// A service with an admin listener on a free port, and that port's address.
pub(super) fn with_admin(flags: &[&str]) -> (Service, SocketAddr) {
    // Port 0 takes a free one, which is announced first.
    let flags = [&["--admin-listen", "127.0.0.1:0"], flags].concat();
    let service = Service::start(&flags);
    let address = address_in(service.said_first()).expect("an admin address");
    (service, address)
}

pub(super) fn get(address: SocketAddr, path: &str) -> Answer {
    get_as(address, "localhost", path)
}

fn get_as(address: SocketAddr, host: &str, path: &str) -> Answer {
    let mut stream = TcpStream::connect(address).expect("it accepts connections");
    stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
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
    let (mut service, admin) = with_admin(&["--drain-timeout", "600"]);
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
    assert!(service.ended().success());
}

#[test]
fn the_listener_for_operators_answers_to_its_own_names_and_to_addresses() {
    let public = ["--public-url", "https://render.example.org"];
    let (_open, open) = with_admin(&public);
    let keys = KeyFile::new("admin_hosts", "");
    let (_keyed, keyed) = with_admin(&[&public[..], &["--keys", keys.path()]].concat());
    for admin in [open, keyed] {
        for path in ["/metrics", "/livez", "/readyz", "/healthz"] {
            for host in [&admin.to_string(), "localhost:9090", "10.0.0.1:9090", "[::2]", "render.example.org:9090"] {
                assert_eq!(get_as(admin, host, path).status, 200, "{host} {path}");
            }
            for host in ["evil.example", "localhost.evil.example:9090", "127.0.0.1.nip.example"] {
                let refused = get_as(admin, host, path).problem(421, "misdirected-request");
                assert!(refused["detail"].as_str().unwrap().contains("--public-url"), "{refused}");
            }
        }
        get_as(admin, "user@localhost", "/metrics").problem(400, "malformed-request");
    }
}

#[test]
fn operators_are_warned_of_a_listener_that_others_reach() {
    let warning = "other machines can reach --admin-listen 0.0.0.0:0";
    Service::start(&["--admin-listen", "0.0.0.0:0"]).wait_for_log(warning);
    let (service, _) = with_admin(&[]);
    service.wait_for_log("documentation:");
    assert!(!service.log().contains("can reach"), "{}", service.log());
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
        "strahl_renders_total{lane=\"renders\",outcome=\"ok\"} 1",
        "strahl_renders_total{lane=\"renders\",outcome=\"refused\"} 2",
        "strahl_shed_total{reason=\"saturated\"} 1",
        "strahl_render_seconds_count{lane=\"renders\"} 1",
        "strahl_queue_seconds_count{lane=\"renders\"} 1",
        "strahl_encode_seconds_count{format=\"png\"} 1",
        "strahl_build_info{version=",
        "# EOF",
    ] {
        assert!(text.contains(line), "{line} in\n{text}");
    }
    let rays = number(&text, "strahl_rays_total{lane=\"renders\"}");
    assert!(rays >= f64::from(48 * 32), "{rays}");
    assert!(number(&text, "strahl_renders_running{lane=\"renders\"}") >= 1.0, "{text}");
    drop(busy);
    service.wait_for(0, 0);
    metrics_with(admin, &["strahl_renders_total{lane=\"renders\",outcome=\"canceled\"} 2"]);
    let wasted = number(&get(admin, "/metrics").text(), "strahl_canceled_work_seconds_total{lane=\"renders\"}");
    assert!(wasted > 0.0, "{wasted}");
}

/// The value of a series.
pub(super) fn number(text: &str, series: &str) -> f64 {
    let value = text.lines().find_map(|line| line.strip_prefix(series)?.strip_prefix(' ')?.parse().ok());
    value.unwrap_or_else(|| panic!("{series} in\n{text}"))
}

/// The numbers, as soon as these lines are among them.
pub(super) fn metrics_with(admin: SocketAddr, lines: &[&str]) -> String {
    let started = Instant::now();
    loop {
        let text = get(admin, "/metrics").text();
        let Some(missing) = lines.iter().find(|line| !text.lines().any(|found| found == **line)) else { return text };
        assert!(started.elapsed() < PATIENCE, "{missing} in\n{text}");
        thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn numbers_say_what_waits_what_runs_and_what_is_kept() {
    let (service, admin) = with_admin(&[]);
    for _ in 0..3 {
        service.post_json("/v1/render", BALL).picture();
    }
    submit(&service, BALL, r#""settings": { "width": 30 }"#);
    let text = metrics_with(
        admin,
        &[
            "strahl_jobs{state=\"succeeded\"} 1",
            "strahl_renders_total{lane=\"jobs\",outcome=\"ok\"} 1",
            "strahl_render_seconds_count{lane=\"jobs\"} 1",
            "strahl_encode_seconds_count{format=\"png\"} 2",
            "strahl_cache_misses_total{cache=\"pictures\"} 1",
            "strahl_cache_hits_total{cache=\"pictures\"} 2",
            "strahl_cache_misses_total{cache=\"scenes\"} 2",
            "strahl_threads_busy 0",
            "strahl_sse_streams 0",
        ],
    );
    for kept in ["strahl_cache_bytes{cache=\"pictures\"}", "strahl_cache_bytes{cache=\"scenes\"}", "strahl_data_bytes"]
    {
        assert!(number(&text, kept) > 100.0, "{kept} in\n{text}");
    }
    assert_eq!(number(&text, "strahl_cache_bytes{cache=\"known_scenes\"}"), 0.0);
    for spent in ["strahl_pool_seconds_total{lane=\"renders\"}", "strahl_pool_seconds_total{lane=\"jobs\"}"] {
        assert!(number(&text, spent) > 0.0, "{spent} in\n{text}");
    }

    let endless = r#""settings": { "width": 1024, "height": 1024 }"#;
    let jobs: Vec<String> = (0..5).map(|_| submit(&service, SLOW, endless)).collect();
    let mut watching = service.connect();
    write!(watching, "GET /v1/jobs/{}/events HTTP/1.1\r\nHost: localhost\r\n\r\n", jobs[0]).unwrap();
    let tiles: Vec<_> =
        (0..3).map(|x| service.begin(&format!("/v1/render/tile?x={x}&y=0&w=1024&h=1024"), SLOW)).collect();
    let text = metrics_with(
        admin,
        &[
            "strahl_jobs{state=\"running\"} 2",
            "strahl_jobs{state=\"queued\"} 3",
            "strahl_queue_depth{lane=\"jobs\"} 3",
            "strahl_renders_running{lane=\"jobs\"} 2",
            "strahl_sse_streams 1",
        ],
    );
    // The newest goes first, so how many have begun depends on how they came.
    let of_tiles = || {
        let text = get(admin, "/metrics").text();
        ["strahl_renders_running{lane=\"tiles\"}", "strahl_queue_depth{lane=\"tiles\"}"]
            .map(|series| number(&text, series))
    };
    let started = Instant::now();
    while !matches!(of_tiles(), [running, waiting] if running >= 1.0 && running + waiting == 3.0) {
        assert!(started.elapsed() < PATIENCE, "of three tiles run and wait {:?}", of_tiles());
    }
    assert!(number(&text, "strahl_threads") > 0.0, "{text}");
    metrics_with(admin, &[&format!("strahl_threads_busy {}", number(&text, "strahl_threads"))]);
    drop((tiles, watching));
    for id in &jobs {
        assert_eq!(service.send("POST", &format!("/v1/jobs/{id}/cancel"), &[], b"").status, 202);
    }
    let text = metrics_with(
        admin,
        &[
            "strahl_jobs{state=\"canceled\"} 5",
            "strahl_renders_total{lane=\"jobs\",outcome=\"canceled\"} 5",
            "strahl_renders_total{lane=\"tiles\",outcome=\"canceled\"} 3",
            "strahl_renders_running{lane=\"tiles\"} 0",
            "strahl_threads_busy 0",
            "strahl_sse_streams 0",
        ],
    );
    for wasted in ["tiles", "jobs"] {
        assert!(number(&text, &format!("strahl_canceled_work_seconds_total{{lane=\"{wasted}\"}}")) > 0.0, "{text}");
    }
    assert!(!text.contains("tenant") && !text.contains("anonymous"), "{text}");
}

#[test]
fn the_health_check_is_answered_however_many_clients_there_are() {
    let (service, admin) = with_admin(&["--max-connections", "4", "--body-timeout", "60"]);
    let check = |variable: &str, address: SocketAddr| {
        let strahl =
            Command::new(env!("CARGO_BIN_EXE_strahl")).arg("healthcheck").env(variable, address.to_string()).output();
        strahl.expect("the binary starts").status.success()
    };
    assert!(check("STRAHL_LISTEN", service.address));
    // Those that had no request would give way.
    let unfinished = "POST /v1/render HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n";
    let crowd: Vec<_> = (0..40).map(|_| service.connect()).collect();
    crowd.iter().for_each(|mut client| client.write_all(unfinished.as_bytes()).unwrap());
    assert!(!check("STRAHL_LISTEN", service.address), "the crowd has not taken all connections");
    assert!(check("STRAHL_ADMIN_LISTEN", admin), "operators are kept waiting, too");
    drop(crowd);
    let started = Instant::now();
    while !check("STRAHL_LISTEN", service.address) {
        assert!(started.elapsed() < PATIENCE, "the crowd has gone, and its connections have not");
    }
}

/// T6: whoever probes never waits for renders: all of them are still under way afterwards.
#[test]
fn probes_do_not_wait_for_renders() {
    let (service, admin) = with_admin(&NO_TIMEOUT);
    let _busy: Vec<_> = (0..8).map(|i| service.begin(&format!("/v1/render?max_depth={}", 900 + i), SLOW)).collect();
    service.wait_for_all(8);
    for _ in 0..200 {
        assert_eq!(get(admin, "/livez").status, 200);
    }
    service.wait_for_all(8);
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
    assert!(line["ms"].is_number(), "{line}");
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
fn printed_settings_hold_no_password() {
    let print = strahl(&["config", "print", "--store", "/tmp/store", "--farm", "nats://me:secret@a:1,tls://b:2"]);
    let text = String::from_utf8(print.stdout).unwrap();
    assert!(text.contains("farm = \"nats://***@a:1,tls://b:2\"  # flag"), "{text}");
}

#[test]
fn the_health_check_asks_where_the_file_says() {
    let service = Service::start(&[]);
    let path = file("health.toml", &format!("listen = \"{}\"\nqueue = 7\n", service.address));
    let check = |environment: Option<(&str, &str)>| {
        let mut strahl = Command::new(env!("CARGO_BIN_EXE_strahl"));
        strahl.args(["healthcheck", "--config", path.to_str().unwrap()]).envs(environment);
        strahl.output().expect("the binary starts").status.success()
    };
    assert!(check(None));
    assert!(!check(Some(("STRAHL_LISTEN", "127.0.0.1:9"))), "the environment comes first");
}

#[test]
fn misspelt_variables_are_named_in_the_log() {
    let mut program = Command::new(env!("CARGO_BIN_EXE_strahl"));
    program.envs([("STRAHL_MEMORY_BYTE", "7"), ("STRAHL_PORT", "tcp://10.0.0.1:80")]);
    let log = Service::try_start_command(program, &[]).unwrap_or_else(|(_, said)| panic!("{said}")).log();
    assert!(log.contains("STRAHL_MEMORY_BYTE is no setting; did you mean STRAHL_MEMORY_BYTES?"), "{log}");
    assert!(!log.contains("STRAHL_PORT"), "Kubernetes sets it: {log}");
}

#[test]
fn mistakes_in_the_file_are_named() {
    for (text, part) in [
        ("max_pixel = 3\n", "did you mean \"max_pixels\""),
        ("queue = \"many\"\n", "many"),
        ("queue = {}\n", "queue"),
        ("queue = \n", "line 1"),
        ("listen = \"everywhere\"\n", "everywhere"),
        ("public_url = \"https://a.org/?b\"\n", "without ? and #"),
        ("listen = \"0.0.0.0:0\"\n", "--insecure-no-auth"),
        ("listen = \"127.0.0.1:8081\"\nadmin_listen = \"127.0.0.1:8081\"\n", "the same address"),
        ("store = \"ftp://a/b\"\n", "ftp:// is not known"),
        ("store = \"s3:///b\"\n", "there is no bucket"),
        ("data = \"/nowhere/a\"\ncache = \"/nowhere/a/b\"\n", "one is in the other"),
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
