//! Retention: old pictures and records are deleted, and pictures where disk space runs out: the oldest ones of the tenant that
//! has most.
//!
//! Texts of scenes may take half of the space, and files of open jobs the other half. So there is room for every accepted
//! job once finished pictures have been deleted.

use super::Jobs;
use super::disk_shares::{DiskShares, Kinds};
use super::job::{Job, Stopped};
use super::record::{Failure, Record, State};
use super::registry::Registry;
use crate::service::ANONYMOUS;
use crate::service::limits::JobLimits;
use std::collections::HashMap;
use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use strahl::film::FileFormat;

/// Milliseconds after the end of a job for which its events are kept. Who comes later is told how it ended.
const EVENTS_KEPT: u64 = 60_000;
/// Milliseconds between two notes of how long services have run, while nothing else is written.
const TIME_KEPT: u64 = 60_000;

impl Jobs {
    /// Called once a second: stops jobs that run too long, and deletes what is too old or too much.
    pub(crate) fn tick(&self) {
        let now = self.records.time();
        let is_empty = self.registry.lock().jobs.is_empty();
        let is_due = !is_empty && now >= self.time_kept.load(Ordering::Relaxed) + TIME_KEPT;
        // Records that could not be written tell by this when they can be again.
        if is_due || self.records.is_failing() {
            self.time_kept.store(now, Ordering::Relaxed);
            if let Err(error) = self.records.keep_time() {
                tracing::error!(%error, "how long the service has run cannot be written down");
            }
        }
        if self.files_fail.load(Ordering::Relaxed) && self.files.are_writable() {
            self.files_fail.store(false, Ordering::Relaxed);
        }
        let are_gone = !self.files.are_there();
        let were_gone = self.folders_are_gone.swap(are_gone, Ordering::Relaxed);
        if are_gone && !were_gone {
            tracing::error!("the folders with the files of jobs are gone: put them back, or start the service again");
        }
        let (mut expired, mut forgotten) = (Vec::new(), Vec::new());
        {
            let registry = self.registry.lock();
            let mut ended: HashMap<String, usize> = HashMap::new();
            for job in &registry.open {
                let begun = *job.begun.lock();
                if begun.is_some_and(|begun| begun.elapsed() > self.limits.job_timeout) {
                    let seconds = self.limits.job_timeout.as_secs_f64();
                    let detail = format!("the job was not done after {seconds} s (job_timeout)");
                    job.stop(Stopped::Failed(Failure { slug: "render-deadline".into(), detail }));
                }
            }
            for job in registry.jobs.values().rev() {
                let record = job.record();
                let Some(kept) = self.kept_for(&record) else { continue };
                let newer = ended.entry(record.tenant.clone()).or_default();
                *newer += 1;
                if *newer > self.limits.keep_jobs as usize {
                    forgotten.push(Arc::clone(job));
                } else if kept.is_zero() && record.state == State::Succeeded {
                    expired.push(Arc::clone(job));
                } else if kept.is_zero() {
                    forgotten.push(Arc::clone(job));
                } else if record.ended.is_some_and(|ended| now >= ended + EVENTS_KEPT) {
                    job.rest();
                }
            }
        }
        expired.iter().for_each(|job| self.expire(job));
        if let Err(error) = self.forget_all(&forgotten) {
            tracing::error!(%error, "records of old jobs cannot be removed");
        }
        self.make_room();
        self.remove_leftovers();
        self.tell_late_ends();
    }

    /// How long a job that has ended is kept from now on: with its picture if it has one. The time that no service runs does
    /// not count.
    pub(crate) fn kept_for(&self, record: &Record) -> Option<Duration> {
        let age = Duration::from_millis(self.records.time().saturating_sub(record.ended?));
        let JobLimits { keep_pictures, keep_records, .. } = self.limits;
        let kept = match record.state {
            State::Succeeded => keep_pictures,
            State::Expired => keep_pictures + keep_records,
            State::Failed | State::Canceled => keep_records,
            State::Queued | State::Running => return None,
        };
        Some(kept.saturating_sub(age))
    }

    /// Deletes pictures until there is room for the files of open jobs.
    pub(super) fn make_room(&self) {
        let budget = self.limits.data_bytes;
        let shares = |registry: &Registry| DiskShares::of(registry, &self.files, Kinds::All, budget, None);
        self.expire_until(shares, |registry| {
            let written: u64 = registry.open.iter().map(|job| disk_of(&job.record())).sum();
            self.files.bytes() + written <= budget
        });
    }

