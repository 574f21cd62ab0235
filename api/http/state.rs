//! What all handlers share.

use super::auth::Access;
use super::auth::client::Client;
use super::drain::Drain;
use super::host::Host;
use super::memory_budget::MemoryBudget;
use super::metrics::Metrics;
use super::settings::{ConnectionLimits, Origins};
use crate::service::concurrency_limit::ConcurrencyLimit;
use crate::service::requests::Service;
use axum::http::Extensions;
use std::sync::{Arc, LazyLock};

/// Everything that handlers share.
#[derive(Debug)]
pub(crate) struct AppState {
    /// Scenes, pictures and jobs.
    pub(crate) service: Arc<Service>,
    /// Who may do what.
    pub(crate) access: Arc<Access>,
    /// Whose pages may ask.
    pub(crate) origins: Origins,
    /// The address under which clients see the service, if it was told.
    pub(crate) public_url: Option<String>,
    /// Open event streams of tenants.
    pub(crate) streams: ConcurrencyLimit<String>,
    /// Tiles that are being answered.
    pub(crate) tile_clients: ConcurrencyLimit<Client>,
    /// What one connection may take.
    pub(crate) limits: ConnectionLimits,
    /// How much memory bodies and answers may take together.
    pub(crate) memory: MemoryBudget,
    /// What has been counted.
    pub(crate) metrics: Arc<Metrics>,
    /// Whether the service is about to end.
    pub(crate) drain: Drain,
    /// The contract, made when somebody asks for it.
    pub(crate) contract: LazyLock<String>,
}

impl AppState {
    /// The host of the address under which clients see the service, if it was told.
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
}

/// How handlers get it.
pub(crate) type App = Arc<AppState>;
