//! Questions about a scene that are answered without a picture: ray trees, the plan, validity.

use super::render::{find, gone};
use crate::http::contract::bodies::{Bytes, Valid};
use crate::http::contract::generated::{Explained, RayTree, Scene};
use crate::http::contract::queries;
use crate::http::extract::body::Held;
use crate::http::extract::query::{Parameters, outside};
use crate::http::extract::scene_request;
use crate::http::extract::scene_request::SceneRequest;
use crate::http::problem::{Kind, Problem};
use crate::http::{App, Service};
use crate::service::pictures::render;
use crate::service::pictures::render::RenderSpec;
use crate::service::scenes::cache::Found;
use crate::service::scenes::prepared::{Analyzed, PreparedScene, planned};
use crate::service::scheduler::admission::{Work, task_of};
use crate::service::scheduler::task::Class;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde_json::json;
use std::sync::Arc;
use strahl::film::{FileFormat, Region};
use strahl::inspect::TreeFormat;
use strahl::inspect::tree::trace_pixel_while;
use strahl::scene::{Format, Overrides};

/// Which effects the scene calls for, why, and what they should take.
///
/// `analyze` renders the picture, within the limits of any, and adds what they took.
#[utoipa::path(
    post, path = "/v1/explain", operation_id = "explain", tag = "render",
    params(queries::Settings, queries::Analyze),
    request_body(
        description = "The scene; NFF plain or gzip",
        content((Scene = "application/json"), (String = "text/x-nff"), (Bytes = "application/gzip"))
    ),
    responses((status = 200, description = "The plan", body = Explained)),
)]
pub(crate) async fn explanation(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    let answer = |service: &Service, job: &Work, bytes: &[u8], format, overrides: &Overrides, analyze: bool| {
        let Found { ready, loading, .. } = find(service, job, bytes, format, overrides)?;
        let region = Region::whole(ready.scene.width, ready.scene.height);
        if analyze {
            service.limits.check(&ready.scene, region)?;
        }
        let (mut plan, pilot) = planned(&ready, region, &job.workers, &job.control).map_err(|_| gone())?;
        if !analyze {
            return to_json(&plan);
        }
        let shot = RenderSpec::of(&ready.scene, region, FileFormat::Png8);
        let made = render::make(job.started, &ready, loading, &shot, &job.workers, &job.control);
        let cost = made.map_err(|_| gone())?.report.cost;
        plan.measure(&pilot, &cost.rays, &cost.refined, cost.phases_ms.trace);
        to_json(&Analyzed { plan: &plan, actual: &cost })
    };
    let analyze = |parameters: &mut Parameters, _: &HeaderMap| {
        let choices = [("false", false), ("true", true), ("0", false), ("1", true)];
        Ok(parameters.choice("analyze", &choices, false))
    };
    ask(service, request, analyze, answer).await
}

/// Checks a scene without rendering it: all its problems, or none and perhaps warnings.
#[utoipa::path(
    post, path = "/v1/scenes/validate", operation_id = "validateScene", tag = "render",
    params(queries::Settings),
    request_body(
        description = "The scene; NFF plain or gzip",
        content((Scene = "application/json"), (String = "text/x-nff"), (Bytes = "application/gzip"))
    ),
    responses((status = 200, description = "The scene is valid", body = Valid)),
)]
pub(crate) async fn validate(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    let answer = |service: &Service, job: &Work, bytes: &[u8], format, overrides: &Overrides, ()| {
        let found = find(service, job, bytes, format, overrides)?;
        to_json(&json!({ "valid": true, "warnings": found.ready.scene.warnings }))
    };
    ask(service, request, nothing, answer).await
}

/// Every ray of one pixel.
#[utoipa::path(
    post, path = "/v1/tree", operation_id = "tree", tag = "render",
    params(queries::Pixel, queries::Settings),
    request_body(
        description = "The scene; NFF plain or gzip",
        content((Scene = "application/json"), (String = "text/x-nff"), (Bytes = "application/gzip"))
    ),
    responses((status = 200, description = "The tree of rays", content(
        (RayTree = "application/json"), (String = "text/vnd.graphviz"), (String = "image/svg+xml")
    ))),
)]
pub(crate) async fn tree(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    let answer = |service: &Service,
                  job: &Work,
                  bytes: &[u8],
                  format,
                  overrides: &Overrides,
                  (pixel, tree_format): ([u32; 2], _)| {
        let [x, y] = pixel;
        let PreparedScene { scene, .. } = &*find(service, job, bytes, format, overrides)?.ready;
        if x >= scene.width || y >= scene.height {
            return Err(outside(&format!("the pixel x={x}, y={y}"), scene.width, scene.height));
        }
        let tree = job
            .workers
            .work(|| trace_pixel_while(scene, x, y, &job.control))
            .and_then(|tree| tree)
            .map_err(|_| gone())?;
        match tree_format {
            TreeFormat::Json => to_json(&tree),
            TreeFormat::Dot => Ok(("text/vnd.graphviz", tree.to_dot().into_bytes())),
            TreeFormat::Svg => Ok(("image/svg+xml", tree.to_svg().into_bytes())),
        }
    };
    ask(service, request, pixel_and_format, answer).await
}

fn pixel_and_format(parameters: &mut Parameters, _: &HeaderMap) -> Result<([u32; 2], TreeFormat), Problem> {
    Ok((parameters.pixel(), parameters.word("format").unwrap_or_default()))
}

fn nothing(_: &mut Parameters, _: &HeaderMap) -> Result<(), Problem> {
    Ok(())
}

/// A media type and bytes of it.
pub(crate) type Answer = (&'static str, Vec<u8>);

/// A value as an answer.
pub(crate) fn to_json(value: &impl Serialize) -> Result<Answer, Problem> {
    let json = serde_json::to_vec(value).map_err(|error| {
        tracing::error!(%error, "an answer cannot be written as JSON");
        Problem::new(Kind::Internal, "the answer cannot be written")
    })?;
    Ok(("application/json", json))
}

/// What all questions share: the request is read, a job answers it.
pub(crate) async fn ask<P: Send + 'static>(
    service: App,
    request: Request,
    extra: impl FnOnce(&mut Parameters, &HeaderMap) -> Result<P, Problem>,
    answer: impl FnOnce(&Service, &Work, &[u8], Format, &Overrides, P) -> Result<Answer, Problem> + Send + 'static,
) -> Result<Response, Problem> {
    let SceneRequest { format, overrides, extra, tenant, body, .. } =
        scene_request::read(&service, request, extra).await?;
    let work = {
        let service = Arc::clone(&service);
        move |job: &Work| answer(&service, job, body.as_ref(), format, &overrides, extra)
    };
    let (media_type, bytes) = service.queue.run(task_of(&tenant, Class::Renders), work).await?.value;
    let body = Held::new(bytes, &service.memory).into_body();
    Ok(([(header::CONTENT_TYPE, media_type)], body).into_response())
}
