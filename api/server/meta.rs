//! About the service itself: is it alive, is it ready, its limits, the scene's schema, what its problems mean.

use super::App;
use super::problem::{Kind, Problem};
use axum::Json;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use axum::http::{StatusCode, Uri, header};
use axum::response::IntoResponse;
use serde_json::{Value, json};
use strahl::scene::schema::schema_text;

/// `GET /livez`: the process answers.
pub(super) async fn livez() -> impl IntoResponse {
    (no_store(), "alive\n")
}

/// `GET /readyz`: it takes work. Being busy is no reason not to be ready; only stopping is.
pub(super) async fn readyz(State(service): State<App>) -> impl IntoResponse {
    let (status, word) = if service.drain.has_begun() {
        (StatusCode::SERVICE_UNAVAILABLE, "draining")
    } else {
        (StatusCode::OK, "ready")
    };
    let body = json!({ "status": word, "running": service.queue.running(), "waiting": service.queue.waiting() });
    (status, no_store(), Json(body))
}

/// `GET /v1/limits`.
pub(super) async fn limits(State(service): State<App>) -> Json<Value> {
    Json(service.limits.to_json())
}

/// `GET /schema/scene.json`.
pub(super) async fn schema() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/schema+json")], schema_text())
}

/// `GET /problems/{slug}`.
pub(super) async fn problem_page(slug: Result<Path<String>, PathRejection>) -> Result<String, Problem> {
    let slug = slug.map_or_else(|_| String::new(), |Path(slug)| slug);
    Kind::ALL
        .iter()
        .map(|kind| kind.page())
        .find(|(known, ..)| *known == slug)
        .map(|(_, status, title, advice)| format!("{title} ({})\n\n{advice}\n", status.as_u16()))
        .ok_or_else(|| Problem::new(Kind::NotFound, "there is no problem of that name"))
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
