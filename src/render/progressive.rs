//! Progressive rendering: the best picture in a time, or for a number of rays.
//!
//! The work is a list of chunks of pixels in five stages: one pixel in 1,024, which is always done so that every pixel shows
//! something; one in 64; all pixels, without rays of little weight; the pixels that are not yet proved to one code; and those
//! that differ from a neighbour, with more samples. Threads take chunks in order, and the picture consists of the chunks
//! before the first unfinished one. So it depends only on the number of these chunks: a number of rays gives the same picture
//! again, on any machine, with any number of threads, however often it is paused.

use super::contrast::is_uneven;
use super::packets::{KernelFormat, TraceJob, Traced};
use super::partial_picture::{PartialPicture, STRIDES};
use crate::control::{Cancelled, Control, Stopwatch};
use crate::trace::counts::RayCounts;
use crate::trace::pixel::Samples;

use super::renderer::Renderer;
use super::tiles::near;
use super::{Picture, Refined, RenderOptions};
use crate::camera::Window;
use crate::film::Region;
use crate::film::srgb::{Codes8, code8};
use crate::scene::Scene;
use crate::scene::compile::Precise;
use crate::scene::effects::REFINED_SAMPLES;
use crate::scene::world::{Pruning, World};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub enum Stop {
    /// At an instant.
    At(Instant),
    /// With the chunk that reaches this number of rays.
    Rays(u64),
}

/// How far a picture came.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "RenderProgress")]
pub struct Progress {
    /// Rays that make this picture again, in the rays mode.
    pub count: u64,
    /// Whether nothing was left to do.
    pub finished: bool,
    /// Pixels that were traced themselves; the others show a neighbour.
    pub traced_pixels: u64,
    /// Pixels that are known to need more, and have not had it: those that were not traced, as long as there are any.
    pub waiting_pixels: u64,
    /// Milliseconds that the rest would take, estimated from those before.
    pub ms_to_target: f64,
}

/// Stages, the last of which antialiasing is.
const STAGES: usize = 5;
/// Samples per pixel of the stages before every pixel has been traced.
const FEW: u32 = 4;
/// Share of the pixels that antialiasing refines in most pictures.
const UNEVEN: f64 = 0.12;
/// Weight below which rays are omitted in these stages.
const LIGHT: f64 = 0.05;
/// Pixels in a chunk of one sample each.
const CHUNK: usize = 512;

/// Renders the best picture of a region of a window that a time or a number of rays allows; the region must fit the window.
/// Every pixel of the picture shows something.
pub fn render_until(
    scene: &Scene,
    window: &Window,
    region: Region,
    control: &Control,
    stop: Stop,
) -> Result<Picture, Cancelled> {
    fn of<R: KernelFormat>(
        scene: &Scene,
        world: &World<R>,
        window: &Window,
        region: Region,
        control: &Control,
        stop: Stop,
    ) -> Result<Picture, Cancelled> {
        let renderer = Renderer::new(scene, world, control, RenderOptions::default()).through(window);
        let mut render = StagedRender::new(renderer, region, stop);
        render.go_on()?;
        Ok(render.picture())
    }
    match &scene.world {
        Precise::Single(world) => of(scene, world, window, region, control, stop),
        Precise::Double(world) => of(scene, world, window, region, control, stop),
    }
}

/// Chunks that are traced with the same settings.
struct Stage {
    pixels: Vec<[u32; 2]>,
    samples: u32,
    pruning: Pruning,
}

impl Stage {
    /// Pixels in a chunk.
    fn chunk(&self) -> usize {
        (CHUNK / self.samples as usize).max(16)
    }
}

/// A picture that is rendered in stages.
struct StagedRender<'a, R> {
    renderer: Renderer<'a, R>,
    stop: Stop,
    partial: PartialPicture,
    /// The current stage.
    number: usize,
    stage: Stage,
    /// Its finished chunks.
    chunks: usize,
    /// Their rays.
    rays: RayCounts,
    /// Whether all stages are done.
    finished: bool,
    started: Stopwatch,
    /// Time spent on the last stage.
    refining: Duration,
    /// Nanoseconds that threads have spent tracing.
    traced: u64,
}

