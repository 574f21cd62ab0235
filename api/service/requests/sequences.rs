//! Sequences: every frame is checked before a job of them is accepted, and a few are estimated.

use super::Service;
use super::jobs::WantedJob;
use crate::service::error::Error;
use crate::service::jobs::Job;
use crate::service::jobs::record::{JobSpec, Record};
use crate::service::memory_budget::MeteredBytes;
use crate::service::scenes::prepared::planned;
use crate::service::scenes::sent_scene::SentScene;
use crate::service::scheduler::admission::Work;
use crate::service::sequences::Frames;
use crate::service::sequences::price::{Price, is_pilot, price};
use crate::service::sequences::shown::{animation, in_words};
use crate::service::sequences::text::join;
use std::time::{Duration, Instant};
use strahl::control;
use strahl::film::Region;
use strahl::film::animation::{Animation, AnimationFormat};
use strahl::film::sheet::{Sheet, cell, columns};
use strahl::scene::assets::named_in;
use strahl::scene::description::ImageSize;
use strahl::scene::problem::Code;
use strahl::scene::{Description, Format, Problem, Problems};
use strahl::sequence::Sequence;

/// No frame is estimated once estimates have taken this long together.
const PILOTING: Duration = Duration::from_millis(500);

/// What all frames have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Common {
    size: [u32; 2],
    transparent: bool,
}

/// What a check of all frames finds.
struct Checked {
    common: Common,
    price: Price,
    /// Bytes of the scene and of the largest two frames beside it.
    scene_bytes: u64,
    /// Whether a time or a number of rays ends a frame.
    progressive: bool,
}

impl Service {
    /// The record of a job of frames, and the text of its sequence and its scene.
    pub(super) fn check_sequence(
        &self,
        work: &Work,
        wanted: WantedJob,
        sequence: &Sequence,
    ) -> Result<(Record, MeteredBytes), Error> {
        sequence.check()?;
        let WantedJob { scene, form, overrides, output, priority, labels, .. } = wanted;
        let sent = SentScene::new(scene.as_ref(), &form, &overrides);
        let Checked { common, price, scene_bytes, progressive } = self.check_frames(work, &sent, sequence)?;
        self.check_time(price.ms)?;
        let [width, height] = common.size;
        let pixels = u64::from(width) * u64::from(height);
        let edge = if progressive { 0 } else { self.jobs.tile_edge(pixels, price.ms / f64::from(sequence.count())) };
        let (format, scene, settings) = self.text_of_job(work, scene, &form, overrides, common.size)?;
        let text = join(sequence, scene.as_ref()).map_err(|_| Error::Internal("the sequence cannot be written"))?;
        let text = self.memory.metered(text)?;
        // Frames may name others than the scene.
        let assets = if format == Format::Json { named_in(text.as_ref()) } else { Vec::new() };
        let spec = JobSpec { scene: String::new(), format, settings, output };
        let frames = Some(Frames::of(sequence));
        let job = Record { priority, labels, frames, width, height, edge, assets, ..Record::new(spec) };
        Ok((Record { estimate_ms: price.ms, estimate_rays: price.rays, scene_bytes, ..job }, text))
    }

