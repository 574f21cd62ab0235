//! `strahl serve`: its flags, its log, and the service itself.

use super::allocator;
use super::failure::Failure;
use super::log::{LogFormat, log};
use super::values::word;
use crate::http::settings::HttpSettings;
use crate::service::error::StartError;
use crate::service::farm::settings::FarmSettings;
use crate::service::limits::Settings;
use crate::service::values::threads;
use clap::Args;
use std::path::PathBuf;

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
    /// Milliseconds of predicted time above which a picture that somebody waits for is cut into tiles for the nodes of the farm
    /// [default: the service renders it itself].
    #[arg(long, env = "STRAHL_SPREAD", value_name = "MS", requires = "farm", help_heading = "Farm")]
    spread: Option<u64>,
}

/// Refuses settings that contradict each other.
pub(super) fn check(args: &ServeArgs) -> Result<(), StartError> {
    crate::http::check(&args.http, &args.service, &args.farm)
}

/// Serves until SIGTERM or Ctrl-C.
pub(super) fn run(args: &ServeArgs) -> Result<(), Failure> {
    allocator::settle();
    log(args.log_format)?;
    Ok(crate::http::run(args.threads, &args.http, &args.service, (&args.farm, args.spread))?)
}
