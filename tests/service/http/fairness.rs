//! Who asks for much does not hold up who asks for little, and has no more at one time than it may have.

use super::access::KeyFile;
use crate::common::service::{Answer, PATIENCE, Service, request};
use crate::common::{BALL, SLOW};
use serde_json::Value;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::thread;
use std::time::{Duration, Instant};

/// A service with keys, as one of its tenants sees it.
pub(super) struct Tenant<'a> {
    pub(super) service: &'a Service,
    pub(super) key: &'a str,
}

impl Tenant<'_> {
    pub(super) fn send(&self, method: &str, path: &str, body: &str) -> Answer {
        let headers = [("Content-Type", "application/json"), ("Authorization", self.key)];
        self.service.send(method, path, &headers, body.as_bytes())
    }

    pub(super) fn begin(&self, method: &str, path: &str, body: &str) -> TcpStream {
        let mut stream = self.service.connect();
        let headers = [("Content-Type", "application/json"), ("Authorization", self.key)];
        stream.write_all(&request(method, path, &headers, body.as_bytes())).unwrap();
        stream
    }

    /// The path of a new job.
    fn submit(&self, body: &str) -> String {
        let answer = self.send("POST", "/v1/jobs", body);
        assert_eq!(answer.status, 202, "{}", answer.text());
        answer.header("location").to_owned()
    }

    /// An open stream of events, as soon as there may be one.
    fn watch(&self, path: &str) -> TcpStream {
        let started = Instant::now();
        loop {
            let mut stream = self.begin("GET", path, "");
            let mut status = [0; 12];
            stream.read_exact(&mut status).unwrap();
            if status.ends_with(b"200") {
                return stream;
            }
            assert!(started.elapsed() < PATIENCE, "no room for a stream: {}", status.escape_ascii());
        }
    }

    /// When jobs have been finished, the latest first.
    fn finished(&self) -> Vec<String> {
        let (mut times, mut cursor) = (Vec::new(), String::new());
        loop {
            let page = self.send("GET", &format!("/v1/jobs?state=succeeded&limit=200{cursor}"), "").json();
            times.extend(page["jobs"].as_array().unwrap().iter().map(|job| text(&job["finished_at"]).to_owned()));
            let Some(next) = page["next"].as_str() else { return times };
            cursor = format!("&cursor={next}");
        }
    }
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("{value} is no text"))
}

