//! Questions about single rays and pixels: what a ray hits, every ray of a pixel, and maps of what pixels took.

pub mod first_hits;
mod map_scale;
pub mod maps;
pub mod overlay;
pub mod query;
mod ray_kinds;
pub mod tree;
mod tree_drawing;

pub use tree_drawing::TreeFormat;
