//! Admission: the bounded queue before the renderer, the only way from a request to the pool.
//!
//! A request that finds the queue full is refused at once. One that waits or works too long is given up. One whose client
//! goes away stops: its future is dropped, and with it the guard that cancels the work. Its place is free again only when
//! the work has really ended.

use super::pool::{Pool, Workers};
use super::task::Task;
use crate::service::clock::milliseconds;
use crate::service::concurrency_limit::{ConcurrencyLimit, Permit};
use crate::service::error::{Error, panic_text};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};
use strahl::control::Control;
use tokio::sync::oneshot;
use tokio::time::timeout_at;

/// Requests under way beside those that wait: one renders while another encodes its picture.
const UNDER_WAY: usize = 2;
/// A tenant with fewer requests is let in even if those of others fill the queue.
const GUARANTEED: u32 = 2;

/// The queue.
#[derive(Debug)]
pub(crate) struct Queue {
    pool: Arc<Pool>,
    /// Requests of each tenant that wait or are under way.
    places: ConcurrencyLimit<Arc<str>>,
    /// Requests that have had a time slice.
    running: Arc<AtomicUsize>,
    /// Microseconds of work on requests that were cancelled.
    canceled: Arc<AtomicU64>,
    size: usize,
    patience: Duration,
    pace: Pace,
}

/// What a request works with, once it is its turn.
#[derive(Debug)]
pub(crate) struct Work {
    /// The threads that render.
    pub(crate) workers: Workers,
    /// Tells the work to stop.
    pub(crate) control: Control,
    /// When it was queued.
    pub(crate) queued: Instant,
    /// When it began.
    pub(crate) started: Instant,
    /// What makes it expensive, once that is known, in words for a client whose request takes too long.
    pub(crate) expensive: Arc<OnceLock<String>>,
}

/// What a request has made.
#[derive(Debug)]
pub(crate) struct Done<T> {
    /// The result.
    pub(crate) value: T,
    /// Milliseconds it waited before.
    pub(crate) queue_ms: f64,
}

impl Queue {
    /// `waiting`: how many requests may wait. `patience`: time limit of each, waiting included.
    pub(crate) fn new(pool: Arc<Pool>, waiting: u32, patience: Duration) -> Self {
        let size = waiting as usize + UNDER_WAY;
        Self {
            pool,
            places: ConcurrencyLimit::default(),
            running: Arc::default(),
            canceled: Arc::default(),
            size,
            patience,
            pace: Pace::default(),
        }
    }

    /// Queues work and waits for it. It runs on a thread of its own, never on one of tokio's workers.
    pub(crate) async fn run<T: Send + 'static, E: From<Error> + Send + 'static>(
        &self,
        task: Task,
        work: impl FnOnce(&Work) -> Result<T, E> + Send + 'static,
    ) -> Result<Done<T>, E> {
        let (sender, receiver) = oneshot::channel();
        let queue_ms = self.wait_for(task, Box::new(|context| drop(sender.send(work(context))))).await?;
        let value = receiver.await.map_err(|_| Error::Internal("the work has ended without a result"))?;
        Ok(Done { value: value?, queue_ms })
    }

