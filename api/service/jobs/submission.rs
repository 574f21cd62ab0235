//! Accepting a job: idempotency keys, limits, and its record.

use super::Jobs;
use super::disk_shares::{DiskShares, Kinds};
use super::job::{Job, locked};
use super::record::{Idempotency, Record, State, Stats};
use super::registry::{Registry, estimate, memory_of, remaining};
use super::retention::disk_of;
use crate::service::error::Error;
use crate::service::pictures::file::PictureFile;
use data_encoding::HEXLOWER;
use sha2::{Digest, Sha256};
use std::io;
use std::sync::Arc;

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
}

/// A claimed idempotency key. Dropping it gives the key up, unless a job was made with it.
#[derive(Debug)]
pub(crate) struct Claim {
    jobs: Arc<Jobs>,
    tenant: String,
    idempotency: Idempotency,
}

impl Drop for Claim {
    fn drop(&mut self) {
        let key = (self.tenant.clone(), self.idempotency.key.clone());
        let mut registry = locked(&self.jobs.registry);
        if registry.keys.get(&key).is_some_and(Option::is_none) {
            registry.keys.remove(&key);
        }
    }
}

impl Jobs {
    /// Claims an idempotency key for a request, whose bytes are `request`.
    pub(crate) fn claim(self: &Arc<Self>, tenant: &str, key: &str, request: &[u8]) -> Result<Claim, KeyUse> {
        let idempotency = Idempotency { key: key.to_owned(), request: hash(request) };
        let mut registry = locked(&self.registry);
        let place = (tenant.to_owned(), key.to_owned());
        match registry.keys.get(&place) {
            Some(None) => return Err(KeyUse::Pending),
            Some(Some(id)) => {
                if let Some(job) = registry.jobs.get(id) {
                    let same = job.record().idempotency.as_ref() == Some(&idempotency);
                    return Err(if same { KeyUse::Same(Arc::clone(job)) } else { KeyUse::Other });
                }
            }
            None => {}
        }
        registry.keys.insert(place, None);
        Ok(Claim { jobs: Arc::clone(self), tenant: tenant.to_owned(), idempotency })
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
        let scene = hash(text);
        record.spec.scene.clone_from(&scene);
        record.idempotency = claim.map(|claim| claim.idempotency.clone());
        let (needs, all) = (memory_of(&record), self.cache.memory.most());
        if needs > all {
            let detail = format!("it would take {needs} bytes of memory; the service has {all} (memory_bytes)");
            return Err(Error::Limit { name: "memory_bytes", max: all, detail });
        }
        let max = self.limits.job_memory_bytes;
        if needs > max {
            let detail = format!("it would take {needs} bytes of memory; a job may take {max} (job_memory_bytes)");
            return Err(Error::Limit { name: "job_memory_bytes", max, detail });
        }
        let bytes = text.len() as u64;
        let (written, max) = (bytes.max(disk_of(&record)), self.limits.data_bytes);
        if written > max / 2 {
            let detail = format!(
                "its scene or its picture with all tiles would take {written} bytes on disk; each may take half of {max} \
                 (data_bytes)"
            );
            return Err(Error::Limit { name: "data_bytes", max, detail });
        }
        if !self.files.scenes.has(&scene) && !self.make_room_for_scene(&record.tenant, bytes) {
            let detail = "the scenes of other jobs fill the disk space for scenes (data_bytes)".into();
            return Err(Error::Busy { detail, retry_after: locked(&self.registry).seconds_for_a_tenth() });
        }
        {
            let mut registry = locked(&self.registry);
            let of_tenant = |job: &&Arc<Job>| job.record().tenant == record.tenant;
            let mine = registry.queued.iter().chain(&registry.open).filter(of_tenant).count();
            let retry_after = registry.seconds_for_a_tenth();
            if made.is_none() && registry.queued.len() + registry.open.len() >= self.limits.jobs as usize {
                return Err(Error::Busy {
                    detail: "the limit on waiting and running jobs is reached (jobs)".into(),
                    retry_after,
                });
            }
            let (tenant, written) = (record.tenant.as_str(), disk_of(&record));
            let room = || DiskShares::of(&registry, &self.files, Kinds::All, max, Some((tenant, 0))).room(tenant);
            if made.is_none() && self.files.bytes() + written > max && written > room() {
                let detail = "the pictures that other tenants may keep leave no room for its files (data_bytes)".into();
                return Err(Error::Busy { detail, retry_after });
            }
            if made.is_none() && mine >= most as usize {
                let detail = "your limit on waiting and running jobs is reached (jobs of your tenant)".into();
                return Err(Error::TenantBusy { detail, retry_after });
            }
            // From here on the files of the scene and the picture are not removed.
            registry.scenes.add(&scene);
            if made.is_some() {
                registry.pictures.add(&record.picture_name());
            }
        }
        let files = &self.files;
        let kept = if files.scenes.get(&scene).is_some() { Ok(()) } else { files.scenes.put(&scene, b"", text) };
        let kept = kept.and_then(|()| made.map_or(Ok(()), |made| self.reuse_picture(&mut record, made)));
        let kept = kept.and_then(|()| self.store.put(&record));
        let mut registry = locked(&self.registry);
        let job = Arc::new(Job::new(record.clone()));
        if kept.is_ok() {
            registry.add(&job);
        }
        // `add` has counted them for the job itself.
        registry.release_scene(&record, files);
        if made.is_some() {
            registry.release_pictures(&record, files);
        }
        drop(registry);
        kept.map_err(|error| {
            tracing::error!(%error, "a job's record cannot be written");
            Error::Internal("the job's record cannot be written; the service's log says why")
        })?;
        if made.is_some() {
            self.make_room();
        }
        self.open_next();
        Ok(job)
    }

