//! `strahl serve`: its flags, its log, and the service itself.

use super::allocator;
use super::failure::Failure;
use super::values::word;
use crate::http::settings::HttpSettings;
use crate::service::farm::settings::FarmSettings;
use crate::service::limits::Settings;
use crate::service::values::threads;
use clap::Args;
use schemars::JsonSchema;
use serde::Deserialize;
use std::io;
use std::path::PathBuf;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

/// `strahl serve`.
#[derive(Debug, Clone, Args)]
#[command(args_override_self = true)]
pub(super) struct ServeArgs {
    /// Configuration file: TOML with the names of these flags (max_pixels = 1000000). Flags and environment variables override
    /// it.
    #[arg(long, env = "STRAHL_CONFIG", value_name = "FILE.toml")]
    config: Option<PathBuf>,
    /// Format of the log.
    #[arg(long, env = "STRAHL_LOG_FORMAT", value_name = "FORMAT", default_value = "text", value_parser = word::<LogFormat>())]
    log_format: LogFormat,
    /// Threads to render with [default: all of the machine, or of its container].
    #[arg(long, env = "STRAHL_THREADS", value_parser = threads())]
    threads: Option<u64>,
    #[command(flatten)]
    http: HttpSettings,
    #[command(flatten)]
    service: Settings,
    #[command(flatten)]
    farm: FarmSettings,
}

/// Names of log formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum LogFormat {
    /// For people.
    Text,
    /// For programs: one object in each line.
    Json,
}

/// Serves until SIGTERM or Ctrl-C.
pub(super) fn run(args: &ServeArgs) -> Result<(), Failure> {
    allocator::settle();
    log(args.log_format);
    Ok(crate::http::run(args.threads, &args.http, &args.service, &args.farm)?)
}

/// Starts the log on standard error. `STRAHL_LOG` filters it; the default is `info`.
fn log(format: LogFormat) {
    let wanted = std::env::var("STRAHL_LOG").ok().and_then(|filter| filter.parse::<Targets>().ok());
    let filter = wanted.unwrap_or_else(|| Targets::new().with_default(tracing::Level::INFO));
    let lines = tracing_subscriber::fmt::layer().with_writer(io::stderr).with_ansi(false);
    let log = tracing_subscriber::registry().with(filter);
    match format {
        LogFormat::Text => log.with(lines).init(),
        LogFormat::Json => log.with(lines.json().flatten_event(true).with_current_span(false)).init(),
    }
}
