//! Image metrics: how far one picture is from another.

mod ciede2000;
mod code_errors;
mod difference;
mod flip;
mod image;
mod spread;

pub use ciede2000::ciede2000;
pub use code_errors::{CodeErrors, code_errors};
pub use difference::Difference;
pub use flip::{PIXELS_PER_DEGREE, flip, flip_map};
pub use image::Image8;
pub use spread::Spread;
