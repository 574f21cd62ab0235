//! Errors as RFC 9457 problem details. Handlers return a [`Problem`]; the envelope writes it, with the request's id.

use crate::jobs::record::Failure;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::{Map, Value, json};
use std::fmt::Write;
use strahl::scene;
use strahl::scene::limits::PROBLEMS;
use strahl::scene::problem::Code;

/// What can go wrong. Each kind has a page at `/problems/{slug}`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    InvalidJson,
    InvalidNff,
    InvalidRequest,
    InvalidParameter,
    InvalidScene,
    InvalidRays,
    UnsupportedMediaType,
    NotAcceptable,
    TooLarge,
    CostLimit,
    InvalidEncoding,
    MalformedRequest,
    UriTooLong,
    HeadersTooLarge,
    Unauthorized,
    Forbidden,
    RateLimited,
    NotFound,
    BadIiifRequest,
    MethodNotAllowed,
    Gone,
    Conflict,
    JobNotFinished,
    JobFailed,
    IdempotencyKeyReused,
    PreconditionFailed,
    BodyTimeout,
    Saturated,
    Draining,
    RenderDeadline,
    Internal,
}

impl Kind {
    /// All kinds.
    pub(super) const ALL: [Self; 31] = [
        Self::InvalidJson,
        Self::InvalidNff,
        Self::InvalidRequest,
        Self::InvalidParameter,
        Self::InvalidScene,
        Self::InvalidRays,
        Self::UnsupportedMediaType,
        Self::NotAcceptable,
        Self::TooLarge,
        Self::CostLimit,
        Self::InvalidEncoding,
        Self::MalformedRequest,
        Self::UriTooLong,
        Self::HeadersTooLarge,
        Self::Unauthorized,
        Self::Forbidden,
        Self::RateLimited,
        Self::NotFound,
        Self::BadIiifRequest,
        Self::MethodNotAllowed,
        Self::Gone,
        Self::Conflict,
        Self::JobNotFinished,
        Self::JobFailed,
        Self::IdempotencyKeyReused,
        Self::PreconditionFailed,
        Self::BodyTimeout,
        Self::Saturated,
        Self::Draining,
        Self::RenderDeadline,
        Self::Internal,
    ];

