//! The best picture in a time, or for a number of rays.
//!
//! Work is a list of parcels of pixels, in stages: one pixel in 1,024, whatever the time, so that something stands
//! everywhere; one in 64; all pixels, with light rays left out; those proved to at most one code that are not; and those
//! that differ from a neighbour, with more samples. Threads take parcels in order, and the picture is made of the parcels up
//! to the first one that was not finished. So it is a function of how many parcels count, and of the rays in them: a number
//! of rays makes the same picture again, on any machine and any number of threads, and in any number of turns.

use super::canvas::{Canvas, STRIDES};
use super::contrast::{REFINED_SAMPLES, is_uneven, refines};
use super::packets::{Job, Kernel, Traced};
use crate::trace::control::{Cancelled, Control};
use crate::trace::counts::RayCounts;
use crate::trace::pixel::Samples;

use super::renderer::Renderer;
use super::tiles::near;
use super::{Cut, Picture, Refined};
use crate::camera::Window;
use crate::film::Region;
use crate::film::srgb::{Codes8, code8};
use crate::scene::Scene;
use crate::scene::compile::Precise;
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
    /// With the parcel in which so many rays are reached.
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
/// Samples of the stages before every pixel has been traced.
const FEW: u32 = 4;
/// Share of the pixels that antialiasing refines in most pictures.
const UNEVEN: f64 = 0.12;
/// Weight below which rays are left out in these stages.
const LIGHT: f64 = 0.05;
/// Pixels in a parcel of one sample each.
const PARCEL: usize = 512;
/// How often somebody looks whether it is time to stop.
const LOOK: Duration = Duration::from_millis(1);

/// A picture on its way, which can be left and taken up again.
pub struct Progressive<'a>(Of<'a>);

enum Of<'a> {
    Single(Course<'a, f32>),
    Double(Course<'a, f64>),
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
                let renderer = Renderer::new(scene, world, control, Cut::default()).through(window);
                Of::Single(Course::new(renderer, region, stop))
            }
            Precise::Double(world) => {
                let renderer = Renderer::new(scene, world, control, Cut::default()).through(window);
                Of::Double(Course::new(renderer, region, stop))
            }
        })
    }

    /// Goes on, on the current rayon pool, until there is reason to stop or the pool is needed elsewhere. Returns whether
    /// there is more to do.
    pub fn go_on(&mut self, pause: Option<Instant>) -> Result<bool, Cancelled> {
        match &mut self.0 {
            Of::Single(course) => course.go_on(pause),
            Of::Double(course) => course.go_on(pause),
        }
    }

    /// The picture as it is. Once [`Self::go_on`] has returned, every pixel shows something.
    pub fn picture(self) -> Picture {
        match self.0 {
            Of::Single(course) => course.picture(),
            Of::Double(course) => course.picture(),
        }
    }
}

/// Parcels that are traced alike.
struct Stage {
    pixels: Vec<[u32; 2]>,
    samples: u32,
    pruning: Pruning,
}

impl Stage {
    /// Pixels in a parcel.
    fn parcel(&self) -> usize {
        (PARCEL / self.samples as usize).max(16)
    }
}

/// A picture on its way through the stages.
struct Course<'a, R> {
    renderer: Renderer<'a, R>,
    stop: Stop,
    canvas: Canvas,
    /// The stage at hand.
    number: usize,
    stage: Stage,
    /// Its parcels that count.
    parcels: usize,
    /// Their rays.
    rays: RayCounts,
    /// Whether all stages are done.
    finished: bool,
    /// Time spent on all of them, and on the last.
    spent: Duration,
    refining: Duration,
    /// Nanoseconds that threads have spent tracing.
    traced: u64,
}

/// Why a stage was left.
enum Left {
    Done,
    Stopped,
    Paused,
}

