//! One tenant sends what takes for ever; the other one renders small pictures, and is answered. `tests/external/hostile.py` has
//! many more such requests, and the times that are promised; here nobody waits for the end of another's request.

use super::access::KeyFile;
use super::fairness::Tenant;
use crate::common::service::{NO_TIMEOUT, PATIENCE, Service, request};
use crate::common::{BALL, SLOW};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Value, json};
use std::io::Write;
use std::time::{Duration, Instant};

/// How long each request goes on.
const MEANWHILE: Duration = Duration::from_secs(1);

/// A scene's text: a picture of this size, objects, and whatever else it has.
fn scene(size: [u32; 2], objects: Value, others: Value) -> String {
    let mut scene = json!({ "version": 1, "image": { "width": size[0], "height": size[1] }, "objects": objects,
        "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } } });
    scene.as_object_mut().unwrap().extend(others.as_object().unwrap().clone());
    scene.to_string()
}

/// 2^31 balls at one place, in a corner that no pilot looks at.
fn instances() -> String {
    let turned = |of: u32, angle: i64| json!({ "instance": { "of": format!("d{of}"), "transform": { "rotate_deg": { "axis": [1, 2, 3], "angle": angle } } } });
    let doubled = |i: u32| (format!("d{i}"), json!([turned(i - 1, i64::from(i)), turned(i - 1, -i64::from(i))]));
    let mut definitions: serde_json::Map<_, _> = (1..32).map(doubled).collect();
    definitions.insert("d0".into(), json!([{ "sphere": { "center": [0, 0, 0], "radius": 1 } }]));
    let corner = json!([{ "instance": { "of": "d31", "transform": { "scale": 0.004, "translate": [3.2, 1.8, 0] } } }]);
    scene([960, 540], corner, json!({ "definitions": definitions }))
}

/// Glass balls around one pixel, whose tree of rays has no end.
fn one_pixel() -> String {
    let at = |i: u32| f64::from(i) - 4.0;
    let ball = |i: u32| json!({ "sphere": { "center": [at(i % 9), at(i / 9 % 9), at(i / 81)], "radius": 0.45, "material": "glass" } });
    let glass = json!({ "diffuse": 0, "reflection": 0.5, "transmission": 0.5, "ior": 1.5 });
    let render = json!({ "max_depth": 100_000, "min_weight": 0, "samples": 1024, "antialias": false });
    scene([1, 1], (0..729).map(ball).collect(), json!({ "materials": { "glass": glass }, "render": render }))
}

/// A thousand lights in a room of mirrors.
fn lights() -> String {
    let light = |i: u32| json!({ "point": { "position": [f64::from(i) / 500.0 - 1.0, 0.5, 2.0], "intensity": 0.01 } });
    let room = json!([{ "box": { "min": [-6, -6, -6], "max": [6, 6, 6], "hollow": true, "material": "mirror" } }]);
    let mirror = json!({ "mirror": { "diffuse": 0.1, "reflection": 0.9 } });
    let lights: Vec<_> = (0..1_000).map(light).collect();
    scene([250, 250], room, json!({ "materials": mirror, "lights": lights, "render": { "samples": 1024 } }))
}

/// A thousand rings that turn a hundred times while the shutter is open.
fn motion() -> String {
    let ring = json!({ "torus": { "center": [0, 0, 0], "major_radius": 1, "minor_radius": 0.3 } });
    let turn = |i: u32| json!({ "rotate_deg": { "axis": [1, i % 7, i % 11], "angle": 36_000 } });
    let turning = |i: u32| json!({ "group": { "objects": [ring], "motion": turn(i) } });
    scene([200, 200], (0..1_000).map(turning).collect(), json!({ "render": { "samples": 1024 } }))
}

/// 1.9 million equal balls in 37 kB.
fn packed_balls() -> Vec<u8> {
    let view = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 512 512\nf 1 1 1 .5 .5 9 .5 1.5\n";
    let mut packer = GzEncoder::new(Vec::new(), Compression::default());
    packer.write_all(view.as_bytes()).unwrap();
    packer.write_all(&b"s 0 0 0 1\n".repeat(1_900_000)).unwrap();
    packer.finish().unwrap()
}

/// Renders small pictures all the time, each another one, and sees that all are answered.
fn renders_meanwhile(tenant: &Tenant<'_>, beside: &str) {
    let begun = Instant::now();
    for number in 0.. {
        let path = format!("/v1/render?width=32&height=20&min_weight=0.0{number:06}");
        let answer = tenant.send("POST", &path, BALL);
        assert_eq!(answer.status, 200, "beside {beside}: {}", answer.text());
        if begun.elapsed() > MEANWHILE {
            return;
        }
    }
}

#[test]
fn no_request_holds_up_another_tenant() {
    let file = KeyFile::new("neighbours", "");
    let keys = [file.key("acme", "render"), file.key("bolt", "render")];
    let json = ("Content-Type", "application/json");
    let of = |text: String| (vec![json], text.into_bytes());
    for (name, (headers, body)) in [
        ("instances", of(instances())),
        ("one pixel", of(one_pixel())),
        ("lights", of(lights())),
        ("motion", of(motion())),
        ("packed balls", (vec![("Content-Type", "text/x-nff"), ("Content-Encoding", "gzip")], packed_balls())),
    ] {
        let service = file.serve(&NO_TIMEOUT);
        let mut hostile = service.connect();
        let headers = [&headers[..], &[("Authorization", &keys[0])]].concat();
        hostile.write_all(&request("POST", "/v1/render", &headers, &body)).unwrap();
        renders_meanwhile(&Tenant { service: &service, key: &keys[1] }, name);
        drop(hostile);
        service.wait_for(0, 0);
    }
}

#[test]
fn no_job_holds_up_another_tenant_or_its_own_end() {
    let file = KeyFile::new("neighbours_jobs", "");
    let keys = [file.key("acme", "jobs,read"), file.key("bolt", "render")];
    let mut begun = 0;
    for (name, text) in [
        ("a slow picture", SLOW.to_owned()),
        ("instances", instances()),
        ("one pixel", one_pixel()),
        ("lights", lights()),
        ("motion", motion()),
    ] {
        let service: Service = file.serve(&NO_TIMEOUT);
        let [acme, bolt] = [0, 1].map(|i| Tenant { service: &service, key: &keys[i] });
        for (method, suffix) in [("POST", "/cancel"), ("DELETE", "")] {
            let job = acme.send("POST", "/v1/jobs", &format!(r#"{{"scene": {text}}}"#));
            // It may also be too much for any job.
            assert!([202, 413].contains(&job.status), "{name}: {}", job.text());
            if job.status == 413 {
                continue;
            }
            begun += 1;
            renders_meanwhile(&bolt, name);
            let answer = acme.send(method, &format!("{}{suffix}", job.header("location")), "");
            assert!((200..300).contains(&answer.status), "{name}: {}", answer.text());
            let ended = Instant::now();
            while acme.send("GET", "/v1/jobs?state=running", "").json()["jobs"] != json!([]) {
                assert!(ended.elapsed() < PATIENCE, "{name} goes on");
            }
        }
    }
    assert!(begun >= 4, "only {begun} jobs were accepted: the test sees nothing");
}
