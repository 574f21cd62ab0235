//! A window of the camera: any part of its picture at any size.
//!
//! A window is a grid of pixels over the plane of the scene's own picture, measured in that picture's pixels. Nothing is
//! resampled: rays go through the window's pixels, so a larger window shows more detail, not larger pixels.

/// A grid of pixels over the scene's picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Its upper left corner, in pixels of the scene's picture.
    pub origin: [f64; 2],
    /// Width and height of its pixels in those of the scene's picture, above 0.
    pub step: [f64; 2],
    /// Pixels across, at least 1.
    pub width: u32,
    /// Pixels down, at least 1.
    pub height: u32,
}

impl Window {
    /// The scene's own picture.
    pub fn whole(width: u32, height: u32) -> Self {
        Self { origin: [0.0; 2], step: [1.0; 2], width, height }
    }

    /// The whole picture in pixels that are 2^`level` wide and high: enlarged for negative levels, reduced for positive ones,
    /// where the last column and row may reach beyond the picture. `None` if it would have 2^32 pixels or more across or
    /// down.
    pub fn level(width: u32, height: u32, level: i32) -> Option<Self> {
        let scaled = |length: u32| match level {
            0.. => Some(u64::from(length).div_ceil(1_u64.checked_shl(level.unsigned_abs())?)),
            _ => u64::from(length).checked_mul(1_u64.checked_shl(level.unsigned_abs())?),
        };
        let step = libm::ldexp(1.0, level);
        let [width, height] = [scaled(width)?, scaled(height)?].map(u32::try_from);
        Some(Self { origin: [0.0; 2], step: [step; 2], width: width.ok()?, height: height.ok()? })
    }

    /// A rectangle of the picture, from `origin` and of `extent`, in `width` x `height` pixels.
    pub fn part(origin: [f64; 2], extent: [f64; 2], width: u32, height: u32) -> Self {
        Self { origin, step: [extent[0] / f64::from(width), extent[1] / f64::from(height)], width, height }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_have_the_pixels_that_cover_the_picture() {
        let size = |level| Window::level(1_000, 601, level).map(|window| [window.width, window.height]);
        assert_eq!(size(0), Some([1_000, 601]));
        assert_eq!(size(1), Some([500, 301]));
        assert_eq!(size(10), Some([1, 1]));
        assert_eq!(size(63), Some([1, 1]));
        assert_eq!(size(-3), Some([8_000, 4_808]));
        assert_eq!((size(-30), size(-64), size(64)), (None, None, None));
    }
}
