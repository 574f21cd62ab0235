//! What an answer has cost. Handlers put it into their response's extensions, from where it is counted.

use crate::service::pictures::cache::Took;
use std::time::Duration;
use strahl::film::FileFormat;

/// Cost of a picture.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Cost {
    /// Rays of all kinds.
    pub(crate) rays: u64,
    /// Time in the queue.
    pub(crate) queue: Duration,
    /// Time without waiting.
    pub(crate) render: Duration,
    /// Part of that for encoding the picture.
    pub(crate) encode: Duration,
    /// The picture's format by name.
    pub(crate) format: &'static str,
}

impl Cost {
    /// Cost of a picture for the request that rendered it. None if it was cached, or another request rendered it.
    pub(crate) fn of(took: &Took, format: FileFormat) -> Option<Self> {
        let (phases, rays) = took.render.filter(|_| !took.is_shared)?;
        let duration = |ms: f64| Duration::try_from_secs_f64(ms / 1e3).unwrap_or_default();
        Some(Self {
            rays,
            queue: duration(took.queue_ms),
            render: duration(phases.list().iter().map(|(_, ms)| ms).sum()),
            encode: duration(phases.png),
            format: format.names().0,
        })
    }
}
