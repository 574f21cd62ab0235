//! A scene that is asked for again is not built again, and nobody can tell but by the time.

use super::operations::{get, number, with_admin};
use crate::common::BALL;
use crate::common::service::{Answer, Service};

/// Whether the answer's scene was there already: `hit` or `miss`.
fn scene(answer: &Answer) -> &str {
    assert_eq!(answer.status, 200, "{}", answer.text());
    let timing = answer.header("server-timing");
    timing.split(", ").find_map(|metric| metric.strip_prefix("scene;desc=")).unwrap_or_else(|| panic!("{timing}"))
}

/// A client that has the canonical text is not sent it again.
#[test]
fn the_text_of_a_scene_is_sent_once() {
    let service = Service::start(&[]);
    let path = format!("/v1/scenes/{}", service.post_json("/v1/scenes", BALL).json()["scene_id"].as_str().unwrap());
    let etag = service.get(&path).header("etag").to_owned();
    let again = service.send("GET", &path, &[("If-None-Match", &etag)], b"");
    assert_eq!((again.status, again.body.len(), again.header("etag")), (304, 0, etag.as_str()));
    assert_eq!(service.send("GET", &path, &[("If-None-Match", "\"other\"")], b"").status, 200);
}

#[test]
fn the_second_request_gets_the_same_bytes_without_building() {
    let service = Service::start(&[]);
    let first = service.post_json("/v1/render", BALL);
    let second = service.post_json("/v1/render", BALL);
    assert_eq!((scene(&first), scene(&second)), ("miss", "hit"));
    assert_eq!(first.body, second.body);
    assert!(second.header("server-timing").contains("picture;desc=hit"), "{}", second.header("server-timing"));
    let other = service.post_json("/v1/render?bits=16", BALL);
    for phase in ["plan;dur=0.000", "bvh;dur=0.000"] {
        assert!(other.header("server-timing").contains(phase), "{}", other.header("server-timing"));
    }
    for name in ["render-rays", "render-plan", "content-type"] {
        assert_eq!(first.header(name), second.header(name));
    }
    assert_eq!(
        scene(&service.post_json("/v1/render/tile?x=1&y=2&w=3&h=4", BALL)),
        "hit",
        "tiles are of the same scene"
    );
    assert_eq!(scene(&other), "hit", "so are other formats");
}

/// Width and height are known when the scene has been read, so nothing is built for a picture that is refused.
#[test]
fn a_picture_that_is_too_large_is_refused_before_its_scene_is_built() {
    let (service, admin) = with_admin(&["--job-max-pixels", "1000000"]);
    let built = || number(&get(admin, "/metrics").text(), "strahl_cache_bytes{cache=\"scenes\"}");
    let json = [("Content-Type", "application/json")];
    for (path, limit) in [
        ("/v1/render?width=16000&height=4000", "max_pixels"),
        ("/v1/render?width=2000&height=2000&samples=100", "max_samples_total"),
        ("/v1/render/tile?width=16000&height=4000&x=0&y=0&w=16000&h=4000", "max_pixels"),
        ("/v1/map?width=16000&height=4000", "max_pixels"),
        ("/v1/explain?analyze=true&width=16000&height=4000", "max_pixels"),
    ] {
        let problem = service.send("POST", path, &json, BALL.as_bytes()).problem(413, "cost-limit");
        assert_eq!(problem["limit"]["name"], limit, "{path}");
        assert_eq!(built(), 0.0, "{path}");
    }
    let job = format!(r#"{{ "scene": {BALL}, "settings": {{ "width": 2000, "height": 2000 }} }}"#);
    let problem = service.send("POST", "/v1/jobs", &json, job.as_bytes()).problem(413, "cost-limit");
    assert_eq!((&problem["limit"]["name"], built()), (&"job_max_pixels".into(), 0.0));
    let wrong = BALL.replace("0.8", "-0.8");
    service.send("POST", "/v1/render?width=16000&height=4000", &json, wrong.as_bytes()).problem(422, "invalid-scene");
    assert_eq!(service.post_json("/v1/render", BALL).status, 200);
    assert!(built() > 0.0);
}

#[test]
fn other_options_and_other_bytes_are_other_scenes() {
    let service = Service::start(&[]);
    service.post_json("/v1/render", BALL);
    for query in ["width=24", "max_depth=3", "min_weight=0.5", "samples=2", "antialias=false", "precision=double"] {
        let path = format!("/v1/render?{query}");
        let [first, second] = [(); 2].map(|()| service.post_json(&path, BALL));
        assert_eq!((scene(&first), scene(&second)), ("miss", "hit"), "{query}");
        assert_eq!(first.body, second.body, "{query}");
    }
    assert_eq!(scene(&service.post_json("/v1/render", &BALL.replace("0.8", "0.7"))), "miss");
    assert_eq!(scene(&service.post_json("/v1/render", BALL)), "hit");
}

#[test]
fn kept_scenes_stay_within_their_bytes() {
    // Each takes between a half and the whole of the budget.
    let balls = |radius: f64| {
        let ball = |i: usize| format!(r#"{{ "sphere": {{ "center": [{i}, 0, 0], "radius": {radius} }} }}"#);
        let balls: Vec<_> = (0..2_000).map(ball).collect();
        format!(
            r#"{{ "version": 1, "image": {{ "width": 8, "height": 8 }},
                "camera": {{ "pinhole": {{ "eye": [0, 0, 5], "look_at": [0, 0, 0] }} }}, "objects": [{}] }}"#,
            balls.join(",")
        )
    };
    let (one, other) = (balls(0.25), balls(0.5));
    let service = Service::start(&["--scene-cache-bytes", "450000"]);
    let asked = [&one, &one, &other, &other, &one].map(|json| service.post_json("/v1/render", json));
    assert_eq!(asked.each_ref().map(scene), ["miss", "hit", "miss", "hit", "miss"]);
    assert_eq!((&asked[0].body, &asked[2].body), (&asked[4].body, &asked[3].body));
    assert_eq!(service.get("/v1/limits").json()["request"]["scene_cache_bytes"], 450_000);

    let service = Service::start(&["--scene-cache-bytes", "0"]);
    let asked = [(); 2].map(|()| service.post_json("/v1/render", BALL));
    assert_eq!(asked.each_ref().map(scene), ["miss", "miss"]);
}

