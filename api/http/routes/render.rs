//! `POST` and `QUERY /v1/render`, `POST /v1/render/tile`: a scene in, a picture out.

use super::jobs::render_later;
use super::tiles;
use crate::http::auth::client::Client;
use crate::http::contract::bodies::{Bytes, Picture};
use crate::http::contract::generated::Scene as AnyScene;
use crate::http::contract::queries;
use crate::http::extract::body::Held;
use crate::http::extract::conditions;
use crate::http::extract::prefer::Prefer;
use crate::http::extract::query::Parameters;
use crate::http::extract::scene_request;
use crate::http::extract::scene_request::SceneRequest;
use crate::http::problem::{Kind, Problem};
use crate::http::respond;
use crate::http::respond::{Freshness, ResponseContext, Source};
use crate::http::{App, Service};
use crate::service::pictures::report::Report;
use crate::service::pictures::spec::PictureSpec;
use crate::service::scenes::cache::{Found, Key, key};
use crate::service::scheduler::admission::Work;
use crate::service::scheduler::task::Class;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use strahl::film::Region;
use strahl::scene::{Format, Overrides};

/// Bytes of a scene that are hashed between two requests.
const HASHED_AT_ONCE: usize = 64 << 10;

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
pub(crate) async fn whole(State(service): State<App>, request: Request) -> Result<Response, Problem> {
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
pub(crate) async fn tile(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    answer(service, request, |parameters| Some(parameters.region())).await
}

async fn answer(
    service: App,
    request: Request,
    region: impl FnOnce(&mut Parameters) -> Option<Region>,
) -> Result<Response, Problem> {
    let extra = |parameters: &mut Parameters, headers: &HeaderMap| {
        let negotiated = !parameters.has("format");
        Ok((region(parameters), parameters.picture_format(headers)?, negotiated))
    };
    let client = Client::of(request.extensions());
    let SceneRequest { format, overrides, extra: (region, file_format, negotiated), tenant, method, headers, body } =
        scene_request::read(&service, request, extra).await?;
    let spec = PictureSpec::plain(region, file_format);
    let class = if region.is_some() { Class::Tiles } else { Class::Renders };
    let _place = region.map(|_| tiles::place(&service, client)).transpose()?;
    let body = Arc::new(body);
    let key = hash(&body, format, overrides).await?;
    let source = Source::Sent { key, body, format, overrides };
    let context =
        ResponseContext { method: &method, headers: &headers, tenant: &tenant, freshness: Freshness::Once, negotiated };

    // A client that has the picture already need not wait until it is traced, only until its scene is known.
    let mut known = service.scenes.recall(&key);
    if known.is_none() && conditions::has_any(&headers) {
        known = Some(respond::build(&service, &tenant, class, source.clone()).await?);
    }
    if let Some(ready) = known
        && let Some(image) = respond::image_of(&ready)
    {
        // What does not fit the picture is refused before its tag is compared.
        spec.shot(&ready.scene, image.zoom)?;
        let name = spec.name(&image);
        if let Some(answer) = respond::precondition_response(&context, Some(&respond::tag(&name))) {
            return answer;
        }
        if let Some(made) = respond::kept(&service, &image, &spec).await {
            return respond::deliver(&service, &context, &respond::cached(made), &spec);
        }
    }
    let shown = respond::make(&service, &tenant, class, source, spec).await?;
    respond::deliver(&service, &context, &shown, &spec)
}

/// The name of a scene as it was sent. Long texts are hashed where nobody else has to wait for it.
async fn hash(body: &Arc<Held>, format: Format, overrides: Overrides) -> Result<Key, Problem> {
    let work = {
        let body = Arc::clone(body);
        move || key((*body).as_ref(), format, &overrides)
    };
    if (**body).as_ref().len() < HASHED_AT_ONCE {
        return Ok(work());
    }
    let hashed = tokio::task::spawn_blocking(work).await;
    hashed.map_err(|_| Problem::new(Kind::Internal, "the scene cannot be hashed"))
}

/// `QUERY /v1/render` (RFC 10008): as `POST`, but safe, so that a client that has the picture is told so. Other methods are
/// refused.
pub(crate) async fn query(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    if *request.method() == Method::OPTIONS {
        return Ok((StatusCode::NO_CONTENT, allowed()).into_response());
    }
    if *request.method() != Method::QUERY {
        let detail = "/v1/render takes POST and QUERY";
        let mut response = Problem::new(Kind::MethodNotAllowed, detail).into_response();
        response.headers_mut().extend(allowed());
        return Ok(response);
    }
    answer(service, request, |_| None).await
}

fn allowed() -> HeaderMap {
    HeaderMap::from_iter([
        (header::ALLOW, HeaderValue::from_static("OPTIONS, POST, QUERY")),
        (
            HeaderName::from_static("accept-query"),
            HeaderValue::from_static("application/json, text/x-nff, application/gzip"),
        ),
    ])
}

/// The scene that a request is about, as part of its job.
pub(crate) fn find(
    service: &Service,
    job: &Work,
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
pub(crate) fn gone() -> Problem {
    Problem::new(Kind::RenderDeadline, "the request was given up")
}

/// `Server-Timing`: what this answer took, if its picture had to be made.
pub(crate) fn timing(report: Option<&Report>, queue_ms: f64, kept: bool) -> String {
    let scene = format!("scene;desc={}", if kept { "hit" } else { "miss" });
    let Some(report) = report else { return scene + ", picture;desc=hit" };
    let phases = report.cost.phases_ms.list();
    // What no phase accounts for was spent waiting for a turn on the pool.
    let waited = report.cost.wall_ms - phases.iter().map(|(_, ms)| ms).sum::<f64>();
    let durations = [("queue", queue_ms + waited.max(0.0))].into_iter().chain(phases);
    let refine = format!("refine;dur={:.3};desc=\"part of trace\"", report.cost.phases_ms.refine);
    let durations = durations.map(|(phase, ms)| format!("{phase};dur={ms:.3}"));
    let timing: Vec<String> = [scene].into_iter().chain(durations).chain([refine]).collect();
    timing.join(", ")
}
