//! What there is to see of a job: its picture, the preview of it, and parts that are finished.

use super::change::blocking;
use super::{no_picture, patiently};
use crate::http::auth::tenant::Tenant;
use crate::http::contract::bodies::{Bytes, Picture};
use crate::http::contract::queries;
use crate::http::extract::body::Held;
use crate::http::extract::named_job::Named;
use crate::http::extract::prefer::Prefer;
use crate::http::extract::query::{Parameters, outside};
use crate::http::problem::{Kind, Problem};
use crate::http::respond;
use crate::http::respond::{Freshness, ResponseContext, Source};
use crate::http::{App, Service};
use crate::service::jobs::Job;
use crate::service::jobs::PREVIEW_SIDE;
use crate::service::jobs::record::State as JobState;
use crate::service::pictures::spec::{Grid, PictureSpec};
use crate::service::scenes::cache::key;
use crate::service::scheduler::admission::{Work, task_of};
use crate::service::scheduler::task::Class;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use std::time::Duration;
use strahl::film::{FileFormat, Film, Region, encode};

/// How long a look at an unfinished part waits for it: viewers give up after 30 seconds.
const PART_PATIENCE: Duration = Duration::from_secs(25);
/// Longest wait for another preview, in seconds.
const PREVIEW_PATIENCE: usize = 30;
/// Pixels of a part.
const PART_PIXELS: u64 = 4 << 20;

/// The picture of a job that has succeeded.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/image", operation_id = "jobImage", tag = "jobs",
    params(("id" = String, Path, description = "The job's id.")),
    responses((status = 200, response = Picture)),
)]
pub(crate) async fn job_image(
    State(service): State<App>,
    Named { job, tenant }: Named,
    request: Request,
) -> Result<Response, Problem> {
    picture_of(&service, &tenant, request.method(), request.headers(), &job).await
}

/// The picture of a job, if there is one, as any other picture is answered.
pub(crate) async fn picture_of(
    service: &App,
    tenant: &Tenant,
    method: &Method,
    headers: &HeaderMap,
    job: &Job,
) -> Result<Response, Problem> {
    let (state, id, output) = {
        let record = job.record();
        (record.state, record.id.clone(), record.spec.output)
    };
    if state != JobState::Succeeded {
        return Err(no_picture(job));
    }
    let made = {
        let (jobs, id) = (Arc::clone(&service.jobs), id.clone());
        blocking(move || jobs.picture(&id)).await?
    };
    let made = made.map_err(|error| {
        tracing::error!(job = id, %error, "a picture cannot be read");
        Problem::new(Kind::Internal, "the picture cannot be read")
    })?;
    let context = ResponseContext { method, headers, tenant, freshness: Freshness::Once, negotiated: false };
    respond::deliver(service, &context, &respond::cached(Arc::new(made)), &PictureSpec::plain(None, output))
}

/// The newest preview, at most 1,024 pixels wide and high, as a PNG.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/preview", operation_id = "jobPreview", tag = "jobs",
    params(
        ("id" = String, Path, description = "The job's id."),
        ("rev" = Option<u64>, Query, description = "Any number: another one is another URL, for pages that look again."),
        ("after" = Option<u64>, Query, description = "Waits for a later revision than this."),
        ("wait" = Option<u32>, Query, minimum = 1, maximum = 30, description = "How many seconds at most, 30 if only `after` is given."),
        ("If-None-Match" = Option<String>, Header, description = "The ETag of the preview that is there already."),
        ("Prefer" = Option<String>, Header, description = "`wait=10` waits so many seconds for another preview than that of If-None-Match."),
    ),
    responses(
        (status = 200, description = "The preview; its revision is its ETag", body = Bytes, content_type = "image/png"),
        (status = 304, description = "There is no other yet"),
    ),
)]
pub(crate) async fn job_preview(
    State(service): State<App>,
    Named { job, tenant }: Named,
    request: Request,
) -> Result<Response, Problem> {
    let mut parameters = Parameters::of(request.uri())?;
    parameters.number("rev");
    let (after, wait) = (parameters.number("after"), parameters.count("wait", PREVIEW_PATIENCE));
    parameters.finish()?;
    let known = request.headers().get(header::IF_NONE_MATCH).and_then(|tag| tag.to_str().ok()).map(str::to_owned);
    let patience = wait
        .or(after.map(|_| PREVIEW_PATIENCE))
        .map(|seconds| Duration::from_secs(seconds as u64))
        .or(Prefer::of(request.headers()).wait);
    let is_new = |job: &Job| {
        let revision = job.revision();
        let succeeded = job.record().state == JobState::Succeeded;
        (revision > 0 || succeeded)
            && after.is_none_or(|after| revision > after || succeeded)
            && known.as_deref() != Some(tag(revision, succeeded).as_str())
    };
    if let Some(patience) = patience {
        let _watcher = job.watch();
        let mut bell = job.events.bell();
        let news = async { while !is_new(&job) && !job.record().state.is_final() && bell.changed().await.is_ok() {} };
        // Either way the newest is shown.
        patiently(&service, patience, news).await;
    }
    let succeeded = job.record().state == JobState::Succeeded;
    let (png, revision) = if succeeded {
        let (jobs, id) = (Arc::clone(&service.jobs), job.record().id.clone());
        let png = match blocking(move || jobs.last_preview(&id)).await? {
            Ok(png) => png,
            Err(_) => again(&service, &tenant, &job, small(&job)).await?,
        };
        (png, job.revision())
    } else {
        let (film, revision) = job.preview().ok_or_else(|| no_picture(&job))?;
        if known.as_deref() == Some(tag(revision, false).as_str()) {
            (Vec::new(), revision)
        } else {
            (to_png(&service, &tenant, film).await?, revision)
        }
    };
    let tag = tag(revision, succeeded);
    let headers = [
        (header::ETAG, tag.clone()),
        (header::CACHE_CONTROL, "no-cache".to_owned()),
        (HeaderName::from_static("preview-revision"), revision.to_string()),
    ];
    if known.as_ref() == Some(&tag) {
        return Ok((StatusCode::NOT_MODIFIED, headers).into_response());
    }
    let body = Held::new(png, &service.memory).into_body();
    Ok((headers, [(header::CONTENT_TYPE, "image/png")], body).into_response())
}

