//! Pictures in memory, and the files they are written to.

mod adjust;
pub mod animation;
pub mod cryptomatte;
mod display;
pub mod encode;
mod exr;
mod format;
mod layers;
mod part;
mod pfm;
mod png;
pub mod sheet;
mod sink;
pub mod srgb;
pub mod srgb16;
mod tone;
mod web_formats;

pub use adjust::{Adjustment, Tone};
use display::CHUNK;
pub use display::Display;
pub use encode::{Codes, encode};
pub use exr::encode_with as encode_exr_with;
pub use format::{DEFAULT_QUALITY, FileFormat, Misplaced, PictureFormat};
pub use layers::{ID_CHANNELS, Layer};
pub(crate) use part::code_of_alpha;
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
    pub fn iter(self) -> impl Iterator<Item = [u32; 2]> + Clone {
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

    /// The linear colors that pictures of codes show, over the backdrop or else black where the background is transparent.
    pub fn shown(&self) -> Cow<'_, [[f32; 3]]> {
        if self.alpha.is_empty() {
            return self.display.all(&self.pixels);
        }
        let backdrop = self.display.backdrop().unwrap_or_default();
        let mut shown = vec![[0.0; 3]; self.pixels.len()];
        let chunks = self.pixels.par_chunks(CHUNK).zip(self.alpha.par_chunks(CHUNK)).zip(shown.par_chunks_mut(CHUNK));
        chunks.for_each(|((pixels, alpha), shown)| {
            self.display.show_each_part(pixels, alpha, shown);
            for (shown, alpha) in shown.iter_mut().zip(alpha) {
                *shown = std::array::from_fn(|c| shown[c] + backdrop[c] * (1.0 - alpha));
            }
        });
        Cow::Owned(shown)
    }

    /// The alpha that files of codes have; none where they have none.
    pub fn codes_of_alpha(&self) -> Vec<u8> {
        if self.is_clear() { self.straight().1.into_iter().map(code_of_alpha).collect() } else { Vec::new() }
    }

    /// The linear colors that are shown, not multiplied by alpha, and their alpha. Files of codes have no colors above 1. So
    /// where a highlight on glass is brighter than its alpha, they have more alpha: over black the light is whole, and what is
    /// behind it shows less.
    fn straight(&self) -> (Vec<[f32; 3]>, Vec<f32>) {
        let mut colors = vec![[0.0; 3]; self.pixels.len()];
        let mut alphas = vec![0.0; self.alpha.len()];
        let own = self.pixels.par_chunks(CHUNK).zip(self.alpha.par_chunks(CHUNK));
        own.zip(colors.par_chunks_mut(CHUNK)).zip(alphas.par_chunks_mut(CHUNK)).for_each(
            |(((pixels, alpha), colors), alphas)| {
                self.display.show_each_part(pixels, alpha, colors);
                for ((color, alpha), raised) in colors.iter_mut().zip(alpha).zip(alphas) {
                    *raised = part::raised(*alpha, *color);
                    let by = *raised;
                    *color = color.map(|channel| if by > 0.0 { channel / by } else { 0.0 });
                }
            },
        );
        (colors, alphas)
    }

    /// How many codes a pixel is off at most, channel by channel, if its radiance is nowhere above `highest`, and its alpha not below
    /// `least_alpha`: of the alpha that files have, and of the picture over the backdrop, or else black.
    pub fn codes_off(&self, index: usize, highest: [f32; 3], least_alpha: f32) -> [u8; 3] {
        let pixel = self.pixels[index];
        if highest.iter().any(|channel| channel.is_infinite()) {
            // Nothing is known of it: a pixel that was not traced may also be darker than it is shown, or clearer.
            let most = |code: u8| code.max(u8::MAX - code);
            let of_alpha = self.alpha.get(index).map_or(0, |alpha| most(code_of_alpha(*alpha)));
            return self.display.codes(pixel).map(|code| most(code).max(of_alpha));
        }
        let Some(&alpha) = self.alpha.get(index) else { return self.display.codes_off(pixel, highest) };
        self.display.codes_of_part_off(pixel, highest, [least_alpha.min(alpha), alpha])
    }
}
