//! Pictures of 8-bit codes, which metrics compare.

use crate::film::{Film, srgb};

/// sRGB codes of a picture, row by row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image8 {
    /// Pixels across.
    pub width: usize,
    /// Red, green and blue.
    pub pixels: Vec<[u8; 3]>,
}

impl Image8 {
    /// Pixels down.
    pub fn height(&self) -> usize {
        self.pixels.len().checked_div(self.width).unwrap_or(0)
    }
}

impl From<&Film> for Image8 {
    fn from(film: &Film) -> Self {
        let mut pixels = vec![[0; 3]; film.pixels.len()];
        srgb::Codes8::get().codes(film.shown().as_flattened(), pixels.as_flattened_mut());
        Self { width: film.region.width as usize, pixels }
    }
}
