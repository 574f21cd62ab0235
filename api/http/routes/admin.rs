//! What operators ask, on a listener of its own: no crowd of clients can keep a probe waiting, and no client can read the
//! numbers.

use super::about;
use crate::http::App;
use axum::Router;
use axum::extract::State;
use axum::http::header;
use axum::response::IntoResponse;
use axum::routing::get;

/// Media type of OpenMetrics, which Prometheus asks for.
const OPEN_METRICS: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

/// Its paths.
pub(crate) fn routes(service: App) -> Router {
    Router::new()
        .route("/livez", get(about::livez))
        .route("/readyz", get(about::readyz))
        .route("/healthz", get(about::readyz))
        .route("/metrics", get(metrics))
        .with_state(service)
}

async fn metrics(State(service): State<App>) -> impl IntoResponse {
    ([(header::CONTENT_TYPE, OPEN_METRICS)], service.metrics.text(&service))
}
