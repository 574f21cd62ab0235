//! `/embed.js`: the custom element `<strahl-picture>`, for pages of others. It needs no key, since it says nothing about
//! anybody; what it shows asks for one.

use crate::http::extract::accept::takes_gzip;
use crate::http::extract::conditions::{Verdict, weigh};
use crate::http::prelude::*;
use data_encoding::BASE64URL_NOPAD;
use flate2::Compression;
use flate2::write::GzEncoder;
use sha2::{Digest, Sha256};
use std::io::Write;
use std::sync::LazyLock;

pub(super) fn routes() -> Vec<Route> {
    let about = "The custom element `<strahl-picture>`, which shows jobs, images and scenes in any page, as a module.";
    vec![
        Route::get("/embed.js", element, ["embed", "service", about])
            .header("If-None-Match", "The ETag of the version that the client has.")
            .answer(200, "JavaScript", &[Content::text("text/javascript")])
            .answer(304, "The client has this version", &[]),
    ]
}

/// The element, served as it is written.
const ELEMENT: &str = include_str!("../../../web/embed/strahl-picture.js");
/// Pages name the address without a version, so they get a new one within an hour.
const HOUR: &str = "public, max-age=3600";

/// The element compressed, and its tag.
static FILE: LazyLock<(Vec<u8>, String)> = LazyLock::new(|| {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    // Memory takes all bytes.
    let compressed = encoder.write_all(ELEMENT.as_bytes()).and_then(|()| encoder.finish()).unwrap_or_default();
    (compressed, format!("\"{}\"", BASE64URL_NOPAD.encode(&Sha256::digest(ELEMENT)[..12])))
});

async fn element(request: Request) -> Response {
    let (compressed, tag) = &*FILE;
    // Weak, since the compressed form has it, too.
    let about = [
        (header::CACHE_CONTROL, HOUR.to_owned()),
        (header::VARY, "Accept-Encoding".to_owned()),
        (header::ETAG, format!("W/{tag}")),
    ];
    match weigh(request.method(), request.headers(), Some(tag)) {
        Verdict::NotModified => return (StatusCode::NOT_MODIFIED, about).into_response(),
        Verdict::Failed => {
            return Problem::new(Kind::PreconditionFailed, format!("the element is {tag} by now")).into_response();
        }
        Verdict::Proceed => {}
    }
    let about = (about, [(header::CONTENT_TYPE, "text/javascript; charset=utf-8")]);
    if takes_gzip(request.headers()) {
        return (about, [(header::CONTENT_ENCODING, "gzip")], compressed.as_slice()).into_response();
    }
    (about, ELEMENT).into_response()
}
