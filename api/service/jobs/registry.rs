//! All jobs in memory, and which of the waiting ones is opened next.

use super::files::Files;
use super::job::Job;
use super::record::Record;
use super::references::References;
use super::retention::disk_of;
use crate::service::limits::JobLimits;
use crate::service::pictures::render::PIXEL_BYTES;
use crate::service::scheduler::task::aged;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;
use std::time::Instant;
use tokio::sync::watch;

/// Open jobs of one tenant: one renders while another encodes its picture.
const OPEN: usize = 2;
/// Open jobs of one tenant, counting those opened for their higher priority.
const MOST_OPEN: usize = 4;
/// Open jobs of all tenants.
const ALL_OPEN: usize = 64;

/// Numbers of jobs that wait or run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Unfinished {
    /// Those of one tenant.
    pub(super) of_tenant: usize,
    pub(super) all: usize,
}

/// All jobs.
#[derive(Debug, Default)]
pub(super) struct Registry {
    pub(super) jobs: BTreeMap<String, Arc<Job>>,
    pub(super) queued: Vec<Arc<Job>>,
    pub(super) open: Vec<Arc<Job>>,
    /// Jobs that other fronts work on.
    pub(super) elsewhere: Vec<Arc<Job>>,
    /// Jobs whose owners do not want to see them any more, and which have yet to leave.
    pub(super) leaving: BTreeMap<String, Arc<Job>>,
    /// Jobs that are being accepted, and what was before each when its record came back from the broker.
    pub(super) submitting: HashMap<String, Option<Unfinished>>,
    /// Job ids by tenant and idempotency key. None while a job is being accepted.
    pub(super) keys: HashMap<(String, String), Option<String>>,
    /// Ids of jobs that have ended and have something to deliver.
    pub(super) outgoing: BTreeSet<String>,
    /// Scenes that jobs need.
    pub(super) scenes: References,
    /// Pictures that jobs have.
    pub(super) pictures: References,
    /// Whether the service is shutting down, so that no more jobs are opened.
    pub(super) closing: bool,
    /// Whether there are more jobs than are here yet, so that none is opened.
    pub(super) loading: bool,
    /// Time of jobs divided by their estimates: a moving average.
    pub(super) slowness: Option<f64>,
    /// Changes when jobs come and go.
    pub(super) changes: watch::Sender<u64>,
}

impl Registry {
    /// Adds a job, from where records live, or a new one.
    pub(super) fn add(&mut self, job: &Arc<Job>) {
        let record = job.record().clone();
        if record.forgotten {
            self.leaving.insert(record.id, Arc::clone(job));
            return;
        }
        if self.submitting.contains_key(&record.id) {
            let before = self.unfinished(&record.tenant);
            self.submitting.insert(record.id.clone(), Some(before));
        }
        if record.needs_scene() {
            self.scenes.add(&record.spec.scene);
        }
        if record.has_pictures() {
            record.picture_names().iter().for_each(|name| self.pictures.add(name));
        }
        if let Some(same) = &record.idempotency {
            self.keys.insert((record.tenant.clone(), same.key.clone()), Some(record.id.clone()));
        }
        self.line_up(job, &record);
        self.jobs.insert(record.id.clone(), Arc::clone(job));
        self.look_for_deliveries(&record);
        self.changes.send_modify(|changes| *changes += 1);
    }

    /// Puts a job that has not ended, and that this process does not work on, to those that wait or that others work on.
    fn line_up(&mut self, job: &Arc<Job>, record: &Record) {
        if !record.state.is_final() {
            let line = if record.front.is_none() { &mut self.queued } else { &mut self.elsewhere };
            line.push(Arc::clone(job));
        }
    }

    /// Follows a job whose record was another one before.
    pub(super) fn follow(&mut self, job: &Arc<Job>, before: &Record, files: &Files) {
        let record = job.record().clone();
        if record.has_pictures() && !before.has_pictures() {
            record.picture_names().iter().for_each(|name| self.pictures.add(name));
        }
        if record.has_picture() && !before.has_picture() {
            files.learn(&record);
        }
        if before.has_pictures() && !record.has_pictures() {
            self.release_pictures(before, files);
        }
        if before.needs_scene() && !record.needs_scene() {
            self.release_scene(before, files);
        }
        if !self.is_open(job) {
            self.queued.retain(|other| !Arc::ptr_eq(other, job));
            self.elsewhere.retain(|other| !Arc::ptr_eq(other, job));
            self.line_up(job, &record);
        }
        self.look_for_deliveries(&record);
        if record.forgotten && !before.forgotten {
            if before.state.is_final() {
                job.rest();
            }
            self.remove(&record.id);
            self.leaving.insert(record.id, Arc::clone(job));
        }
    }

    /// Keeps the list of jobs with something to deliver as their records are.
    fn look_for_deliveries(&mut self, record: &Record) {
        if record.next_delivery().is_some() && self.jobs.contains_key(&record.id) {
            self.outgoing.insert(record.id.clone());
        } else {
            self.outgoing.remove(&record.id);
        }
    }

    /// Whether this process works on a job.
    pub(super) fn is_open(&self, job: &Arc<Job>) -> bool {
        self.open.iter().any(|open| Arc::ptr_eq(open, job))
    }

    /// The job is not open any more.
    pub(super) fn close(&mut self, job: &Arc<Job>) {
        self.open.retain(|open| !Arc::ptr_eq(open, job));
        let record = job.record().clone();
        if !record.state.is_final() {
            job.reset();
            self.line_up(job, &record);
        }
    }

