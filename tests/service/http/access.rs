//! Who may do what: keys, scopes, quotas, capabilities, pages of other origins, and who is not let in at all.

use super::flood::until;
use super::job_events::Events;
use super::jobs::{ENDLESS, body, text};
use crate::common::service::{Answer, NO_TIMEOUT, PATIENCE, Service, request};
use crate::common::{BALL, SLOW};
use serde_json::json;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

fn strahl(args: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_strahl")).args(args).output().expect("the binary starts")
}

/// A key file of its own for each test.
pub(crate) struct KeyFile(PathBuf);

impl KeyFile {
    pub(crate) fn new(test: &str, text: &str) -> Self {
        let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{test}.toml"));
        std::fs::write(&file, text).unwrap();
        Self(file)
    }

    pub(crate) fn path(&self) -> &str {
        self.0.to_str().unwrap()
    }

    /// A new key, as an operator makes it.
    pub(crate) fn key(&self, tenant: &str, scopes: &str) -> String {
        let made = strahl(&["key", "new", "--tenant", tenant, "--scopes", scopes, "--file", self.path()]);
        assert!(made.status.success(), "{made:?}");
        format!("Bearer {}", String::from_utf8(made.stdout).unwrap().trim())
    }

    pub(crate) fn serve(&self, flags: &[&str]) -> Service {
        Service::start(&[&["--keys", self.path()], flags].concat())
    }
}

/// A request with somebody's key.
pub(crate) fn keyed(service: &Service, key: &str, method: &str, path: &str, body: &str) -> Answer {
    service.send(method, path, &[("Content-Type", "application/json"), ("Authorization", key)], body.as_bytes())
}

fn post(service: &Service, path: &str, key: &str, body: &str) -> Answer {
    let headers = [("Content-Type", "application/json"), ("Authorization", key)];
    let headers = if key.is_empty() { &headers[..1] } else { &headers[..] };
    service.send("POST", path, headers, body.as_bytes())
}

#[test]
fn keys_open_what_their_scopes_say() {
    let file = KeyFile::new("scopes", "");
    let (render, read) = (file.key("acme", "render"), file.key("acme", "read"));
    let service = file.serve(&[]);
    post(&service, "/v1/render", &render, BALL).picture();
    let refused = post(&service, "/v1/render", &read, BALL);
    assert!(refused.problem(403, "forbidden")["detail"].as_str().unwrap().contains("scope render"));
    for wrong in ["", "Basic eDp5", "Bearer rk_nobody_nothing", &render[..render.len() - 1], "Bearer"] {
        let refused = post(&service, "/v1/render", wrong, BALL);
        refused.problem(401, "unauthorized");
        assert!(refused.header("www-authenticate").starts_with("Bearer"), "{wrong}");
    }
    for open in ["/livez", "/readyz", "/v1/limits", "/schema/scene.json", "/openapi.json", "/problems/unauthorized"] {
        assert_eq!(service.get(open).status, 200, "{open} needs no key");
    }
    assert!(!service.log().contains("rk_"), "the log holds a key");
}

#[test]
fn keys_come_and_go_without_a_restart() {
    let file = KeyFile::new("reload", "");
    let first = file.key("acme", "render");
    let service = file.serve(&[]);
    let second = file.key("acme", "render");
    service.wait_for_log("the keys were read again");
    post(&service, "/v1/render", &second, BALL).picture();
    std::fs::write(&file.0, "nonsense").unwrap();
    service.wait_for_log("the keys stay as they were");
    post(&service, "/v1/render", &first, BALL).picture();
    std::fs::write(&file.0, "").unwrap();
    let started = Instant::now();
    while post(&service, "/v1/render", &first, BALL).status != 401 {
        assert!(started.elapsed() < PATIENCE, "a key that was taken away still opens");
    }
    service.wait_for_log("there are no keys any more");
}

#[test]
fn a_stream_ends_with_its_key() {
    let file = KeyFile::new("stream_of_key", "");
    let without = std::fs::read_to_string(&file.0).unwrap();
    let key = file.key("acme", "jobs,read");
    let service = file.serve(&[]);
    let mut events = Events::at(&service, "/v1/events", &[("Authorization", &key)]);
    keyed(&service, &key, "POST", "/v1/jobs", &body(SLOW, ENDLESS));
    assert_eq!(events.next_of_several().unwrap().0, "created");
    std::fs::write(&file.0, without).unwrap();
    // The job goes on for minutes, and tells of each of its tiles.
    while events.next_of_several().is_some() {}
    assert_eq!(keyed(&service, &key, "GET", "/v1/me", "").status, 401);
}

