//! `POST` and `QUERY /v1/render`, `POST /v1/render/tile`: renders a scene.

use crate::http::auth::client::Client;
use crate::http::extract::accept;
use crate::http::extract::conditions;
use crate::http::extract::prefer::Prefer;
use crate::http::extract::scene_request::{self, SceneRequest};
use crate::http::extract::scene_types;
use crate::http::metrics::render_cost::Cost;
use crate::http::prelude::*;
use crate::http::respond::image::tile_permit;
use crate::http::respond::job::{JobView, picture_of, until_final};
use crate::http::respond::picture::{self, Freshness, ResponseContext};
use crate::http::respond::put;
use crate::http::respond::streamed::streamed;
use crate::http::respond::submission::{Claimed, accepted, claim, submitted, wishes_of};
use crate::http::respond::turntable;
use crate::service::jobs::record::State as JobState;
use crate::service::pictures::spec::PictureSpec;
use crate::service::requests::jobs::WantedJob;
use crate::service::requests::pictures::{Source, Upload, image_of};
use crate::service::scenes::sent_scene::Form;
use crate::service::scheduler::task::{Class, PRIORITY};
use axum::http::{HeaderName, Method};
use std::time::Duration;
use strahl::film::{FileFormat, Region};

const ALLOWED: &str = "OPTIONS, POST, QUERY";

pub(super) fn routes() -> Vec<Route> {
    let about = "Renders a region of the picture, with the same pixels as that part of the whole.";
    let about_whole = "Renders a scene.\n\nIf `Accept` prefers `multipart/mixed`, the picture streams: coarse ones first, each a part \
                       of JSON (`pass`, `scale`, `x`, `y`, `w`, `h`, `eta_ms`) and a PNG, then the picture (`final`), and its \
                       report as the last part, or a `problem`.";
    vec![
        Route::post("/v1/render", whole, ["render", "render", about_whole])
            .about_scene()
            .or_else(other_methods)
            .header("Prefer", "`respond-async` makes a job of it; `wait=20` waits up to 20 seconds for its picture.")
            .query(Query::output)
            .query(Query::layers)
            .query(turntable::parameters)
            .picture_or_parts()
            .answer(202, "The job, if `Prefer` asks for one and it has not ended", &[Content::json::<JobView>()])
            .answer_header("Location", "The job's path."),
        Route::post("/v1/render/tile", tile, ["renderTile", "render", about])
            .query(Query::region)
            .about_scene()
            .query(Query::output)
            .query(Query::layers)
            .picture(),
    ]
}

async fn whole(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    if turntable::is_asked(request.uri()) {
        return turntable::answer(app, request).await;
    }
    let prefer = Prefer::of(request.headers());
    // Who may not submit jobs gets the picture at once, as if nothing were preferred.
    if prefer != Prefer::default() && Tenant::of(request.extensions()).may(Scope::Jobs) {
        return as_job(app, request, prefer).await;
    }
    if accept::prefers(request.headers(), "multipart/mixed", "image/*") {
        return in_parts(app, request).await;
    }
    answer(app, request, |_| None).await
}

/// The picture as a stream of pictures, from coarse to fine.
async fn in_parts(app: App, request: Request) -> Result<Response, Problem> {
    let extra = |query: &mut Query, _: &HeaderMap| {
        let (output, layers) = (query.output(), query.layers());
        turntable::refuse_without(query);
        query.refuse_layers(layers, "ask for them without multipart/mixed");
        query.picture_format(output, &HeaderMap::new())
    };
    let SceneRequest { form, overrides, extra: format, tenant, body, .. } =
        scene_request::read(&app, request, extra).await?;
    let spec = PictureSpec::plain(None, format);
    let upload = Upload::new(body, form, overrides).await?;
    let (service, task) = (Arc::clone(&app.service), tenant.task(Class::Renders));
    let known = service.scenes.cached(Some(&task.tenant), &upload.sent().key);
    let metrics = Arc::clone(&app.metrics);
    let (passes, made) = service.stream_picture(task, Source::Sent(upload), spec);
    let picture = async move {
        if let Some(image) = known.as_deref().and_then(image_of)
            && let Some(file) = service.stored_picture(&image, &spec).await
        {
            return Ok(file);
        }
        let made = made.await?;
        if let Some(cost) = Cost::of(&made.took, format) {
            metrics.rendered(Class::Renders, &cost);
        }
        Ok(made.file)
    };
    streamed(passes, Box::pin(picture), format).await
}

async fn tile(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    answer(app, request, |query| Some(query.region())).await
}

/// `QUERY /v1/render` (RFC 10008): as `POST`, but safe, so that a client that has the picture gets 304. The router does not know
/// QUERY, so it comes here with all other methods, which are refused.
async fn other_methods(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    if *request.method() == Method::OPTIONS {
        return Ok((StatusCode::NO_CONTENT, allowed()).into_response());
    }
    if *request.method() != Method::QUERY {
        let detail = "/v1/render takes POST and QUERY";
        let mut response = Problem::new(Kind::MethodNotAllowed, detail).into_response();
        response.headers_mut().extend(allowed());
        return Ok(response);
    }
    let mut response = answer(app, request, |_| None).await.unwrap_or_else(IntoResponse::into_response);
    put(response.headers_mut(), header::ALLOW, ALLOWED);
    Ok(response)
}

