//! Errors as RFC 9457 problem documents. Handlers return a [`Problem`], and the request log writes it with the request's id.

mod kind;

pub(crate) use kind::Kind;

use crate::service::error::Error;
use crate::service::jobs::record::Failure;
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use std::fmt::Write;
use strahl::scene;
use strahl::scene::limits::PROBLEMS;

/// Most bytes of a detail.
const DETAIL: usize = 2_048;

/// An error on its way to a client.
#[derive(Debug, Clone)]
pub(crate) struct Problem {
    kind: Kind,
    detail: String,
    members: Box<Members>,
    retry_after: Option<u32>,
    /// What bodies may be instead, and the header that says so.
    takes: Option<(HeaderName, &'static str)>,
}

/// A problem (RFC 9457).
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ProblemDocument {
    #[serde(flatten)]
    summary: ProblemSummary,
    /// The request's id, as in `X-Request-Id`.
    instance: String,
    #[serde(flatten)]
    members: Members,
}

/// A problem inside of another document.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "JobFailure")]
pub(crate) struct ProblemSummary {
    /// Path of the page about this kind of problem, `/problems/{slug}`.
    #[schemars(extend("format" = "uri-reference", "example" = "/problems/invalid-scene"))]
    r#type: String,
    /// What kind of problem it is.
    title: &'static str,
    /// The status that an answer with this problem has.
    #[schemars(range(min = 400, max = 599))]
    status: u16,
    /// What is wrong, and what to do.
    detail: String,
}

/// Members that only some problems have.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
struct Members {
    /// What is wrong, one by one, up to the limit `problems`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    errors: Vec<ErrorEntry>,
    /// Number of further errors. The check stops after a thousand.
    #[serde(skip_serializing_if = "is_zero")]
    more: usize,
    /// The limit that was exceeded; `/v1/limits` has all limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    limit: Option<LimitEntry>,
    /// Of assets that are missing: the SHA-256 of each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    missing: Vec<String>,
    /// With 406: the formats there are.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    available: Vec<&'static str>,
    /// With 403: the scope that the key lacks.
    #[serde(skip_serializing_if = "Option::is_none")]
    scope: Option<&'static str>,
    /// What to do instead, as one word.
    #[serde(skip_serializing_if = "Option::is_none")]
    suggest: Option<&'static str>,
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// One thing that is wrong.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub(crate) struct ErrorEntry {
    /// Where it is in the body: a JSON pointer as a URI fragment.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("example" = "#/objects/3/sphere/radius"))]
    pub(crate) pointer: Option<String>,
    /// The query parameter that is wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) parameter: Option<String>,
    /// The kind of mistake.
    #[schemars(with = "String")]
    pub(crate) code: Value,
    /// What is wrong, and what to do.
    pub(crate) detail: String,
    /// Line in the body, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) line: Option<u64>,
    /// Column in the line, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) column: Option<u64>,
    /// Offset in a binary body, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) offset: Option<u64>,
}

/// A limit by name.
#[derive(Debug, Clone, Serialize, JsonSchema)]
struct LimitEntry {
    /// Its name in `/v1/limits`.
    name: &'static str,
    /// The largest value allowed.
    max: u64,
}

impl ErrorEntry {
    /// An error of a kind.
    pub(crate) fn new(code: &'static str, detail: impl Into<String>) -> Self {
        Self { code: code.into(), detail: shortened(detail.into()), ..Self::default() }
    }
}

impl ProblemSummary {
    /// The problem that a job has failed with.
    pub(crate) fn of(failure: &Failure) -> Self {
        let kind = Kind::by_slug(&failure.slug).unwrap_or(Kind::Internal);
        Self::new(kind, failure.detail.clone())
    }

