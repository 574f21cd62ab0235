//! From a film to the bytes of a file. The same film gives the same bytes on every machine and with any number of threads.

use super::{Adjustment, FileFormat, Film, PictureFormat, exr, pfm, png, web_formats};

/// A film's integer codes as a format stores them; none for formats of floats.
#[derive(Debug)]
pub struct Codes {
    size: [u32; 2],
    /// Three for each pixel, or four with alpha.
    pub(super) codes: Vec<u8>,
    channels: usize,
}

impl Codes {
    /// The first half of encoding: channels to codes, on the current rayon pool.
    pub fn new(film: &Film, format: FileFormat) -> Self {
        let size = [film.region.width, film.region.height];
        let transparent = film.is_clear();
        let codes = match format {
            FileFormat::Png8 | FileFormat::WebP if transparent => {
                let (colors, alpha) = film.straight();
                with_alpha(&png::codes8(&colors), &alpha, |alpha| [(255.0 * alpha + 0.5) as u8])
            }
            FileFormat::Png16 if transparent => {
                let (colors, alpha) = film.straight();
                with_alpha(&png::codes16(&colors), &alpha, |alpha| ((65535.0 * alpha + 0.5) as u16).to_be_bytes())
            }
            FileFormat::Png8 | FileFormat::Jpeg(_) | FileFormat::WebP => png::codes8(&film.shown()),
            FileFormat::Png16 => png::codes16(&film.shown()),
            FileFormat::Exr | FileFormat::Pfm => Vec::new(),
        };
        let alone = matches!(format, FileFormat::Jpeg(_)) || !transparent;
        Self { size, codes, channels: if alone { 3 } else { 4 } }
    }

    /// Codes of 8 bits, mirrored, turned and without color as asked.
    #[must_use]
    pub fn adjusted(self, adjustment: Adjustment) -> Self {
        let (size, codes) = match self.channels {
            3 => adjustment.apply::<3>(self.size, self.codes),
            _ => adjustment.apply::<4>(self.size, self.codes),
        };
        Self { size, codes, channels: self.channels }
    }

    /// The second half, on one thread: codes to the file. `film` and `format` must be those that the codes are from.
    pub fn file(&self, film: &Film, format: FileFormat) -> Vec<u8> {
        self.file_with(film, format, None)
    }

    /// [`Self::file`], with a text about the picture. Only PNG has a place for it: an iTXt chunk with the keyword
    /// [`NOTE`](super::NOTE).
    pub fn file_with(&self, film: &Film, format: FileFormat, note: Option<&str>) -> Vec<u8> {
        match format {
            FileFormat::Png8 => png::file(self.size, &self.codes, self.channels, ::png::BitDepth::Eight, note),
            FileFormat::Png16 => png::file(self.size, &self.codes, self.channels, ::png::BitDepth::Sixteen, note),
            FileFormat::Jpeg(quality) => web_formats::jpeg(self.size, &self.codes, quality),
            FileFormat::WebP => web_formats::webp(self.size, &self.codes, self.channels),
            FileFormat::Exr => exr::encode(film),
            FileFormat::Pfm => pfm::encode(film),
        }
    }
}

/// Codes of colors, each pixel with that of its alpha behind.
fn with_alpha<const BYTES: usize>(colors: &[u8], alpha: &[f32], code: impl Fn(f32) -> [u8; BYTES]) -> Vec<u8> {
    let mut codes = Vec::with_capacity(colors.len() + alpha.len() * BYTES);
    for (color, alpha) in colors.chunks_exact(3 * BYTES).zip(alpha) {
        codes.extend_from_slice(color);
        codes.extend(code(*alpha));
    }
    codes
}

/// The PNG of 8-bit codes, rows from the top: three for each pixel, or four with alpha.
pub fn png_of(width: u32, height: u32, codes: &[u8]) -> Vec<u8> {
    let pixels = u64::from(width) * u64::from(height);
    let channels = if codes.len() as u64 == 4 * pixels { 4 } else { 3 };
    png::file([width, height], codes, channels, ::png::BitDepth::Eight, None)
}

/// A lossless picture of 8-bit codes in the other format of such pictures; none if the file is no picture of codes.
pub fn transcoded(file: &[u8], format: PictureFormat) -> Option<Vec<u8>> {
    let picture = image::load_from_memory(file).ok()?;
    let (size, clear) = ([picture.width(), picture.height()], picture.color().has_alpha());
    let (codes, channels) =
        if clear { (picture.into_rgba8().into_raw(), 4) } else { (picture.into_rgb8().into_raw(), 3) };
    match format {
        PictureFormat::Png => Some(png::file(size, &codes, channels, ::png::BitDepth::Eight, None)),
        PictureFormat::Webp => Some(web_formats::webp(size, &codes, channels)),
        PictureFormat::Jpg | PictureFormat::Exr | PictureFormat::Pfm => None,
    }
}

/// Encodes a film. This cannot fail: a film's size is within the formats' limits.
pub fn encode(film: &Film, format: FileFormat) -> Vec<u8> {
    Codes::new(film, format).file(film, format)
}

/// A film whose every channel tells where it is, for the encoders' tests.
#[cfg(test)]
pub(super) fn test_film(region: super::Region, full_width: u32, full_height: u32) -> Film {
    let pixel = |i: u32| {
        let (x, y) = (region.x + i % region.width, region.y + i / region.width);
        [x as f32 / full_width as f32, y as f32 / full_height as f32, (x * y) as f32 * 0.3]
    };
    Film {
        region,
        full_width,
        full_height,
        pixels: (0..region.width * region.height).map(pixel).collect(),
        ..Film::default()
    }
}