fn allowed() -> HeaderMap {
    let mut headers = HeaderMap::new();
    put(&mut headers, header::ALLOW, ALLOWED);
    put(&mut headers, HeaderName::from_static("accept-query"), &scene_types::names());
    headers
}

async fn answer(
    app: App,
    request: Request,
    region: impl FnOnce(&mut Query) -> Option<Region>,
) -> Result<Response, Problem> {
    let extra = |query: &mut Query, headers: &HeaderMap| {
        let (region, output) = (region(query), query.output());
        turntable::refuse_without(query);
        let (format, layers) = (query.picture_format(output, headers)?, query.layers());
        if format != FileFormat::Exr {
            query.refuse_layers(layers, "only EXR has room for them: add format=exr");
        }
        Ok((region, format, layers, output.format.is_none()))
    };
    let client = Client::of(request.extensions());
    let SceneRequest {
        form,
        overrides,
        extra: (region, file_format, layers, negotiated),
        tenant,
        method,
        headers,
        body,
    } = scene_request::read(&app, request, extra).await?;
    let spec = PictureSpec { layers, ..PictureSpec::plain(region, file_format) };
    let task = tenant.task(if region.is_some() { Class::Tiles } else { Class::Renders });
    let _permit = region.map(|_| tile_permit(&app, client)).transpose()?;
    let upload = Upload::new(body, form, overrides).await?;
    let context =
        ResponseContext { method: &method, headers: &headers, tenant: &tenant, freshness: Freshness::Once, negotiated };

    // A client that has the picture already waits only until its scene is built.
    let mut ready = app.service.scenes.cached(Some(&tenant.name), &upload.sent().key);
    if ready.is_none() && conditions::has_any(&headers) {
        ready = Some(app.service.build_scene(task.clone(), Source::Sent(upload.clone())).await?);
    }
    if let Some(ready) = ready
        && let Some(image) = image_of(&ready)
    {
        // A region outside of the picture is refused before tags are compared.
        spec.render_spec(&ready.scene, image.zoom)?;
        let name = spec.name(&image);
        let place = picture::place_of(&context, &image, &spec);
        if let Some(answer) = picture::precondition_response(&context, Some(&picture::tag(&name)), place.as_deref()) {
            return answer;
        }
        if let Some(file) = app.service.stored_picture(&image, &spec).await {
            return picture::deliver(&app, &context, &picture::stored(file), &spec);
        }
    }
    let made = app.service.make_picture(task, Source::Sent(upload), spec).await?;
    picture::deliver(&app, &context, &made, &spec)
}

/// Renders as a job, for `Prefer: respond-async` or `wait=N`. The answer is the picture if it is finished in time, else the
/// job.
async fn as_job(app: App, request: Request, prefer: Prefer) -> Result<Response, Problem> {
    let headers = request.headers().clone();
    let query = request.uri().query().unwrap_or_default().to_owned();
    let extra = |query: &mut Query, headers: &HeaderMap| {
        let (output, layers) = (query.output(), query.layers());
        turntable::refuse_without(query);
        query.refuse_layers(
            layers,
            "jobs have none: ask without Prefer, for parts of a large picture at /v1/render/tile",
        );
        Ok((query.picture_format(output, headers)?, output.format.is_none()))
    };
    let SceneRequest { form, overrides, extra: (output, negotiated), tenant, method, body, .. } =
        scene_request::read(&app, request, extra).await?;
    // The query is part of the request that an idempotency key stands for.
    let base = if let Form::Variation(base) = &form { base.as_bytes() } else { b"" };
    let beside = [query.as_bytes(), b"\n", base].concat();
    let (claimed, scene) = claim(&app, &tenant, &headers, beside, body).await?;
    let (job, is_replay) = match claimed {
        Claimed::Before(job) => {
            drop(scene);
            (job, true)
        }
        Claimed::Now(claim) => {
            let (priority, labels, wishes) = (PRIORITY, Vec::new(), wishes_of(&app, &tenant, None, None)?);
            let wanted = WantedJob { scene, form, frames: None, overrides, output, priority, labels, wishes };
            (submitted(&app, &tenant, wanted, claim).await?, false)
        }
    };
    // The job is accepted, so it is answered in any case.
    _ = until_final(&app, &tenant, &job, prefer.wait.unwrap_or(Duration::ZERO)).await;
    if job.record().state == JobState::Succeeded {
        let mut response = picture_of(&app, &tenant, &method, &headers, &job).await?;
        Prefer { respond_async: false, ..prefer }.add_applied(response.headers_mut());
        if negotiated {
            put(response.headers_mut(), header::VARY, "Accept");
        }
        return Ok(response);
    }
    Ok(accepted(&app, &job, is_replay, prefer).await)
}
