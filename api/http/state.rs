//! What all handlers share.

use super::auth::Access;
use super::auth::client::Client;
use super::concurrency_limit::ConcurrencyLimit;
use super::drain::Drain;
use super::memory_budget::MemoryBudget;
use super::metrics::Metrics;
use super::settings::{ConnectionLimits, Origins};
use crate::service::requests::Service;
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

/// How handlers get it.
pub(crate) type App = Arc<AppState>;
