//! Comparing pictures.

use crate::common::service::{Answer, NO_TIMEOUT, Service};
use crate::common::{BALL, SLOW};
use serde_json::{Value, json};

fn scene() -> Value {
    serde_json::from_str(BALL).unwrap()
}

fn compare(service: &Service, query: &str, a: &Value, b: &Value) -> Answer {
    service.post_json(&format!("/v1/compare{query}"), &json!({ "a": a, "b": b }).to_string())
}

#[test]
fn two_pictures_are_compared_by_id_or_by_scene() {
    let service = Service::start(&[]);
    let stored = service.post_json("/v1/scenes", BALL).json();
    let (plain, smooth) =
        (json!({ "scene": scene(), "settings": { "antialias": false } }), json!({ "scene": scene() }));
    let by_id = json!({ "image": stored["image_id"] });
    let varied = json!({ "scene": { "base": stored["scene_id"], "patch": {} } });
    let same = compare(&service, "", &smooth, &by_id).json();
    assert_eq!(
        (&same["same"], &same["codes"]["identical"], &same["rms_codes"]),
        (&true.into(), &1.0.into(), &0.0.into())
    );
    assert_eq!((&same["a"], &same["b"], &same["width"]), (&stored["image_id"], &stored["image_id"], &48.into()));
    assert_eq!(compare(&service, "", &varied, &by_id).json()["same"], true);

    let other = compare(&service, "", &smooth, &plain).json();
    assert_eq!(other["same"], false);
    // The pictures say the same.
    let [a, b] = ["", "?antialias=false"].map(|query| service.post_json(&format!("/v1/render{query}"), BALL).picture());
    let (a, b) = (a.to_rgb8(), b.to_rgb8());
    let worst = |(a, b): (&image::Rgb<u8>, &image::Rgb<u8>)| (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap();
    let errors: Vec<u8> = a.pixels().zip(b.pixels()).map(worst).collect();
    let identical = errors.iter().filter(|error| **error == 0).count() as f64 / errors.len() as f64;
    assert_eq!(other["codes"]["error"]["max"], f64::from(*errors.iter().max().unwrap()));
    assert_eq!(other["codes"]["identical"], identical);
    assert!(other["flip"]["mean"].as_f64().is_some_and(|mean| mean > 0.0 && mean < 0.2), "{other}");

    let drawn = compare(&service, "?format=png&gain=1", &smooth, &plain).picture().to_rgb8();
    let most = drawn.pixels().flat_map(|pixel| pixel.0).max().unwrap();
    assert_eq!(most, *errors.iter().max().unwrap());
    let light = compare(&service, "?format=pfm", &smooth, &smooth);
    assert!(light.body.starts_with(b"PF\n48 32\n") && light.body[14..].iter().all(|byte| *byte == 0));
    let flip = compare(&service, "?format=flip", &smooth, &plain);
    assert!(flip.body.starts_with(b"Pf\n48 32\n") && flip.body.len() == 14 + 4 * 48 * 32, "{}", flip.body.len());
}

#[test]
fn pictures_with_alpha_are_compared_with_it() {
    let service = Service::start(&[]);
    let clear = |color: Value| {
        let mut scene = scene();
        scene["film"] = json!({ "background": "transparent" });
        scene["background"] = color;
        json!({ "scene": scene })
    };
    let answer = compare(&service, "", &clear(json!(0)), &clear(json!([0, 0, 1]))).json();
    assert!(answer["width"] == 48 && answer["codes"]["error"]["max"].is_f64(), "{answer}");

    // Black before nothing: only alpha tells one from the other.
    let black = |radius: f64| {
        let mut scene = scene();
        scene["film"] = json!({ "background": "transparent" });
        (scene["lights"], scene["background"]) = (json!([]), json!(0));
        scene["materials"] = json!({ "black": { "ambient": 0, "diffuse": 0 } });
        scene["objects"] = json!([{ "sphere": { "center": [0, 0, 0], "radius": radius, "material": "black" } }]);
        json!({ "scene": scene })
    };
    let answer = compare(&service, "", &black(1.0), &black(0.5)).json();
    assert!(answer["codes"]["error"]["max"] == 255.0 && answer["same"] == false, "{answer}");
    assert!(answer["flip"]["max"].as_f64() > Some(0.5) && answer["ciede2000"]["max"].as_f64() > Some(50.0), "{answer}");
    let drawn = compare(&service, "?format=png&gain=1", &black(1.0), &black(0.5)).picture().to_rgb8();
    assert!(drawn.pixels().any(|pixel| pixel.0 == [255; 3]));
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let service = Service::start(&["--max-pixels", "100000"]);
    let (ball, small) = (json!({ "scene": scene() }), json!({ "scene": scene(), "settings": { "width": 20 } }));
    let sizes = compare(&service, "", &ball, &small).problem(400, "invalid-parameter");
    assert!(sizes["detail"].as_str().unwrap().contains("48 x 32 and 20 x 32"), "{sizes}");
    let image = "i_aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa_aaaaaa_a";
    compare(&service, "", &ball, &json!({ "image": image })).problem(404, "not-found");
    for side in
        [json!({}), json!({ "image": image, "scene": scene() }), json!({ "scene": scene(), "image": null, "x": 1 })]
    {
        compare(&service, "", &ball, &side).problem(422, "invalid-request");
    }
    let mut wrong = scene();
    wrong["objects"][0]["sphere"]["radius"] = json!(-1);
    let problem = compare(&service, "", &ball, &json!({ "scene": wrong })).problem(422, "invalid-scene");
    assert_eq!(problem["errors"][0]["pointer"], "#/b/scene/objects/0/sphere/radius");
    compare(&service, "", &ball, &json!({ "scene": scene(), "settings": { "width": 4000 } }))
        .problem(413, "cost-limit");
    compare(&service, "?gain=0&format=png", &ball, &ball).problem(400, "invalid-parameter");
    compare(&service, "", &ball, &json!({ "scene": scene(), "settings": { "widht": 4 } }))
        .problem(400, "invalid-parameter");
}

/// Neither picture would ever be finished.
#[test]
fn nothing_is_rendered_of_pictures_that_cannot_be_compared() {
    let service = Service::start(&["--max-pixels", "5000000", "--memory-bytes", "1000000000"]);
    let slow: Value = serde_json::from_str(SLOW).unwrap();
    let sized = |width: u32, height: u32| json!({ "scene": slow, "settings": { "width": width, "height": height } });
    compare(&service, "", &sized(2000, 2000), &sized(2000, 2001)).problem(400, "invalid-parameter");
    compare(&service, "?format=png", &sized(2000, 2000), &sized(3000, 2000)).problem(413, "cost-limit");
    for (query, limit) in [("?format=flip", "flip_pixels"), ("", "memory_bytes")] {
        let size = if limit == "flip_pixels" { sized(2200, 2000) } else { sized(2000, 2000) };
        let problem = compare(&service, query, &size, &size).problem(413, "cost-limit");
        assert_eq!(problem["limit"]["name"], limit, "{problem}");
    }
}

#[test]
fn a_client_that_goes_away_stops_its_comparison() {
    let service = Service::start(&NO_TIMEOUT);
    let slow: Value = serde_json::from_str(SLOW).unwrap();
    let client = service.begin("/v1/compare", &json!({ "a": { "scene": slow }, "b": { "scene": slow } }).to_string());
    service.wait_for(1, 0);
    drop(client);
    service.wait_for(0, 0);
}
