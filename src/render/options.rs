//! Options of a render.

use fearless_simd::Level;

/// Options of a render; no pixel depends on them.
#[derive(Debug, Clone, Copy)]
pub struct RenderOptions {
    /// Edge of a tile in pixels, at least 1.
    pub tile: u32,
    /// Instruction set.
    pub level: Level,
    /// Whether to use the kernel's variant for the scene's effects, not the general one.
    pub specialised: bool,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { tile: 32, level: Level::new(), specialised: true }
    }
}
