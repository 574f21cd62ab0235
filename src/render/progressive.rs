//! Progressive rendering: the best picture in a time, or for a number of rays.
//!
//! The work is a ladder (`ladder.rs`): first coarse pictures of it all, each finer than the one before, then what improves the
//! picture most for each ray. Each rung is a list of chunks of pixels. Threads take chunks in order, and the picture consists of
//! the chunks before the first unfinished one. So it depends only on the number of these chunks: a number of rays gives the same
//! picture again, on any machine, with any number of threads, however often it is paused.

use super::ladder::{Chunk, Ladder};
use super::packets::{KernelFormat, TraceJob, Traced};
use super::partial_picture::PartialPicture;
use crate::control::{Cancelled, Control, Stopwatch};
use crate::trace::pixel::Samples;

use super::renderer::Renderer;
use super::{Picture, Refined, RenderOptions};
use crate::camera::Window;
use crate::film::{Film, Region};
use crate::lanes::MAX_LANES;
use crate::scene::Scene;
use crate::scene::compile::with_world;
use crate::scene::world::World;
use parking_lot::Mutex;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub enum Stop {
    /// At an instant.
    At(Instant),
    /// With the chunk that reaches this number of rays, or inside of it if it alone takes more.
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
    /// Pixels that were traced themselves; the others are interpolated.
    pub traced_pixels: u64,
    /// Pixels that are known to need more, and have not had it: those that were not traced, as long as there are any.
    pub waiting_pixels: u64,
    /// Milliseconds that the rest would take, estimated from those before.
    pub ms_to_target: f64,
}

/// Rays that are so few that one chunk may take them.
const FEW: u64 = 1 << 22;

/// Is shown the picture so far after each rung, and the distance of the pixels that are certainly traced, across and down.
pub type Watcher<'a> = &'a mut (dyn FnMut(Film, u32) + Send);

/// Renders the best picture of a region of a window that a time or a number of rays allows; the region must fit the window.
/// Every pixel of the picture shows something.
pub fn render_until(
    scene: &Scene,
    window: &Window,
    region: Region,
    control: &Control,
    stop: Stop,
) -> Result<Picture, Cancelled> {
    render_watched(scene, window, region, control, stop, None)
}

/// The same, for a watcher. The time that it takes is part of the time.
pub fn render_watched(
    scene: &Scene,
    window: &Window,
    region: Region,
    control: &Control,
    stop: Stop,
    watcher: Option<Watcher<'_>>,
) -> Result<Picture, Cancelled> {
    fn of<R: KernelFormat>(
        scene: &Scene,
        world: &World<R>,
        window: &Window,
        region: Region,
        control: &Control,
        stop: Stop,
        watcher: Option<Watcher<'_>>,
    ) -> Result<Picture, Cancelled> {
        let renderer = Renderer::new(scene, world, control, RenderOptions::default()).through(window);
        let mut render = ProgressiveRender::new(renderer, region, stop);
        render.climb(watcher)?;
        Ok(render.picture())
    }
    with_world!(&scene.world, |world| of(scene, world, window, region, control, stop, watcher))
}

/// A picture that is rendered rung by rung.
struct ProgressiveRender<'a, R> {
    renderer: Renderer<'a, R>,
    ladder: Ladder,
    stop: Stop,
    partial: PartialPicture,
    started: Stopwatch,
    /// Nanoseconds that threads have spent tracing.
    traced: u64,
    /// Samples that were traced in them.
    samples: u64,
    /// Whether the last chunk ended early, as it does not with more rays.
    is_cut: bool,
}

impl<'a, R: KernelFormat> ProgressiveRender<'a, R> {
    fn new(renderer: Renderer<'a, R>, region: Region, stop: Stop) -> Self {
        let ladder = Ladder::new(renderer.scene);
        let world = renderer.job.world;
        let partial = PartialPicture::new(region, world.display, world.transparent);
        Self { renderer, ladder, stop, partial, started: Stopwatch::start(), traced: 0, samples: 0, is_cut: false }
    }

    /// Takes one rung after the other until there is reason to stop.
    fn climb(&mut self, mut watcher: Option<Watcher<'_>>) -> Result<(), Cancelled> {
        for number in 0.. {
            // The first rung is always finished, so that every pixel shows something.
            let stop = Some(self.stop).filter(|_| number > 0);
            // It stops work inside of chunks, which may take seconds.
            let halt = match stop {
                Some(Stop::At(end)) => Control::until(end),
                _ => Control::default(),
            };
            if halt.is_cancelled() || is_full(&self.partial, stop) {
                break;
            }
            if Ladder::chooses(number) {
                self.partial.update(&self.ladder);
            }
            let rung = self.ladder.rung(number, &self.partial);
            let chunks = self.ladder.chunks(&rung);
            if chunks.is_empty() {
                if Ladder::covers(number) {
                    continue;
                }
                break;
            }
            if !self.work(&chunks, stop, &halt)? {
                break;
            }
            if let Some(watcher) = &mut watcher {
                let film = self.renderer.film(self.partial.region, self.partial.so_far());
                watcher(Film { alpha: self.partial.alpha(), ..film }, Ladder::distance(number));
            }
        }
        self.partial.update(&self.ladder);
        Ok(())
    }

