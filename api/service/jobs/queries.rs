//! Queries about jobs.

use super::files::frame_name;
use super::job::Job;
use super::record::{JobSpec, Record, State, is_job_id};
use super::registry::{estimate, rank, remaining};
use super::{Jobs, canvas};
use crate::service::error::Error;
use crate::service::memory_budget::MeteredBytes;
use crate::service::pictures::file::{PictureFile, PictureMeta};
use crate::service::pictures::spec::PictureSpec;
use std::collections::HashSet;
use std::ops::Bound;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use strahl::film::FileFormat;
use tokio::sync::watch;

/// Bytes for each pixel of a picture that is decoded and made smaller: 16 bits for each channel, twice.
const DECODED_BYTES: u64 = 16;

impl Jobs {
    /// A job.
    pub(crate) fn find(&self, id: &str) -> Option<Arc<Job>> {
        self.registry.lock().jobs.get(id).map(Arc::clone)
    }

    /// A job, also one that another front has accepted a moment ago. An error says that it is not known whether there is one.
    pub(crate) async fn find_lately(&self, id: &str) -> Result<Option<Arc<Job>>, Error> {
        let found = self.find(id);
        if found.is_some() || self.shared.is_none() || !is_job_id(id) {
            return Ok(found);
        }
        let is_up_to_date = self.catch_up().await;
        match self.find(id) {
            None if !is_up_to_date => {
                let detail =
                    "the broker of the farm does not answer, so it is not known whether there is such a job".into();
                Err(Error::Busy { detail, retry_after: 2 })
            }
            found => Ok(found),
        }
    }

    /// What a job with this scene id renders, if there is one: of an owner, or of anybody.
    pub(crate) fn spec_of(&self, scene_id: &str, owner: Option<&str>) -> Option<JobSpec> {
        let registry = self.registry.lock();
        let same = |job: &Arc<Job>| {
            let record = job.record();
            let same = record.scene_id.as_deref() == Some(scene_id)
                && record.state.needs_scene()
                && owner.is_none_or(|owner| owner == record.tenant);
            same.then(|| record.spec.clone())
        };
        registry.jobs.values().find_map(same)
    }

    /// The SHA-256 of all assets that jobs may need.
    pub(crate) fn assets(&self) -> HashSet<String> {
        let registry = self.registry.lock();
        let needed = |job: &Arc<Job>| {
            let record = job.record();
            if record.needs_scene() { record.assets.clone() } else { Vec::new() }
        };
        registry.jobs.values().flat_map(needed).collect()
    }

    /// A job of a tenant that has not ended and names an asset. In a farm it may wait for what other fronts have accepted.
    pub(crate) fn that_needs(&self, tenant: &str, hash: &str) -> Result<Option<String>, Error> {
        if let Some(shared) = &self.shared
            && !shared.records.catch_up_here()
        {
            let detail =
                "the broker of the farm does not answer, so it is not known whether a job needs the asset".into();
            return Err(Error::Busy { detail, retry_after: 2 });
        }
        let registry = self.registry.lock();
        let needs = |job: &Arc<Job>| {
            let record = job.record();
            let is_needed = record.tenant == tenant && record.assets.iter().any(|asset| asset == hash);
            is_needed.then(|| record.id.clone())
        };
        Ok(registry.all_unfinished().find_map(needs))
    }

    /// The picture of a job that shows this whole image in this format.
    pub(crate) fn picture_of(&self, image_id: &str, format: FileFormat) -> Option<PictureFile> {
        let name = PictureSpec::plain(None, format).name(&image_id);
        let is_of_a_job = self.registry.lock().pictures.has(&name);
        is_of_a_job.then(|| self.read_picture(&name).ok())??
    }

    /// Whether some job has that picture.
    pub(crate) fn has_picture(&self, image_id: &str, format: FileFormat) -> bool {
        self.registry.lock().pictures.has(&PictureSpec::plain(None, format).name(&image_id))
    }

    /// Jobs older than `before` that are `wanted`, the newest first.
    pub(crate) fn list(&self, before: Option<&str>, limit: usize, wanted: impl Fn(&Record) -> bool) -> Vec<Arc<Job>> {
        let registry = self.registry.lock();
        let older = registry.jobs.range::<str, _>((Bound::Unbounded, before.map_or(Bound::Unbounded, Bound::Excluded)));
        older.rev().map(|(_, job)| job).filter(|job| wanted(&job.record())).take(limit).map(Arc::clone).collect()
    }

    /// A channel that changes when jobs come and go.
    pub(crate) fn changes(&self) -> watch::Receiver<u64> {
        self.registry.lock().changes.subscribe()
    }

