//! Changing a job: its priority, and whether it goes on.

use super::shown;
use super::view::etag;
use crate::http::App;
use crate::http::contract::jobs::JobView;
use crate::http::extract::named_job::Named;
use crate::http::problem::{Kind, Problem};
use crate::service::jobs::Job;
use axum::body::{Body, to_bytes};
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use std::sync::Arc;
use utoipa::ToSchema;

/// Bytes of a change.
const CHANGE_BYTES: usize = 4_096;

/// What may be changed.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = JobChange)]
pub(crate) struct Change {
    /// 0 to 100.
    #[schema(minimum = 0, maximum = 100)]
    priority: Option<u8>,
}

/// Changes a job's priority, by a JSON merge patch.
#[utoipa::path(
    patch, path = "/v1/jobs/{id}", operation_id = "changeJob", tag = "jobs",
    params(
        ("id" = String, Path, description = "The job's id."),
        ("If-Match" = Option<String>, Header, description = "The job's ETag: refused if somebody has changed it since."),
    ),
    request_body(description = "What is to be changed", content((Change = "application/merge-patch+json"), (Change = "application/json"))),
    responses((status = 200, description = "The job", body = JobView)),
)]
pub(crate) async fn change_job(
    State(service): State<App>,
    Named { job, .. }: Named,
    headers: HeaderMap,
    body: Body,
) -> Result<Response, Problem> {
    let expected = "the body is {\"priority\": N}, N from 0 to 100";
    let body = to_bytes(body, CHANGE_BYTES).await.map_err(|_| Problem::new(Kind::InvalidRequest, expected))?;
    let change: Change = serde_json::from_slice(&body)
        .map_err(|error| Problem::new(Kind::InvalidRequest, format!("{expected}: {error}")))?;
    if change.priority.is_some_and(|priority| priority > 100) {
        return Err(Problem::new(Kind::InvalidRequest, expected));
    }
    if let Some(wanted) = headers.get(header::IF_MATCH).and_then(|wanted| wanted.to_str().ok()) {
        let version = etag(job.record().version);
        if wanted.trim() != "*" && !wanted.split(',').any(|tag| tag.trim() == version) {
            return Err(Problem::new(Kind::PreconditionFailed, format!("the job is {version} by now, not {wanted}")));
        }
    }
    if let Some(priority) = change.priority {
        if job.record().state.is_final() {
            return Err(over(&job));
        }
        let (service, job) = (Arc::clone(&service), Arc::clone(&job));
        blocking(move || service.jobs.set_priority(&job, priority)).await?.map_err(|error| {
            tracing::error!(%error, "a record cannot be written");
            Problem::new(Kind::Internal, "the change cannot be kept")
        })?;
    }
    Ok(shown(&service, &job).await)
}

/// Stops a job.
#[utoipa::path(
    post, path = "/v1/jobs/{id}/cancel", operation_id = "cancelJob", tag = "jobs",
    params(("id" = String, Path, description = "The job's id.")),
    responses((status = 202, description = "The job, which stops within a tenth of a second", body = JobView)),
)]
pub(crate) async fn cancel_job(State(service): State<App>, Named { job, .. }: Named) -> Result<Response, Problem> {
    let canceled = {
        let (service, job) = (Arc::clone(&service), Arc::clone(&job));
        blocking(move || service.jobs.cancel(&job)).await?
    };
    if canceled { Ok((StatusCode::ACCEPTED, shown(&service, &job).await).into_response()) } else { Err(over(&job)) }
}

/// It has ended, so there is nothing to change.
fn over(job: &Job) -> Problem {
    let record = job.record();
    Problem::new(Kind::Conflict, format!("job {} is {} already", record.id, record.state.name()))
}

/// Forgets a job, its picture included; it is stopped first if it still runs.
#[utoipa::path(
    delete, path = "/v1/jobs/{id}", operation_id = "forgetJob", tag = "jobs",
    params(("id" = String, Path, description = "The job's id.")),
    responses((status = 204, description = "It is forgotten")),
)]
pub(crate) async fn forget_job(State(service): State<App>, Named { job, .. }: Named) -> Result<StatusCode, Problem> {
    let service = Arc::clone(&service);
    blocking(move || service.jobs.forget(&job)).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Work that writes to disk, on a thread that may wait for it.
pub(crate) async fn blocking<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T, Problem> {
    tokio::task::spawn_blocking(work).await.map_err(|_| Problem::new(Kind::Internal, "the request failed"))
}
