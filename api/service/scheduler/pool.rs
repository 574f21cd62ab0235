//! The threads that render. One task has the processors at a time, each on threads of its own.

use super::task::Task;
use super::time_slices::{Scheduled, Scheduler, Slices};
use parking_lot::Mutex;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::fmt;
use std::io;
use std::mem;
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::{Duration, Instant};
use strahl::control::{Cancelled, Control, leave_all};

/// Threads of so many tasks are kept for others.
const KEPT: usize = 8;

/// Threads for tasks, and who has the processors.
///
/// Each task has a rayon pool of its own, so that a thread that waits for a part of one render never takes up another
/// render, and a paused task keeps its threads where they are.
#[derive(Debug)]
pub(crate) struct Pool {
    /// How many threads a task has.
    pub(crate) threads: usize,
    idle: Mutex<Vec<ThreadPool>>,
    pub(crate) scheduler: Scheduler,
    meter: Option<Arc<dyn Meter>>,
}

/// Who is told what tasks took.
pub(crate) trait Meter: fmt::Debug + Send + Sync {
    /// A task of a tenant has ended, done or cancelled, after so many rays were traced for it.
    fn traced(&self, tenant: &str, rays: u64);
}

/// The pool as one task sees it.
#[derive(Debug)]
pub(crate) struct Workers {
    pool: Arc<Pool>,
    tenant: Arc<str>,
    scheduled: Scheduled,
    control: Control,
    threads: OnceLock<ThreadPool>,
    /// Slices that were waited for before there was a thread to work on.
    first: Mutex<Option<Slices>>,
}

impl Pool {
    /// Tasks will have a number of threads; by default as many as the machine or its container has processors.
    pub(crate) fn start(threads: Option<u64>, meter: Option<Arc<dyn Meter>>) -> io::Result<Arc<Self>> {
        let processors = || thread::available_parallelism().map_or(1, usize::from);
        let threads = threads.map_or_else(processors, |threads| usize::try_from(threads).unwrap_or(usize::MAX));
        let idle = Mutex::new(vec![start_threads(threads)?]);
        Ok(Arc::new(Self { threads, idle, scheduler: Scheduler::start()?, meter }))
    }

    /// A task that may want the pool. Waiting for it ends when `control` is cancelled.
    pub(crate) fn join(self: Arc<Self>, task: Task, control: Control) -> Workers {
        let tenant = Arc::clone(&task.tenant);
        let scheduled = self.scheduler.join(task, control.clone());
        Workers { tenant, scheduled, pool: self, control, threads: OnceLock::new(), first: Mutex::new(None) }
    }
}

fn start_threads(threads: usize) -> io::Result<ThreadPool> {
    let builder = ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("render-{i}"));
    builder.build().map_err(io::Error::other)
}

impl Workers {
    /// Waits for the pool without a thread, and keeps it for the first work.
    pub(crate) async fn wait(&self) -> Result<(), Cancelled> {
        let slices = self.scheduled.wait().await?;
        *self.first.lock() = Some(slices);
        Ok(())
    }

    /// For how long it has had the pool.
    pub(crate) fn had(&self) -> Duration {
        self.scheduled.had()
    }

    /// Does some work on the pool. It is paused while others have their time slices. What it has made is dropped if it was
    /// cancelled meanwhile.
    pub(crate) fn work<T: Send>(&self, work: impl FnOnce() -> T + Send) -> Result<T, Cancelled> {
        let first = self.first.lock().take();
        let slices = first.map_or_else(|| self.scheduled.wait_here(None), Ok)?;
        self.run(slices, work)
    }

    /// The same for work that ends by itself at some time, which should not be paused shortly before.
    pub(crate) fn work_until<T: Send>(&self, ends: Instant, work: impl FnOnce() -> T + Send) -> Result<T, Cancelled> {
        let first = self.first.lock().take().inspect(|slices| slices.end_at(ends));
        let slices = first.map_or_else(|| self.scheduled.wait_here(Some(ends)), Ok)?;
        self.run(slices, work)
    }

    fn run<T: Send>(&self, slices: Slices, work: impl FnOnce() -> T + Send) -> Result<T, Cancelled> {
        let (mut work, mut result) = (Some(work), None);
        self.install(slices, &mut || result = work.take().map(|work| work()))?;
        result.ok_or(Cancelled)
    }