    /// The same for work of any kind, whose result goes another way: it is compiled once for all of them. Returns the milliseconds
    /// that it waited.
    async fn wait_for(&self, task: Task, work: Box<dyn FnOnce(&Work) + Send>) -> Result<f64, Error> {
        let queued = Instant::now();
        let deadline = (queued + self.patience).into();
        let may = |own: u32, all: &dyn Fn() -> u64| own < GUARANTEED || all() < self.size as u64;
        let place = self.places.enter_if(Arc::clone(&task.tenant), may).ok_or_else(|| self.full())?;
        let control = Control::default();
        let _guard = CancelOnDrop(control.clone());
        let workers = Arc::clone(&self.pool).join(task, control.clone());
        let first_slice = timeout_at(deadline, workers.wait()).await;
        first_slice.ok().and_then(Result::ok).ok_or_else(|| self.waited())?;
        let queue_ms = milliseconds(queued);

        let running = Running::new(place, &self.running);
        let (watched, expensive) = (control.clone(), Arc::new(OnceLock::new()));
        let context = Work { workers, control, queued, started: Instant::now(), expensive: Arc::clone(&expensive) };
        let canceled = Arc::clone(&self.canceled);
        let work = tokio::task::spawn_blocking(move || {
            let entered = context.control.enter();
            work(&context);
            drop(entered);
            if context.control.is_cancelled() {
                canceled.fetch_add(microseconds(context.started.elapsed()), Ordering::Relaxed);
            }
            let had = context.workers.had();
            drop((context, running));
            had
        });
        match timeout_at(deadline, work).await {
            Ok(Ok(had)) => {
                self.pace.record(had);
                Ok(queue_ms)
            }
            Ok(Err(panic)) => {
                let text =
                    panic.try_into_panic().map_or_else(|_| "it was aborted".into(), |payload| panic_text(&*payload));
                tracing::error!(panic = text, "a request panicked");
                Err(Error::Internal("the render failed; the service goes on, and its log says more"))
            }
            Err(_) => {
                let seconds = self.patience.as_secs_f64();
                let mut detail = format!("the answer was not ready after {seconds} s (timeout)");
                // Pixels that were begun do not tell how much is left: refining them takes most of the time.
                if watched.rays() > 0 {
                    detail.push_str(&format!(", when {} rays were traced", watched.rays()));
                }
                if let Some(expensive) = expensive.get() {
                    detail.push_str(&format!("; {expensive}"));
                }
                Err(Error::Deadline(detail))
            }
        }
    }

    /// Requests under way.
    pub(crate) fn running(&self) -> usize {
        self.running.load(Ordering::Relaxed)
    }

    /// Requests that wait.
    pub(crate) fn waiting(&self) -> usize {
        self.taken().saturating_sub(self.running())
    }

    /// Time spent on requests that were cancelled.
    pub(crate) fn canceled(&self) -> Duration {
        Duration::from_micros(self.canceled.load(Ordering::Relaxed))
    }

    /// Seconds until what waits now should be done.
    pub(crate) fn retry_after(&self) -> u32 {
        self.pace.seconds_for(self.taken())
    }

    fn taken(&self) -> usize {
        self.places.taken() as usize
    }

    fn waited(&self) -> Error {
        let detail = format!("the renderer was busy for {} s (timeout)", self.patience.as_secs_f64());
        Error::Busy { detail, retry_after: self.retry_after() }
    }

    fn full(&self) -> Error {
        let detail = format!("{} requests are waiting already (queue)", self.waiting());
        Error::Busy { detail, retry_after: self.retry_after() }
    }
}

/// What a request under way occupies, given back however it ends.
#[derive(Debug)]
struct Running {
    _place: Permit<Arc<str>>,
    running: Arc<AtomicUsize>,
}

