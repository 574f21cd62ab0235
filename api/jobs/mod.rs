//! Jobs: pictures that nobody has to wait for. Accepted jobs survive any end of the process, finished tiles included.
//!
//! The folder holds `jobs.redb` (records), `scenes/` (texts by their hash, shared by all jobs that render them) and
//! `jobs/ID/`: `tiles` while the job is rendered, `picture` (with its cost report) and `preview` afterwards.

mod canvas;
mod events;
mod job;
mod order;
pub(crate) mod record;
mod report;
mod run;
mod store;
mod submit;
mod tiles;

pub(crate) use canvas::PREVIEW_SIDE;
pub(crate) use events::Event;
pub(crate) use job::{Job, Stopped, Watcher};
pub(crate) use submit::{Claim, Known, Refused, Submission};

use crate::blobs::Blobs;
use crate::made::{About, Made};
use crate::ready::Ready;
use crate::turns::aged;
use crate::workers::{Pool, Workers};
use job::locked;
use record::{Failure, Order, Record, State, now};
use std::collections::{BTreeMap, HashMap};
use std::fs::{self, File};
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;
use store::Store;
use strahl::film::FileFormat;
use strahl::scene::{Format, Overrides};
use tokio::sync::watch;

/// Jobs of one tenant that are open at one time: one renders while another encodes its picture.
const OPEN: usize = 2;
/// Likewise, counting those that were opened for their higher priority.
const MOST_OPEN: usize = 4;
/// Open jobs of all tenants.
const ALL_OPEN: usize = 64;

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

    /// Work on a tenant's job has ended in this process, after so many rays; `stopped` if there is no picture.
    fn worked(&self, tenant: &str, stopped: Option<&Stopped>, rays: u64);
}

/// Limits on jobs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JobLimits {
    /// Jobs that wait or run.
    pub(crate) jobs: usize,
    /// Bytes that open jobs may take together.
    pub(crate) memory_bytes: u64,
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
}

impl std::fmt::Debug for Jobs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Jobs").field("folder", &self.folder).field("limits", &self.limits).finish_non_exhaustive()
    }
}

