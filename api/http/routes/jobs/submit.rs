//! `POST /v1/jobs`, and what it shares with renders that become jobs.

use super::change::blocking;
use super::{shown, until_final};
use crate::http::auth::tenant::Tenant;
use crate::http::contract::jobs::{JobRequest, JobView};
use crate::http::extract::body;
use crate::http::extract::prefer::Prefer;
use crate::http::extract::query::Parameters;
use crate::http::problem::{Kind, Problem};
use crate::http::respond;
use crate::http::respond::image_of;
use crate::http::routes::render::{find as find_scene, gone};
use crate::http::{App, Service};
use crate::service::jobs::{Claim, Job, KeyUse, Refused, Submission};
use crate::service::limits::Limits;
use crate::service::pictures::spec::PictureSpec;
use crate::service::scenes::ids::ImageId;
use crate::service::scenes::prepared::planned;
use crate::service::scheduler::admission::{Work, task_of};
use crate::service::scheduler::task::{Class, PRIORITY};
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde_json::value::RawValue;
use serde_json::{Map, Value};
use std::sync::Arc;
use strahl::film::{FileFormat, Region};
use strahl::scene::description::Accuracy;
use strahl::scene::{Format, Overrides};

/// Labels of a job, and letters of each.
const LABELS: [usize; 2] = [16, 64];
/// Letters of an idempotency key.
const KEY: usize = 255;

/// The body.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Body<'a> {
    #[serde(borrow)]
    scene: &'a RawValue,
    #[serde(default)]
    settings: Map<String, Value>,
    #[serde(default)]
    output: Map<String, Value>,
    priority: Option<u8>,
    #[serde(default)]
    labels: Vec<String>,
}

/// What is to be rendered, and how it is to be kept.
#[derive(Debug)]
pub(crate) struct Wanted {
    pub(crate) scene: Vec<u8>,
    pub(crate) format: Format,
    pub(crate) overrides: Overrides,
    pub(crate) output: FileFormat,
    pub(crate) priority: u8,
    pub(crate) labels: Vec<String>,
}

/// Submits a job: a scene that is rendered as soon as there is time, also if the service is restarted meanwhile.
#[utoipa::path(
    post, path = "/v1/jobs", operation_id = "submitJob", tag = "jobs",
    params(
        ("Idempotency-Key" = Option<String>, Header, description = "A name for this submission: sent again with it, the same body gives the same job."),
        ("Prefer" = Option<String>, Header, description = "`wait=20` waits so many seconds for the job to end."),
    ),
    request_body(content((JobRequest = "application/json"))),
    responses(
        (status = 202, description = "The job", body = JobView, headers(("Location" = String, description = "The job's path."))),
    ),
)]
pub(crate) async fn submit_job(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    let tenant = Tenant::of(&parts.extensions);
    let read = async {
        if service.drain.has_begun() {
            let detail = "the service is about to stop and takes no new work";
            return Err(Problem::new(Kind::Draining, detail).retry_after(1));
        }
        Parameters::of(&parts.uri)?.finish()?;
        match body::scene_format(&parts.headers)? {
            Format::Json => Ok(()),
            Format::Nff => {
                let detail = "a job is application/json; for NFF use POST /v1/render with Prefer: respond-async";
                Err(Problem::new(Kind::UnsupportedMediaType, detail))
            }
        }
    };
    if let Err(problem) = read.await {
        body::discard(&service, &parts.headers, body).await;
        return Err(problem);
    }
    let text = body::read(&service, &parts.headers, body).await?;
    let claim = match claim(&service, &tenant, &parts.headers, text.as_ref())? {
        Claimed::Before(job) => return Ok(accepted(&service, &job, true, Prefer::default()).await),
        Claimed::Now(claim) => claim,
    };
    let wanted = wanted(text.as_ref())?;
    drop(text);
    let job = accept(&service, &tenant, wanted, claim).await?;
    let prefer = Prefer { respond_async: false, ..Prefer::of(&parts.headers) };
    if let Some(wait) = prefer.wait {
        until_final(&service, &job, wait).await;
    }
    Ok(accepted(&service, &job, false, prefer).await)
}

fn wanted(text: &[u8]) -> Result<Wanted, Problem> {
    let body: Body<'_> = serde_json::from_slice(text).map_err(|error| {
        let kind = if error.is_data() { Kind::InvalidRequest } else { Kind::InvalidJson };
        Problem::new(kind, format!("the body is {{\"scene\": {{...}}, \"settings\": {{...}}, ...}}: {error}"))
    })?;
    let Body { scene, settings, output, priority, labels } = body;
    let invalid = |detail: String| Problem::new(Kind::InvalidRequest, detail);
    let priority = priority.unwrap_or(PRIORITY);
    if priority > 100 {
        return Err(invalid(format!("priority is a whole number from 0 to 100, not {priority}")));
    }
    if labels.len() > LABELS[0] || labels.iter().any(|label| label.is_empty() || label.chars().count() > LABELS[1]) {
        return Err(invalid(format!("at most {} labels of 1 to {} letters each", LABELS[0], LABELS[1])));
    }
    let mut parameters = Parameters::given(settings);
    let overrides = parameters.overrides(Format::Json);
    parameters.finish()?;
    let mut parameters = Parameters::given(output);
    let output = parameters.picture_format(&HeaderMap::new())?;
    parameters.finish()?;
    Ok(Wanted { scene: scene.get().into(), format: Format::Json, overrides, output, priority, labels })
}

