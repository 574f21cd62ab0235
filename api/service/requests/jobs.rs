//! Submitting a job: its scene is checked and its time estimated before it is accepted.

use super::Service;
use super::pictures::{Source, Upload, image_of};
use crate::service::deliveries::key::{FRAME, KeyTemplate};
use crate::service::error::Error;
use crate::service::jobs::outbox::{Delivery, Outbox};
use crate::service::jobs::record::{JobSpec, Record, State};
use crate::service::jobs::{Claim, Job};
use crate::service::memory_budget::MeteredBytes;
use crate::service::pictures::file::PictureFile;
use crate::service::pictures::spec::PictureSpec;
use crate::service::scenes::ids::ImageId;
use crate::service::scenes::prepared::planned;
use crate::service::scenes::sent_scene::{Form, SentScene};
use crate::service::scheduler::admission::Work;
use crate::service::scheduler::task::Task;
use std::sync::Arc;
use std::time::{Duration, UNIX_EPOCH};
use strahl::film::encode::png_of;
use strahl::film::{FileFormat, Region};
use strahl::scene::description::{Accuracy, ImageSize, Rays};
use strahl::scene::{Description, Format, Overrides, Problem, Problems};
use strahl::sequence::Sequence;

/// A job that a client asks for.
#[derive(Debug)]
pub(crate) struct WantedJob {
    /// The scene's text.
    pub(crate) scene: MeteredBytes,
    /// What the text is.
    pub(crate) form: Form,
    /// The frames of a sequence.
    pub(crate) frames: Option<Sequence>,
    /// Settings that replace the scene's.
    pub(crate) overrides: Overrides,
    /// Format of the picture.
    pub(crate) output: FileFormat,
    /// 0 to 100.
    pub(crate) priority: u8,
    /// The owner's labels.
    pub(crate) labels: Vec<String>,
    /// What is delivered after its end.
    pub(crate) wishes: Wishes,
}

/// What is delivered after a job.
#[derive(Debug, Default)]
pub(crate) struct Wishes {
    /// Its picture, to this name in the store.
    pub(crate) key: Option<KeyTemplate>,
    /// A message, to this URL.
    pub(crate) webhook: Option<String>,
}

impl Wishes {
    fn outbox(self, record: &Record) -> Result<Outbox, Error> {
        let value = |word: &str| match word {
            "job" => Some(record.id.clone()),
            "scene" => record.scene_id.clone(),
            "image" => record.image_id.clone(),
            "frame" => record.frames.map(|_| FRAME.to_owned()),
            "width" => Some(record.width.to_string()),
            "height" => Some(record.height.to_string()),
            "date" => Some(day(record.created)),
            "ext" => Some(record.spec.output.names().0.to_owned()),
            _ => None,
        };
        let name = self.key.map(|key| {
            let key = if record.frames.is_some() { key.of_frames()? } else { key };
            key.fill(&record.tenant, value)
        });
        let name = name.transpose().map_err(Error::OutOfRange)?;
        Ok(Outbox { store: name.map(Delivery::to), webhook: self.webhook.map(Delivery::to) })
    }
}

/// The day of a time in milliseconds since 1970, in UTC.
fn day(ms: u64) -> String {
    let time = UNIX_EPOCH + Duration::from_millis(ms);
    humantime::format_rfc3339_seconds(time).to_string().chars().take(10).collect()
}

/// Bytes of a pixel of a picture that is decoded to be cropped.
const CODES_BYTES: u64 = 8;

/// A region of a picture of codes, as a PNG.
fn crop_of_codes(file: &[u8], Region { x, y, width, height }: Region) -> Option<Vec<u8>> {
    let part = image::load_from_memory(file).ok()?.crop_imm(x, y, width, height);
    let codes = if part.color().has_alpha() { part.into_rgba8().into_raw() } else { part.into_rgb8().into_raw() };
    Some(png_of(width, height, &codes))
}