    /// Work of any kind, so that handing it over is compiled once and not for each of 160 kinds.
    fn install(&self, _slices: Slices, work: &mut (dyn FnMut() + Send)) -> Result<(), Cancelled> {
        self.threads_of_its_own()?.install(work);
        // What cancelled work has made may be cut short anywhere.
        if self.control.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// How many threads there are.
    pub(crate) fn threads(&self) -> usize {
        self.pool.threads
    }

    /// Whose work it is.
    pub(crate) fn tenant(&self) -> &str {
        &self.tenant
    }

    fn threads_of_its_own(&self) -> Result<&ThreadPool, Cancelled> {
        if let Some(threads) = self.threads.get() {
            return Ok(threads);
        }
        let idle = self.pool.idle.lock().pop();
        let threads = match idle.map_or_else(|| start_threads(self.pool.threads), Ok) {
            Ok(threads) => threads,
            Err(error) => {
                tracing::error!(%error, "no threads can be started");
                return Err(Cancelled);
            }
        };
        threads.broadcast(|_| self.control.enter_for_good());
        Ok(self.threads.get_or_init(|| threads))
    }
}

impl Drop for Workers {
    fn drop(&mut self) {
        // The processors first: whoever waits need not wait for the threads.
        drop(self.first.lock().take());
        if let Some(meter) = &self.pool.meter {
            meter.traced(&self.tenant, self.control.rays());
        }
        if let Some(threads) = mem::take(&mut self.threads).into_inner() {
            threads.broadcast(|_| leave_all());
            let mut idle = self.pool.idle.lock();
            if idle.len() < KEPT {
                idle.push(threads);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::task::Class;
    use super::*;
    use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
    use std::time::{Duration, Instant};
    use strahl::control::Stopwatch;
    use strahl::film::Region;
    use strahl::render::render;

    fn task(tenant: &str) -> Task {
        Task::new(Class::Renders, tenant, 1)
    }

    #[test]
    fn a_paused_picture_is_the_picture() {
        let text = include_bytes!("../../../scenes/whitted/whitted.json");
        // It takes more than a slice.
        let overrides = strahl::scene::Overrides { width: Some(800), height: Some(450), ..Default::default() };
        let scene = strahl::scene::load(text, strahl::scene::Format::Json, &overrides).unwrap().scene;
        let whole = Region::whole(scene.width, scene.height);
        let alone = render(&scene, whole, &Control::default()).unwrap();
        let pool = Pool::start(Some(2), None).unwrap();
        let [one, other] = ["one", "other"].map(|tenant| {
            let control = Control::default();
            (Arc::clone(&pool).join(task(tenant), control.clone()), control)
        });
        let pictures = thread::scope(|scope| {
            let threads = [&one, &other].map(|(workers, control)| {
                let work = || {
                    let (wall, worked) = (Instant::now(), Stopwatch::start());
                    let picture = render(&scene, whole, control).unwrap();
                    (picture, wall.elapsed().saturating_sub(worked.elapsed()))
                };
                scope.spawn(move || workers.work(work).unwrap())
            });
            threads.map(|thread| thread.join().unwrap())
        });
        for (picture, _) in &pictures {
            assert!(picture.film == alone.film && picture.rays == alone.rays);
        }
        // Two readings of a clock are nanoseconds apart, and a pause is as long as a slice.
        let is_pause = |paused: &Duration| *paused > Duration::from_millis(1);
        assert!(pictures.iter().any(|(_, paused)| is_pause(paused)), "neither was paused");
    }

    /// Work that never looks at its control.
    #[test]
    fn work_that_cannot_be_paused_does_not_hold_up_others() {
        let pool = Pool::start(Some(1), None).unwrap();
        let [deaf, other] = ["deaf", "other"].map(|tenant| Arc::clone(&pool).join(task(tenant), Control::default()));
        let (over, rounds) = (AtomicBool::new(false), AtomicU64::new(0));
        thread::scope(|scope| {
            scope.spawn(|| {
                deaf.work(|| {
                    while !over.load(Ordering::Relaxed) {
                        thread::sleep(Duration::from_millis(1));
                        rounds.fetch_add(1, Ordering::Relaxed);
                    }
                })
            });
            while rounds.load(Ordering::Relaxed) == 0 {
                thread::yield_now();
            }
            for _ in 0..3 {
                assert_eq!(other.work(|| 42), Ok(42));
            }
            over.store(true, Ordering::Relaxed);
        });
    }
}
