//! `GET /metrics`, on the admin listener.

use crate::http::state::App;
use axum::extract::State;
use axum::http::header;
use axum::response::IntoResponse;

/// Media type of OpenMetrics, which Prometheus asks for.
const OPEN_METRICS: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

/// All metrics.
pub(super) async fn metrics(State(app): State<App>) -> impl IntoResponse {
    ([(header::CONTENT_TYPE, OPEN_METRICS)], app.metrics.text(&app.service, app.streams.taken()))
}
