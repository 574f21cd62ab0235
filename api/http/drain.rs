//! Draining before shutdown: new work is refused, running work finishes, and probes are told.

use super::problem::{Kind, Problem};
use tokio::sync::watch;

/// Whether the service is draining, and how many requests are running.
#[derive(Debug)]
pub(crate) struct Drain {
    draining: watch::Sender<bool>,
    /// Requests have had their time.
    given_up: watch::Sender<bool>,
    requests: watch::Sender<usize>,
}

impl Default for Drain {
    fn default() -> Self {
        let [draining, given_up] = [false; 2].map(watch::Sender::new);
        Self { draining, given_up, requests: watch::Sender::new(0) }
    }
}

impl Drain {
    /// Begins to drain: from now on new work is refused.
    pub(crate) fn begin(&self) {
        self.draining.send_replace(true);
    }

    /// Whether the service is draining.
    pub(crate) fn has_begun(&self) -> bool {
        *self.draining.borrow()
    }

    /// Refuses new work while the service is draining.
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

    /// Ends requests that are still running, each with an answer that says so.
    pub(crate) fn give_up(&self) {
        self.given_up.send_replace(true);
    }

    /// The answer to a request, unless it is given up before.
    pub(crate) async fn unless_given_up<T>(&self, answer: impl Future<Output = T>) -> Result<T, Problem> {
        let mut given_up = self.given_up.subscribe();
        tokio::select! {
            biased;
            answer = answer => Ok(answer),
            _ = given_up.wait_for(|given_up| *given_up) => {
                let detail = "the service stops before this was done: send it again";
                Err(Problem::new(Kind::Draining, detail).retry_after(1))
            }
        }
    }

    /// Becomes true when draining begins.
    pub(crate) fn watch(&self) -> watch::Receiver<bool> {
        self.draining.subscribe()
    }

    /// Counts a request until the guard is dropped.
    pub(crate) fn request(&self) -> Counted {
        // Only reaching zero matters to those that wait.
        self.requests.send_if_modified(|requests| {
            *requests += 1;
            false
        });
        Counted(self.requests.clone())
    }

    /// Waits until no request is running.
    pub(crate) async fn idle(&self) {
        // It fails only without a sender, and `self` is one.
        let _ = self.requests.subscribe().wait_for(|requests| *requests == 0).await;
    }
}

fn refused() -> Problem {
    Problem::new(Kind::Draining, "the service is about to stop and takes no new work").retry_after(1)
}

/// A running request.
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
