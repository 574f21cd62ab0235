//! The best picture in a time, or for a number of rays.
//!
//! Work is a list of parcels of pixels, in stages: one pixel in 64, so that something stands everywhere; all pixels, with
//! light rays left out; those proved to at most one code that are not; and those that differ from a neighbour, with more
//! samples. Threads take parcels in order, and the picture is made of the parcels up to the first one that was not finished.
//! So it is a function of how many parcels count, and of the rays in them: a number of rays makes the same picture again, on
//! any machine and any number of threads.

use super::contrast::{CONTRAST, REFINED_SAMPLES, codes_of, contrasts, is_uneven, refines};
use super::packets::{Job, Kernel, Samples, Traced};
use super::renderer::Renderer;
use super::tiles::near;
use super::{Cancelled, Lacking, Picture, RayCounts, Refined};
use crate::film::Region;
use crate::film::srgb::{Codes8, code8};
use crate::scene::world::Pruning;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
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
    /// Pixels that are known to need more, and have not had it.
    pub waiting_pixels: u64,
    /// Milliseconds that the rest would take, estimated from those before.
    pub ms_to_target: f64,
}

/// Every how many pixels the first stage takes one, across and down.
const STRIDE: u32 = 8;
/// Samples of the second stage.
const FEW: u32 = 4;
/// Weight below which rays are left out in the first two stages.
const LIGHT: f64 = 0.05;
/// How far the sample of a pixel on an edge is likely off, from end to end, as a share of the contrast there: twice the
/// standard deviation of what an edge covers that may lie anywhere in it.
const EDGE: f64 = 0.58;
/// Pixels in a parcel of one sample each.
const PARCEL: usize = 512;
/// How often somebody looks whether it is time to stop.
const LOOK: Duration = Duration::from_millis(1);

/// Parcels that are traced alike.
struct Stage {
    pixels: Vec<[u32; 2]>,
    samples: u32,
    pruning: Pruning,
}

/// What all stages add to.
struct Canvas {
    region: Region,
    shown: Vec<[f32; 3]>,
    /// What each pixel is at most.
    highest: Vec<[f32; 3]>,
    /// Samples of each pixel so far.
    samples: Vec<u32>,
    /// What those tell of each pixel, if they are more than one.
    widths: Vec<u8>,
    rays: RayCounts,
    refined: Refined,
}

impl Canvas {
    /// Samples that the picture is made of.
    fn traced_samples(&self) -> u64 {
        self.samples.iter().map(|samples| u64::from(*samples)).sum()
    }

    fn paint(&mut self, at: &[[u32; 2]], samples: u32, traced: &Traced) {
        self.rays = self.rays + traced.rays;
        for (&at, pixel) in at.iter().zip(&traced.pixels) {
            let index = self.region.index(at);
            (self.shown[index], self.highest[index], self.samples[index]) = (*pixel, *pixel, samples);
        }
        for (&at, width) in at.iter().zip(&traced.widths) {
            self.widths[self.region.index(at)] = *width;
        }
        for lacking in traced.lacking.iter() {
            self.highest[self.region.index(lacking.at)] = lacking.highest;
        }
    }

    /// The pixel of the first stage in the square of a pixel.
    fn first(&self, [x, y]: [u32; 2]) -> usize {
        let square = |at: u32, from: u32| from + (at - from) / STRIDE * STRIDE;
        self.region.index([square(x, self.region.x), square(y, self.region.y)])
    }

    /// The picture so far. Pixels that were not traced look like the one of the first stage in their square, and have no
    /// upper end.
    fn filled(self, tells: bool) -> Traced {
        let of = |at: [u32; 2]| {
            let index = self.region.index(at);
            if self.samples[index] > 0 {
                return (self.shown[index], self.highest[index]);
            }
            (self.shown[self.first(at)], [f32::INFINITY; 3])
        };
        let mut filled = Traced { rays: self.rays, ..Traced::default() };
        let mut lacking = Vec::new();
        for at in self.region.iter() {
            let (shown, highest) = of(at);
            filled.pixels.push(shown);
            if highest != shown {
                lacking.push(Lacking { at, highest });
            }
        }
        filled.lacking.add(lacking);
        if tells {
            filled.widths = self.all_widths(&filled.pixels);
        }
        filled
    }

    /// How unsure each pixel is, in codes from end to end: by its samples; if it has but one, by its neighbours; if it has
    /// none, by what its square differs from the squares around it, of which it may be as far off.
    fn all_widths(&self, shown: &[[f32; 3]]) -> Vec<u8> {
        let Region { x, y, width, height } = self.region;
        let of_pixels = contrasts(&codes_of(shown), width);
        let squares = Region { x: 0, y: 0, width: width.div_ceil(STRIDE), height: height.div_ceil(STRIDE) };
        let of_square = |[column, row]: [u32; 2]| self.shown[self.first([x + column * STRIDE, y + row * STRIDE])];
        let of_squares = contrasts(&codes_of(&squares.iter().map(of_square).collect::<Vec<_>>()), squares.width);
        let each = |at: [u32; 2]| {
            let index = self.region.index(at);
            match self.samples[index] {
                0 => of_squares[squares.index([(at[0] - x) / STRIDE, (at[1] - y) / STRIDE])].saturating_mul(2),
                1 if of_pixels[index] < CONTRAST => of_pixels[index],
                1 => (f64::from(of_pixels[index]) * EDGE) as u8,
                _ => self.widths[index],
            }
        };
        self.region.iter().map(each).collect()
    }
}

