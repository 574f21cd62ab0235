//! Answers that several routes give: pictures, known images, jobs.

pub(crate) mod elsewhere;
pub(crate) mod events;
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
use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderName, HeaderValue};
use serde::Serialize;

/// A media type and a body of it.
pub(crate) type Answer = (&'static str, Body);

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
    Ok(("application/json", body(memory.metered(json)?)))
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
