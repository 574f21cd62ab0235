//! What there is to know of jobs, without changing any.

use super::Jobs;
use super::job::{Job, locked};
use super::record::{Record, State};
use super::registry::{estimate, rank, remaining};
use std::fs;
use std::io;
use std::ops::Bound;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

impl Jobs {
    /// A tenant's job.
    pub(crate) fn find(&self, tenant: &str, id: &str) -> Option<Arc<Job>> {
        locked(&self.registry).jobs.get(id).filter(|job| job.record().tenant == tenant).map(Arc::clone)
    }

    /// A tenant's jobs after an id, the newest first, as far as `wanted` says so.
    pub(crate) fn list(
        &self,
        tenant: &str,
        before: Option<&str>,
        limit: usize,
        wanted: impl Fn(&Record) -> bool,
    ) -> Vec<Arc<Job>> {
        let registry = locked(&self.registry);
        let older = registry.jobs.range::<str, _>((Bound::Unbounded, before.map_or(Bound::Unbounded, Bound::Excluded)));
        let mine = |job: &&Arc<Job>| {
            let record = job.record();
            record.tenant == tenant && wanted(&record)
        };
        older.rev().map(|(_, job)| job).filter(mine).take(limit).map(Arc::clone).collect()
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

    /// The picture of a job that has succeeded.
    pub(crate) fn picture(&self, id: &str) -> io::Result<Vec<u8>> {
        fs::read(self.folder_of(id).join("picture"))
    }

    /// The text of a scene that a job needs.
    pub(crate) fn scene(&self, name: &str) -> Option<Vec<u8>> {
        self.scenes.get(name)
    }

    /// Its last preview, a PNG.
    pub(crate) fn last_preview(&self, id: &str) -> io::Result<Vec<u8>> {
        fs::read(self.folder_of(id).join("preview"))
    }
}