    fn check_frames(&self, work: &Work, sent: &SentScene<'_>, sequence: &Sequence) -> Result<Checked, Error> {
        let limits = &self.jobs.limits;
        let base = self.scenes.to_vary(&work.workers, sent)?;
        let (mut common, mut pilots, mut largest, mut progressive) = (None, Vec::new(), 0, false);
        let (mut piloting, mut building) = (Duration::ZERO, Vec::new());
        for frame in sequence.frames() {
            let accept = |scene: &Description| {
                let ImageSize { width, height } = scene.image;
                limits.check([width, height], scene.render.samples.unwrap_or(1))?;
                let first = common.map_or([width, height], |common: Common| common.size);
                if first == [width, height] { Ok(()) } else { Err(other_size(frame.number, [width, height], first)) }
            };
            let began = Instant::now();
            let ready = self.scenes.frame(&work.workers, &base, frame, &sent.overrides, &accept)?;
            building.push(began.elapsed());
            let size = [ready.scene.width, ready.scene.height];
            limits.check(size, ready.scene.samples)?;
            let own = Common { size, transparent: ready.scene.is_transparent() };
            if *common.get_or_insert(own) != own {
                return Err(other_background(frame.number));
            }
            largest = ready.bytes().max(largest);
            progressive |= ready.render.accuracy().is_budget();
            // Where one block of pixels takes seconds, the first frames tell about the others.
            if is_pilot(frame.number, sequence.count()) && piloting < PILOTING {
                let began = Instant::now();
                let (plan, _) = planned(&ready, Region::whole(size[0], size[1]), &work.workers, &work.control)?;
                pilots.extend(plan.estimate.map(|estimate| (frame.number, estimate)));
                piloting += began.elapsed();
            }
        }
        let common = common.ok_or(Error::Internal("a sequence has no frames"))?;
        // The median, since others may have had the pool meanwhile.
        let (_, building, _) = building.select_nth_unstable(sequence.count() as usize / 2);
        let price = price(sequence.count(), &pilots, *building);
        Ok(Checked { common, price, scene_bytes: base.bytes() + 2 * largest, progressive })
    }

    /// An animation of all frames of a job that has succeeded, in one of its formats; none if a frame is damaged or gone.
    pub(crate) fn animation(&self, job: &Job, format: AnimationFormat) -> Result<Option<Animation>, Error> {
        let record = job.record().clone();
        let Some(frames) = record.frames else { return Ok(None) };
        let mut files = Vec::new();
        for number in 0..frames.count {
            let Some(file) = self.jobs.frame(job, number)? else { return Ok(None) };
            files.push(file);
        }
        // The animation is about as large as all frames together.
        let mut share = self.memory.share(0);
        share.grow(files.iter().map(|file| file.bytes.len() as u64).sum())?;
        if format.frames().is_none() {
            // Frames are decoded, a few at a time.
            share
                .grow(12 * rayon::current_num_threads() as u64 * u64::from(record.width) * u64::from(record.height))?;
        }
        let files: Vec<&[u8]> = files.iter().map(|file| &file.bytes[..]).collect();
        let made = animation(&files, record.spec.output, format, frames.timing());
        made.map(Some).map_err(|why| Error::Internal(in_words(why)))
    }

    /// A contact sheet of the frames that are finished; none if there is none yet.
    pub(crate) fn sheet(&self, job: &Job, across: Option<u32>) -> Result<Option<Vec<u8>>, Error> {
        let record = job.record().clone();
        let Some(frames) = record.frames else { return Ok(None) };
        let size = [record.width, record.height];
        let cell = cell(frames.count, size);
        let across = across.unwrap_or_else(|| columns(frames.count, size)).min(frames.count);
        let pixels = u64::from(across) * u64::from(frames.count.div_ceil(across)) * u64::from(cell[0] * cell[1]);
        let mut share = self.memory.share(0);
        share.grow(8 * pixels)?;
        let mut sheet = Sheet::new(frames.count, cell, across);
        let mut is_empty = true;
        for number in 0..frames.count {
            control::look_now()?;
            if let Some(png) = self.jobs.small_frame(job, number)? {
                sheet.put(number, &png);
                is_empty = false;
            }
        }
        Ok((!is_empty).then(|| sheet.png()))
    }
}

fn other_size(number: u32, [width, height]: [u32; 2], first: [u32; 2]) -> Error {
    let [w, h] = first;
    let detail = format!("in frame {number}: {width} x {height} pixels; all frames have those of the first, {w} x {h}");
    Error::Scene(Problems::one(Problem::new("/image", Code::OutOfRange, detail)))
}

fn other_background(number: u32) -> Error {
    let detail = format!("in frame {number}: the background is transparent in some frames, and not in others");
    Error::Scene(Problems::one(Problem::new("/film/background", Code::OutOfRange, detail)))
}