    /// Its name in URLs, its status, its title, and what to do about it.
    pub(super) fn page(self) -> (&'static str, StatusCode, &'static str, &'static str) {
        match self {
            Self::InvalidJson => (
                "invalid-json",
                StatusCode::BAD_REQUEST,
                "The body is not JSON",
                "`detail` and `errors` say where the text stops being JSON.",
            ),
            Self::InvalidNff => (
                "invalid-nff",
                StatusCode::BAD_REQUEST,
                "The body is not Neutral File Format",
                "`errors` says which line is wrong. A scene in JSON needs Content-Type: application/json.",
            ),
            Self::InvalidRequest => (
                "invalid-request",
                StatusCode::UNPROCESSABLE_ENTITY,
                "The request's JSON is not what is expected",
                "`detail` says what is wrong. What each request takes is described at /openapi.json.",
            ),
            Self::InvalidParameter => (
                "invalid-parameter",
                StatusCode::BAD_REQUEST,
                "A query parameter is wrong",
                "`errors` lists every parameter that is unknown, missing or out of range.",
            ),
            Self::InvalidScene => (
                "invalid-scene",
                StatusCode::UNPROCESSABLE_ENTITY,
                "The scene is not valid",
                "`errors` lists every problem with its JSON pointer, line and column. The format is described at \
                 /schema/scene.json.",
            ),
            Self::InvalidRays => (
                "invalid-rays",
                StatusCode::UNPROCESSABLE_ENTITY,
                "The rays are not valid",
                "The body is {\"scene\": {...}, \"rays\": [{\"origin\": [0,0,5], \"direction\": [0,0,-1]}]}.",
            ),
            Self::UnsupportedMediaType => (
                "unsupported-media-type",
                StatusCode::UNSUPPORTED_MEDIA_TYPE,
                "The body's type is not understood",
                "Send application/json, text/x-nff, or application/gzip for a compressed NFF file.",
            ),
            Self::NotAcceptable => (
                "not-acceptable",
                StatusCode::NOT_ACCEPTABLE,
                "No acceptable format",
                "`available` lists the formats there are.",
            ),
            Self::TooLarge => (
                "too-large",
                StatusCode::PAYLOAD_TOO_LARGE,
                "The request is too large",
                "`limit` names the limit. All limits are at /v1/limits. Sending the same again does not help.",
            ),
            Self::CostLimit => (
                "cost-limit",
                StatusCode::PAYLOAD_TOO_LARGE,
                "The picture is too much work for one answer",
                "`limit` names the limit. Ask for tiles (POST /v1/render/tile), a smaller picture or fewer samples.",
            ),
            Self::InvalidEncoding => (
                "invalid-encoding",
                StatusCode::BAD_REQUEST,
                "The body cannot be decompressed",
                "A body with Content-Encoding: gzip has to be a complete gzip file.",
            ),
            Self::MalformedRequest => (
                "malformed-request",
                StatusCode::BAD_REQUEST,
                "This is not HTTP",
                "The service speaks HTTP/1.1 without TLS.",
            ),
            Self::UriTooLong => (
                "uri-too-long",
                StatusCode::URI_TOO_LONG,
                "The URI is too long",
                "Scenes go into the body, not into the URI.",
            ),
            Self::HeadersTooLarge => (
                "headers-too-large",
                StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE,
                "The headers are too large",
                "Send fewer headers, or smaller ones: 100 of them, and 64 KiB with the request's line, are the most.",
            ),
            Self::Unauthorized => (
                "unauthorized",
                StatusCode::UNAUTHORIZED,
                "A key is needed",
                "Send Authorization: Bearer and a key that the operator of this service has made with `strahl key new`.",
            ),
            Self::Forbidden => (
                "forbidden",
                StatusCode::FORBIDDEN,
                "This is not allowed",
                "`detail` says what the key lacks, or what the capability is for.",
            ),
            Self::RateLimited => (
                "rate-limited",
                StatusCode::TOO_MANY_REQUESTS,
                "Too much in too short a time",
                "Try again after the seconds in the Retry-After header. A request costs a unit, and so does each million \
                 rays traced for it; the RateLimit header says how many units are left.",
            ),
            Self::NotFound => {
                ("not-found", StatusCode::NOT_FOUND, "There is nothing here", "Renders are at POST /v1/render.")
            }
            Self::BadIiifRequest => (
                "bad-iiif-request",
                StatusCode::BAD_REQUEST,
                "This is no IIIF request",
                "/iiif/3/{id}/{region}/{size}/{rotation}/{quality}.{format}, as in the IIIF Image API 3.0; info.json says \
                 what there is.",
            ),
            Self::MethodNotAllowed => (
                "method-not-allowed",
                StatusCode::METHOD_NOT_ALLOWED,
                "Wrong method",
                "The Allow header lists the methods there are.",
            ),
            Self::Gone => ("gone", StatusCode::GONE, "It is there no more", "Submit the job again."),
            Self::Conflict => (
                "conflict",
                StatusCode::CONFLICT,
                "It is not in a state for that",
                "`detail` says which state it is in. Jobs that have ended stay as they are.",
            ),
            Self::JobNotFinished => (
                "job-not-finished",
                StatusCode::CONFLICT,
                "The job is not done yet",
                "Try again after the seconds in the Retry-After header, or follow the job's events.",
            ),
            Self::JobFailed => (
                "job-failed",
                StatusCode::CONFLICT,
                "The job has no picture",
                "`detail` says why; so does `problem` of the job.",
            ),
            Self::IdempotencyKeyReused => (
                "idempotency-key-reused",
                StatusCode::UNPROCESSABLE_ENTITY,
                "The idempotency key belongs to another request",
                "Use a new Idempotency-Key for each new job, and the same one only to send the same request again.",
            ),
            Self::PreconditionFailed => (
                "precondition-failed",
                StatusCode::PRECONDITION_FAILED,
                "It is not what If-Match or If-None-Match asks for",
                "A job has been changed meanwhile: get it, look at it, and send the change again with its new ETag. A \
                 picture that a client has already is said to be so, with 304, to GET and QUERY only.",
            ),
            Self::BodyTimeout => (
                "body-timeout",
                StatusCode::REQUEST_TIMEOUT,
                "The body took too long to arrive",
                "Send it faster or make it smaller; NFF may be sent compressed.",
            ),
            Self::Saturated => (
                "saturated",
                StatusCode::SERVICE_UNAVAILABLE,
                "The service is busy",
                "Try again after the seconds in the Retry-After header.",
            ),
            Self::Draining => (
                "draining",
                StatusCode::SERVICE_UNAVAILABLE,
                "The service is about to stop",
                "Try again after the seconds in the Retry-After header, or at another instance.",
            ),
            Self::RenderDeadline => (
                "render-deadline",
                StatusCode::GATEWAY_TIMEOUT,
                "The render took too long",
                "Ask for tiles, a smaller picture, fewer samples or a lower max_depth.",
            ),
            Self::Internal => (
                "internal",
                StatusCode::INTERNAL_SERVER_ERROR,
                "The service has made a mistake",
                "It is the service's fault, not the request's. The log has more under the id in `instance`.",
            ),
        }
    }
}

