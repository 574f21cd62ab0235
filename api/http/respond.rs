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
use crate::service::pictures::file::{PictureFile, PictureMeta};
use crate::service::pictures::render;
use crate::service::pictures::render::{RenderSpec, Rendered};
use crate::service::pictures::report::Report;
use crate::service::pictures::spec::PictureSpec;
use crate::service::scenes::cache::{Found, Key};
use crate::service::scenes::ids::ImageId;
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scheduler::admission::{Done, Queue, Work, task_of};
use crate::service::scheduler::task::Class;
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
    fn find(&self, service: &Service, job: &Work) -> Result<(Found, u32), Problem> {
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
    fn flight(&self, spec: &PictureSpec) -> String {
        match self {
            Self::Sent { key, .. } => {
                let mut name = String::new();
                for byte in key {
                    // Writing to a String cannot fail.
                    let _ = write!(name, "{byte:02x}");
                }
                name + &spec.suffix()
            }
            Self::Known(image) => spec.name(image),
        }
    }
}

/// The scene of a name, which was told to be remembered, or which some job is about.
fn find_known(service: &Service, job: &Work, id: &str) -> Result<Found, Problem> {
    if let Some(order) = service.jobs.order_of(id).filter(|_| !service.scenes.texts.has(id))
        && let Some(text) = service.jobs.scene(&order.scene)
    {
        return find(service, job, &text, order.format, &order.settings);
    }
    service.scenes.find_known(job, id)
}

/// The image that a scene's own picture is, if it has a name.
pub(crate) fn image_of(ready: &PreparedScene) -> Option<ImageId> {
    ready.reproducible.then(|| ImageId { scene: ready.scene_id.clone(), zoom: 0 })
}

/// A picture that need not be made: it is kept, or a job has made it.
pub(crate) async fn kept(service: &App, image: &ImageId, spec: &PictureSpec) -> Option<Arc<PictureFile>> {
    if let Some(made) = service.pictures.cached(&spec.name(image)) {
        return Some(made);
    }
    // No thread is asked that could only say no.
    let by_a_job = || spec.is_whole() && !service.jobs.with_picture(&image.to_string(), spec.format).is_empty();
    if !service.pictures.has_folder() && !by_a_job() {
        return None;
    }
    let (service, image, spec) = (Arc::clone(service), image.clone(), *spec);
    tokio::task::spawn_blocking(move || kept_here(&service, &image, &spec)).await.ok().flatten()
}

/// The same on this thread, which may have to wait for the disk.
fn kept_here(service: &Service, image: &ImageId, spec: &PictureSpec) -> Option<Arc<PictureFile>> {
    let name = spec.name(image);
    if let Some(made) = service.pictures.get(&name) {
        return Some(made);
    }
    let of_a_job = spec.is_whole().then(|| service.jobs.picture_of(&image.to_string(), spec.format));
    let made = Arc::new(of_a_job.flatten()?);
    service.pictures.remember(&name, &made);
    Some(made)
}

/// A picture that is at hand, with the timing of that.
pub(crate) fn cached(made: Arc<PictureFile>) -> Shown {
    Shown { made, timing: timing(None, 0.0, true).into(), cost: None }
}

