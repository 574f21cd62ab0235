//! What an answer has cost. Handlers put it into their response's extensions; quotas are charged and numbers counted
//! from there.

use crate::service::pictures::report::Report;
use std::time::Duration;
use strahl::film::FileFormat;

/// What a picture took.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Cost {
    /// Rays of all kinds.
    pub(crate) rays: u64,
    /// How long it waited before its turn.
    pub(crate) queue: Duration,
    /// How long it took, without waiting.
    pub(crate) render: Duration,
    /// How much of that was writing the picture.
    pub(crate) encode: Duration,
    /// The picture's format by name.
    pub(crate) format: &'static str,
}

impl Cost {
    /// From the report, and the milliseconds in the queue.
    pub(crate) fn of(report: &Report, queue_ms: f64, format: FileFormat) -> Self {
        let phases = report.cost.phases_ms.list();
        let worked: f64 = phases.iter().map(|(_, ms)| ms).sum();
        let encode = phases.last().map_or(0.0, |(_, ms)| *ms);
        let duration = |ms: f64| Duration::try_from_secs_f64(ms / 1e3).unwrap_or_default();
        Self {
            rays: report.cost.rays.total(),
            // What no phase accounts for was spent waiting for a turn on the pool.
            queue: duration(queue_ms + (report.cost.wall_ms - worked).max(0.0)),
            render: duration(worked),
            encode: duration(encode),
            format: format.names().0,
        }
    }
}
