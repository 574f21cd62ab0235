//! `/v1/scenes`: scenes that are remembered by their ids, so that their pictures have addresses.

use super::render::gone;
use crate::http::auth::tenant::{Scope, Tenant};
use crate::http::contract::bodies::Bytes;
use crate::http::contract::generated::Scene as AnyScene;
use crate::http::contract::pictures::KnownScene;
use crate::http::contract::queries;
use crate::http::extract::query::Parameters;
use crate::http::extract::scene_request;
use crate::http::extract::scene_request::SceneRequest;
use crate::http::problem::{Kind, Problem};
use crate::http::{App, Service};
use crate::service::pictures::spec::size_of;
use crate::service::scenes::cache::{key, unknown};
use crate::service::scenes::ids::{ImageId, canonical, is_scene_id};
use crate::service::scenes::prepared::{PreparedScene, planned};
use crate::service::scenes::store::Released;
use crate::service::scheduler::admission::{Work, task_of};
use crate::service::scheduler::task::Class;
use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use serde_json::{Value, json};
use std::io;
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
        (status = 201, description = "It is known now, and yours", body = KnownScene),
        (status = 200, description = "You have sent it before", body = KnownScene),
    ),
)]
pub(crate) async fn add(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    let extra = |parameters: &mut Parameters, _: &HeaderMap| Ok(parameters.zoom());
    let SceneRequest { format, overrides, extra: zoom, tenant, body, .. } =
        scene_request::read(&service, request, extra).await?;
    let job = {
        let (service, tenant) = (Arc::clone(&service), Arc::clone(&tenant));
        move |job: &Work| remember(&service, job, &tenant, (body.as_ref(), format, &overrides), zoom)
    };
    let (new, about) = service.queue.run(task_of(&tenant, Class::Renders), job).await?.value;
    let status = if new { StatusCode::CREATED } else { StatusCode::OK };
    let location = about["links"]["self"].as_str().unwrap_or_default().to_owned();
    Ok((status, [(header::LOCATION, location)], Json(about)).into_response())
}

/// Whether the scene is new to the tenant, and what there is to say about it.
fn remember(
    service: &Service,
    job: &Work,
    tenant: &Tenant,
    (bytes, format, overrides): (&[u8], Format, &Overrides),
    zoom: u32,
) -> Result<(bool, Value), Problem> {
    let texts = &service.scenes.texts;
    let key = key(bytes, format, overrides);
    let ready = match service.scenes.recall(&key).filter(|ready| texts.has(&ready.scene_id)) {
        Some(ready) => ready,
        None => {
            let read = |mut loaded: Loaded| {
                let text = canonical(&mut loaded.description);
                (PreparedScene::from(loaded), text)
            };
            let built = service.scenes.build(&job.workers, bytes, format, overrides, read);
            if job.control.cancelled.load(Ordering::Relaxed) {
                return Err(gone());
            }
            let (ready, text) = built.map_err(|problems| Problem::scene(&problems))?;
            if !ready.reproducible {
                let detail = "pictures of this scene have no name, since files or a clock decide on them: put its textures \
                              into the scene, and ask for another accuracy than time";
                return Err(Problem::new(Kind::InvalidScene, detail));
            }
            if !texts.has(&ready.scene_id) && !texts.put(&ready.scene_id, text).map_err(|error| unwritten(&error))? {
                let detail = "the scene is larger than all that is remembered (known_scene_bytes)";
                return Err(Problem::new(Kind::TooLarge, detail));
            }
            service.scenes.keep(key, ready)
        }
    };
    let about = describe(&ready, job, zoom)?;
    let new = texts.claim(&ready.scene_id, &tenant.name).map_err(|error| unwritten(&error))?;
    Ok((new, about))
}

fn unwritten(error: &io::Error) -> Problem {
    tracing::error!(%error, "a scene cannot be written into the folder");
    Problem::new(Kind::Internal, "the scene cannot be remembered; the service's log says why")
}