    /// Jobs that wait or run, wherever.
    pub(super) fn all_unfinished(&self) -> impl Iterator<Item = &Arc<Job>> {
        self.queued.iter().chain(&self.open).chain(&self.elsewhere)
    }

    /// How many there are, of a tenant and of all.
    pub(super) fn unfinished(&self, tenant: &str) -> Unfinished {
        let of_tenant = self.all_unfinished().filter(|job| job.record().tenant == tenant).count();
        Unfinished { of_tenant, all: self.queued.len() + self.open.len() + self.elsewhere.len() }
    }

    /// Jobs that are worked on, here or elsewhere.
    pub(super) fn running(&self) -> impl Iterator<Item = &Arc<Job>> {
        self.open.iter().chain(&self.elsewhere)
    }

    /// Lets jobs wait again whose fronts are gone.
    pub(super) fn line_up_orphans(&mut self, is_alive: impl Fn(&str) -> bool) {
        let is_orphan = |job: &mut Arc<Job>| job.record().front.as_deref().is_some_and(|front| !is_alive(front));
        self.queued.extend(self.elsewhere.extract_if(.., is_orphan));
    }

    /// Nobody finds a job any more.
    pub(super) fn remove(&mut self, id: &str) -> Option<Arc<Job>> {
        let job = self.jobs.remove(id)?;
        self.outgoing.remove(id);
        let record = job.record();
        if let Some(same) = &record.idempotency {
            self.keys.remove(&(record.tenant.clone(), same.key.clone()));
        }
        drop(record);
        self.changes.send_modify(|changes| *changes += 1);
        Some(job)
    }

    /// The part of the farm that an open job of a tenant may have: tenants share it by weight, and jobs of a tenant equally.
    pub(super) fn share(&self, tenant: &str) -> f64 {
        let mut weights: HashMap<String, (f64, f64)> = HashMap::new();
        for open in self.running() {
            let open = open.record();
            let (weight, jobs) = weights.entry(open.tenant.clone()).or_default();
            *weight = f64::from(open.weight.max(1));
            *jobs += 1.0;
        }
        let all: f64 = weights.values().map(|(weight, _)| weight).sum();
        weights.get(tenant).map_or(1.0, |(weight, jobs)| weight / all / jobs)
    }

    /// Index of the waiting job that is opened next, if one can be.
    pub(super) fn next_to_open(&self, limits: &JobLimits, is_for_others: impl Fn(&Record) -> bool) -> Option<usize> {
        if self.closing || self.loading || self.open.len() >= ALL_OPEN {
            return None;
        }
        let mut open: HashMap<String, (usize, u8)> = HashMap::new();
        for job in self.running() {
            let record = job.record();
            let (count, priority) = open.entry(record.tenant.clone()).or_default();
            *count += 1;
            *priority = record.priority.max(*priority);
        }
        let taken = |of: fn(&Record) -> u64| self.open.iter().map(|job| of(&job.record())).sum::<u64>();
        let (memory, disk) = (taken(memory_of), taken(disk_of));
        let may_open = |(_, job): &(usize, &Arc<Job>)| {
            let record = job.record();
            let (count, priority) = open.get(&record.tenant).copied().unwrap_or_default();
            let has_place = count < OPEN || (count < MOST_OPEN && record.priority > priority);
            let fits = memory + memory_of(&record) <= limits.job_memory_bytes
                && disk + disk_of(&record) <= limits.data_bytes / 2;
            has_place && (self.open.is_empty() || fits) && !is_for_others(&record)
        };
        let few = |job: &Arc<Job>| open.get(&job.record().tenant).map_or(0, |(count, _)| *count);
        let now = Instant::now();
        let first = |(_, a): &(usize, &Arc<Job>), (_, b): &(usize, &Arc<Job>)| {
            let ranked = || rank(a, now).partial_cmp(&rank(b, now)).unwrap_or(std::cmp::Ordering::Equal);
            few(b).cmp(&few(a)).then_with(ranked)
        };
        self.queued.iter().enumerate().filter(may_open).max_by(first).map(|(at, _)| at)
    }
}

/// Order among the jobs of a tenant: the greatest rank is opened first.
pub(super) fn rank(job: &Arc<Job>, now: Instant) -> (f64, std::cmp::Reverse<String>) {
    let record = job.record();
    (aged(record.priority, job.since, now), std::cmp::Reverse(record.id.clone()))
}

/// Memory of an open job in bytes: its scene, its pixels as floats and as codes, their bounds, and its file. Of a sequence one
/// frame is written while the next one is rendered.
pub(super) fn memory_of(record: &Record) -> u64 {
    record.scene_bytes + pixel_bytes(record)
}

/// Bytes that its picture takes.
pub(super) fn pixel_bytes(record: &Record) -> u64 {
    let frames = if record.frames.is_some() { 2 } else { 1 };
    u64::from(record.width) * u64::from(record.height) * PIXEL_BYTES * frames
}

/// Estimated milliseconds of a job.
pub(super) fn estimate(job: &Arc<Job>) -> f64 {
    job.record().estimate_ms
}

/// Estimated milliseconds that are left of a job.
pub(super) fn remaining(job: &Arc<Job>) -> f64 {
    let progress = job.progress();
    estimate(job) * (progress.total - progress.done) as f64 / progress.total.max(1) as f64
}
