//! The events of a job, numbered: the last thousand, and a channel that signals new ones.

use serde_json::Value;
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};
use tokio::sync::watch;

/// Events that are kept for clients that reconnect.
const KEPT: usize = 1_024;
/// Event numbers for each restart, so that numbers grow over restarts, too.
const PER_LIFE: u64 = 1_000_000_000;

/// An event.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Event {
    /// Its number. Later events have greater ones.
    pub(crate) seq: u64,
    /// Its kind.
    pub(crate) name: &'static str,
    /// Its contents.
    pub(crate) data: Value,
}

/// The events of a job.
#[derive(Debug)]
pub(crate) struct Events {
    kept: Mutex<Kept>,
    last: watch::Sender<u64>,
}

#[derive(Debug)]
struct Kept {
    events: VecDeque<Event>,
    /// Number of the last event that is not kept any more.
    before: u64,
    last: u64,
}

impl Events {
    /// No events yet since the last restart.
    pub(super) fn new(life: u64) -> Self {
        let before = life * PER_LIFE;
        let kept = Kept { events: VecDeque::new(), before, last: before };
        Self { kept: Mutex::new(kept), last: watch::Sender::new(before) }
    }

    /// Publishes an event and returns its number.
    pub(super) fn publish(&self, name: &'static str, data: Value) -> u64 {
        let mut kept = self.kept();
        kept.last += 1;
        let seq = kept.last;
        kept.events.push_back(Event { seq, name, data });
        if kept.events.len() > KEPT
            && let Some(gone) = kept.events.pop_front()
        {
            kept.before = gone.seq;
        }
        drop(kept);
        self.last.send_replace(seq);
        seq
    }

    /// Forgets the events of a job that has ended. A client that comes back gets a snapshot and how it ended.
    pub(super) fn forget(&self) {
        let mut kept = self.kept();
        kept.events = VecDeque::new();
        kept.before = kept.last;
    }

    /// All events after a number. None if some of them are not kept any more, or no event has had the number.
    pub(crate) fn since(&self, seq: u64) -> Option<Vec<Event>> {
        let kept = self.kept();
        (kept.before..=kept.last)
            .contains(&seq)
            .then(|| kept.events.iter().filter(|event| event.seq > seq).cloned().collect())
    }

    /// Number of the last event.
    pub(crate) fn last(&self) -> u64 {
        self.kept().last
    }

    /// A channel that changes with each event.
    pub(crate) fn bell(&self) -> watch::Receiver<u64> {
        self.last.subscribe()
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn who_comes_back_hears_what_was_missed_and_who_comes_too_late_starts_again() {
        let events = Events::new(2);
        let first = events.publish("started", json!({}));
        let second = events.publish("progress", json!({}));
        assert!(second > first && first > 2 * PER_LIFE);
        assert_eq!(events.since(first).map(|events| events.len()), Some(1));
        assert_eq!(events.since(second), Some(Vec::new()));
        assert_eq!(events.since(5), None, "an earlier life's number");
        assert_eq!(events.since(second + 1), None, "a number that was never given");
        for _ in 0..KEPT {
            events.publish("tile", json!({}));
        }
        assert_eq!(events.since(first), None);
        assert_eq!(events.since(second).map(|events| events.len()), Some(KEPT));
    }
}
