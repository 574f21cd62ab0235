//! `GET /v1/jobs/{id}`, `GET /v1/jobs`: a job, and the list of the tenant's jobs.

use super::ID;
use crate::http::extract::conditions::{Verdict, weigh};
use crate::http::extract::named_job::{NamedJob, may_see};
use crate::http::extract::prefer::Prefer;
use crate::http::prelude::*;
use crate::http::respond::job::{JobView, shown, until_final};
use crate::http::respond::{blocking, put};
use crate::service::jobs::record::{Record, State as JobState, is_job_id};
use axum::Extension;
use axum::body::Body as AnswerBody;
use axum::http::Method;

/// Default and most jobs of a page.
const PAGE: [u32; 2] = [50, 200];

pub(super) fn routes() -> Vec<Route> {
    vec![
        Route::get("/v1/jobs/{id}", job, ["job", "jobs", "A job, whatever its state."])
            .needs(Scope::Read)
            .path("id", ID)
            .header("Prefer", "`wait=20` waits up to 20 seconds for the job to end.")
            .header("If-None-Match", "The ETag of what the client knows of it: 304 if nothing else is to be said.")
            .header("If-Match", "An ETag of it: 412 if there is something else to be said.")
            .answer(200, "The job", &[Content::json::<JobView>()])
            .answer(304, "Nothing else is to be said of it", &[]),
        Route::get("/v1/jobs", jobs, ["jobs", "jobs", "The tenant's jobs, the newest first."])
            .needs(Scope::Read)
            .query(filters)
            .answer(200, "The jobs; `Link` with `rel=\"next\"` leads to the next page.", &[Content::json::<JobList>()]),
    ]
}

/// Jobs, the newest first.
#[derive(Debug, Serialize, JsonSchema)]
struct JobList {
    /// The jobs.
    jobs: Vec<JobView>,
    /// `cursor` of the next page; null on the last one.
    next: Option<String>,
}

async fn job(
    State(app): State<App>,
    NamedJob { job, tenant }: NamedJob,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let prefer = Prefer { respond_async: false, ..Prefer::of(&headers) };
    if let Some(wait) = prefer.wait {
        until_final(&app, &tenant, &job, wait).await?;
    }
    let mut response = shown(&app, &job).await;
    let etag = response.headers().get(header::ETAG).and_then(|etag| etag.to_str().ok());
    match weigh(&method, &headers, etag) {
        Verdict::Proceed => {}
        Verdict::NotModified => {
            *response.status_mut() = StatusCode::NOT_MODIFIED;
            *response.body_mut() = AnswerBody::empty();
            response.headers_mut().remove(header::CONTENT_TYPE);
        }
        Verdict::Failed => {
            let detail = "the job is not as If-Match says";
            return Err(Problem::new(Kind::PreconditionFailed, detail));
        }
    }
    prefer.add_applied(response.headers_mut());
    Ok(response)
}

/// Filters of the list.
struct Filters {
    state: Option<JobState>,
    label: Option<String>,
    limit: usize,
    cursor: Option<String>,
}

fn filters(query: &mut Query) -> Filters {
    Filters {
        state: query.word("state", "Only those in this state."),
        label: query.text("label", "Only those with this label."),
        limit: query.count("limit", "How many at most, 50 by default.", PAGE[1]).unwrap_or(PAGE[0]) as usize,
        cursor: cursor(query),
    }
}

/// The id of the last job of the page before.
fn cursor(query: &mut Query) -> Option<String> {
    let cursor = query.text("cursor", "Where the page before ended: its `next`.")?;
    if !is_job_id(&cursor) {
        query.wrong("cursor", "out-of-range", format!("expected `next` of the page before, got \"{cursor}\""));
    }
    Some(cursor)
}

async fn jobs(
    State(app): State<App>,
    Extension(tenant): Extension<Arc<Tenant>>,
    request: Request,
) -> Result<Response, Problem> {
    let Filters { state, label, limit, cursor } = Query::read(request.uri(), filters)?;
    app.service.jobs.catch_up().await;
    let of_label = label.clone();
    // Each place in a long queue is counted.
    let (jobs, next) = blocking(move || {
        let wanted = |record: &Record| {
            may_see(&tenant, record)
                && state.is_none_or(|state| record.state == state)
                && of_label.as_ref().is_none_or(|label| record.labels.contains(label))
        };
        let mut found = app.service.jobs.list(cursor.as_deref(), limit + 1, wanted);
        let more = found.len() > limit;
        found.truncate(limit);
        let next = found.last().filter(|_| more).map(|job| job.record().id.clone());
        let jobs: Vec<JobView> = found.iter().map(|job| JobView::of(&app, job)).collect();
        (jobs, next)
    })
    .await?;
    let mut headers = HeaderMap::new();
    if let Some(next) = &next {
        let filters = [("state", state.map(|state| state.name().to_owned())), ("label", label)];
        let filters: String =
            filters.into_iter().filter_map(|(name, value)| Some(format!("&{name}={}", encoded(&value?)))).collect();
        put(&mut headers, header::LINK, &format!("</v1/jobs?limit={limit}&cursor={next}{filters}>; rel=\"next\""));
    }
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    Ok((headers, Json(JobList { jobs, next })).into_response())
}

/// Percent-encodes text for a query.
fn encoded(text: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~".contains(&byte);
    text.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}
