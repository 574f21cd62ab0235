//! Answers about jobs.

use super::blocking;
use super::image::tiles_of;
use super::picture::{self, Freshness, ResponseContext, address_of};
use super::put;
use crate::http::auth::tenant::Tenant;
use crate::http::extract::conditions::may_act;
use crate::http::problem::{Kind, Problem, ProblemSummary};
use crate::http::state::{App, AppState};
use crate::service::ANONYMOUS;
use crate::service::clock::unix_time;
use crate::service::concurrency_limit::Permit;
use crate::service::deliveries::report_of;
use crate::service::error::Error;
use crate::service::jobs::Job;
use crate::service::jobs::outbox::{Delivery, DeliveryState};
use crate::service::jobs::record::{State as JobState, Stats};
use crate::service::pictures::report::Report;
use crate::service::pictures::spec::PictureSpec;
use crate::service::scheduler::admission::Work;
use crate::service::scheduler::task::Class;
use crate::service::sequences::Frames;
use crate::service::sequences::report::SequenceReport;
use axum::http::{HeaderMap, HeaderValue, Method, header};
use axum::response::{IntoResponse, Response};
use data_encoding::HEXLOWER;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::value::RawValue;
use sha2::{Digest, Sha256};
use std::sync::Arc;
use std::time::{Duration, UNIX_EPOCH};
use strahl::film::{FileFormat, Film, encode};

/// A job.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct JobView {
    /// A UUID of version 7.
    id: String,
    /// Its state.
    state: JobState,
    /// Its progress.
    progress: JobProgress,
    /// Its position among the tenant's waiting jobs, from 1.
    position: Option<usize>,
    /// Estimated milliseconds until it is done.
    eta_ms: Option<f64>,
    /// Estimated milliseconds on a machine that does nothing else.
    estimate_ms: f64,
    /// 0 to 100.
    #[schemars(range(min = 0, max = 100))]
    priority: u8,
    /// The owner's labels.
    labels: Vec<String>,
    /// Pixels across.
    width: u32,
    /// Pixels down.
    height: u32,
    /// Edge of a tile in pixels; 0 if the picture is one tile.
    tile: u32,
    /// Id of the scene with the settings in it. Null if its picture depends on a clock or on files.
    scene_id: Option<String>,
    /// Id of the picture, if it has one.
    image_id: Option<String>,
    /// The tenant that owns it.
    tenant: String,
    /// When it was accepted (RFC 3339).
    created_at: String,
    /// When it was first started.
    started_at: Option<String>,
    /// When it ended.
    finished_at: Option<String>,
    /// When it will be deleted.
    expires_at: Option<String>,
    /// Paths of the job and what belongs to it.
    links: JobLinks,
    /// The frames of a sequence.
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<Frames>,
    /// Its cost.
    stats: Stats,
    /// Why it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<ProblemSummary>,
    /// The message about its end, if it has a webhook.
    #[serde(skip_serializing_if = "Option::is_none")]
    webhook: Option<DeliveryView>,
    /// Its picture in the store, if it asked for that.
    #[serde(skip_serializing_if = "Option::is_none")]
    store: Option<StoredView>,
    /// What the picture cost, and how far it may be from the exact one. Only in the answer about a single job that has
    /// succeeded.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Report>")]
    report: Option<Box<RawValue>>,
    /// What the frames of a sequence cost, and the worst of their bounds. Only in the answer about a single job that has
    /// succeeded.
    #[serde(skip_serializing_if = "Option::is_none")]
    sequence: Option<SequenceReport>,
}

