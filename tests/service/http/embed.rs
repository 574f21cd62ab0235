//! `/embed.js`, the element for pages of others. `tests/external/embed.py` tries it in a browser.

use crate::common::service::Service;
use flate2::read::GzDecoder;
use std::io::Read;

/// The element as it is in the repository.
const ELEMENT: &str = include_str!("../../../web/embed/strahl-picture.js");
/// Most bytes of it, compressed.
const BUDGET: usize = 8_192;

fn at(service: &Service, headers: &[(&str, &str)]) -> crate::common::service::Answer {
    service.send("GET", "/embed.js", headers, b"")
}

#[test]
fn the_element_is_served_as_it_is_written_and_once() {
    let service = Service::start(&[]);
    let plain = at(&service, &[]);
    assert_eq!((plain.status, plain.text().as_str()), (200, ELEMENT));
    assert_eq!(plain.header("content-type"), "text/javascript; charset=utf-8");
    assert_eq!(plain.header("cache-control"), "public, max-age=3600");
    let compressed = at(&service, &[("Accept-Encoding", "br, gzip")]);
    assert_eq!((compressed.header("content-encoding"), compressed.header("etag")), ("gzip", plain.header("etag")));
    let mut unpacked = String::new();
    GzDecoder::new(&compressed.body[..]).read_to_string(&mut unpacked).unwrap();
    assert_eq!(unpacked, ELEMENT);
    assert!(compressed.body.len() <= BUDGET, "{} bytes", compressed.body.len());
    assert!(plain.header("etag").starts_with("W/\""), "two forms, so it is weak: {plain:?}");
    let known = at(&service, &[("If-None-Match", plain.header("etag"))]);
    assert_eq!((known.status, known.body.len(), known.header("etag")), (304, 0, plain.header("etag")));
    assert_eq!(known.header("cache-control"), "public, max-age=3600");
    at(&service, &[("If-Match", "\"another\"")]).problem(412, "precondition-failed");
}

#[test]
fn pages_of_this_machine_may_load_the_element_and_with_keys_all() {
    let open = Service::start(&[]);
    let from = |service: &Service, page: &str| {
        at(service, &[("Origin", page)]).header("access-control-allow-origin").to_owned()
    };
    assert_eq!(from(&open, "http://localhost:3000"), "http://localhost:3000");
    assert_eq!(from(&open, "https://elsewhere.example"), "");
    let keys = std::env::temp_dir().join(format!("strahl-embed-{}.toml", std::process::id()));
    std::fs::write(&keys, "").unwrap();
    let closed = Service::start(&["--keys", keys.to_str().unwrap()]);
    std::fs::remove_file(&keys).unwrap();
    // It needs no key itself.
    let answer = at(&closed, &[("Origin", "https://elsewhere.example")]);
    assert_eq!((answer.status, answer.header("access-control-allow-origin")), (200, "*"));
}

#[test]
fn the_element_makes_no_html_from_text_and_names_no_other_place() {
    let words = [
        "innerHTML",
        "outerHTML",
        "insertAdjacentHTML",
        "document.write",
        "eval(",
        "new Function",
        "import(",
        "http:",
        "https:",
    ];
    for word in words {
        assert!(!ELEMENT.contains(word), "{word}");
    }
}