    /// Position of a waiting job among those of its tenant, from 1, and estimated milliseconds until it is done.
    pub(crate) fn place(&self, job: &Arc<Job>) -> Option<(usize, f64)> {
        let registry = self.registry.lock();
        let now = Instant::now();
        let mine = rank(job, now);
        let tenant = job.record().tenant.clone();
        registry.queued.iter().find(|queued| Arc::ptr_eq(queued, job))?;
        let of_tenant = |other: &&Arc<Job>| other.record().tenant == tenant;
        let ahead: Vec<f64> =
            registry.queued.iter().filter(of_tenant).filter(|other| rank(other, now) > mine).map(estimate).collect();
        let running: f64 = registry.running().filter(of_tenant).map(remaining).sum();
        let mut tenants: Vec<String> = registry.running().map(|job| job.record().tenant.clone()).collect();
        tenants.push(tenant.clone());
        tenants.sort();
        tenants.dedup();
        let alone = ahead.iter().sum::<f64>() + running + estimate(job);
        Some((ahead.len() + 1, alone * registry.slowness.unwrap_or(1.0) * tenants.len() as f64))
    }

    /// Whether the disk does not take the records or files of jobs. It is tried again each second.
    pub(crate) fn is_unwritable(&self) -> bool {
        // A job that has ended waits for nothing: its record is written before it says so.
        let waits_for_disk = |job: &Arc<Job>| job.waits.load(Ordering::Relaxed) && !job.record().state.is_final();
        // In a farm other fronts take them, and the broker and the store say for themselves whether they answer.
        let waits = || !self.files.shared && self.registry.lock().open.iter().any(waits_for_disk);
        let files = [&self.folders_are_gone, &self.files_fail];
        self.records.is_failing() || files.into_iter().any(|fails| fails.load(Ordering::Relaxed)) || waits()
    }

    /// Numbers of waiting jobs and of jobs that are worked on.
    pub(crate) fn counts(&self) -> (usize, usize) {
        let registry = self.registry.lock();
        (registry.queued.len(), registry.running().count())
    }

    /// The states of all jobs.
    pub(crate) fn by_state(&self) -> Vec<State> {
        self.registry.lock().jobs.values().map(|job| job.record().state).collect()
    }

    /// Time spent on jobs that were canceled or have failed.
    pub(crate) fn canceled(&self) -> Duration {
        Duration::from_millis(self.canceled.load(Ordering::Relaxed))
    }

    /// Bytes of scenes and of finished pictures on disk.
    pub(crate) fn bytes(&self) -> u64 {
        self.files.bytes()
    }

    /// The picture of a job that has succeeded, if it is there and whole.
    pub(crate) fn picture(&self, job: &Job) -> Result<Option<PictureFile>, Error> {
        let name = job.record().picture_name();
        self.read_picture(&name)
    }

    fn read_picture(&self, name: &str) -> Result<Option<PictureFile>, Error> {
        PictureFile::read(&*self.files.pictures, name, &self.cache.memory)
    }

    /// A frame of a sequence, if it is finished, there and whole.
    pub(crate) fn frame(&self, job: &Job, number: u32) -> Result<Option<PictureFile>, Error> {
        let record = job.record().clone();
        if !record.has_pictures() {
            return Ok(None);
        }
        self.read_picture(&frame_name(&record.id, number))
    }

    /// The small picture of a frame, a PNG.
    pub(crate) fn small_frame(&self, job: &Job, number: u32) -> Result<Option<Vec<u8>>, Error> {
        let record = job.record().clone();
        if !record.has_pictures() {
            return Ok(None);
        }
        self.files.small_frame(&record.id, number).map_err(|error| Error::io("a frame cannot be read", &error))
    }

    /// The metadata of that picture.
    pub(crate) fn meta(&self, job: &Job) -> Option<PictureMeta> {
        let record = job.record().clone();
        self.files.meta(&record)
    }

    /// The text of a job's scene, if it is there and whole.
    pub(crate) fn scene(&self, name: &str) -> Result<Option<MeteredBytes>, Error> {
        let bytes = self.files.scenes.size(name).unwrap_or(0);
        self.cache.memory.read(bytes, || {
            let found = self.files.scenes.get(name).map_err(|error| Error::io("the scene cannot be read", &error))?;
            Ok(found.map(|blob| blob.body))
        })
    }

    /// The last preview of a finished job, a PNG. If the picture existed already, it is made from the picture; none if
    /// that is in a format without codes.
    pub(crate) fn last_preview(&self, job: &Job) -> Result<Option<Vec<u8>>, Error> {
        let record = job.record().clone();
        if let Some(png) = self.files.preview(&record) {
            return Ok(Some(png));
        }
        let Some(picture) = self.picture(job)? else { return Ok(None) };
        let mut share = self.cache.memory.share(0);
        share.grow(DECODED_BYTES * u64::from(record.width) * u64::from(record.height))?;
        let Some(png) = canvas::preview_of(&picture.bytes, record.width, record.height) else { return Ok(None) };
        if let Err(error) = self.files.put_preview(&record, &png) {
            tracing::warn!(job = record.id, %error, "a preview cannot be kept");
        }
        Ok(Some(png))
    }
}