    /// Finishes a job with a picture that exists already. If another job has it, they share it.
    fn reuse_picture(&self, record: &mut Record, made: &PictureFile) -> io::Result<()> {
        if !self.files.pictures.has(&record.picture_name()) {
            self.files.put_picture(record, made)?;
        }
        record.state = State::Succeeded;
        record.ended = Some(self.store.run_time.ms());
        (record.started, record.finished, record.last_event) = (Some(record.created), Some(record.created), Some(1));
        record.stats = Stats { picture_bytes: made.bytes.len() as u64, reused: true, ..Stats::default() };
        Ok(())
    }

    /// The edge of tiles for a picture of some pixels that takes some milliseconds.
    pub(crate) fn tile_edge(&self, pixels: u64, estimate_ms: f64) -> u32 {
        edge(estimate_ms / pixels as f64, self.pool.threads)
    }
}

impl Registry {
    /// Seconds until a tenth of all jobs, at least one, should be done: 1 to 120.
    fn seconds_for_a_tenth(&self) -> u32 {
        let all: f64 = self.queued.iter().map(estimate).chain(self.open.iter().map(remaining)).sum();
        let share = (0.1_f64).max(1.0 / (self.queued.len() + self.open.len()).max(1) as f64);
        let seconds = all * self.slowness.unwrap_or(1.0) * share / 1e3;
        (seconds.ceil() as u32).clamp(1, 120)
    }
}

/// The edge of tiles whose pixels take `pixel_ms` each.
fn edge(pixel_ms: f64, threads: usize) -> u32 {
    let pixels = (PIXELS_A_THREAD * threads as f64).min(TILE_MS / pixel_ms.max(1e-12));
    EDGES.into_iter().find(|edge| f64::from(*edge).powi(2) <= pixels * 1.01).unwrap_or(EDGES[EDGES.len() - 1])
}

/// SHA-256 in hexadecimal digits.
pub(super) fn hash(bytes: &[u8]) -> String {
    HEXLOWER.encode(&Sha256::digest(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_smaller_where_pixels_are_dear_and_larger_for_many_threads() {
        assert_eq!([edge(1e-4, 2), edge(1e-4, 32), edge(0.01, 2), edge(1.0, 2)], [128, 512, 64, 32]);
    }
}
