//! The threads that render. There is one pool, and one piece of work has all of it at a time.

use super::fair_queue::{Scheduled, Scheduler, Slice};
use super::task::{Class, Task};
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::sync::{Arc, Mutex, PoisonError};
use strahl::render::{Cancelled, Control};

/// One rayon pool and whose turn it is.
///
/// Turns exist because a rayon thread that waits for a part of one render may take up a whole other render in the
/// meantime, and the first would then not end (nor notice that it is cancelled) before the second.
#[derive(Debug)]
pub(crate) struct Pool {
    threads: ThreadPool,
    scheduler: Scheduler,
}

/// The pool as one of those who share it sees it.
#[derive(Debug)]
pub(crate) struct Workers {
    pool: Arc<Pool>,
    scheduled: Scheduled,
    control: Arc<Control>,
    alone: bool,
    /// A turn that was waited for before there was a thread to work on.
    first: Mutex<Option<Slice>>,
}

impl Pool {
    /// Starts the threads; without a number, as many as the machine or its container gives.
    pub(crate) fn start(threads: Option<u64>) -> Result<Arc<Self>, ThreadPoolBuildError> {
        let threads = threads.map_or(0, |threads| usize::try_from(threads).unwrap_or(usize::MAX));
        let threads = ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("render-{i}")).build()?;
        Ok(Arc::new(Self { threads, scheduler: Scheduler::default() }))
    }

    /// Somebody who wants turns; waiting for them ends when `control` is cancelled.
    pub(crate) fn join(self: Arc<Self>, task: Task, control: Arc<Control>) -> Workers {
        Workers { scheduled: self.scheduler.join(task), pool: self, control, alone: false, first: Mutex::new(None) }
    }

    /// How many threads there are.
    pub(crate) fn threads(&self) -> usize {
        self.threads.current_num_threads()
    }

    /// Whether they have work.
    pub(crate) fn is_busy(&self) -> bool {
        self.scheduler.is_taken()
    }

    /// Seconds that they have spent on a kind of work.
    pub(crate) fn spent(&self, class: Class) -> f64 {
        self.scheduler.spent(class)
    }
}

impl Workers {
    /// For one who shares the pool with nobody.
    pub(crate) fn alone(pool: Arc<Pool>, control: Arc<Control>) -> Self {
        let task = Task::new(Class::Renders, "", 1);
        Self { alone: true, ..pool.join(task, control) }
    }

    /// Waits for the first turn without a thread, and keeps it for the first piece of work.
    pub(crate) async fn line_up(&self) -> Result<(), Cancelled> {
        let turn = self.scheduled.turn().await?;
        *self.first() = Some(turn);
        Ok(())
    }

    /// Does some work on the pool, when it is its turn.
    pub(crate) fn work<T: Send>(&self, work: impl FnOnce() -> T + Send) -> Result<T, Cancelled> {
        let _turn = self.turn()?;
        Ok(self.pool.threads.install(work))
    }

    /// Does pieces of work, of which each returns whether there is another, and lets others in between.
    pub(crate) fn work_on<T: Send>(&self, mut piece: impl FnMut() -> Step<T> + Send) -> Result<T, Cancelled> {
        let mut turn = self.turn()?;
        loop {
            match self.pool.threads.install(&mut piece) {
                Step::Done(value) => return Ok(value),
                Step::More => turn = self.scheduled.pass(turn, &self.control.cancelled)?,
            }
        }
    }

    fn turn(&self) -> Result<Slice, Cancelled> {
        let first = self.first().take();
        first.map_or_else(|| self.scheduled.turn_or(&self.control.cancelled), Ok)
    }

    fn first(&self) -> std::sync::MutexGuard<'_, Option<Slice>> {
        self.first.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether nobody else wants turns, ever.
    pub(crate) fn is_alone(&self) -> bool {
        self.alone
    }

    /// How many threads there are.
    pub(crate) fn threads(&self) -> usize {
        self.pool.threads()
    }
}

/// What a piece of work has come to.
#[derive(Debug)]
pub(crate) enum Step<T> {
    /// There are more.
    More,
    /// It was the last.
    Done(T),
}
