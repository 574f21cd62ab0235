//! One picture: tiles on the current rayon pool, with progress and cancellation.

mod progressive;

use crate::camera::{Camera, Window};
use crate::film::srgb::Codes8;
use crate::film::{Film, Region};
use crate::lanes::{Lanes, MAX_LANES, Real, V3, dispatch, lanes_of};
use crate::plan::effects::{Clear, Detailed, DetailedMirrors, Effects, Everything, Local, Mirrors, Specialised};
use crate::scene::Scene;
use crate::scene::compile::Precise;
use crate::scene::world::{Pruning, World};
use crate::shading::media::Medium;
use crate::trace::certificate::{ends, raised};
use crate::trace::enclosing::media_at;
use crate::trace::hits::Hits;
use crate::trace::kernel::Tracer;
use crate::trace::observer::Observer;
use fearless_simd::{Level, f32x16, f64x8};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

pub use progressive::{Progress, Stop};

/// Part of the names under which pictures are cached: to be raised with every change that may change a pixel of any
/// picture, which golden pictures notice.
pub const RENDER_EPOCH: u32 = 2;

/// Shared between a render and whoever watches it.
#[derive(Debug, Default)]
pub struct Control {
    /// Set to stop the render; it stops within milliseconds.
    pub cancelled: AtomicBool,
    /// Pixels finished so far, out of `total`. With antialiasing pixels that get more samples count again.
    pub done: AtomicU64,
    /// Pixels to do, as far as known.
    pub total: AtomicU64,
}

/// Rays by kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[expect(missing_docs, reason = "the names say it")]
pub struct RayCounts {
    pub camera: u64,
    pub shadow: u64,
    pub reflected: u64,
    pub transmitted: u64,
    /// Rays from diffuse surfaces, for color bleeding.
    pub gathered: u64,
    /// Camera rays that hit something.
    #[serde(skip)]
    pub camera_hits: u64,
    /// Transmissions that total internal reflection turned into reflections.
    pub total_internal_reflections: u64,
    /// Shadow rays not traced because their light could not add a quarter of `min_weight` to the pixel.
    pub shadow_skipped: u64,
    /// Rays not followed because a sample reached the limit `rays_per_sample`.
    pub dropped: u64,
}

impl RayCounts {
    /// All rays that were traced.
    pub fn total(&self) -> u64 {
        self.camera + self.shadow + self.reflected + self.transmitted + self.gathered
    }
}

impl std::ops::Add for RayCounts {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self {
            camera: self.camera + o.camera,
            shadow: self.shadow + o.shadow,
            reflected: self.reflected + o.reflected,
            transmitted: self.transmitted + o.transmitted,
            gathered: self.gathered + o.gathered,
            camera_hits: self.camera_hits + o.camera_hits,
            total_internal_reflections: self.total_internal_reflections + o.total_internal_reflections,
            shadow_skipped: self.shadow_skipped + o.shadow_skipped,
            dropped: self.dropped + o.dropped,
        }
    }
}

/// A finished render.
#[derive(Debug)]
pub struct Picture {
    /// The pixels.
    pub film: Film,
    /// The pixels that may lack light, in no particular order. All others are those of the same samples with recursion
    /// without end, or to [`Reach::max_depth`](crate::scene::ceiling::Reach::max_depth).
    pub lacking: Vec<Lacking>,
    /// What was traced.
    pub rays: RayCounts,
    /// What antialiasing added.
    pub refined: Refined,
    /// How far a picture came that had to stop at some point.
    pub progress: Option<Progress>,
    /// Milliseconds of wall time spent tracing.
    pub trace_ms: f64,
}

impl Picture {
    /// What each pixel is at most, however far the recursion goes, row by row.
    pub fn highest(&self) -> Vec<[f32; 3]> {
        let mut highest = self.film.pixels.clone();
        for lacking in &self.lacking {
            highest[self.film.region.index(lacking.at)] = lacking.highest;
        }
        highest
    }
}

/// A pixel of which something was left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lacking {
    /// Its column and row in the whole picture.
    pub at: [u32; 2],
    /// What it is at most: see [`certificate`](crate::trace::certificate).
    pub highest: [f32; 3],
}

