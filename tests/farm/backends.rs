//! Whoever renders the tiles, the picture is the same.

use crate::common::BALL;
use crate::common::service::Service;
use crate::harness::{Ear, Farm, job, wait_until};

/// Mirrors face to face: a few seconds of one thread.
pub(crate) const MIRRORS: &str = r#"{
  "version": 1,
  "image": { "width": 400, "height": 300 },
  "camera": { "pinhole": { "eye": [0, 0, 0], "look_at": [0.3, 0.1, -1], "vfov_deg": 50 } },
  "materials": {
    "mirror": { "diffuse": 0, "reflection": 1 },
    "red": { "diffuse": [0.8, 0.2, 0.1], "specular": 0.5, "reflection": 0.2 }
  },
  "objects": [
    { "plane": { "point": [0, 0, -1], "normal": [0, 0, 1], "material": "mirror" } },
    { "plane": { "point": [0, 0, 1], "normal": [0, 0, -1], "material": "mirror" } },
    { "sphere": { "center": [0.4, 0.1, -0.7], "radius": 0.2, "material": "red" } }
  ],
  "render": { "max_depth": 60, "min_weight": 0, "samples": 4, "antialias": false }
}"#;

/// The picture of a job as one machine renders it.
pub(crate) fn alone(members: &str, scene: &str) -> Vec<u8> {
    let service = Service::start(&["--threads", "2"]);
    let answer = service.post_json("/v1/jobs", &job(members, scene));
    assert_eq!(answer.status, 202, "{}", answer.text());
    let job = answer.header("location").to_owned();
    loop {
        let state = service.get(&job).json()["state"].as_str().unwrap().to_owned();
        match state.as_str() {
            "queued" | "running" => std::thread::sleep(std::time::Duration::from_millis(10)),
            "succeeded" => return service.get(&format!("{job}/image")).body,
            other => panic!("{other}: {}", service.get(&job).text()),
        }
    }
}

/// T16, and the least that a farm has to do.
#[test]
fn two_nodes_make_the_picture_that_one_machine_makes() {
    let Some(farm) = Farm::start(&[]) else { return };
    let nodes = ["one", "two"].map(|name| farm.node(name));
    let large = r#""settings": { "width": 700, "height": 500, "antialias": true }"#;
    for (scene, members) in [(MIRRORS, ""), (BALL, r#""output": { "format": "exr" }"#), (BALL, large)] {
        let id = farm.submit(members, scene);
        assert!(farm.picture(&id).body == alone(members, scene), "another picture: {members}\n{}", nodes[0].log());
    }
    assert_eq!(farm.broker.messages("FARM_T"), 0, "work is left behind");
    let rendered = |log: String| log.contains("ERROR");
    assert!(!nodes.iter().any(|node| rendered(node.log())), "{}", nodes[0].log());
}

/// Pictures that somebody waits for, and tiles of viewers.
#[test]
fn what_takes_long_is_spread_over_nodes_and_stays_the_same() {
    let Some(farm) = Farm::start(&["--spread", "20"]) else { return };
    let begun = Ear::at(&farm.broker, "farm.b.>");
    let here = farm.front.post_json("/v1/render", BALL);
    assert_eq!((here.status, begun.heard().len()), (200, 0), "a quick one is rendered by the front");
    // Without nodes the front helps itself.
    let alone = Service::start(&[]);
    let expected = alone.post_json("/v1/render", MIRRORS);
    let scenes =
        ["/v1/render/tile?x=100&y=50&w=200&h=150", "/v1/render?width=500&height=400&format=png&bits=16", "/v1/render"];
    let _nodes = ["one", "two"].map(|name| farm.node(name));
    wait_until("the front knows its nodes", || farm.nodes().len() == 2);
    for path in scenes {
        let before = begun.heard().len();
        let [spread, alone] = [&farm.front, &alone].map(|service| service.post_json(path, MIRRORS));
        assert_eq!(spread.status, 200, "{}", spread.text());
        assert!(spread.body == alone.body, "another picture: {path}");
        assert!(begun.heard().len() > before, "{path} was not spread");
    }
    assert!(farm.front.post_json("/v1/render", MIRRORS).body == expected.body);
    assert_eq!(farm.broker.messages("FARM_T"), 0);
}
