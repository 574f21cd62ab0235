//! Jobs: pictures that nobody has to wait for. Accepted jobs survive any end of the process, finished tiles included.
//!
//! The folder holds `jobs.redb` (records), `scenes/` (texts by their hash, shared by all jobs that render them) and
//! `jobs/ID/`: `tiles` while the job is rendered, `picture` (with its cost report) and `preview` afterwards.

mod canvas;
mod events;
mod job;
mod keep;
mod order;
pub(crate) mod record;
mod registry;
mod report;
mod run;
mod store;
mod submit;
mod tiles;

pub(crate) use canvas::PREVIEW_SIDE;
pub(crate) use events::Event;
pub(crate) use job::{Job, Watcher};
pub(crate) use submit::{Claim, Known, Refused, Submission};

use crate::blobs::Blobs;
use crate::made::{About, Made};
use crate::picture::milliseconds;
use crate::ready::Ready;
use crate::workers::{Pool, Workers};
use job::{Stopped, locked};
use record::{Failure, Order, Record, State, now};
use registry::{Registry, estimate, rank, remaining};
use std::fs::{self, File};
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;
use store::Store;
use strahl::film::FileFormat;
use strahl::scene::{Format, Overrides};
use tokio::sync::watch;

/// The finished picture's file in the folder of a job.
const PICTURE: &str = "picture";
/// The small picture's.
const PREVIEW: &str = "preview";

/// What jobs ask of the service around them.
pub(crate) trait Host: Send + Sync {
    /// Reads and builds a scene.
    fn build(
        &self,
        workers: &Workers,
        text: &[u8],
        format: Format,
        settings: &Overrides,
    ) -> Result<Arc<Ready>, Failure>;

    /// This process works on a tenant's job no more, after so many rays.
    fn spent(&self, tenant: &str, rays: u64);

    /// A job has ended, in this state.
    fn ended(&self, record: &Record, state: State);
}

/// Limits on jobs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JobLimits {
    /// Jobs that wait or run.
    pub(crate) jobs: usize,
    /// Bytes that open jobs may take together.
    pub(crate) memory_bytes: u64,
    /// Bytes that the files of all jobs may take.
    pub(crate) data_bytes: u64,
    /// How long a job may run in one process.
    pub(crate) timeout: Duration,
    /// How long pictures are kept.
    pub(crate) keep_pictures: Duration,
    /// How long records are kept after there is no picture (any more).
    pub(crate) keep_records: Duration,
}

/// All jobs.
pub(crate) struct Jobs {
    pool: Arc<Pool>,
    host: Box<dyn Host>,
    store: Store,
    scenes: Blobs,
    folder: PathBuf,
    /// Whether jobs outlive the process.
    pub(crate) is_durable: bool,
    /// The limits.
    pub(crate) limits: JobLimits,
    registry: Mutex<Registry>,
    /// How many are open.
    open: watch::Sender<usize>,
    /// Milliseconds of work on jobs that came to nothing.
    canceled: AtomicU64,
}

impl std::fmt::Debug for Jobs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Jobs").field("folder", &self.folder).field("limits", &self.limits).finish_non_exhaustive()
    }
}

impl Jobs {
    /// Opens a folder and goes on with the jobs in it.
    pub(crate) fn open(
        folder: &Path,
        is_durable: bool,
        limits: JobLimits,
        pool: Arc<Pool>,
        host: Box<dyn Host>,
    ) -> io::Result<Arc<Self>> {
        fs::create_dir_all(folder)?;
        let store = Store::open(&folder.join("jobs.redb"))?;
        let scenes = Blobs::open(&folder.join("scenes"), u64::MAX)?;
        let mut registry = Registry::default();
        let (records, others) = store.all()?;
        for mut record in records {
            if !record.state.is_final() {
                record.state = State::Queued;
                record.lives += 1;
                store.put(&record)?;
            }
            registry.add(&Arc::new(Job::new(record)));
        }
        let jobs = Arc::new(Self {
            pool,
            host,
            store,
            scenes,
            folder: folder.to_owned(),
            is_durable,
            limits,
            registry: Mutex::new(registry),
            open: watch::Sender::new(0),
            canceled: AtomicU64::new(0),
        });
        // What another version wrote is not for this one to remove.
        if !others {
            jobs.remove_strangers();
        }
        let is_done = |job: &&Arc<Job>| job.record().state == State::Succeeded;
        locked(&jobs.registry).jobs.values().filter(is_done).for_each(|job| jobs.weigh(job));
        jobs.open_next();
        Ok(jobs)
    }

