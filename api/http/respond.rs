//! The way from a request to a picture file: it is at hand, or on its way, or a job makes it.

use super::problem::{Kind, Problem};
use super::{App, Service};
use crate::http::auth::tenant::Tenant;
use crate::http::extract::body::Held;
use crate::http::extract::conditions::{Verdict, weigh};
use crate::http::metrics::render_cost::Cost;
use crate::http::routes::images::place_of;
use crate::http::routes::render::{find, gone, timing};
use crate::service::pictures::cache::Shown;
use crate::service::pictures::file::{About, Made};
use crate::service::pictures::render;
use crate::service::pictures::render::{Finished, Shot};
use crate::service::pictures::report::Report;
use crate::service::pictures::spec::Excerpt;
use crate::service::scenes::cache::{Found, Key};
use crate::service::scenes::ids::ImageId;
use crate::service::scenes::prepared::Ready;
use crate::service::scheduler::admission::{Done, Job, Queue, seat_of};
use crate::service::scheduler::task::Lane;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use strahl::scene::{Format, Overrides};

/// Which scene a picture is of.
#[derive(Debug, Clone)]
pub(crate) enum Source {
    /// One that was sent.
    Sent { key: Key, body: Arc<Held>, format: Format, overrides: Overrides },
    /// One that is known.
    Known(ImageId),
}

impl Source {
    /// The scene and its zoom, as part of a job.
    fn find(&self, service: &Service, job: &Job) -> Result<(Found, u32), Problem> {
        match self {
            Self::Sent { body, format, overrides, .. } => {
                find(service, job, (**body).as_ref(), *format, overrides).map(|found| (found, 0))
            }
            Self::Known(image) => {
                let found = find_known(service, job, &image.scene);
                if job.control.cancelled.load(Ordering::Relaxed) { Err(gone()) } else { Ok((found?, image.zoom)) }
            }
        }
    }

    /// What work on the same picture has in common.
    fn flight(&self, excerpt: &Excerpt) -> String {
        match self {
            Self::Sent { key, .. } => {
                let mut name = String::new();
                for byte in key {
                    // Writing to a String cannot fail.
                    let _ = write!(name, "{byte:02x}");
                }
                name + &excerpt.suffix()
            }
            Self::Known(image) => excerpt.name(image),
        }
    }
}

/// The scene of a name, which was told to be remembered, or which some job is about.
fn find_known(service: &Service, job: &Job, id: &str) -> Result<Found, Problem> {
    if let Some(order) = service.jobs.order_of(id).filter(|_| !service.scenes.texts.has(id))
        && let Some(text) = service.jobs.scene(&order.scene)
    {
        return find(service, job, &text, order.format, &order.settings);
    }
    service.scenes.find_known(job, id)
}

/// The image that a scene's own picture is, if it has a name.
pub(crate) fn image_of(ready: &Ready) -> Option<ImageId> {
    ready.reproducible.then(|| ImageId { scene: ready.scene_id.clone(), zoom: 0 })
}

/// A picture that need not be made: it is kept, or a job has made it.
pub(crate) async fn kept(service: &App, image: &ImageId, excerpt: &Excerpt) -> Option<Arc<Made>> {
    if let Some(made) = service.pictures.at_hand(&excerpt.name(image)) {
        return Some(made);
    }
    // No thread is asked that could only say no.
    let by_a_job = || excerpt.is_whole() && !service.jobs.with_picture(&image.to_string(), excerpt.format).is_empty();
    if !service.pictures.has_folder() && !by_a_job() {
        return None;
    }
    let (service, image, excerpt) = (Arc::clone(service), image.clone(), *excerpt);
    tokio::task::spawn_blocking(move || kept_here(&service, &image, &excerpt)).await.ok().flatten()
}

/// The same on this thread, which may have to wait for the disk.
fn kept_here(service: &Service, image: &ImageId, excerpt: &Excerpt) -> Option<Arc<Made>> {
    let name = excerpt.name(image);
    if let Some(made) = service.pictures.get(&name) {
        return Some(made);
    }
    let of_a_job = excerpt.is_whole().then(|| service.jobs.picture_of(&image.to_string(), excerpt.format));
    let made = Arc::new(of_a_job.flatten()?);
    service.pictures.remember(&name, &made);
    Some(made)
}

/// A picture that is at hand, with the timing of that.
pub(crate) fn at_hand(made: Arc<Made>) -> Shown {
    Shown { made, timing: timing(None, 0.0, true).into(), cost: None }
}

/// Makes a picture, or waits for whoever makes it.
pub(crate) async fn make(
    service: &App,
    tenant: &Tenant,
    lane: Lane,
    source: Source,
    excerpt: Excerpt,
) -> Result<Shown, Problem> {
    let seat = seat_of(tenant, lane);
    let name = source.flight(&excerpt);
    let mut is_mine = false;
    let work = || {
        is_mine = true;
        let service = Arc::clone(service);
        async move {
            let job_side = Arc::clone(&service);
            let job = move |job: &Job| render(&job_side, job, &source, &excerpt);
            let Done { value: (made, report, kept), queue_ms } = queue_of(&service, lane).run(seat, job).await?;
            let cost = report.as_ref().map(|report| Cost::of(report, queue_ms, excerpt.format));
            Ok(Shown { made, timing: timing(report.as_ref(), queue_ms, kept).into(), cost })
        }
    };
    let mut shown = service.pictures.share(name, work).await?;
    if !is_mine {
        shown.cost = None;
    }
    Ok(shown)
}

