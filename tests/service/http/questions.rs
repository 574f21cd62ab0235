//! Questions about pictures: maps of what is seen, plans of several settings, and what is asked about an image by its id.

use crate::common::BALL;
use crate::common::service::{Answer, Service};
use serde_json::{Value, json};

/// The numbers of a grey PFM, from the top, and its size.
fn numbers(answer: &Answer) -> ([usize; 2], Vec<f32>) {
    assert_eq!(answer.status, 200, "{}", answer.text());
    let mut lines = answer.body.splitn(4, |byte| *byte == b'\n');
    assert_eq!(lines.next(), Some(&b"Pf"[..]));
    let size = String::from_utf8(lines.next().unwrap().to_vec()).unwrap();
    let (width, height) = size.split_once(' ').unwrap();
    let size = [width.parse().unwrap(), height.parse().unwrap()];
    let floats: Vec<f32> =
        lines.nth(1).unwrap().as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    assert_eq!(floats.len(), size[0] * size[1]);
    (size, floats.chunks(size[0]).rev().flatten().copied().collect())
}

/// The number of each pixel.
fn unpacked(map: &Value) -> Vec<u64> {
    let runs = map["runs"].as_array().unwrap().iter();
    runs.flat_map(|run| vec![run[0].as_u64().unwrap(); run[1].as_u64().unwrap() as usize]).collect()
}

#[test]
fn a_map_of_objects_says_whose_surface_each_pixel_shows() {
    let service = Service::start(&[]);
    let map = service.post_json("/v1/map?of=object", BALL).json();
    let all = unpacked(&map);
    assert_eq!((all.len(), &map["columns"], &map["rows"], &map["step"]), (48 * 32, &48.into(), &32.into(), &1.into()));
    let pointers: Vec<&str> =
        map["objects"].as_array().unwrap().iter().map(|object| object["pointer"].as_str().unwrap()).collect();
    assert_eq!(
        {
            let mut sorted = pointers.clone();
            sorted.sort_unstable();
            sorted
        },
        ["/objects/0", "/objects/1"]
    );
    // The first ray of each pixel's tree hits the same.
    let plain = "antialias=false&samples=1";
    for [x, y] in [[24, 16], [0, 0], [3, 30], [20, 9]] {
        let tree = service.post_json(&format!("/v1/tree?x={x}&y={y}&{plain}"), BALL).json();
        let expected = tree["rays"][0]["hit"]["object"].as_str().unwrap_or_default();
        let number = all[y * 48 + x] as usize;
        let found = number.checked_sub(1).map_or("", |index| pointers[index]);
        assert_eq!(found, expected, "{x}, {y}");
    }
    let part = service.post_json("/v1/map?of=object&x=8&y=4&w=16&h=10", BALL).json();
    let names = |map: &Value| {
        let of = |number: u64| number.checked_sub(1).map(|index| map["objects"][index as usize]["pointer"].clone());
        unpacked(map).into_iter().map(of).collect::<Vec<_>>()
    };
    let crop: Vec<_> =
        (4..14).flat_map(|y| (8..24).map(move |x| y * 48 + x)).map(|at| names(&map)[at].clone()).collect();
    assert_eq!(names(&part), crop);
    let coarse = service.post_json("/v1/map?of=object&step=8&format=pfm", BALL);
    assert_eq!(numbers(&coarse).0, [6, 4]);
}

#[test]
fn a_map_of_distances_and_one_of_shares_hold_numbers() {
    let service = Service::start(&[]);
    let ([width, height], distances) = numbers(&service.post_json("/v1/map?of=distance", BALL));
    assert_eq!([width, height], [48, 32]);
    // The ball's nearest point is 4 away, and the sky is nowhere.
    let middle = distances[12 * 48 + 24];
    assert!((3.9..4.3).contains(&middle), "{middle}");
    assert_eq!(distances[0], f32::INFINITY);
    let (_, shares) = numbers(&service.post_json("/v1/map?of=share&pointer=/objects/0", BALL));
    assert!(shares[12 * 48 + 24] > 0.5 && shares[0] == 0.0 && shares.iter().all(|share| (0.0..=1.0).contains(share)));
    for refused in [
        "of=share",
        "of=share&pointer=/materials/red",
        "of=rays&x=0&y=0&w=1&h=1",
        "of=object&x=1",
        "of=object&format=png",
        "of=rays&format=json",
        "of=rays&pointer=/objects/0",
        "of=object&x=40&y=0&w=9&h=1",
        "of=share&pointer=/objects/7",
    ] {
        service.post_json(&format!("/v1/map?{refused}"), BALL).problem(400, "invalid-parameter");
    }
}

