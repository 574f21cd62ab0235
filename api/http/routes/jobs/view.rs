//! Jobs as JSON, one and many.

use super::change::blocking;
use super::until_final;
use crate::http::auth::tenant::Tenant;
use crate::http::contract::jobs::{JobList, JobView};
use crate::http::extract::named_job::Named;
use crate::http::extract::named_job::may_see;
use crate::http::extract::prefer::Prefer;
use crate::http::extract::query::Parameters;
use crate::http::problem::{Kind, Problem};
use crate::http::routes::images::place_of;
use crate::http::routes::scenes::tiles_of;
use crate::http::{App, Service};
use crate::service::jobs::Job;
use crate::service::jobs::record::{Record, State as JobState};
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::{Duration, UNIX_EPOCH};

/// Jobs of a page, and how many there may be.
const PAGE: [usize; 2] = [50, 200];

/// A job, whatever its state.
#[utoipa::path(
    get, path = "/v1/jobs/{id}", operation_id = "job", tag = "jobs",
    params(
        ("id" = String, Path, description = "The job's id."),
        ("Prefer" = Option<String>, Header, description = "`wait=20` waits so many seconds for the job to end."),
    ),
    responses((status = 200, description = "The job", body = JobView)),
)]
pub(crate) async fn job(
    State(service): State<App>,
    Named { job, .. }: Named,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let prefer = Prefer { respond_async: false, ..Prefer::of(&headers) };
    if let Some(wait) = prefer.wait {
        until_final(&service, &job, wait).await;
    }
    let view = shown(&service, &job).await;
    Ok(if prefer.wait.is_some() { (prefer.applied(), view).into_response() } else { view.into_response() })
}

/// The tenant's jobs, the newest first.
#[utoipa::path(
    get, path = "/v1/jobs", operation_id = "jobs", tag = "jobs",
    params(
        ("state" = Option<String>, Query, description = "Only those in this state."),
        ("label" = Option<String>, Query, description = "Only those with this label."),
        ("limit" = Option<u32>, Query, minimum = 1, maximum = 200, description = "How many at most, 50 if it is not given."),
        ("cursor" = Option<String>, Query, description = "Where the page before ended: its `next`."),
    ),
    responses((status = 200, description = "The jobs; `Link` with `rel=\"next\"` leads to the next page.", body = JobList)),
)]
pub(crate) async fn jobs(
    State(service): State<App>,
    Extension(tenant): Extension<Arc<Tenant>>,
    request: Request,
) -> Result<Response, Problem> {
    let mut parameters = Parameters::of(request.uri())?;
    let state = parameters.choice("state", &JobState::ALL.map(|(name, state)| (name, Some(state))), None);
    let (label, cursor) = (parameters.text("label"), parameters.text("cursor"));
    let limit = parameters.count("limit", PAGE[1]).unwrap_or(PAGE[0]);
    parameters.finish()?;
    let wanted = |record: &Record| {
        may_see(&tenant, record)
            && state.is_none_or(|state| record.state == state)
            && label.as_ref().is_none_or(|label| record.labels.contains(label))
    };
    let mut found = service.jobs.list(cursor.as_deref(), limit + 1, wanted);
    let more = found.len() > limit;
    found.truncate(limit);
    let next = found.last().filter(|_| more).map(|job| job.record().id.clone());
    let views: Vec<Value> = found.iter().map(|job| view(&service, job)).collect();
    let mut headers = HeaderMap::new();
    if let Some(next) = &next {
        let filters = [("state", state.map(|state| state.name().to_owned())), ("label", label)];
        let filters: String =
            filters.into_iter().filter_map(|(name, value)| Some(format!("&{name}={}", encoded(&value?)))).collect();
        let link = format!("</v1/jobs?limit={limit}&cursor={next}{filters}>; rel=\"next\"");
        if let Ok(link) = HeaderValue::from_str(&link) {
            headers.insert(header::LINK, link);
        }
    }
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    Ok((headers, Json(json!({ "jobs": views, "next": next }))).into_response())
}

