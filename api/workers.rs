//! The threads that render. There is one pool, and one piece of work has all of it at a time.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::sync::{Mutex, PoisonError};

/// One rayon pool and whose turn it is.
///
/// Turns exist because a rayon thread that waits for a part of one render may take up a whole other render in the
/// meantime, and the first would then not end (nor notice that it is cancelled) before the second.
#[derive(Debug)]
pub(crate) struct Workers {
    pool: ThreadPool,
    turn: Mutex<()>,
}

impl Workers {
    /// Starts the threads; without a number, as many as the machine or its container gives.
    pub(crate) fn start(threads: Option<u64>) -> Result<Self, ThreadPoolBuildError> {
        let threads = threads.map_or(0, |threads| usize::try_from(threads).unwrap_or(usize::MAX));
        let pool = ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("render-{i}")).build()?;
        Ok(Self { pool, turn: Mutex::new(()) })
    }

    /// Does some work on the pool, when it is its turn.
    pub(crate) fn work<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        // A panic while working leaves nothing half-done behind the lock.
        let _turn = self.turn.lock().unwrap_or_else(PoisonError::into_inner);
        self.pool.install(work)
    }

    /// How many threads there are.
    pub(crate) fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }
}