/// A key for pages of others' pictures makes no jobs, in whatever way it asks for them.
#[test]
fn who_may_not_submit_jobs_makes_none() {
    let file = KeyFile::new("no_jobs", "");
    let (render, read) = (file.key("acme", "render"), file.key("acme", "read"));
    let service = file.serve(&[]);
    for preferred in ["respond-async", "wait=20"] {
        let headers = [("Content-Type", "application/json"), ("Authorization", render.as_str()), ("Prefer", preferred)];
        let answer = service.send("POST", "/v1/render?width=24", &headers, BALL.as_bytes());
        assert_eq!((answer.status, answer.header("preference-applied")), (200, ""), "{}", answer.text());
    }
    let around = post(&service, "/v1/render?turntable=2&width=16&height=16", &render, BALL);
    assert!(around.problem(403, "forbidden")["detail"].as_str().unwrap().contains("scope jobs"), "{}", around.text());
    assert_eq!(keyed(&service, &read, "GET", "/v1/jobs", "").json()["jobs"], serde_json::json!([]));
}

#[test]
fn what_was_waited_for_is_given_to_who_may_still_read_it() {
    let file = KeyFile::new("waited", "");
    let without = std::fs::read_to_string(&file.0).unwrap();
    let key = file.key("acme", "jobs,read");
    let service = file.serve(&[]);
    let job = keyed(&service, &key, "POST", "/v1/jobs", &body(SLOW, ENDLESS)).json();
    let path = format!("/v1/jobs/{}/preview?after=1000000&wait=6", job["id"].as_str().unwrap());
    let waited = thread::scope(|scope| {
        let waited = scope.spawn(|| keyed(&service, &key, "GET", &path, ""));
        // The key is looked at when the request comes, so it goes a while later.
        thread::sleep(Duration::from_millis(500));
        std::fs::write(&file.0, without).unwrap();
        waited.join().unwrap()
    });
    waited.problem(401, "unauthorized");
}

#[test]
fn a_tenant_leaves_connections_to_others_while_it_waits() {
    let file = KeyFile::new("waits", "");
    let (many, one) = (file.key("many", "jobs,read"), file.key("one", "jobs,read"));
    let service = file.serve(&["--max-connections", "8"]);
    let job = keyed(&service, &many, "POST", "/v1/jobs", &body(SLOW, ENDLESS)).json();
    let path = format!("/v1/jobs/{}", text(&job["id"]));
    let wait = [("Authorization", many.as_str()), ("Prefer", "wait=60")];
    let begin = || {
        let mut stream = service.connect();
        stream.write_all(&request("GET", &path, &wait, b"")).unwrap();
        stream
    };
    let (_first, mut second) = (begin(), begin());
    let started = Instant::now();
    loop {
        let refused = service.send("GET", &path, &[("Authorization", &many), ("Prefer", "wait=1")], b"");
        if refused.status == 429 {
            assert!(refused.problem(429, "rate-limited")["detail"].as_str().unwrap().contains("/v1/events"));
            break;
        }
        assert!(started.elapsed() < PATIENCE, "two requests wait, and a third one may, too");
        // It may have come while the one before took a place for its second, and was refused.
        second = begin();
    }
    assert_eq!(keyed(&service, &many, "GET", &path, "").status, 200, "who does not wait is answered");
    assert_eq!(keyed(&service, &one, "GET", "/v1/me", "").status, 200);
    drop(second);
}

#[test]
fn a_tenant_leaves_connections_to_others_while_it_sends() {
    let file = KeyFile::new("sends", "");
    let (many, one) = (file.key("many", "render,read"), file.key("one", "render,read"));
    let service = file.serve(&["--max-connections", "8", "--body-timeout", "60"]);
    let headers = [("Content-Type", "application/json"), ("Authorization", &many), ("Expect", "100-continue")];
    let whole = request("POST", "/v1/render", &headers, BALL.as_bytes());
    let mut slow: Vec<TcpStream> = (0..4).map(|_| service.connect()).collect();
    for stream in &mut slow {
        stream.write_all(&whole[..whole.len() - BALL.len()]).unwrap();
        // The service says so as soon as it wants the body.
        stream.read_exact(&mut [0; 25]).unwrap();
    }
    let refused = keyed(&service, &many, "GET", "/v1/me", "");
    assert!(refused.problem(429, "rate-limited")["detail"].as_str().unwrap().contains("4 requests of your tenant"));
    assert_eq!(refused.header("retry-after"), "1");
    keyed(&service, &one, "POST", "/v1/render", BALL).picture();
    drop(slow);
    until("places of who has left are not given back", || keyed(&service, &many, "GET", "/v1/me", "").status == 200);
}

