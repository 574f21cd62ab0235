//! The log of commands that run for long.

use schemars::JsonSchema;
use serde::Deserialize;
use std::io;
use tracing::Level;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

/// Names of log formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum LogFormat {
    /// For people.
    Text,
    /// For programs: one object in each line.
    Json,
}

/// Starts the log on standard error. `STRAHL_LOG` filters it; the default is `info`.
pub(super) fn log(format: LogFormat) {
    let wanted = std::env::var("STRAHL_LOG").ok().and_then(|filter| filter.parse::<Targets>().ok());
    let filter =
        wanted.unwrap_or_else(|| Targets::new().with_default(Level::INFO).with_target("async_nats", Level::WARN));
    let lines = tracing_subscriber::fmt::layer().with_writer(io::stderr).with_ansi(false);
    let log = tracing_subscriber::registry().with(filter);
    match format {
        LogFormat::Text => log.with(lines).init(),
        LogFormat::Json => log.with(lines.json().flatten_event(true).with_current_span(false)).init(),
    }
}
