//! `/v1/scenes`: scenes that are stored by their ids, so that their pictures have URLs.

use crate::http::extract::conditions::{Verdict, may_act, weigh};
use crate::http::extract::scene_request::{self, SceneRequest};
use crate::http::extract::scene_types;
use crate::http::prelude::*;
use crate::http::respond::body;
use crate::http::respond::image::tiles_of;
use crate::service::requests::scenes::Remembered;
use crate::service::scenes::sent_scene::SentScene;
use crate::service::scenes::store::{Released, Source};
use crate::service::scheduler::admission::Work;
use crate::service::scheduler::task::Class;
use axum::Extension;
use axum::body::Bytes;
use axum::http::Method;
use serde_json::json;
use std::io::BufRead;
use strahl::film::Region;
use strahl::plan::estimate::Estimate;
use strahl::scene::{self, Format};

/// Pixels across and down of a small picture.
const SMALL: u64 = 1_024;

pub(super) fn routes() -> Vec<Route> {
    let known = [Content::json::<KnownScene<'_>>()];
    let scene = Content::of("application/json", |_| json!({ "$ref": "#/components/schemas/Scene" }));
    let about_add = "Stores a scene, opened as 2^zoom times its size, and returns the paths of its pictures and tiles.";
    let about_get = "The canonical text of a known scene: all defaults filled in, keys in alphabetical order.\n\nOnly the \
                     tenants that have sent it, in a request or a job, may read it, and who has a capability of theirs.";
    let about_source = "The text of a known scene as you have posted it last, in its own order and layout.\n\nOf a text of more than \
                        1 MiB, of a variation, and of a job's scene it is the canonical one.";
    let about_remove = "Forgets a scene. It and its pictures are deleted once every tenant that posted it has deleted \
                        it.\n\nWith the scope admin they are deleted at once.";
    vec![
        Route::post("/v1/scenes", add, ["addScene", "pictures", about_add])
            .query(Query::zoom)
            .about_scene()
            .answer(201, "It is known now, and yours", &known)
            .answer(200, "You have sent it before", &known),
        Route::get("/v1/scenes/{scene_id}", get, ["scene", "pictures", about_get])
            .needs(Scope::Read)
            .path("scene_id", "As `POST /v1/scenes` says it.")
            .header("If-None-Match", "The ETag of the scene that the client has.")
            .answer(200, "The scene", &[scene])
            .answer_header("ETag", "Its id.")
            .answer(304, "The client has it", &[]),
        Route::get("/v1/scenes/{scene_id}/source", source, ["sceneSource", "pictures", about_source])
            .needs(Scope::Read)
            .path("scene_id", "As `POST /v1/scenes` says it.")
            .answer(200, "The scene", &[scene, Content::text("text/x-nff"), Content::file("application/gzip")]),
        Route::delete("/v1/scenes/{scene_id}", remove, ["removeScene", "pictures", about_remove])
            .needs(Scope::Render)
            .path("scene_id", "As `POST /v1/scenes` says it.")
            .header("If-Match", "The scene's ETag.")
            .answer(204, "It is forgotten", &[]),
    ]
}

/// A stored scene.
#[derive(Debug, Serialize, JsonSchema)]
struct KnownScene<'a> {
    /// Its id: a hash of what it says, not of how it was written.
    scene_id: &'a str,
    /// The id of its picture, opened as 2^zoom times its size.
    image_id: String,
    /// The scene was opened as 2^zoom times its size.
    zoom: u32,
    /// Pixels across.
    width: u32,
    /// Pixels down.
    height: u32,
    /// Warnings about the scene.
    warnings: &'a [scene::Problem],
    /// Estimated rays and milliseconds of its picture.
    estimate: Estimate,
    /// Paths of the scene, its picture and its tiles.
    links: SceneLinks,
}

/// Paths of a scene, its picture and its tiles.
#[derive(Debug, Serialize, JsonSchema)]
struct SceneLinks {
    /// The scene's canonical text.
    #[serde(rename = "self")]
    this: String,
    /// The picture as a PNG, or where it is more than one answer may be, a small one: at most 1,024 pixels across and down.
    image: String,
    /// The description of the image for IIIF.
    iiif: String,
    /// The description of the image for DZI.
    dzi: String,
    /// The description of the image's tiles for XYZ.
    xyz: String,
}

