//! Accepting a job: idempotency keys, limits, and its record.

use super::Jobs;
use super::disk_shares::{DiskShares, Kinds};
use super::event_log::EventPublisher;
use super::files::Files;
use super::job::Job;
use super::record::{Idempotency, Record, State, Stats};
use super::registry::{Registry, Unfinished, estimate, memory_of, remaining};
use super::retention::disk_of;
use super::run::REMOTE_EDGE;
use crate::service::error::{Error, is_temporary};
use crate::service::hash::sha256;
use crate::service::pictures::file::PictureFile;
use crate::service::storage::revisions::Refused;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Pixels of a tile for each thread, which keep it busy.
const PIXELS_A_THREAD: f64 = 8_192.0;
/// Longest expected time of a tile, in milliseconds.
const TILE_MS: f64 = 50.0;
/// Edges that tiles may have, in pixels.
const EDGES: [u32; 5] = [512, 256, 128, 64, 32];

/// Why an idempotency key cannot be claimed.
#[derive(Debug)]
pub(crate) enum KeyUse {
    /// The same request has already made this job.
    Same(Arc<Job>),
    /// Another request has used the key.
    Other,
    /// A request with the key is being accepted now.
    Pending,
    /// Where records live nothing answers.
    Unknown(io::Error),
}

/// A claimed idempotency key. Dropping it gives the key up, unless a job was made with it.
#[derive(Debug)]
pub(crate) struct Claim {
    jobs: Arc<Jobs>,
    tenant: String,
    idempotency: Idempotency,
    /// Revision of the claim, where records live.
    revision: AtomicU64,
}

impl Drop for Claim {
    fn drop(&mut self) {
        let key = (self.tenant.clone(), self.idempotency.key.clone());
        let mut registry = self.jobs.registry.lock();
        if registry.keys.get(&key).is_some_and(Option::is_none) {
            registry.keys.remove(&key);
        }
        drop(registry);
        // From here on the job's record has the key, if there is a job.
        self.jobs.records.give_up(&self.tenant, &self.idempotency.key, self.revision.load(Ordering::Relaxed));
    }
}

impl Jobs {
    /// Claims an idempotency key for a request. With a farm it asks the broker.
    pub(crate) fn claim(self: &Arc<Self>, tenant: &str, idempotency: Idempotency) -> Result<Claim, KeyUse> {
        let place = (tenant.to_owned(), idempotency.key.clone());
        {
            let mut registry = self.registry.lock();
            match registry.keys.get(&place) {
                Some(None) => return Err(KeyUse::Pending),
                Some(Some(_)) => {
                    if let Some(known) = registry.use_of(&place, &idempotency) {
                        return Err(known);
                    }
                }
                None => {}
            }
            registry.keys.insert(place.clone(), None);
        }
        let claim =
            Claim { jobs: Arc::clone(self), tenant: tenant.to_owned(), idempotency, revision: AtomicU64::new(0) };
        match self.records.claim(tenant, &claim.idempotency.key) {
            Ok(Some(revision)) => claim.revision.store(revision, Ordering::Relaxed),
            // Another front accepts it now.
            Ok(None) => return Err(KeyUse::Pending),
            Err(error) => return Err(KeyUse::Unknown(error)),
        }
        // Another front may have had the key before, and then its job is here by now.
        let known = self.registry.lock().use_of(&place, &claim.idempotency);
        known.map_or(Ok(claim), Err)
    }

