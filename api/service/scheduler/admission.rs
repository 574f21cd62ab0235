//! The bounded queue before the renderer, the only way from a request to the pool.
//!
//! A request that finds no place is refused at once, one that waits or works too long is given up, and one whose
//! client goes away stops: its future is dropped, and with it the guard that cancels the job. A place is free again
//! only when the job has really ended.

use super::pool::{Pool, Workers};
use super::task::{Class, Task};
use crate::http::auth::tenant::Tenant;
use crate::http::problem::{Kind, Problem};
use crate::service::pictures::render::milliseconds;
use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use strahl::render::Control;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::timeout_at;

/// Requests under way beside those that wait: one renders while another encodes its picture.
const UNDER_WAY: usize = 2;

/// The queue.
#[derive(Debug)]
pub(crate) struct Queue {
    pool: Arc<Pool>,
    /// Places for jobs that wait and jobs under way.
    places: Arc<Semaphore>,
    /// Jobs that have had a turn.
    running: Arc<AtomicUsize>,
    /// Microseconds of work that nobody got.
    canceled: Arc<AtomicU64>,
    size: usize,
    patience: Duration,
    pace: Pace,
}

/// What a job works with.
#[derive(Debug)]
pub(crate) struct Work {
    /// The threads that render.
    pub(crate) workers: Workers,
    /// Tells the job to stop.
    pub(crate) control: Arc<Control>,
    /// When it was asked for.
    pub(crate) asked: Instant,
    /// When work began.
    pub(crate) started: Instant,
}

/// A tenant's seat for what it waits for.
pub(crate) fn task_of(tenant: &Tenant, class: Class) -> Task {
    Task::new(class, &tenant.name, tenant.weight)
}

/// What a job has made.
#[derive(Debug)]
pub(crate) struct Done<T> {
    /// The result.
    pub(crate) value: T,
    /// Milliseconds it waited before.
    pub(crate) queue_ms: f64,
}

impl Queue {
    /// A queue for so many waiting jobs, each of which may take so long until it is done.
    pub(crate) fn new(pool: Arc<Pool>, waiting: u32, patience: Duration) -> Self {
        let size = waiting as usize + UNDER_WAY;
        Self {
            pool,
            places: Arc::new(Semaphore::new(size)),
            running: Arc::default(),
            canceled: Arc::default(),
            size,
            patience,
            pace: Pace::default(),
        }
    }

    /// Queues a job and waits for it. The job runs on a thread of its own, never on one of tokio's workers.
    pub(crate) async fn run<T: Send + 'static>(
        &self,
        task: Task,
        job: impl FnOnce(&Work) -> Result<T, Problem> + Send + 'static,
    ) -> Result<Done<T>, Problem> {
        let queued = Instant::now();
        let deadline = (queued + self.patience).into();
        let place = Arc::clone(&self.places).try_acquire_owned().map_err(|_| self.saturated())?;
        let control = Arc::new(Control::default());
        let _guard = CancelOnDrop(Arc::clone(&control));
        let workers = Arc::clone(&self.pool).join(task, Arc::clone(&control));
        let turn = timeout_at(deadline, workers.line_up()).await;
        turn.ok().and_then(Result::ok).ok_or_else(|| self.waited())?;
        let queue_ms = milliseconds(queued);

        let held = Running::new(place, &self.running);
        let job_side = Work { workers, control, asked: queued, started: Instant::now() };
        let canceled = Arc::clone(&self.canceled);
        let work = tokio::task::spawn_blocking(move || {
            let value = job(&job_side);
            let took = job_side.started.elapsed();
            if job_side.control.cancelled.load(Ordering::Relaxed) {
                canceled.fetch_add(microseconds(took), Ordering::Relaxed);
            }
            drop((job_side, held));
            (value, took)
        });
        match timeout_at(deadline, work).await {
            Ok(Ok((value, took))) => {
                self.pace.record(took);
                Ok(Done { value: value?, queue_ms })
            }
            Ok(Err(panic)) => {
                let what =
                    panic.try_into_panic().map_or_else(|_| "it was aborted".into(), |payload| message(&*payload));
                tracing::error!(panic = what, "a job panicked");
                Err(Problem::new(Kind::Internal, "the render failed; the service goes on, and its log says more"))
            }
            Err(_) => {
                let seconds = self.patience.as_secs_f64();
                let detail = format!("the answer was not ready after {seconds} s (timeout)");
                Err(Problem::new(Kind::RenderDeadline, detail).with("suggest", "tiles".into()))
            }
        }
    }

    /// Jobs under way.
    pub(crate) fn running(&self) -> usize {
        self.running.load(Ordering::Relaxed)
    }

    /// Jobs that wait.
    pub(crate) fn waiting(&self) -> usize {
        (self.size - self.places.available_permits()).saturating_sub(self.running())
    }

    /// Time spent on jobs that were cancelled.
    pub(crate) fn canceled(&self) -> Duration {
        Duration::from_micros(self.canceled.load(Ordering::Relaxed))
    }

    /// When a place should be free.
    pub(crate) fn retry_after(&self) -> u32 {
        self.pace.seconds_for(self.size - self.places.available_permits())
    }

    fn waited(&self) -> Problem {
        let detail = format!("the renderer was busy for {} s (timeout)", self.patience.as_secs_f64());
        Problem::new(Kind::Saturated, detail).retry_after(self.retry_after())
    }

    fn saturated(&self) -> Problem {
        let detail = format!("{} requests are waiting already (queue)", self.waiting());
        Problem::new(Kind::Saturated, detail).retry_after(self.retry_after())
    }
}

