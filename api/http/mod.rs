//! The service over HTTP: connections, middleware, authorization, routes and the contract.

mod activity;
pub(crate) mod auth;
mod client_socket;
mod connection_limit;
mod contract;
mod drain;
mod extract;
mod host;
#[cfg(any(test, fuzzing))]
pub(crate) mod in_process;
mod metrics;
mod middleware;
mod prelude;
mod problem;
mod raw_errors;
mod respond;
mod routes;
mod scene_job;
mod server;
pub(crate) mod settings;
mod start;
mod state;

pub(crate) use start::{check, run};

/// The contract as the text of `api/openapi.json`.
pub(crate) fn openapi_text() -> String {
    contract::openapi_text(&routes::all())
}
