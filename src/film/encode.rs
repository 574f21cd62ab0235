//! Film to the bytes of a file. The same film gives the same bytes, on every machine and with any number of threads.

use super::{Film, exr, pfm, png};

/// Picture formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileFormat {
    /// PNG, sRGB, 8 bits per channel.
    Png8,
    /// PNG, sRGB, 16 bits per channel.
    Png16,
    /// OpenEXR, linear 32-bit floats; the data window is the region, the display window the whole picture.
    Exr,
    /// Portable float map, linear, little-endian.
    Pfm,
}

/// Encodes a film. This cannot fail: a film's size is within the formats' limits.
pub fn encode(film: &Film, format: FileFormat) -> Vec<u8> {
    match format {
        FileFormat::Png8 => png::encode8(film),
        FileFormat::Png16 => png::encode16(film),
        FileFormat::Exr => exr::encode(film),
        FileFormat::Pfm => pfm::encode(film),
    }
}

/// A film whose every channel tells where it is, for the encoders' tests.
#[cfg(test)]
pub(super) fn test_film(region: super::Region, full_width: u32, full_height: u32) -> Film {
    let pixel = |i: u32| {
        let (x, y) = (region.x + i % region.width, region.y + i / region.width);
        [x as f32 / full_width as f32, y as f32 / full_height as f32, (x * y) as f32 * 0.3]
    };
    Film { region, full_width, full_height, pixels: (0..region.width * region.height).map(pixel).collect() }
}
