//! Settings of a node.

use crate::service::values::seconds;
use crate::service::{memory, memory_budget};
use clap::{Args, value_parser};
use std::thread;
use std::time::Duration;

/// What a node takes of its machine.
#[derive(Debug, Clone, Args)]
#[group(skip)]
#[command(next_help_heading = "Node")]
pub(crate) struct NodeSettings {
    /// Pieces of work that are rendered at one time, on a thread each [default: the processors of the machine, or of its
    /// container].
    #[arg(long, env = "STRAHL_NODE_SLOTS", value_name = "PIECES", value_parser = value_parser!(u32).range(1..=1_024))]
    pub(crate) slots: Option<u32>,
    /// What people call the node [default: the name of the machine].
    #[arg(long, env = "STRAHL_NODE_NAME", value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// Bytes of memory that scenes and pictures may take [default: three quarters of what the machine, or its container, has].
    #[arg(long, env = "STRAHL_MEMORY_BYTES", value_name = "BYTES", default_value_t = (memory::available() / 4 * 3).max(memory_budget::LEAST), hide_default_value = true, value_parser = value_parser!(u64).range(memory_budget::LEAST..))]
    pub(crate) memory_bytes: u64,
    /// Bytes of built scenes that are kept in memory for the next job.
    #[arg(long, env = "STRAHL_SCENE_CACHE_BYTES", value_name = "BYTES", default_value_t = 2 << 30)]
    pub(crate) scene_cache_bytes: u64,
    /// Seconds to finish pieces after SIGTERM or Ctrl-C; then they are given back.
    #[arg(long, env = "STRAHL_DRAIN_TIMEOUT", value_name = "SECONDS", default_value = "20", value_parser = seconds)]
    pub(crate) drain_timeout: Duration,
}

impl NodeSettings {
    pub(super) fn slots(&self) -> u32 {
        let processors = || thread::available_parallelism().map_or(1, |processors| processors.get() as u32);
        self.slots.unwrap_or_else(processors)
    }

    pub(super) fn name(&self) -> String {
        let machine = || std::fs::read_to_string("/proc/sys/kernel/hostname").ok().map(|name| name.trim().to_owned());
        self.name.clone().or_else(machine).unwrap_or_else(|| "node".into())
    }
}