/// Whether two estimates expect the same rays. A pilot on a busy machine traces little in its time, so it may be asked for again.
fn are_near(mut estimates: impl FnMut() -> [Value; 2]) -> bool {
    (0..10).any(|_| {
        let [a, b] = estimates().map(|of| of["estimate"]["rays"].as_i64().unwrap());
        (a - b).abs() <= a / 20
    })
}

#[test]
fn several_settings_are_estimated_in_one_request() {
    let service = Service::start(&[]);
    let scene: Value = serde_json::from_str(BALL).unwrap();
    let settings = json!([{ "max_depth": 2 }, { "antialias": false }, { "accuracy": "proved:2" }, { "precision": "double" }, { "accuracy": "time:50" }]);
    let explained = |path: &str, body: &Value| {
        let answer = service.post_json(path, &body.to_string());
        assert_eq!(answer.status, 200, "{}", answer.text());
        answer.json()
    };
    let several = json!({ "scene": scene, "settings": settings });
    let answer = explained("/v1/explain", &several);
    assert!(answer["plan"]["effects"].is_array());
    let estimates = answer["estimates"].as_array().unwrap();
    assert_eq!(estimates.len(), 5);
    for (i, (own, estimate)) in settings.as_array().unwrap().iter().zip(estimates).take(4).enumerate() {
        assert_eq!(&estimate["settings"], own);
        let (key, value) = own.as_object().unwrap().iter().next().unwrap();
        let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let alone = || explained(&format!("/v1/explain?{key}={value}"), &scene);
        let both = || [explained("/v1/explain", &several)["estimates"][i].clone(), alone()];
        assert!(are_near(both), "{key}: {estimate}");
        assert_eq!(estimate["depth"], alone()["depth"], "{key}");
    }
    assert!(estimates[4]["image_id"].is_null() && estimates[1]["image_id"].is_string(), "a time has no id");
    let base = service.post_json("/v1/scenes", BALL).json()["scene_id"].clone();
    let varied = json!({ "scene": { "base": base, "patch": {} }, "settings": [{ "max_depth": 2 }] });
    let both = || [&varied, &several].map(|question| explained("/v1/explain", question)["estimates"][0].clone());
    assert!(are_near(both), "{varied}");

    let refused = |settings: Value, query: &str| {
        let body = json!({ "scene": scene, "settings": settings }).to_string();
        service.post_json(&format!("/v1/explain{query}"), &body)
    };
    refused(json!(vec![json!({}); 33]), "").problem(422, "invalid-request");
    refused(json!([{}]), "?analyze=true").problem(422, "invalid-request");
    refused(json!([{ "max_dept": 1 }]), "").problem(400, "invalid-parameter");
    let wrong = json!({ "scene": { "version": 1 }, "settings": [] }).to_string();
    let problem = service.post_json("/v1/explain", &wrong).problem(422, "invalid-scene");
    assert_eq!(problem["errors"][0]["pointer"], "#/scene");
}

