//! The end of the service: no new work, the running work finishes, probes are told.

use std::io;
use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio::sync::watch;

/// Whether the service is about to end, and how many requests it still has.
#[derive(Debug)]
pub(super) struct Drain {
    draining: watch::Sender<bool>,
    requests: watch::Sender<usize>,
}

impl Default for Drain {
    fn default() -> Self {
        Self { draining: watch::Sender::new(false), requests: watch::Sender::new(0) }
    }
}

impl Drain {
    /// From now on the service takes no work.
    pub(super) fn begin(&self) {
        self.draining.send_replace(true);
    }

    /// Whether it has begun.
    pub(super) fn has_begun(&self) -> bool {
        *self.draining.borrow()
    }

    /// Becomes true when it begins.
    pub(super) fn watch(&self) -> watch::Receiver<bool> {
        self.draining.subscribe()
    }

    /// Counts a request; dropping it counts it off.
    pub(super) fn request(&self) -> Counted {
        // Nobody has to hear of more requests, nor of fewer, unless there are none.
        self.requests.send_if_modified(|requests| {
            *requests += 1;
            false
        });
        Counted(self.requests.clone())
    }

    /// Waits until there are no requests.
    pub(super) async fn idle(&self) {
        // It fails only without a sender, and `self` is one.
        let _ = self.requests.subscribe().wait_for(|requests| *requests == 0).await;
    }
}

/// A request under way.
#[derive(Debug)]
pub(super) struct Counted(watch::Sender<usize>);

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.send_if_modified(|requests| {
            *requests -= 1;
            *requests == 0
        });
    }
}

/// SIGTERM and SIGINT.
#[derive(Debug)]
pub(super) struct StopSignals {
    terminate: Signal,
    interrupt: Signal,
}

impl StopSignals {
    /// From now on the signals no longer end the process by themselves.
    pub(super) fn watch() -> io::Result<Self> {
        Ok(Self { terminate: signal(SignalKind::terminate())?, interrupt: signal(SignalKind::interrupt())? })
    }

    /// Waits for the next one; its name.
    pub(super) async fn next(&mut self) -> &'static str {
        tokio::select! {
            _ = self.terminate.recv() => "SIGTERM",
            _ = self.interrupt.recv() => "SIGINT",
        }
    }
}