impl Running {
    fn new(place: Permit<Arc<str>>, running: &Arc<AtomicUsize>) -> Self {
        running.fetch_add(1, Ordering::Relaxed);
        Self { _place: place, running: Arc::clone(running) }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.running.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Cancels work when its request is dropped.
#[derive(Debug)]
struct CancelOnDrop(Control);

impl Drop for CancelOnDrop {
    fn drop(&mut self) {
        self.0.cancel();
    }
}

/// How long requests have the pool lately: an exponential moving average in microseconds. The time from their beginning to their end
/// has that of all who take turns with them, and would count it once for each.
#[derive(Debug, Default)]
struct Pace(AtomicU64);

impl Pace {
    fn record(&self, had: Duration) {
        let had = microseconds(had);
        // Of two requests that end at once one may be lost; an average can bear that.
        let average = self.0.load(Ordering::Relaxed);
        self.0.store((average * 7 + had) / 8, Ordering::Relaxed);
    }

    /// Whole seconds until this number of requests is done, 1 to 120.
    fn seconds_for(&self, requests: usize) -> u32 {
        let micros = self.0.load(Ordering::Relaxed).saturating_mul(requests as u64);
        u32::try_from(micros.div_ceil(1_000_000)).unwrap_or(u32::MAX).clamp(1, 120)
    }
}

fn microseconds(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX / 8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::scheduler::task::Class;
    use std::thread::sleep;

    fn queue(waiting: u32, patience_ms: u64) -> Arc<Queue> {
        Arc::new(Queue::new(Pool::start(Some(2), None).unwrap(), waiting, Duration::from_millis(patience_ms)))
    }

    fn task() -> Task {
        Task::new(Class::Renders, "somebody", 1)
    }

    /// A job that runs until it is cancelled.
    fn endless(job: &Work) -> Result<(), Error> {
        let wait = || {
            while !job.control.is_cancelled() {
                sleep(Duration::from_millis(1));
            }
        };
        job.workers.work(wait).map_err(Error::from)
    }

    fn panicking(job: &Work) -> Result<(), Error> {
        Ok(job.workers.work(|| panic!("the kernel broke"))?)
    }

    async fn until(mut condition: impl FnMut() -> bool) {
        let started = Instant::now();
        while !condition() {
            assert!(started.elapsed() < Duration::from_secs(60), "it does not come to pass");
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    }

    #[tokio::test]
    async fn a_panic_fails_its_request_and_the_next_one_runs() {
        let queue = queue(0, 60_000);
        for _ in 0..5 {
            let bad = queue.run(task(), panicking).await;
            assert!(matches!(bad, Err(Error::Internal(_))));
        }
        let good = queue.run(task(), |work| work.workers.work(|| 42).map_err(Error::from)).await;
        assert_eq!(good.unwrap().value, 42);
        assert_eq!((queue.running(), queue.waiting()), (0, 0));
    }

    #[tokio::test]
    async fn a_full_queue_refuses_at_once() {
        let queue = queue(1, 600_000);
        let busy: Vec<_> = (0..=UNDER_WAY)
            .map(|_| {
                let queue = Arc::clone(&queue);
                tokio::spawn(async move { queue.run(task(), endless).await.map(|done| done.value) })
            })
            .collect();
        // How many have had a time slice depends on the machine.
        let all = || queue.running() + queue.waiting();
        until(|| queue.running() > 0 && all() == 1 + UNDER_WAY).await;
        assert!(matches!(queue.run(task(), endless).await, Err(Error::Busy { .. })));
        assert_eq!(all(), 1 + UNDER_WAY, "it has waited for others");
        // Another tenant's few requests have room all the same.
        let other = queue.run(Task::new(Class::Renders, "somebody else", 1), |_| Ok::<_, Error>(42)).await;
        assert_eq!(other.unwrap().value, 42);
        busy.iter().for_each(tokio::task::JoinHandle::abort);
        until(|| (queue.running(), queue.waiting()) == (0, 0)).await;
    }

    #[tokio::test]
    async fn a_client_that_goes_away_stops_its_job() {
        let queue = queue(0, 600_000);
        let request = {
            let queue = Arc::clone(&queue);
            tokio::spawn(async move { queue.run(task(), endless).await.map(|done| done.value) })
        };
        until(|| queue.running() == 1).await;
        request.abort();
        until(|| queue.running() == 0).await;
    }

    #[tokio::test]
    async fn a_job_past_its_deadline_is_given_up() {
        // It has begun long before.
        let queue = queue(0, 3_000);
        assert!(matches!(queue.run(task(), endless).await, Err(Error::Deadline(_))));
        until(|| queue.running() == 0).await;
    }

    #[test]
    fn waiting_times_follow_the_pace() {
        let pace = Pace::default();
        assert_eq!(pace.seconds_for(30), 1);
        for _ in 0..100 {
            pace.record(Duration::from_secs(2));
        }
        assert!((3..=4).contains(&pace.seconds_for(2)), "{}", pace.seconds_for(2));
        assert_eq!(pace.seconds_for(10_000), 120);
    }
}
