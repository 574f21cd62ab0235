//! How far pictures are from each other.

mod ciede2000;
mod codes;
mod flip;
mod spread;

pub use ciede2000::ciede2000;
pub use codes::{Codes, codes};
pub use flip::{PIXELS_PER_DEGREE, flip};
pub use spread::Spread;

/// sRGB codes of a picture, row by row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Codes8 {
    /// Pixels across.
    pub width: usize,
    /// Red, green and blue.
    pub pixels: Vec<[u8; 3]>,
}

impl Codes8 {
    /// Pixels down.
    pub fn height(&self) -> usize {
        self.pixels.len().checked_div(self.width).unwrap_or(0)
    }
}