/// What antialiasing added to the base samples of all pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Refined {
    /// Pixels that got more samples.
    pub pixels: u64,
    /// The rays of those samples.
    pub rays: RayCounts,
}

/// The render was cancelled before it was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cancelled;

/// How a picture is cut into work; no pixel depends on it.
#[derive(Debug, Clone, Copy)]
pub struct Cut {
    /// Edge of a tile in pixels, at least 1.
    pub tile: u32,
    /// Instruction set.
    pub level: Level,
    /// Whether the kernel is the one for the scene's effects, or the general one.
    pub specialised: bool,
}

impl Default for Cut {
    fn default() -> Self {
        Self { tile: 32, level: Level::new(), specialised: true }
    }
}

/// Renders a region of the scene's picture, which must fit ([`Region::fits`]).
pub fn render(scene: &Scene, region: Region, control: &Control) -> Result<Picture, Cancelled> {
    render_cut(scene, region, control, Cut::default())
}

/// [`render`], cut in a given way.
pub fn render_cut(scene: &Scene, region: Region, control: &Control, cut: Cut) -> Result<Picture, Cancelled> {
    render_seen(scene, &Window::whole(scene.width, scene.height), region, control, cut)
}

/// Renders a region of what a window shows of the scene's picture, in the window's pixels; it must fit the window. It is
/// that crop of the whole window's picture, byte for byte.
pub fn render_window(scene: &Scene, window: &Window, region: Region, control: &Control) -> Result<Picture, Cancelled> {
    render_seen(scene, window, region, control, Cut::default())
}

/// Renders as much of a region of what a window shows as a time or a number of rays allows, in an order that makes the best of it; it must fit
/// the window. Every pixel of the picture shows something.
pub fn render_until(
    scene: &Scene,
    window: &Window,
    region: Region,
    control: &Control,
    stop: Stop,
) -> Result<Picture, Cancelled> {
    let start = Instant::now();
    let picture = match &scene.world {
        Precise::Single(world) => {
            Renderer::new(scene, world, control, Cut::default()).through(window).progressive(region, stop)?
        }
        Precise::Double(world) => {
            Renderer::new(scene, world, control, Cut::default()).through(window).progressive(region, stop)?
        }
    };
    Ok(Picture { trace_ms: start.elapsed().as_secs_f64() * 1e3, ..picture })
}

fn render_seen(
    scene: &Scene,
    window: &Window,
    region: Region,
    control: &Control,
    cut: Cut,
) -> Result<Picture, Cancelled> {
    let start = Instant::now();
    let picture = match &scene.world {
        Precise::Single(world) => Renderer::new(scene, world, control, cut).through(window).picture(region)?,
        Precise::Double(world) => Renderer::new(scene, world, control, cut).through(window).picture(region)?,
    };
    Ok(Picture { trace_ms: start.elapsed().as_secs_f64() * 1e3, ..picture })
}

/// Samples of one pixel of the scene's picture: `samples`, or more where antialiasing refines it.
pub fn samples_of(scene: &Scene, x: u32, y: u32, control: &Control) -> u32 {
    if !refines(scene) {
        return scene.samples;
    }
    let around = Region { x, y, width: 1, height: 1 }.with_border(scene.width, scene.height);
    let uneven = match &scene.world {
        Precise::Single(world) => Renderer::new(scene, world, control, Cut::default()).uneven_in(around, x, y),
        Precise::Double(world) => Renderer::new(scene, world, control, Cut::default()).uneven_in(around, x, y),
    };
    if uneven { REFINED_SAMPLES } else { scene.samples }
}

/// Traces the base samples of some pixels: what [`pilot`](crate::plan::pilot) asks a scene.
pub(crate) type Probe<'a> = Box<dyn Fn(&[[u32; 2]]) -> (Vec<[f32; 3]>, RayCounts) + 'a>;

/// The probe of a scene. Once cancelled, it answers early and wrongly.
pub(crate) fn probe<'a>(scene: &'a Scene, control: &'a Control) -> Probe<'a> {
    fn of<'a, R: Kernel>(scene: &'a Scene, world: &'a World<R>, control: &'a Control) -> Probe<'a> {
        let Renderer { cut, job, .. } = Renderer::new(scene, world, control, Cut::default());
        Box::new(move |at| {
            let mut traced = Traced::default();
            R::trace(cut.level, &job, at, scene.samples, &mut traced);
            (traced.pixels, traced.rays)
        })
    }
    match &scene.world {
        Precise::Single(world) => of(scene, world, control),
        Precise::Double(world) => of(scene, world, control),
    }
}