impl Service {
    /// Checks a scene, estimates its time, and accepts the job for the tenant of `task`, which may have `most` waiting and
    /// running jobs.
    pub(crate) async fn submit(
        self: &Arc<Self>,
        task: Task,
        most: u32,
        mut wanted: WantedJob,
        claim: Option<Claim>,
    ) -> Result<Arc<Job>, Error> {
        let (tenant, weight) = (task.tenant.to_string(), task.weight);
        let (service, wishes) = (Arc::clone(self), std::mem::take(&mut wanted.wishes));
        let check = move |work: &Work| {
            if let Some(sequence) = wanted.frames.take() {
                let (record, text) = service.check_sequence(work, wanted, &sequence)?;
                return Ok((Record { tenant, weight, ..record }, text));
            }
            let WantedJob { scene, form, overrides, output, priority, labels, .. } = wanted;
            let limits = &service.jobs.limits;
            let accept = |scene: &Description| {
                let ImageSize { width, height } = scene.image;
                limits.check([width, height], scene.render.samples.unwrap_or(1))
            };
            let sent = SentScene::new(scene.as_ref(), &form, &overrides);
            let ready = service.scenes.find_if(&work.workers, &sent, &accept)?.ready;
            let size = [ready.scene.width, ready.scene.height];
            limits.check(size, ready.scene.samples)?;
            let region = Region::whole(size[0], size[1]);
            let (plan, _) = planned(&ready, region, &work.workers, &work.control)?;
            let (estimate_ms, estimate_rays) = plan.estimate.map_or((0.0, 0), |estimate| (estimate.ms, estimate.rays));
            service.check_time(estimate_ms)?;
            let [scene_id, image_id] =
                image_of(&ready).map_or([None, None], |image| [image.scene.clone(), image.to_string()].map(Some));
            // A time or a number of rays ends the whole picture, so it has no tiles.
            let edge = if ready.render.accuracy().is_budget() {
                0
            } else {
                service.jobs.tile_edge(region.pixels(), estimate_ms)
            };
            let scene_bytes = ready.scene.bytes() as u64;
            let assets = ready.scene.assets.clone();
            let [width, height] = size;
            let (format, scene, settings) = service.text_of_job(work, scene, &form, overrides, size)?;
            let spec = JobSpec { scene: String::new(), format, settings, output };
            let job = Record {
                tenant,
                weight,
                priority,
                labels,
                scene_id,
                image_id,
                width,
                height,
                assets,
                ..Record::new(spec)
            };
            Ok::<_, Error>((Record { edge, estimate_ms, estimate_rays, scene_bytes, ..job }, scene))
        };
        let (mut record, scene) = self.run(task, check).await?.value;
        record.outbox = wishes.outbox(&record)?;
        let file = match record.image_id.as_deref().and_then(ImageId::read) {
            Some(image) => self.stored_picture(&image, &PictureSpec::plain(None, record.spec.output)).await,
            None => None,
        };
        let (service, owner) = (Arc::clone(self), record.tenant.clone());
        let submit = move || {
            let job = service.jobs.submit(record, scene.as_ref(), most, claim.as_ref(), file.as_deref())?;
            if let Err(lacking) = service.check_assets(&job) {
                let gone = service.jobs.forget(&job);
                gone.unwrap_or_else(|error| tracing::error!(%error, "a job without its assets cannot be forgotten"));
                return Err(lacking);
            }
            Ok(job)
        };
        self.storage_threads.run(&owner, submit).await?
    }

    /// The text that a job keeps, its format, and the settings. A job does not depend on other scenes, so of a variation it keeps all.
    pub(super) fn text_of_job(
        &self,
        work: &Work,
        scene: MeteredBytes,
        form: &Form,
        overrides: Overrides,
        [width, height]: [u32; 2],
    ) -> Result<(Format, MeteredBytes, Overrides), Error> {
        match form {
            Form::Whole(format) => Ok((*format, scene, overrides)),
            Form::Variation(_) => {
                let text = self.canonical_text(work, &SentScene::new(scene.as_ref(), form, &overrides))?;
                Ok((Format::Json, self.memory.metered(text)?, overrides.again(ImageSize { width, height })))
            }
        }
    }

    /// Refuses a job whose assets were deleted while it was being accepted, by another front perhaps. Who deletes one looks for jobs
    /// that need it; this looks for the asset when the job can be seen.
    fn check_assets(&self, job: &Job) -> Result<(), Error> {
        let (tenant, assets) = {
            let record = job.record();
            // It may have begun already, and failed since they are gone.
            let needs_none = matches!(record.state, State::Succeeded | State::Canceled | State::Expired);
            let assets = if needs_none { Vec::new() } else { record.assets.clone() };
            (record.tenant.clone(), assets)
        };
        let lacking = assets.iter().filter(|hash| !self.assets.owns(&tenant, hash));
        let problems: Vec<Problem> = lacking.map(|hash| Problem::missing_asset("", hash)).collect();
        // While the store is out of reach, the job waits for it.
        if problems.is_empty() || self.assets.check_store().is_err() {
            Ok(())
        } else {
            Err(Error::Scene(Problems(problems)))
        }
    }