#[test]
fn warnings_and_problems_are_said_again() {
    let service = Service::start(&[]);
    let glaring = BALL.replace(r#""reflection": 0.2"#, r#""reflection": 0.7, "transmission": 0.7"#);
    let [first, second] = [(); 2].map(|()| service.post_json("/v1/scenes/validate", &glaring).json());
    assert_eq!(first["warnings"].as_array().map(Vec::len), Some(1), "{first}");
    assert_eq!(first, second);
    assert_eq!(scene(&service.post_json("/v1/render", &glaring)), "hit", "validating has built it");

    let broken = BALL.replace(r#""material": "red""#, r#""material": "rot""#);
    let [first, second] = [(); 2].map(|()| service.post_json("/v1/render", &broken).problem(422, "invalid-scene"));
    assert_eq!(first["errors"], second["errors"]);

    // The rays' scene is a part of the body, and known without the rest.
    let rays = |rays: &str| format!(r#"{{"rays": [{rays}], "scene": {BALL}}}"#);
    let ray = r#"{"origin": [0, 1, 5], "direction": [0, 0, -1]}"#;
    let answers = |body: &str| service.post_json("/v1/rays", body).json()["answers"].clone();
    assert_eq!(answers(&rays(ray))[0], answers(&rays(&format!("{ray}, {ray}")))[1]);
}

/// A wall with a picture from a file.
pub(super) const WALL: &str = r#"{
  "version": 1,
  "image": { "width": 8, "height": 8 },
  "camera": { "orthographic": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "height": 2 } },
  "materials": { "wall": { "diffuse": { "image": { "source": "wall.png", "mapping": { "planar": { "axes": "xy" } } } } } },
  "objects": [{ "plane": { "point": [0, 0, 0], "normal": [0, 0, 1], "material": "wall" } }]
}"#;

#[test]
fn pictures_from_files_are_read_each_time() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("pictures_from_files_are_read_each_time");
    std::fs::create_dir_all(&folder).unwrap();
    let paint = |color: [u8; 3]| {
        image::RgbImage::from_fn(2, 2, |x, y| image::Rgb(if x + y == 0 { [0; 3] } else { color }))
            .save(folder.join("wall.png"))
            .unwrap();
    };
    let service = Service::start(&["--textures", folder.to_str().unwrap()]);
    paint([255, 0, 0]);
    let red = service.post_json("/v1/render", WALL);
    paint([0, 0, 255]);
    let blue = service.post_json("/v1/render", WALL);
    assert_eq!((scene(&red), scene(&blue)), ("miss", "miss"));
    assert_ne!(red.body, blue.body);

    let outside = WALL.replace("wall.png", "../wall.png");
    for (service, scene) in [(&service, outside.as_str()), (&Service::start(&[]), WALL)] {
        let problem = service.post_json("/v1/render", scene).problem(422, "invalid-scene");
        assert_eq!(problem["errors"][0]["pointer"], "#/materials/wall/diffuse/image/source");
    }
}