/// Samples of a pixel that differs from a neighbour.
pub(crate) const REFINED_SAMPLES: u32 = 16;
/// Difference of neighbouring pixels, in 8-bit sRGB codes of any channel, from which on both are refined.
const CONTRAST: u8 = 8;

/// Whether antialiasing may add samples.
pub(crate) fn refines(scene: &Scene) -> bool {
    scene.antialias && scene.samples < REFINED_SAMPLES
}

/// Offset of sample i of n within its pixel: the Hammersley set, which puts one sample into each of n columns and of
/// n rows. A single sample is the pixel's centre.
pub fn sample_offset(i: u32, n: u32) -> [f64; 2] {
    let n = f64::from(n);
    // The van der Corput sequence reaches from 0 to 1 - 1/n on average one half of 1/n below the middle.
    let radical_inverse = f64::from(i.reverse_bits()) / 4_294_967_296.0;
    if n == 1.0 { [0.5, 0.5] } else { [(f64::from(i) + 0.5) / n, (radical_inverse + 0.5 / n).min(1.0 - 0.5 / n)] }
}

/// The two kernels that pictures are traced with.
trait Kernel: Real {
    /// Traces the pixels at `at` with `samples` samples each.
    fn trace(level: Level, job: &Job<'_, Self>, at: &[[u32; 2]], samples: u32, out: &mut Traced);
    /// The bodies around the eye.
    fn eye_media(world: &World<Self>) -> Vec<Medium<Self>>;
}

/// What all tiles of a picture share.
struct Job<'a, R> {
    world: &'a World<R>,
    camera: Camera<R>,
    eye: Vec<Medium<R>>,
    cancelled: &'a AtomicBool,
    kernel: Specialised,
    pruning: Pruning,
}

/// What became of some pixels.
#[derive(Default)]
struct Traced {
    /// In the order asked for.
    pixels: Vec<[f32; 3]>,
    /// Those that may lack light.
    lacking: Vec<Lacking>,
    rays: RayCounts,
}

macro_rules! kernel {
    ($real:ident, $lanes:ident) => {
        impl Kernel for $real {
            fn trace(level: Level, job: &Job<'_, Self>, at: &[[u32; 2]], samples: u32, out: &mut Traced) {
                dispatch!(level, s => match job.kernel {
                    Specialised::Local => trace_with::<$lanes<_>, Local>(s, job, at, samples, out),
                    Specialised::Mirrors => trace_with::<$lanes<_>, Mirrors>(s, job, at, samples, out),
                    Specialised::Clear => trace_with::<$lanes<_>, Clear>(s, job, at, samples, out),
                    Specialised::DetailedMirrors => trace_with::<$lanes<_>, DetailedMirrors>(s, job, at, samples, out),
                    Specialised::Detailed => trace_with::<$lanes<_>, Detailed>(s, job, at, samples, out),
                    Specialised::Everything => trace_with::<$lanes<_>, Everything>(s, job, at, samples, out),
                });
            }
            fn eye_media(world: &World<Self>) -> Vec<Medium<Self>> {
                eye_media::<Self>((), world)
            }
        }
    };
}

kernel!(f32, f32x16);
kernel!(f64, f64x8);