impl<'a, R: KernelFormat> StagedRender<'a, R> {
    fn new(renderer: Renderer<'a, R>, region: Region, stop: Stop) -> Self {
        let started = Stopwatch::start();
        let partial = PartialPicture::new(region);
        let stage = renderer.stage(0, &partial);
        let (rays, refining) = (RayCounts::default(), Duration::ZERO);
        Self {
            renderer,
            stop,
            partial,
            number: 0,
            stage,
            chunks: 0,
            rays,
            finished: false,
            started,
            refining,
            traced: 0,
        }
    }

    /// Does one stage after the other until there is reason to stop.
    fn go_on(&mut self) -> Result<(), Cancelled> {
        loop {
            let working = Stopwatch::start();
            let done = self.work()?;
            if self.number + 1 == STAGES {
                self.refining += working.elapsed();
                self.finished = done;
                return Ok(());
            }
            if !done {
                return Ok(());
            }
            self.number += 1;
            self.stage = self.renderer.stage(self.number, &self.partial);
            (self.chunks, self.rays) = (0, RayCounts::default());
        }
    }

    /// Works on the current stage; whether it is done.
    fn work(&mut self) -> Result<bool, Cancelled> {
        let control = self.renderer.control;
        // The first stage is always finished, so that every pixel shows something.
        let stop = Some(self.stop).filter(|_| self.number > 0);
        if self.stage.pixels.is_empty() {
            return Ok(true);
        }
        // It stops work inside of chunks, which may take seconds.
        let halt = match stop {
            Some(Stop::At(end)) => Control::until(end),
            _ => Control::default(),
        };
        if halt.is_cancelled() || self.is_full(stop) {
            return Ok(false);
        }
        let Self { renderer, partial, stage, chunks: counted, rays, traced: nanoseconds, .. } = self;
        let busy = AtomicU64::new(0);
        let chunks: Vec<&[[u32; 2]]> = stage.pixels.chunks(stage.chunk()).collect();
        let next = AtomicUsize::new(0);
        let done = Mutex::new(Done { partial, early: BTreeMap::new(), chunks: 0, rays: *rays, full: false });
        let job = TraceJob { pruning: stage.pruning, control: &halt, ..renderer.job.clone() };
        let take = || {
            let _entered = control.enter();
            while !halt.is_cancelled() {
                let number = next.fetch_add(1, Ordering::Relaxed);
                let Some(at) = chunks.get(number) else { return };
                let mut traced = Traced::default();
                let tracing = Stopwatch::start();
                R::trace(renderer.options.level, &job, at, Samples::of_picture(stage.samples), &mut traced);
                control.add_rays(traced.rays.total());
                busy.fetch_add(tracing.elapsed().as_nanos() as u64, Ordering::Relaxed);
                let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
                if halt.stops() || done.full {
                    return;
                }
                done.early.insert(number, traced);
                done.settle(&chunks, stage.samples, stop);
                control.add_done(at.len() as u64);
            }
        };
        rayon::broadcast(|_| take());
        let done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
        (*counted, *rays) = (done.chunks, done.rays);
        *nanoseconds += busy.into_inner();
        if control.stops() { Err(Cancelled) } else { Ok(*counted == chunks.len()) }
    }

    /// Whether the rays are used up.
    fn is_full(&self, stop: Option<Stop>) -> bool {
        matches!(stop, Some(Stop::Rays(count)) if self.partial.rays.total() >= count)
    }

    fn picture(self) -> Picture {
        let Self { renderer, partial, number, stage, chunks, rays, finished, started, refining, traced, .. } = self;
        let pixels = (chunks * stage.chunk()).min(stage.pixels.len());
        let waiting = match number {
            0..=2 => partial.region.pixels() - partial.traced_pixels(),
            _ => (stage.pixels.len() - pixels) as u64,
        };
        let ms_to_target = if finished {
            0.0
        } else {
            let samples = waiting * u64::from(stage.samples) + renderer.later(number, &partial);
            let threads = rayon::current_num_threads() as f64;
            samples as f64 * traced as f64 * 1e-6 / (threads * partial.traced_samples().max(1) as f64)
        };
        let progress = Progress {
            count: partial.rays.total(),
            finished,
            traced_pixels: partial.traced_pixels(),
            waiting_pixels: waiting,
            ms_to_target,
        };
        let refined = if number + 1 == STAGES { Refined { pixels: pixels as u64, rays } } else { Refined::default() };
        // A single pixel has no neighbours to estimate its interval from.
        let alone = renderer.scene.samples == 1 && partial.traced_samples() == 1 && partial.region.pixels() == 1;
        let tells = (renderer.scene.refines() || renderer.scene.samples > 1) && !alone;
        let picture = renderer.picture_of(partial.region, partial.filled(tells), refined);
        let trace_ms = started.milliseconds();
        Picture { progress: Some(progress), trace_ms, refine_ms: refining.as_secs_f64() * 1e3, ..picture }
    }
}