/// What there is to say about a scene.
fn describe(ready: &PreparedScene, job: &Work, zoom: u32) -> Result<Value, Problem> {
    let [width, height] = size_of(&ready.scene, zoom).ok_or_else(|| {
        let detail = "opened this large, neighboring pixels have the same rays: ask for a smaller zoom, or for \
                      render.precision double";
        Problem::new(Kind::InvalidParameter, detail)
    })?;
    let whole = Region::whole(ready.scene.width, ready.scene.height);
    let (plan, _) = planned(ready, whole, &job.workers, &job.control).map_err(|_| gone())?;
    let plan = serde_json::to_value(&plan).unwrap_or_default();
    let scene = &ready.scene_id;
    let image = ImageId { scene: scene.clone(), zoom }.to_string();
    let [iiif, dzi, xyz] = tiles_of(&image);
    Ok(json!({
        "scene_id": scene,
        "image_id": image,
        "zoom": zoom,
        "width": width,
        "height": height,
        "warnings": ready.scene.warnings,
        "estimate": plan["estimate"],
        "links": {
            "self": format!("/v1/scenes/{scene}"),
            "image": format!("/v1/images/{image}.png"),
            "iiif": iiif,
            "dzi": dzi,
            "xyz": xyz,
        },
    }))
}

/// Where an image's tiles are, by convention: IIIF, DZI and XYZ.
pub(crate) fn tiles_of(image: &str) -> [String; 3] {
    [format!("/iiif/3/{image}/info.json"), format!("/dzi/{image}.dzi"), format!("/xyz/{image}.json")]
}

/// The canonical text of a known scene: all defaults filled in, keys in alphabetical order.
#[utoipa::path(
    get, path = "/v1/scenes/{scene_id}", operation_id = "scene", tag = "pictures",
    params(("scene_id" = String, Path, description = "As `POST /v1/scenes` says it.")),
    responses((status = 200, description = "The scene", body = AnyScene)),
)]
pub(crate) async fn get(
    State(service): State<App>,
    Extension(tenant): Extension<Arc<Tenant>>,
    Path(id): Path<String>,
) -> Result<Response, Problem> {
    let text = {
        let (service, id) = (Arc::clone(&service), id.clone());
        tokio::task::spawn_blocking(move || is_scene_id(&id).then(|| service.scenes.texts.get(&id)).flatten()).await
    };
    let text = match text.ok().flatten() {
        Some(text) => text,
        None => of_a_job(&service, &tenant, id.clone()).await?.into(),
    };
    let etag = format!("\"{id}\"");
    Ok(([(header::CONTENT_TYPE, "application/json"), (header::ETAG, &etag)], text).into_response())
}

/// The canonical text of a scene that nobody told to remember, but that some job is about.
async fn of_a_job(service: &App, tenant: &Tenant, id: String) -> Result<Vec<u8>, Problem> {
    let work = {
        let service = Arc::clone(service);
        move |job: &Work| {
            let order = service.jobs.order_of(&id).ok_or_else(|| unknown(&id))?;
            let text = service.jobs.scene(&order.scene).ok_or_else(|| unknown(&id))?;
            let read = |mut loaded: Loaded| canonical(&mut loaded.description);
            let built = service.scenes.build(&job.workers, &text, order.format, &order.settings, read);
            built.map_err(|problems| Problem::scene(&problems))
        }
    };
    Ok(service.queue.run(task_of(tenant, Class::Renders), work).await?.value)
}

/// Forgets a scene: it and its pictures go when nobody who has sent it wants it any more.
///
/// With the scope admin it goes at once, whoever has sent it.
#[utoipa::path(
    delete, path = "/v1/scenes/{scene_id}", operation_id = "removeScene", tag = "pictures",
    params(("scene_id" = String, Path, description = "As `POST /v1/scenes` says it.")),
    responses((status = 204, description = "It is forgotten")),
)]
pub(crate) async fn remove(
    State(service): State<App>,
    Extension(tenant): Extension<Arc<Tenant>>,
    Path(id): Path<String>,
) -> Result<StatusCode, Problem> {
    let released = {
        let (service, id) = (Arc::clone(&service), id.clone());
        tokio::task::spawn_blocking(move || {
            if !is_scene_id(&id) {
                return Released::Unknown;
            }
            let owner = Some(tenant.name.as_str()).filter(|_| !tenant.may(Scope::Admin));
            let released = service.scenes.texts.release(&id, owner);
            if released == Released::Gone {
                service.scenes.forget(&id);
                service.pictures.forget(&format!("i_{}_", &id[2..]));
            }
            released
        })
        .await
    };
    if released.unwrap_or(Released::Unknown) == Released::Unknown {
        return Err(Problem::new(Kind::NotFound, format!("you have sent no scene {id}, or it is forgotten already")));
    }
    Ok(StatusCode::NO_CONTENT)
}