/// Names the instruction set's type once, so that the macro's argument can be a type over it.
#[inline(always)]
fn trace_with<L: Lanes, E: Effects>(
    s: L::Simd,
    job: &Job<'_, L::Real>,
    at: &[[u32; 2]],
    samples: u32,
    out: &mut Traced,
) {
    let mut tracer = Tracer::<L, (), E>::new(s, job.world, &job.camera, &job.eye, job.cancelled, job.pruning, ());
    let mut hits = Hits::none(s);
    for packet in at.chunks(L::COUNT) {
        let active = ((1u64 << packet.len()) - 1) as u32;
        let mut sum = V3::splat(s, [L::Real::from_f64(0.0); 3]);
        add_samples(&mut tracer, packet, active, samples, &mut hits, &mut sum);
        let lanes = |v: V3<L>| {
            let mut channels = [[L::Real::default(); MAX_LANES]; 3];
            for (channel, lanes) in channels.iter_mut().zip([v.x, v.y, v.z]) {
                lanes.store(channel);
            }
            channels
        };
        let [red, green, blue] = lanes(sum);
        let first = out.pixels.len();
        out.pixels.extend((0..packet.len()).map(|lane| [red[lane], green[lane], blue[lane]].map(narrow)));
        for lane in lanes_of(tracer.lacking() & active) {
            let sum = [red[lane], green[lane], blue[lane]];
            let ends = ends(sum, tracer.rest().lane(lane), tracer.roundings().lane(lane));
            let (shown, highest) = show(sum, ends, job.pruning);
            out.pixels[first + lane] = shown;
            out.lacking.push(Lacking { at: packet[lane], highest });
        }
    }
    out.rays = out.rays + tracer.counts;
}

/// What is shown of a pixel that lies between two ends, and what it is at most, seen from there.
fn show<R: Real>(sum: [R; 3], ends: [[f32; 2]; 3], pruning: Pruning) -> ([f32; 3], [f32; 3]) {
    let shown = match pruning {
        Pruning::Weight(_) => sum.map(narrow),
        Pruning::Proved { max_codes } => std::array::from_fn(|c| narrow(sum[c] + raised(sum[c], ends[c], max_codes))),
    };
    // Whatever lies some codes below, by rounding, counts as if it lay as many above.
    let codes = Codes8::get();
    let highest = std::array::from_fn(|c| {
        let [low, high] = ends[c];
        let code = codes.code(shown[c]);
        let below = code - codes.code(low).min(code);
        if codes.code(high) - code < below { codes.least(code.saturating_add(below)).max(high) } else { high }
    });
    (shown, highest)
}

/// A channel of the film.
#[inline(always)]
fn narrow<R: Real>(channel: R) -> f32 {
    channel.to_f64() as f32
}

/// Adds all samples of a packet of pixels, each weighted 1/n.
#[inline(always)]
pub(crate) fn add_samples<L: Lanes, O: Observer<L>, E: Effects>(
    tracer: &mut Tracer<'_, L, O, E>,
    pixels: &[[u32; 2]],
    active: u32,
    samples: u32,
    hits: &mut Hits<L>,
    sum: &mut V3<L>,
) {
    let s = tracer.simd();
    let weight = L::Real::from_f64(1.0 / f64::from(samples));
    tracer.begin(pixels, samples);
    let (mut active, mut sample) = (active, 0);
    // One call of `follow_from` for the first rays of each sample and those put aside: it holds all of the kernel.
    while !tracer.is_cancelled() {
        let rays;
        if sample < samples {
            let offset = sample_offset(sample, samples);
            let coordinate = |axis: usize| {
                L::from_fn(s, |lane| L::Real::from_f64(f64::from(tracer.corners(axis)[lane]) + offset[axis]))
            };
            let (x, y) = (coordinate(0), coordinate(1));
            tracer.choose(sample);
            rays = tracer.sample(x, y, active, weight, hits, sum);
            sample += 1;
        } else if tracer.prove(active, hits, sum) {
            let Some(next) = tracer.pop() else { continue };
            rays = next;
        } else {
            (active, sample) = (tracer.finish(active, sum), 0);
            if active == 0 {
                return;
            }
            continue;
        }
        tracer.follow_from(rays, hits, sum);
    }
}

/// The media around the eye, if all rays start there.
pub(crate) fn eye_media<L: Lanes>(s: L::Simd, world: &World<L::Real>) -> Vec<Medium<L::Real>> {
    if !world.transmits || !world.shared_eye {
        return Vec::new();
    }
    let eye = world.camera.primary(s, L::lit(s, 0.0), L::lit(s, 0.0)).origin.lane(0);
    media_at::<L>(s, world, eye, None)
}

/// A tile and where its pixels go, row by row.
struct Tile<'a> {
    region: Region,
    rows: Vec<&'a mut [[f32; 3]]>,
}

