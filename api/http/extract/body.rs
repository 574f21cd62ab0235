//! Request bodies: which format, how large, how slow, and how much memory they take together with the answers. They may
//! come compressed (`Content-Encoding: gzip`); limits are on what comes out.

use crate::http::Service;
use crate::http::problem::{Kind, Problem};
use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderName, header};
use flate2::write::GzDecoder;
use http_body_util::BodyExt;
use std::io::{self, Write};
use std::sync::Arc;
use std::time::Duration;
use strahl::scene::Format;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::timeout;

/// Bytes that one permit of the memory budget stands for. Semaphores count up to 2^61 on 64-bit machines, but acquire
/// at most 2^32 permits at a time.
pub(crate) const UNIT: u64 = 4_096;

/// Compressed bytes that are unpacked at a time.
const PIECE: usize = 4_096;

/// How long the body of a refused request is listened to.
const DISCARD: Duration = Duration::from_secs(2);

/// So many bytes in units.
pub(crate) fn units(bytes: u64) -> usize {
    usize::try_from(bytes.div_ceil(UNIT)).unwrap_or(usize::MAX).min(Semaphore::MAX_PERMITS)
}

/// Bytes together with their share of the memory budget.
#[derive(Debug)]
pub(crate) struct Held {
    bytes: Vec<u8>,
    memory: Option<OwnedSemaphorePermit>,
}

impl Held {
    /// Bytes that are there already: the share is taken if there is one, since refusing would not free them sooner.
    pub(crate) fn new(bytes: Vec<u8>, budget: &Arc<Semaphore>) -> Self {
        let wanted = u32::try_from(units(bytes.len() as u64)).unwrap_or(u32::MAX);
        Self { memory: Arc::clone(budget).try_acquire_many_owned(wanted).ok(), bytes }
    }

    /// Takes in more of a request's body, within the limits.
    fn append(&mut self, service: &Service, more: &[u8]) -> Result<(), Problem> {
        let length = (self.bytes.len() + more.len()) as u64;
        if length > service.limits.max_body_bytes {
            return Err(too_large(service));
        }
        grow(service, &mut self.memory, units(length))?;
        self.bytes.extend_from_slice(more);
        Ok(())
    }

    /// The body of an answer that others may get, too: each holds its share until its last byte has gone out.
    pub(crate) fn shared(bytes: Bytes, budget: &Arc<Semaphore>) -> Body {
        struct Shared(Bytes, #[expect(dead_code, reason = "held until it is dropped")] Option<OwnedSemaphorePermit>);
        impl AsRef<[u8]> for Shared {
            fn as_ref(&self) -> &[u8] {
                &self.0
            }
        }
        let wanted = u32::try_from(units(bytes.len() as u64)).unwrap_or(u32::MAX);
        let memory = Arc::clone(budget).try_acquire_many_owned(wanted).ok();
        Body::from(Bytes::from_owner(Shared(bytes, memory)))
    }

    /// An answer's body; the share is given back when the last byte has gone out.
    pub(crate) fn into_body(self) -> Body {
        Body::from(Bytes::from_owner(self))
    }
}

impl AsRef<[u8]> for Held {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

/// Which format the headers say the scene has.
pub(crate) fn scene_format(headers: &HeaderMap) -> Result<Format, Problem> {
    let kind = text(headers, header::CONTENT_TYPE);
    let kind = kind.split(';').next().unwrap_or_default().trim().to_ascii_lowercase();
    let format = match kind.as_str() {
        "application/json" => Format::Json,
        "text/x-nff" | "application/gzip" | "application/x-gzip" => Format::Nff,
        "" => return Err(unsupported("there is no Content-Type".into())),
        _ => return Err(unsupported(format!("Content-Type {kind} is no scene format"))),
    };
    encoding(headers).map(|_| format)
}

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
        other => Err(unsupported(format!("Content-Encoding {other} is not supported, gzip is"))),
    }
}

/// Refuses bodies that do not say they are JSON.
pub(crate) fn json_only(headers: &HeaderMap) -> Result<(), Problem> {
    match scene_format(headers)? {
        Format::Json => Ok(()),
        Format::Nff => Err(Problem::new(Kind::UnsupportedMediaType, "this takes application/json only")),
    }
}

fn text(headers: &HeaderMap, name: HeaderName) -> &str {
    headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default()
}