#[test]
fn an_image_is_asked_about_by_its_id_in_the_pixels_of_its_zoom() {
    let service = Service::start(&[]);
    let image = |zoom: u32| {
        service.post_json(&format!("/v1/scenes?zoom={zoom}"), BALL).json()["image_id"].as_str().unwrap().to_owned()
    };
    let (whole, large) = (image(0), image(3));
    let tree = |path: &str| {
        let mut tree = service.get(path).json();
        tree["trace_ms"] = Value::Null;
        tree
    };
    let sent = service.post_json("/v1/tree?x=20&y=10", BALL).json();
    assert_eq!(tree(&format!("/v1/images/{whole}/tree?x=20&y=10"))["rays"], sent["rays"]);
    // The large picture's rays are those of the scene in that size.
    let resized = BALL.replace("48", "384").replace("32", "256");
    let sent = service.post_json("/v1/tree?x=171&y=93", &resized).json();
    assert_eq!(tree(&format!("/v1/images/{large}/tree?x=171&y=93"))["rays"], sent["rays"]);
    let map = |path: &str| service.get(path);
    let sent = service.post_json("/v1/map?of=object&x=160&y=80&w=64&h=32", &resized).json();
    assert_eq!(map(&format!("/v1/images/{large}/map?of=object&x=160&y=80&w=64&h=32")).json(), sent);
    let sent = service.post_json("/v1/map?of=rays&format=pfm", BALL);
    assert!(map(&format!("/v1/images/{whole}/map?of=rays&format=pfm")).body == sent.body);
    let plan = service.get(&format!("/v1/images/{large}/explain")).json();
    assert!(plan["estimate"]["rays"].as_u64().unwrap() > 384 * 256, "{plan}");

    let huge = image(12);
    for path in ["map", "map?of=object", "explain?analyze=true"] {
        service.get(&format!("/v1/images/{huge}/{path}")).problem(413, "cost-limit");
    }
    let links = &service.post_json("/v1/scenes?zoom=12", BALL).json()["links"];
    assert_eq!(service.get(links["image"].as_str().unwrap()).picture().width(), 1_024, "{links}");
    // A plan takes a pilot, whatever the picture takes.
    assert_eq!(service.get(&format!("/v1/images/{huge}/explain")).status, 200);
    let deepest = BALL.replacen('{', r#"{ "render": { "precision": "double" },"#, 1);
    let deepest = service.post_json("/v1/scenes?zoom=16", &deepest).json();
    let plan = service.get(&format!("/v1/images/{}/explain", deepest["image_id"].as_str().unwrap())).json();
    assert!(plan["estimate"]["rays"].as_u64() > Some((48 << 16) * (32 << 16)), "{plan}");
    assert_eq!(service.get(&format!("/v1/images/{huge}/tree?x=100000&y=60000")).status, 200);
    service.get(&format!("/v1/images/{whole}/tree?x=48&y=0")).problem(400, "invalid-parameter");
    service.get(&format!("/v1/images/{whole}/tree?x=0&y=0&format=overlay")).problem(400, "invalid-parameter");
    service.get("/v1/images/i_a/tree?x=0&y=0").problem(404, "not-found");
    let unknown = whole.replace(&whole[2..10], "aaaaaaaa");
    for path in ["tree?x=0&y=0", "map", "explain"] {
        service.get(&format!("/v1/images/{unknown}/{path}")).problem(404, "not-found");
    }
}

/// What a model's file says and its scene does not is told with each answer about the scene, also by the id of its image.
#[test]
fn answers_about_a_scene_have_its_warnings() {
    let service = Service::start(&[]);
    let mut scene: Value = serde_json::from_str(BALL).unwrap();
    scene["import_warnings"] = json!([{ "code": "not-simulated", "detail": "not-simulated: sheen" }]);
    let text = scene.to_string();
    let expected = r#""not-simulated: sheen""#;
    for question in ["render", "map", "map?of=object", "tree?x=1&y=1", "tree?x=1&y=1&format=overlay"] {
        let answer = service.post_json(&format!("/v1/{question}"), &text);
        assert_eq!((answer.status, answer.header("render-warnings")), (200, expected), "{question}");
    }
    let rays = json!({ "scene": scene, "rays": [{ "origin": [0, 1, 5], "direction": [0, 0, -1] }] });
    let plain: Value = serde_json::from_str(BALL).unwrap();
    // Each once, from either picture.
    let same = json!({ "a": { "scene": scene }, "b": { "scene": scene, "settings": { "samples": 2 } } });
    let other = json!({ "a": { "scene": plain }, "b": { "scene": scene } });
    for (question, body) in [("rays", &rays), ("compare", &same), ("compare", &other), ("compare?format=png", &other)] {
        let answer = service.post_json(&format!("/v1/{question}"), &body.to_string());
        assert_eq!((answer.status, answer.header("render-warnings")), (200, expected), "{question}");
    }
    let image = service.post_json("/v1/scenes", &text).json()["image_id"].as_str().unwrap().to_owned();
    for question in ["map", "tree?x=1&y=1"] {
        let answer = service.get(&format!("/v1/images/{image}/{question}"));
        assert_eq!((answer.status, answer.header("render-warnings")), (200, expected), "{question}");
    }
    let silent = service.post_json("/v1/map", BALL);
    assert_eq!((silent.status, silent.header("render-warnings")), (200, ""));
}
