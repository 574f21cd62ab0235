//! Jobs: renders that run in the background. Accepted jobs and their finished tiles survive a restart or a crash.
//!
//! The folder holds `jobs.redb` (records), `scenes/` (texts by their hash), `pictures/` (with their cost reports, and small ones
//! beside them; jobs share both) and `tiles/` (finished tiles of the jobs that are rendered).

mod backend;
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
mod leftovers;
mod orphans;
mod queries;
pub(crate) mod record;
mod records;
mod references;
mod registry;
mod replica;
mod retention;
mod run;
mod shared;
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
use crate::service::farm::Farm;
use crate::service::limits::JobLimits;
use crate::service::scenes::cache::SceneCache;
use crate::service::scheduler::pool::Pool;
use crate::service::storage::folder::Folder;
use crate::service::storage::revisions::Refused;
use event_log::{Herald, before_life};
use files::Files;
use job::{Stopped, locked};
use record::{Failure, Record, State, now};
use records::Records;
use registry::Registry;
use shared::Shared;
use std::io;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};
use store::Store;
use tokio::sync::watch;

/// How often a record is changed again after another front has changed it first.
const TRIES: u32 = 100;
/// Time until the end of a job is written again, while it cannot be.
const BETWEEN_WRITES: Duration = Duration::from_secs(1);
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
            open: watch::Sender::new(0),
            canceled: AtomicU64::new(0),
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
    fn herald(&self) -> Option<Arc<dyn Herald>> {
        self.shared.as_ref().map(|shared| Arc::<Shared>::clone(shared) as Arc<dyn Herald>)
    }

    /// Stops a job. False if it had already ended.
    pub(crate) fn cancel(&self, job: &Arc<Job>) -> io::Result<bool> {
        if locked(&self.registry).is_open(job) {
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
        job.forgotten.store(true, Ordering::SeqCst);
        self.cancel(job)?;
        let is_open = {
            let mut registry = locked(&self.registry);
            let is_open = registry.is_open(job);
            if is_open {
                let id = job.record().id.clone();
                registry.remove(&id);
            }
            is_open
        };
        if is_open {
            // The rest follows when it is closed.
            self.forget_record(job);
        } else {
            self.forget_all(&[Arc::clone(job)]);
        }
        Ok(())
    }

    /// Opens no more jobs, and suspends open ones if another process can go on with them.
    pub(crate) fn close(&self) {
        let mut registry = locked(&self.registry);
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

    /// Changes a record where records live, and then here. False if `change` says that it does not apply: it is asked again when
    /// another front has changed the record.
    fn change(&self, job: &Arc<Job>, change: impl Fn(&mut Record) -> bool) -> io::Result<bool> {
        let _turn = locked(&job.changing);
        for _ in 0..TRIES {
            let (mut record, revision) = job.stored();
            if !change(&mut record) {
                return Ok(false);
            }
            // The record of a forgotten job is gone.
            let is_gone = job.forgotten.load(Ordering::SeqCst);
            match if is_gone { Ok(revision + 1) } else { self.records.replace(&record, revision) } {
                Ok(revision) => {
                    self.adopt(job, record, revision);
                    return Ok(true);
                }
                Err(Refused::Changed) => match self.records.current(&record)? {
                    Some((current, revision)) => self.adopt(job, current, revision),
                    None => {
                        self.vanished(&record.id);
                        return Ok(false);
                    }
                },
                Err(Refused::Failed(error)) => return Err(error),
            }
        }
        Err(Refused::Changed.into())
    }

    /// Takes over a record that was written, here or elsewhere.
    fn adopt(&self, job: &Arc<Job>, record: Record, revision: u64) {
        let mut registry = locked(&self.registry);
        let Some(before) = job.adopt(record, revision) else { return };
        registry.follow(job, &before, &self.files);
        let record = job.record().clone();
        if registry.is_open(job) && (record.state.is_final() || !self.is_mine(&record)) {
            job.stop(Stopped::Taken);
        }
        drop(registry);
        if record.lives != before.lives {
            job.events.begin(record.lives);
        }
        if record.state.is_final() {
            *locked(&job.left) = Some(Instant::now());
        }
        job.events.ring();
    }

    /// Whether this process works on a job, or nobody does where no other could.
    fn is_mine(&self, record: &Record) -> bool {
        record.front.as_deref() == self.records.front()
    }

    /// Makes this process the one that works on a job. False if another does, or the job has ended.
    fn begin(&self, job: &Arc<Job>) -> io::Result<bool> {
        let done = job.done.load(Ordering::Relaxed) as u64;
        let front = self.records.front();
        let change = |record: &mut Record| {
            // An answer of the broker may have been lost: then this front has it already.
            let is_other = |owner: &str| Some(owner) != front && self.records.is_alive(owner);
            if record.state.is_final() || record.front.as_deref().is_some_and(is_other) {
                return false;
            }
            if let Some(front) = front {
                if record.state == State::Running && record.front.as_deref() != Some(front) {
                    record.count_crash(done);
                }
                record.front = Some(front.to_owned());
                record.lives += 1;
            }
            record.state = State::Running;
            if record.started.is_none() {
                let started = now();
                record.started = Some(started);
                record.stats.queue_ms = started.saturating_sub(record.created) as f64;
            }
            true
        };
        let is_mine = loop {
            match self.change(job, change) {
                Err(error) if front.is_some() && !job.control().is_cancelled() => {
                    tracing::error!(job = job.record().id, %error, "a record cannot be written");
                    thread::sleep(BETWEEN_WRITES);
                }
                done => break done?,
            }
        };
        if let (Some(_), true) = (front, is_mine) {
            let record = job.record();
            tracing::info!(job = record.id, life = record.lives, "this front begins");
        }
        Ok(is_mine)
    }

    /// Lets another process go on with a job: what is kept of it suffices. It waits again, since this end of the process is not
    /// the job's fault.
    fn suspend(&self, job: &Arc<Job>) {
        let suspended = self.change(job, |record| {
            let is_mine = self.is_mine(record) && !record.state.is_final();
            (record.state, record.front) = (State::Queued, None);
            is_mine
        });
        if let Err(error) = suspended {
            tracing::error!(%error, "a record cannot be written");
        }
    }

    /// Writes the final state of a job that this process works on, and tells observer and watchers. It counts only if no other
    /// front has taken the job.
    fn finish(&self, job: &Arc<Job>, state: State, failure: Option<Failure>) {
        let change = |record: &mut Record| {
            let is_mine = self.is_mine(record) && !record.state.is_final();
            self.end_record(job, record, state, failure.clone());
            is_mine
        };
        let life = job.record().lives;
        let has_ended_in = |life: u64| {
            let record = job.record();
            record.lives == life && record.state.is_final()
        };
        let mut is_doubtful = false;
        loop {
            match self.change(job, change) {
                Ok(true) => break,
                // It was written, and only the answer was lost.
                Ok(false) if is_doubtful && has_ended_in(life) => break,
                Ok(false) => return tracing::info!(job = job.record().id, "a job was taken by another front"),
                Err(error) => tracing::error!(job = job.record().id, %error, "a record cannot be written"),
            }
            is_doubtful = true;
            if self.records.front().is_none() {
                // It has ended all the same, until the service is started again.
                let (mut record, revision) = job.stored();
                change(&mut record);
                self.adopt(job, record, revision + 1);
                break;
            }
            if locked(&self.registry).closing {
                return;
            }
            thread::sleep(BETWEEN_WRITES);
        }
        self.ended(job);
    }

    /// Ends a job that this process does not work on. False if it has ended already.
    fn end(&self, job: &Arc<Job>, state: State) -> io::Result<bool> {
        let has_ended = self.change(job, |record| {
            let goes_on = !record.state.is_final();
            self.end_record(job, record, state, None);
            goes_on
        })?;
        if has_ended {
            self.ended(job);
        }
        Ok(has_ended)
    }

    /// The final record of a job.
    fn end_record(&self, job: &Job, record: &mut Record, state: State, failure: Option<Failure>) {
        let last = if self.is_mine(record) {
            job.events.last()
        } else {
            // Another front may be about to publish events: those of a later life come after all of them.
            record.lives += 1;
            before_life(record.lives)
        };
        record.state = state;
        record.finished = Some(now());
        record.ended = Some(self.records.time());
        record.failure = failure;
        record.last_event = Some(last + 1);
        record.stats.rays = record.stats.rays.max(job.rays.load(Ordering::Relaxed));
        let leaves_files = state != State::Succeeded;
        record.front = self.records.front().filter(|_| leaves_files).map(str::to_owned);
    }

    /// A job has been ended by this process.
    fn ended(&self, job: &Job) {
        let record = job.record().clone();
        self.files.remove_tiles_of(std::slice::from_ref(&record.id));
        if let Some(farm) = &self.farm {
            farm.forget_results(&job.work_name());
        }
        if let (false, Some(begun)) = (record.state == State::Succeeded, *locked(&job.begun)) {
            self.canceled.fetch_add(milliseconds(begun) as u64, Ordering::Relaxed);
        }
        self.observer.ended(&record, record.state);
        tracing::info!(job = record.id, state = record.state.name(), "a job has ended");
        job.events.hear(end_of(&record, record.last_event.unwrap_or_default()));
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
                job.events.publish_here("queued", data);
            }
        }
    }

    fn closed(self: &Arc<Self>, job: &Arc<Job>) {
        let mut registry = locked(&self.registry);
        registry.close(job);
        let record = job.record();
        if record.state == State::Succeeded && record.stats.tiles_recovered == 0 {
            let ratio = record.stats.render_ms / record.estimate_ms.max(0.1);
            registry.slowness = Some(registry.slowness.map_or(ratio, |slowness| 0.8 * slowness + 0.2 * ratio));
        }
        drop(record);
        self.open.send_replace(registry.open.len());
        if job.forgotten.load(Ordering::SeqCst) {
            let record = job.record().clone();
            registry.release_files(&record, &self.files);
            self.forget_record(job);
        }
        drop(registry);
        self.open_next();
    }
}

/// The last event of a job, and its number. Every front makes it from the record.
fn end_of(record: &Record, seq: u64) -> Event {
    let data = serde_json::json!({ "stats": record.stats, "failure": record.failure });
    Event { seq, name: record.state.name(), data }
}

/// Why a job is given up that no process gets on with.
fn abandoned() -> Failure {
    let detail = format!("the service ended {} times while it rendered this job, without a new tile", CRASHES + 1);
    Failure { slug: "abandoned".into(), detail }
}