impl<R: KernelFormat> Renderer<'_, R> {
    /// An estimate of the samples of the following stages, from a few of the pixels.
    fn later(&self, number: usize, partial: &PartialPicture) -> u64 {
        let few = Region::whole(partial.region.width, partial.region.height).iter().step_by(61);
        let few: Vec<[u32; 2]> = few.map(|[x, y]| [partial.region.x + x, partial.region.y + y]).collect();
        let few: Vec<[u32; 2]> = few.into_iter().filter(|at| partial.samples[partial.region.index(*at)] > 0).collect();
        let share = partial.region.pixels() as f64 / few.len().max(1) as f64;
        let poor = few.iter().filter(|at| number < 3 && self.is_poor(**at, partial)).count();
        let uneven = match number {
            // For pixels without traced neighbours there is no estimate.
            0..=2 if self.scene.refines() => few.len() as f64 * UNEVEN,
            0..=3 => few.iter().filter(|at| self.is_uneven(**at, partial)).count() as f64,
            _ => 0.0,
        };
        let samples = poor as f64 * f64::from(self.scene.samples) + uneven * f64::from(REFINED_SAMPLES);
        (samples * share) as u64
    }

    /// Whether a pixel needs more of its base samples.
    fn is_poor(&self, at: [u32; 2], partial: &PartialPicture) -> bool {
        let index = partial.region.index(at);
        let (codes, shown, highest) = (Codes8::get(), partial.shown[index], partial.highest[index]);
        let apart = (0..3).any(|c| codes.code(highest[c]).saturating_sub(codes.code(shown[c])) > 1);
        apart || partial.samples[index] < self.scene.samples
    }

    fn is_uneven(&self, [x, y]: [u32; 2], partial: &PartialPicture) -> bool {
        self.scene.refines()
            && is_uneven(|x, y| partial.shown[partial.region.index([x, y])].map(code8), partial.region, x, y)
    }

    fn stage(&self, number: usize, partial: &PartialPicture) -> Stage {
        let (samples, proved) = (self.scene.samples, Pruning::Proved { max_codes: 1 });
        let (few, light) = (samples.min(FEW), Pruning::Weight(LIGHT));
        let (samples, pruning) = match number {
            0..=2 => (few, light),
            3 => (samples, proved),
            _ => (REFINED_SAMPLES, proved),
        };
        let wanted = |at: [u32; 2]| match number {
            0 => partial.is_first(at, STRIDES[0]),
            1 => partial.is_first(at, STRIDES[1]) && !partial.is_first(at, STRIDES[0]),
            2 => !partial.is_first(at, STRIDES[1]),
            3 => self.is_poor(at, partial),
            _ => self.is_uneven(at, partial),
        };
        let pixels = near(partial.region, wanted);
        self.control.add_total(pixels.len() as u64);
        Stage { pixels, samples, pruning }
    }
}

/// The progress of a stage.
struct Done<'a> {
    partial: &'a mut PartialPicture,
    /// Chunks that were finished before an earlier one.
    early: BTreeMap<usize, Traced>,
    /// Finished chunks without a gap.
    chunks: usize,
    /// Their rays.
    rays: RayCounts,
    /// Whether the rays are used up.
    full: bool,
}

impl Done<'_> {
    /// Adds the chunks that are next in order to the picture.
    fn settle(&mut self, chunks: &[&[[u32; 2]]], samples: u32, stop: Option<Stop>) {
        loop {
            if matches!(stop, Some(Stop::Rays(count)) if self.partial.rays.total() >= count) {
                self.full = true;
                return;
            }
            let Some(traced) = self.early.remove(&self.chunks) else { return };
            self.rays = self.rays + traced.rays;
            self.partial.paint(chunks[self.chunks], samples, &traced);
            self.chunks += 1;
        }
    }
}