impl<R: Kernel> Renderer<'_, R> {
    pub(super) fn progressive(&self, region: Region, stop: Stop) -> Result<Picture, Cancelled> {
        let count = region.pixels() as usize;
        let mut canvas = Canvas {
            region,
            shown: vec![[0.0; 3]; count],
            highest: vec![[0.0; 3]; count],
            samples: vec![0; count],
            widths: vec![0; count],
            rays: RayCounts::default(),
            refined: Refined::default(),
        };
        let started = Instant::now();
        let mut left = None;
        for number in 0..4 {
            let stage = self.stage(number, &canvas);
            let pixels = stage.pixels.len();
            self.control.total.fetch_add(pixels as u64, Ordering::Relaxed);
            let (done, rays) = self.work(&stage, &mut canvas, stop);
            if self.control.cancelled.load(Ordering::Relaxed) {
                return Err(Cancelled);
            }
            if number == 3 {
                canvas.refined = Refined { pixels: done as u64, rays };
            }
            if done < pixels {
                left = Some((number, (pixels - done) as u64, stage.samples));
                break;
            }
        }
        let traced_pixels = canvas.samples.iter().filter(|samples| **samples > 0).count() as u64;
        let ms_to_target = left.map_or(0.0, |(number, waiting, samples)| {
            let spent = started.elapsed().as_secs_f64() * 1e3;
            let samples = waiting * u64::from(samples) + self.later(number, &canvas);
            samples as f64 * spent / canvas.traced_samples().max(1) as f64
        });
        let progress = Progress {
            count: canvas.rays.total(),
            finished: left.is_none(),
            traced_pixels,
            waiting_pixels: left.map_or(0, |(_, waiting, _)| waiting),
            ms_to_target,
        };
        let refined = canvas.refined;
        let tells = refines(self.scene) || self.scene.samples > 1;
        let picture = self.picture_of(region, canvas.filled(tells), refined);
        Ok(Picture { progress: Some(progress), ..picture })
    }

    /// Samples that the stages after one are likely to take, from a few of the pixels.
    fn later(&self, number: u32, canvas: &Canvas) -> u64 {
        let few = Region::whole(canvas.region.width, canvas.region.height).iter().step_by(61);
        let few: Vec<[u32; 2]> = few.map(|[x, y]| [canvas.region.x + x, canvas.region.y + y]).collect();
        let few: Vec<[u32; 2]> = few.into_iter().filter(|at| canvas.samples[canvas.region.index(*at)] > 0).collect();
        let share = canvas.region.pixels() as f64 / few.len().max(1) as f64;
        let poor = few.iter().filter(|at| number < 2 && self.is_poor(**at, canvas)).count();
        let uneven = few.iter().filter(|at| number < 3 && self.is_uneven(**at, canvas)).count();
        let samples = poor as f64 * f64::from(self.scene.samples) + uneven as f64 * f64::from(REFINED_SAMPLES);
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

    fn stage(&self, number: u32, canvas: &Canvas) -> Stage {
        let region = canvas.region;
        let (samples, proved) = (self.scene.samples, Pruning::Proved { max_codes: 1 });
        let (few, light) = (samples.min(FEW), Pruning::Weight(LIGHT));
        let first = |[x, y]: [u32; 2]| (x - region.x).is_multiple_of(STRIDE) && (y - region.y).is_multiple_of(STRIDE);
        let (samples, pruning) =
            [(few, light), (few, light), (samples, proved), (REFINED_SAMPLES, proved)][number as usize];
        let wanted = |at: [u32; 2]| match number {
            0 => first(at),
            1 => !first(at),
            2 => self.is_poor(at, canvas),
            _ => self.is_uneven(at, canvas),
        };
        Stage { pixels: near(region, wanted), samples, pruning }
    }

    /// Does a stage as far as it goes; returns how many of its pixels are done, and their rays.
    fn work(&self, stage: &Stage, canvas: &mut Canvas, stop: Stop) -> (usize, RayCounts) {
        let parcels: Vec<&[[u32; 2]]> = stage.pixels.chunks((PARCEL / stage.samples as usize).max(16)).collect();
        let (next, halt) = (AtomicUsize::new(0), AtomicBool::new(false));
        let done =
            Mutex::new(Done { canvas, early: BTreeMap::new(), parcels: 0, rays: RayCounts::default(), full: false });
        let job = Job { pruning: stage.pruning, cancelled: &halt, ..self.job.clone() };
        let take = || {
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                let Some(at) = parcels.get(number) else { return };
                let mut traced = Traced::default();
                R::trace(self.cut.level, &job, at, Samples::of_picture(stage.samples), &mut traced);
                let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
                if halt.load(Ordering::Relaxed) || done.full {
                    return;
                }
                done.early.insert(number, traced);
                done.settle(&parcels, stage.samples, stop);
                self.control.done.fetch_add(at.len() as u64, Ordering::Relaxed);
            }
        };
        let watch = AtomicBool::new(true);
        thread::scope(|scope| {
            scope.spawn(|| {
                while watch.load(Ordering::Relaxed) {
                    let late = matches!(stop, Stop::At(end) if Instant::now() >= end);
                    if late || self.control.cancelled.load(Ordering::Relaxed) {
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
        let pixels = parcels[..done.parcels].iter().map(|parcel| parcel.len()).sum();
        (pixels, done.rays)
    }
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
    fn settle(&mut self, parcels: &[&[[u32; 2]]], samples: u32, stop: Stop) {
        loop {
            if matches!(stop, Stop::Rays(count) if self.canvas.rays.total() >= count) {
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
