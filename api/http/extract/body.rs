//! Request bodies: which format, how large, how slow. They may come compressed (`Content-Encoding: gzip`); limits are on what comes out.

use super::scene_types::{advice, format_of};
use super::variation;
use crate::http::auth::tenant::Tenant;
use crate::http::problem::{Kind, Problem};
use crate::http::state::AppState;
use crate::service::memory_budget::MeteredBytes;
use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderName, header};
use flate2::write::MultiGzDecoder;
use http_body_util::BodyExt;
use std::io::{self, Write};
use std::time::Duration;
use strahl::scene::Format;
use strahl::scene::recognise::{Recognised, is_gzip, recognise_start};
use tokio::time::timeout;

/// Compressed bytes that are decompressed at a time.
const PIECE: usize = 4_096;

/// Time for which the body of a refused request is read.
const DISCARD: Duration = Duration::from_secs(2);

/// Media types that say nothing: none, and those that clients such as curl send by default.
const UNDECLARED: [&str; 3] = ["", "application/x-www-form-urlencoded", "application/octet-stream"];

/// The format of the scene by its Content-Type. None if that says nothing. Then the body decides ([`check_content`]).
pub(crate) fn declared_format(headers: &HeaderMap) -> Result<Option<Format>, Problem> {
    let format = match media_type(headers).as_str() {
        name if UNDECLARED.contains(&name) => None,
        name => Some(format_of(name).ok_or_else(|| unsupported(&format!("Content-Type {name} is no scene format")))?),
    };
    encoding(headers).map(|_| format)
}

/// Without a declared format a body has to begin like a JSON object. A body in a format that is not read is refused by name.
pub(crate) fn check_content(declared: Option<Format>, body: &[u8]) -> Result<Format, Problem> {
    let recognised = recognise_start(body);
    let is_other = matches!(recognised, Recognised::Other(_));
    let is_model = declared.is_some_and(|format| format != Format::Nff) && recognised.model().is_some();
    if (is_other || is_model)
        && let Some(problem) = recognised.refused_as(declared.unwrap_or(Format::Json))
    {
        return Err(Problem::new(Kind::UnsupportedMediaType, problem.detail));
    }
    match declared.or_else(|| recognised.model()) {
        Some(format) => Ok(format),
        None if recognised == Recognised::Json => Ok(Format::Json),
        None if recognised == Recognised::Nff => {
            let what = if is_gzip(body) {
                "this is compressed: JSON needs Content-Encoding: gzip, and Neutral File Format its Content-Type"
            } else {
                "this looks like Neutral File Format, which needs its Content-Type"
            };
            Err(unsupported(what))
        }
        None if body.is_empty() => Err(unsupported("the body is empty")),
        None => Err(unsupported("there is no Content-Type, and the body is not a JSON object")),
    }
}

/// Whether the Content-Type says that the body is a variation of a scene.
pub(crate) fn declares_variation(headers: &HeaderMap) -> bool {
    media_type(headers) == variation::MEDIA_TYPE
}

/// Refuses a Content-Type other than JSON.
pub(crate) fn declares_json(headers: &HeaderMap) -> Result<Option<Format>, Problem> {
    match declared_format(headers)? {
        declared @ (None | Some(Format::Json)) => Ok(declared),
        Some(_) => Err(Problem::new(Kind::UnsupportedMediaType, "this takes application/json only")),
    }
}

/// Media types of changes: JSON merge patches (RFC 7396) and JSON.
const PATCHES: &str = "application/merge-patch+json, application/json";

/// Refuses a Content-Type other than those of changes.
pub(crate) fn declares_patch(headers: &HeaderMap) -> Result<(), Problem> {
    let kind = media_type(headers);
    if UNDECLARED.contains(&kind.as_str()) || PATCHES.split(", ").any(|known| known == kind) {
        return Ok(());
    }
    let detail = format!("a change has the Content-Type {}, not {kind}", PATCHES.replace(", ", " or "));
    Err(Problem::new(Kind::UnsupportedMediaType, detail).taking(HeaderName::from_static("accept-patch"), PATCHES))
}

/// Content codings of bodies.
const CODINGS: &str = "gzip";

/// How a body is encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Identity,
    Gzip,
}

fn encoding(headers: &HeaderMap) -> Result<Encoding, Problem> {
    match text(headers, header::CONTENT_ENCODING).to_ascii_lowercase().as_str() {
        "" | "identity" => Ok(Encoding::Identity),
        "gzip" | "x-gzip" => Ok(Encoding::Gzip),
        other => {
            let detail = format!("Content-Encoding {other} is not supported: send the body as it is, or with gzip");
            Err(Problem::new(Kind::UnsupportedMediaType, detail).taking(header::ACCEPT_ENCODING, CODINGS))
        }
    }
}

/// The media type of the body in lower case, without parameters.
fn media_type(headers: &HeaderMap) -> String {
    text(headers, header::CONTENT_TYPE).split(';').next().unwrap_or_default().trim().to_ascii_lowercase()
}

fn text(headers: &HeaderMap, name: HeaderName) -> &str {
    headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default()
}

fn unsupported(what: &str) -> Problem {
    Problem::new(Kind::UnsupportedMediaType, format!("{what}: {}", advice()))
}

