//! Rendering a picture: tiles on the current rayon pool, antialiasing, progressive and adaptive modes, cancellation.

mod adaptive_sampling;
mod antialiasing;
mod confidence;
mod contrast;
mod first_hits;
mod held_out;
mod interpolation;
mod kernels;
mod ladder;
mod layers;
mod options;
mod packets;
mod partial_picture;
mod picture;
mod pixel_samples;
mod probe;
mod progressive;
mod renderer;
mod sample_sums;
mod sparse;
mod statistical_sampling;
mod student_t;
mod thread_time;
mod tiles;

use crate::camera::Window;
use crate::film::Region;
use crate::scene::Scene;
use crate::scene::compile::with_world;
use crate::scene::world::World;
use packets::KernelFormat;
use renderer::Renderer;

pub(crate) use adaptive_sampling::border_share;
pub use adaptive_sampling::sampling_bytes;
pub(crate) use antialiasing::refined_samples;
pub use confidence::{Histogram, Sampling};
pub(crate) use contrast::{CONTRAST, contrast_in, contrast_within};
pub(crate) use ladder::{CHUNK, COARSEST_SHARE};
pub use layers::{LayerKind, Layers, render_layers, render_sources};
pub use options::RenderOptions;
pub use picture::{Picture, PixelCost, Refined};
pub(crate) use pixel_samples::{Grouping, trace_pixel_samples};
pub(crate) use probe::{PacketCost, Probe};
pub use progressive::{Progress, Stop, Watcher, render_until, render_watched};
pub use statistical_sampling::Reached;
pub(crate) use tiles::BLOCK;

use crate::control::Stopwatch;
pub use crate::control::{Cancelled, Control};
pub use crate::trace::counts::RayCounts;

/// Part of the names under which pictures are cached. Raise it with every change that may change a pixel of any picture;
/// golden pictures notice such changes.
pub const RENDER_EPOCH: u32 = 37;

/// Renders a region of the scene's picture, which must fit ([`Region::fits`]).
pub fn render(scene: &Scene, region: Region, control: &Control) -> Result<Picture, Cancelled> {
    render_with(scene, region, control, RenderOptions::default())
}

/// [`render`], with options.
pub fn render_with(
    scene: &Scene,
    region: Region,
    control: &Control,
    options: RenderOptions,
) -> Result<Picture, Cancelled> {
    render_window_with(scene, &Window::whole(scene.width, scene.height), region, control, options)
}

/// Renders a region of a window of the scene's picture, in the window's pixels; it must fit the window. The result is that
/// crop of the whole window's picture, byte for byte.
pub fn render_window(scene: &Scene, window: &Window, region: Region, control: &Control) -> Result<Picture, Cancelled> {
    render_window_with(scene, window, region, control, RenderOptions::default())
}

fn render_window_with(
    scene: &Scene,
    window: &Window,
    region: Region,
    control: &Control,
    options: RenderOptions,
) -> Result<Picture, Cancelled> {
    let start = Stopwatch::start();
    let picture = with_world!(&scene.world, |world| {
        Renderer::new(scene, world, control, options).through(window).picture(region)?
    });
    Ok(Picture { trace_ms: start.milliseconds(), ..picture })
}

/// Renders the pixel in the middle of each block of `step` x `step` pixels, exactly as the whole picture has it, and lists the
/// rays of each, and its time if `timed`. They are the picture's own pixels.
pub fn render_measured(scene: &Scene, step: u32, timed: bool, control: &Control) -> Result<Picture, Cancelled> {
    fn of<R: KernelFormat>(
        scene: &Scene,
        world: &World<R>,
        step: u32,
        timed: bool,
        control: &Control,
    ) -> Result<Picture, Cancelled> {
        let renderer = Renderer::new(scene, world, control, RenderOptions::default()).measured(timed);
        if step == 1 { renderer.picture(Region::whole(scene.width, scene.height)) } else { renderer.sparse(step) }
    }
    let start = Stopwatch::start();
    let picture = with_world!(&scene.world, |world| of(scene, world, step, timed, control)?);
    Ok(Picture { trace_ms: start.milliseconds(), ..picture })
}

/// Samples of one pixel of the scene's picture.
pub fn samples_of(scene: &Scene, at: [u32; 2], control: &Control) -> Result<u32, Cancelled> {
    fn of<R: KernelFormat>(renderer: &Renderer<'_, R>, at: [u32; 2]) -> Result<u32, Cancelled> {
        match renderer.scene {
            Scene { statistical: Some(_), .. } => renderer.sure_samples_of(at),
            Scene { adaptive: true, .. } => renderer.doubled_samples_of(at),
            scene if scene.refines() => renderer.refined_samples_of(at),
            scene => Ok(scene.samples),
        }
    }
    with_world!(&scene.world, |world| of(&Renderer::new(scene, world, control, RenderOptions::default()), at))
}
