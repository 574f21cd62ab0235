//! A picture that streams: `Accept: multipart/mixed`.

use super::jobs::mirrors;
use super::operations::{get, number, with_admin};
use crate::common::service::{Answer, NO_TIMEOUT, Service, request};
use crate::common::{BALL, SLOW};
use serde_json::{Value, json};
use std::io::{Read, Write};

const PARTS: [(&str, &str); 2] = [("Content-Type", "application/json"), ("Accept", "multipart/mixed")];

/// The bytes of chunks (RFC 9112, section 7.1).
fn unchunked(mut body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    loop {
        let end = body.windows(2).position(|two| two == b"\r\n").expect("a length");
        let length = usize::from_str_radix(std::str::from_utf8(&body[..end]).unwrap(), 16).unwrap();
        if length == 0 {
            return bytes;
        }
        bytes.extend(&body[end + 2..end + 2 + length]);
        body = &body[end + 2 + length + 2..];
    }
}

/// The parts of an answer, each with its media type, as a reader of RFC 2046 takes them apart.
fn parts(answer: &Answer) -> Vec<(String, Vec<u8>)> {
    assert_eq!(answer.status, 200, "{}", answer.text());
    let boundary = answer.header("content-type").strip_prefix("multipart/mixed; boundary=").expect("the media type");
    let (body, delimiter) = (unchunked(&answer.body), format!("--{boundary}"));
    let places: Vec<usize> = (0..body.len()).filter(|at| body[*at..].starts_with(delimiter.as_bytes())).collect();
    assert!(body[places[places.len() - 1]..].ends_with(format!("{delimiter}--\r\n").as_bytes()), "it is whole");
    let part = |pair: &[usize]| {
        let text = &body[pair[0] + delimiter.len() + 2..pair[1] - 2];
        let end = text.windows(4).position(|four| four == b"\r\n\r\n").expect("headers");
        let head = String::from_utf8(text[..end].to_vec()).unwrap();
        let bytes = text[end + 4..].to_vec();
        let field = |name: &str| head.split("\r\n").find_map(|line| line.strip_prefix(name)).unwrap().to_owned();
        assert_eq!(field("Content-Length: "), bytes.len().to_string());
        (field("Content-Type: "), bytes)
    };
    places.windows(2).map(part).collect()
}

fn stream(service: &Service, path: &str, scene: &str) -> Vec<(String, Vec<u8>)> {
    parts(&service.send("POST", path, &PARTS, scene.as_bytes()))
}

fn json_of(part: &(String, Vec<u8>)) -> Value {
    assert_eq!(part.0, "application/json");
    serde_json::from_slice(&part.1).unwrap()
}