#[test]
fn strangers_are_kept_out_unless_told_otherwise() {
    let refused = strahl(&["serve", "--listen", "0.0.0.0:0"]);
    assert_eq!(refused.status.code(), Some(2));
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(said.contains("--keys") && said.contains("--insecure-no-auth"), "{said}");
    let both = strahl(&["serve", "--keys", "x.toml", "--insecure-no-auth"]);
    assert_eq!(both.status.code(), Some(2));
    let broken = KeyFile::new("broken", "[[kyes]]\n");
    let refused = strahl(&["serve", "--keys", broken.path()]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("kyes"), "{refused:?}");
}

#[test]
fn settings_that_cannot_work_are_refused_at_the_start() {
    let admin = "--admin-listen";
    for (flags, part) in [
        (&["--listen", "127.0.0.1:18999", admin, "127.0.0.1:18999"][..], "own port"),
        (&["--listen", "0.0.0.0:18999", "--insecure-no-auth", admin, "127.0.0.1:18999"], "own port"),
        (&["--listen", "localhost:8080"], "names are not looked up"),
        (&["--studio-files", "no-such-folder"], "there is no such folder"),
        (&["--textures", "no-such-folder"], "--textures no-such-folder"),
        (&["--max-pixels", "0"], "--max-pixels"),
    ] {
        let refused = strahl(&[&["serve"], flags].concat());
        let said = String::from_utf8_lossy(&refused.stderr);
        assert!(refused.status.code() == Some(2) && said.contains(part), "{flags:?}: {said}");
    }
}

#[test]
fn a_tenant_that_asks_too_often_is_told_when_to_come_back() {
    let file = KeyFile::new("rate", "[tenants.small]\nunits_per_minute = 3\n");
    let (small, large) = (file.key("small", "render"), file.key("large", "render"));
    let service = file.serve(&[]);
    for left in ["r=2", "r=1", "r=0"] {
        let answer = post(&service, "/v1/scenes/validate", &small, BALL);
        assert_eq!((answer.status, answer.header("ratelimit-policy")), (200, "\"tenant\";q=3;w=60"));
        assert!(answer.header("ratelimit").contains(left), "{left} in {}", answer.header("ratelimit"));
    }
    let refused = post(&service, "/v1/scenes/validate", &small, BALL);
    refused.problem(429, "rate-limited");
    assert!(refused.header("retry-after").parse::<u32>().is_ok_and(|s| (1..=20).contains(&s)), "{refused:?}");
    assert!(refused.header("ratelimit").contains("r=0"));
    for _ in 0..5 {
        assert_eq!(post(&service, "/v1/scenes/validate", &large, BALL).status, 200, "others are not held up");
    }
}

#[test]
fn who_has_no_units_left_can_stop_what_takes_them() {
    let file = KeyFile::new("stop", "[tenants.small]\nunits_per_minute = 3\n");
    let key = file.key("small", "jobs,read");
    let service = file.serve(&[]);
    let submitted = post(&service, "/v1/jobs", &key, &format!("{{\"scene\": {SLOW}}}")).json();
    while post(&service, "/v1/jobs", &key, "{}").status != 429 {}
    let path = format!("/v1/jobs/{}", submitted["id"].as_str().unwrap());
    let send = |method: &str| service.send(method, &path, &[("Authorization", &key)], b"");
    assert_eq!(post(&service, &format!("{path}/cancel"), &key, "").status, 202);
    // No other method of the path is free.
    send("GET").problem(429, "rate-limited");
    let forgotten = send("DELETE");
    assert_eq!((forgotten.status, forgotten.header("ratelimit").contains("r=0")), (204, true), "{forgotten:?}");
}

#[test]
fn a_picture_costs_units_by_its_rays() {
    let file = KeyFile::new("cost", "[tenants.acme]\nunits_per_minute = 600\n");
    let key = file.key("acme", "render");
    let service = file.serve(&[]);
    let answer = post(&service, "/v1/render?width=1500&height=1000&antialias=false", &key, BALL);
    assert_eq!(answer.status, 200);
    let rays = answer.header("render-rays").split(", ").filter_map(|kind| kind.split_once('=')?.1.parse::<u64>().ok());
    let units = 1 + rays.sum::<u64>() / 1_000_000;
    assert!(units > 2, "{answer:?}");
    let left = answer.header("ratelimit").split(';').find_map(|part| part.strip_prefix("r=")?.parse::<u64>().ok());
    let left = left.unwrap();
    // Ten units come back each second.
    assert!((600 - units..=600 - units + 50).contains(&left), "{left} left after {units}");
}

