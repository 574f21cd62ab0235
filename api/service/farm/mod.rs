//! The farm: a broker and a store between fronts, which take requests, and nodes, which render.

pub(crate) mod accounts;
pub(crate) mod connection;
pub(crate) mod names;
pub(crate) mod settings;

use self::connection::Broker;
use self::settings::FarmSettings;
use crate::service::error::StartError;
use tokio::runtime::Handle;

/// The farm as a front sees it.
#[derive(Debug)]
pub(crate) struct Farm {
    /// The connection to the broker.
    pub(crate) broker: Broker,
    /// The runtime of the connection. Threads of jobs wait on it.
    pub(crate) runtime: Handle,
}

impl Farm {
    /// Connects a front, if the settings name a broker. Not to be called on a thread of a runtime.
    pub(crate) fn open(settings: &FarmSettings, runtime: &Handle) -> Result<Option<Self>, StartError> {
        if settings.farm.is_none() {
            return Ok(None);
        }
        let broker = runtime.block_on(async {
            let broker = Broker::connect(settings, "strahl serve").await?;
            names::set_up(&broker, settings).await?;
            Ok(broker)
        })?;
        Ok(Some(Self { broker, runtime: runtime.clone() }))
    }
}