/// A job as an answer: with the cost report once there is a picture, its version as ETag, and when to ask again.
pub(crate) async fn shown(service: &App, job: &Arc<Job>) -> Response {
    let mut view = view(service, job);
    if view["state"] == JobState::Succeeded.name() {
        let (service, id) = (Arc::clone(service), job.record().id.clone());
        let about = blocking(move || service.jobs.about(&id)).await;
        let report = about.ok().and_then(Result::ok).and_then(|about| about.report);
        view["report"] = report.and_then(|report| serde_json::from_str(report.get()).ok()).unwrap_or_default();
    }
    let record = job.record();
    let mut headers = HeaderMap::new();
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    if let Ok(version) = HeaderValue::from_str(&etag(record.version)) {
        headers.insert(header::ETAG, version);
    }
    if !record.state.is_final() {
        let seconds = view["eta_ms"].as_f64().map_or(1, |eta| (eta / 1e3).ceil() as u32).clamp(1, 10);
        headers.insert(header::RETRY_AFTER, seconds.into());
    }
    drop(record);
    (headers, Json(view)).into_response()
}

/// The ETag of a version.
pub(crate) fn etag(version: u64) -> String {
    format!("\"v{version}\"")
}

/// A job as JSON.
pub(crate) fn view(service: &Service, job: &Arc<Job>) -> Value {
    let progress = job.progress();
    let place = service.jobs.place(job);
    let record = job.record();
    let path = format!("/v1/jobs/{}", record.id);
    let time = |ms: u64| humantime::format_rfc3339_millis(UNIX_EPOCH + Duration::from_millis(ms)).to_string();
    let eta_ms = if record.state.is_final() { None } else { place.map(|(_, eta)| eta).or(progress.eta_ms) };
    let limits = service.jobs.limits;
    let kept = match record.state {
        JobState::Succeeded => limits.keep_pictures,
        JobState::Expired => limits.keep_pictures + limits.keep_records,
        _ => limits.keep_records,
    };
    let mut links = json!({
        "self": path,
        "events": format!("{path}/events"),
        "preview": format!("{path}/preview"),
        "image": format!("{path}/image"),
        "cancel": format!("{path}/cancel"),
    });
    if let (Some(scene), Some(image)) = (&record.scene_id, &record.image_id) {
        let [iiif, dzi, xyz] = tiles_of(image);
        let (scene, picture) = (format!("/v1/scenes/{scene}"), place_of(image, record.spec.output));
        for (name, link) in [("scene", scene), ("picture", picture), ("iiif", iiif), ("dzi", dzi), ("xyz", xyz)] {
            links[name] = link.into();
        }
    }
    let mut view = json!({
        "id": record.id,
        "state": record.state,
        "progress": {
            "fraction": progress.done as f64 / progress.total as f64,
            "tiles_done": progress.done,
            "tiles_total": progress.total,
            "rays": progress.rays,
        },
        "position": place.map(|(position, _)| position),
        "eta_ms": eta_ms.map(f64::round),
        "estimate_ms": record.estimate_ms,
        "priority": record.priority,
        "labels": record.labels,
        "width": record.width,
        "height": record.height,
        "tile": record.edge,
        "scene_id": record.scene_id,
        "image_id": record.image_id,
        "tenant": record.tenant,
        "created_at": time(record.created),
        "started_at": record.started.map(time),
        "finished_at": record.finished.map(time),
        "expires_at": record.finished.map(|finished| time(finished + kept.as_millis() as u64)),
        "links": links,
        "stats": record.stats,
    });
    if let Some(failure) = &record.failure {
        view["problem"] = Kind::document(&failure.slug, &failure.detail);
    }
    view
}

/// Text as a part of a query.
fn encoded(text: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~".contains(&byte);
    text.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}
