//! Single flight: requests for the same work wait for one run of it. It is cancelled when the last of them has gone.

use crate::service::error::Error;
use parking_lot::Mutex;
use std::collections::HashMap;
use std::sync::{Arc, Weak};
use tokio::sync::watch;
use tokio::task::AbortHandle;

/// Work under way, by name.
#[derive(Debug)]
pub(crate) struct SingleFlight<T>(Mutex<HashMap<String, Weak<Flight<T>>>>);

impl<T> Default for SingleFlight<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

/// Work that requests wait for.
#[derive(Debug)]
struct Flight<T> {
    outcome: watch::Receiver<Option<Result<T, Error>>>,
    task: AbortHandle,
}

impl<T> Drop for Flight<T> {
    fn drop(&mut self) {
        // Dropping the task's future cancels what it waits for. Finished work is not affected.
        self.task.abort();
    }
}

impl<T: Clone + Send + Sync + 'static> SingleFlight<T> {
    /// The outcome of the work of a name, which is started unless it is under way.
    pub(crate) async fn share<F>(&self, name: String, work: impl FnOnce() -> F) -> Result<T, Error>
    where
        F: Future<Output = Result<T, Error>> + Send + 'static,
    {
        let flight = self.join(name, work);
        let mut outcome = flight.outcome.clone();
        let outcome = outcome.wait_for(Option::is_some).await.ok().and_then(|outcome| outcome.clone());
        // Without an outcome the task has panicked, and the log says so.
        outcome.unwrap_or_else(|| Err(Error::Internal("the work broke off; the service's log says more")))
    }

    fn join<F>(&self, name: String, work: impl FnOnce() -> F) -> Arc<Flight<T>>
    where
        F: Future<Output = Result<T, Error>> + Send + 'static,
    {
        // Nothing below panics.
        let mut flights = self.0.lock();
        if let Some(flight) = flights.get(&name).and_then(Weak::upgrade) {
            return flight;
        }
        flights.retain(|_, flight| flight.strong_count() > 0);
        let (sender, outcome) = watch::channel(None);
        let work = work();
        let task = tokio::spawn(async move {
            let outcome = work.await;
            sender.send_replace(Some(outcome));
        });
        let flight = Arc::new(Flight { outcome, task: task.abort_handle() });
        flights.insert(name, Arc::downgrade(&flight));
        flight
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::Duration;
    use tokio::sync::Notify;
    use tokio::time::{sleep, timeout};

    /// Counts itself off when it is dropped.
    struct Running(Arc<AtomicUsize>);

    impl Drop for Running {
        fn drop(&mut self) {
            self.0.fetch_sub(1, Ordering::SeqCst);
        }
    }

    #[tokio::test]
    async fn work_is_done_once_and_given_up_with_the_last_who_waits() {
        let flights = Arc::new(SingleFlight::default());
        let (started, running) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
        let go = Arc::new(Notify::new());
        let ask = || {
            let (flights, started, running, go) =
                (Arc::clone(&flights), Arc::clone(&started), Arc::clone(&running), Arc::clone(&go));
            tokio::spawn(async move {
                let work = || async move {
                    started.fetch_add(1, Ordering::SeqCst);
                    running.fetch_add(1, Ordering::SeqCst);
                    let _running = Running(running);
                    go.notified().await;
                    Ok(42)
                };
                flights.share("a".into(), work).await.ok()
            })
        };
        let [first, second] = [(); 2].map(|()| ask());
        sleep(Duration::from_millis(20)).await;
        first.abort();
        sleep(Duration::from_millis(20)).await;
        assert_eq!((started.load(Ordering::SeqCst), running.load(Ordering::SeqCst)), (1, 1));
        go.notify_one();
        assert_eq!(timeout(Duration::from_secs(5), second).await.unwrap().unwrap(), Some(42));

        let third = ask();
        sleep(Duration::from_millis(20)).await;
        assert_eq!((started.load(Ordering::SeqCst), running.load(Ordering::SeqCst)), (2, 1));
        third.abort();
        sleep(Duration::from_millis(20)).await;
        assert_eq!(running.load(Ordering::SeqCst), 0);
    }
}
