//! The end of the service: no new work, the running work finishes, probes are told.

use super::problem::{Kind, Problem};
use std::io;
use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio::sync::watch;

/// Whether the service is about to end, and how many requests it still has.
#[derive(Debug)]
pub(crate) struct Drain {
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
    pub(crate) fn begin(&self) {
        self.draining.send_replace(true);
    }

    /// Whether it has begun.
    pub(crate) fn has_begun(&self) -> bool {
        *self.draining.borrow()
    }

    /// Refuses new work once it has begun.
    pub(crate) fn accepts_work(&self) -> Result<(), Problem> {
        if self.has_begun() { Err(refused()) } else { Ok(()) }
    }

    /// The result of taking in a request, unless it begins before all of the request is there.
    pub(crate) async fn unless_begun<T>(&self, taking: impl Future<Output = Result<T, Problem>>) -> Result<T, Problem> {
        let mut draining = self.watch();
        tokio::select! {
            biased;
            taken = taking => taken,
            _ = draining.wait_for(|draining| *draining) => Err(refused()),
        }
    }

    /// Becomes true when it begins.
    pub(crate) fn watch(&self) -> watch::Receiver<bool> {
        self.draining.subscribe()
    }

    /// Counts a request; dropping it counts it off.
    pub(crate) fn request(&self) -> Counted {
        // Nobody has to hear of more requests, nor of fewer, unless there are none.
        self.requests.send_if_modified(|requests| {
            *requests += 1;
            false
        });
        Counted(self.requests.clone())
    }

    /// Waits until there are no requests.
    pub(crate) async fn idle(&self) {
        // It fails only without a sender, and `self` is one.
        let _ = self.requests.subscribe().wait_for(|requests| *requests == 0).await;
    }
}

fn refused() -> Problem {
    Problem::new(Kind::Draining, "the service is about to stop and takes no new work").retry_after(1)
}

/// A request under way.
#[derive(Debug)]
pub(crate) struct Counted(watch::Sender<usize>);

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
pub(crate) struct StopSignals {
    terminate: Signal,
    interrupt: Signal,
}

impl StopSignals {
    /// From now on the signals no longer end the process by themselves.
    pub(crate) fn watch() -> io::Result<Self> {
        Ok(Self { terminate: signal(SignalKind::terminate())?, interrupt: signal(SignalKind::interrupt())? })
    }

    /// Waits for the next one; its name.
    pub(crate) async fn next(&mut self) -> &'static str {
        tokio::select! {
            _ = self.terminate.recv() => "SIGTERM",
            _ = self.interrupt.recv() => "SIGINT",
        }
    }
}
