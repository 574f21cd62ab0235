//! What a render shares with those who watch or cancel it.

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

/// The render was cancelled before it was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cancelled;
