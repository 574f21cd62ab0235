//! Pictures in memory, and the files they are written to.

mod adjust;
pub mod encode;
mod exr;
mod format;
mod pfm;
mod png;
mod sink;
pub mod srgb;
pub mod srgb16;
mod web_formats;

pub use adjust::{Adjustment, Tone};
pub use encode::{Codes, encode};
pub use format::{DEFAULT_QUALITY, FileFormat, Misplaced, PictureFormat};
pub use png::NOTE;

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, schemars::JsonSchema)]
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

    /// Whether a pixel, given by column and row, is one of the region's.
    pub fn contains(&self, [x, y]: [u32; 2]) -> bool {
        (self.x..self.x + self.width).contains(&x) && (self.y..self.y + self.height).contains(&y)
    }

    /// The place of a pixel of the region, row by row.
    pub fn index(&self, [x, y]: [u32; 2]) -> usize {
        (y - self.y) as usize * self.width as usize + (x - self.x) as usize
    }

    /// Number of pixels.
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// The region and the pixels next to it, within a picture of this size.
    #[must_use]
    pub fn with_border(&self, width: u32, height: u32) -> Self {
        let (x, y) = (self.x.saturating_sub(1), self.y.saturating_sub(1));
        let (right, bottom) = ((self.x + self.width + 1).min(width), (self.y + self.height + 1).min(height));
        Self { x, y, width: right - x, height: bottom - y }
    }

    /// The pixels, row by row.
    pub fn iter(self) -> impl Iterator<Item = [u32; 2]> {
        (self.y..self.y + self.height).flat_map(move |y| (self.x..self.x + self.width).map(move |x| [x, y]))
    }

    /// Squares of the given edge that cover the region, cut off at its border, row by row.
    pub fn tiles(self, edge: u32) -> impl Iterator<Item = Self> {
        let (columns, rows) = (self.width.div_ceil(edge), self.height.div_ceil(edge));
        (0..rows).flat_map(move |row| {
            (0..columns).map(move |column| {
                let (left, top) = (column * edge, row * edge);
                Self {
                    x: self.x + left,
                    y: self.y + top,
                    width: edge.min(self.width - left),
                    height: edge.min(self.height - top),
                }
            })
        })
    }
}

/// The pixels of a region of a picture: linear radiance, rows from the top.
#[derive(Debug, Clone, PartialEq, Default)]
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
