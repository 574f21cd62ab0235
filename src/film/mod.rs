//! Pictures in memory, and the files they are written to.

mod adjust;
pub mod animation;
pub mod cryptomatte;
mod display;
pub mod encode;
mod exr;
mod format;
mod layers;
mod pfm;
mod png;
pub mod sheet;
mod sink;
pub mod srgb;
pub mod srgb16;
mod tone;
mod web_formats;

pub use adjust::{Adjustment, Tone};
pub use display::Display;
pub use encode::{Codes, encode};
pub use exr::encode_with as encode_exr_with;
pub use format::{DEFAULT_QUALITY, FileFormat, Misplaced, PictureFormat};
pub use layers::{ID_CHANNELS, Layer};
pub use pfm::encode_gray;
pub use png::NOTE;
pub use tone::{ToneMapping, taken_by_khronos_pbr_neutral};

use rayon::prelude::*;
use std::borrow::Cow;

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, schemars::JsonSchema)]
pub struct Region {
    /// Left edge.
    pub x: u32,
    /// Upper edge.
    pub y: u32,
    /// Pixels across, at least 1.
    pub width: u32,
    /// Pixels down, at least 1.
    pub height: u32,
}

impl Region {
    /// The whole of a picture.
    pub fn whole(width: u32, height: u32) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// Whether the region has pixels and lies inside a picture of this size.
    pub fn fits(&self, width: u32, height: u32) -> bool {
        let inside =
            |start: u32, length: u32, end: u32| length > 0 && start.checked_add(length).is_some_and(|e| e <= end);
        inside(self.x, self.width, width) && inside(self.y, self.height, height)
    }

    /// Whether a pixel, given by column and row, is one of the region's.
    pub fn contains(&self, [x, y]: [u32; 2]) -> bool {
        (self.x..self.x + self.width).contains(&x) && (self.y..self.y + self.height).contains(&y)
    }

    /// The place of a pixel of the region, row by row.
    pub fn index(&self, [x, y]: [u32; 2]) -> usize {
        (y - self.y) as usize * self.width as usize + (x - self.x) as usize
    }

    /// Number of pixels.
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// The region and the pixels next to it, within a picture of this size.
    #[must_use]
    pub fn with_border(&self, width: u32, height: u32) -> Self {
        let (x, y) = (self.x.saturating_sub(1), self.y.saturating_sub(1));
        let (right, bottom) = ((self.x + self.width + 1).min(width), (self.y + self.height + 1).min(height));
        Self { x, y, width: right - x, height: bottom - y }
    }

    /// The pixels, row by row.
    pub fn iter(self) -> impl Iterator<Item = [u32; 2]> {
        (self.y..self.y + self.height).flat_map(move |y| (self.x..self.x + self.width).map(move |x| [x, y]))
    }

    /// Squares of the given edge that cover the region, cut off at its border, row by row.
    pub fn tiles(self, edge: u32) -> impl Iterator<Item = Self> {
        let (columns, rows) = (self.width.div_ceil(edge), self.height.div_ceil(edge));
        (0..rows).flat_map(move |row| {
            (0..columns).map(move |column| {
                let (left, top) = (column * edge, row * edge);
                Self {
                    x: self.x + left,
                    y: self.y + top,
                    width: edge.min(self.width - left),
                    height: edge.min(self.height - top),
                }
            })
        })
    }
}

/// The pixels of a region of a picture: linear radiance, rows from the top.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Film {
    /// Which part of the picture this is.
    pub region: Region,
    /// Pixels across the whole picture.
    pub full_width: u32,
    /// Pixels down the whole picture.
    pub full_height: u32,
    /// `region.width * region.height` pixels.
    pub pixels: Vec<[f32; 3]>,
    /// The share of each pixel that is not background, if the background is transparent: `pixels` are its light alone, which
    /// is already multiplied by it (premultiplied alpha). Else empty.
    pub alpha: Vec<f32>,
    /// How formats of codes show the light.
    pub display: Display,
}

