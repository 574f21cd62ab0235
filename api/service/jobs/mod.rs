//! Jobs: renders that run in the background. Accepted jobs and their finished tiles survive a restart or a crash.
//!
//! The folder holds `jobs.redb` (records), `scenes/` (texts by their hash), `pictures/` (with their cost reports, and small ones
//! beside them; jobs share both) and `tiles/` (finished tiles of the jobs that are rendered).

mod backend;
mod canvas;
mod checkpoint;
#[cfg(test)]
mod crash_tests;
mod disk_shares;
mod event_log;
#[cfg(test)]
mod failing_disk_tests;
mod files;
mod finish;
mod frames;
mod job;
mod leftovers;
mod orphans;
pub(crate) mod outbox;
mod queries;
pub(crate) mod record;
mod records;
mod references;
mod registry;
mod rendering;
mod replica;
mod retention;
mod run;
mod shared;
mod store;
mod submission;
mod tile_order;
mod transitions;
mod upgrade;
mod waiters;

pub(crate) use canvas::PREVIEW_SIDE;
pub(crate) use event_log::Event;
pub(crate) use files::DATA;
pub(crate) use job::{Job, Watcher};
pub(crate) use submission::{Claim, KeyUse};
pub(crate) use transitions::end_of;

use crate::service::error::StartError;
use crate::service::farm::Farm;
use crate::service::limits::JobLimits;
use crate::service::scenes::cache::SceneCache;
use crate::service::scheduler::pool::Pool;
use crate::service::storage::folder::Folder;
use event_log::EventPublisher;
use files::Files;
use job::Stopped;
use outbox::{DeliveryKind, DeliveryState};
use parking_lot::Mutex;
use record::{Record, State};
use records::Records;
use registry::Registry;
use shared::Shared;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use store::Store;
use tokio::sync::{Notify, watch};
use transitions::abandoned;

/// A job fails after more ends of the process than this without a new tile.
const CRASHES: u32 = 2;

/// Milliseconds of an estimate from which on it tells how slow the service is: of shorter jobs most is what no estimate has.
const TELLING: f64 = 100.0;

/// Counts jobs.
pub(crate) trait JobObserver: Send + Sync {
    /// A job has ended in a final state.
    fn ended(&self, record: &Record, state: State);
    /// An attempt to deliver something has ended: pending if there will be another.
    fn attempted(&self, kind: DeliveryKind, state: DeliveryState);
}

/// All jobs.
pub(crate) struct Jobs {
    pool: Arc<Pool>,
    cache: Arc<SceneCache>,
    /// Who renders tiles, if it is not this process.
    farm: Option<Arc<Farm>>,
    observer: Arc<dyn JobObserver>,
    records: Box<dyn Records>,
    /// What the fronts of a farm have in common.
    shared: Option<Arc<Shared>>,
    files: Files,
    /// Whether another version of the program has written records that this one cannot read.
    has_other_records: bool,
    /// The limits.
    pub(crate) limits: JobLimits,
    registry: Mutex<Registry>,
    /// Rings when a job has something to deliver.
    bell: Notify,
    /// Number of open jobs.
    open: watch::Sender<usize>,
    /// Milliseconds of work on jobs that failed or were canceled.
    canceled: AtomicU64,
    /// Whether somebody has removed the folders of files.
    folders_are_gone: AtomicBool,
    /// Whether a job could not be kept lately.
    files_fail: AtomicBool,
    /// The run time that was last written down for its own sake.
    time_kept: AtomicU64,
}

impl std::fmt::Debug for Jobs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Jobs").field("files", &self.files).field("limits", &self.limits).finish_non_exhaustive()
    }
}

impl Jobs {
    fn new(
        pool: Arc<Pool>,
        cache: Arc<SceneCache>,
        farm: Option<Arc<Farm>>,
        observer: Arc<dyn JobObserver>,
        records: Box<dyn Records>,
        shared: Option<Arc<Shared>>,
        files: Files,
        limits: JobLimits,
        registry: Registry,
    ) -> Self {
        Self {
            pool,
            cache,
            farm,
            observer,
            records,
            shared,
            files,
            has_other_records: false,
            limits,
            registry: Mutex::new(registry),
            bell: Notify::new(),
            open: watch::Sender::new(0),
            canceled: AtomicU64::new(0),
            folders_are_gone: AtomicBool::new(false),
            files_fail: AtomicBool::new(false),
            time_kept: AtomicU64::new(0),
        }
    }