fn unsupported(what: String) -> Problem {
    let detail = format!("{what}: send application/json, text/x-nff, or application/gzip for compressed NFF");
    Problem::new(Kind::UnsupportedMediaType, detail)
}

/// Reads a whole body, within the limits. Who announces too much is refused before sending it.
pub(crate) async fn read(service: &Service, headers: &HeaderMap, body: Body) -> Result<Held, Problem> {
    if announced(headers) > service.limits.max_body_bytes {
        return Err(too_large(service));
    }
    let body = collect(service, encoding(headers)?, body);
    timeout(service.limits.body_timeout, body).await.unwrap_or_else(|_| {
        let seconds = service.limits.body_timeout.as_secs_f64();
        Err(Problem::new(Kind::BodyTimeout, format!("the body was not complete after {seconds} s (body_timeout)")))
    })
}

/// Takes in a body whose request is refused anyway: who is still sending does not hear the answer. Bodies that are too
/// large or too slow do not get that courtesy.
pub(crate) async fn discard(service: &Service, headers: &HeaderMap, mut body: Body) {
    let mut left = service.limits.max_body_bytes;
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
    // Out of time or not, the answer is the same.
    let _ = timeout(DISCARD, all).await;
}

fn announced(headers: &HeaderMap) -> u64 {
    text(headers, header::CONTENT_LENGTH).parse().unwrap_or(0)
}

async fn collect(service: &Service, encoding: Encoding, mut body: Body) -> Result<Held, Problem> {
    let mut held = Held { bytes: Vec::new(), memory: None };
    let mut unpacked = (encoding == Encoding::Gzip).then(|| GzDecoder::new(Vec::new()));
    while let Some(frame) = body.frame().await {
        let frame = frame.map_err(|error| Problem::new(Kind::InvalidJson, format!("the body broke off: {error}")))?;
        let Ok(data) = frame.into_data() else { continue };
        match &mut unpacked {
            None => held.append(service, &data)?,
            // A little at a time: a small piece may hold a thousand times as much.
            Some(decoder) => {
                for piece in data.chunks(PIECE) {
                    decoder.write_all(piece).map_err(|error| no_gzip(&error))?;
                    held.append(service, &std::mem::take(decoder.get_mut()))?;
                }
            }
        }
    }
    if let Some(decoder) = unpacked {
        held.append(service, &decoder.finish().map_err(|error| no_gzip(&error))?)?;
    }
    Ok(held)
}

fn no_gzip(error: &io::Error) -> Problem {
    Problem::new(Kind::InvalidEncoding, format!("the body is not a gzip file, or not all of one: {error}"))
}

/// Memory is taken as bytes arrive, not as they are announced: announcing costs a client nothing.
fn grow(service: &Service, memory: &mut Option<OwnedSemaphorePermit>, wanted: usize) -> Result<(), Problem> {
    let have = memory.as_ref().map_or(0, OwnedSemaphorePermit::num_permits);
    let missing = u32::try_from(wanted.saturating_sub(have)).unwrap_or(u32::MAX);
    let more = Arc::clone(&service.memory).try_acquire_many_owned(missing).map_err(|_| {
        let detail = "the bodies of other requests take all the memory there is for them (memory_bytes)";
        Problem::new(Kind::Saturated, detail).retry_after(service.queue.retry_after())
    })?;
    match memory {
        Some(memory) => memory.merge(more),
        None => *memory = Some(more),
    }
    Ok(())
}

fn too_large(service: &Service) -> Problem {
    let max = service.limits.max_body_bytes;
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
    fn the_content_type_says_the_format() {
        let of = |value| scene_format(&with(header::CONTENT_TYPE, value)).ok();
        assert_eq!(of("Application/JSON; charset=utf-8"), Some(Format::Json));
        assert_eq!(of("text/x-nff"), Some(Format::Nff));
        assert_eq!(of("application/gzip"), Some(Format::Nff));
        assert_eq!(of("application/x-www-form-urlencoded"), None);
        assert!(scene_format(&HeaderMap::new()).is_err());
        let mut encoded = with(header::CONTENT_TYPE, "application/json");
        encoded.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
        assert_eq!(scene_format(&encoded).ok(), Some(Format::Json));
        encoded.insert(header::CONTENT_ENCODING, HeaderValue::from_static("br"));
        assert!(scene_format(&encoded).is_err());
    }
}