impl Film {
    /// Whether pictures of codes are transparent where nothing is.
    pub fn is_clear(&self) -> bool {
        !self.alpha.is_empty() && self.display.backdrop().is_none()
    }

    /// The linear colours that pictures of codes show, over the backdrop or else black where the background is transparent.
    pub fn shown(&self) -> Cow<'_, [[f32; 3]]> {
        if self.alpha.is_empty() {
            return self.display.all(&self.pixels);
        }
        let (straight, alpha) = self.straight();
        let backdrop = self.display.backdrop().unwrap_or_default();
        let over = |(color, alpha): (&[f32; 3], &f32)| -> [f32; 3] {
            std::array::from_fn(|c| color[c].min(1.0) * alpha + backdrop[c] * (1.0 - alpha))
        };
        Cow::Owned(straight.iter().zip(&alpha).map(over).collect())
    }

    /// The linear colours that are shown, not multiplied by alpha, and their alpha. Files of codes have no colours above 1. So
    /// where a highlight on glass is brighter than its alpha, they have more alpha: over black the light is whole, and what is
    /// behind it shows less.
    fn straight(&self) -> (Vec<[f32; 3]>, Vec<f32>) {
        let undo = |(pixel, alpha): (&[f32; 3], &f32)| {
            let alpha = if self.display.is_linear() {
                self.display.show(*pixel).into_iter().fold(*alpha, f32::max).min(1.0)
            } else {
                *alpha
            };
            let color = if alpha > 0.0 { pixel.map(|c| c / alpha) } else { [0.0; 3] };
            (self.display.show(color), alpha)
        };
        self.pixels.par_iter().zip(&self.alpha).map(undo).unzip()
    }

    /// How many codes a pixel is off at most, channel by channel, if its radiance is nowhere above `highest`, and its alpha not below
    /// `least_alpha`: of the picture over black where the background is transparent, and of its alpha. Over any brighter one
    /// colours are off by no more, since codes of dark colours are the nearest to each other.
    pub fn codes_off(&self, index: usize, highest: [f32; 3], least_alpha: f32) -> [u8; 3] {
        let pixel = self.pixels[index];
        if highest.iter().any(|channel| channel.is_infinite()) {
            // Nothing is known of it: a pixel that was not traced may also be darker than it is shown.
            return self.display.codes(pixel).map(|code| code.max(u8::MAX - code));
        }
        let Some(&alpha) = self.alpha.get(index) else { return self.display.codes_off(pixel, highest) };
        if alpha <= 0.0 {
            return [0; 3];
        }
        let least = least_alpha.min(alpha);
        let of_colors = match self.display.is_linear() {
            true => self.display.codes_off(pixel, highest),
            false => self.codes_off_by_tone(pixel, highest, [alpha, least]),
        };
        let code = |alpha: f32| (255.0 * alpha).round() as u8;
        of_colors.map(|off| off.max(code(alpha) - code(least)))
    }

    /// The same over black, where tone is of colours that are not multiplied by an alpha between those given.
    fn codes_off_by_tone(&self, pixel: [f32; 3], highest: [f32; 3], [alpha, least]: [f32; 2]) -> [u8; 3] {
        let over_black = |color: f32, alpha: f32| srgb::code8(color.min(1.0) * alpha);
        let shown = self.display.show(pixel.map(|c| c / alpha)).map(|color| over_black(color, alpha));
        let mut off = [0; 3];
        for alpha in [alpha, least].into_iter().filter(|alpha| *alpha > 0.0) {
            let [low, high] = [pixel, highest].map(|radiance| radiance.map(|c| c / alpha));
            let ends = self.display.ends(low, high).map(|ends| ends.map(|color| over_black(color, alpha)));
            off =
                std::array::from_fn(|c| ends[c].into_iter().fold(off[c], |off, code| off.max(code.abs_diff(shown[c]))));
        }
        off
    }
}
