//! What a picture cost: the same JSON on `--stats`, and behind the headers of an answer.

use serde::Serialize;
use strahl::film::Region;
use strahl::plan::Plan;
use strahl::render::{RayCounts, Refined};
use strahl::scene::description::RenderSettings;

/// The cost report.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    /// The effects, each on or off, and why, and how deep rays go.
    pub(crate) plan: Plan,
    /// Time and rays.
    pub(crate) cost: Cost,
    /// How far the picture may be from the exact one.
    pub(crate) error: ErrorBounds,
    /// What renders the same pixels again.
    pub(crate) replay: Replay,
}

/// Time and rays.
#[derive(Debug, Serialize)]
pub(crate) struct Cost {
    /// Milliseconds from the scene's bytes to the picture's.
    pub(crate) wall_ms: f64,
    /// Where they went.
    pub(crate) phases_ms: Phases,
    /// Rays by kind.
    pub(crate) rays: RayCounts,
    /// Camera rays that hit something.
    pub(crate) camera_hits: u64,
    /// What antialiasing added.
    pub(crate) refined: Refined,
    /// Threads of the pool.
    pub(crate) threads: usize,
}

/// Milliseconds by phase, in order.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Phases {
    /// Reading the scene.
    pub(crate) parse: f64,
    /// Checking and compiling it.
    pub(crate) plan: f64,
    /// Building bounding volume hierarchies.
    pub(crate) bvh: f64,
    /// Tracing.
    pub(crate) trace: f64,
    /// Encoding the picture, whatever its format.
    pub(crate) png: f64,
}

impl Phases {
    /// Names and milliseconds, in order.
    pub(crate) fn list(&self) -> [(&'static str, f64); 5] {
        [("parse", self.parse), ("plan", self.plan), ("bvh", self.bvh), ("trace", self.trace), ("png", self.png)]
    }
}

/// Bounds by how they are known, kept apart. None is computed yet: all are null, which means unknown, not exact.
#[derive(Debug, Default, Serialize)]
pub(crate) struct ErrorBounds {
    /// True for certain.
    pub(crate) proved: Option<f64>,
    /// Likely.
    pub(crate) estimated: Option<f64>,
    /// Found against a reference picture.
    pub(crate) measured: Option<f64>,
}

/// What renders the same pixels again, on any machine and any number of threads.
#[derive(Debug, Serialize)]
pub(crate) struct Replay {
    /// Version of the renderer.
    pub(crate) version: &'static str,
    /// Width and height of the whole picture.
    pub(crate) image: [u32; 2],
    /// The part that was rendered.
    pub(crate) region: Region,
    /// The settings, after overrides.
    pub(crate) render: RenderSettings,
    /// Whether an NFF file's opaque surfaces were seen from behind, too.
    pub(crate) two_sided: bool,
    /// Whether an NFF file was rendered by the SPD's counting rules.
    pub(crate) spd_counts: bool,
}
