//! `POST /v1/render` and `POST /v1/render/tile`: a scene in, a picture out.

use super::asked::{self, Asked};
use super::body::Held;
use super::cost::Cost;
use super::jobs::{Prefer, render_later};
use super::negotiate;
use super::openapi::bodies::{Bytes, Picture, Scene as AnyScene};
use super::openapi::queries;
use super::parameters::{Parameters, outside};
use super::problem::{Kind, Problem};
use super::queue::{Done, Job, seat_of};
use super::scenes::Found;
use super::warnings;
use super::{App, Service};
use crate::picture::{self, Finished};
use crate::ready::Ready;
use crate::report::Report;
use crate::turns::Lane;
use axum::Extension;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use strahl::film::{FileFormat, Region};
use strahl::scene::{Format, Overrides, Scene};

/// A scene in, a picture out.
#[utoipa::path(
    post, path = "/v1/render", operation_id = "render", tag = "render",
    params(queries::Settings, queries::Output),
    request_body(
        description = "The scene; NFF plain or gzip",
        content((AnyScene = "application/json"), (String = "text/x-nff"), (Bytes = "application/gzip"))
    ),
    responses((status = 200, response = Picture)),
)]
pub(super) async fn whole(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    let prefer = Prefer::of(request.headers());
    if prefer != Prefer::default() {
        return render_later(service, request, prefer).await;
    }
    answer(service, request, |_| None).await
}

/// A region of the picture: the same bytes as that part of the whole.
#[utoipa::path(
    post, path = "/v1/render/tile", operation_id = "renderTile", tag = "render",
    params(queries::Region, queries::Settings, queries::Output),
    request_body(
        description = "The scene; NFF plain or gzip",
        content((AnyScene = "application/json"), (String = "text/x-nff"), (Bytes = "application/gzip"))
    ),
    responses((status = 200, response = Picture)),
)]
pub(super) async fn tile(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    answer(service, request, |parameters| Some(parameters.region())).await
}

async fn answer(
    service: App,
    request: Request,
    region: impl FnOnce(&mut Parameters) -> Option<Region>,
) -> Result<Response, Problem> {
    let further = |parameters: &mut Parameters, headers: &HeaderMap| {
        Ok((region(parameters), parameters.picture_format(headers)?))
    };
    let Asked { format, overrides, further: (region, file_format), tenant, body } =
        asked::read(&service, request, further).await?;
    let seat = seat_of(&tenant, if region.is_some() { Lane::Tiles } else { Lane::Renders });
    let render = {
        let service = Arc::clone(&service);
        move |job: &Job| {
            let Found { ready, loading, kept } = find(&service, job, body.as_ref(), format, &overrides)?;
            let region = region_of(&service, &ready, region)?;
            picture::make(job.started, &ready, loading, region, file_format, &job.workers, &job.control)
                .map(|finished| (finished, kept, warnings::header(&ready.scene.warnings)))
                .map_err(|_| gone())
        }
    };
    let Done { value: (Finished { file, report }, kept, warnings), queue_ms } = service.queue.run(seat, render).await?;
    let cost = Extension(Cost::of(&report, queue_ms, file_format));
    let mut headers = picture_headers(file_format, &report, queue_ms, kept);
    headers.extend(warnings);
    Ok((cost, headers, Held::new(file, &service.memory).into_body()).into_response())
}

/// The scene that a request is about, as part of its job.
pub(super) fn find(
    service: &Service,
    job: &Job,
    bytes: &[u8],
    format: Format,
    overrides: &Overrides,
) -> Result<Found, Problem> {
    let found = service.scenes.find(&job.workers, bytes, format, overrides);
    if job.control.cancelled.load(Ordering::Relaxed) {
        return Err(gone());
    }
    found.map_err(|problems| Problem::scene(&problems))
}

/// A job noticed that it was cancelled. Nobody waits for this answer any more: its client has gone or has been
/// answered.
pub(super) fn gone() -> Problem {
    Problem::new(Kind::RenderDeadline, "the request was given up")
}

fn region_of(service: &Service, ready: &Ready, region: Option<Region>) -> Result<Region, Problem> {
    let Scene { width, height, .. } = ready.scene;
    let region = region.unwrap_or_else(|| Region::whole(width, height));
    if !region.fits(width, height) {
        let Region { x, y, width: w, height: h } = region;
        return Err(outside(&format!("the region x={x}, y={y}, w={w}, h={h}"), width, height));
    }
    service.limits.check(&ready.scene, region)?;
    Ok(region)
}

fn picture_headers(format: FileFormat, report: &Report, queue_ms: f64, kept: bool) -> HeaderMap {
    let (name, media_type) = negotiate::description(format);
    let phases = report.cost.phases_ms.list();
    // What no phase accounts for was spent waiting for a turn on the pool.
    let waited = report.cost.wall_ms - phases.iter().map(|(_, ms)| ms).sum::<f64>();
    let durations = [("queue", queue_ms + waited.max(0.0))].into_iter().chain(phases);
    let scene = format!("scene;desc={}", if kept { "hit" } else { "miss" });
    let timing: Vec<String> =
        [scene].into_iter().chain(durations.map(|(phase, ms)| format!("{phase};dur={ms:.3}"))).collect();
    let rays = report.cost.rays;
    let rays = format!(
        "camera={}, shadow={}, reflected={}, transmitted={}",
        rays.camera, rays.shadow, rays.reflected, rays.transmitted
    );
    let proved = report.error.proved.header();
    let on: Vec<_> = report.plan.explanation.names_on().collect();
    let mut headers = HeaderMap::new();
    for (header, value) in [
        (header::CONTENT_TYPE, media_type.to_owned()),
        (header::CONTENT_DISPOSITION, format!("inline; filename=\"picture.{name}\"")),
        (header::VARY, "Accept".to_owned()),
        (HeaderName::from_static("server-timing"), timing.join(", ")),
        (HeaderName::from_static("render-error"), proved),
        (HeaderName::from_static("render-rays"), rays),
        (HeaderName::from_static("render-plan"), on.join(", ")),
    ] {
        // Names of effects and numbers are ASCII, so this does not fail.
        if let Ok(value) = HeaderValue::from_str(&value) {
            headers.insert(header, value);
        }
    }
    headers
}
