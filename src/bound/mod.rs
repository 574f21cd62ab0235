//! Error bounds that are proved: the radiance ceiling of a scene, the pixels that may miss light, and the largest error of
//! a picture.

pub mod ceiling;
pub(crate) mod interval;
mod pixels;
mod proof;

pub use pixels::{BoundedPixel, BoundedPixels};
pub use proof::{GIVEN_UP, Proof};
