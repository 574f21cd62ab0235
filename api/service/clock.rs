//! Times as the service counts them.

pub(crate) use strahl::control::milliseconds;

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Time since 1970.
pub(crate) fn unix_time() -> Duration {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default()
}

/// How long services have run on a folder. It grows by a second in each second of theirs, whatever the clock of the machine
/// says, which may be wrong by years and be put right at any moment.
#[derive(Debug)]
pub(crate) struct RunTime {
    before: Duration,
    started: Instant,
}

impl RunTime {
    /// It goes on after this number of milliseconds.
    pub(crate) fn after(before_ms: u64) -> Self {
        Self { before: Duration::from_millis(before_ms), started: Instant::now() }
    }

    /// Milliseconds.
    pub(crate) fn ms(&self) -> u64 {
        u64::try_from((self.before + self.started.elapsed()).as_millis()).unwrap_or(u64::MAX)
    }
}
