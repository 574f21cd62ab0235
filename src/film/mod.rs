//! Pixels and the files they go into.

pub mod encode;
mod exr;
mod pfm;
mod png;
pub mod srgb;

pub use encode::{FileFormat, encode};

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Region {
    /// Left edge.
    pub x: u32,
    /// Upper edge.
    pub y: u32,
    /// Pixels across, at least 1.
    pub width: u32,
    /// Pixels down, at least 1.
    pub height: u32,
}

impl Region {
    /// The whole of a picture.
    pub fn whole(width: u32, height: u32) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// Whether the region has pixels and lies inside a picture of this size.
    pub fn fits(&self, width: u32, height: u32) -> bool {
        let inside =
            |start: u32, length: u32, end: u32| length > 0 && start.checked_add(length).is_some_and(|e| e <= end);
        inside(self.x, self.width, width) && inside(self.y, self.height, height)
    }
}

/// The pixels of a region of a picture: linear radiance, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    /// Which part of the picture this is.
    pub region: Region,
    /// Pixels across the whole picture.
    pub full_width: u32,
    /// Pixels down the whole picture.
    pub full_height: u32,
    /// `region.width * region.height` pixels.
    pub pixels: Vec<[f32; 3]>,
}