    /// A job.
    pub(crate) fn find(&self, id: &str) -> Option<Arc<Job>> {
        locked(&self.registry).jobs.get(id).map(Arc::clone)
    }

    /// The scene of some job that goes by this name, and the settings over it.
    pub(crate) fn order_of(&self, scene_id: &str) -> Option<Order> {
        let registry = locked(&self.registry);
        let same = |job: &Arc<Job>| {
            let record = job.record();
            let same = record.scene_id.as_deref() == Some(scene_id) && record.state.needs_scene();
            same.then(|| record.order.clone())
        };
        registry.jobs.values().find_map(same)
    }

    /// The picture of some job that is the whole of this image in this format.
    pub(crate) fn picture_of(&self, image_id: &str, format: FileFormat) -> Option<Made> {
        // One that has just been forgotten is as good as none.
        self.with_picture(image_id, format).iter().find_map(|id| self.picture(id).ok())
    }

    /// The jobs that have that picture.
    pub(crate) fn with_picture(&self, image_id: &str, format: FileFormat) -> Vec<String> {
        let registry = locked(&self.registry);
        let same = |job: &Arc<Job>| {
            let record = job.record();
            let same = record.image_id.as_deref() == Some(image_id) && record.order.output == format;
            (same && record.state == State::Succeeded).then(|| record.id.clone())
        };
        registry.jobs.values().filter_map(same).collect()
    }

    /// Jobs after an id, the newest first, as far as `wanted` says so.
    pub(crate) fn list(&self, before: Option<&str>, limit: usize, wanted: impl Fn(&Record) -> bool) -> Vec<Arc<Job>> {
        let registry = locked(&self.registry);
        let older = registry.jobs.range::<str, _>((
            std::ops::Bound::Unbounded,
            before.map_or(std::ops::Bound::Unbounded, std::ops::Bound::Excluded),
        ));
        older.rev().map(|(_, job)| job).filter(|job| wanted(&job.record())).take(limit).map(Arc::clone).collect()
    }

    /// Place of a job among the waiting ones of its tenant, from 1, and milliseconds until it should be done.
    pub(crate) fn place(&self, job: &Arc<Job>) -> Option<(usize, f64)> {
        let registry = locked(&self.registry);
        let mine = rank(job);
        let tenant = job.record().tenant.clone();
        registry.queued.iter().find(|queued| Arc::ptr_eq(queued, job))?;
        let of_tenant = |other: &&Arc<Job>| other.record().tenant == tenant;
        let ahead: Vec<f64> =
            registry.queued.iter().filter(of_tenant).filter(|other| rank(other) > mine).map(estimate).collect();
        let running: f64 = registry.open.iter().filter(of_tenant).map(remaining).sum();
        let mut tenants: Vec<String> = registry.open.iter().map(|job| job.record().tenant.clone()).collect();
        tenants.push(tenant.clone());
        tenants.sort();
        tenants.dedup();
        let alone = ahead.iter().sum::<f64>() + running + estimate(job);
        Some((ahead.len() + 1, alone * registry.slowness.unwrap_or(1.0) * tenants.len() as f64))
    }

    /// Jobs that wait and jobs that are open.
    pub(crate) fn counts(&self) -> (usize, usize) {
        let registry = locked(&self.registry);
        (registry.queued.len(), registry.open.len())
    }

    /// The states of all jobs that are known.
    pub(crate) fn by_state(&self) -> Vec<State> {
        locked(&self.registry).jobs.values().map(|job| job.record().state).collect()
    }

    /// Time spent on jobs that were canceled or have failed.
    pub(crate) fn canceled(&self) -> Duration {
        Duration::from_millis(self.canceled.load(Ordering::Relaxed))
    }

    /// Bytes of scenes and of finished pictures on disk.
    pub(crate) fn bytes(&self) -> u64 {
        self.scenes.bytes() + locked(&self.registry).kept()
    }

    /// Stops a job; whether it was not final yet.
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

