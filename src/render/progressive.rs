//! Progressive rendering: the best picture in a time, or for a number of rays.
//!
//! The work is a list of chunks of pixels in five stages: one pixel in 1,024, which is always done so that every pixel shows
//! something; one in 64; all pixels, without rays of little weight; the pixels that are not yet proved to one code; and those
//! that differ from a neighbour, with more samples. Threads take chunks in order, and the picture consists of the chunks
//! before the first unfinished one. So it depends only on the number of these chunks: a number of rays gives the same picture
//! again, on any machine, with any number of threads, and in any number of time slices.

use super::contrast::is_uneven;
use super::packets::{KernelFormat, TraceJob, Traced};
use super::partial_picture::{PartialPicture, STRIDES};
use crate::trace::control::{Cancelled, Control};
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
use crate::scene::world::Pruning;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
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
/// How often the clock and the flags are checked.
const LOOK: Duration = Duration::from_millis(1);

/// A progressive render, which can be paused and continued.
pub struct Progressive<'a>(Of<'a>);

enum Of<'a> {
    Single(StagedRender<'a, f32>),
    Double(StagedRender<'a, f64>),
}

impl std::fmt::Debug for Progressive<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Progressive").finish_non_exhaustive()
    }
}

impl<'a> Progressive<'a> {
    /// Begins with a region of what a window shows, which must fit the window.
    pub fn new(scene: &'a Scene, window: &Window, region: Region, control: &'a Control, stop: Stop) -> Self {
        Self(match &scene.world {
            Precise::Single(world) => {
                let renderer = Renderer::new(scene, world, control, RenderOptions::default()).through(window);
                Of::Single(StagedRender::new(renderer, region, stop))
            }
            Precise::Double(world) => {
                let renderer = Renderer::new(scene, world, control, RenderOptions::default()).through(window);
                Of::Double(StagedRender::new(renderer, region, stop))
            }
        })
    }

    /// Goes on, on the current rayon pool, until it has to stop or to pause. Returns whether there is more to do.
    pub fn go_on(&mut self, pause: Option<Instant>) -> Result<bool, Cancelled> {
        match &mut self.0 {
            Of::Single(render) => render.go_on(pause),
            Of::Double(render) => render.go_on(pause),
        }
    }

    /// The picture so far. Once [`Self::go_on`] has returned, every pixel shows something.
    pub fn picture(self) -> Picture {
        match self.0 {
            Of::Single(render) => render.picture(),
            Of::Double(render) => render.picture(),
        }
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
    /// Time spent on all stages, and on the last.
    spent: Duration,
    refining: Duration,
    /// Nanoseconds that threads have spent tracing.
    traced: u64,
}

/// How work on a stage ended.
enum Outcome {
    Done,
    Stopped,
    Paused,
}

impl<'a, R: KernelFormat> StagedRender<'a, R> {
    fn new(renderer: Renderer<'a, R>, region: Region, stop: Stop) -> Self {
        let started = Instant::now();
        let partial = PartialPicture::new(region);
        let stage = renderer.stage(0, &partial);
        let (rays, refining, spent) = (RayCounts::default(), Duration::ZERO, started.elapsed());
        Self { renderer, stop, partial, number: 0, stage, chunks: 0, rays, finished: false, spent, refining, traced: 0 }
    }

    fn go_on(&mut self, pause: Option<Instant>) -> Result<bool, Cancelled> {
        let started = Instant::now();
        let more = loop {
            let working = Instant::now();
            let left = self.work(pause)?;
            if self.number + 1 == STAGES {
                self.refining += working.elapsed();
            }
            match left {
                Outcome::Paused => break true,
                Outcome::Stopped => break false,
                Outcome::Done if self.number + 1 == STAGES => {
                    self.finished = true;
                    break false;
                }
                Outcome::Done => {
                    self.number += 1;
                    self.stage = self.renderer.stage(self.number, &self.partial);
                    (self.chunks, self.rays) = (0, RayCounts::default());
                }
            }
        };
        self.spent += started.elapsed();
        Ok(more)
    }

