//! Submissions of jobs: their keys, what is delivered after them, and the answer.

use super::job::shown;
use super::{blocking, put};
use crate::http::auth::tenant::Tenant;
use crate::http::extract::prefer::Prefer;
use crate::http::problem::{Kind, Problem};
use crate::http::state::{App, AppState};
use crate::service::deliveries::key::KeyTemplate;
use crate::service::deliveries::receiver::Rules;
use crate::service::error::Error;
use crate::service::hash::sha256_of_parts;
use crate::service::jobs::record::Idempotency;
use crate::service::jobs::{Claim, Job, KeyUse};
use crate::service::memory_budget::MeteredBytes;
use crate::service::requests::jobs::{WantedJob, Wishes};
use crate::service::requests::pictures::HASHED_AT_ONCE;
use crate::service::scheduler::task::Class;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Most characters of an idempotency key.
const KEY: usize = 255;

/// A submission's idempotency key.
#[derive(Debug)]
pub(crate) enum Claimed {
    /// The same submission has made this job before.
    Before(Arc<Job>),
    /// The submission is new, or has no key.
    Now(Option<Claim>),
}

/// The SHA-256 of a request: of what stands for it beside the body, and of the body.
pub(crate) async fn hash_of(beside: Vec<u8>, body: MeteredBytes) -> Result<(String, MeteredBytes), Problem> {
    let is_long = body.len() >= HASHED_AT_ONCE;
    let hash = move || (sha256_of_parts([&beside, body.as_ref()]), body);
    if is_long { blocking(hash).await } else { Ok(hash()) }
}

/// Claims the key of a submission, if it has one. Also returns the body.
pub(crate) async fn claim(
    app: &AppState,
    tenant: &Tenant,
    headers: &HeaderMap,
    beside: Vec<u8>,
    body: MeteredBytes,
) -> Result<(Claimed, MeteredBytes), Problem> {
    let Some(key) = headers.get("idempotency-key") else { return Ok((Claimed::Now(None), body)) };
    let (hash, body) = hash_of(beside, body).await?;
    Ok((claim_by(app, tenant, key, &hash).await?, body))
}

/// Claims a key for a request of this hash.
async fn claim_by(app: &AppState, tenant: &Tenant, key: &HeaderValue, hash: &str) -> Result<Claimed, Problem> {
    let key =
        key.to_str().ok().filter(|key| (1..=KEY).contains(&key.len())).ok_or_else(|| {
            Problem::new(Kind::InvalidRequest, format!("Idempotency-Key is 1 to {KEY} letters of ASCII"))
        })?;
    let (jobs, tenant) = (Arc::clone(&app.service.jobs), tenant.name.clone());
    let same = Idempotency::of(key, hash);
    match blocking(move || jobs.claim(&tenant, same)).await? {
        Ok(claim) => Ok(Claimed::Now(Some(claim))),
        Err(KeyUse::Same(job)) => Ok(Claimed::Before(job)),
        Err(KeyUse::Other) => {
            let detail = "this Idempotency-Key was used for another request; use a new one for a new job";
            Err(Problem::new(Kind::IdempotencyKeyReused, detail))
        }
        Err(KeyUse::Pending) => {
            let detail =
                "the first request with this Idempotency-Key is still being accepted; send it again in a moment";
            Err(Problem::new(Kind::Conflict, detail).retry_after(1))
        }
        Err(KeyUse::Unknown(error)) => {
            tracing::error!(%error, "an idempotency key cannot be claimed");
            let detail = "the farm's broker takes nothing now; the service's log says why";
            Err(Problem::new(Kind::Saturated, detail).retry_after(5))
        }
    }
}

/// Claims a key that the client does not know of. Of several at one time the first submits the job, and the others wait for it.
pub(crate) async fn claim_in_turn(
    app: &AppState,
    tenant: &Tenant,
    key: &HeaderValue,
    hash: &str,
) -> Result<Claimed, Problem> {
    let end = Instant::now() + app.service.settings.answers.timeout;
    loop {
        match claim_by(app, tenant, key, hash).await {
            Err(problem) if problem.kind() == Kind::Conflict && Instant::now() < end => {
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
            claimed => return claimed,
        }
    }
}

/// Submits a job.
pub(crate) async fn submitted(
    app: &AppState,
    tenant: &Tenant,
    wanted: WantedJob,
    claim: Option<Claim>,
) -> Result<Arc<Job>, Problem> {
    let task = tenant.task(Class::Renders);
    app.service.submit(task, tenant.quotas.jobs, wanted, claim).await.map_err(|error| match error {
        // What helps against a render's deadline does not help where a scene was not built in time.
        Error::Deadline(detail) => {
            let ways = "nothing was submitted; send the job again when less is rendered, or a scene with less in it";
            Problem::new(Kind::Saturated, format!("{detail}, before the scene was built and priced: {ways}"))
                .retry_after(30)
        }
        error => error.into(),
    })
}

/// What is delivered after a job of a tenant: to the receiver that it names, or else to the tenant's own.
pub(crate) fn wishes_of(
    app: &AppState,
    tenant: &Tenant,
    key: Option<KeyTemplate>,
    webhook: Option<String>,
) -> Result<Wishes, Problem> {
    let invalid = |detail: String| Problem::new(Kind::InvalidRequest, detail);
    if key.is_some() && app.service.store.is_none() {
        return Err(invalid(
            "this service has no store (--store): fetch the picture from the job's links instead".into(),
        ));
    }
    if let Some(url) = &webhook {
        Rules::of(&app.service.settings.deliveries).check(url).map_err(invalid)?;
        if tenant.webhook.secret.is_none() {
            let whose = if tenant.is_anonymous() { "the service" } else { "your tenant" };
            return Err(invalid(format!(
                "{whose} has no secret to sign messages with: its operator makes one with `strahl key webhook`"
            )));
        }
    }
    Ok(Wishes { key, webhook: webhook.or_else(|| tenant.webhook.url.clone()) })
}

/// The answer to a submission. `again` if the same request has made this job before.
pub(crate) async fn accepted(app: &App, job: &Arc<Job>, again: bool, prefer: Prefer) -> Response {
    let mut response = (StatusCode::ACCEPTED, shown(app, job).await).into_response();
    let headers = response.headers_mut();
    put(headers, header::LOCATION, &format!("/v1/jobs/{}", job.record().id));
    if again {
        headers.insert(HeaderName::from_static("idempotency-replayed"), HeaderValue::from_static("true"));
    }
    prefer.add_applied(headers);
    response
}