/// Reads a whole body, within the limits. A client that announces too large a body is refused before it sends it.
pub(crate) async fn read(
    app: &AppState,
    tenant: &Tenant,
    headers: &HeaderMap,
    body: Body,
) -> Result<MeteredBytes, Problem> {
    if announced(headers) > app.limits.max_body_bytes {
        return Err(too_large(app));
    }
    let body = timeout(app.limits.body_timeout, collect(app, tenant, encoding(headers)?, body));
    // A client that is slow must not delay the end of the service.
    let body = app.drain.unless_begun(async {
        body.await.unwrap_or_else(|_| {
            let seconds = app.limits.body_timeout.as_secs_f64();
            Err(Problem::new(Kind::BodyTimeout, format!("the body was not complete after {seconds} s (body_timeout)")))
        })
    });
    body.await
}

/// Reads on although the request is refused: a client that is still sending does not read the answer. Bodies that are too
/// large or too slow are not read.
pub(crate) async fn discard(app: &AppState, headers: &HeaderMap, mut body: Body) {
    let mut left = app.limits.max_body_bytes;
    if announced(headers) > left {
        return;
    }
    let all = async {
        while let Some(Ok(frame)) = body.frame().await {
            let length = frame.data_ref().map_or(0, Bytes::len) as u64;
            if length > left {
                return;
            }
            left -= length;
        }
    };
    // The answer is the same if the time is over.
    let _ = timeout(DISCARD, all).await;
}

fn announced(headers: &HeaderMap) -> u64 {
    text(headers, header::CONTENT_LENGTH).parse().unwrap_or(0)
}

async fn collect(app: &AppState, tenant: &Tenant, encoding: Encoding, mut body: Body) -> Result<MeteredBytes, Problem> {
    let mut all = app.service.memory.body_of(&tenant.name);
    let mut unpacked = (encoding == Encoding::Gzip).then(|| MultiGzDecoder::new(Vec::new()));
    while let Some(frame) = body.frame().await {
        let broken = |error| Problem::new(Kind::MalformedRequest, format!("the body broke off: {error}"));
        let frame = frame.map_err(broken)?;
        let Ok(data) = frame.into_data() else { continue };
        match &mut unpacked {
            None => append(app, &mut all, &data)?,
            // A little at a time, since it may decompress to a thousand times its size.
            Some(decoder) => {
                for piece in data.chunks(PIECE) {
                    decoder.write_all(piece).map_err(|error| no_gzip(&error))?;
                    append(app, &mut all, &std::mem::take(decoder.get_mut()))?;
                    // Members of a gzip file may be empty, and each takes time: others are answered between.
                    tokio::task::yield_now().await;
                }
            }
        }
    }
    if let Some(decoder) = unpacked {
        append(app, &mut all, &decoder.finish().map_err(|error| no_gzip(&error))?)?;
    }
    Ok(all)
}

/// Memory is taken as bytes arrive, not as they are announced: announcing costs a client nothing.
fn append(app: &AppState, all: &mut MeteredBytes, more: &[u8]) -> Result<(), Problem> {
    if (all.len() + more.len()) as u64 > app.limits.max_body_bytes {
        return Err(too_large(app));
    }
    Ok(all.append(more)?)
}

fn no_gzip(error: &io::Error) -> Problem {
    Problem::new(Kind::InvalidEncoding, format!("the body is not a gzip file, or not all of one: {error}"))
}

fn too_large(app: &AppState) -> Problem {
    let max = app.limits.max_body_bytes;
    Problem::limit(Kind::TooLarge, "max_body_bytes", max, format!("a body has at most {max} bytes (max_body_bytes)"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    fn with(name: HeaderName, value: &'static str) -> HeaderMap {
        HeaderMap::from_iter([(name, HeaderValue::from_static(value))])
    }

    #[test]
    fn the_content_type_says_the_format_or_the_body_does() {
        let of = |value| declared_format(&with(header::CONTENT_TYPE, value)).ok();
        assert_eq!(of("Application/JSON; charset=utf-8"), Some(Some(Format::Json)));
        assert_eq!(of("text/x-nff"), Some(Some(Format::Nff)));
        assert_eq!(of("application/gzip"), Some(Some(Format::Nff)));
        assert_eq!(of("application/x-www-form-urlencoded"), Some(None));
        assert_eq!(of("text/html"), None);
        assert_eq!(declared_format(&HeaderMap::new()).ok(), Some(None));
        assert_eq!(check_content(None, b" \n{\"version\": 1}").ok(), Some(Format::Json));
        assert!(check_content(None, b"scene=1").is_err() && check_content(None, b"").is_err());
        assert!(check_content(Some(Format::Json), b"glTF\x02").is_err());
        assert_eq!(check_content(None, b"glTF\x02").ok(), Some(Format::Gltf));
        assert_eq!(check_content(None, b"v 1 2 3").ok(), Some(Format::Obj));
        let mut encoded = with(header::CONTENT_TYPE, "application/json");
        encoded.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
        assert_eq!(declared_format(&encoded).ok(), Some(Some(Format::Json)));
        encoded.insert(header::CONTENT_ENCODING, HeaderValue::from_static("br"));
        assert!(declared_format(&encoded).is_err());
    }
}
