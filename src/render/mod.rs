//! One picture: tiles on the current rayon pool, with progress and cancellation.

mod canvas;
mod contrast;
mod costs;
mod kernels;
mod packets;
mod probe;
mod progressive;
mod renderer;
mod sampling;
mod statistical;
mod student;
mod tiles;

use crate::bound::{BoundedPixels, Proof};
use crate::camera::Window;
use crate::film::{Film, Region};
use crate::scene::Scene;
use crate::scene::compile::Precise;
use crate::scene::world::World;
use fearless_simd::Level;
use packets::Kernel;
use renderer::Renderer;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::time::Instant;

pub(crate) use contrast::{CONTRAST, REFINED_SAMPLES, code_in, is_uneven, refines};
pub use costs::PixelCost;
pub(crate) use probe::{PacketCost, Probe};
pub use progressive::{Progress, Progressive, Stop};
pub use sampling::{Histogram, Sampling};
pub use statistical::Reached;
pub(crate) use tiles::BLOCK;

pub use crate::trace::control::{Cancelled, Control};
pub use crate::trace::counts::RayCounts;

/// Part of the names under which pictures are cached: to be raised with every change that may change a pixel of any
/// picture, which golden pictures notice.
pub const RENDER_EPOCH: u32 = 3;

/// A finished render.
#[derive(Debug)]
pub struct Picture {
    /// The pixels.
    pub film: Film,
    /// The pixels that may lack light. All others are those of the same samples with recursion
    /// without end, or to [`Reach::max_depth`](crate::bound::ceiling::Reach::max_depth).
    pub lacking: BoundedPixels,
    /// What its samples tell about how far more of them would take it.
    pub sampling: Sampling,
    /// What was traced.
    pub rays: RayCounts,
    /// What antialiasing added.
    pub refined: Refined,
    /// What each pixel took, in no particular order, from [`render_one_by_one`]; a refined pixel comes twice.
    pub costs: Vec<PixelCost>,
    /// How far a picture came that had to stop at some point.
    pub progress: Option<Progress>,
    /// Milliseconds of wall time spent tracing.
    pub trace_ms: f64,
    /// Those of them that antialiasing took.
    pub refine_ms: f64,
}

impl Picture {
    /// What is proved about it.
    pub fn proof(&self) -> Proof {
        Proof::of(&self.film, &self.lacking)
    }

    /// What each pixel is at most, however far the recursion goes, row by row.
    pub fn highest(&self) -> Vec<[f32; 3]> {
        let mut highest = self.film.pixels.clone();
        for lacking in self.lacking.iter() {
            highest[self.film.region.index(lacking.at)] = lacking.highest;
        }
        highest
    }
}

/// What antialiasing added to the base samples of all pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Refined {
    /// Pixels that got more samples.
    pub pixels: u64,
    /// The rays of those samples.
    pub rays: RayCounts,
}

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
    let mut progressive = Progressive::new(scene, window, region, control, stop);
    progressive.go_on(None)?;
    Ok(progressive.picture())
}

/// Renders a region of the scene's picture, which must fit, pixel by pixel, and says what each of them takes. The pixels are
/// those of [`render`], but take many times as long.
pub fn render_one_by_one(scene: &Scene, region: Region, control: &Control) -> Result<Picture, Cancelled> {
    fn of<R: Kernel>(scene: &Scene, world: &World<R>, region: Region, control: &Control) -> Result<Picture, Cancelled> {
        Renderer::new(scene, world, control, Cut::default()).one_by_one().picture(region)
    }
    let start = Instant::now();
    let picture = match &scene.world {
        Precise::Single(world) => of(scene, world, region, control)?,
        Precise::Double(world) => of(scene, world, region, control)?,
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