/// Units that are left, by the header of a request that costs one.
fn units_left(service: &Service, key: &str) -> u64 {
    let answer = post(service, "/v1/scenes/validate", key, BALL);
    let left = answer.header("ratelimit").split(';').find_map(|part| part.strip_prefix("r=")?.parse().ok());
    left.unwrap_or_else(|| panic!("{answer:?}"))
}

/// Starts a render and leaves after a time, before it is done.
fn render_and_leave(service: &Service, key: &str, path: &str, after: Duration) {
    let headers = [("Content-Type", "application/json"), ("Authorization", key)];
    let mut client = service.connect();
    client.write_all(&request("POST", path, &headers, SLOW.as_bytes())).unwrap();
    service.wait_for(1, 0);
    thread::sleep(after);
}

#[test]
fn rays_of_renders_that_were_left_are_charged() {
    // In a second fewer come back than a slow machine takes.
    let file = KeyFile::new("left", "[tenants.hasty]\nunits_per_minute = 300\n");
    let key = file.key("hasty", "render");
    let service = file.serve(&NO_TIMEOUT);
    let started = Instant::now();
    let before = units_left(&service, &key);
    let mut requests = 0;
    while units_left(&service, &key) + requests + 20 > before {
        assert!(started.elapsed() < PATIENCE, "{} of {before} units are left", units_left(&service, &key));
        render_and_leave(&service, &key, "/v1/render", Duration::from_millis(300));
        service.wait_for(0, 0);
        requests += 2;
    }
}

#[test]
fn who_began_a_render_pays_for_it_although_another_waits_for_it() {
    let tenants = "[tenants.first]\nunits_per_minute = 1000\n[tenants.second]\nunits_per_minute = 1000\n";
    let file = KeyFile::new("flight", tenants);
    let [first, second] = ["first", "second"].map(|tenant| file.key(tenant, "render"));
    let service = file.serve(&[]);
    let path = "/v1/render?width=256&height=256&samples=4";
    let picture = thread::scope(|scope| {
        let waiting = scope.spawn(|| {
            service.wait_for(1, 0);
            post(&service, path, &second, SLOW)
        });
        // Until the other one waits, too.
        render_and_leave(&service, &first, path, Duration::from_secs(2));
        waiting.join().unwrap()
    });
    let rays = picture.header("render-rays").split(", ").filter_map(|kind| kind.split_once('=')?.1.parse::<u64>().ok());
    let units = rays.sum::<u64>() / 1_000_000;
    assert!(units > 100, "{picture:?}");
    let [first, second] = [first, second].map(|key| units_left(&service, &key));
    assert!(first < 1_000 - units / 2 && second > 1_000 - units / 2, "{first} and {second} are left of {units}");
}

/// A page takes the addresses of tiles from the description that its capability has opened.
#[test]
fn tiles_are_named_with_the_capability_that_opens_them() {
    let file = KeyFile::new("named_tiles", "");
    let key = file.key("acme", "read,render");
    let service = file.serve(&["--public-url", "https://render.example.org/sub"]);
    let id = post(&service, "/v1/scenes", &key, BALL).json()["image_id"].as_str().unwrap().to_owned();
    let minted = post(&service, "/v1/capabilities", &key, &format!("{{\"image_id\": \"{id}\"}}")).json();
    let prefix = minted["prefix"].as_str().unwrap();
    let about = service.get(&format!("{prefix}/xyz/{id}.json")).json();
    let template = about["tiles"][0].as_str().unwrap();
    let path = template.strip_prefix("https://render.example.org/sub").unwrap_or_else(|| panic!("{template}"));
    let tile = path.replace("{z}", "0").replace("{x}", "0").replace("{y}", "0");
    assert_eq!(service.get(&tile).status, 200, "{tile}");
}

