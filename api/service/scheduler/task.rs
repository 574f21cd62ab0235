//! Who wants turns: what kind of work it is, whose, and how important.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::Instant;

/// Priority where nobody says which.
pub(crate) const PRIORITY: u8 = 50;
/// Seconds of waiting that are worth a point of priority.
const SECONDS_A_POINT: f64 = 6.0;

/// What kind of work it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Class {
    /// Parts of pictures that somebody looks at; the newest first, since who looks has moved on from the older ones.
    Tiles,
    /// Requests that somebody waits for; the oldest first.
    Renders,
    /// Jobs; the oldest first.
    Jobs,
}

impl Class {
    /// Its name for those who look at numbers.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Tiles => "tiles",
            Self::Renders => "renders",
            Self::Jobs => "jobs",
        }
    }
}

/// Who wants turns.
#[derive(Debug, Clone)]
pub(crate) struct Task {
    /// The kind of work.
    pub(crate) class: Class,
    /// Whose work it is.
    pub(crate) tenant: Arc<str>,
    /// The tenant's share beside others, at least 1.
    pub(crate) weight: u32,
    /// 0 to 100; compared with others of the same tenant only. It may change meanwhile.
    pub(crate) priority: Arc<AtomicU8>,
    /// Since when it waits for its end: jobs that are older than others grow in priority.
    pub(crate) waiting_since: Instant,
}

impl Task {
    /// A seat from now on, of the usual priority.
    pub(crate) fn new(class: Class, tenant: &str, weight: u32) -> Self {
        let priority = Arc::new(AtomicU8::new(PRIORITY));
        Self { class, tenant: tenant.into(), weight, priority, waiting_since: Instant::now() }
    }

    /// Its priority now.
    pub(crate) fn priority(&self) -> u8 {
        self.priority.load(Ordering::Relaxed)
    }
}

/// A priority that has grown from some instant until `now`. What is compared needs the same `now`: with the clock read once more the
/// second seems older.
pub(crate) fn aged(priority: u8, since: Instant, now: Instant) -> f64 {
    f64::from(priority) + now.saturating_duration_since(since).as_secs_f64() / SECONDS_A_POINT
}
