//! Errors as RFC 9457 problem details. Handlers return a [`Problem`]; the envelope writes it, with the request's id.

mod kind;

pub(crate) use kind::Kind;

use crate::service::jobs::record::Failure;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::{Map, Value, json};
use std::fmt::Write;
use strahl::scene;
use strahl::scene::limits::PROBLEMS;
use strahl::scene::problem::Code;

/// An error on its way to a client.
#[derive(Debug, Clone)]
pub(crate) struct Problem {
    kind: Kind,
    detail: String,
    /// Further members of the JSON.
    members: Map<String, Value>,
    retry_after: Option<u32>,
}

impl Problem {
    /// A problem with a sentence that says what to do.
    pub(crate) fn new(kind: Kind, detail: impl Into<String>) -> Self {
        Self { kind, detail: detail.into(), members: Map::new(), retry_after: None }
    }

    /// A limit, by name.
    pub(crate) fn limit(kind: Kind, name: &str, max: u64, detail: impl Into<String>) -> Self {
        Self::new(kind, detail).with("limit", json!({ "name": name, "max": max }))
    }

    /// Adds a member.
    pub(crate) fn with(mut self, scheduled: &str, value: Value) -> Self {
        self.members.insert(scheduled.to_owned(), value);
        self
    }

    /// Says when to try again, in seconds.
    pub(crate) fn retry_after(mut self, seconds: u32) -> Self {
        self.retry_after = Some(seconds);
        self
    }

    /// Its slug and sentence: what a job remembers of it.
    pub(crate) fn into_failure(self) -> Failure {
        Failure { slug: self.kind.page().0.into(), detail: self.detail }
    }

    /// Problems of a scene. Text that cannot even be read as its format is the request's fault, not the scene's.
    pub(crate) fn scene(problems: &scene::Problems) -> Self {
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
    pub(crate) fn status(&self) -> StatusCode {
        let (_, status, _, _) = self.kind.page();
        status
    }

    /// Why a request was refused that would have been welcome at another time.
    pub(crate) fn shed(&self) -> Option<&'static str> {
        let (slug, _, _, _) = self.kind.page();
        matches!(self.kind, Kind::Saturated | Kind::Draining | Kind::RateLimited).then_some(slug)
    }

    /// The document; the request's id completes it.
    pub(crate) fn document(self, request_id: &str) -> String {
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
    pub(crate) fn answer(self, request_id: &str) -> Response {
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