#[test]
fn a_capability_is_for_one_thing_and_for_looking() {
    let file = KeyFile::new("capability", "");
    let key = file.key("acme", "read");
    let service = file.serve(&[]);
    let id = "i_aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa";
    let minted = post(&service, "/v1/capabilities", &key, &format!("{{\"image_id\": \"{id}\", \"ttl\": 60}}"));
    assert_eq!(minted.status, 201, "{}", minted.text());
    let prefix = minted.json()["prefix"].as_str().unwrap().to_owned();
    let status = |path: &str| service.get(&format!("{prefix}{path}")).status;
    // There is no such picture; but who may not look does not learn that.
    assert_eq!(status(&format!("/v1/images/{id}.png")), 404);
    assert_eq!(status("/v1/images/i_bbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb.png"), 403);
    assert_eq!(status("/v1/limits"), 403);
    let changed = prefix.replace('~', "~x");
    assert_eq!(service.get(&format!("{changed}/v1/images/{id}.png")).status, 403);
    let submit = service.send("POST", &format!("{prefix}/v1/images/{id}.png"), &[], b"");
    submit.problem(403, "forbidden");
    for lost in ["", "/nothing", &format!("{prefix}/v1/jobs"), &format!("/{prefix}")] {
        assert!([403, 404].contains(&status(lost)), "{lost}");
    }
    service.wait_for_log("path=/c/... status=404");
    let tag = prefix.rsplit('.').next().unwrap();
    assert!(!service.log().contains(tag), "a capability is in the log:\n{}", service.log());
    for body in ["{}", "{\"image_id\": \"a/b\"}", "{\"image_id\": \"a\", \"ttl\": 0}", "{\"image\": \"a\"}"] {
        post(&service, "/v1/capabilities", &key, body).problem(422, "invalid-request");
    }
    post(&service, "/v1/capabilities", "", "{}").problem(401, "unauthorized");
}

#[test]
fn pages_of_other_origins_hear_even_why_they_are_refused() {
    let service = Service::start(&["--cors-origin", "https://a.org,https://b.org"]);
    let from = |origin: &str, method: &str, more: &[(&str, &str)]| {
        let headers = [&[("Origin", origin)], more].concat();
        service.send(method, "/v1/render", &headers, b"")
    };
    let wanted = [("Access-Control-Request-Method", "POST"), ("Access-Control-Request-Headers", "content-type")];
    let preflight = from("https://b.org", "OPTIONS", &wanted);
    assert_eq!(preflight.status, 204);
    assert_eq!(preflight.header("access-control-allow-origin"), "https://b.org");
    assert_eq!(preflight.header("access-control-allow-headers"), "content-type");
    assert!(preflight.header("access-control-allow-methods").contains("POST"));
    let refused = from("https://a.org", "POST", &[]);
    refused.problem(415, "unsupported-media-type");
    assert_eq!(refused.header("access-control-allow-origin"), "https://a.org");
    assert!(refused.header("access-control-expose-headers").contains("Retry-After"));
    assert_eq!(from("https://c.org", "POST", &[]).header("access-control-allow-origin"), "");
    assert_eq!(from("https://c.org", "OPTIONS", &wanted).header("access-control-allow-methods"), "");
    let keyed = KeyFile::new("origins", "").serve(&[]);
    assert_eq!(keyed.get("/livez").header("access-control-allow-origin"), "*");
}

/// One pixel of glass takes as many rays as a whole picture.
#[test]
fn rays_of_trees_are_charged() {
    let file = KeyFile::new("trees", "[tenants.curious]\nunits_per_minute = 6\n");
    let key = file.key("curious", "render");
    let service = file.serve(&[]);
    let balls: Vec<_> = (0..12)
        .map(|i| json!({ "sphere": { "center": [0, 0, 0], "radius": 1.0 + 0.1 * f64::from(i), "material": "glass" } }))
        .collect();
    let scene = json!({
        "version": 1, "image": { "width": 4, "height": 4 },
        "camera": { "pinhole": { "eye": [0.3, 0.2, 6], "look_at": [0, 0, 0] } },
        "materials": { "glass": { "transmission": 0.5, "reflection": 0.5, "ior": 1.5 } }, "objects": balls,
        "render": { "max_depth": 60, "min_weight": 0, "samples": 3, "antialias": false }
    });
    let (before, started) = (units_left(&service, &key), Instant::now());
    assert_eq!(post(&service, "/v1/tree?x=2&y=2", &key, &scene.to_string()).status, 200);
    let after = units_left(&service, &key);
    // A unit comes back in ten seconds.
    let regained = started.elapsed().as_secs() / 10 + 1;
    assert!(after + 3 <= before + regained, "{after} of {before} are left after {:?}", started.elapsed());
}
