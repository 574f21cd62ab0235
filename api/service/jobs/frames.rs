//! Rendering the frames of a sequence in tiles as any picture: one after the other here, several at a time where a farm has more
//! slots than a frame has tiles. Meanwhile finished ones are written to disk by another thread.
//!
//! A finished frame is a file like any picture, and is there after any crash; of the frame that was being rendered the finished
//! tiles are.

use super::Jobs;
use super::backend::{disk, until_possible};
use super::canvas::Canvas;
use super::files::frame_name;
use super::finish::{Coded, JobFiles, code};
use super::job::{Job, Stopped};
use super::record::{JobSpec, Record};
use super::registry::pixel_bytes;
use super::rendering::tiles_of;
use super::run::{Begun, backend, begin, farm_for, recover, scene_is_gone, tiles, when_there_is_room, whole};
use crate::service::clock::milliseconds;
use crate::service::error::Error;
use crate::service::farm::Farm;
use crate::service::pictures::warnings;
use crate::service::scenes::ids::ImageId;
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scenes::sent_scene::{Form, SentScene};
use crate::service::scheduler::pool::Workers;
use crate::service::sequences::report::FrameReport;
use crate::service::sequences::text::split;
use parking_lot::Mutex;
use serde_json::json;
use serde_json::value::RawValue;
use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::Instant;
use std::vec;
use strahl::film::sheet::{cell, small};
use strahl::render::{Cancelled, sampling_bytes};
use strahl::scene::Overrides;
use strahl::scene::limits::PROBLEMS;
use strahl::sequence::Sequence;

/// Frames of a job that are rendered at the same time, at most.
const MOST_AT_ONCE: u64 = 16;

/// A frame that is rendered, and not yet written.
struct Traced {
    number: u32,
    ready: PreparedScene,
    coded: Coded,
}

/// What all frames are made of.
struct Film<'a> {
    jobs: &'a Jobs,
    job: &'a Arc<Job>,
    /// Who renders the tiles, if it is not this process.
    farm: Option<&'a Arc<Farm>>,
    workers: &'a Workers,
    sequence: &'a Sequence,
    base: &'a Arc<PreparedScene>,
    spec: &'a JobSpec,
    edge: u32,
    began: Instant,
    /// Held by the frame that the pool of this process works on.
    pool: Mutex<()>,
}

/// Works on a sequence until all of its frames are finished.
pub(super) fn work(jobs: &Jobs, job: &Arc<Job>) -> Result<(), Stopped> {
    let began = Instant::now();
    let Begun { workers, spec, edge, .. } = begin(jobs, job)?;
    let text = when_there_is_room(job, || jobs.scene(&spec.scene));
    let text = text.map_err(|error| job.why_stopped_or(error.into()))?;
    let text = text.ok_or_else(scene_is_gone)?;
    let (sequence, scene) = split(text.as_ref()).ok_or_else(scene_is_gone)?;
    let (building, form) = (Instant::now(), Form::Whole(spec.format));
    let sent = SentScene::new(scene, &form, &spec.settings);
    let base = when_there_is_room(job, || jobs.cache.to_vary(&workers, &sent));
    let base = base.map_err(|error| job.why_stopped_or(error.into()))?;
    let farm = farm_for(jobs, job, edge, &base, text.as_ref())?;
    drop(text);
    let bvh_ms = milliseconds(building);
    job.record().stats.bvh_ms = bvh_ms;
    job.events.publish("started", json!({ "threads": workers.threads(), "bvh_ms": bvh_ms }));

    jobs.make_room();
    let mut share = jobs.cache.memory.share(base.bytes());
    let sampling = sampling_bytes(&base.scene, u64::from(base.scene.width) * u64::from(base.scene.height));
    let bytes = pixel_bytes(&job.record()) + base.scene.stack_bytes() * workers.threads() as u64 + sampling;
    let taken = when_there_is_room(job, || share.grow(bytes));
    taken.map_err(|error| job.why_stopped_or(error.into()))?;
    // As many more as there is memory for.
    let of_frame = pixel_bytes(&job.record()) / 2;
    let at_once =
        1 + (1..lanes(jobs, job, farm)).take_while(|more| share.grow(bytes + of_frame * more).is_ok()).count();
    let rendering = Instant::now();
    *job.begun.lock() = Some(rendering);
    let film = Film {
        jobs,
        job,
        farm,
        workers: &workers,
        sequence: &sequence,
        base: &base,
        spec: &spec,
        edge,
        began,
        pool: Mutex::default(),
    };
    film.all(at_once)?;
    job.record().stats.render_ms = milliseconds(rendering);
    Ok(())
}