/// T7. Times of different machines are not compared, but how much of one tenant's work was done during the other's.
#[test]
fn a_thousand_jobs_of_one_tenant_hold_up_anothers_by_no_more_than_a_round() {
    let file = KeyFile::new("fairness", "");
    let (many, one) = (file.key("many", "jobs,read"), file.key("one", "jobs,read"));
    let service = file.serve(&[]);
    let (many, one) = (Tenant { service: &service, key: &many }, Tenant { service: &service, key: &one });
    // Dozens of tiles each, and no two the same, since a picture that is there already is not rendered again.
    let theirs = |i: u32| {
        let settings = format!(r#"{{ "width": 2048, "height": 2048, "antialias": false, "min_weight": 0.00{i:04} }}"#);
        many.submit(&format!(r#"{{"scene": {BALL}, "settings": {settings}}}"#))
    };
    let first = theirs(0);
    // Many at a time: what the service finishes while they come is of no use.
    let numbers: Vec<u32> = (1..1_000).collect();
    thread::scope(|scope| {
        for part in numbers.chunks(64) {
            scope.spawn(|| part.iter().for_each(|i| drop(theirs(*i))));
        }
    });
    let waiting = service.get("/readyz").json()["jobs"]["waiting"].as_u64();
    assert!(waiting > Some(500), "only {waiting:?} of a thousand jobs wait: the test sees nothing");
    let mine = one.submit(&format!(r#"{{"scene": {BALL}}}"#));
    let mut job = one.send("GET", &mine, "").json();
    let started = Instant::now();
    while job["state"] != "succeeded" {
        assert!(started.elapsed() < PATIENCE, "{job}");
        job = one.send("GET", &mine, "").json();
    }
    assert!(job["stats"]["queue_ms"].as_f64() > Some(0.0), "it waited for the turns of others: {job}");
    // Whatever turns it needed, the others had one for each: at most the two jobs that were open came to their end.
    let (begin, end) = (text(&job["created_at"]), text(&job["finished_at"]));
    let meanwhile = many.finished().iter().filter(|time| (begin..=end).contains(&time.as_str())).count();
    assert!(meanwhile <= 2, "{meanwhile} of the other tenant's jobs were finished between {begin} and {end}");
    assert_eq!(one.send("GET", &first, "").status, 404, "others' jobs are nobody's business");
}

#[test]
fn scenes_that_wait_leave_room_for_those_of_others() {
    let file = KeyFile::new("waiting_scenes", "");
    let (many, one) = (file.key("many", "jobs,read"), file.key("one", "jobs,read"));
    let service = file.serve(&["--data-bytes", "40000000"]);
    let (many, one) = (Tenant { service: &service, key: &many }, Tenant { service: &service, key: &one });
    // Nothing ends meanwhile: each job takes minutes.
    let job = |bytes: usize| {
        let scene = SLOW.replacen('{', &format!("{{{}", " ".repeat(bytes)), 1);
        format!(r#"{{"scene": {scene}, "settings": {{ "width": 256, "height": 256, "samples": 256 }}}}"#)
    };
    let answers: Vec<Answer> = (0..4).map(|i| many.send("POST", "/v1/jobs", &job(4_900_000 + i))).collect();
    assert_eq!(answers[1].status, 202, "{}", answers[1].text());
    let refused = answers.last().unwrap();
    assert!(text(&refused.problem(429, "rate-limited")["detail"]).contains("data_bytes"), "{refused:?}");
    one.submit(&job(4_900_000));
}

#[test]
fn a_tenant_has_so_many_jobs_and_streams_at_one_time() {
    let file = KeyFile::new("quotas", "[tenants.small]\njobs = 2\nstreams = 1\n");
    let (small, large) = (file.key("small", "jobs,read"), file.key("large", "jobs,read"));
    let service = file.serve(&[]);
    let (small, large) = (Tenant { service: &service, key: &small }, Tenant { service: &service, key: &large });
    let endless = format!(r#"{{"scene": {SLOW}, "settings": {{ "width": 1024, "height": 1024 }}}}"#);
    let [watched, other] = [(); 2].map(|()| small.submit(&endless));
    let refused = small.send("POST", "/v1/jobs", &endless);
    refused.problem(429, "rate-limited");
    assert!(refused.header("retry-after").parse::<u32>().is_ok_and(|seconds| seconds > 0), "{refused:?}");
    large.submit(&format!(r#"{{"scene": {BALL}}}"#));

    let events = format!("{watched}/events");
    let watching = small.watch(&events);
    small.send("GET", &events, "").problem(429, "rate-limited");
    drop(watching);
    // When one has ended there is room for another.
    small.watch(&events);
    assert_eq!(small.send("POST", &format!("{other}/cancel"), "").status, 202);

    let limits = |tenant: &Tenant<'_>| tenant.send("GET", "/v1/limits", "").json()["tenant"].clone();
    assert_eq!(limits(&small), serde_json::json!({ "jobs": 2, "streams": 1, "units_per_minute": null }));
    assert_eq!((&limits(&large)["jobs"], &limits(&large)["streams"]), (&1_000.into(), &64.into()));
}

#[test]
fn a_client_has_so_many_tiles_at_one_time_and_leaves_room_for_others() {
    let file = KeyFile::new("tiles", "");
    let (many, one) = (file.key("many", "render"), file.key("one", "render"));
    let service = file.serve(&["--client-tiles", "3", "--timeout", "600"]);
    let (many, one) = (Tenant { service: &service, key: &many }, Tenant { service: &service, key: &one });
    let limits = service.get("/v1/limits").json();
    assert_eq!((&limits["request"]["client_tiles"], &limits["request"]["tile_queue"]), (&3.into(), &512.into()));
    let slow = |number: u32| many.begin("POST", &format!("/v1/render/tile?x={number}&y=0&w=1024&h=1024"), SLOW);
    let mut waiting: Vec<TcpStream> = (0..3).map(slow).collect();
    let small = "/v1/render/tile?x=0&y=0&w=8&h=8";
    // One that comes before them would be let in, and wait for them.
    thread::sleep(Duration::from_secs(2));
    let started = Instant::now();
    let mut refused = many.send("POST", small, BALL);
    while refused.status == 200 {
        assert!(started.elapsed() < PATIENCE, "a client may have any number of tiles");
        refused = many.send("POST", small, BALL);
    }
    assert!(text(&refused.problem(429, "rate-limited")["detail"]).contains("client_tiles"), "{}", refused.text());
    assert!(refused.header("retry-after").parse::<u32>().is_ok_and(|seconds| seconds > 0), "{refused:?}");
    one.send("POST", small, BALL).picture();
    many.send("POST", "/v1/render", BALL).picture();
    // Who no longer wants one may ask for another.
    drop(waiting.pop());
    let left = Instant::now();
    while many.send("POST", small, BALL).status != 200 {
        assert!(left.elapsed() < PATIENCE, "the place of who has gone stays taken");
    }
}

/// A picture that takes all the time it is given takes turns, too: one that begins after it ends before it.
#[test]
fn a_picture_in_a_time_lets_others_in() {
    let file = KeyFile::new("timed", "");
    let (long, short) = (file.key("long", "render"), file.key("short", "render"));
    let service = file.serve(&[]);
    let (long, short) = (Tenant { service: &service, key: &long }, Tenant { service: &service, key: &short });
    let mut waiting = long.begin("POST", "/v1/render?accuracy=time:10000", SLOW);
    service.wait_for(1, 0);
    short.send("POST", "/v1/render", BALL).picture();
    waiting.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
    let mut byte = [0];
    assert!(waiting.read(&mut byte).is_err(), "the long one had come to its end before the short one was answered");
    waiting.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let mut answer = vec![0; 12];
    waiting.read_exact(&mut answer).unwrap();
    assert_eq!(String::from_utf8_lossy(&answer), "HTTP/1.1 200");
}
