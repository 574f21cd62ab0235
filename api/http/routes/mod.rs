//! Every path of the service.

pub(crate) mod about;
pub(crate) mod admin;
pub(crate) mod capabilities;
pub(crate) mod docs;
pub(crate) mod explain;
pub(crate) mod images;
pub(crate) mod jobs;
pub(crate) mod map;
pub(crate) mod problems;
pub(crate) mod rays;
pub(crate) mod render;
pub(crate) mod scenes;
pub(crate) mod tiles;
pub(crate) mod tradeoff;

use crate::http::App;
use crate::http::auth::tenant::Scope;
use crate::http::contract::Shared;
use crate::http::middleware::request_log;
use crate::http::middleware::{auth_gate, cors};
use crate::http::problem::{Kind, Problem};
use axum::Router;
use axum::extract::{DefaultBodyLimit, Request};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use std::any::Any;
use std::pin::Pin;
use std::sync::Arc;
use tower::ServiceBuilder;
use tower_http::catch_panic::CatchPanicLayer;
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

type BoxFuture<T> = Pin<Box<dyn Future<Output = T> + Send>>;

/// The service as a router.
pub(crate) fn routes(service: App) -> Router {
    let (router, _) = documented().split_for_parts();
    router
        .fallback(about::not_found)
        .method_not_allowed_fallback(about::method_not_allowed)
        .layer(
            ServiceBuilder::new()
                .layer(from_fn_with_state(Arc::clone(&service), cors::cors))
                .layer(from_fn_with_state(Arc::clone(&service), request_log::envelope))
                .layer(CatchPanicLayer::custom(panicked))
                .layer(from_fn_with_state(Arc::clone(&service), auth_gate::identify))
                // Bodies are read by `body::read`, which has limits of its own.
                .layer(DefaultBodyLimit::disable()),
        )
        .with_state(service)
}

/// Every path, with its place in the contract.
pub(crate) fn documented() -> OpenApiRouter<App> {
    let render = OpenApiRouter::with_openapi(Shared::openapi())
        .routes(routes!(render::tile))
        .routes(routes!(rays::rays))
        .routes(routes!(explain::tree))
        .routes(routes!(map::map))
        .routes(routes!(explain::explanation))
        .routes(routes!(tradeoff::tradeoff))
        .routes(routes!(explain::validate))
        .routes(routes!(scenes::add))
        .routes(routes!(scenes::remove))
        .route_layer(from_fn(needs(Scope::Render)));
    let jobs = OpenApiRouter::new()
        .routes(routes!(jobs::submit_job))
        .routes(routes!(jobs::change_job, jobs::forget_job))
        .routes(routes!(jobs::cancel_job))
        .route_layer(from_fn(needs(Scope::Jobs)));
    let (schemas, paths, whole) = routes!(render::whole);
    // The router knows no QUERY yet, so it comes with all other methods, which `route_layer` would leave open.
    let whole = whole.fallback(render::query).layer(from_fn(needs(Scope::Render)));
    let whole = OpenApiRouter::new().routes((schemas, paths, whole));
    let read = OpenApiRouter::new()
        .routes(routes!(capabilities::mint))
        .routes(routes!(scenes::get))
        .routes(routes!(images::image))
        .routes(routes!(tiles::iiif))
        .routes(routes!(tiles::iiif_info))
        .routes(routes!(tiles::iiif_image))
        .routes(routes!(tiles::dzi))
        .routes(routes!(tiles::dzi_tile))
        .routes(routes!(tiles::xyz))
        .routes(routes!(tiles::xyz_tile))
        .routes(routes!(jobs::jobs))
        .routes(routes!(jobs::job))
        .routes(routes!(jobs::job_image))
        .routes(routes!(jobs::job_preview))
        .routes(routes!(jobs::job_tile))
        .routes(routes!(jobs::look_at_job))
        .routes(routes!(jobs::job_events))
        .routes(routes!(jobs::events))
        .route_layer(from_fn(needs(Scope::Read)));
    let about = OpenApiRouter::new()
        .routes(routes!(about::livez))
        .routes(routes!(about::readyz))
        .routes(routes!(about::limits))
        .routes(routes!(about::version))
        .routes(routes!(about::formats))
        .routes(routes!(about::schema))
        .routes(routes!(about::openapi))
        .routes(routes!(docs::page))
        .routes(routes!(docs::viewer))
        .routes(routes!(problems::list))
        .routes(routes!(problems::page));
    render.merge(whole).merge(jobs).merge(read).merge(about)
}

/// Lets those through whose key allows such a thing.
fn needs(scope: Scope) -> impl Fn(Request, Next) -> BoxFuture<Result<Response, Problem>> + Clone {
    move |request, next| Box::pin(auth_gate::require(scope, request, next))
}

/// A handler panicked (jobs are caught in the queue). The panic itself has been written to standard error.
fn panicked(_: Box<dyn Any + Send>) -> Response {
    Problem::new(Kind::Internal, "the request failed; the service goes on, and its log says more").into_response()
}
