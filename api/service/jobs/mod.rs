//! Jobs: renders that run in the background. Accepted jobs and their finished tiles survive a restart or a crash.
//!
//! The folder holds `jobs.redb` (records), `scenes/` (texts by their hash), `pictures/` (with their cost reports, and small ones
//! beside them; jobs share both) and `tiles/` (finished tiles of the jobs that are rendered).

mod canvas;
mod checkpoint;
#[cfg(test)]
mod crash;
mod disk_shares;
mod event_log;
mod files;
mod finish;
mod frames;
mod job;
mod orphans;
mod queries;
pub(crate) mod record;
mod references;
mod registry;
mod retention;
mod run;
mod store;
mod submission;
mod tile_order;
mod upgrade;

pub(crate) use canvas::PREVIEW_SIDE;
pub(crate) use event_log::Event;
pub(crate) use files::DATA;
pub(crate) use job::{Job, Watcher};
pub(crate) use submission::{Claim, KeyUse};

use crate::service::clock::milliseconds;
use crate::service::error::StartError;
use crate::service::limits::JobLimits;
use crate::service::scenes::cache::SceneCache;
use crate::service::scheduler::pool::Pool;
use crate::service::storage::folder::Folder;
use files::Files;
use job::{Stopped, locked};
use record::{Failure, Record, State, now};
use registry::Registry;
use std::io;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use store::Store;
use tokio::sync::watch;

/// A job fails after more ends of the process than this without a new tile.
const CRASHES: u32 = 2;

/// Counts jobs.
pub(crate) trait JobObserver: Send + Sync {
    /// A job has ended in a final state.
    fn ended(&self, record: &Record, state: State);
}

/// All jobs.
pub(crate) struct Jobs {
    pool: Arc<Pool>,
    cache: Arc<SceneCache>,
    observer: Arc<dyn JobObserver>,
    store: Store,
    files: Files,
    /// Whether another version of the program has written records that this one cannot read.
    has_other_records: bool,
    /// The limits.
    pub(crate) limits: JobLimits,
    registry: Mutex<Registry>,
    /// Number of open jobs.
    open: watch::Sender<usize>,
    /// Milliseconds of work on jobs that failed or were canceled.
    canceled: AtomicU64,
    /// The run time that was last written down for its own sake.
    time_kept: AtomicU64,
}

impl std::fmt::Debug for Jobs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Jobs").field("files", &self.files).field("limits", &self.limits).finish_non_exhaustive()
    }
}

impl Jobs {
    /// Opens a folder and resumes the jobs in it.
    pub(crate) fn open(
        folder: &mut Folder,
        limits: JobLimits,
        pool: Arc<Pool>,
        cache: Arc<SceneCache>,
        observer: Arc<dyn JobObserver>,
    ) -> Result<Arc<Self>, StartError> {
        let path = &folder.path;
        let unusable = |error| {
            let advice = "The service has to write into this folder: name another with --data DIR.";
            StartError::Machine(format!("jobs cannot be kept in {}: {error}\n\n{advice}", path.display()))
        };
        let files = Files::open(path, limits.data.is_some()).map_err(unusable)?;
        let (store, contents) = Store::open(path, !files.is_empty() || upgrade::has_files(path))?;
        if !folder.is_marked {
            upgrade::upgrade(path, &files, &contents.records).map_err(unusable)?;
        }
        let mut registry = Registry::default();
        for mut record in contents.records {
            if !record.state.is_final() {
                if record.state == State::Running {
                    record.count_crash(files.written(&record));
                }
                record.state = State::Queued;
                record.lives += 1;
                store.put(&record).map_err(unusable)?;
            }
            if record.state.is_final() && record.ended.is_none() {
                record.ended = Some(store.run_time.ms());
                store.put(&record).map_err(unusable)?;
            }
            registry.add(&Arc::new(Job::new(record)));
        }
        let hopeless = |job: &Arc<Job>| job.record().crashes > CRASHES;
        let hopeless: Vec<_> = registry.queued.extract_if(.., |job| hopeless(job)).collect();
        folder.mark()?;
        let jobs = Arc::new(Self {
            pool,
            cache,
            observer,
            store,
            files,
            has_other_records: contents.others,
            limits,
            registry: Mutex::new(registry),
            open: watch::Sender::new(0),
            canceled: AtomicU64::new(0),
            time_kept: AtomicU64::new(0),
        });
        jobs.check_orphans();
        for job in hopeless {
            let detail =
                format!("the service ended {} times while it rendered this job, without a new tile", CRASHES + 1);
            jobs.finish(&job, State::Failed, Some(Failure { slug: "abandoned".into(), detail }));
        }
        jobs.open_next();
        Ok(jobs)
    }

    /// Stops a job. False if it had already ended.
    pub(crate) fn cancel(&self, job: &Arc<Job>) -> bool {
        let was_queued = {
            let mut registry = locked(&self.registry);
            let queued = registry.queued.iter().position(|queued| Arc::ptr_eq(queued, job));
            queued.map(|at| registry.queued.swap_remove(at)).is_some()
        };
        if was_queued {
            self.finish(job, State::Canceled, None);
            return true;
        }
        let running = !job.record().state.is_final();
        job.stop(Stopped::Canceled);
        running
    }

