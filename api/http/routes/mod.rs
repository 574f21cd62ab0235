//! Every path of the service: one file for each noun, with its handlers, its request and answer types, and its part of the
//! contract. Routes do not use each other.

mod about;
mod assets;
mod capabilities;
mod compare;
mod docs;
mod embed;
mod explain;
mod farm;
mod health;
mod home;
mod images;
mod jobs;
mod map;
mod me;
mod metrics;
mod problems;
mod rays;
mod render;
mod scenes;
mod studio;
mod tiles;
mod tradeoff;
mod tree;
mod validate;

use super::auth::tenant::Scope;
use super::contract::Route;
use super::middleware::auth_gate::{identify, require};
use super::middleware::cors::cors;
use super::middleware::host_gate::{check_admin_host, check_host};
use super::middleware::request_log::request_log;
use super::middleware::transfer_gate::check_transfer;
use super::problem::{Kind, Problem};
use super::state::App;
use axum::Router;
use axum::extract::{DefaultBodyLimit, Request};
use axum::http::{Method, StatusCode, Uri};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use std::any::Any;
use std::pin::Pin;
use std::sync::Arc;
use tower::ServiceBuilder;
use tower_http::catch_panic::CatchPanicLayer;

type BoxFuture<T> = Pin<Box<dyn Future<Output = T> + Send>>;

/// All routes for clients.
pub(crate) fn all() -> Vec<Route> {
    let groups: [fn() -> Vec<Route>; 23] = [
        home::routes,
        render::routes,
        rays::routes,
        tree::routes,
        map::routes,
        explain::routes,
        tradeoff::routes,
        compare::routes,
        validate::routes,
        scenes::routes,
        assets::routes,
        images::routes,
        jobs::routes,
        tiles::routes,
        capabilities::routes,
        me::routes,
        farm::routes,
        health::routes,
        about::routes,
        docs::routes,
        embed::routes,
        studio::routes,
        problems::routes,
    ];
    groups.into_iter().flat_map(|routes| routes()).collect()
}

/// The service for clients.
pub(crate) fn router(app: App) -> Router {
    let mut routes = all();
    let scopes = [Some(Scope::Render), Some(Scope::Jobs), Some(Scope::Read), Some(Scope::Admin), None];
    let mut router = Router::new();
    for (scope, is_free) in scopes.into_iter().flat_map(|scope| [(scope, false), (scope, true)]) {
        let (of_scope, others): (Vec<_>, Vec<_>) =
            routes.into_iter().partition(|route| (route.scope, route.is_free) == (scope, is_free));
        routes = others;
        if of_scope.is_empty() {
            continue;
        }
        let mut group = Router::new();
        for route in of_scope {
            group = group.route(route.path, route.handler);
        }
        router = router.merge(match scope {
            Some(scope) => group.route_layer(from_fn(needs(scope, is_free))),
            None => group,
        });
    }
    router
        .fallback(not_found)
        .method_not_allowed_fallback(method_not_allowed)
        .layer(
            ServiceBuilder::new()
                .layer(from_fn_with_state(Arc::clone(&app), cors))
                .layer(from_fn_with_state(Arc::clone(&app), request_log))
                .layer(CatchPanicLayer::custom(panicked))
                .layer(from_fn(check_transfer))
                .layer(from_fn_with_state(Arc::clone(&app), check_host))
                .layer(from_fn_with_state(Arc::clone(&app), identify))
                // Bodies are read by `extract::body`, which has limits of its own.
                .layer(DefaultBodyLimit::disable()),
        )
        .with_state(app)
}

/// The answer to another front, about a job that this one works on.
pub(crate) async fn answer_front(app: App, question: Vec<u8>) -> (Vec<u8>, Vec<u8>) {
    jobs::answer_front(app, question).await
}

/// The routes of the admin listener. Clients can neither delay its probes nor read its metrics.
pub(crate) fn admin(app: App) -> Router {
    Router::new()
        .route("/livez", get(health::livez))
        .route("/readyz", get(health::readyz))
        .route("/healthz", get(health::readyz))
        .route("/metrics", get(metrics::metrics))
        .layer(from_fn_with_state(Arc::clone(&app), check_admin_host))
        .with_state(app)
}

/// Refuses requests whose key lacks a scope.
fn needs(scope: Scope, is_free: bool) -> impl Fn(Request, Next) -> BoxFuture<Result<Response, Problem>> + Clone {
    move |request, next| Box::pin(require(scope, is_free, request, next))
}

/// The answer if a handler has panicked, which standard error tells. Panics of renders are caught in the queue.
fn panicked(_: Box<dyn Any + Send>) -> Response {
    Problem::new(Kind::Internal, "the request failed; the service goes on, and its log says more").into_response()
}

/// The answer to any other path.
async fn not_found(method: Method, uri: Uri) -> Result<StatusCode, Problem> {
    let path = uri.path();
    if method == Method::OPTIONS && path == "*" {
        // About the service as a whole (RFC 9110 section 9.3.7): it is there.
        return Ok(StatusCode::NO_CONTENT);
    }
    let detail = match path {
        "/metrics" => "metrics are on the listener for operators (--admin-listen)".to_owned(),
        _ => format!("there is nothing at {path}; /openapi.json lists what there is"),
    };
    Err(Problem::new(Kind::NotFound, detail))
}

/// The answer to a method that a path does not take.
async fn method_not_allowed(uri: Uri) -> Problem {
    let detail = format!("{} does not take this method; Allow lists those it takes", uri.path());
    Problem::new(Kind::MethodNotAllowed, detail)
}