/// Makes a picture, or waits for whoever makes it.
pub(crate) async fn make(
    service: &App,
    tenant: &Tenant,
    class: Class,
    source: Source,
    spec: PictureSpec,
) -> Result<Shown, Problem> {
    let task = task_of(tenant, class);
    let name = source.flight(&spec);
    let mut is_mine = false;
    let work = || {
        is_mine = true;
        let service = Arc::clone(service);
        async move {
            let job_side = Arc::clone(&service);
            let job = move |job: &Work| render(&job_side, job, &source, &spec);
            let Done { value: (made, report, kept), queue_ms } = queue_of(&service, class).run(task, job).await?;
            let cost = report.as_ref().map(|report| Cost::of(report, queue_ms, spec.format));
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
pub(crate) async fn build(
    service: &App,
    tenant: &Tenant,
    class: Class,
    source: Source,
) -> Result<Arc<PreparedScene>, Problem> {
    let job = {
        let service = Arc::clone(service);
        move |job: &Work| source.find(&service, job).map(|(found, _)| found.ready)
    };
    queue_of(service, class).run(task_of(tenant, class), job).await.map(|done| done.value)
}

/// Tiles wait in a queue of their own: a viewer asks for many at once, and does not ask twice.
pub(crate) fn queue_of(service: &Service, class: Class) -> &Queue {
    if class == Class::Tiles { &service.tiles } else { &service.queue }
}

/// A picture, what it took unless it was there, and whether its scene was there.
fn render(
    service: &Service,
    job: &Work,
    source: &Source,
    spec: &PictureSpec,
) -> Result<(Arc<PictureFile>, Option<Report>, bool), Problem> {
    let (Found { ready, loading, kept }, zoom) = source.find(service, job)?;
    let image = ready.reproducible.then(|| ImageId { scene: ready.scene_id.clone(), zoom });
    // The same scene may have been sent in other words, or to another process.
    if let Some(made) = image.as_ref().and_then(|image| kept_here(service, image, spec)) {
        return Ok((made, None, kept));
    }
    // Tiles are many and small: what there is to say of them is in their headers.
    let shot = RenderSpec { note: spec.is_whole(), asked: Some(job.asked), ..spec.shot(&ready.scene, zoom)? };
    service.limits.check(&ready.scene, shot.region)?;
    let finished = render::make(job.started, &ready, loading, &shot, &job.workers, &job.control);
    let Rendered { file, report } = finished.map_err(|_| gone())?;
    let name = image.as_ref().map(|image| spec.name(image));
    let about = PictureMeta::new(image.map(|image| image.to_string()), &report, &ready.scene, spec.is_whole());
    let made = Arc::new(PictureFile::new(file, about));
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
pub(crate) struct ResponseContext<'a> {
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
pub(crate) fn precondition_response(
    context: &ResponseContext<'_>,
    etag: Option<&str>,
) -> Option<Result<Response, Problem>> {
    match weigh(context.method, context.headers, etag) {
        Verdict::Proceed => None,
        Verdict::Failed => {
            let detail = "the picture is not the one that If-Match or If-None-Match asks for";
            Some(Err(Problem::new(Kind::PreconditionFailed, detail)))
        }
        Verdict::NotModified => {
            let mut response = StatusCode::NOT_MODIFIED.into_response();
            put(response.headers_mut(), header::ETAG, etag.unwrap_or_default());
            caching(response.headers_mut(), context);
            Some(Ok(response))
        }
    }
}

/// The answer that a picture makes, if the request's conditions allow it.
pub(crate) fn deliver(
    service: &Service,
    context: &ResponseContext<'_>,
    shown: &Shown,
    spec: &PictureSpec,
) -> Result<Response, Problem> {
    let Shown { made, timing, cost } = shown;
    let etag = made.about.image.as_ref().map(|image| tag(&spec.name(image)));
    if let Some(answer) = precondition_response(context, etag.as_deref()) {
        return answer;
    }
    let (ending, media_type) = spec.format.names();
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
        if context.freshness == Freshness::Once && spec.is_whole() {
            put(headers, header::CONTENT_LOCATION, &place_of(image, spec.format));
        }
    }
    caching(headers, context);
    if etag.is_none() {
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    }
    Ok(response)
}

fn caching(headers: &mut HeaderMap, context: &ResponseContext<'_>) {
    let everybody = context.tenant.is_anonymous();
    let value = match context.freshness {
        Freshness::Immutable if everybody => "public, max-age=31536000, immutable",
        Freshness::Immutable => "private, max-age=31536000, immutable",
        Freshness::Once => "no-cache",
    };
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static(value));
    if context.negotiated {
        headers.insert(header::VARY, HeaderValue::from_static("Accept"));
    }
}

/// Sets a header. What goes in is ASCII: ids, numbers, names of effects.
pub(crate) fn put(headers: &mut HeaderMap, name: HeaderName, value: &str) {
    if let Ok(value) = HeaderValue::from_str(value) {
        headers.insert(name, value);
    }
}
