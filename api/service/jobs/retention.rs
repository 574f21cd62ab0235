//! Retention: old pictures and records are deleted, and the oldest pictures first where disk space runs out.
//!
//! Texts of scenes may take half of the space, and files of open jobs the other half. So there is room for every accepted
//! job once finished pictures have been deleted.

use super::Jobs;
use super::job::{Job, Stopped, locked};
use super::record::{Failure, Record, State, now};
use super::registry::Registry;
use crate::service::limits::JobLimits;
use std::fs;
use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

impl Jobs {
    /// Called once a second: stops jobs that run too long, and deletes what is too old or too much.
    pub(crate) fn tick(&self) {
        let now = now();
        let (mut expired, mut forgotten) = (Vec::new(), Vec::new());
        {
            let registry = locked(&self.registry);
            for job in &registry.open {
                let begun = *locked(&job.begun);
                if begun.is_some_and(|(begun, _)| begun.elapsed() > self.limits.job_timeout) {
                    let seconds = self.limits.job_timeout.as_secs_f64();
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
                    State::Expired if is_over(*keep_pictures + *keep_records) => forgotten.push(record.id.clone()),
                    State::Failed | State::Canceled if is_over(*keep_records) => forgotten.push(record.id.clone()),
                    _ => {}
                }
            }
        }
        expired.iter().for_each(|job| self.expire(job));
        self.forget_all(&forgotten);
        self.make_room();
    }

    /// Deletes the oldest pictures until there is room for the files of open jobs.
    pub(super) fn make_room(&self) {
        self.expire_until(|registry| {
            let written: u64 = registry.open.iter().map(|job| disk_of(&job.record())).sum();
            self.scenes.bytes() + registry.kept() + written <= self.limits.data_bytes
        });
    }

    /// Deletes the oldest pictures until there is room for another scene. False if there is none.
    pub(super) fn make_room_for_scene(&self, bytes: u64) -> bool {
        self.expire_until(|_| self.scenes.bytes() + bytes <= self.limits.data_bytes / 2)
    }

    /// Deletes pictures, the oldest first, until `is_enough`. False if it never is.
    fn expire_until(&self, is_enough: impl Fn(&Registry) -> bool) -> bool {
        let mut oldest: Vec<(Option<u64>, Arc<Job>)> = {
            let registry = locked(&self.registry);
            if is_enough(&registry) {
                return true;
            }
            let finished = |job: &Arc<Job>| {
                let record = job.record();
                (record.state == State::Succeeded).then(|| (record.finished, Arc::clone(job)))
            };
            registry.jobs.values().filter_map(finished).collect()
        };
        oldest.sort_by_key(|(finished, _)| *finished);
        oldest.iter().any(|(_, job)| {
            tracing::info!(job = job.record().id, "a picture is deleted to make room (data_bytes)");
            self.expire(job);
            is_enough(&locked(&self.registry))
        })
    }

    /// Deletes a picture, and its scene if no other job needs it.
    fn expire(&self, job: &Job) {
        let record = {
            let mut record = job.record();
            if record.state != State::Succeeded {
                return;
            }
            record.state = State::Expired;
            record.clone()
        };
        self.remove_files(&record.id);
        job.kept.store(0, Ordering::Relaxed);
        locked(&self.registry).release_scene(&record.spec, &self.scenes);
        if let Err(error) = self.store.put(&record) {
            tracing::error!(job = record.id, %error, "a record cannot be written");
        }
    }

    /// Deletes jobs that have ended.
    pub(super) fn forget_all(&self, ids: &[String]) {
        if ids.is_empty() {
            return;
        }
        if let Err(error) = self.store.remove(ids) {
            tracing::error!(%error, "records cannot be removed");
        }
        ids.iter().for_each(|id| self.remove_files(id));
        let mut registry = locked(&self.registry);
        for id in ids {
            let Some(job) = registry.remove(id) else { continue };
            let record = job.record();
            if record.state.needs_scene() {
                registry.release_scene(&record.spec, &self.scenes);
            }
        }
    }

    /// Removes a record from disk.
    pub(super) fn forget_record(&self, id: &str) {
        if let Err(error) = self.store.remove(&[id.to_owned()]) {
            tracing::error!(job = id, %error, "a record cannot be removed");
        }
    }

    /// Deletes files without a record, which a crash has left behind.
    pub(super) fn remove_orphans(&self) {
        let registry = locked(&self.registry);
        let folders = fs::read_dir(self.folder.join("jobs")).into_iter().flatten().flatten();
        let names: Vec<String> = folders.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.iter().filter(|id| !registry.jobs.contains_key(*id)).for_each(|id| self.remove_files(id));
        for name in self.scenes.names().iter().filter(|name| !registry.scenes.contains_key(*name)) {
            self.scenes.remove(name);
        }
    }

    pub(super) fn remove_files(&self, id: &str) {
        if let Err(error) = fs::remove_dir_all(self.folder_of(id))
            && error.kind() != io::ErrorKind::NotFound
        {
            tracing::warn!(job = id, %error, "a job's files cannot be removed");
        }
    }

    /// Measures the files of a job.
    pub(super) fn measure_files(&self, job: &Job) {
        let files = fs::read_dir(self.folder_of(&job.record().id)).into_iter().flatten().flatten();
        let bytes = files.filter_map(|file| Some(file.metadata().ok()?.len())).sum();
        job.kept.store(bytes, Ordering::Relaxed);
    }
}

/// Most bytes that an open job writes to disk: its tiles with their bounds, its picture in the largest format with its cost
/// report, and its preview.
pub(crate) fn disk_of(record: &Record) -> u64 {
    (64 << 10) + u64::from(record.width) * u64::from(record.height) * 46
}