/// Builds a scene without a picture.
pub(crate) async fn build(service: &App, tenant: &Tenant, lane: Lane, source: Source) -> Result<Arc<Ready>, Problem> {
    let job = {
        let service = Arc::clone(service);
        move |job: &Job| source.find(&service, job).map(|(found, _)| found.ready)
    };
    queue_of(service, lane).run(seat_of(tenant, lane), job).await.map(|done| done.value)
}

/// Tiles wait in a queue of their own: a viewer asks for many at once, and does not ask twice.
pub(crate) fn queue_of(service: &Service, lane: Lane) -> &Queue {
    if lane == Lane::Tiles { &service.tiles } else { &service.queue }
}

/// A picture, what it took unless it was there, and whether its scene was there.
fn render(
    service: &Service,
    job: &Job,
    source: &Source,
    excerpt: &Excerpt,
) -> Result<(Arc<Made>, Option<Report>, bool), Problem> {
    let (Found { ready, loading, kept }, zoom) = source.find(service, job)?;
    let image = ready.reproducible.then(|| ImageId { scene: ready.scene_id.clone(), zoom });
    // The same scene may have been sent in other words, or to another process.
    if let Some(made) = image.as_ref().and_then(|image| kept_here(service, image, excerpt)) {
        return Ok((made, None, kept));
    }
    // Tiles are many and small: what there is to say of them is in their headers.
    let shot = Shot { note: excerpt.is_whole(), asked: Some(job.asked), ..excerpt.shot(&ready.scene, zoom)? };
    service.limits.check(&ready.scene, shot.region)?;
    let finished = render::make(job.started, &ready, loading, &shot, &job.workers, &job.control);
    let Finished { file, report } = finished.map_err(|_| gone())?;
    let name = image.as_ref().map(|image| excerpt.name(image));
    let about = About::new(image.map(|image| image.to_string()), &report, &ready.scene, excerpt.is_whole());
    let made = Arc::new(Made::new(file, about));
    if let Some(name) = name {
        service.pictures.put(&name, &made);
    }
    Ok((made, Some(report), kept))
}

/// How long others may keep an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Freshness {
    /// It is what this address stands for, for ever.
    Immutable,
    /// It answers this request; to be asked about before it is used again.
    Once,
}

/// The parts of an answer that depend on how it was asked for.
#[derive(Debug)]
pub(crate) struct Manner<'a> {
    /// The request's method and headers.
    pub(crate) method: &'a Method,
    pub(crate) headers: &'a HeaderMap,
    /// Who asks: what one tenant may see, shared caches may not keep.
    pub(crate) tenant: &'a Tenant,
    pub(crate) freshness: Freshness,
    /// Whether `Accept` decided on the format.
    pub(crate) negotiated: bool,
}

/// The entity tag of a picture: its whole name.
pub(crate) fn tag(name: &str) -> String {
    format!("\"{name}\"")
}

/// The answer to a request whose conditions say so, before anything is made.
pub(crate) fn settled(manner: &Manner<'_>, etag: Option<&str>) -> Option<Result<Response, Problem>> {
    match weigh(manner.method, manner.headers, etag) {
        Verdict::Proceed => None,
        Verdict::Failed => {
            let detail = "the picture is not the one that If-Match or If-None-Match asks for";
            Some(Err(Problem::new(Kind::PreconditionFailed, detail)))
        }
        Verdict::NotModified => {
            let mut response = StatusCode::NOT_MODIFIED.into_response();
            put(response.headers_mut(), header::ETAG, etag.unwrap_or_default());
            caching(response.headers_mut(), manner);
            Some(Ok(response))
        }
    }
}

/// The answer that a picture makes, if the request's conditions allow it.
pub(crate) fn deliver(
    service: &Service,
    manner: &Manner<'_>,
    shown: &Shown,
    excerpt: &Excerpt,
) -> Result<Response, Problem> {
    let Shown { made, timing, cost } = shown;
    let etag = made.about.image.as_ref().map(|image| tag(&excerpt.name(image)));
    if let Some(answer) = settled(manner, etag.as_deref()) {
        return answer;
    }
    let (ending, media_type) = excerpt.format.names();
    let mut response = Response::new(Held::shared(made.file.clone(), &service.memory));
    if let Some(cost) = cost {
        response.extensions_mut().insert(*cost);
    }
    let headers = response.headers_mut();
    headers.clone_from(&made.headers);
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(media_type));
    let name = made.about.image.as_deref().unwrap_or("picture");
    put(headers, header::CONTENT_DISPOSITION, &format!("inline; filename=\"{name}.{ending}\""));
    put(headers, HeaderName::from_static("server-timing"), timing);
    if let (Some(etag), Some(image)) = (&etag, &made.about.image) {
        put(headers, header::ETAG, etag);
        if manner.freshness == Freshness::Once && excerpt.is_whole() {
            put(headers, header::CONTENT_LOCATION, &place_of(image, excerpt.format));
        }
    }
    caching(headers, manner);
    if etag.is_none() {
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    }
    Ok(response)
}

fn caching(headers: &mut HeaderMap, manner: &Manner<'_>) {
    let everybody = manner.tenant.is_anonymous();
    let value = match manner.freshness {
        Freshness::Immutable if everybody => "public, max-age=31536000, immutable",
        Freshness::Immutable => "private, max-age=31536000, immutable",
        Freshness::Once => "no-cache",
    };
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static(value));
    if manner.negotiated {
        headers.insert(header::VARY, HeaderValue::from_static("Accept"));
    }
}

/// Sets a header. What goes in is ASCII: ids, numbers, names of effects.
pub(crate) fn put(headers: &mut HeaderMap, name: HeaderName, value: &str) {
    if let Ok(value) = HeaderValue::from_str(value) {
        headers.insert(name, value);
    }
}
