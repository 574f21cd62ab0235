//! Questions about single rays and pixels: what a ray hits, every ray of a pixel, and maps of what pixels took.

pub mod first_hits;
pub mod maps;
pub mod query;
pub mod tree;
mod tree_drawing;

pub use tree_drawing::TreeFormat;
