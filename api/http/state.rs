//! The state that all handlers share.

use super::auth::Access;
use super::auth::client::Client;
use super::drain::Drain;
use super::host::Host;
use super::metrics::Metrics;
use super::settings::{ConnectionLimits, Origins, Studio};
use crate::service::concurrency_limit::ConcurrencyLimit;
use crate::service::requests::Service;
use axum::http::Extensions;
use std::sync::{Arc, LazyLock};

/// The state of the service over HTTP.
#[derive(Debug)]
pub(crate) struct AppState {
    /// Scenes, pictures and jobs.
    pub(crate) service: Arc<Service>,
    /// Keys, capabilities and rate limits.
    pub(crate) access: Arc<Access>,
    /// Origins whose pages may use the service.
    pub(crate) origins: Origins,
    /// The address under which clients see the service, if it is set.
    pub(crate) public_url: Option<String>,
    /// Open event streams of tenants.
    pub(crate) streams: ConcurrencyLimit<String>,
    /// Requests of tenants that wait for jobs.
    pub(crate) waits: ConcurrencyLimit<String>,
    /// Requests of tenants that are being answered.
    pub(crate) requests: ConcurrencyLimit<String>,
    /// Connections that there may be.
    pub(crate) max_connections: u32,
    /// Tiles that are being answered.
    pub(crate) tile_clients: ConcurrencyLimit<Client>,
    /// Where the files of the studio are.
    pub(crate) studio: Studio,
    /// What one connection may take.
    pub(crate) limits: ConnectionLimits,
    /// Figures for Prometheus.
    pub(crate) metrics: Arc<Metrics>,
    /// Whether the service is draining.
    pub(crate) drain: Drain,
    /// The contract, made at the first request for it.
    pub(crate) contract: LazyLock<String>,
}

impl AppState {
    /// The host of `public_url`, if it is set.
    pub(crate) fn public_host(&self) -> Option<Host> {
        self.public_url.as_deref().and_then(Host::of_url)
    }

    /// The address under which the client of a request sees the service.
    pub(crate) fn base_url(&self, extensions: &Extensions) -> String {
        let of_host = || match extensions.get::<Host>() {
            Some(host) => format!("http://{host}"),
            None => "http://localhost".to_owned(),
        };
        self.public_url.clone().unwrap_or_else(of_host)
    }

    /// A first request, to try.
    pub(crate) fn first_request(&self, base_url: &str) -> String {
        let key = if self.access.needs_keys() { " -H 'Authorization: Bearer KEY'" } else { "" };
        format!("curl {base_url}/v1/render{key} --data-binary @scene.json -o picture.png")
    }
}

/// The state as handlers get it.
pub(crate) type App = Arc<AppState>;