    /// The picture of a job that has succeeded. If its file is damaged or gone it is rendered again, to the same bytes; none
    /// if that cannot be.
    pub(crate) async fn job_picture(
        self: &Arc<Self>,
        task: Task,
        job: &Arc<Job>,
    ) -> Result<Option<Arc<PictureFile>>, Error> {
        let (jobs, kept) = (Arc::clone(&self.jobs), Arc::clone(job));
        if let Some(file) = self.storage_threads.run(&task.tenant, move || jobs.picture(&kept)).await?? {
            return Ok(Some(Arc::new(file)));
        }
        let (output, image) = {
            let record = job.record();
            tracing::error!(job = record.id, "the picture of a job is damaged or gone");
            (record.spec.output, record.image_id.clone())
        };
        if image.is_none() {
            return Ok(None);
        }
        let made = match self.render_of_job(task, job, PictureSpec::plain(None, output)).await {
            // The answer to a request may be smaller than a job.
            Err(Error::Limit { .. }) | Ok(None) => return Ok(None),
            Err(error) => return Err(error),
            Ok(Some(made)) => made,
        };
        let (jobs, job, file) = (Arc::clone(&self.jobs), Arc::clone(job), Arc::clone(&made));
        // Whether it can be kept does not matter to this request.
        let _ = tokio::task::spawn_blocking(move || jobs.restore_picture(&job, &file)).await;
        Ok(Some(made))
    }

    /// A region of a finished job's picture, as a PNG; none if its scene is gone.
    pub(crate) async fn part_of_job(
        self: &Arc<Self>,
        task: Task,
        job: &Arc<Job>,
        region: Region,
    ) -> Result<Option<Vec<u8>>, Error> {
        let (is_whole, output, pixels) = {
            let record = job.record();
            (record.edge == 0, record.spec.output, u64::from(record.width) * u64::from(record.height))
        };
        if !is_whole {
            let part = self.render_of_job(task, job, PictureSpec::plain(Some(region), FileFormat::Png8)).await?;
            return Ok(part.map(|file| file.bytes.clone()));
        }
        // A time or a number of rays has ended the picture: a part with as much for itself would be another.
        // The codes of its file will do; those of floats are made once more, of as many rays.
        let whole = match output {
            FileFormat::Exr | FileFormat::Pfm => {
                self.render_of_job(task.clone(), job, PictureSpec::plain(None, FileFormat::Png8)).await?
            }
            _ => self.job_picture(task.clone(), job).await?,
        };
        let Some(whole) = whole else { return Ok(None) };
        let memory = self.memory.clone();
        let work = move |work: &Work| {
            let mut share = memory.share(0);
            share.grow(CODES_BYTES * pixels)?;
            Ok::<_, Error>(work.workers.work(|| crop_of_codes(&whole.bytes, region))?)
        };
        Ok(self.run(task, work).await?.value)
    }

    /// A picture of a job's scene, rendered for a request unless it is in a cache; none if the scene is gone. Of a picture that a time
    /// has ended it is the one of as many rays.
    pub(crate) async fn render_of_job(
        self: &Arc<Self>,
        task: Task,
        job: &Job,
        spec: PictureSpec,
    ) -> Result<Option<Arc<PictureFile>>, Error> {
        let (mut of_job, rays) = {
            let record = job.record();
            (record.spec.clone(), Some(record.stats.rays).filter(|rays| record.edge == 0 && *rays > 0))
        };
        if let Some(count) = rays {
            of_job.settings.accuracy = Some(Accuracy::Rays(Rays { count }));
        }
        let (jobs, scene) = (Arc::clone(&self.jobs), of_job.scene.clone());
        let text = self.storage_threads.run(&task.tenant, move || jobs.scene(&scene)).await??;
        let Some(text) = text else { return Ok(None) };
        let upload = Upload::new(text, Form::Whole(of_job.format), of_job.settings).await?;
        Ok(Some(self.make_picture(task, Source::Sent(upload), spec).await?.file))
    }

    pub(super) fn check_time(&self, estimate_ms: f64) -> Result<(), Error> {
        let max = self.jobs.limits.job_timeout.as_secs();
        if estimate_ms <= max as f64 * 1e3 {
            return Ok(());
        }
        let detail = format!(
            "it would take about {:.0} s on this machine; a job has at most {max} (job_timeout): fewer samples, a lower \
             max_depth or a smaller picture take less",
            estimate_ms / 1e3
        );
        Err(Error::Limit { name: "job_timeout", max, detail })
    }
}