/// A delivery after the end of a job.
#[derive(Debug, Serialize, JsonSchema)]
struct DeliveryView {
    /// Where it goes.
    url: String,
    /// How far it is.
    state: DeliveryState,
    /// Attempts so far.
    attempts: u32,
    /// When it is tried next, after an attempt that failed (RFC 3339).
    #[serde(skip_serializing_if = "Option::is_none")]
    next_attempt_at: Option<String>,
    /// When it arrived or was given up (RFC 3339).
    #[serde(skip_serializing_if = "Option::is_none")]
    ended_at: Option<String>,
    /// Why the last attempt failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

/// The picture of a job in the store.
#[derive(Debug, Serialize, JsonSchema)]
struct StoredView {
    /// The picture's name in the store.
    key: String,
    /// The name of its cost report.
    report_key: String,
    /// Its delivery.
    #[serde(flatten)]
    delivery: DeliveryView,
}

impl DeliveryView {
    fn of(delivery: &Delivery, url: String) -> Self {
        let is_pending = delivery.state == DeliveryState::Pending;
        Self {
            url,
            state: delivery.state,
            attempts: delivery.attempts,
            next_attempt_at: (is_pending && delivery.next > 0).then(|| rfc3339(delivery.next)),
            ended_at: delivery.ended.map(rfc3339),
            error: delivery.error.clone(),
        }
    }
}

/// A time in milliseconds since 1970.
pub(super) fn rfc3339(ms: u64) -> String {
    humantime::format_rfc3339_millis(UNIX_EPOCH + Duration::from_millis(ms)).to_string()
}

/// Progress of a job.
#[derive(Debug, Serialize, JsonSchema)]
struct JobProgress {
    /// From 0 to 1.
    fraction: f64,
    /// Finished tiles.
    tiles_done: usize,
    /// All tiles.
    tiles_total: usize,
    /// Rays of the finished tiles.
    rays: u64,
}

/// Paths of a job and what belongs to it, and of its picture and tiles if they have ids.
#[derive(Debug, Serialize, JsonSchema)]
struct JobLinks {
    /// The job.
    #[serde(rename = "self")]
    this: String,
    /// Its events.
    events: String,
    /// The picture so far.
    preview: String,
    /// The picture.
    image: String,
    /// The frames of a sequence.
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<String>,
    /// All of them in one file.
    #[serde(skip_serializing_if = "Option::is_none")]
    animation: Option<String>,
    /// All of them on a contact sheet.
    #[serde(skip_serializing_if = "Option::is_none")]
    sheet: Option<String>,
    /// Stops it.
    cancel: String,
    /// The canonical text of its scene, with the settings in it.
    #[serde(skip_serializing_if = "Option::is_none")]
    scene: Option<String>,
    /// The picture by its id.
    #[serde(skip_serializing_if = "Option::is_none")]
    picture: Option<String>,
    /// The description of the image for IIIF.
    #[serde(skip_serializing_if = "Option::is_none")]
    iiif: Option<String>,
    /// The description of the image for DZI.
    #[serde(skip_serializing_if = "Option::is_none")]
    dzi: Option<String>,
    /// The description of the image's tiles for XYZ.
    #[serde(skip_serializing_if = "Option::is_none")]
    xyz: Option<String>,
}

impl JobView {
    /// A job as it is now, without its cost report.
    pub(crate) fn of(app: &AppState, job: &Arc<Job>) -> Self {
        let progress = job.progress();
        let place = app.service.jobs.place(job);
        let record = job.record().clone();
        let path = format!("/v1/jobs/{}", record.id);
        let eta_ms = place.map(|(_, eta)| eta).or(progress.eta_ms).unwrap_or(record.estimate_ms);
        let eta_ms = (!record.state.is_final()).then_some(eta_ms);
        // Whole seconds: what two clocks say is not the same from one answer to the next.
        let expires = app.service.jobs.kept_for(&record).map(|kept| (unix_time() + kept).as_secs() * 1_000);
        let ids = record.scene_id.as_ref().zip(record.image_id.as_ref());
        let tiles = ids.map(|(_, image)| tiles_of(image));
        let of_frames = |what: &str| record.frames.map(|_| format!("{path}/{what}"));
        let [iiif, dzi, xyz] = tiles.map_or_else(Default::default, |tiles| tiles.map(Some));
        Self {
            state: record.state,
            progress: JobProgress {
                fraction: progress.done as f64 / progress.total as f64,
                tiles_done: progress.done,
                tiles_total: progress.total,
                rays: progress.rays,
            },
            position: place.map(|(position, _)| position),
            eta_ms: eta_ms.map(f64::round),
            estimate_ms: record.estimate_ms,
            priority: record.priority,
            width: record.width,
            height: record.height,
            tile: record.edge,
            created_at: rfc3339(record.created),
            started_at: record.started.map(rfc3339),
            finished_at: record.finished.map(rfc3339),
            expires_at: expires.map(rfc3339),
            links: JobLinks {
                events: format!("{path}/events"),
                preview: format!("{path}/preview"),
                image: format!("{path}/image"),
                frames: of_frames("frames"),
                animation: of_frames("animation"),
                sheet: of_frames("sheet"),
                cancel: format!("{path}/cancel"),
                scene: ids.map(|(scene, _)| format!("/v1/scenes/{scene}")),
                picture: ids.map(|(_, image)| address_of(image, record.spec.output)),
                iiif,
                dzi,
                xyz,
                this: path,
            },
            // One that was stopped keeps none.
            frames: record
                .frames
                .map(|frames| if record.has_pictures() { frames } else { Frames { done: 0, ..frames } }),
            stats: record.stats,
            problem: record.failure.as_ref().map(ProblemSummary::of),
            webhook: record.outbox.webhook.as_ref().map(|delivery| DeliveryView::of(delivery, delivery.to.clone())),
            store: record.outbox.store.as_ref().map(|delivery| StoredView {
                report_key: report_of(&delivery.to),
                delivery: DeliveryView::of(
                    delivery,
                    app.service.store.as_ref().map_or_else(String::new, |store| store.url(&delivery.to)),
                ),
                key: delivery.to.clone(),
            }),
            report: None,
            sequence: None,
            id: record.id,
            labels: record.labels,
            scene_id: record.scene_id,
            image_id: record.image_id,
            tenant: record.tenant,
        }
    }
}

/// The answer about a job: with the cost report if it has succeeded, its ETag, and when to ask again.
pub(crate) async fn shown(app: &App, job: &Arc<Job>) -> Response {
    // Before the rest, so that a change meanwhile is not taken as known.
    let version = job.record().version;
    let mut view = JobView::of(app, job);
    if view.state == JobState::Succeeded && view.frames.is_some() {
        let (app, record) = (Arc::clone(app), job.record().clone());
        let (rays, ms) = (record.estimate_rays, record.estimate_ms);
        let frames = blocking(move || app.service.jobs.frame_reports(&record)).await;
        view.sequence =
            frames.ok().and_then(Result::ok).map(|(frames, warnings)| SequenceReport::of(&frames, warnings, rays, ms));
    } else if view.state == JobState::Succeeded {
        let (app, job) = (Arc::clone(app), Arc::clone(job));
        let meta = blocking(move || app.service.jobs.meta(&job)).await;
        let report = meta.ok().flatten().and_then(|meta| meta.report);
        view.report = report.or_else(|| RawValue::from_string("null".into()).ok());
    }
    let mut headers = HeaderMap::new();
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    if !view.state.is_final() {
        let seconds = view.eta_ms.map_or(1, |eta| (eta / 1e3).ceil() as u32).clamp(1, 10);
        headers.insert(header::RETRY_AFTER, seconds.into());
    }
    let Ok(said) = serde_json::to_vec(&view) else {
        return Problem::new(Kind::Internal, "the request failed").into_response();
    };
    put(&mut headers, header::ETAG, &etag(version, &said));
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
    (headers, said).into_response()
}

/// The ETag of what is said of a job: its version, and a hash, since progress is no change of the job.
fn etag(version: u64, said: &[u8]) -> String {
    format!("\"{}-{}\"", tag_of(version), HEXLOWER.encode(&Sha256::digest(said)[..6]))
}

/// Whether the conditions of a request that acts on a job hold for its version, whatever its progress.
pub(crate) fn holds(headers: &HeaderMap, version: u64) -> bool {
    let cut = |tag: &str| match tag.trim().split_once('-') {
        Some((version, _)) => format!("{version}\""),
        None => tag.trim().to_owned(),
    };
    let mut conditions = HeaderMap::new();
    for name in [header::IF_MATCH, header::IF_NONE_MATCH] {
        for tags in headers.get_all(&name).into_iter().filter_map(|tags| tags.to_str().ok()) {
            let tags: Vec<String> = tags.split(',').map(cut).collect();
            conditions.extend(HeaderValue::try_from(tags.join(", ")).map(|tags| (name.clone(), tags)));
        }
    }
    may_act(&conditions, Some(&format!("\"{}\"", tag_of(version))))
}

/// How tags and messages name a version.
pub(crate) fn tag_of(version: u64) -> String {
    format!("v{version}")
}

/// The answer with the picture of a job.
pub(crate) async fn picture_of(
    app: &App,
    tenant: &Tenant,
    method: &Method,
    headers: &HeaderMap,
    job: &Arc<Job>,
) -> Result<Response, Problem> {
    let (state, output) = {
        let record = job.record();
        (record.state, record.spec.output)
    };
    if state != JobState::Succeeded {
        return Err(no_picture(job));
    }
    let file = app.service.job_picture(tenant.task(Class::Renders), job).await?.ok_or_else(|| {
        let id = job.record().id.clone();
        let detail = format!(
            "the file with the picture of job {id} is damaged, and it cannot be rendered again in one answer; submit the \
             job again"
        );
        Problem::new(Kind::Gone, detail)
    })?;
    let context = ResponseContext { method, headers, tenant, freshness: Freshness::Once, negotiated: false };
    picture::deliver(app, &context, &picture::stored(file), &PictureSpec::plain(None, output))
}

/// The problem of a job that has no picture.
pub(crate) fn no_picture(job: &Job) -> Problem {
    let record = job.record();
    let (id, state) = (record.id.clone(), record.state);
    match state {
        JobState::Expired => Problem::new(Kind::Gone, format!("the picture of job {id} has expired; submit it again")),
        JobState::Failed | JobState::Canceled => {
            let detail = record.failure.as_ref().map_or("it was canceled", |failure| failure.detail.as_str());
            Problem::new(Kind::JobFailed, format!("job {id} has no picture: {detail}"))
        }
        JobState::Queued | JobState::Running | JobState::Succeeded => {
            drop(record);
            let eta = job.progress().eta_ms.unwrap_or(1_000.0);
            let seconds = ((eta / 1e3).ceil() as u32).clamp(1, 10);
            Problem::new(Kind::JobNotFinished, format!("job {id} is {}", state.name())).retry_after(seconds)
        }
    }
}

/// A part of a finished picture, from a cache or rendered again to the same bytes.
pub(crate) async fn render_again(app: &App, tenant: &Tenant, job: &Job, spec: PictureSpec) -> Result<Vec<u8>, Problem> {
    let made = app.service.render_of_job(tenant.task(Class::Tiles), job, spec).await?;
    made.map(|file| file.bytes.clone()).ok_or_else(|| Problem::new(Kind::Gone, "the job's scene is gone"))
}

/// Pixels as a PNG.
pub(crate) async fn encode_png(app: &App, tenant: &Tenant, film: Film) -> Result<Vec<u8>, Problem> {
    let work = move |work: &Work| Ok::<_, Error>(work.workers.work(|| encode(&film, FileFormat::Png8))?);
    Ok(app.service.queue.run(tenant.task(Class::Tiles), work).await?.value)
}

/// Waits for something. None if the time is over or the service drains.
pub(crate) async fn patiently<T>(app: &AppState, patience: Duration, wait: impl Future<Output = T>) -> Option<T> {
    let mut draining = app.drain.watch();
    tokio::select! {
        done = wait => Some(done),
        () = tokio::time::sleep(patience) => None,
        _ = draining.wait_for(|draining| *draining) => None,
    }
}

/// A place among the requests of a tenant that wait for jobs. They have a quarter of all connections, so that no tenant takes
/// those of others. Without keys there are no tenants.
pub(crate) fn waiting_permit(app: &AppState, tenant: &Tenant) -> Result<Permit<String>, Problem> {
    let most = if tenant.name == ANONYMOUS { u32::MAX } else { (app.max_connections / 4).max(1) };
    app.waits.enter(tenant.name.clone(), most).ok_or_else(|| {
        let detail =
            format!("{most} requests of your tenant wait for jobs: follow several in one stream, GET /v1/events");
        Problem::new(Kind::RateLimited, detail).retry_after(5)
    })
}

/// Waits until a job has ended or the time is over. It fails at once if too many requests of the tenant wait already.
pub(crate) async fn until_final(
    app: &AppState,
    tenant: &Tenant,
    job: &Arc<Job>,
    patience: Duration,
) -> Result<(), Problem> {
    if patience.is_zero() || job.record().state.is_final() {
        return Ok(());
    }
    let _permit = waiting_permit(app, tenant)?;
    let mut bell = job.events.bell();
    let ended = async {
        while !job.record().state.is_final() {
            if bell.changed().await.is_err() {
                return;
            }
        }
    };
    // The caller reads the state in either case.
    patiently(app, patience, ended).await;
    Ok(())
}
