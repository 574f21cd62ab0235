//! The log of commands that run for long.

use super::environment;
use super::failure::Failure;
use schemars::JsonSchema;
use serde::Deserialize;
use std::io;
use tracing::Level;
use tracing_subscriber::filter::{LevelFilter, Targets};
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

/// Starts the log on standard error, with what is likely misspelt in the environment. `STRAHL_LOG` filters it; the default is `info`.
pub(super) fn log(format: LogFormat) -> Result<(), Failure> {
    let filter = match std::env::var("STRAHL_LOG") {
        Ok(text) if !text.trim().is_empty() => filter_of(&text)?,
        _ => Targets::new().with_default(Level::INFO).with_target("async_nats", Level::WARN),
    };
    let lines = tracing_subscriber::fmt::layer().with_writer(io::stderr).with_ansi(false);
    let log = tracing_subscriber::registry().with(filter);
    match format {
        LogFormat::Text => log.with(lines).init(),
        LogFormat::Json => log.with(lines.json().flatten_event(true).with_current_span(false)).init(),
    }
    environment::warn_of_misspelt();
    Ok(())
}

/// A level, or levels of targets. A word that is no level would be a target, and silence all others.
fn filter_of(text: &str) -> Result<Targets, Failure> {
    let is_known = |part: &str| part.contains('=') || part.trim().parse::<LevelFilter>().is_ok();
    let filter = text.parse::<Targets>().ok().filter(|_| text.split(',').all(is_known));
    filter.ok_or_else(|| {
        let ways =
            "a level (off, error, warn, info, debug, trace), or levels of targets, such as info,async_nats=debug";
        Failure::Usage(format!("STRAHL_LOG={text} is no filter: it is {ways}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_are_levels() {
        for text in ["info", "DEBUG", "warn,strahl::http=debug", "off", "strahl=trace"] {
            assert!(filter_of(text).is_ok(), "{text}");
        }
        for text in ["foo", "info,foo", "debgu", "strahl=loud"] {
            assert!(filter_of(text).is_err(), "{text}");
        }
    }
}
