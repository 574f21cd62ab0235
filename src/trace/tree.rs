//! The ray tree of a pixel.

use crate::scene::Scene;
use serde::Serialize;

/// Every ray of one pixel.
#[derive(Debug, Clone, Serialize)]
pub struct Tree {
    /// Column and row of the pixel.
    pub pixel: [u32; 2],
}

impl Tree {
    /// Graphviz text.
    pub fn to_dot(&self) -> String {
        String::new()
    }
    /// A drawing.
    pub fn to_svg(&self) -> String {
        String::new()
    }
}

/// Traces one pixel and records every ray. The pixel must lie inside the picture.
pub fn trace_pixel(_scene: &Scene, x: u32, y: u32) -> Tree {
    Tree { pixel: [x, y] }
}