    /// Works on a rung; whether it is done.
    fn work(&mut self, chunks: &[Chunk<'_>], stop: Option<Stop>, halt: &Control) -> Result<bool, Cancelled> {
        let Self { renderer, ladder, partial, traced: nanoseconds, samples: all_samples, .. } = self;
        let control = renderer.control;
        control.add_total(chunks.iter().map(|chunk| chunk.pixels.len() as u64).sum());
        // A chunk that alone takes all rays there were at the start of the rung ends early: the proof of a pixel may take as many
        // as a whole picture. What earlier chunks took may not count, since this one may be finished before them.
        let most = match stop {
            Some(Stop::Rays(count)) => count - partial.rays.total(),
            _ => u64::MAX,
        };
        let part = if most < FEW { MAX_LANES } else { usize::MAX };
        let (busy, samples) = (AtomicU64::new(0), AtomicU64::new(0));
        let next = AtomicUsize::new(0);
        let done = Mutex::new(Done { partial, ladder, early: BTreeMap::new(), chunks: 0, full: false, is_cut: false });
        let take = || {
            let _entered = control.enter();
            // Each thread asks the clock itself: one that watches it for others may wait for a processor.
            while !halt.is_cancelled() {
                let number = next.fetch_add(1, Ordering::Relaxed);
                let Some(chunk) = chunks.get(number) else { return };
                let step = ladder.step(chunk.level);
                let job = TraceJob { pruning: step.pruning, control: halt, ..renderer.job.clone() };
                let (samples_of_pixel, level) = (Samples::of_picture(step.samples), renderer.options.level);
                let mut traced = Traced::default();
                let tracing = Stopwatch::start();
                for part in chunk.pixels.chunks(part) {
                    R::trace(level, &job, part, samples_of_pixel, &mut traced);
                    if traced.rays.total() >= most {
                        break;
                    }
                }
                control.add_rays(traced.rays.total());
                busy.fetch_add(tracing.elapsed().as_nanos() as u64, Ordering::Relaxed);
                samples.fetch_add(chunk.pixels.len() as u64 * u64::from(step.samples), Ordering::Relaxed);
                let mut done = done.lock();
                if halt.stops() || done.full {
                    return;
                }
                done.early.insert(number, traced);
                done.settle(chunks, stop);
                control.add_done(chunk.pixels.len() as u64);
            }
        };
        rayon::broadcast(|_| take());
        let Done { chunks: settled, is_cut, .. } = done.into_inner();
        self.is_cut = is_cut;
        *nanoseconds += busy.into_inner();
        *all_samples += samples.into_inner();
        if control.stops() { Err(Cancelled) } else { Ok(settled == chunks.len()) }
    }

    fn picture(self) -> Picture {
        let Self { renderer, ladder, stop, partial, started, traced, samples, is_cut } = self;
        let alpha = partial.alpha();
        let traced_pixels = partial.count(|level| level > 0);
        let (needing, left) = ladder.left(&partial);
        let untraced = partial.region.pixels() - traced_pixels;
        let threads = rayon::current_num_threads() as f64;
        let count = match stop {
            Stop::Rays(count) if is_cut => count,
            _ => partial.rays.total(),
        };
        let progress = Progress {
            count,
            finished: needing == 0,
            traced_pixels,
            waiting_pixels: if untraced > 0 { untraced } else { needing },
            ms_to_target: left as f64 * traced as f64 * 1e-6 / (threads * samples.max(1) as f64),
        };
        let refined = Refined { pixels: partial.count(|level| ladder.refines(level)), rays: partial.refining };
        // A single pixel has no neighbours to estimate its interval from.
        let alone = renderer.scene.samples == 1 && partial.region.pixels() == 1 && refined.pixels == 0;
        let tells = (renderer.scene.refines() || renderer.scene.samples > 1) && !alone;
        let refining = partial.refining.total() as f64 / partial.rays.total().max(1) as f64;
        let mut picture = renderer.picture_of(partial.region, partial.filled(&ladder, tells), refined);
        picture.film.alpha = alpha;
        let trace_ms = started.milliseconds();
        Picture { progress: Some(progress), trace_ms, refine_ms: trace_ms * refining, ..picture }
    }
}

/// Whether the rays are used up.
fn is_full(partial: &PartialPicture, stop: Option<Stop>) -> bool {
    matches!(stop, Some(Stop::Rays(count)) if partial.rays.total() >= count)
}

/// The progress of a rung.
struct Done<'a> {
    partial: &'a mut PartialPicture,
    ladder: &'a Ladder,
    /// Chunks that were finished before an earlier one.
    early: BTreeMap<usize, Traced>,
    /// Finished chunks without a gap.
    chunks: usize,
    /// Whether the rays are used up.
    full: bool,
    /// Whether the last chunk in the picture ended early.
    is_cut: bool,
}

impl Done<'_> {
    /// Adds the chunks that are next in order to the picture.
    fn settle(&mut self, chunks: &[Chunk<'_>], stop: Option<Stop>) {
        loop {
            if is_full(self.partial, stop) {
                self.full = true;
                return;
            }
            let Some(traced) = self.early.remove(&self.chunks) else { return };
            let chunk = &chunks[self.chunks];
            self.is_cut = traced.pixels.len() < chunk.pixels.len();
            self.partial.paint(chunk, self.ladder, &traced);
            self.chunks += 1;
        }
    }
}
