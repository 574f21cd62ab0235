//! What jobs leave behind that other fronts know of, too: their records and files go some time after the last job that needs
//! them. Another front that has just accepted a job with the same scene may not have told this one yet.

use super::Jobs;
use super::event_log::before_life;
use super::job::{Job, Stopped};
use super::record::{Record, State, now};
use std::io;
use std::sync::Arc;
use std::time::Duration;

/// Time until what a job leaves behind goes.
const GRACE: Duration = Duration::from_secs(60);

impl Jobs {
    /// Lets nobody see a job any more. Its record goes when what it leaves behind is gone.
    pub(super) fn mark_forgotten(&self, job: &Arc<Job>) -> io::Result<bool> {
        let was_unfinished = !job.record().state.is_final();
        let marked = self.change(job, |record| {
            let is_seen = !record.forgotten;
            if !record.state.is_final() {
                record.lives += 1;
                record.state = State::Canceled;
                record.finished = Some(now());
                record.ended = Some(self.records.time());
                record.last_event = Some(before_life(record.lives) + 1);
            }
            record.forgotten = true;
            record.front = self.records.front().map(str::to_owned);
            is_seen
        })?;
        if marked && was_unfinished {
            self.ended(job);
        }
        Ok(marked)
    }

    /// Called once a second: removes what is left behind by jobs that this front has ended, or a front that is gone.
    pub(super) fn remove_leftovers(&self) {
        let Some(front) = self.records.front() else { return };
        let is_due = |job: &&Arc<Job>| {
            let left = *job.left.lock();
            let record = job.record();
            let is_ours = |of: &str| of == front || !self.records.is_alive(of);
            record.state.is_final()
                && record.front.as_deref().is_some_and(is_ours)
                && left.is_some_and(|left| left.elapsed() >= GRACE)
        };
        let due: Vec<_> = {
            let registry = self.registry.lock();
            registry.jobs.values().chain(registry.leaving.values()).filter(is_due).map(Arc::clone).collect()
        };
        for job in due {
            let record = job.record().clone();
            self.remove_unneeded(&record);
            let removed = if record.forgotten {
                self.records.remove(&[Arc::clone(&job)]).map_err(io::Error::from)
            } else {
                self.change(&job, |record| record.state.is_final() && record.front.take().is_some()).map(drop)
            };
            match removed {
                Ok(()) if record.forgotten => self.vanished(&record.id),
                Ok(()) => {}
                Err(error) => tracing::warn!(job = record.id, %error, "a record is not removed yet"),
            }
        }
    }

    /// Removes the files of a job that no job needs. Who needs one from now on puts it there again.
    fn remove_unneeded(&self, record: &Record) {
        let (scene, pictures) = {
            let registry = self.registry.lock();
            let mut pictures = record.picture_names();
            pictures.retain(|name| !registry.pictures.has(name));
            (!registry.scenes.has(&record.spec.scene), pictures)
        };
        if scene {
            self.files.scenes.remove(&record.spec.scene);
        }
        pictures.iter().for_each(|name| self.files.remove_picture(name));
    }

    /// The record of a job is gone.
    pub(super) fn vanished(&self, id: &str) {
        let mut registry = self.registry.lock();
        registry.leaving.remove(id);
        let Some(job) = registry.remove(id) else { return };
        let record = job.record().clone();
        registry.release_files(&record, &self.files);
        registry.queued.retain(|other| !Arc::ptr_eq(other, &job));
        registry.elsewhere.retain(|other| !Arc::ptr_eq(other, &job));
        job.stop(Stopped::Taken);
    }
}
