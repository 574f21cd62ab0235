//! Pictures of 8-bit codes, which metrics compare.

use crate::film::{Film, srgb};
use crate::math::srgb_to_linear;

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

impl Image8 {
    /// Codes with alpha, which do not contain it, over black.
    pub fn over_black(width: usize, pixels: &[[u8; 4]]) -> Self {
        let codes = srgb::Codes8::get();
        let table: Vec<f32> = (0..=255_u8).map(|code| srgb_to_linear(f64::from(code) / 255.0) as f32).collect();
        let over = |[r, g, b, alpha]: &[u8; 4]| match alpha {
            255 => [*r, *g, *b],
            alpha => [r, g, b].map(|code| codes.code(table[usize::from(*code)] * f32::from(*alpha) / 255.0)),
        };
        Self { width, pixels: pixels.iter().map(over).collect() }
    }
}

impl From<&Film> for Image8 {
    fn from(film: &Film) -> Self {
        let mut pixels = vec![[0; 3]; film.pixels.len()];
        srgb::Codes8::get().codes(film.shown().as_flattened(), pixels.as_flattened_mut());
        Self { width: film.region.width as usize, pixels }
    }
}
