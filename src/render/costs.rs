//! What each pixel takes, for maps of it.

/// What one pixel took.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelCost {
    /// Its column and row in the whole picture.
    pub at: [u32; 2],
    /// Rays of all kinds.
    pub rays: u64,
    /// Wall time of tracing it alone, with what begins a packet: more than its share of a packet of pixels.
    pub nanoseconds: u64,
    /// Longest chain of rays that were followed.
    pub deepest: u32,
}
