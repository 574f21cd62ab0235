//! Answers that several routes give: pictures, known images, jobs.

pub(crate) mod event_stream;
pub(crate) mod events;
pub(crate) mod forward;
pub(crate) mod image;
pub(crate) mod job;
pub(crate) mod message;
mod multipart;
pub(crate) mod picture;
pub(crate) mod sequence;
pub(crate) mod streamed;
pub(crate) mod submission;
pub(crate) mod turntable;

use super::problem::{Kind, Problem};
use crate::service::memory_budget::{MemoryBudget, MeteredBytes};
use crate::service::pictures::warnings;
use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use data_encoding::BASE64;
use serde::Serialize;
use strahl::scene;

/// The answer to a question about a scene.
#[derive(Debug)]
pub(crate) struct Answer {
    media_type: &'static str,
    body: Body,
    /// The line with the warnings of the scene.
    warnings: Option<String>,
}

impl Answer {
    /// A body of a media type.
    pub(crate) fn new(media_type: &'static str, body: Body) -> Self {
        Self { media_type, body, warnings: None }
    }

    /// The same with the warnings of its scene as a header.
    pub(crate) fn warning(self, warnings: &[scene::Problem]) -> Self {
        Self { warnings: warnings::line(warnings, None), ..self }
    }
}

impl IntoResponse for Answer {
    fn into_response(self) -> Response {
        let mut response = ([(header::CONTENT_TYPE, self.media_type)], self.body).into_response();
        put_warnings(response.headers_mut(), self.warnings.as_deref());
        response
    }
}

/// Sets the header with warnings, if there are any.
pub(crate) fn put_warnings(headers: &mut HeaderMap, line: Option<&str>) {
    if let Some(line) = line {
        put(headers, HeaderName::from_static(warnings::NAME), line);
    }
}

/// Bytes as the body of an answer. They keep their share of the memory until they are sent.
pub(crate) fn body(bytes: MeteredBytes) -> Body {
    Body::from(Bytes::from_owner(bytes))
}

/// A value that is not large as an answer.
pub(crate) fn to_json(memory: &MemoryBudget, value: &impl Serialize) -> Result<Answer, Problem> {
    let json = serde_json::to_vec(value).map_err(|error| {
        tracing::error!(%error, "an answer cannot be written as JSON");
        Problem::new(Kind::Internal, "the answer cannot be written")
    })?;
    Ok(Answer::new("application/json", body(memory.metered(json)?)))
}

/// Sets a header. Values are ASCII: ids, numbers, names of effects.
pub(crate) fn put(headers: &mut HeaderMap, name: HeaderName, value: &str) {
    if let Ok(value) = HeaderValue::from_str(value) {
        headers.insert(name, value);
    }
}

/// The value of `Repr-Digest` (RFC 9530) for a SHA-256.
pub(crate) fn repr_digest(sha256: &[u8]) -> String {
    format!("sha-256=:{}:", BASE64.encode(sha256))
}

/// Runs work that may wait for the disk, on a thread for such work.
pub(crate) async fn blocking<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T, Problem> {
    tokio::task::spawn_blocking(work).await.map_err(|_| Problem::new(Kind::Internal, "the request failed"))
}
