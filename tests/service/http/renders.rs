//! Requests that succeed.

use crate::common::BALL;
use crate::common::service::Service;
use flate2::{Compression, write::GzEncoder};
use image::GenericImageView;
use std::io::Write;

const NFF: &str = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 16 16\nb 0.1 0.2 0.3\n\
                   l 3 3 3\nf 1 0.5 0.2 0.8 0.2 10 0 1\ns 0 0 0 1\n";

/// What curl sends with --data-binary, and what a client sends that says nothing.
#[test]
fn json_needs_no_content_type() {
    let service = Service::start(&[]);
    let whole = service.post_json("/v1/render", BALL);
    for headers in [&[][..], &[("Content-Type", "application/x-www-form-urlencoded")]] {
        let answer = service.send("POST", "/v1/render", headers, BALL.as_bytes());
        assert_eq!((answer.status, &answer.body), (200, &whole.body), "{headers:?}");
        let job = format!(r#"{{ "scene": {BALL} }}"#);
        assert_eq!(service.send("POST", "/v1/jobs", headers, job.as_bytes()).status, 202, "{headers:?}");
    }
}

#[test]
fn a_scene_becomes_a_picture_and_says_what_it_cost() {
    let service = Service::start(&[]);
    let answer = service.post_json("/v1/render", BALL);
    assert_eq!(answer.picture().dimensions(), (48, 32));
    for phase in ["queue;dur=", "parse;dur=", "plan;dur=", "bvh;dur=", "trace;dur=", "png;dur=", "refine;dur="] {
        assert!(answer.header("server-timing").contains(phase), "{phase} in {}", answer.header("server-timing"));
    }
    for kind in ["camera=", "shadow=", "reflected=", "transmitted="] {
        assert!(answer.header("render-rays").contains(kind), "{kind} in {}", answer.header("render-rays"));
    }
    assert!(answer.headers.iter().any(|(name, _)| name == "render-plan"));
    assert_eq!(answer.header("x-content-type-options"), "nosniff");
    assert!(answer.header("content-disposition").starts_with("inline"));
    assert!(!answer.header("x-request-id").is_empty());
    let again = service.send(
        "POST",
        "/v1/render",
        &[("Content-Type", "application/json"), ("X-Request-Id", "mine-1")],
        BALL.as_bytes(),
    );
    assert_eq!(again.body, answer.body, "the same scene gives the same bytes");
    assert_eq!(again.header("x-request-id"), "mine-1");
    service.wait_for_log("request=mine-1");
}

#[test]
fn an_exr_has_the_layers_that_are_asked_for() {
    let service = Service::start(&[]);
    let post = |query: &str| service.post_json(&format!("/v1/render{query}"), BALL);
    let has = |body: &[u8], text: &str| body.windows(text.len()).any(|part| part == text.as_bytes());
    let plain = post("?format=exr");
    let some = post("?format=exr&layers=distance,object");
    assert_eq!((plain.status, some.status), (200, 200), "{}", some.text());
    assert!(!has(&plain.body, "Z\0\u{2}\0") && has(&some.body, "Z\0\u{2}\0") && has(&some.body, "crypto_object00.R\0"));
    assert!(has(&some.body, "\"/objects/0\":\"0e0349e6\""));
    // Other layers are another file.
    let more = post("?format=exr&layers=object,distance,share:/objects/0");
    let tags = [&plain, &some, &more].map(|answer| answer.header("etag").to_owned());
    assert!(tags[0] != tags[1] && tags[1] != tags[2] && tags[0] != tags[2], "{tags:?}");
    let again = post("?format=exr&layers=object,distance");
    assert_eq!((again.header("etag"), &again.body), (some.header("etag"), &some.body));
    assert!(again.header("server-timing").contains("picture;desc=hit"), "{}", again.header("server-timing"));
    let headers = [("Content-Type", "application/json"), ("Accept", "image/x-exr"), ("If-None-Match", &tags[1])];
    let known = service.send("QUERY", "/v1/render?layers=distance,object", &headers, BALL.as_bytes());
    assert_eq!(known.status, 304, "{}", known.text());
    let tile = post("/tile?x=8&y=8&w=16&h=16&format=exr&layers=normal");
    assert!(tile.status == 200 && has(&tile.body, "N.X\0\u{2}\0"), "{}", tile.text());

    let refused = |query: &str, part: &str| {
        let answer = post(query);
        assert!(answer.problem(400, "invalid-parameter").to_string().contains(part), "{part} in {}", answer.text());
    };
    refused("?layers=distance", "format=exr");
    refused("?format=pfm&layers=distance", "format=exr");
    refused("?format=exr&layers=normals", "did you mean");
    refused("?format=exr&layers=share:/objects/7", "objects");
    refused("?format=exr&layer=normal", "did you mean \\\"layers");
    let headers = [("Content-Type", "application/json"), ("Prefer", "respond-async")];
    let job = service.send("POST", "/v1/render?format=exr&layers=normal", &headers, BALL.as_bytes());
    assert!(job.problem(400, "invalid-parameter").to_string().contains("without Prefer"), "{}", job.text());
}

/// What the iTXt chunk of a PNG says about it.
fn note(png: &[u8]) -> Option<String> {
    let start = b"iTXtstrahl\0";
    let at = png.windows(start.len()).position(|window| window == start)?;
    let length = u32::from_be_bytes(png[at - 4..at].try_into().unwrap()) as usize;
    Some(String::from_utf8_lossy(&png[at + start.len()..at + 4 + length]).into_owned())
}

#[test]
fn whole_pictures_carry_what_is_known_of_them() {
    let service = Service::start(&[]);
    let whole = note(&service.post_json("/v1/render", BALL).body).unwrap();
    assert!(whole.contains(r#""max_codes":"#) && whole.contains(r#""replay":"#), "{whole}");
    // 48 x 32 pixels, of which two come first.
    let stopped = note(&service.post_json("/v1/render?accuracy=rays:1", BALL).body).unwrap();
    assert!(stopped.contains("1534 pixels were not traced"), "{stopped}");
    assert_eq!(note(&service.post_json("/v1/render/tile?x=0&y=0&w=16&h=16", BALL).body), None, "tiles are small");
}

#[test]
fn the_query_overrides_the_scene() {
    let service = Service::start(&[]);
    let answer = service.post_json("/v1/render?width=20&height=10&antialias=false&precision=double", BALL);
    assert_eq!(answer.picture().dimensions(), (20, 10));
    let deep = service.post_json("/v1/render?bits=16", BALL).picture();
    assert_eq!(deep.color(), image::ColorType::Rgb16);
}

#[test]
fn a_tile_is_that_part_of_the_whole() {
    let service = Service::start(&[]);
    let mut whole = service.post_json("/v1/render", BALL).picture();
    for (x, y, w, h) in [(0, 0, 48, 32), (0, 0, 1, 1), (7, 5, 17, 11), (47, 31, 1, 1), (16, 0, 32, 32)] {
        let tile = service.post_json(&format!("/v1/render/tile?x={x}&y={y}&w={w}&h={h}"), BALL).picture();
        assert_eq!(tile.to_rgb8(), whole.crop(x, y, w, h).to_rgb8(), "{x},{y},{w},{h}");
    }
}

#[test]
fn the_client_chooses_the_format() {
    let service = Service::start(&[]);
    let with = |accept| {
        let headers = [("Content-Type", "application/json"), ("Accept", accept)];
        service.send("POST", "/v1/render", &headers, BALL.as_bytes())
    };
    for (accept, media_type, magic) in [
        ("*/*", "image/png", b"\x89PNG".as_slice()),
        ("image/png;q=0.1, image/x-exr", "image/x-exr", b"\x76\x2f\x31\x01"),
        ("image/x-portable-floatmap", "image/x-portable-floatmap", b"PF\n"),
        ("image/jpeg", "image/jpeg", b"\xff\xd8\xff"),
        ("image/webp, image/png;q=0.9", "image/webp", b"RIFF"),
    ] {
        let answer = with(accept);
        assert_eq!((answer.status, answer.header("content-type")), (200, media_type), "{accept}");
        assert!(answer.body.starts_with(magic), "{accept}");
    }
    let named = service.post_json("/v1/render?format=exr", BALL);
    assert_eq!(named.header("content-type"), "image/x-exr");
    let pixels = |query: &str| {
        let answer = service.post_json(&format!("/v1/render?{query}"), BALL);
        assert_eq!(answer.status, 200, "{query}: {}", answer.text());
        (answer.body.len(), image::load_from_memory(&answer.body).expect("a picture").to_rgb8())
    };
    let (_, exact) = pixels("format=png");
    assert_eq!(pixels("format=webp").1, exact, "WebP loses nothing");
    let ((fine, near), (coarse, _)) = (pixels("format=jpg&quality=95"), pixels("format=jpg&quality=5"));
    assert!(coarse < fine && near.dimensions() == exact.dimensions(), "{coarse} {fine}");
    let refused = with("text/html").problem(406, "not-acceptable");
    assert_eq!(refused["available"][0], "image/png");
}

#[test]
fn nff_comes_plain_or_compressed() {
    let service = Service::start(&[]);
    let plain = service.send("POST", "/v1/render?width=8&height=8", &[("Content-Type", "text/x-nff")], NFF.as_bytes());
    assert_eq!(plain.picture().dimensions(), (8, 8));
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    gzip.write_all(NFF.as_bytes()).unwrap();
    let gzip = gzip.finish().unwrap();
    let packed = service.send("POST", "/v1/render?width=8&height=8", &[("Content-Type", "application/gzip")], &gzip);
    assert_eq!(packed.body, plain.body);
}

#[test]
fn questions_have_answers() {
    let service = Service::start(&[]);
    let body = format!(
        r#"{{"scene": {BALL}, "rays": [{{"origin": [0, 1, 5], "direction": [0, 0, -1]}}, {{"origin": [0, 5, 0], "direction": [0, 1, 0]}}]}}"#
    );
    let answers = service.post_json("/v1/rays", &body).json();
    assert_eq!(answers["answers"].as_array().map(Vec::len), Some(2), "{answers}");
    assert_eq!(answers["answers"][0]["hit"], true, "{answers}");
    assert_eq!(answers["answers"][1]["hit"], false, "{answers}");

    let tree = service.post_json("/v1/tree?x=24&y=16", BALL);
    assert_eq!((tree.status, tree.header("content-type")), (200, "application/json"), "{}", tree.text());
    let dot = service.post_json("/v1/tree?x=24&y=16&format=dot", BALL);
    assert_eq!((dot.status, dot.header("content-type")), (200, "text/vnd.graphviz"));
    let named = BALL.replace(r#""radius": 1,"#, r#""radius": 1, "name": "be\u0001for\ufffee","#);
    let svg = service.post_json("/v1/tree?x=24&y=16&format=svg", &named);
    assert_eq!((svg.status, svg.header("content-type")), (200, "image/svg+xml"), "{}", svg.text());
    assert!(svg.text().contains("before"), "what XML cannot hold is left out: {}", svg.text());

    let plan = service.post_json("/v1/explain", BALL).json();
    assert!(plan["effects"].is_array(), "{plan}");
    let depth = &plan["depth"];
    assert!(depth["proved_sufficient"].is_null() && depth["reached"].is_null(), "{plan}");
    assert_eq!(depth["because"][0], "/materials/red/reflection", "{plan}");
    assert!(plan["estimate"]["rays"].is_u64() && plan["actual"].is_null(), "{plan}");
    let analyzed = service.post_json("/v1/explain?analyze=1&antialias=false", BALL).json();
    let effects = analyzed["effects"].as_array().map(Vec::as_slice).unwrap_or_default();
    assert_eq!(analyzed["depth"]["reached"], 2, "{analyzed}");
    let reflection = effects.iter().find(|effect| effect["effect"] == "reflection");
    let reflection = reflection.unwrap_or_else(|| panic!("{analyzed}"));
    assert_eq!(reflection["act"]["rays"], analyzed["actual"]["rays"]["reflected"], "{analyzed}");
    assert_eq!(reflection["values"]["/materials/red/reflection"][0], 0.2, "{reflection}");
    let refused = service.post_json("/v1/explain?analyze=perhaps", BALL);
    assert!(refused.status == 400 && refused.text().contains("analyze"), "{}", refused.text());
    let valid = service.post_json("/v1/scenes/validate", BALL).json();
    assert_eq!(valid["valid"], true, "{valid}");
    assert!(valid["warnings"].is_array(), "{valid}");
}

#[test]
fn a_coarse_map_comes_first_and_looks_like_the_whole() {
    let service = Service::start(&[]);
    let map = |query: &str| service.post_json(&format!("/v1/map?of=rays&width=64&height=48{query}"), BALL);
    let (coarse, whole) = (map("&step=8").picture().to_rgb8(), map("").picture().to_rgb8());
    assert_eq!(coarse.dimensions(), whole.dimensions());
    assert!((0..8).all(|i| coarse.get_pixel(24 + i, 16 + i) == coarse.get_pixel(24, 16)), "a block has one color");
    assert!(map("").body != map("&step=8").body && map("&step=1").body == map("").body);
    for step in ["0", "65", "-1", "x"] {
        let refused = map(&format!("&step={step}"));
        assert!(refused.status == 400 && refused.text().contains("step"), "{}", refused.text());
    }
}

#[test]
fn the_service_describes_itself() {
    let service = Service::start(&["--max-pixels", "1234", "--queue", "5"]);
    let limits = service.get("/v1/limits").json();
    assert_eq!((&limits["request"]["max_pixels"], &limits["request"]["queue"]), (&1234.into(), &5.into()));
    assert_eq!(limits["scene"]["image_side"], 16_384);
    let schema = service.get("/schema/scene.json");
    assert_eq!(schema.header("content-type"), "application/schema+json");
    assert!(schema.json()["properties"]["objects"].is_object());
    let page = service.get("/problems/saturated");
    assert!(page.status == 200 && page.text().contains("Retry-After"), "{}", page.text());
    assert_eq!(service.get("/livez").status, 200);
    assert_eq!(service.get("/readyz").json()["status"], "ready");
}