    /// Changes a job's priority. It counts from the next time slice on.
    pub(crate) fn set_priority(&self, job: &Job, priority: u8) -> io::Result<()> {
        job.priority.store(priority, Ordering::Relaxed);
        {
            let mut record = job.record();
            record.priority = priority;
            record.version += 1;
        }
        self.save(job)
    }

    /// Deletes a job. Its files go when its work has stopped.
    pub(crate) fn forget(&self, job: &Arc<Job>) {
        job.forgotten.store(true, Ordering::SeqCst);
        self.cancel(job);
        let id = job.record().id.clone();
        let is_open = {
            let mut registry = locked(&self.registry);
            let is_open = registry.open.iter().any(|open| Arc::ptr_eq(open, job));
            if is_open {
                registry.remove(&id);
            }
            is_open
        };
        if is_open {
            // The rest follows when it is closed.
            self.forget_record(&id);
        } else {
            self.forget_all(&[id]);
        }
    }

    /// Opens no more jobs, and suspends open ones if their folder outlives this process.
    pub(crate) fn close(&self) {
        let mut registry = locked(&self.registry);
        registry.closing = true;
        if self.limits.data.is_some() {
            registry.open.iter().for_each(|job| job.stop(Stopped::Suspended));
        }
    }

    /// Waits until no job is open.
    pub(crate) async fn idle(&self) {
        // It fails only without a sender, and `self` is one.
        let _ = self.open.subscribe().wait_for(|open| *open == 0).await;
    }

    fn save(&self, job: &Job) -> io::Result<()> {
        let record = job.record().clone();
        self.put(job, &record)
    }

    fn put(&self, job: &Job, record: &Record) -> io::Result<()> {
        if job.forgotten.load(Ordering::SeqCst) { Ok(()) } else { self.store.put(record) }
    }

    /// Writes the final state of a job, and tells observer and watchers.
    fn finish(&self, job: &Job, state: State, failure: Option<Failure>) {
        let (id, data) = {
            let mut record = job.record();
            record.finished = Some(now());
            record.ended = Some(self.store.run_time.ms());
            record.failure = failure;
            record.last_event = Some(job.events.last() + 1);
            record.stats.rays = record.stats.rays.max(job.rays.load(Ordering::Relaxed));
            (record.id.clone(), serde_json::json!({ "stats": record.stats, "failure": record.failure }))
        };
        // The record is on disk before clients see it.
        let on_disk = Record { state, ..job.record().clone() };
        if let Err(error) = self.put(job, &on_disk) {
            tracing::error!(job = id, %error, "a record cannot be written");
        }
        self.files.remove_tiles(&id);
        job.record().state = state;
        if state != State::Succeeded {
            let mut registry = locked(&self.registry);
            registry.release_scene(&on_disk, &self.files);
            if on_disk.frames.is_some() {
                registry.release_pictures(&on_disk, &self.files);
            }
        }
        if let (false, Some(begun)) = (state == State::Succeeded, *locked(&job.begun)) {
            self.canceled.fetch_add(milliseconds(begun) as u64, Ordering::Relaxed);
        }
        self.observer.ended(&on_disk, state);
        tracing::info!(job = id, state = state.name(), "a job has ended");
        job.events.publish(state.name(), data);
    }

    /// Opens waiting jobs while there is room for more.
    fn open_next(self: &Arc<Self>) {
        let mut registry = locked(&self.registry);
        while let Some(at) = registry.next_to_open(&self.limits) {
            let job = registry.queued.swap_remove(at);
            registry.open.push(Arc::clone(&job));
            self.open.send_replace(registry.open.len());
            let jobs = Arc::clone(self);
            let begun = thread::Builder::new().name("job".into()).spawn({
                let job = Arc::clone(&job);
                move || {
                    run::run(&jobs, &job);
                    jobs.closed(&job);
                }
            });
            if let Err(error) = begun {
                tracing::error!(%error, "no thread for a job");
                registry.open.retain(|open| !Arc::ptr_eq(open, &job));
                registry.queued.push(job);
                self.open.send_replace(registry.open.len());
                return;
            }
        }
        // Clients that watch a waiting job see it move up.
        let watched: Vec<_> = registry.queued.iter().filter(|job| job.is_watched()).map(Arc::clone).collect();
        drop(registry);
        for job in watched {
            if let Some((position, eta_ms)) = self.place(&job) {
                let data = serde_json::json!({ "position": position, "eta_ms": eta_ms.round() });
                job.events.publish("queued", data);
            }
        }
    }

    fn closed(self: &Arc<Self>, job: &Arc<Job>) {
        let mut registry = locked(&self.registry);
        registry.open.retain(|open| !Arc::ptr_eq(open, job));
        let record = job.record();
        if record.state == State::Succeeded && record.stats.tiles_recovered == 0 {
            let ratio = record.stats.render_ms / record.estimate_ms.max(0.1);
            registry.slowness = Some(registry.slowness.map_or(ratio, |slowness| 0.8 * slowness + 0.2 * ratio));
        }
        drop(record);
        self.open.send_replace(registry.open.len());
        if job.forgotten.load(Ordering::SeqCst) {
            let record = job.record();
            registry.release_files(&record, &self.files);
            self.forget_record(&record.id);
        }
        drop(registry);
        self.open_next();
    }
}