    fn new(kind: Kind, detail: String) -> Self {
        let (slug, status, title, _) = kind.page();
        Self { r#type: format!("/problems/{slug}"), title, status: status.as_u16(), detail }
    }
}

impl From<Error> for ProblemSummary {
    fn from(error: Error) -> Self {
        let Problem { kind, detail, .. } = error.into();
        Self::new(kind, detail)
    }
}

impl Problem {
    /// Its kind.
    pub(crate) fn kind(&self) -> Kind {
        self.kind
    }

    /// A problem with its detail.
    pub(crate) fn new(kind: Kind, detail: impl Into<String>) -> Self {
        Self { kind, detail: shortened(detail.into()), members: Box::default(), retry_after: None, takes: None }
    }

    /// A limit, by name.
    pub(crate) fn limit(kind: Kind, name: &'static str, max: u64, detail: impl Into<String>) -> Self {
        let mut problem = Self::new(kind, detail);
        problem.members.limit = Some(LimitEntry { name, max });
        problem
    }

    /// Adds the list of errors.
    pub(crate) fn with_errors(mut self, errors: Vec<ErrorEntry>) -> Self {
        self.members.more += errors.len().saturating_sub(PROBLEMS.max as usize);
        self.members.errors = errors;
        self.members.errors.truncate(PROBLEMS.max as usize);
        self
    }

    /// Adds the formats there are.
    pub(crate) fn with_available(mut self, available: Vec<&'static str>) -> Self {
        self.members.available = available;
        self
    }

    /// Says in a header what bodies may be. Only for who sent something else: with other problems the header would mislead
    /// (RFC 9110 section 12.5.3).
    pub(crate) fn taking(self, header: HeaderName, what: &'static str) -> Self {
        Self { takes: Some((header, what)), ..self }
    }

    /// Adds the scope that the key lacks.
    pub(crate) fn with_scope(mut self, scope: &'static str) -> Self {
        self.members.scope = Some(scope);
        self
    }

    /// Says when to try again, in seconds.
    pub(crate) fn retry_after(mut self, seconds: u32) -> Self {
        self.retry_after = Some(seconds);
        self
    }

    /// Problems of a scene.
    pub(crate) fn scene(problems: &scene::Problems) -> Self {
        let Failure { slug, detail } = problems.into();
        let kind = Kind::by_slug(&slug).unwrap_or(Kind::InvalidScene);
        let (reported, more) = problems.reported();
        let mut problem =
            if more > 0 { Self::limit(kind, PROBLEMS.name, PROBLEMS.max, detail) } else { Self::new(kind, detail) };
        problem.members.more = more;
        problem.members.missing = problems.0.iter().filter_map(|problem| problem.lacks()).map(str::to_owned).collect();
        problem.with_errors(reported.iter().map(error_entry).collect())
    }

    /// Problems of a kind with the shape of a body, or the one that it is no JSON. `about` says what the body is.
    pub(crate) fn body(kind: Kind, about: &str, problems: &scene::Problems) -> Self {
        let mut problem = Self::scene(problems);
        if problem.kind == Kind::InvalidScene {
            problem.kind = kind;
        }
        problem.detail = shortened(format!("{about}: {}", problem.detail));
        problem
    }

    /// Its status.
    pub(crate) fn status(&self) -> StatusCode {
        let (_, status, _, _) = self.kind.page();
        status
    }

    /// The label of this problem in the metric `shed`, if the request would be accepted at another time.
    pub(crate) fn shed(&self) -> Option<&'static str> {
        let (slug, _, _, _) = self.kind.page();
        matches!(self.kind, Kind::Saturated | Kind::Draining | Kind::RateLimited).then_some(slug)
    }

    /// The document with the request's id.
    pub(crate) fn document(self, request_id: &str) -> String {
        let summary = ProblemSummary::new(self.kind, self.detail);
        let document = ProblemDocument { summary, instance: request_id.into(), members: *self.members };
        // Strings and numbers can always be written as JSON.
        serde_json::to_string(&document).unwrap_or_default()
    }