impl Film<'_> {
    /// Renders all frames that are not there, so many at a time.
    fn all(&self, at_once: usize) -> Result<(), Stopped> {
        let missing = Mutex::new(self.take_up()?.into_iter());
        *self.job.tiling.lock() = Some((Instant::now(), self.job.work_done()));
        let (traced, to_write) = sync_channel(0);
        thread::scope(|scope| {
            let writer = scope.spawn(|| self.write(to_write));
            let lane = |_| {
                let (missing, traced) = (&missing, traced.clone());
                scope.spawn(move || self.lane(missing, &traced, at_once))
            };
            let lanes: Vec<_> = (0..at_once).map(lane).collect();
            drop(traced);
            let ends = lanes.into_iter().chain([writer]);
            // All are waited for, whatever the first one says.
            let ends: Vec<_> = ends.map(|end| end.join().unwrap_or_else(|_| Err(self.job.why_stopped()))).collect();
            ends.into_iter().collect()
        })
    }

    /// Renders frames until there are no more to begin with.
    fn lane(
        &self,
        missing: &Mutex<vec::IntoIter<u32>>,
        traced: &SyncSender<Traced>,
        at_once: usize,
    ) -> Result<(), Stopped> {
        let next = || missing.lock().next();
        while let Some(number) = next() {
            let frame = self.trace(number, at_once).inspect_err(|why| self.give_up(number, why))?;
            // It fails if the writer has stopped, which has stopped the job.
            traced.send(frame).map_err(|_| self.job.why_stopped())?;
        }
        Ok(())
    }

    /// A frame is not finished: the others need not be, and nobody needs its tiles if nobody goes on with it.
    fn give_up(&self, number: u32, why: &Stopped) {
        self.job.stop(why.clone());
        if let (Some(farm), Stopped::Canceled | Stopped::Failed(_)) = (self.farm, why) {
            farm.forget_results(&frame_name(&self.job.record().id, number));
        }
    }

    /// Counts the frames that are there; the numbers of the others.
    fn take_up(&self) -> Result<Vec<u32>, Stopped> {
        let Self { jobs, job, .. } = self;
        let id = job.record().id.clone();
        let (mut missing, mut rays, mut bytes) = (Vec::new(), 0, 0);
        for number in 0..self.sequence.count() {
            let report = until_possible(job, || jobs.frame_report(&id, number));
            match report.map_err(|error| job.why_stopped_or(disk(&error)))? {
                Some(report) => {
                    rays += report.rays;
                    bytes += jobs.files.pictures.size(&frame_name(&id, number)).unwrap_or(0);
                }
                None => missing.push(number),
            }
        }
        let done = self.sequence.count() - missing.len() as u32;
        let tiles = done as usize * tiles_of(&job.record());
        job.done.store(tiles, Ordering::Relaxed);
        job.rays.store(rays, Ordering::Relaxed);
        let mut record = job.record();
        (record.stats.rays, record.stats.picture_bytes) = (rays, bytes);
        record.stats.tiles_recovered = tiles as u64;
        record.frames.iter_mut().for_each(|frames| frames.done = done);
        Ok(missing)
    }

    /// Renders a frame, all but its file, beside others.
    fn trace(&self, number: u32, at_once: usize) -> Result<Traced, Stopped> {
        let Self { jobs, job, farm, workers, sequence, base, spec, edge, began, ref pool } = *self;
        let overrides: &Overrides = &spec.settings;
        let frame = sequence.frame(number);
        let alone = pool.lock();
        let ready = when_there_is_room(job, || jobs.cache.frame(workers, base, frame, overrides, &|_| Ok(())));
        let ready = ready.map_err(|error| job.why_stopped_or(error.into()))?;
        let rendering = job.begin_picture(Some(number));
        if edge == 0 {
            whole(job, &rendering, &ready, spec.output, workers, began).map_err(|Cancelled| job.why_stopped())?;
            drop(alone);
        } else {
            let tenant = job.record().tenant.clone();
            let share = || jobs.registry.lock().share(&tenant) / at_once as f64;
            let mut backend = backend(jobs, farm, &share);
            recover(job, &rendering, &mut *backend)?;
            let alone = (!backend.is_remote()).then_some(alone);
            tiles(job, &rendering, &ready, workers, &mut *backend)?;
            drop(alone);
        }
        let canvas = rendering.take().ok_or_else(|| job.why_stopped())?;
        let _alone = pool.lock();
        let cell = cell(sequence.count(), [ready.scene.width, ready.scene.height]);
        let preview = |canvas: &Canvas| small(&canvas.picture.film, cell);
        let coded = code(canvas, preview, &ready, spec, workers, began).map_err(|Cancelled| job.why_stopped())?;
        Ok(Traced { number, ready, coded })
    }

    /// Writes frames to disk, and publishes that they are there.
    fn write(&self, traced: Receiver<Traced>) -> Result<(), Stopped> {
        let Self { jobs, job, spec, .. } = self;
        while let Ok(Traced { number, ready, coded }) = traced.recv() {
            let encoding = Instant::now();
            let image = ready.reproducible.then(|| ImageId { scene: ready.scene_id.clone(), zoom: 0 }.to_string());
            let rays = coded.rays();
            let entered = job.control().enter();
            let files = coded.files(spec, image, &ready);
            drop(entered);
            if job.control().is_cancelled() {
                // The file may be cut short.
                return Err(job.why_stopped());
            }
            let id = job.record().id.clone();
            let kept = until_possible(job, || jobs.files.put_frame(&id, number, &files));
            if let Err(error) = kept {
                tracing::error!(%error, "a finished frame cannot be kept");
                job.stop(disk(&error));
                return Err(job.why_stopped());
            }
            jobs.files.remove_tiles(&frame_name(&id, number));
            if let Some(farm) = self.farm {
                farm.forget_results(&frame_name(&id, number));
            }
            let frames_done = {
                let mut record = job.record();
                record.stats.encode_ms += milliseconds(encoding);
                record.stats.rays += rays;
                record.stats.picture_bytes += files.made.bytes.len() as u64;
                let frames = record.frames.as_mut();
                frames.map_or(0, |frames| {
                    frames.done += 1;
                    frames.done
                })
            };
            let JobFiles { made, .. } = &files;
            let data = json!({
                "number": number, "frames_done": frames_done, "rays": rays, "image_id": made.meta.image,
                "error": made.meta.lines.iter().find(|(name, _)| name == "render-error").map(|(_, line)| line),
            });
            job.events.publish("frame", data);
        }
        Ok(())
    }
}