    /// Whether a tenant may have another scene of a job that waits. As those cannot be deleted, it leaves some room to others.
    pub(super) fn may_wait_with(&self, tenant: &str, bytes: u64) -> bool {
        let budget = self.limits.data_bytes / 2;
        // Without keys there are no others.
        if tenant == ANONYMOUS || self.files.scenes.bytes() + bytes <= budget / 2 {
            return true;
        }
        let shares = DiskShares::of(&self.registry.lock(), &self.files, Kinds::Scenes, budget, None);
        bytes <= shares.room_for_waiting(tenant)
    }

    /// Deletes pictures until there is room for another scene of a tenant. False if there is none.
    pub(super) fn make_room_for_scene(&self, tenant: &str, bytes: u64) -> bool {
        let (wanted, budget) = (Some((tenant, bytes)), self.limits.data_bytes / 2);
        let shares = |registry: &Registry| DiskShares::of(registry, &self.files, Kinds::Scenes, budget, wanted);
        self.expire_until(shares, |_| self.files.scenes.bytes() + bytes <= budget)
    }

    /// Deletes pictures, those of the tenant that has most first, until `is_enough`. False if it never is.
    fn expire_until(&self, shares: impl Fn(&Registry) -> DiskShares, is_enough: impl Fn(&Registry) -> bool) -> bool {
        let mut shares = {
            let registry = self.registry.lock();
            if is_enough(&registry) || (self.remove_orphans(&registry, Duration::ZERO).0 > 0 && is_enough(&registry)) {
                return true;
            }
            shares(&registry)
        };
        while let Some(job) = shares.next() {
            tracing::info!(job = job.record().id, "a picture is deleted to make room (data_bytes)");
            self.expire(&job);
            if is_enough(&self.registry.lock()) {
                return true;
            }
        }
        false
    }

    /// Deletes a picture, and its scene if no other job needs it.
    fn expire(&self, job: &Arc<Job>) {
        let expired = self.change(job, |record| {
            let has_picture = record.has_picture();
            record.state = State::Expired;
            record.front = self.records.front().map(str::to_owned);
            has_picture
        });
        if let Err(error) = expired {
            tracing::error!(job = job.record().id, %error, "a record cannot be written");
        }
    }

    /// Deletes jobs that have ended. Without their records they would come back, so those go first.
    pub(super) fn forget_all(&self, jobs: &[Arc<Job>]) -> io::Result<()> {
        if jobs.is_empty() {
            return Ok(());
        }
        if self.records.front().is_some() {
            let marked: Vec<_> = jobs.iter().map(|job| self.mark_forgotten(job).map(drop)).collect();
            return marked.into_iter().collect();
        }
        self.records.remove(jobs)?;
        self.drop_all(jobs);
        Ok(())
    }

    /// Drops jobs whose records are gone.
    pub(super) fn drop_all(&self, jobs: &[Arc<Job>]) {
        let ids: Vec<String> = jobs.iter().map(|job| job.record().id.clone()).collect();
        self.files.remove_tiles_of(&ids);
        let mut registry = self.registry.lock();
        for id in ids {
            let Some(job) = registry.remove(&id) else { continue };
            let record = job.record().clone();
            registry.release_files(&record, &self.files);
        }
    }
}

/// Most bytes that an open job has yet to write to disk: its tiles with their bounds, its picture in the largest format with its
/// cost report, and its preview. A sequence has the tiles of one frame at a time, and pictures of all.
pub(crate) fn disk_of(record: &Record) -> u64 {
    let pixels = u64::from(record.width) * u64::from(record.height);
    let left = record.frames.map_or(0, |frames| u64::from(frames.count - frames.done).saturating_sub(1));
    (64 << 10) + pixels * 46 + left * ((64 << 10) + pixels * pixel_of(record.spec.output))
}

/// Bytes that a pixel of a frame takes at most in a file, with alpha, and a little more for its small picture.
fn pixel_of(output: FileFormat) -> u64 {
    match output {
        FileFormat::Png8 | FileFormat::WebP | FileFormat::Jpeg(_) => 6,
        FileFormat::Png16 => 10,
        FileFormat::Pfm => 14,
        FileFormat::Exr => 20,
    }
}
