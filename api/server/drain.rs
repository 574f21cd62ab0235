//! The end of the service: no new work, the running work finishes, probes are told.

use std::future::pending;
use tokio::signal::unix::{SignalKind, signal};
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

    /// Counts a request; dropping it counts it off.
    pub(super) fn request(&self) -> Counted {
        self.requests.send_modify(|requests| *requests += 1);
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
        self.0.send_modify(|requests| *requests -= 1);
    }
}

/// Waits for SIGTERM or SIGINT.
pub(super) async fn stop_signal() -> &'static str {
    tokio::select! {
        () = arrival(SignalKind::terminate()) => "SIGTERM",
        () = arrival(SignalKind::interrupt()) => "SIGINT",
    }
}

async fn arrival(kind: SignalKind) {
    match signal(kind) {
        Ok(mut signal) => {
            signal.recv().await;
        }
        Err(error) => {
            tracing::error!(%error, "a signal cannot be watched for");
            pending::<()>().await;
        }
    }
}
