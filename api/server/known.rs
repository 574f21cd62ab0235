//! `/v1/scenes`: scenes that are remembered by their ids, so that their pictures have addresses.

use super::asked::{self, Asked};
use super::excerpt::size_of;
use super::openapi::bodies::{Bytes, KnownScene, Scene as AnyScene};
use super::openapi::queries;
use super::parameters::Parameters;
use super::picture::gone;
use super::problem::{Kind, Problem};
use super::queue::{Job, seat_of};
use super::scenes::{key, unknown};
use super::{App, Service};
use crate::identity::{ImageId, canonical, is_scene_id};
use crate::ready::{Ready, planned};
use crate::turns::Lane;
use axum::Json;
use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use strahl::film::Region;
use strahl::scene::{Format, Loaded, Overrides};

/// Remembers a scene, opened as 2^zoom times its size, and says under which addresses its pictures and tiles are.
#[utoipa::path(
    post, path = "/v1/scenes", operation_id = "addScene", tag = "pictures",
    params(queries::Zoom, queries::Settings),
    request_body(
        description = "The scene; NFF plain or gzip",
        content((AnyScene = "application/json"), (String = "text/x-nff"), (Bytes = "application/gzip"))
    ),
    responses(
        (status = 201, description = "It is known now", body = KnownScene),
        (status = 200, description = "It was known before", body = KnownScene),
    ),
)]
pub(super) async fn add(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    let further = |parameters: &mut Parameters, _: &HeaderMap| Ok(parameters.zoom());
    let Asked { format, overrides, further: zoom, tenant, body, .. } = asked::read(&service, request, further).await?;
    let job = {
        let service = Arc::clone(&service);
        move |job: &Job| remember(&service, job, body.as_ref(), format, &overrides, zoom)
    };
    let (new, about) = service.queue.run(seat_of(&tenant, Lane::Renders), job).await?.value;
    let status = if new { StatusCode::CREATED } else { StatusCode::OK };
    let location = about["links"]["self"].as_str().unwrap_or_default().to_owned();
    Ok((status, [(header::LOCATION, location)], Json(about)).into_response())
}

/// Whether the scene is new, and what there is to say about it.
fn remember(
    service: &Service,
    job: &Job,
    bytes: &[u8],
    format: Format,
    overrides: &Overrides,
    zoom: u32,
) -> Result<(bool, Value), Problem> {
    let read = |mut loaded: Loaded| {
        let text = canonical(&mut loaded.description);
        (Ready::from(loaded), text)
    };
    let key = key(bytes, format, overrides);
    if let Some(ready) = service.scenes.recall(&key)
        && service.scenes.texts.has(&ready.scene_id)
    {
        return Ok((false, describe(&ready, job, zoom)?));
    }
    let built = service.scenes.build(&job.workers, bytes, format, overrides, read);
    if job.control.cancelled.load(Ordering::Relaxed) {
        return Err(gone());
    }
    let (ready, text) = built.map_err(|problems| Problem::scene(&problems))?;
    if !ready.reproducible {
        let detail = "pictures of this scene have no name, since files or a clock decide on them: put its textures into the \
                      scene, and ask for another accuracy than time";
        return Err(Problem::new(Kind::InvalidScene, detail));
    }
    let about = describe(&ready, job, zoom)?;
    let id = ready.scene_id.clone();
    let new = !service.scenes.texts.has(&id);
    if new {
        let room = service.scenes.texts.put(&id, text).map_err(|error| {
            tracing::error!(%error, "a scene cannot be written into the folder");
            Problem::new(Kind::Internal, "the scene cannot be remembered; the service's log says why")
        })?;
        if !room {
            let detail = "the scene is larger than all that is remembered (known_scene_bytes)";
            return Err(Problem::new(Kind::TooLarge, detail));
        }
    }
    service.scenes.keep(key, ready);
    Ok((new, about))
}

/// What there is to say about a scene.
fn describe(ready: &Ready, job: &Job, zoom: u32) -> Result<Value, Problem> {
    let [width, height] = size_of(&ready.scene, zoom).ok_or_else(|| {
        let detail = "opened this large, neighboring pixels have the same rays: ask for a smaller zoom, or for \
                      render.precision double";
        Problem::new(Kind::InvalidParameter, detail)
    })?;
    let whole = Region::whole(ready.scene.width, ready.scene.height);
    let (plan, _) = planned(ready, whole, &job.workers, &job.control).map_err(|_| gone())?;
    let plan = serde_json::to_value(&plan).unwrap_or_default();
    let scene = &ready.scene_id;
    let image = ImageId { scene: scene.clone(), zoom };
    Ok(json!({
        "scene_id": scene,
        "image_id": image.to_string(),
        "zoom": zoom,
        "width": width,
        "height": height,
        "warnings": ready.scene.warnings,
        "estimate": plan["estimate"],
        "links": {
            "self": format!("/v1/scenes/{scene}"),
            "image": format!("/v1/images/{image}.png"),
            "iiif": format!("/iiif/3/{image}/info.json"),
            "dzi": format!("/dzi/{image}.dzi"),
            "xyz": format!("/xyz/{image}.json"),
        },
    }))
}

/// The canonical text of a known scene: all defaults filled in, keys in alphabetical order.
#[utoipa::path(
    get, path = "/v1/scenes/{scene_id}", operation_id = "scene", tag = "pictures",
    params(("scene_id" = String, Path, description = "As `POST /v1/scenes` says it.")),
    responses((status = 200, description = "The scene", body = AnyScene)),
)]
pub(super) async fn get(State(service): State<App>, Path(id): Path<String>) -> Result<Response, Problem> {
    let text = {
        let (service, id) = (Arc::clone(&service), id.clone());
        tokio::task::spawn_blocking(move || is_scene_id(&id).then(|| service.scenes.texts.get(&id)).flatten()).await
    };
    let text = text.ok().flatten().ok_or_else(|| unknown(&id))?;
    let etag = format!("\"{id}\"");
    Ok(([(header::CONTENT_TYPE, "application/json"), (header::ETAG, &etag)], text).into_response())
}

/// Forgets a scene and its pictures.
#[utoipa::path(
    delete, path = "/v1/scenes/{scene_id}", operation_id = "removeScene", tag = "pictures",
    params(("scene_id" = String, Path, description = "As `POST /v1/scenes` says it.")),
    responses((status = 204, description = "It is forgotten")),
)]
pub(super) async fn remove(State(service): State<App>, Path(id): Path<String>) -> Result<StatusCode, Problem> {
    let known = {
        let (service, id) = (Arc::clone(&service), id.clone());
        tokio::task::spawn_blocking(move || {
            let known = is_scene_id(&id) && service.scenes.forget(&id);
            if known {
                service.pictures.forget(&format!("i_{}_", &id[2..]));
            }
            known
        })
        .await
    };
    if known.unwrap_or(false) { Ok(StatusCode::NO_CONTENT) } else { Err(unknown(&id)) }
}