    /// Opens a folder and resumes the jobs in it, or joins the fronts of a farm.
    pub(crate) fn open(
        folder: &mut Folder,
        limits: JobLimits,
        pool: Arc<Pool>,
        cache: Arc<SceneCache>,
        farm: Option<Arc<Farm>>,
        observer: Arc<dyn JobObserver>,
    ) -> Result<Arc<Self>, StartError> {
        if let Some(farm) = farm {
            return Self::join(folder, limits, pool, cache, farm, observer);
        }
        let path = &folder.path;
        let unusable = |error| {
            let advice = "The service has to write into this folder: name another with --data DIR.";
            StartError::Machine(format!("jobs cannot be kept in {}: {error}\n\n{advice}", path.display()))
        };
        let files = Files::open(path, limits.data.is_some(), !folder.is_marked).map_err(unusable)?;
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
                store.create(&record).map_err(|refused| unusable(refused.into()))?;
            }
            if record.state.is_final() && record.ended.is_none() {
                record.ended = Some(store.time());
                store.create(&record).map_err(|refused| unusable(refused.into()))?;
            }
            registry.add(&Arc::new(Job::new(record, 1, None)));
        }
        let hopeless = |job: &Arc<Job>| job.record().crashes > CRASHES;
        let hopeless: Vec<_> = registry.queued.iter().filter(|job| hopeless(job)).map(Arc::clone).collect();
        folder.mark()?;
        let jobs = Self::new(pool, cache, None, observer, Box::new(store), None, files, limits, registry);
        let jobs = Arc::new(Self { has_other_records: contents.others, ..jobs });
        jobs.check_orphans();
        for job in hopeless {
            jobs.finish(&job, State::Failed, Some(abandoned()));
        }
        jobs.open_next();
        Ok(jobs)
    }

    /// Who tells other fronts of events.
    fn publisher(&self) -> Option<Arc<dyn EventPublisher>> {
        self.shared.as_ref().map(|shared| Arc::<Shared>::clone(shared) as Arc<dyn EventPublisher>)
    }

    /// Stops a job. False if it had already ended.
    pub(crate) fn cancel(&self, job: &Arc<Job>) -> io::Result<bool> {
        if self.registry.lock().is_open(job) {
            let running = !job.record().state.is_final();
            job.stop(Stopped::Canceled);
            return Ok(running);
        }
        self.end(job, State::Canceled)
    }

    /// Changes a job's priority, which counts from the next time slice on. False if `may` refuses the version that it has.
    pub(crate) fn set_priority(&self, job: &Arc<Job>, priority: u8, may: impl Fn(u64) -> bool) -> io::Result<bool> {
        self.change(job, |record| {
            if !may(record.version) {
                return false;
            }
            record.priority = priority;
            record.version += 1;
            true
        })
    }

    /// Deletes a job. Its files go when its work has stopped.
    pub(crate) fn forget(&self, job: &Arc<Job>) -> io::Result<()> {
        if self.records.front().is_some() {
            return self.mark_forgotten(job).map(drop);
        }
        {
            // From here on no change writes the record again.
            let _turn = job.changing.lock();
            self.records.remove(&[Arc::clone(job)])?;
            job.forgotten.store(true, Ordering::SeqCst);
        }
        self.cancel(job)?;
        let is_open = {
            let mut registry = self.registry.lock();
            let is_open = registry.is_open(job);
            if is_open {
                let id = job.record().id.clone();
                registry.remove(&id);
            }
            is_open
        };
        // The files of an open one follow when it is closed.
        if !is_open {
            self.drop_all(&[Arc::clone(job)]);
        }
        Ok(())
    }

    /// Opens no more jobs, and suspends open ones if another process can go on with them.
    pub(crate) fn close(&self) {
        let mut registry = self.registry.lock();
        registry.closing = true;
        if self.limits.durable {
            registry.open.iter().for_each(|job| job.stop(Stopped::Suspended));
        }
    }

    /// Waits until no job is open.
    pub(crate) async fn idle(&self) {
        // It fails only without a sender, and `self` is one.
        let _ = self.open.subscribe().wait_for(|open| *open == 0).await;
    }

    /// Opens waiting jobs while there is room for more.
    fn open_next(self: &Arc<Self>) {
        let mut registry = self.registry.lock();
        while let Some(at) = registry.next_to_open(&self.limits, |record| self.is_for_others(record)) {
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
                job.events.publish_here("queued", data);
            }
        }
    }

    fn closed(self: &Arc<Self>, job: &Arc<Job>) {
        let mut registry = self.registry.lock();
        registry.close(job);
        let record = job.record();
        if record.state == State::Succeeded && record.stats.tiles_recovered == 0 && record.estimate_ms >= TELLING {
            let ratio = record.stats.render_ms / record.estimate_ms;
            registry.slowness = Some(registry.slowness.map_or(ratio, |slowness| 0.8 * slowness + 0.2 * ratio));
        }
        drop(record);
        self.open.send_replace(registry.open.len());
        // One that is still there is dropped by who forgets it.
        let record = job.record().clone();
        if job.forgotten.load(Ordering::SeqCst) && !registry.jobs.contains_key(&record.id) {
            registry.release_files(&record, &self.files);
        }
        drop(registry);
        self.open_next();
    }
}