/// A submission's key.
#[derive(Debug)]
pub(crate) enum Claimed {
    /// The same submission has become this job.
    Before(Arc<Job>),
    /// It is the first, or has no key.
    Now(Option<Claim>),
}

/// Claims the key of a submission, if it has one.
pub(crate) fn claim(
    service: &Service,
    tenant: &Tenant,
    headers: &HeaderMap,
    request: &[u8],
) -> Result<Claimed, Problem> {
    let Some(key) = headers.get("idempotency-key") else { return Ok(Claimed::Now(None)) };
    let key =
        key.to_str().ok().filter(|key| (1..=KEY).contains(&key.len())).ok_or_else(|| {
            Problem::new(Kind::InvalidRequest, format!("Idempotency-Key is 1 to {KEY} letters of ASCII"))
        })?;
    match service.jobs.claim(&tenant.name, key, request) {
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
    }
}

/// Checks a scene and what it should take, and takes the job in.
pub(crate) async fn accept(
    service: &App,
    tenant: &Arc<Tenant>,
    wanted: Wanted,
    claim: Option<Claim>,
) -> Result<Arc<Job>, Problem> {
    let check = {
        let (service, tenant) = (Arc::clone(service), Arc::clone(tenant));
        move |work: &Work| {
            let Wanted { scene, format, overrides, output, priority, labels } = wanted;
            let ready = find_scene(&service, work, &scene, format, &overrides)?.ready;
            service.limits.check_job(&ready.scene)?;
            let size = [ready.scene.width, ready.scene.height];
            let region = Region::whole(size[0], size[1]);
            let (plan, _) = planned(&ready, region, &work.workers, &work.control).map_err(|_| gone())?;
            let estimate_ms = plan.estimate.map_or(0.0, |estimate| estimate.ms);
            check_time(&service, estimate_ms)?;
            Ok(Submission {
                tenant: tenant.name.clone(),
                weight: tenant.weight,
                most: tenant.quotas.jobs as usize,
                priority,
                labels,
                scene,
                format,
                overrides,
                output,
                names: image_of(&ready).map(|image| [image.scene.clone(), image.to_string()]),
                is_progressive: matches!(ready.render.accuracy(), Accuracy::Time(_) | Accuracy::Rays(_)),
                size,
                estimate_ms,
                scene_bytes: ready.scene.bytes() as u64,
            })
        }
    };
    let submission = service.queue.run(task_of(tenant, Class::Renders), check).await?.value;
    let made = match submission.names.as_ref().and_then(|[_, image]| ImageId::read(image)) {
        Some(image) => respond::kept(service, &image, &PictureSpec::plain(None, submission.output)).await,
        None => None,
    };
    let jobs = Arc::clone(&service.jobs);
    blocking(move || jobs.submit(submission, claim.as_ref(), made.as_deref()))
        .await?
        .map_err(|refused| refusal(&service.limits, &refused))
}

fn check_time(service: &Service, estimate_ms: f64) -> Result<(), Problem> {
    let most = service.jobs.limits.timeout.as_secs();
    if estimate_ms <= most as f64 * 1e3 {
        return Ok(());
    }
    let detail = format!(
        "it would take about {:.0} s on this machine; a job has at most {most} (job_timeout): fewer samples, a lower \
         max_depth or a smaller picture take less",
        estimate_ms / 1e3
    );
    Err(Problem::limit(Kind::CostLimit, "job_timeout", most, detail))
}

fn refusal(limits: &Limits, refused: &Refused) -> Problem {
    match refused {
        Refused::Full(seconds) => {
            Problem::new(Kind::Saturated, "as many jobs wait as there may be (jobs)").retry_after(*seconds)
        }
        Refused::TenantFull(seconds) => {
            let detail = "you have as many jobs that wait or run as you may have (jobs of your tenant)";
            Problem::new(Kind::RateLimited, detail).retry_after(*seconds)
        }
        Refused::TooLarge(bytes) => {
            let most = limits.job_memory_bytes;
            let detail = format!("it would take {bytes} bytes of memory; jobs have at most {most} (job_memory_bytes)");
            Problem::limit(Kind::CostLimit, "job_memory_bytes", most, detail)
        }
        Refused::TooLargeForDisk(bytes) => {
            let most = limits.data_bytes;
            let detail = format!(
                "its scene or its picture with all tiles would take {bytes} bytes on disk; half of {most} is there for \
                 either (data_bytes)"
            );
            Problem::limit(Kind::CostLimit, "data_bytes", most, detail)
        }
        Refused::NoRoom(seconds) => {
            let detail = "the scenes of other jobs take all the room there is for them (data_bytes)";
            Problem::new(Kind::Saturated, detail).retry_after(*seconds)
        }
        Refused::Disk(error) => {
            tracing::error!(%error, "a job cannot be written down");
            Problem::new(Kind::Internal, "the job cannot be written down")
        }
    }
}

/// The answer to a submission.
pub(crate) async fn accepted(service: &App, job: &Arc<Job>, again: bool, prefer: Prefer) -> Response {
    let mut response = (StatusCode::ACCEPTED, shown(service, job).await).into_response();
    let headers = response.headers_mut();
    if let Ok(path) = HeaderValue::from_str(&format!("/v1/jobs/{}", job.record().id)) {
        headers.insert(header::LOCATION, path);
    }
    if again {
        headers.insert(HeaderName::from_static("idempotency-replayed"), HeaderValue::from_static("true"));
    }
    let [(name, applied)] = prefer.applied();
    if let (false, Ok(applied)) = (applied.is_empty(), HeaderValue::from_str(&applied)) {
        headers.insert(name, applied);
    }
    response
}