    /// Accepts a job, which is on disk when this returns. Given a picture that exists already, the job is finished at once
    /// and does not count against the limits on jobs. Its owner may have `most` waiting and running jobs.
    pub(crate) fn submit(
        self: &Arc<Self>,
        mut record: Record,
        text: &[u8],
        most: u32,
        claim: Option<&Claim>,
        made: Option<&PictureFile>,
    ) -> Result<Arc<Job>, Error> {
        let scene = sha256(text);
        record.spec.scene.clone_from(&scene);
        record.idempotency = claim.map(|claim| claim.idempotency.clone());
        if self.files.shared {
            record.text_bytes = text.len() as u64;
        }
        let bytes = text.len() as u64;
        self.check_size(&record, bytes)?;
        if self.files.scenes.size(&scene).is_none() {
            self.check_space_for_scene(&record.tenant, bytes, made.is_some())?;
        }
        self.reserve(&record, most, made.is_some())?;
        let files = &self.files;
        // In a store it is there if this front has put it, or a record names it: reading it would take longer than putting it.
        let is_kept =
            if files.shared { files.scenes.size(&scene) } else { files.scenes.get(&scene).ok().flatten().map(|_| 0) }
                .is_some();
        let kept = if is_kept { Ok(()) } else { files.scenes.put(&scene, b"", text) };
        let kept = kept.and_then(|()| made.map_or(Ok(()), |made| self.reuse_picture(&mut record, made)));
        let kept = kept.map_err(Refused::Failed).and_then(|()| self.keep_new(&record, claim));
        let mut registry = self.registry.lock();
        let added = kept.map(|revision| registry.find_or_add(record.clone(), revision, self.publisher(), files));
        let before = registry.submitting.remove(&record.id).flatten();
        // The job itself has been counted.
        registry.release_scene(&record, files);
        if made.is_some() {
            registry.release_pictures(&record, files);
        }
        let retry_after = registry.seconds_for_a_tenth();
        drop(registry);
        let job = added.map_err(|refused| match refused {
            Refused::Changed => Error::Busy {
                detail: "another front has accepted a job with this Idempotency-Key meanwhile; send it again".into(),
                retry_after: 1,
            },
            Refused::Failed(error) => {
                self.files_fail.store(!self.files.shared && is_temporary(&error), Ordering::Relaxed);
                Error::io("the job cannot be kept", &error)
            }
        })?;
        // Other fronts may have accepted jobs at the same moment: the broker's order decides which are too many.
        if let (Some(before), None) = (before, made)
            && let Err(error) = self.check_unfinished(before, most, retry_after)
        {
            if let Err(error) = self.forget_all(&[job]) {
                tracing::error!(%error, "a job that is one too many cannot be forgotten");
            }
            return Err(error);
        }
        if made.is_some() {
            self.bell.notify_one();
            self.make_room();
        }
        self.open_next();
        Ok(job)
    }

    /// Refuses a job whose picture takes more memory, or whose files more disk, than any may.
    fn check_size(&self, record: &Record, text_bytes: u64) -> Result<(), Error> {
        let (needs, all) = (memory_of(record), self.cache.memory.most());
        if needs > all {
            let detail = format!("it would take {needs} bytes of memory; the service has {all} (memory_bytes)");
            return Err(Error::Limit { name: "memory_bytes", max: all, detail });
        }
        let max = self.limits.job_memory_bytes;
        if needs > max {
            let detail = format!("it would take {needs} bytes of memory; a job may take {max} (job_memory_bytes)");
            return Err(Error::Limit { name: "job_memory_bytes", max, detail });
        }
        let (written, max) = (text_bytes.max(disk_of(record)), self.limits.data_bytes);
        if written > max / 2 {
            let detail = format!(
                "its scene or its picture with all tiles would take {written} bytes on disk; each may take half of {max} \
                 (data_bytes)"
            );
            return Err(Error::Limit { name: "data_bytes", max, detail });
        }
        Ok(())
    }

    /// Makes room for the text of a scene that is not kept yet. Where the picture exists already, the job does not wait.
    fn check_space_for_scene(&self, tenant: &str, bytes: u64, is_made: bool) -> Result<(), Error> {
        if !is_made && !self.may_wait_with(tenant, bytes) {
            let detail = "the scenes of your jobs that wait take half of the disk space that other tenants leave \
                          (data_bytes): submit more when some have ended";
            let retry_after = self.registry.lock().seconds_for_a_tenth();
            return Err(Error::TenantBusy { detail: detail.into(), retry_after });
        }
        if !self.make_room_for_scene(tenant, bytes) {
            let detail = "the scenes of other jobs fill the disk space for scenes (data_bytes)".into();
            return Err(Error::Busy { detail, retry_after: self.registry.lock().seconds_for_a_tenth() });
        }
        Ok(())
    }

    /// Refuses a job beside too many others, or whose picture has no space. From here on the files of its scene and of a picture that
    /// exists already are not removed.
    fn reserve(&self, record: &Record, most: u32, is_made: bool) -> Result<(), Error> {
        let mut registry = self.registry.lock();
        let retry_after = registry.seconds_for_a_tenth();
        if !is_made {
            self.check_unfinished(registry.unfinished(&record.tenant), most, retry_after)?;
        }
        let (tenant, written, max) = (record.tenant.as_str(), disk_of(record), self.limits.data_bytes);
        let room = || DiskShares::of(&registry, &self.files, Kinds::All, max, Some((tenant, 0))).room(tenant);
        if !is_made && self.files.bytes() + written > max && written > room() {
            let detail = "the pictures that other tenants may keep leave no room for its files (data_bytes)".into();
            return Err(Error::Busy { detail, retry_after });
        }
        registry.scenes.add(&record.spec.scene);
        if is_made {
            registry.pictures.add(&record.picture_name());
        }
        Ok(())
    }

