//! Every path of the service.

use super::problem::{Kind, Problem};
use super::tenant::Tenant;
use super::{App, envelope, meta, picture, questions, rays, tradeoff};
use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::middleware::{from_fn_with_state, map_request};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use std::any::Any;
use std::sync::Arc;
use tower::ServiceBuilder;
use tower_http::catch_panic::CatchPanicLayer;

/// The service as a router.
pub(super) fn routes(service: App) -> Router {
    let work = Router::new()
        .route("/v1/render", post(picture::whole))
        .route("/v1/render/tile", post(picture::tile))
        .route("/v1/rays", post(rays::rays))
        .route("/v1/tree", post(questions::tree))
        .route("/v1/explain", post(questions::explanation))
        .route("/v1/tradeoff", post(tradeoff::tradeoff))
        .route("/v1/scenes/validate", post(questions::validate));
    let about = Router::new()
        .route("/livez", get(meta::livez))
        .route("/readyz", get(meta::readyz))
        .route("/v1/limits", get(meta::limits))
        .route("/schema/scene.json", get(meta::schema))
        .route("/problems/{slug}", get(meta::problem_page));
    work.merge(about)
        .fallback(meta::not_found)
        .method_not_allowed_fallback(meta::method_not_allowed)
        .layer(
            ServiceBuilder::new()
                .layer(from_fn_with_state(Arc::clone(&service), envelope::envelope))
                .layer(CatchPanicLayer::custom(panicked))
                .layer(map_request(async |request| Tenant::identify(request)))
                // Bodies are read by `body::read`, which has limits of its own.
                .layer(DefaultBodyLimit::disable()),
        )
        .with_state(service)
}

/// A handler panicked (jobs are caught in the queue). The panic itself has been written to standard error.
fn panicked(_: Box<dyn Any + Send>) -> Response {
    Problem::new(Kind::Internal, "the request failed; the service goes on, and its log says more").into_response()
}
