//! How far pictures are from each other, and what getting nearer costs.

mod advice;
mod ciede2000;
mod codes;
mod flip;
mod maps;
pub mod page;
pub mod pareto;
pub mod plot;
mod spread;
pub mod sweep;
pub mod tradeoff;

pub use advice::advice;

pub use ciede2000::ciede2000;
pub use codes::{Codes, codes};
pub use flip::{PIXELS_PER_DEGREE, flip};
pub use maps::{Map, MapKind};
pub use spread::Spread;
pub use sweep::Errors;

use crate::film::{Film, srgb};

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

impl From<&Film> for Codes8 {
    fn from(film: &Film) -> Self {
        let mut pixels = vec![[0; 3]; film.pixels.len()];
        srgb::Codes8::get().codes(film.pixels.as_flattened(), pixels.as_flattened_mut());
        Self { width: film.region.width as usize, pixels }
    }
}
