//! About the service itself: is it alive, is it ready, its limits, the scene's schema, its contract.

use crate::http::App;
use crate::http::auth::tenant::Tenant;
use crate::http::contract::about::{AllLimits, Formats, Readiness, Version};
use crate::http::contract::openapi_text;
use crate::http::problem::{Kind, Problem};
use axum::Json;
use axum::extract::State;
use axum::http::{Extensions, StatusCode, Uri, header};
use axum::response::IntoResponse;
use serde_json::{Value, json};
use strahl::film::{DEFAULT_QUALITY, PictureFormat};
use strahl::render::RENDER_EPOCH;
use strahl::scene::schema::schema_text;

/// Whether the process answers.
#[utoipa::path(
    get, path = "/livez", operation_id = "livez", tag = "service", security(()),
    responses((status = 200, description = "It does", body = String)),
)]
pub(crate) async fn livez() -> impl IntoResponse {
    (no_store(), "alive\n")
}

/// Whether the service takes work. Being busy is no reason not to be ready; only stopping is.
#[utoipa::path(
    get, path = "/readyz", operation_id = "readyz", tag = "service", security(()),
    responses(
        (status = 200, description = "It takes work", body = Readiness),
        (status = 503, description = "It is about to stop", body = Readiness),
    ),
)]
pub(crate) async fn readyz(State(service): State<App>) -> impl IntoResponse {
    let (status, word) = if service.drain.has_begun() {
        (StatusCode::SERVICE_UNAVAILABLE, "draining")
    } else {
        (StatusCode::OK, "ready")
    };
    let (waiting, running) = service.jobs.counts();
    let body = json!({ "status": word, "running": service.queue.running(), "waiting": service.queue.waiting(), "jobs": { "waiting": waiting, "running": running } });
    (status, no_store(), Json(body))
}

/// What a request and a scene may ask for, and what whoever asks may have at one time.
#[utoipa::path(
    get, path = "/v1/limits", operation_id = "limits", tag = "service", security(()),
    responses((status = 200, description = "All limits by name", body = AllLimits)),
)]
pub(crate) async fn limits(State(service): State<App>, extensions: Extensions) -> Json<Value> {
    Json(service.limits.to_json(&Tenant::of(&extensions)))
}

/// The version of the service, and of what its pictures depend on.
#[utoipa::path(
    get, path = "/v1/version", operation_id = "version", tag = "service", security(()),
    responses((status = 200, description = "Name and numbers", body = Version)),
)]
pub(crate) async fn version() -> Json<Value> {
    Json(json!({ "name": "strahl", "version": env!("CARGO_PKG_VERSION"), "render_epoch": RENDER_EPOCH }))
}

/// The formats that pictures may have.
#[utoipa::path(
    get, path = "/v1/formats", operation_id = "formats", tag = "service", security(()),
    responses((status = 200, description = "Names, media types and parameters", body = Formats)),
)]
pub(crate) async fn formats() -> Json<Value> {
    let entry = |format: PictureFormat| {
        let parameters = match format {
            PictureFormat::Png => json!({ "bits": { "enum": [8, 16], "default": 8 } }),
            PictureFormat::Jpg => json!({ "quality": { "minimum": 1, "maximum": 100, "default": DEFAULT_QUALITY } }),
            PictureFormat::Webp | PictureFormat::Exr | PictureFormat::Pfm => json!({}),
        };
        let (name, media_type) = format.names();
        json!({
            "name": name,
            "media_type": media_type,
            "lossless": format != PictureFormat::Jpg,
            "linear": format.is_linear(),
            "parameters": parameters,
        })
    };
    Json(json!({ "formats": PictureFormat::ALL.map(entry).as_slice() }))
}

/// The JSON Schema of scenes.
#[utoipa::path(
    get, path = "/schema/scene.json", operation_id = "sceneSchema", tag = "service", security(()),
    responses((status = 200, description = "Draft 2020-12", body = Object, content_type = "application/schema+json")),
)]
pub(crate) async fn schema() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/schema+json")], schema_text())
}

/// This document.
#[utoipa::path(
    get, path = "/openapi.json", operation_id = "openapi", tag = "service", security(()),
    responses((status = 200, description = "OpenAPI 3.1", body = Object, content_type = "application/json")),
)]
pub(crate) async fn openapi() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/json")], openapi_text())
}

/// Any other path.
pub(crate) async fn not_found(uri: Uri) -> Problem {
    Problem::new(Kind::NotFound, format!("there is nothing at {}", uri.path()))
}

/// A path with another method than its own.
pub(crate) async fn method_not_allowed(uri: Uri) -> Problem {
    Problem::new(
        Kind::MethodNotAllowed,
        format!("{} does not take this method; Allow lists those it takes", uri.path()),
    )
}

fn no_store() -> [(header::HeaderName, &'static str); 1] {
    [(header::CACHE_CONTROL, "no-store")]
}
