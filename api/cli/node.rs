//! `strahl node`: renders for a farm.

use super::allocator;
use super::failure::Failure;
use super::log::{LogFormat, log};
use super::values::word;
use crate::service::farm::node;
use crate::service::farm::node::settings::NodeSettings;
use crate::service::farm::settings::FarmSettings;
use clap::Args;

/// `strahl node`.
#[derive(Debug, Clone, Args)]
pub(super) struct NodeArgs {
    /// Format of the log.
    #[arg(long, env = "STRAHL_LOG_FORMAT", value_name = "FORMAT", default_value = "text", value_parser = word::<LogFormat>())]
    log_format: LogFormat,
    #[command(flatten)]
    node: NodeSettings,
    #[command(flatten)]
    farm: FarmSettings,
}

/// Renders until SIGTERM or Ctrl-C.
pub(super) fn run(args: &NodeArgs) -> Result<(), Failure> {
    allocator::settle();
    log(args.log_format)?;
    Ok(node::run(&args.node, &args.farm)?)
}
