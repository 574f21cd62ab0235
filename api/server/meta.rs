//! About the service itself: is it alive, is it ready, its limits, the scene's schema, its contract.

use super::App;
use super::openapi::bodies::Readiness;
use super::openapi::openapi_text;
use super::problem::{Kind, Problem};
use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, Uri, header};
use axum::response::IntoResponse;
use serde_json::{Value, json};
use strahl::scene::schema::schema_text;

/// Whether the process answers.
#[utoipa::path(
    get, path = "/livez", operation_id = "livez", tag = "service", security(()),
    responses((status = 200, description = "It does", body = String)),
)]
pub(super) async fn livez() -> impl IntoResponse {
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
pub(super) async fn readyz(State(service): State<App>) -> impl IntoResponse {
    let (status, word) = if service.drain.has_begun() {
        (StatusCode::SERVICE_UNAVAILABLE, "draining")
    } else {
        (StatusCode::OK, "ready")
    };
    let (waiting, running) = service.jobs.counts();
    let body = json!({ "status": word, "running": service.queue.running(), "waiting": service.queue.waiting(), "jobs": { "waiting": waiting, "running": running } });
    (status, no_store(), Json(body))
}

/// What a request and a scene may ask for.
#[utoipa::path(
    get, path = "/v1/limits", operation_id = "limits", tag = "service", security(()),
    responses((status = 200, description = "All limits by name", body = Value)),
)]
pub(super) async fn limits(State(service): State<App>) -> Json<Value> {
    Json(service.limits.to_json())
}

/// The JSON Schema of scenes.
#[utoipa::path(
    get, path = "/schema/scene.json", operation_id = "sceneSchema", tag = "service", security(()),
    responses((status = 200, description = "Draft 2020-12", body = Value, content_type = "application/schema+json")),
)]
pub(super) async fn schema() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/schema+json")], schema_text())
}

/// This document.
#[utoipa::path(
    get, path = "/openapi.json", operation_id = "openapi", tag = "service", security(()),
    responses((status = 200, description = "OpenAPI 3.1", body = Value, content_type = "application/json")),
)]
pub(super) async fn openapi() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/json")], openapi_text())
}

/// Any other path.
pub(super) async fn not_found(uri: Uri) -> Problem {
    Problem::new(Kind::NotFound, format!("there is nothing at {}", uri.path()))
}

/// A path with another method than its own.
pub(super) async fn method_not_allowed(uri: Uri) -> Problem {
    Problem::new(
        Kind::MethodNotAllowed,
        format!("{} does not take this method; Allow lists those it takes", uri.path()),
    )
}

fn no_store() -> [(header::HeaderName, &'static str); 1] {
    [(header::CACHE_CONTROL, "no-store")]
}
