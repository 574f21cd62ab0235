//! What is proved about pictures: how bright anything in a scene can be at most, which pixels lack light, and how far
//! recursion without end can be from what is shown.

pub mod ceiling;
mod pixels;
mod proof;

pub use pixels::{BoundedPixel, BoundedPixels};
pub use proof::Proof;