impl Kind {
    /// A problem as a part of another document, of which the slug is known.
    pub(super) fn document(slug: &str, detail: &str) -> Value {
        let kind = Self::ALL.into_iter().find(|kind| kind.page().0 == slug).unwrap_or(Self::Internal);
        let (slug, status, title, _) = kind.page();
        json!({ "type": format!("/problems/{slug}"), "title": title, "status": status.as_u16(), "detail": detail })
    }
}

/// An error on its way to a client.
#[derive(Debug, Clone)]
pub(super) struct Problem {
    kind: Kind,
    detail: String,
    /// Further members of the JSON.
    members: Map<String, Value>,
    retry_after: Option<u32>,
}

impl Problem {
    /// A problem with a sentence that says what to do.
    pub(super) fn new(kind: Kind, detail: impl Into<String>) -> Self {
        Self { kind, detail: detail.into(), members: Map::new(), retry_after: None }
    }

    /// A limit, by name.
    pub(super) fn limit(kind: Kind, name: &str, max: u64, detail: impl Into<String>) -> Self {
        Self::new(kind, detail).with("limit", json!({ "name": name, "max": max }))
    }

    /// Adds a member.
    pub(super) fn with(mut self, member: &str, value: Value) -> Self {
        self.members.insert(member.to_owned(), value);
        self
    }

    /// Says when to try again, in seconds.
    pub(super) fn retry_after(mut self, seconds: u32) -> Self {
        self.retry_after = Some(seconds);
        self
    }

    /// Its slug and sentence: what a job remembers of it.
    pub(super) fn into_failure(self) -> Failure {
        Failure { slug: self.kind.page().0.into(), detail: self.detail }
    }

    /// Problems of a scene. Text that cannot even be read as its format is the request's fault, not the scene's.
    pub(super) fn scene(problems: &scene::Problems) -> Self {
        let kind = match problems.0.first().map(|first| first.code) {
            Some(Code::InvalidJson) => Kind::InvalidJson,
            Some(Code::InvalidNff) => Kind::InvalidNff,
            _ => Kind::InvalidScene,
        };
        let first = problems.0.first().map_or_else(String::new, ToString::to_string);
        let found = problems.0.len();
        // No more are looked for, so nobody knows how many there would be.
        let cut = found as u64 >= PROBLEMS.max;
        let detail = match found {
            0 | 1 => first,
            n if cut => {
                format!("{n} problems, and perhaps more, which are not looked for (problems); the first: {first}")
            }
            n => format!("{n} problems; the first: {first}"),
        };
        let problem =
            if cut { Self::limit(kind, PROBLEMS.name, PROBLEMS.max, detail) } else { Self::new(kind, detail) };
        problem.with("errors", problems.0.iter().map(error_entry).collect())
    }