    /// Keeps the record of a new job where records live; its revision.
    fn keep_new(&self, record: &Record, claim: Option<&Claim>) -> Result<u64, Refused> {
        if let Some(claim) = claim {
            let revision = claim.revision.load(Ordering::Relaxed);
            let renewed = self.records.renew(&claim.tenant, &claim.idempotency.key, revision)?;
            claim.revision.store(renewed.ok_or(Refused::Changed)?, Ordering::Relaxed);
        }
        if self.records.front().is_some() {
            self.registry.lock().submitting.insert(record.id.clone(), None);
        }
        self.records.create(record)
    }

    /// Refuses a job beside so many others.
    fn check_unfinished(&self, others: Unfinished, most: u32, retry_after: u32) -> Result<(), Error> {
        if others.all >= self.limits.jobs as usize {
            let detail = "the limit on waiting and running jobs is reached (jobs)".into();
            return Err(Error::Busy { detail, retry_after });
        }
        if others.of_tenant >= most as usize {
            let detail = "your limit on waiting and running jobs is reached (jobs of your tenant)".into();
            return Err(Error::TenantBusy { detail, retry_after });
        }
        Ok(())
    }

    /// Finishes a job with a picture that exists already. If another job has it, they share it.
    fn reuse_picture(&self, record: &mut Record, made: &PictureFile) -> io::Result<()> {
        if self.files.pictures.size(&record.picture_name()).is_none() {
            self.files.put_picture(record, made)?;
        }
        record.state = State::Succeeded;
        record.ended = Some(self.records.time());
        (record.started, record.finished, record.last_event) = (Some(record.created), Some(record.created), Some(1));
        record.stats = Stats { picture_bytes: made.bytes.len() as u64, reused: true, ..Stats::default() };
        Ok(())
    }

    /// The edge of tiles for a picture of some pixels that takes some milliseconds.
    pub(crate) fn tile_edge(&self, pixels: u64, estimate_ms: f64) -> u32 {
        let edge = edge(estimate_ms / pixels as f64, self.pool.threads);
        if self.farm.is_some() { edge.min(REMOTE_EDGE) } else { edge }
    }
}

impl Registry {
    /// What a key was used for, if there is a job with it.
    fn use_of(&self, place: &(String, String), idempotency: &Idempotency) -> Option<KeyUse> {
        let job = self.jobs.get(self.keys.get(place)?.as_ref()?)?;
        let same = job.record().idempotency.as_ref() == Some(idempotency);
        Some(if same { KeyUse::Same(Arc::clone(job)) } else { KeyUse::Other })
    }

    /// The job of a record. Other fronts' jobs and those of this one come by the same way; one that is here stays.
    pub(super) fn find_or_add(
        &mut self,
        record: Record,
        revision: u64,
        publisher: Option<Arc<dyn EventPublisher>>,
        files: &Files,
    ) -> Arc<Job> {
        if let Some(job) = self.jobs.get(&record.id).or_else(|| self.leaving.get(&record.id)) {
            return Arc::clone(job);
        }
        files.learn(&record);
        let job = Arc::new(Job::new(record, revision, publisher));
        self.add(&job);
        job
    }

    /// Seconds until a tenth of all jobs, at least one, should be done: 1 to 120.
    fn seconds_for_a_tenth(&self) -> u32 {
        let all: f64 = self.queued.iter().map(estimate).chain(self.running().map(remaining)).sum();
        let share = (0.1_f64).max(1.0 / self.all_unfinished().count().max(1) as f64);
        let seconds = all * self.slowness.unwrap_or(1.0) * share / 1e3;
        (seconds.ceil() as u32).clamp(1, 120)
    }
}

/// The edge of tiles whose pixels take `pixel_ms` each.
fn edge(pixel_ms: f64, threads: usize) -> u32 {
    let pixels = (PIXELS_A_THREAD * threads as f64).min(TILE_MS / pixel_ms.max(1e-12));
    EDGES.into_iter().find(|edge| f64::from(*edge).powi(2) <= pixels * 1.01).unwrap_or(EDGES[EDGES.len() - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_smaller_where_pixels_are_dear_and_larger_for_many_threads() {
        assert_eq!([edge(1e-4, 2), edge(1e-4, 32), edge(0.01, 2), edge(1.0, 2)], [128, 512, 64, 32]);
    }
}
