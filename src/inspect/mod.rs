//! Questions about single rays and pixels: what a ray hits, and every ray of a pixel.

pub mod first_hits;
pub mod query;
pub mod tree;
mod tree_drawing;

pub use tree_drawing::TreeFormat;