async fn add(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    let SceneRequest { form, overrides, extra: zoom, tenant, body, .. } =
        scene_request::read(&app, request, |query, _| Ok(query.zoom())).await?;
    let work = {
        let (service, tenant) = (Arc::clone(&app.service), tenant.name.clone());
        move |work: &Work| service.remember(work, &tenant, &SentScene::new(body.as_ref(), &form, &overrides), zoom)
    };
    let remembered = app.service.run(tenant.task(Class::Renders), work).await?.value;
    let Remembered { ready, image: id, size: [width, height], estimate, is_new } = remembered;
    let image_id = id.to_string();
    let [iiif, dzi, xyz] = tiles_of(&image_id);
    let limits = &app.service.settings.answers;
    let image = match limits.check(Region::whole(width, height), ready.scene.samples) {
        Ok(()) => format!("/v1/images/{image_id}.png"),
        Err(_) => {
            let side = limits.max_area(&ready.scene).isqrt().min(SMALL).min(width.max(height).into());
            format!("/iiif/3/{image_id}/full/!{side},{side}/0/default.png")
        }
    };
    let this = format!("/v1/scenes/{}", ready.scene_id);
    let location = [(header::LOCATION, this.clone())];
    let known = KnownScene {
        scene_id: &ready.scene_id,
        zoom,
        width,
        height,
        warnings: &ready.scene.warnings,
        estimate,
        links: SceneLinks { this, image, iiif, dzi, xyz },
        image_id,
    };
    let status = if is_new { StatusCode::CREATED } else { StatusCode::OK };
    Ok((status, location, Json(known)).into_response())
}

async fn get(
    State(app): State<App>,
    Extension(tenant): Extension<Arc<Tenant>>,
    Path(id): Path<String>,
    method: Method,
    conditions: HeaderMap,
) -> Result<Response, Problem> {
    let etag = etag(&id);
    let text = app.service.scene_text(tenant.task(Class::Renders), id, owner(&tenant)).await?;
    match weigh(&method, &conditions, Some(&etag)) {
        Verdict::NotModified => return Ok((StatusCode::NOT_MODIFIED, [(header::ETAG, etag)]).into_response()),
        Verdict::Failed => return Err(other_scene(&etag)),
        Verdict::Proceed => {}
    }
    let headers = [(header::CONTENT_TYPE, "application/json"), (header::ETAG, &etag)];
    Ok((headers, Bytes::from_owner(text)).into_response())
}

async fn source(
    State(app): State<App>,
    Extension(tenant): Extension<Arc<Tenant>>,
    Path(id): Path<String>,
    method: Method,
    conditions: HeaderMap,
) -> Result<Response, Problem> {
    let claim = app.service.scene_claim(id.clone(), tenant.name.clone()).await;
    let Some(Source { format, text }) = claim.as_deref().and_then(Source::read) else {
        return get(State(app), Extension(tenant), Path(id), method, conditions).await;
    };
    let media_type = scene_types::name_of(format, text);
    // The first line of parts is their boundary.
    let boundary = (format == Format::Parts).then(|| text.get(2..).unwrap_or_default().lines().next()?.ok());
    let boundary =
        boundary.flatten().map_or_else(String::new, |boundary| format!("; boundary={}", boundary.trim_end()));
    let headers =
        [(header::CONTENT_TYPE, format!("{media_type}{boundary}")), (header::CACHE_CONTROL, "no-cache".into())];
    Ok((headers, body(app.service.memory.metered(text.to_vec())?)).into_response())
}

async fn remove(
    State(app): State<App>,
    Extension(tenant): Extension<Arc<Tenant>>,
    Path(id): Path<String>,
    conditions: HeaderMap,
) -> Result<StatusCode, Problem> {
    let unknown = || Problem::new(Kind::NotFound, format!("you have sent no scene {id}, or it is forgotten already"));
    let etag = etag(&id);
    if !may_act(&conditions, Some(&etag)) {
        // Who has not sent it hears nothing of it.
        let is_known = app.service.is_known_scene(id.clone(), owner(&tenant)).await?;
        return Err(if is_known { other_scene(&etag) } else { unknown() });
    }
    match app.service.forget_scene(id.clone(), owner(&tenant)).await? {
        Released::Unknown => Err(unknown()),
        Released::Shared | Released::Gone => Ok(StatusCode::NO_CONTENT),
    }
}

/// The ETag of a scene.
fn etag(id: &str) -> String {
    format!("\"{id}\"")
}

/// The scene is another one than the request wants.
fn other_scene(etag: &str) -> Problem {
    Problem::new(Kind::PreconditionFailed, format!("the scene is {etag}"))
}

/// Whose scenes a tenant may read and remove: its own, and operators those of all.
fn owner(tenant: &Tenant) -> Option<String> {
    (!tenant.may(Scope::Admin)).then(|| tenant.name.clone())
}