/// Edge of the block of pixels that share a packet, so that its rays stay together: 4 x 4 are 16 lanes.
pub(crate) const BLOCK: u32 = 4;

impl Tile<'_> {
    /// Its pixels, block by block.
    fn blocks(&self) -> Vec<[u32; 2]> {
        let mut at = Vec::with_capacity(self.region.pixels() as usize);
        for block in self.region.tiles(BLOCK) {
            for y in block.y..block.y + block.height {
                at.extend((block.x..block.x + block.width).map(|x| [x, y]));
            }
        }
        at
    }

    /// Puts pixels in the order of [`Self::blocks`] where they belong.
    fn put(&mut self, mut pixels: &[[f32; 3]]) {
        for block in self.region.tiles(BLOCK) {
            let (left, top) = ((block.x - self.region.x) as usize, (block.y - self.region.y) as usize);
            for row in &mut self.rows[top..top + block.height as usize] {
                let (part, rest) = pixels.split_at(block.width as usize);
                row[left..left + part.len()].copy_from_slice(part);
                pixels = rest;
            }
        }
    }
}

/// Cuts the pixels of a region into tiles.
fn split(region: Region, edge: u32, pixels: &mut [[f32; 3]]) -> Vec<Tile<'_>> {
    let mut tiles: Vec<Tile<'_>> = region.tiles(edge).map(|region| Tile { region, rows: Vec::new() }).collect();
    let across = region.width.div_ceil(edge) as usize;
    for (y, row) in pixels.chunks_mut(region.width as usize).enumerate() {
        let first = y / edge as usize * across;
        for (tile, part) in tiles[first..first + across].iter_mut().zip(row.chunks_mut(edge as usize)) {
            tile.rows.push(part);
        }
    }
    tiles
}

struct Renderer<'a, R> {
    scene: &'a Scene,
    control: &'a Control,
    cut: Cut,
    /// Of the whole picture.
    size: [u32; 2],
    job: Job<'a, R>,
}

impl<'a, R: Kernel> Renderer<'a, R> {
    fn new(scene: &'a Scene, world: &'a World<R>, control: &'a Control, cut: Cut) -> Self {
        let kernel = if cut.specialised { Specialised::of(world) } else { Specialised::Everything };
        let (camera, eye, pruning) = (world.camera, R::eye_media(world), world.rules.pruning);
        let job = Job { world, camera, eye, cancelled: &control.cancelled, kernel, pruning };
        Self { scene, control, cut, size: [scene.width, scene.height], job }
    }

    /// The renderer of what a window shows.
    fn through(mut self, window: &Window) -> Self {
        self.size = [window.width, window.height];
        self.job.camera = self.job.camera.through(window);
        self
    }

    fn picture(&self, region: Region) -> Result<Picture, Cancelled> {
        let [full_width, full_height] = self.size;
        if !refines(self.scene) {
            self.control.total.fetch_add(region.pixels(), Ordering::Relaxed);
            return Ok(self.picture_of(region, self.grid(region)?, Refined::default()));
        }
        // Antialiasing compares with neighbours, also across the region's edge, so that a tile is a crop of the whole.
        let around = region.with_border(full_width, full_height);
        self.control.total.fetch_add(around.pixels(), Ordering::Relaxed);
        let mut traced = self.grid(around)?;
        let codes = codes_of(&traced.pixels);
        let uneven: Vec<[u32; 2]> =
            region.iter().filter(|&[x, y]| is_uneven(code_in(&codes, around), around, x, y)).collect();
        self.control.total.fetch_add(uneven.len() as u64, Ordering::Relaxed);
        let refined = self.list(&uneven, REFINED_SAMPLES)?;
        if around != region {
            traced.pixels = region.iter().map(|at| traced.pixels[around.index(at)]).collect();
        }
        for (&at, pixel) in uneven.iter().zip(refined.pixels) {
            traced.pixels[region.index(at)] = pixel;
        }
        // `uneven` is in the order of rows.
        let is_refined = |[x, y]: [u32; 2]| uneven.binary_search_by_key(&[y, x], |[x, y]| [*y, *x]).is_ok();
        traced.lacking.retain(|lacking| region.contains(lacking.at) && !is_refined(lacking.at));
        traced.lacking.extend(refined.lacking);
        traced.rays = traced.rays + refined.rays;
        Ok(self.picture_of(region, traced, Refined { pixels: uneven.len() as u64, rays: refined.rays }))
    }