    /// The answer with the request's id.
    pub(crate) fn answer(self, request_id: &str) -> Response {
        let (kind, status, retry_after, takes) = (self.kind, self.status(), self.retry_after, self.takes.clone());
        let mut response = (status, self.document(request_id)).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        if matches!(kind, Kind::TooLarge | Kind::BodyTimeout) {
            // The rest of the body is not read, so no other request can follow.
            headers.insert(header::CONNECTION, HeaderValue::from_static("close"));
        }
        if kind == Kind::Unauthorized {
            headers.insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer realm=\"strahl\""));
        }
        if let Some((name, what)) = takes {
            headers.insert(name, HeaderValue::from_static(what));
        }
        if let Some(seconds) = retry_after {
            headers.insert(header::RETRY_AFTER, seconds.into());
        }
        response
    }
}

impl From<Error> for Problem {
    fn from(error: Error) -> Self {
        match error {
            Error::Scene(problems) => Self::scene(&problems),
            Error::UnknownScene(id) => {
                let detail = format!("the scene {id} is not known here, or no longer: send it to POST /v1/scenes");
                Self::new(Kind::NotFound, detail)
            }
            Error::OtherBytes { expected, hash } => {
                let detail = format!("the body has the SHA-256 {hash}, not {expected}");
                Self::new(Kind::AssetMismatch, detail)
            }
            Error::NoIds(detail) => Self::new(Kind::InvalidScene, detail),
            Error::OutOfRange(detail) => Self::new(Kind::InvalidParameter, detail),
            Error::InUse(detail) => Self::new(Kind::Conflict, detail),
            Error::Limit { name, max, detail } => Self::limit(Kind::CostLimit, name, max, detail),
            Error::TooLarge(detail) => Self::new(Kind::TooLarge, detail),
            Error::Busy { detail, retry_after } => Self::new(Kind::Saturated, detail).retry_after(retry_after),
            Error::TenantBusy { detail, retry_after } => Self::new(Kind::RateLimited, detail).retry_after(retry_after),
            Error::Deadline(detail) => {
                let ways = "ask for fewer pixels (maps take `step`), or for accuracy=time:MS, the best picture in MS \
                            milliseconds; a picture may also be a job, which has no such timeout (Prefer: respond-async)";
                let mut problem = Self::new(Kind::RenderDeadline, format!("{detail}: {ways}"));
                problem.members.suggest = Some("tiles");
                problem
            }
            Error::Cancelled => Self::new(Kind::RenderDeadline, "the request was given up"),
            Error::Internal(detail) => Self::new(Kind::Internal, detail),
        }
    }
}

impl IntoResponse for Problem {
    /// Only carries the problem to the request log, which knows the request's id.
    fn into_response(self) -> Response {
        let mut response = self.status().into_response();
        response.extensions_mut().insert(self);
        response
    }
}

/// A detail without its middle if it is long, since it may quote the request.
fn shortened(detail: String) -> String {
    if detail.len() <= DETAIL {
        return detail;
    }
    let letters = DETAIL / 8;
    let begin: String = detail.chars().take(letters).collect();
    let end = detail.char_indices().rev().nth(letters - 1).map_or("", |(at, _)| &detail[at..]);
    format!("{begin}…{end}")
}

/// A scene's problem as an entry of `errors`.
fn error_entry(problem: &scene::Problem) -> ErrorEntry {
    ErrorEntry {
        pointer: Some(format!("#{}", fragment(&problem.pointer))),
        code: serde_json::to_value(problem.code).unwrap_or_default(),
        detail: shortened(problem.detail.clone()),
        line: problem.line.map(u64::from),
        column: problem.column.map(u64::from),
        offset: problem.offset,
        ..ErrorEntry::default()
    }
}

/// A JSON pointer as a URI fragment (RFC 6901 section 6): bytes that a fragment cannot hold are percent-encoded.
pub(crate) fn fragment(pointer: &str) -> String {
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
    use strahl::scene::problem::Code;

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