    /// Changes a job's priority, from its next turn on.
    pub(crate) fn set_priority(&self, job: &Job, priority: u8) -> io::Result<()> {
        job.priority.store(priority, Ordering::Relaxed);
        {
            let mut record = job.record();
            record.priority = priority;
            record.version += 1;
        }
        self.save(job)
    }

    /// Forgets a job, which ends first if it has not.
    pub(crate) fn forget(&self, job: &Arc<Job>) {
        if self.cancel(job) {
            while locked(&self.registry).open.iter().any(|open| Arc::ptr_eq(open, job)) {
                // It stops within milliseconds; this thread is not one of tokio's.
                thread::sleep(Duration::from_millis(2));
            }
        }
        let id = job.record().id.clone();
        self.forget_all(&[id]);
    }

    /// The picture of a job that has succeeded.
    pub(crate) fn picture(&self, id: &str) -> io::Result<Made> {
        Made::read(&mut BufReader::new(File::open(self.folder_of(id).join(PICTURE))?))
    }

    /// What is said about it.
    pub(crate) fn about(&self, id: &str) -> io::Result<About> {
        About::read(&mut BufReader::new(File::open(self.folder_of(id).join(PICTURE))?))
    }

    /// The text of a scene that a job needs.
    pub(crate) fn scene(&self, name: &str) -> Option<Vec<u8>> {
        self.scenes.get(name)
    }

    /// Its last preview, a PNG; jobs whose picture was there already have none.
    pub(crate) fn last_preview(&self, id: &str) -> io::Result<Vec<u8>> {
        fs::read(self.folder_of(id).join(PREVIEW))
    }

    /// Opens no more jobs. Those that are open are suspended if another process can go on with them.
    pub(crate) fn close(&self) {
        let mut registry = locked(&self.registry);
        registry.closing = true;
        if self.is_durable {
            registry.open.iter().for_each(|job| job.stop(Stopped::Suspended));
        }
    }

    /// Waits until no job is open.
    pub(crate) async fn idle(&self) {
        // It fails only without a sender, and `self` is one.
        let _ = self.open.subscribe().wait_for(|open| *open == 0).await;
    }

    fn folder_of(&self, id: &str) -> PathBuf {
        self.folder.join("jobs").join(id)
    }

    /// Writes a file completely or not at all.
    fn write(&self, folder: &Path, name: &str, contents: &[u8]) -> io::Result<()> {
        let unfinished = folder.join(format!("{name}~"));
        fs::write(&unfinished, contents)?;
        fs::rename(unfinished, folder.join(name))
    }

    fn save(&self, job: &Job) -> io::Result<()> {
        let record = job.record().clone();
        self.store.put(&record)
    }

    /// A job has reached its final state.
    fn finish(&self, job: &Job, state: State, failure: Option<Failure>) {
        let (id, data) = {
            let mut record = job.record();
            record.finished = Some(now());
            record.failure = failure;
            record.last_event = Some(job.events.last() + 1);
            record.stats.rays = record.stats.rays.max(job.rays.load(Ordering::Relaxed));
            (record.id.clone(), serde_json::json!({ "stats": record.stats, "failure": record.failure }))
        };
        if state != State::Succeeded {
            self.remove_files(&id);
        }
        // On disk before anybody hears of it.
        let on_disk = Record { state, ..job.record().clone() };
        if let Err(error) = self.store.put(&on_disk) {
            tracing::error!(job = id, %error, "a record cannot be written");
        }
        let _ = fs::remove_file(self.folder_of(&id).join("tiles"));
        job.record().state = state;
        if state == State::Succeeded {
            self.weigh(job);
        } else {
            locked(&self.registry).release_scene(&on_disk.order, &self.scenes);
        }
        if let (false, Some((begun, _))) = (state == State::Succeeded, *locked(&job.begun)) {
            self.canceled.fetch_add(milliseconds(begun) as u64, Ordering::Relaxed);
        }
        self.host.ended(&on_disk, state);
        tracing::info!(job = id, state = state.name(), "a job has ended");
        job.events.publish(state.name(), data);
    }

    /// Opens the jobs that are next, as far as there is room.
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
        // Who watches a waiting job sees it move up.
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
        drop(registry);
        self.open_next();
    }
}
