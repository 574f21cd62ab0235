//! Changing, canceling and deleting jobs.

use super::ID;
use crate::http::extract::named_job::NamedJob;
use crate::http::extract::{body, json_body};
use crate::http::prelude::*;
use crate::http::respond::blocking;
use crate::http::respond::job::{JobView, holds, shown, tag_of};
use crate::service::error::Error;
use crate::service::jobs::Job;
use axum::body::Body as RequestBody;
use std::io;

/// Most bytes of a change.
const CHANGE_BYTES: usize = 4_096;

pub(super) fn routes() -> Vec<Route> {
    let job = [Content::json::<JobView>()];
    let tag = "The job's ETag: nothing is done if the job has been changed since.";
    let about_forget = "Forgets a job, its picture included; it is stopped first if it still runs. It costs no units.";
    vec![
        Route::patch(
            "/v1/jobs/{id}",
            change,
            ["changeJob", "jobs", "Changes a job's priority, by a JSON merge patch."],
        )
        .needs(Scope::Jobs)
        .path("id", ID)
        .header("If-Match", "The job's ETag: the change is refused if the job has been changed since.")
        .body(Body::json::<JobChange>("What is to be changed").or("application/merge-patch+json"))
        .answer(200, "The job", &job),
        // Who has no units left must be able to stop what takes them.
        Route::post("/v1/jobs/{id}/cancel", cancel, ["cancelJob", "jobs", "Stops a job. It costs no units."])
            .needs(Scope::Jobs)
            .free()
            .path("id", ID)
            .header("If-Match", tag)
            .answer(202, "The job, which stops within a tenth of a second", &job),
        Route::delete("/v1/jobs/{id}", forget, ["forgetJob", "jobs", about_forget])
            .needs(Scope::Jobs)
            .free()
            .path("id", ID)
            .header("If-Match", tag)
            .answer(204, "It is forgotten", &[]),
    ]
}

/// A change of a job.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct JobChange {
    /// 0 to 100.
    #[schemars(range(min = 0, max = 100))]
    priority: Option<u8>,
}

async fn change(
    State(app): State<App>,
    NamedJob { job, tenant }: NamedJob,
    headers: HeaderMap,
    body: RequestBody,
) -> Result<Response, Problem> {
    let expected = "the body is {\"priority\": N}, N from 0 to 100";
    body::declares_patch(&headers)?;
    let body = body::read(&app, &tenant, &headers, body).await?;
    if body.as_ref().len() > CHANGE_BYTES {
        return Err(Problem::new(Kind::InvalidRequest, expected));
    }
    let change: JobChange = json_body::read(body.as_ref(), expected)?;
    if change.priority.is_some_and(|priority| priority > 100) {
        return Err(Problem::new(Kind::InvalidRequest, expected));
    }
    let conditions = headers.clone();
    let is_wanted = move |version: u64| holds(&conditions, version);
    let other = |version: u64| other_version(&headers, version);
    let version = job.record().version;
    if !is_wanted(version) {
        return Err(other(version));
    }
    if let Some(priority) = change.priority {
        if job.record().state.is_final() {
            return Err(over(&job));
        }
        let (jobs, changed) = (Arc::clone(&app.service.jobs), Arc::clone(&job));
        let is_changed = blocking(move || jobs.set_priority(&changed, priority, is_wanted)).await?.map_err(not_kept)?;
        if !is_changed {
            // Somebody has changed it since.
            return Err(other(job.record().version));
        }
    }
    Ok(shown(&app, &job).await)
}

/// The job has another version than the request wants.
fn other_version(headers: &HeaderMap, version: u64) -> Problem {
    let is = tag_of(version);
    let wanted = headers.get(header::IF_MATCH).and_then(|wanted| wanted.to_str().ok());
    let detail = match wanted {
        Some(wanted) => format!("the job is {is} by now, not {wanted}"),
        None => format!("the job is {is}, which If-None-Match excludes"),
    };
    Problem::new(Kind::PreconditionFailed, detail)
}

/// Refuses to act on a job if the conditions of the request do not hold.
fn check_conditions(headers: &HeaderMap, job: &Job) -> Result<(), Problem> {
    let version = job.record().version;
    if holds(headers, version) { Ok(()) } else { Err(other_version(headers, version)) }
}

async fn cancel(
    State(app): State<App>,
    NamedJob { job, .. }: NamedJob,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    check_conditions(&headers, &job)?;
    let canceled = {
        let (app, job) = (Arc::clone(&app), Arc::clone(&job));
        blocking(move || app.service.jobs.cancel(&job)).await?.map_err(not_kept)?
    };
    if canceled { Ok((StatusCode::ACCEPTED, shown(&app, &job).await).into_response()) } else { Err(over(&job)) }
}

/// The change cannot be written where records live.
fn not_kept(error: io::Error) -> Problem {
    Error::io("the change cannot be kept", &error).into()
}

/// It has ended, so there is nothing to change.
fn over(job: &Job) -> Problem {
    let record = job.record();
    Problem::new(Kind::Conflict, format!("job {} is {} already", record.id, record.state.name()))
}

async fn forget(
    State(app): State<App>,
    NamedJob { job, .. }: NamedJob,
    headers: HeaderMap,
) -> Result<StatusCode, Problem> {
    check_conditions(&headers, &job)?;
    blocking(move || app.service.jobs.forget(&job)).await?.map_err(not_kept)?;
    Ok(StatusCode::NO_CONTENT)
}
