//! The events of a job, numbered: the last thousand, and a channel that signals new ones.

use parking_lot::{Mutex, MutexGuard};
use serde_json::Value;
use std::collections::VecDeque;
use std::fmt;
use std::sync::Arc;
use tokio::sync::watch;

/// Events that are kept for clients that reconnect.
const KEPT: usize = 1_024;
/// Event numbers for each life, so that numbers grow over restarts, too.
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

/// Where the events of jobs go besides those who watch them here.
pub(super) trait EventPublisher: fmt::Debug + Send + Sync {
    /// Tells an event of a job.
    fn tell(&self, job: &str, event: &Event);
}

/// The events of a job.
#[derive(Debug)]
pub(crate) struct Events {
    kept: Mutex<Kept>,
    last: watch::Sender<u64>,
    /// Who tells others of them, and by which id.
    publisher: Option<(Arc<dyn EventPublisher>, String)>,
}

/// The number before the first event of a life.
pub(super) fn before_life(life: u64) -> u64 {
    life * PER_LIFE
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
    pub(super) fn new(life: u64, publisher: Option<(Arc<dyn EventPublisher>, String)>) -> Self {
        let before = before_life(life);
        let kept = Kept { events: VecDeque::new(), before, last: before };
        Self { kept: Mutex::new(kept), last: watch::Sender::new(before), publisher }
    }

    /// Publishes an event and returns its number.
    pub(super) fn publish(&self, name: &'static str, data: Value) -> u64 {
        let kept = self.kept();
        let event = Event { seq: kept.last + 1, name, data };
        if let Some((publisher, job)) = &self.publisher {
            // In the order of the numbers: under the lock.
            publisher.tell(job, &event);
        }
        self.keep(kept, event)
    }

    /// Publishes an event to those who watch here, and to nobody else.
    pub(super) fn publish_here(&self, name: &'static str, data: Value) {
        let kept = self.kept();
        let event = Event { seq: kept.last + 1, name, data };
        self.keep(kept, event);
    }

    /// Takes in an event that was published elsewhere. One that is there is not taken in again, and one that does not follow
    /// the last is the first to be kept.
    pub(super) fn hear(&self, event: Event) {
        let mut kept = self.kept();
        if event.seq > kept.last {
            if event.seq > kept.last + 1 {
                kept.events.clear();
                kept.before = event.seq - 1;
            }
            self.keep(kept, event);
        }
    }

    /// The job begins another life. Who has heard of one before gets a snapshot.
    pub(super) fn begin(&self, life: u64) {
        let mut kept = self.kept();
        let before = before_life(life);
        if kept.last < before {
            kept.events.clear();
            (kept.before, kept.last) = (before, before);
            drop(kept);
            self.ring();
        }
    }

    /// Lets those who watch look at the job.
    pub(super) fn ring(&self) {
        let last = self.last();
        self.last.send_replace(last);
    }

    fn keep(&self, mut kept: MutexGuard<'_, Kept>, event: Event) -> u64 {
        let seq = event.seq;
        kept.last = seq;
        kept.events.push_back(event);
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

    /// Whether an event that was seen may have been published by another front, and not be heard of here yet.
    pub(crate) fn may_lack(&self, seq: u64) -> bool {
        self.publisher.is_some() && seq > self.last()
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
        self.kept.lock()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn who_comes_back_hears_what_was_missed_and_who_comes_too_late_starts_again() {
        let events = Events::new(2, None);
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
    #[test]
    fn what_was_heard_of_is_as_good_as_what_was_published() {
        let (here, there) = (Events::new(1, None), Events::new(1, None));
        let event = |seq, name| Event { seq: before_life(1) + seq, name, data: json!({}) };
        there.hear(event(1, "started"));
        there.hear(event(2, "tile"));
        there.hear(event(1, "started"));
        here.publish("started", json!({}));
        here.publish("tile", json!({}));
        assert_eq!(there.since(before_life(1)), here.since(before_life(1)));
        // Events that were lost on their way are nobody's next ones.
        there.hear(event(5, "tile"));
        assert_eq!((there.since(before_life(1) + 2), there.last()), (None, before_life(1) + 5));
        assert_eq!(there.since(before_life(1) + 4).map(|events| events.len()), Some(1));
        there.begin(2);
        there.hear(event(6, "tile"));
        assert_eq!((there.since(before_life(1) + 5), there.last()), (None, before_life(2)), "an earlier life is over");
    }
}