#[derive(Debug, Default)]
struct Registry {
    jobs: BTreeMap<String, Arc<Job>>,
    queued: Vec<Arc<Job>>,
    open: Vec<Arc<Job>>,
    /// Jobs by tenant and idempotency key; none while the job is being accepted.
    keys: HashMap<(String, String), Option<String>>,
    /// How many jobs need each scene.
    scenes: HashMap<String, usize>,
    /// Whether no more jobs are opened.
    closing: bool,
    /// How many times as long as estimated jobs take: a moving average.
    slowness: Option<f64>,
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
        for mut record in store.all()? {
            if !record.state.is_final() {
                record.state = State::Queued;
                record.lives += 1;
                store.put(&record)?;
            }
            registry.add(&Arc::new(Job::new(record)));
        }
        remove_strays(&folder.join("jobs"), |id| registry.jobs.contains_key(id))?;
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
        });
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
            (record.scene_id.as_deref() == Some(scene_id)).then(|| record.order.clone())
        };
        registry.jobs.values().find_map(same)
    }

    /// The picture of some job that is the whole of this image in this format.
    pub(crate) fn picture_of(&self, image_id: &str, format: FileFormat) -> Option<Made> {
        let registry = locked(&self.registry);
        let same = |job: &Arc<Job>| {
            let record = job.record();
            let same = record.image_id.as_deref() == Some(image_id) && record.order.output == format;
            (same && record.state == State::Succeeded).then(|| record.id.clone())
        };
        let ids: Vec<String> = registry.jobs.values().filter_map(same).collect();
        drop(registry);
        // One that has just been forgotten is as good as none.
        ids.iter().find_map(|id| self.picture(id).ok())
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
        let record = job.record().clone();
        self.forget_all(&[record]);
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

    /// What happens once a second: jobs that run too long are stopped, what is too old goes.
    pub(crate) fn tick(&self) {
        let now = now();
        let (mut expired, mut forgotten) = (Vec::new(), Vec::new());
        {
            let registry = locked(&self.registry);
            for job in &registry.open {
                let begun = *locked(&job.begun);
                if begun.is_some_and(|(begun, _)| begun.elapsed() > self.limits.timeout) {
                    let seconds = self.limits.timeout.as_secs_f64();
                    let detail = format!("the job was not done after {seconds} s (job_timeout)");
                    job.stop(Stopped::Failed(Failure { slug: "render-deadline".into(), detail }));
                }
            }
            for job in registry.jobs.values() {
                let record = job.record();
                let Some(finished) = record.finished else { continue };
                let is_over = |kept: Duration| now.saturating_sub(finished) >= kept.as_millis() as u64;
                let Self { limits: JobLimits { keep_pictures, keep_records, .. }, .. } = self;
                match record.state {
                    State::Succeeded if is_over(*keep_pictures) => expired.push(Arc::clone(job)),
                    State::Expired if is_over(*keep_pictures + *keep_records) => forgotten.push(record.clone()),
                    State::Failed | State::Canceled if is_over(*keep_records) => forgotten.push(record.clone()),
                    _ => {}
                }
            }
        }
        for job in expired {
            job.record().state = State::Expired;
            let id = job.record().id.clone();
            self.remove_files(&id);
            if let Err(error) = self.save(&job) {
                tracing::error!(job = id, %error, "a record cannot be written");
            }
        }
        self.forget_all(&forgotten);
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

    fn forget_all(&self, records: &[Record]) {
        if records.is_empty() {
            return;
        }
        let ids: Vec<String> = records.iter().map(|record| record.id.clone()).collect();
        if let Err(error) = self.store.remove(&ids) {
            tracing::error!(%error, "records cannot be removed");
        }
        ids.iter().for_each(|id| self.remove_files(id));
        let mut registry = locked(&self.registry);
        for record in records {
            if registry.jobs.remove(&record.id).is_none() {
                continue;
            }
            if let Some(same) = &record.idempotency {
                registry.keys.remove(&(record.tenant.clone(), same.key.clone()));
            }
            registry.release_scene(&record.order, &self.scenes);
        }
    }

    fn remove_files(&self, id: &str) {
        if let Err(error) = fs::remove_dir_all(self.folder_of(id))
            && error.kind() != io::ErrorKind::NotFound
        {
            tracing::warn!(job = id, %error, "a job's files cannot be removed");
        }
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
        tracing::info!(job = id, state = state.name(), "a job has ended");
        job.events.publish(state.name(), data);
    }

    /// Opens the jobs that are next, as far as there is room.
    fn open_next(self: &Arc<Self>) {
        let mut registry = locked(&self.registry);
        while let Some(at) = registry.next_to_open(self.limits.memory_bytes) {
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

impl Registry {
    /// Takes a job in, from disk or new.
    fn add(&mut self, job: &Arc<Job>) {
        let record = job.record();
        *self.scenes.entry(record.order.scene.clone()).or_default() += 1;
        if let Some(same) = &record.idempotency {
            self.keys.insert((record.tenant.clone(), same.key.clone()), Some(record.id.clone()));
        }
        if !record.state.is_final() {
            self.queued.push(Arc::clone(job));
        }
        self.jobs.insert(record.id.clone(), Arc::clone(job));
    }

    fn release_scene(&mut self, order: &Order, scenes: &Blobs) {
        let Some(count) = self.scenes.get_mut(&order.scene) else { return };
        *count -= 1;
        if *count == 0 {
            self.scenes.remove(&order.scene);
            scenes.remove(&order.scene);
        }
    }

    /// Which of the waiting jobs is opened next; none if none can be.
    fn next_to_open(&self, memory: u64) -> Option<usize> {
        if self.closing || self.open.len() >= ALL_OPEN {
            return None;
        }
        let mut open: HashMap<String, (usize, u8)> = HashMap::new();
        for job in &self.open {
            let record = job.record();
            let (count, priority) = open.entry(record.tenant.clone()).or_default();
            *count += 1;
            *priority = record.priority.max(*priority);
        }
        let taken: u64 = self.open.iter().map(|job| memory_of(&job.record())).sum();
        let may_open = |(_, job): &(usize, &Arc<Job>)| {
            let record = job.record();
            let (count, priority) = open.get(&record.tenant).copied().unwrap_or_default();
            let has_place = count < OPEN || (count < MOST_OPEN && record.priority > priority);
            has_place && (self.open.is_empty() || taken + memory_of(&record) <= memory)
        };
        let few = |job: &Arc<Job>| open.get(&job.record().tenant).map_or(0, |(count, _)| *count);
        let first = |(_, a): &(usize, &Arc<Job>), (_, b): &(usize, &Arc<Job>)| {
            few(b).cmp(&few(a)).then_with(|| rank(a).partial_cmp(&rank(b)).unwrap_or(std::cmp::Ordering::Equal))
        };
        self.queued.iter().enumerate().filter(may_open).max_by(first).map(|(at, _)| at)
    }
}

/// Removes folders of jobs that there is no record of: a kill came between the two.
fn remove_strays(folder: &Path, is_known: impl Fn(&str) -> bool) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if !is_known(&entry.file_name().to_string_lossy()) {
            fs::remove_dir_all(entry.path())?;
        }
    }
    Ok(())
}

/// Greater goes first among the jobs of a tenant.
fn rank(job: &Arc<Job>) -> (f64, std::cmp::Reverse<String>) {
    let record = job.record();
    (aged(record.priority, job.since), std::cmp::Reverse(record.id.clone()))
}

/// Bytes that an open job takes: its scene, its pixels as floats and as codes, what they lack at most, and its file.
pub(crate) fn memory_of(record: &Record) -> u64 {
    record.scene_bytes + u64::from(record.width) * u64::from(record.height) * 44
}

fn estimate(job: &Arc<Job>) -> f64 {
    job.record().estimate_ms
}

fn remaining(job: &Arc<Job>) -> f64 {
    let progress = job.progress();
    estimate(job) * (progress.total - progress.done) as f64 / progress.total.max(1) as f64
}
