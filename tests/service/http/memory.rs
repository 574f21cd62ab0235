//! Memory is bounded by `--memory-bytes`, whatever is sent. What counts is what the system says that the process has had.

use super::access::{KeyFile, keyed};
use super::operations::{get, number, with_admin};
use crate::common::service::{Service, request};
use serde_json::json;
use std::io::Write;
use std::thread;
use std::time::Duration;

const MIB: u64 = 1 << 20;

/// Most and present resident bytes of a service.
fn resident(service: &Service) -> [u64; 2] {
    let status = std::fs::read_to_string(format!("/proc/{}/status", service.pid())).unwrap();
    ["VmHWM:", "VmRSS:"].map(|name| {
        let line = status.lines().find_map(|line| line.strip_prefix(name)).unwrap();
        line.trim().strip_suffix("kB").unwrap().trim().parse::<u64>().unwrap() * 1_024
    })
}

fn scene(objects: &str) -> String {
    format!(
        r#"{{"version":1,"image":{{"width":16,"height":16}},"camera":{{"pinhole":{{"eye":[0,0,5],"look_at":[0,0,0]}}}},"objects":[{objects}]}}"#
    )
}

fn balls(count: usize, seed: usize) -> String {
    let ball = |i: usize| format!(r#"{{"sphere":{{"center":[{i},{seed},0],"radius":1}}}}"#);
    scene(&(0..count).map(ball).collect::<Vec<_>>().join(","))
}

/// Each of these scenes takes about 80 MB while it is built.
#[test]
fn a_storm_of_large_scenes_stays_within_the_memory_there_is() {
    let bytes = 256 * MIB;
    let (service, admin) = with_admin(&["--memory-bytes", &bytes.to_string()]);
    thread::scope(|scope| {
        for client in 0..4 {
            let service = &service;
            scope.spawn(move || {
                for round in 0..6 {
                    let answer = service.post_json("/v1/render", &balls(60_000, 10 * client + round));
                    match answer.status {
                        200 => {}
                        _ => drop(answer.problem(503, "saturated")),
                    }
                }
            });
        }
    });
    let [most, now] = resident(&service);
    assert!(most < bytes * 11 / 10, "{} MiB", most / MIB);
    let counted = number(&get(admin, "/metrics").text(), "strahl_memory_bytes") as u64;
    assert!(now < counted * 13 / 10 + 32 * MIB, "{} MiB, counted {}", now / MIB, counted / MIB);
    assert_eq!(service.post_json("/v1/render", &balls(10, 0)).status, 200);
}

/// Bodies that one tenant sends, and never finishes, leave memory to others.
#[test]
fn unfinished_bodies_of_one_tenant_leave_room_for_others() {
    let file = KeyFile::new("unfinished", "");
    let (acme, bolt) = (file.key("acme", "render"), file.key("bolt", "render"));
    let service = file.serve(&["--memory-bytes", &(256 * MIB).to_string()]);
    let length = 16 * MIB as usize;
    let headers = [("Content-Type", "application/json"), ("Authorization", bolt.as_str())];
    let unfinished = &request("POST", "/v1/render", &headers, &vec![b' '; length])[..];
    let clients: Vec<_> = (0..12)
        .map(|_| {
            let mut client = service.connect();
            // One that is refused is cut off while it sends.
            _ = client.write_all(&unfinished[..unfinished.len() - 10]);
            client
        })
        .collect();
    let picture = keyed(&service, &acme, "POST", "/v1/render", &balls(60_000, 1));
    assert_eq!(picture.status, 200, "{}", picture.text());
    drop(clients);
}

/// A picture that fits, with layers that do not.
#[test]
fn layers_count_in_the_memory_of_a_request() {
    let bytes = 256 * MIB;
    let service = Service::start(&["--memory-bytes", &bytes.to_string()]);
    let render = |layers: &str| {
        let path = format!("/v1/render?width=1000&height=1000&samples=1&antialias=false&format=exr{layers}");
        service.post_json(&path, &balls(3, 0))
    };
    assert_eq!(render("").status, 200);
    let refused = render("&layers=distance,position,normal,albedo,object,material");
    assert!(refused.problem(413, "cost-limit").to_string().contains("memory_bytes"), "{}", refused.text());
    assert_eq!(render("&layers=distance").status, 200);
    let [most, _] = resident(&service);
    assert!(most < bytes * 11 / 10, "{} MiB", most / MIB);
}

#[test]
fn a_scene_that_never_fits_is_told_so() {
    let service = Service::start(&["--memory-bytes", &(128 * MIB).to_string()]);
    for path in ["/v1/render", "/v1/explain", "/v1/scenes"] {
        let problem = service.post_json(path, &balls(400_000, 0)).problem(413, "cost-limit");
        assert_eq!(problem["limit"]["name"], "memory_bytes", "{problem}");
    }
    assert_eq!(service.post_json("/v1/render", &balls(1_000, 0)).status, 200);
}

#[test]
fn kept_scenes_take_what_is_counted() {
    let (service, admin) = with_admin(&["--picture-cache-bytes", "0"]);
    service.post_json("/v1/render", &balls(2, 0));
    let [_, before] = resident(&service);
    for i in 1..4_000 {
        assert_eq!(service.post_json("/v1/render", &balls(2, i)).status, 200);
    }
    let [_, after] = resident(&service);
    let counted = number(&get(admin, "/metrics").text(), "strahl_cache_bytes{cache=\"scenes\"}");
    let grown = after.saturating_sub(before) as f64;
    assert!(grown < 1.3 * counted, "{grown} bytes, counted {counted}");
}

/// 80,000 rays, whose answers repeat a name of 256 bytes.
#[test]
fn answers_about_rays_grow_with_what_was_sent() {
    let service = Service::start(&["--memory-bytes", &(256 * MIB).to_string()]);
    let named = scene(&format!(r#"{{"sphere":{{"center":[0,0,0],"radius":1,"name":"{}"}}}}"#, "n".repeat(256)));
    let rays = [r#"{"origin":[0,0,5],"direction":[0,0,-1]}"#; 80_000].join(",");
    let body = format!(r#"{{"scene":{named},"rays":[{rays}]}}"#);
    let answer = service.post_json("/v1/rays", &body);
    assert_eq!(answer.json()["answers"].as_array().map(Vec::len), Some(80_000));
    assert!(answer.body.len() < 100 * body.len());
    assert!(resident(&service)[0] < 256 * MIB);
}

/// A thousand glass balls in a row: a small scene with a large tree.
#[test]
fn a_large_tree_is_sent_as_it_is_written() {
    let service = Service::start(&["--memory-bytes", &(192 * MIB).to_string()]);
    let ball = |i: i32| json!({ "sphere": { "center": [0, 0, -3 * i], "radius": 1, "material": "glass" } });
    let glass = json!({
        "version": 1, "image": { "width": 8, "height": 8 },
        "camera": { "pinhole": { "eye": [0, 0.1, 5], "look_at": [0, 0.1, 0] } },
        "materials": { "glass": { "transmission": 0.9, "reflection": 0.9, "ior": 1.1 } },
        "objects": (0..40).map(ball).collect::<Vec<_>>(),
        "render": { "max_depth": 60, "min_weight": 0, "antialias": false, "accuracy": { "fixed": {} } },
    });
    for (format, end) in [("json", "]}"), ("svg", "</svg>\n"), ("dot", "}\n")] {
        let answer = service.post_json(&format!("/v1/tree?x=4&y=4&format={format}"), &glass.to_string());
        assert_eq!(answer.status, 200);
        // It comes in chunks.
        assert!(answer.text().trim_end().ends_with(&format!("{end}\r\n0")), "{}", answer.body.len());
        assert!(answer.body.len() > 5_000_000, "{} bytes", answer.body.len());
    }
    assert!(resident(&service)[0] < 192 * MIB, "{} MiB", resident(&service)[0] / MIB);
}

/// A few pixels of nested glass between mirrors, whose rays have almost no end: each would be deferred until it is needed.
#[test]
fn rays_that_a_proof_defers_take_little_memory() {
    let service = Service::start(&["--memory-bytes", &(256 * MIB).to_string()]);
    let ball =
        |i: i32| json!({ "sphere": { "center": [0, 0, 0], "radius": 1.0 + 0.1 * f64::from(i), "material": "glass" } });
    let mirror = |z: i32| json!({ "plane": { "point": [0, 0, z], "normal": [0, 0, -z], "material": "mirror" } });
    let glass = json!({
        "version": 1, "image": { "width": 8, "height": 8 }, "background": 0.5, "ambient": 0.3,
        "camera": { "pinhole": { "eye": [0.3, 0.2, 6], "look_at": [0, 0, 0], "vfov_deg": 30 } },
        "lights": [{ "point": { "position": [0, 5, 5] } }],
        "materials": {
            "glass": { "transmission": 0.5, "reflection": 0.5, "ior": 1.5 },
            "mirror": { "reflection": 0.98, "diffuse": 0.02 }
        },
        "objects": (0..5).map(ball).chain([mirror(-8), mirror(8)]).collect::<Vec<_>>(),
        "render": { "max_depth": 1_000, "accuracy": { "proved": { "max_codes": 0 } }, "antialias": false }
    });
    assert_eq!(service.post_json("/v1/render", &glass.to_string()).status, 200);
    assert!(resident(&service)[0] < 128 * MIB, "{} MiB", resident(&service)[0] / MIB);
}

/// Pictures of 18 MB in a folder, for clients that do not read them.
#[test]
fn pictures_that_are_read_from_disk_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = 256 * MIB;
    let flags = ["--memory-bytes", &bytes.to_string(), "--picture-cache-bytes", "0", "--cache"];
    let service = Service::start(&[&flags[..], &[folder.path().to_str().unwrap()]].concat());
    let path = "/v1/render?width=1500&height=1000&antialias=false&format=pfm";
    let all: Vec<String> = (0..24).map(|i| balls(2, i)).collect();
    for scene in &all {
        assert_eq!(service.post_json(path, scene).status, 200);
    }
    let waiting: Vec<_> = all.iter().map(|scene| service.begin(path, scene)).collect();
    service.wait_for(0, 0);
    thread::sleep(Duration::from_secs(2));
    let [most, _] = resident(&service);
    assert!(most < bytes * 11 / 10, "{} MiB", most / MIB);
    drop(waiting);
}