    /// Its status.
    pub(super) fn status(&self) -> StatusCode {
        let (_, status, _, _) = self.kind.page();
        status
    }

    /// Why a request was refused that would have been welcome at another time.
    pub(super) fn shed(&self) -> Option<&'static str> {
        let (slug, _, _, _) = self.kind.page();
        matches!(self.kind, Kind::Saturated | Kind::Draining | Kind::RateLimited).then_some(slug)
    }

    /// The document; the request's id completes it.
    pub(super) fn document(self, request_id: &str) -> String {
        let (slug, status, title, _) = self.kind.page();
        let mut body = Map::new();
        body.insert("type".into(), format!("/problems/{slug}").into());
        body.insert("title".into(), title.into());
        body.insert("status".into(), status.as_u16().into());
        body.insert("detail".into(), self.detail.into());
        body.insert("instance".into(), request_id.into());
        body.extend(self.members);
        Value::Object(body).to_string()
    }

    /// The answer; the request's id completes it.
    pub(super) fn answer(self, request_id: &str) -> Response {
        let (kind, status, retry_after) = (self.kind, self.status(), self.retry_after);
        let mut response = (status, self.document(request_id)).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        if kind == Kind::Unauthorized {
            headers.insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer realm=\"strahl\""));
        }
        if let Some(seconds) = retry_after {
            headers.insert(header::RETRY_AFTER, seconds.into());
        }
        response
    }
}

impl IntoResponse for Problem {
    /// Only carries the problem to the envelope, which knows the request's id.
    fn into_response(self) -> Response {
        let mut response = self.status().into_response();
        response.extensions_mut().insert(self);
        response
    }
}

/// A scene's problem as an entry of `errors`.
fn error_entry(problem: &scene::Problem) -> Value {
    let mut entry = json!({
        "pointer": format!("#{}", fragment(&problem.pointer)),
        "code": problem.code,
        "detail": problem.detail,
    });
    for (key, value) in [("line", problem.line), ("column", problem.column)] {
        if let Some(value) = value {
            entry[key] = value.into();
        }
    }
    entry
}

/// A JSON pointer as a URI fragment (RFC 6901 section 6): bytes that a fragment cannot hold are percent-encoded.
fn fragment(pointer: &str) -> String {
    let mut encoded = String::with_capacity(pointer.len());
    for byte in pointer.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~!$&'()*+,;=:@/?".contains(&byte) {
            encoded.push(char::from(byte));
        } else {
            // Writing to a String cannot fail.
            let _ = write!(encoded, "%{byte:02X}");
        }
    }
    encoded
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slugs_are_unique() {
        let mut slugs: Vec<_> = Kind::ALL.iter().map(|kind| kind.page().0).collect();
        slugs.sort_unstable();
        slugs.dedup();
        assert_eq!(slugs.len(), Kind::ALL.len());
    }

    #[test]
    fn pointers_become_fragments() {
        assert_eq!(fragment("/materials/dark red~1x/ior"), "/materials/dark%20red~1x/ior");
    }

    #[test]
    fn scenes_and_their_text_have_different_statuses() {
        let of = |code| Problem::scene(&scene::Problems::one(scene::Problem::new("/a", code, "wrong"))).kind;
        assert_eq!(of(Code::InvalidJson), Kind::InvalidJson);
        assert_eq!(of(Code::OutOfRange), Kind::InvalidScene);
    }
}
