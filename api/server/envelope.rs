//! What every answer has, whatever it is about: a request id, safe headers, problems as JSON, one line in the log.

use super::drain::Counted;
use super::problem::Problem;
use super::{App, Service};
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::Response;
use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Headers of a response that stay when a problem takes its place.
const KEPT: [HeaderName; 3] =
    [header::ALLOW, HeaderName::from_static("ratelimit"), HeaderName::from_static("ratelimit-policy")];

/// Wraps a handler.
pub(super) async fn envelope(State(service): State<App>, request: Request, next: Next) -> Response {
    let id = request_id(request.headers());
    let visit = Visit::begin(&service, &request, &id);
    let mut response = next.run(request).await;
    if let Some(problem) = response.extensions_mut().remove::<Problem>() {
        let found = std::mem::take(response.headers_mut());
        response = problem.answer(&id);
        for (name, value) in KEPT.iter().filter_map(|name| Some((name, found.get(name)?))) {
            response.headers_mut().insert(name, value.clone());
        }
    }
    let status = response.status();
    let headers = response.headers_mut();
    if let Ok(id) = HeaderValue::from_str(&id) {
        headers.insert(REQUEST_ID, id);
    }
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    // Ray trees as SVG repeat names from the scene; nothing in an answer may ever run. Reports contain their pictures.
    headers.insert(
        header::CONTENT_SECURITY_POLICY,
        HeaderValue::from_static("default-src 'none'; img-src data:; style-src 'unsafe-inline'; sandbox"),
    );
    if status.is_client_error() || status.is_server_error() {
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    }
    visit.end(status);
    response
}

/// The client's id if it is harmless, else a new one: 32 random bits of this process and a counter.
fn request_id(headers: &HeaderMap) -> String {
    static PROCESS: LazyLock<u64> = LazyLock::new(|| RandomState::new().build_hasher().finish() & 0xffff_ffff);
    static COUNT: AtomicU64 = AtomicU64::new(1);
    let harmless = |id: &&str| {
        (1..=64).contains(&id.len()) && id.bytes().all(|b| b.is_ascii_alphanumeric() || b"._-".contains(&b))
    };
    match headers.get(REQUEST_ID).and_then(|id| id.to_str().ok()).filter(harmless) {
        Some(id) => id.to_owned(),
        None => format!("{:08x}-{}", *PROCESS, COUNT.fetch_add(1, Ordering::Relaxed)),
    }
}

/// One request, from its headers to its answer or to its client going away; it ends with a line in the log.
#[derive(Debug)]
struct Visit {
    id: String,
    method: Method,
    path: String,
    started: Instant,
    status: Option<StatusCode>,
    _counted: Counted,
}

impl Visit {
    fn begin(service: &Service, request: &Request, id: &str) -> Self {
        Self {
            id: id.to_owned(),
            method: request.method().clone(),
            path: request.uri().path().to_owned(),
            started: Instant::now(),
            status: None,
            _counted: service.drain.request(),
        }
    }

    fn end(mut self, status: StatusCode) {
        self.status = Some(status);
    }
}

impl Drop for Visit {
    fn drop(&mut self) {
        let Self { id, method, path, started, status, .. } = self;
        let ms = started.elapsed().as_millis();
        match status.map(|status| status.as_u16()) {
            // Probes come every few seconds and say nothing new.
            Some(status) if matches!(path.as_str(), "/livez" | "/readyz") => {
                tracing::debug!(request = %id, %method, %path, status, ms, "answered");
            }
            Some(status) => tracing::info!(request = %id, %method, %path, status, ms, "answered"),
            None => tracing::info!(request = %id, %method, %path, ms, "the client went away"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_harmless_ids_are_taken_over() {
        let id = |text: &str| request_id(&HeaderMap::from_iter([(REQUEST_ID, HeaderValue::from_str(text).unwrap())]));
        assert_eq!(id("abc-1.2_3"), "abc-1.2_3");
        for text in ["", "a b", "a\"b", &"x".repeat(65)] {
            assert_ne!(id(text), text);
        }
        assert_ne!(request_id(&HeaderMap::new()), request_id(&HeaderMap::new()));
    }
}