/// How many frames keep the job's share of the farm busy: one of this process.
fn lanes(jobs: &Jobs, job: &Job, farm: Option<&Arc<Farm>>) -> u64 {
    let Some(farm) = farm else { return 1 };
    let record = job.record().clone();
    let slots = f64::from(farm.nodes.slots()) * jobs.registry.lock().share(&record.tenant);
    ((2.0 * slots / tiles_of(&record) as f64).ceil() as u64).clamp(1, MOST_AT_ONCE)
}

impl Jobs {
    /// What is known of a finished frame; none if it is not there.
    fn frame_report(&self, id: &str, number: u32) -> io::Result<Option<FrameReport>> {
        let meta = self.files.frame_meta(id, number)?;
        Ok(meta.and_then(|meta| FrameReport::of(number, format!("/v1/jobs/{id}/frames/{number}"), &meta)))
    }

    /// The warnings of all finished frames of a job, as one line of a header.
    pub(crate) fn frame_warnings(&self, record: &Record) -> Option<String> {
        let count = record.frames.map_or(0, |frames| frames.count);
        // As far as they can be read.
        let metas = (0..count).map_while(|number| self.files.frame_meta(&record.id, number).ok()).flatten();
        let lines: Vec<_> = metas.filter_map(|meta| meta.warnings().map(str::to_owned)).collect();
        warnings::together(lines.iter().map(String::as_str))
    }

    /// What is known of all finished frames of a job, and their warnings. Most are those of all frames, so each is kept once.
    pub(crate) fn frame_reports(&self, record: &Record) -> Result<(Vec<FrameReport>, Vec<Box<RawValue>>), Error> {
        let count = record.frames.map_or(0, |frames| frames.count);
        let (mut reports, mut warnings) = (Vec::new(), Vec::<Box<RawValue>>::new());
        for number in 0..count {
            let report = self.frame_report(&record.id, number);
            let report = report.map_err(|error| Error::io("the frames cannot be read", &error))?;
            let Some(mut report) = report else { continue };
            for warning in std::mem::take(&mut report.warnings) {
                let is_told = warnings.iter().any(|told| told.get() == warning.get());
                if (warnings.len() as u64) < PROBLEMS.max && !is_told {
                    warnings.push(warning);
                }
            }
            reports.push(report);
        }
        Ok((reports, warnings))
    }
}