impl<'a, R: Kernel> Course<'a, R> {
    fn new(renderer: Renderer<'a, R>, region: Region, stop: Stop) -> Self {
        let started = Instant::now();
        let canvas = Canvas::new(region);
        let stage = renderer.stage(0, &canvas);
        let (rays, refining, spent) = (RayCounts::default(), Duration::ZERO, started.elapsed());
        Self { renderer, stop, canvas, number: 0, stage, parcels: 0, rays, finished: false, spent, refining, traced: 0 }
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
                Left::Paused => break true,
                Left::Stopped => break false,
                Left::Done if self.number + 1 == STAGES => {
                    self.finished = true;
                    break false;
                }
                Left::Done => {
                    self.number += 1;
                    self.stage = self.renderer.stage(self.number, &self.canvas);
                    (self.parcels, self.rays) = (0, RayCounts::default());
                }
            }
        };
        self.spent += started.elapsed();
        Ok(more)
    }

    /// Goes on with the stage at hand.
    fn work(&mut self, pause: Option<Instant>) -> Result<Left, Cancelled> {
        let control = self.renderer.control;
        // Something has to stand everywhere.
        let stop = Some(self.stop).filter(|_| self.number > 0);
        if self.stage.pixels.is_empty() {
            return Ok(Left::Done);
        }
        if is_late(stop) || self.is_full(stop) {
            return Ok(Left::Stopped);
        }
        let Self { renderer, canvas, stage, parcels: counted, rays, traced: nanoseconds, .. } = self;
        let busy = AtomicU64::new(0);
        let parcels: Vec<&[[u32; 2]]> = stage.pixels.chunks(stage.parcel()).collect();
        let (next, halt) = (AtomicUsize::new(*counted), AtomicBool::new(false));
        let done = Mutex::new(Done { canvas, early: BTreeMap::new(), parcels: *counted, rays: *rays, full: false });
        let job = Job { pruning: stage.pruning, cancelled: &halt, ..renderer.job.clone() };
        let take = || {
            // At least one parcel each turn, however short the turn is, so that any number of turns ends the picture.
            loop {
                // Between parcels the clock is read here: the watcher below may not have been given a processor yet.
                if is_late(stop) {
                    halt.store(true, Ordering::Relaxed);
                    return;
                }
                let number = next.fetch_add(1, Ordering::Relaxed);
                let Some(at) = parcels.get(number) else { return };
                let mut traced = Traced::default();
                let tracing = Instant::now();
                R::trace(renderer.cut.level, &job, at, Samples::of_picture(stage.samples), &mut traced);
                busy.fetch_add(tracing.elapsed().as_nanos() as u64, Ordering::Relaxed);
                let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
                if halt.load(Ordering::Relaxed) || done.full {
                    return;
                }
                done.early.insert(number, traced);
                done.settle(&parcels, stage.samples, stop);
                control.done.fetch_add(at.len() as u64, Ordering::Relaxed);
                if pause.is_some_and(|pause| Instant::now() >= pause) {
                    return;
                }
            }
        };
        let watch = AtomicBool::new(true);
        thread::scope(|scope| {
            scope.spawn(|| {
                // What goes on inside a parcel, which may take seconds, only this thread can end.
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
        (*counted, *rays) = (done.parcels, done.rays);
        *nanoseconds += busy.into_inner();
        let full = done.full;
        match () {
            () if control.cancelled.load(Ordering::Relaxed) => Err(Cancelled),
            () if *counted == parcels.len() => Ok(Left::Done),
            () if full || halt.into_inner() => Ok(Left::Stopped),
            () => Ok(Left::Paused),
        }
    }

    /// Whether the rays are used up.
    fn is_full(&self, stop: Option<Stop>) -> bool {
        matches!(stop, Some(Stop::Rays(count)) if self.canvas.rays.total() >= count)
    }

    fn picture(self) -> Picture {
        let Self { renderer, canvas, number, stage, parcels, rays, finished, spent, refining, traced, .. } = self;
        let started = Instant::now();
        let pixels = (parcels * stage.parcel()).min(stage.pixels.len());
        let waiting = match number {
            0..=2 => canvas.region.pixels() - canvas.traced_pixels(),
            _ => (stage.pixels.len() - pixels) as u64,
        };
        let ms_to_target = if finished {
            0.0
        } else {
            let samples = waiting * u64::from(stage.samples) + renderer.later(number, &canvas);
            let threads = rayon::current_num_threads() as f64;
            samples as f64 * traced as f64 * 1e-6 / (threads * canvas.traced_samples().max(1) as f64)
        };
        let progress = Progress {
            count: canvas.rays.total(),
            finished,
            traced_pixels: canvas.traced_pixels(),
            waiting_pixels: waiting,
            ms_to_target,
        };
        let refined = if number + 1 == STAGES { Refined { pixels: pixels as u64, rays } } else { Refined::default() };
        // A single pixel has no neighbours to tell how far its one sample is off.
        let alone = renderer.scene.samples == 1 && canvas.traced_samples() == 1 && canvas.region.pixels() == 1;
        let tells = (refines(renderer.scene) || renderer.scene.samples > 1) && !alone;
        let picture = renderer.picture_of(canvas.region, canvas.filled(tells), refined);
        let trace_ms = (spent + started.elapsed()).as_secs_f64() * 1e3;
        Picture { progress: Some(progress), trace_ms, refine_ms: refining.as_secs_f64() * 1e3, ..picture }
    }
}

impl<R: Kernel> Renderer<'_, R> {
    /// Samples that the stages after one are likely to take, from a few of the pixels.
    fn later(&self, number: usize, canvas: &Canvas) -> u64 {
        let few = Region::whole(canvas.region.width, canvas.region.height).iter().step_by(61);
        let few: Vec<[u32; 2]> = few.map(|[x, y]| [canvas.region.x + x, canvas.region.y + y]).collect();
        let few: Vec<[u32; 2]> = few.into_iter().filter(|at| canvas.samples[canvas.region.index(*at)] > 0).collect();
        let share = canvas.region.pixels() as f64 / few.len().max(1) as f64;
        let poor = few.iter().filter(|at| number < 3 && self.is_poor(**at, canvas)).count();
        let uneven = match number {
            // Of pixels whose neighbours are not traced nobody knows.
            0..=2 if refines(self.scene) => few.len() as f64 * UNEVEN,
            0..=3 => few.iter().filter(|at| self.is_uneven(**at, canvas)).count() as f64,
            _ => 0.0,
        };
        let samples = poor as f64 * f64::from(self.scene.samples) + uneven * f64::from(REFINED_SAMPLES);
        (samples * share) as u64
    }

    /// Whether a pixel has not yet had all that its base samples can give.
    fn is_poor(&self, at: [u32; 2], canvas: &Canvas) -> bool {
        let index = canvas.region.index(at);
        let (codes, shown, highest) = (Codes8::get(), canvas.shown[index], canvas.highest[index]);
        let apart = (0..3).any(|c| codes.code(highest[c]).saturating_sub(codes.code(shown[c])) > 1);
        apart || canvas.samples[index] < self.scene.samples
    }

    fn is_uneven(&self, [x, y]: [u32; 2], canvas: &Canvas) -> bool {
        refines(self.scene)
            && is_uneven(|x, y| canvas.shown[canvas.region.index([x, y])].map(code8), canvas.region, x, y)
    }

    fn stage(&self, number: usize, canvas: &Canvas) -> Stage {
        let (samples, proved) = (self.scene.samples, Pruning::Proved { max_codes: 1 });
        let (few, light) = (samples.min(FEW), Pruning::Weight(LIGHT));
        let (samples, pruning) = match number {
            0..=2 => (few, light),
            3 => (samples, proved),
            _ => (REFINED_SAMPLES, proved),
        };
        let wanted = |at: [u32; 2]| match number {
            0 => canvas.is_first(at, STRIDES[0]),
            1 => canvas.is_first(at, STRIDES[1]) && !canvas.is_first(at, STRIDES[0]),
            2 => !canvas.is_first(at, STRIDES[1]),
            3 => self.is_poor(at, canvas),
            _ => self.is_uneven(at, canvas),
        };
        let pixels = near(canvas.region, wanted);
        self.control.total.fetch_add(pixels.len() as u64, Ordering::Relaxed);
        Stage { pixels, samples, pruning }
    }
}

/// Whether the time is up.
fn is_late(stop: Option<Stop>) -> bool {
    matches!(stop, Some(Stop::At(end)) if Instant::now() >= end)
}

/// What a stage has done so far.
struct Done<'a> {
    canvas: &'a mut Canvas,
    /// Parcels that are finished before one that comes first.
    early: BTreeMap<usize, Traced>,
    /// Parcels that count.
    parcels: usize,
    /// Their rays.
    rays: RayCounts,
    /// Whether the rays are used up.
    full: bool,
}

impl Done<'_> {
    /// Paints the parcels that are next in order.
    fn settle(&mut self, parcels: &[&[[u32; 2]]], samples: u32, stop: Option<Stop>) {
        loop {
            if matches!(stop, Some(Stop::Rays(count)) if self.canvas.rays.total() >= count) {
                self.full = true;
                return;
            }
            let Some(traced) = self.early.remove(&self.parcels) else { return };
            self.rays = self.rays + traced.rays;
            self.canvas.paint(parcels[self.parcels], samples, &traced);
            self.parcels += 1;
        }
    }
}