/// All of a picture in as many pixels as a preview has.
fn small(job: &Job) -> PictureSpec {
    let record = job.record();
    let level = record.width.max(record.height).div_ceil(PREVIEW_SIDE).next_power_of_two().ilog2();
    PictureSpec { grid: Grid::Level(level as i32), ..PictureSpec::plain(None, FileFormat::Png8) }
}

fn tag(revision: u64, is_last: bool) -> String {
    if is_last { "\"last\"".to_owned() } else { format!("\"r{revision}\"") }
}

/// A part of the picture as a PNG: at once if it is finished, else as soon as it is. Looking at it makes it the next to be
/// rendered.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/tile", operation_id = "jobTile", tag = "jobs",
    params(("id" = String, Path, description = "The job's id."), queries::Region),
    responses((status = 200, description = "The part, as it will be in the picture", body = Bytes, content_type = "image/png")),
)]
pub(crate) async fn job_tile(
    State(service): State<App>,
    Named { job, tenant }: Named,
    request: Request,
) -> Result<Response, Problem> {
    let region = region_of(&job, &request)?;
    let mut bell = job.events.bell();
    let watcher = job.watch();
    job.look(region);
    let finished = async {
        loop {
            if let Some(film) = job.finished_part(region) {
                return Some(film);
            }
            if job.record().state.is_final() || bell.changed().await.is_err() {
                return None;
            }
        }
    };
    let film = patiently(&service, PART_PATIENCE, finished).await.flatten();
    drop(watcher);
    let png = match film {
        Some(film) => to_png(&service, &tenant, film).await?,
        None if job.record().state == JobState::Succeeded => {
            again(&service, &tenant, &job, PictureSpec::plain(Some(region), FileFormat::Png8)).await?
        }
        None => return Err(no_picture(&job)),
    };
    let headers = [(header::CONTENT_TYPE, "image/png"), (header::CACHE_CONTROL, "private, max-age=3600")];
    Ok((headers, Held::new(png, &service.memory).into_body()).into_response())
}

/// Says that somebody looks at a part of the picture, which is rendered next.
#[utoipa::path(
    post, path = "/v1/jobs/{id}/look", operation_id = "lookAtJob", tag = "jobs",
    params(("id" = String, Path, description = "The job's id."), queries::Region),
    responses((status = 204, description = "It is next")),
)]
pub(crate) async fn look_at_job(Named { job, .. }: Named, request: Request) -> Result<StatusCode, Problem> {
    job.look(region_of(&job, &request)?);
    Ok(StatusCode::NO_CONTENT)
}

fn region_of(job: &Job, request: &Request) -> Result<Region, Problem> {
    let mut parameters = Parameters::of(request.uri())?;
    let region = parameters.region();
    parameters.finish()?;
    let record = job.record();
    if !region.fits(record.width, record.height) {
        return Err(outside("the region", record.width, record.height));
    }
    if region.pixels() > PART_PIXELS {
        let detail = format!("a part has at most {PART_PIXELS} pixels (part_pixels)");
        return Err(Problem::limit(Kind::CostLimit, "part_pixels", PART_PIXELS, detail));
    }
    Ok(region)
}

/// An excerpt of a picture that was finished before: rendered again, to the same bytes, unless it is at hand.
async fn again(service: &App, tenant: &Tenant, job: &Job, spec: PictureSpec) -> Result<Vec<u8>, Problem> {
    let order = job.record().spec.clone();
    let text = {
        let (jobs, scene) = (Arc::clone(&service.jobs), order.scene.clone());
        blocking(move || jobs.scene(&scene)).await?
    };
    let text = text.ok_or_else(|| Problem::new(Kind::Gone, "the job's scene is gone"))?;
    let (key, body) = (key(&text, order.format, &order.settings), Arc::new(Held::new(text, &service.memory)));
    let source = Source::Sent { key, body, format: order.format, overrides: order.settings };
    Ok(respond::make(service, tenant, Class::Tiles, source, spec).await?.made.file.to_vec())
}

async fn to_png(service: &Service, tenant: &Tenant, film: Film) -> Result<Vec<u8>, Problem> {
    let encode = move |work: &Work| {
        work.workers.work(|| encode(&film, FileFormat::Png8)).map_err(|_| crate::http::routes::render::gone())
    };
    Ok(service.queue.run(task_of(tenant, Class::Tiles), encode).await?.value)
}
