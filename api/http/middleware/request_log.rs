//! Gives every answer a request id, security headers, a problem document for errors, and a line in the log.

use crate::http::auth::capability;
use crate::http::drain::Counted;
use crate::http::problem::Problem;
use crate::http::state::App;
use axum::body::Body;
use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use http_body_util::BodyExt;
use hyper::body::Body as _;
use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, LazyLock};
use std::time::Instant;

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Headers of a response that are kept when a problem document replaces it.
const KEPT: [HeaderName; 3] =
    [header::ALLOW, HeaderName::from_static("ratelimit"), HeaderName::from_static("ratelimit-policy")];

/// Wraps all handlers.
pub(crate) async fn request_log(State(app): State<App>, request: Request, next: Next) -> Response {
    let id = request_id(request.headers());
    let visit = RequestLog::begin(&app, &request, &id);
    let answer = app.drain.unless_given_up(next.run(request)).await;
    let mut response = answer.unwrap_or_else(IntoResponse::into_response);
    if let Some(problem) = response.extensions_mut().remove::<Problem>() {
        if let Some(reason) = problem.shed() {
            app.metrics.shed(reason);
        }
        let found = std::mem::take(response.headers_mut());
        response = problem.answer(&id);
        for (name, value) in KEPT.iter().filter_map(|name| Some((name, found.get(name)?))) {
            response.headers_mut().insert(name, value.clone());
        }
    }
    add_headers(&mut response, &id);
    visit.end(response)
}

/// What every answer to a client has.
pub(crate) fn add_headers(response: &mut Response, id: &str) {
    let status = response.status();
    let headers = response.headers_mut();
    if let Ok(id) = HeaderValue::from_str(id) {
        headers.insert(REQUEST_ID, id);
    }
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    // Ray trees as SVG repeat names from the scene, so nothing in an answer may run. Reports contain their pictures. Only pages
    // that are part of the program have another policy.
    headers
        .entry(header::CONTENT_SECURITY_POLICY)
        .or_insert(HeaderValue::from_static("default-src 'none'; img-src data:; style-src 'unsafe-inline'; sandbox"));
    headers.insert(header::REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    if status.is_client_error() || status.is_server_error() {
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    }
}

/// The client's request id if it is harmless, else a new one: 32 random bits of this process and a counter.
pub(crate) fn request_id(headers: &HeaderMap) -> String {
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

/// The trace id of a `traceparent` header, 32 digits that are not all zero.
fn trace_id(headers: &HeaderMap) -> Option<String> {
    let mut parts = headers.get("traceparent")?.to_str().ok()?.split('-');
    let (version, id) = (parts.next()?, parts.next()?);
    let hexadecimal = |text: &str| text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
    let sound = version.len() == 2 && hexadecimal(version) && version != "ff" && id.len() == 32 && hexadecimal(id);
    (sound && id.bytes().any(|b| b != b'0')).then(|| id.to_owned())
}

/// One request, from its headers to its answer or its disconnection. Dropping it writes a line to the log.
#[derive(Debug)]
struct RequestLog {
    app: App,
    id: String,
    /// Its trace id, if the client sends one (W3C trace context).
    trace: Option<String>,
    /// The pattern of its path.
    route: String,
    method: Method,
    path: String,
    started: Instant,
    status: Option<StatusCode>,
    /// Counts it among those that run, until it is answered.
    counted: Option<Counted>,
}

/// A path as URLs have it: what a client may send raw could control a terminal.
fn graphic(path: &str) -> String {
    if path.bytes().all(|byte| byte.is_ascii_graphic()) {
        return path.to_owned();
    }
    let encoded =
        |byte: u8| if byte.is_ascii_graphic() { char::from(byte).to_string() } else { format!("%{byte:02X}") };
    path.bytes().map(encoded).collect()
}

impl RequestLog {
    fn begin(app: &App, request: &Request, id: &str) -> Self {
        let matched = request.extensions().get::<MatchedPath>();
        Self {
            app: Arc::clone(app),
            trace: trace_id(request.headers()),
            route: matched.map_or("unmatched", MatchedPath::as_str).to_owned(),
            id: id.to_owned(),
            method: request.method().clone(),
            path: graphic(&capability::hidden(request.uri().path())),
            started: Instant::now(),
            status: None,
            counted: Some(app.drain.request()),
        }
    }

    /// The answer is there. One that is made while it is sent still runs: a drain waits for it.
    fn end(mut self, response: Response) -> Response {
        self.status = Some(response.status());
        self.app.metrics.answered(&self.route, &self.method, &response, self.started.elapsed());
        if response.body().size_hint().exact().is_some() {
            return response;
        }
        let counted = self.counted.take();
        response.map(|body| {
            Body::new(body.map_err(move |error| {
                let _counted = &counted;
                error
            }))
        })
    }
}

impl Drop for RequestLog {
    fn drop(&mut self) {
        let Self { id, trace, method, path, started, status, .. } = self;
        let trace = trace.as_deref();
        let ms = u64::try_from(started.elapsed().as_millis()).unwrap_or(u64::MAX);
        match status.map(|status| status.as_u16()) {
            // Probes come every few seconds.
            Some(status) if matches!(path.as_str(), "/livez" | "/readyz") => {
                tracing::debug!(request = %id, %method, %path, status, ms, "answered");
            }
            Some(status) => tracing::info!(request = %id, trace, %method, %path, status, ms, "answered"),
            None => {
                self.app.metrics.left(&self.route);
                tracing::info!(request = %id, trace, %method, %path, ms, "the client went away");
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_path_controls_a_terminal() {
        assert_eq!(graphic("/v1/jobs/a-1~%20"), "/v1/jobs/a-1~%20");
        assert_eq!(graphic("/\u{9b}31m\u{202e}ä"), "/%C2%9B31m%E2%80%AE%C3%A4");
    }

    #[test]
    fn traces_are_recognised() {
        let of = |text| {
            trace_id(&HeaderMap::from_iter([(HeaderName::from_static("traceparent"), HeaderValue::from_static(text))]))
        };
        let id = "4bf92f3577b34da6a3ce929d0e0e4736";
        assert_eq!(of("00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01").as_deref(), Some(id));
        for wrong in [
            "",
            "00",
            "00-abc-def-01",
            "ff-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01",
            "00-00000000000000000000000000000000-00f067aa0ba902b7-01",
            "00-4BF92F3577B34DA6A3CE929D0E0E4736-00f067aa0ba902b7-01",
        ] {
            assert_eq!(of(wrong), None, "{wrong}");
        }
    }

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