    /// Goes on with the current stage.
    fn work(&mut self, pause: Option<Instant>) -> Result<Outcome, Cancelled> {
        let control = self.renderer.control;
        // The first stage is always finished, so that every pixel shows something.
        let stop = Some(self.stop).filter(|_| self.number > 0);
        if self.stage.pixels.is_empty() {
            return Ok(Outcome::Done);
        }
        if is_late(stop) || self.is_full(stop) {
            return Ok(Outcome::Stopped);
        }
        let Self { renderer, partial, stage, chunks: counted, rays, traced: nanoseconds, .. } = self;
        let busy = AtomicU64::new(0);
        let chunks: Vec<&[[u32; 2]]> = stage.pixels.chunks(stage.chunk()).collect();
        let (next, halt) = (AtomicUsize::new(*counted), AtomicBool::new(false));
        let done = Mutex::new(Done { partial, early: BTreeMap::new(), chunks: *counted, rays: *rays, full: false });
        let job = TraceJob { pruning: stage.pruning, cancelled: &halt, ..renderer.job.clone() };
        let take = || {
            // At least one chunk in each time slice, so that every picture ends.
            loop {
                // Between chunks the clock is read here: the thread below may not have started yet.
                if is_late(stop) {
                    halt.store(true, Ordering::Relaxed);
                    return;
                }
                let number = next.fetch_add(1, Ordering::Relaxed);
                let Some(at) = chunks.get(number) else { return };
                let mut traced = Traced::default();
                let tracing = Instant::now();
                R::trace(renderer.options.level, &job, at, Samples::of_picture(stage.samples), &mut traced);
                busy.fetch_add(tracing.elapsed().as_nanos() as u64, Ordering::Relaxed);
                let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
                if halt.load(Ordering::Relaxed) || done.full {
                    return;
                }
                done.early.insert(number, traced);
                done.settle(&chunks, stage.samples, stop);
                control.done.fetch_add(at.len() as u64, Ordering::Relaxed);
                if pause.is_some_and(|pause| Instant::now() >= pause) {
                    return;
                }
            }
        };
        let watch = AtomicBool::new(true);
        thread::scope(|scope| {
            scope.spawn(|| {
                // This thread stops work inside of chunks, which may take seconds.
                while watch.load(Ordering::Relaxed) {
                    if is_late(stop) || control.cancelled.load(Ordering::Relaxed) {
                        halt.store(true, Ordering::Relaxed);
                        return;
                    }
                    thread::sleep(LOOK);
                }
            });
            rayon::broadcast(|_| take());
            watch.store(false, Ordering::Relaxed);
        });
        let done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
        (*counted, *rays) = (done.chunks, done.rays);
        *nanoseconds += busy.into_inner();
        let full = done.full;
        match () {
            () if control.cancelled.load(Ordering::Relaxed) => Err(Cancelled),
            () if *counted == chunks.len() => Ok(Outcome::Done),
            () if full || halt.into_inner() => Ok(Outcome::Stopped),
            () => Ok(Outcome::Paused),
        }
    }

    /// Whether the rays are used up.
    fn is_full(&self, stop: Option<Stop>) -> bool {
        matches!(stop, Some(Stop::Rays(count)) if self.partial.rays.total() >= count)
    }

    fn picture(self) -> Picture {
        let Self { renderer, partial, number, stage, chunks, rays, finished, spent, refining, traced, .. } = self;
        let started = Instant::now();
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
        let trace_ms = (spent + started.elapsed()).as_secs_f64() * 1e3;
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
        self.control.total.fetch_add(pixels.len() as u64, Ordering::Relaxed);
        Stage { pixels, samples, pruning }
    }
}

/// Whether the time is up.
fn is_late(stop: Option<Stop>) -> bool {
    matches!(stop, Some(Stop::At(end)) if Instant::now() >= end)
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