#[test]
fn coarse_pictures_come_first_and_the_last_is_the_picture() {
    let service = Service::start(&[]);
    let clear = BALL.replace(r#""version": 1,"#, r#""version": 1, "film": { "background": "transparent" },"#);
    for (scene, query, media_type) in [
        (BALL, "width=320&height=203", "image/png"),
        (BALL, "width=320&height=203&antialias=false&samples=1", "image/png"),
        (BALL, "width=320&height=200&format=pfm", "image/x-portable-floatmap"),
        (&clear, "width=320&height=200", "image/png"),
        (BALL, "width=320&height=203&accuracy=rays:400000", "image/png"),
    ] {
        let path = format!("/v1/render?{query}");
        let all = stream(&service, &path, scene);
        let count = all.len();
        assert!(count >= 3 && count % 2 == 1, "{query}: {count} parts");
        let mut scales = Vec::new();
        for (number, pair) in all[..count - 1].chunks(2).enumerate() {
            let head = json_of(&pair[0]);
            assert_eq!(head["pass"], number as u64, "{head}");
            if head["final"] == true {
                assert_eq!((number, &pair[1].0), (count / 2 - 1, &media_type.to_owned()), "{query}");
                continue;
            }
            let scale = head["scale"].as_u64().unwrap() as u32;
            let picture = image::load_from_memory(&pair[1].1).expect("a PNG");
            let size = |length: &str| head[length].as_u64().unwrap() as u32;
            assert_eq!(
                [picture.width(), picture.height()],
                [size("w"), size("h")].map(|length| length.div_ceil(scale))
            );
            assert_eq!((size("x"), size("y"), size("w")), (0, 0, 320));
            scales.push(scale);
        }
        assert!(scales.is_sorted_by(|a, b| a > b), "{query}: {scales:?}");
        let report = json_of(&all[count - 1])["report"].clone();
        assert!(report["cost"]["rays"].is_object(), "{report}");
        let plain = service.post_json(&path, scene);
        assert!(all[count - 2].1 == plain.body, "{query}");
        assert_eq!(json_of(&all[count - 3])["repr_digest"], plain.header("repr-digest"));
        // It is there now: no pass is needed.
        assert_eq!(stream(&service, &path, scene).len(), 3, "{query}");
    }
}

#[test]
fn variations_stream_too() {
    let service = Service::start(&[]);
    let base = service.post_json("/v1/scenes", BALL).json()["scene_id"].clone();
    let variation =
        json!({ "base": base, "patch": { "background": [0, 0, 1], "image": { "width": 200, "height": 120 } } });
    let all = stream(&service, "/v1/render", &variation.to_string());
    let whole = BALL.replace("[0.3, 0.5, 0.8]", "[0, 0, 1]").replace("48", "200").replace("32", "120");
    assert!(all[all.len() - 2].1 == service.post_json("/v1/render", &whole).body);
}

#[test]
fn what_fails_before_the_first_part_is_refused_as_ever() {
    let service = Service::start(&["--timeout", "15"]);
    let send = |path: &str, scene: &str| service.send("POST", path, &PARTS, scene.as_bytes());
    send("/v1/render", &BALL.replace("0.8", "-1")).problem(422, "invalid-scene");
    send("/v1/render?width=16000&height=4000", BALL).problem(413, "cost-limit");
    send("/v1/render?layers=depth", BALL).problem(400, "invalid-parameter");
    // One that fails later says so in its last part.
    let late = parts(&send("/v1/render", &SLOW.replace("\"max_depth\": 1000", "\"max_depth\": 100")));
    let last = json_of(&late[late.len() - 1]);
    assert_eq!(last["problem"]["type"], "/problems/render-deadline", "{last}");
}

#[test]
fn a_client_that_goes_away_cancels_the_picture() {
    let service = Service::start(&NO_TIMEOUT);
    let mut stream = service.connect();
    stream.write_all(&request("POST", "/v1/render", &PARTS, SLOW.as_bytes())).unwrap();
    let mut first = [0; 256];
    stream.read_exact(&mut first).expect("the first pass comes");
    service.wait_for(1, 0);
    drop(stream);
    service.wait_for(0, 0);
}

/// The head of such an answer is sent long before its end.
#[test]
fn a_drain_waits_for_answers_that_have_begun() {
    let mut service = Service::start(&["--drain-timeout", "600"]);
    let mut client = service.connect();
    let path = "/v1/render?width=256&height=256&samples=4";
    client.write_all(&request("POST", path, &PARTS, SLOW.as_bytes())).unwrap();
    service.wait_for(1, 0);
    let mut first = [0; 256];
    client.peek(&mut first).expect("the first pass comes");
    service.terminate();
    let all = parts(&Answer::read(client));
    assert!(all[all.len() - 2].1.starts_with(b"\x89PNG") && json_of(&all[all.len() - 1])["problem"].is_null());
    assert!(service.ended().success());
}

#[test]
fn a_client_that_does_not_read_holds_up_nobody() {
    let service = Service::start(&[]);
    let path = "/v1/render?width=2000&height=1200&antialias=false&format=pfm";
    let mut lazy = service.connect();
    lazy.write_all(&request("POST", path, &PARTS, BALL.as_bytes())).unwrap();
    service.wait_for(0, 0);
    assert_eq!(service.post_json("/v1/render", BALL).status, 200);
    // What it missed are passes.
    let all = parts(&Answer::read(lazy));
    assert!(all[all.len() - 2].1 == service.post_json(path, BALL).body);
}

/// Who comes later begins with the newest coarse picture.
#[test]
fn streams_of_the_same_picture_are_rendered_once() {
    let path = "/v1/render?width=256&height=256&samples=4";
    let rays = |streams: usize| {
        let (service, admin) = with_admin(&[]);
        let pictures: Vec<Vec<u8>> = std::thread::scope(|scope| {
            let asked: Vec<_> = (0..streams).map(|_| scope.spawn(|| stream(&service, path, &mirrors()))).collect();
            asked.into_iter().map(|asked| asked.join().unwrap().pop().unwrap().1).collect()
        });
        assert!(pictures.iter().all(|picture| *picture == pictures[0]), "the same bytes");
        service.wait_for(0, 0);
        number(&get(admin, "/metrics").text(), "strahl_rays_total{lane=\"renders\"}")
    };
    let [one, three] = [1, 3].map(rays);
    assert!(three < 1.5 * one, "{three} rays for three clients, {one} for one");
}
