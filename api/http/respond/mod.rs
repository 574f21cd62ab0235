//! Answers that several routes give: pictures, known images, jobs.

pub(crate) mod image;
pub(crate) mod job;
pub(crate) mod picture;

use super::problem::{Kind, Problem};
use axum::http::{HeaderMap, HeaderName, HeaderValue};
use serde::Serialize;

/// A media type and the bytes of an answer.
pub(crate) type Answer = (&'static str, Vec<u8>);

/// A value as an answer.
pub(crate) fn to_json(value: &impl Serialize) -> Result<Answer, Problem> {
    let json = serde_json::to_vec(value).map_err(|error| {
        tracing::error!(%error, "an answer cannot be written as JSON");
        Problem::new(Kind::Internal, "the answer cannot be written")
    })?;
    Ok(("application/json", json))
}

/// Sets a header. Values are ASCII: ids, numbers, names of effects.
pub(crate) fn put(headers: &mut HeaderMap, name: HeaderName, value: &str) {
    if let Ok(value) = HeaderValue::from_str(value) {
        headers.insert(name, value);
    }
}

/// Runs work that may wait for the disk, on a thread for such work.
pub(crate) async fn blocking<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T, Problem> {
    tokio::task::spawn_blocking(work).await.map_err(|_| Problem::new(Kind::Internal, "the request failed"))
}