    fn picture_of(&self, region: Region, traced: Traced, refined: Refined) -> Picture {
        let [full_width, full_height] = self.size;
        let Traced { pixels, lacking, rays } = traced;
        let film = Film { region, full_width, full_height, pixels };
        Picture { film, lacking, rays, refined, progress: None, trace_ms: 0.0 }
    }

    /// The base samples of a region, row by row.
    fn grid(&self, region: Region) -> Result<Traced, Cancelled> {
        let mut pixels = vec![[0.0; 3]; region.pixels() as usize];
        let parts: Result<Vec<Traced>, Cancelled> = split(region, self.cut.tile, &mut pixels)
            .into_par_iter()
            // Tiles differ in cost: each may go to another thread until the last.
            .with_max_len(1)
            .map(|mut tile| {
                let mut traced = self.trace(&tile.blocks(), self.scene.samples)?;
                tile.put(&std::mem::take(&mut traced.pixels));
                Ok(traced)
            })
            .collect();
        Ok(Traced { pixels, ..joined(parts?) })
    }

    /// Pixels anywhere, in the order given.
    fn list(&self, at: &[[u32; 2]], samples: u32) -> Result<Traced, Cancelled> {
        let parts: Result<Vec<Traced>, Cancelled> =
            at.par_chunks(16 * MAX_LANES).with_max_len(1).map(|part| self.trace(part, samples)).collect();
        Ok(joined(parts?))
    }

    fn trace(&self, at: &[[u32; 2]], samples: u32) -> Result<Traced, Cancelled> {
        let mut traced = Traced { pixels: Vec::with_capacity(at.len()), ..Traced::default() };
        R::trace(self.cut.level, &self.job, at, samples, &mut traced);
        if self.control.cancelled.load(Ordering::Relaxed) {
            return Err(Cancelled);
        }
        self.control.done.fetch_add(at.len() as u64, Ordering::Relaxed);
        Ok(traced)
    }

    fn uneven_in(&self, around: Region, x: u32, y: u32) -> bool {
        let Ok(base) = self.grid(around) else { return false };
        let codes = codes_of(&base.pixels);
        is_uneven(code_in(&codes, around), around, x, y)
    }
}

/// The parts one after the other.
fn joined(parts: Vec<Traced>) -> Traced {
    let mut all = Traced::default();
    all.pixels.reserve(parts.iter().map(|part| part.pixels.len()).sum());
    all.lacking.reserve(parts.iter().map(|part| part.lacking.len()).sum());
    for part in parts {
        all.pixels.extend(part.pixels);
        all.lacking.extend(part.lacking);
        all.rays = all.rays + part.rays;
    }
    all
}

/// The 8-bit codes of pixels.
fn codes_of(pixels: &[[f32; 3]]) -> Vec<[u8; 3]> {
    let mut codes = vec![[0; 3]; pixels.len()];
    pixels.par_chunks(1 << 12).zip(codes.par_chunks_mut(1 << 12)).for_each(|(pixels, codes)| {
        Codes8::get().codes(pixels.as_flattened(), codes.as_flattened_mut());
    });
    codes
}

/// Whether a pixel differs from one of its eight neighbours within `around`, by their codes.
pub(crate) fn is_uneven(codes: impl Fn(u32, u32) -> [u8; 3], around: Region, x: u32, y: u32) -> bool {
    let here = codes(x, y);
    let columns = x.saturating_sub(1).max(around.x)..=(x + 1).min(around.x + around.width - 1);
    columns
        .flat_map(|x| {
            let rows = y.saturating_sub(1).max(around.y)..=(y + 1).min(around.y + around.height - 1);
            rows.map(move |y| (x, y))
        })
        .any(|(x, y)| codes(x, y).iter().zip(here).any(|(a, b)| a.abs_diff(b) >= CONTRAST))
}

/// The code of a pixel of a picture that is kept row by row.
pub(crate) fn code_in(codes: &[[u8; 3]], around: Region) -> impl Fn(u32, u32) -> [u8; 3] {
    move |x, y| codes[around.index([x, y])]
}
