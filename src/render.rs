//! One picture: tiles on the current rayon pool, with progress and cancellation.

use crate::film::{Film, Region};
use crate::scene::Scene;
use serde::Serialize;
use std::sync::atomic::{AtomicBool, AtomicU64};

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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[expect(missing_docs, reason = "the names say it")]
pub struct RayCounts {
    pub camera: u64,
    pub shadow: u64,
    pub reflected: u64,
    pub transmitted: u64,
    /// Camera rays that hit something.
    pub camera_hits: u64,
    /// Transmissions that total internal reflection turned into reflections.
    pub total_internal_reflections: u64,
    /// Rays not followed because a sample reached the limit `rays_per_sample`.
    pub dropped: u64,
}

/// A finished render.
#[derive(Debug)]
pub struct Picture {
    /// The pixels.
    pub film: Film,
    /// What was traced.
    pub rays: RayCounts,
    /// Milliseconds of wall time spent tracing.
    pub trace_ms: f64,
}

/// The render was cancelled before it was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cancelled;

/// Renders a region of the scene's picture, which must fit ([`Region::fits`]).
pub fn render(_scene: &Scene, _region: Region, _control: &Control) -> Result<Picture, Cancelled> {
    Err(Cancelled)
}
