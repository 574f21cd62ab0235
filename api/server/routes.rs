//! Every path of the service.

use super::openapi::Shared;
use super::problem::{Kind, Problem, pages};
use super::tenant::Scope;
use super::{App, access, docs, envelope, images, jobs, known, maps, meta, picture, questions, rays, tiles, tradeoff};
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
        .fallback(meta::not_found)
        .method_not_allowed_fallback(meta::method_not_allowed)
        .layer(
            ServiceBuilder::new()
                .layer(from_fn_with_state(Arc::clone(&service), access::cors))
                .layer(from_fn_with_state(Arc::clone(&service), envelope::envelope))
                .layer(CatchPanicLayer::custom(panicked))
                .layer(from_fn_with_state(Arc::clone(&service), access::identify))
                // Bodies are read by `body::read`, which has limits of its own.
                .layer(DefaultBodyLimit::disable()),
        )
        .with_state(service)
}

/// Every path, with its place in the contract.
pub(crate) fn documented() -> OpenApiRouter<App> {
    let render = OpenApiRouter::with_openapi(Shared::openapi())
        .routes(routes!(picture::tile))
        .routes(routes!(rays::rays))
        .routes(routes!(questions::tree))
        .routes(routes!(maps::map))
        .routes(routes!(questions::explanation))
        .routes(routes!(tradeoff::tradeoff))
        .routes(routes!(questions::validate))
        .routes(routes!(known::add))
        .routes(routes!(known::remove))
        .route_layer(from_fn(needs(Scope::Render)));
    let jobs = OpenApiRouter::new()
        .routes(routes!(jobs::submit_job))
        .routes(routes!(jobs::change_job, jobs::forget_job))
        .routes(routes!(jobs::cancel_job))
        .route_layer(from_fn(needs(Scope::Jobs)));
    let (schemas, paths, whole) = routes!(picture::whole);
    // The router knows no QUERY yet, so it comes with all other methods, which `route_layer` would leave open.
    let whole = whole.fallback(picture::query).layer(from_fn(needs(Scope::Render)));
    let whole = OpenApiRouter::new().routes((schemas, paths, whole));
    let read = OpenApiRouter::new()
        .routes(routes!(access::mint))
        .routes(routes!(known::get))
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
        .routes(routes!(meta::livez))
        .routes(routes!(meta::readyz))
        .routes(routes!(meta::limits))
        .routes(routes!(meta::version))
        .routes(routes!(meta::formats))
        .routes(routes!(meta::schema))
        .routes(routes!(meta::openapi))
        .routes(routes!(docs::page))
        .routes(routes!(docs::viewer))
        .routes(routes!(pages::list))
        .routes(routes!(pages::page));
    render.merge(whole).merge(jobs).merge(read).merge(about)
}

/// Lets those through whose key allows such a thing.
fn needs(scope: Scope) -> impl Fn(Request, Next) -> BoxFuture<Result<Response, Problem>> + Clone {
    move |request, next| Box::pin(access::require(scope, request, next))
}

/// A handler panicked (jobs are caught in the queue). The panic itself has been written to standard error.
fn panicked(_: Box<dyn Any + Send>) -> Response {
    Problem::new(Kind::Internal, "the request failed; the service goes on, and its log says more").into_response()
}