/// What a job under way occupies, given back however it ends.
#[derive(Debug)]
struct Running {
    _place: OwnedSemaphorePermit,
    running: Arc<AtomicUsize>,
}

impl Running {
    fn new(place: OwnedSemaphorePermit, running: &Arc<AtomicUsize>) -> Self {
        running.fetch_add(1, Ordering::Relaxed);
        Self { _place: place, running: Arc::clone(running) }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.running.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Cancels a job when nobody waits for it any more.
#[derive(Debug)]
struct CancelOnDrop(Arc<Control>);

impl Drop for CancelOnDrop {
    fn drop(&mut self) {
        self.0.cancelled.store(true, Ordering::Relaxed);
    }
}

/// How long jobs take lately: an exponential moving average in microseconds.
#[derive(Debug, Default)]
struct Pace(AtomicU64);

impl Pace {
    fn record(&self, took: Duration) {
        let took = microseconds(took);
        // Two jobs that end at once may lose one of the two; an average can bear that.
        let average = self.0.load(Ordering::Relaxed);
        self.0.store((average * 7 + took) / 8, Ordering::Relaxed);
    }

    /// Whole seconds until so many jobs are done, 1 to 120.
    fn seconds_for(&self, jobs: usize) -> u32 {
        let micros = self.0.load(Ordering::Relaxed).saturating_mul(jobs as u64);
        u32::try_from(micros.div_ceil(1_000_000)).unwrap_or(u32::MAX).clamp(1, 120)
    }
}

fn microseconds(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX / 8)
}

/// The text of a panic, for the log only.
fn message(payload: &(dyn Any + Send)) -> String {
    payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "no message".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::StatusCode;
    use axum::response::IntoResponse;
    use std::thread::sleep;

    fn queue(waiting: u32, patience_ms: u64) -> Arc<Queue> {
        Arc::new(Queue::new(Pool::start(Some(2)).unwrap(), waiting, Duration::from_millis(patience_ms)))
    }

    fn status<T>(result: Result<Done<T>, Problem>) -> Option<StatusCode> {
        result.err().map(|problem| problem.into_response().status())
    }

    /// A job that runs until it is cancelled.
    fn endless(job: &Work) -> Result<(), Problem> {
        let wait = || {
            while !job.control.cancelled.load(Ordering::Relaxed) {
                sleep(Duration::from_millis(1));
            }
        };
        job.workers.work(wait).map_err(|_| gone())
    }

    fn gone() -> Problem {
        Problem::new(Kind::Internal, "nobody waits any more")
    }

    fn panicking(job: &Work) -> Result<(), Problem> {
        job.workers.work(|| panic!("the kernel broke")).map_err(|_| gone())
    }

    async fn until(mut condition: impl FnMut() -> bool) {
        let started = Instant::now();
        while !condition() {
            assert!(started.elapsed() < Duration::from_secs(5), "it does not come to pass");
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    }

    #[tokio::test]
    async fn a_panicking_job_is_a_500_and_the_next_one_runs() {
        let queue = queue(0, 5_000);
        for _ in 0..5 {
            let bad = queue.run(task_of(&Tenant::anonymous(), Class::Renders), panicking).await;
            assert_eq!(status(bad), Some(StatusCode::INTERNAL_SERVER_ERROR));
        }
        assert_eq!(
            queue
                .run(task_of(&Tenant::anonymous(), Class::Renders), |job| job.workers.work(|| 42).map_err(|_| gone()))
                .await
                .unwrap()
                .value,
            42
        );
        assert_eq!((queue.running(), queue.waiting()), (0, 0));
    }

    #[tokio::test]
    async fn a_full_queue_refuses_at_once() {
        let queue = queue(1, 60_000);
        let busy: Vec<_> = (0..=UNDER_WAY)
            .map(|_| {
                let queue = Arc::clone(&queue);
                tokio::spawn(async move {
                    queue.run(task_of(&Tenant::anonymous(), Class::Renders), endless).await.map(|done| done.value)
                })
            })
            .collect();
        until(|| (queue.running(), queue.waiting()) == (1, UNDER_WAY)).await;
        let asked = Instant::now();
        assert_eq!(
            status(queue.run(task_of(&Tenant::anonymous(), Class::Renders), endless).await),
            Some(StatusCode::SERVICE_UNAVAILABLE)
        );
        assert!(asked.elapsed() < Duration::from_millis(100));
        busy.iter().for_each(tokio::task::JoinHandle::abort);
        until(|| (queue.running(), queue.waiting()) == (0, 0)).await;
    }

    #[tokio::test]
    async fn a_client_that_goes_away_stops_its_job() {
        let queue = queue(0, 60_000);
        let request = {
            let queue = Arc::clone(&queue);
            tokio::spawn(async move {
                queue.run(task_of(&Tenant::anonymous(), Class::Renders), endless).await.map(|done| done.value)
            })
        };
        until(|| queue.running() == 1).await;
        request.abort();
        let gone = Instant::now();
        until(|| queue.running() == 0).await;
        assert!(gone.elapsed() < Duration::from_millis(100), "{:?}", gone.elapsed());
    }

    #[tokio::test]
    async fn a_job_past_its_deadline_is_given_up() {
        let queue = queue(0, 50);
        assert_eq!(
            status(queue.run(task_of(&Tenant::anonymous(), Class::Renders), endless).await),
            Some(StatusCode::GATEWAY_TIMEOUT)
        );
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
