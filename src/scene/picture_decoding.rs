//! Decoding the pictures of a scene, within their limits.
//!
//! Against decompression bombs, all limits are checked before the texels are decoded: the sides of a picture, and the memory of
//! all pictures together.

use super::files::Files;
use super::limits::{PICTURE_MEMORY, PICTURE_SIDE};
use super::problem::{Code, unless_cancelled};
use crate::control::{self, Cancelled};
use crate::math;
use crate::models::jpeg;
use crate::models::ktx2::{self, Ktx2};
use crate::shading::texture::mipmap::Mipmap;
use image::{
    ColorType, DynamicImage, GenericImageView, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits, Rgb32FImage,
    RgbaImage,
};
use std::io::{self, BufRead, Cursor, Read, Seek, SeekFrom};

/// Bytes for each pixel of 8 bits while a picture is decoded: as the decoder gives it, and as three channels.
const DECODING: u64 = 8;

/// Bytes that a decoder gets at a time.
const PORTION: usize = 1 << 14;

/// Why a picture cannot be decoded.
pub(super) type Failure = (Code, String);

/// The meaning of a picture's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Meaning {
    /// sRGB.
    Color,
    /// Radiance: sRGB, or the numbers of a picture of high dynamic range.
    Radiance,
    /// Heights from 0 to 1, all channels alike.
    Height,
    /// Coordinates from -1 to 1.
    Normal,
    /// Numbers from 0 to 1.
    Data,
    /// Alpha from 0 to 1, in all channels.
    Alpha,
    /// A number from 0 to 1, and in the second channel whether it is at least another one: 1 or 0, so that means are shares.
    Mask(Mask),
}

/// What a mask is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Mask {
    /// The channel of the picture, 3 for alpha.
    pub(super) channel: u8,
    /// The bits of the least number, in single precision.
    pub(super) least: u32,
}

impl Mask {
    /// The numbers that stand for that of a texel.
    fn of(self, rgba: [f32; 4]) -> [f32; 3] {
        let number = rgba[usize::from(self.channel)];
        [number, f32::from(number >= f32::from_bits(self.least)), number]
    }
}

/// Decodes a picture, and subtracts its bytes from those that are `left`.
pub(super) fn decode(bytes: &[u8], meaning: Meaning, left: &mut u64, files: &dyn Files) -> Result<Mipmap, Failure> {
    let image = if bytes.starts_with(ktx2::MAGIC) {
        let broken = |why: String| (Code::Degenerate, format!("the picture {why}"));
        let picture = Ktx2::read(bytes).map_err(broken)?;
        let size = Size { width: picture.width, height: picture.height, is_wide: false };
        size.check(bytes, meaning, left, files)?;
        let pixels = picture.decode().map_err(broken)?;
        let image = RgbaImage::from_raw(picture.width, picture.height, pixels.into_flattened());
        DynamicImage::ImageRgba8(image.ok_or_else(|| broken("ends too early".into()))?)
    } else {
        let broken = |error: ImageError| (Code::Degenerate, format!("the picture cannot be decoded: {error}"));
        if bytes.starts_with(b"\xff\xd8\xff") && !jpeg::has_end(bytes) {
            return Err((
                Code::Degenerate,
                "the picture is cut off: this JPEG has no end, so a part of it is not there".into(),
            ));
        }
        let decoder = decoder(bytes, meaning)?;
        let (width, height) = decoder.dimensions();
        Size { width, height, is_wide: is_wide(decoder.color_type()) }.check(bytes, meaning, left, files)?;
        DynamicImage::from_decoder(decoder).map_err(broken)?
    };
    if matches!(image.color(), ColorType::Rgb32F | ColorType::Rgba32F) {
        return radiance(&image.into_rgb32f());
    }
    let mipmap = if is_wide(image.color()) { of_numbers(image, meaning) } else { of_codes(image, meaning) };
    unless_cancelled().map_err(|_| (Code::Cancelled, String::new()))?;
    Ok(mipmap)
}

/// Whether channels have 16 bits or more.
fn is_wide(color: ColorType) -> bool {
    color.bytes_per_pixel() > color.channel_count()
}

/// A picture of 8 bits.
fn of_codes(image: DynamicImage, meaning: Meaning) -> Mipmap {
    let (width, height) = image.dimensions();
    let codes = match meaning {
        Meaning::Alpha => {
            let alphas = image.into_rgba8();
            alphas.pixels().flat_map(|pixel| [pixel.0[3]; 3]).collect()
        }
        Meaning::Mask(mask) => {
            let texels = image.into_rgba8();
            let of = |code: u8| f32::from(code) / f32::from(u8::MAX);
            texels
                .pixels()
                .flat_map(|pixel| mask.of(pixel.0.map(of)).map(|number| (number * 255.0).round() as u8))
                .collect()
        }
        _ => image.into_rgb8().into_raw(),
    };
    let values = std::array::from_fn(|code| value(meaning, code as u16, u8::MAX.into()));
    let is_colorful = |texel: &[u8; 3]| texel[0] != texel[1] || texel[1] != texel[2];
    if meaning == Meaning::Height && codes.as_chunks().0.iter().any(is_colorful) {
        // Means of three channels are no codes.
        let texels = codes.as_chunks().0.iter();
        let texels = texels.map(|codes: &[u8; 3]| texel(meaning, codes.map(|code| values[usize::from(code)])));
        return Mipmap::new(width, height, texels.map_while(unless_stopping).collect());
    }
    Mipmap::of_codes(width, height, codes, values)
}

/// A picture of 16 bits.
fn of_numbers(image: DynamicImage, meaning: Meaning) -> Mipmap {
    let (width, height) = image.dimensions();
    let most = u16::MAX;
    // A table of all values takes milliseconds, longer than a small picture.
    let table: Vec<f32> = if u64::from(width) * u64::from(height) < most.into() {
        Vec::new()
    } else {
        (0..=most).map(|code| value(meaning, code, most)).collect()
    };
    let value = |code: u16| table.get(usize::from(code)).copied().unwrap_or_else(|| value(meaning, code, most));
    let texels = match meaning {
        Meaning::Alpha => {
            let rgba = image.into_rgba16();
            rgba.pixels().map_while(|pixel| unless_stopping([value(pixel.0[3]); 3])).collect()
        }
        Meaning::Mask(mask) => {
            let rgba = image.into_rgba16();
            rgba.pixels().map_while(|pixel| unless_stopping(mask.of(pixel.0.map(value)))).collect()
        }
        _ => {
            let rgb = image.into_rgb16();
            rgb.pixels().map_while(|pixel| unless_stopping(texel(meaning, pixel.0.map(value)))).collect()
        }
    };
    Mipmap::new(width, height, texels)
}

fn decoder(bytes: &[u8], meaning: Meaning) -> Result<impl ImageDecoder + '_, Failure> {
    let mut reader = ImageReader::new(Interruptible(Cursor::new(bytes)))
        .with_guessed_format()
        .map_err(|error| (Code::Degenerate, format!("the picture cannot be read: {error}")))?;
    match reader.format() {
        Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP) => {}
        Some(ImageFormat::Hdr | ImageFormat::OpenExr) if meaning == Meaning::Radiance => {}
        _ => {
            let more = if meaning == Meaning::Radiance { ", Radiance HDR, OpenEXR" } else { "" };
            return Err((Code::Unsupported, format!("the picture is none of PNG, JPEG, WebP{more} and KTX 2.0")));
        }
    }
    let mut limits = Limits::default();
    // At most four channels of 16 bits for three bytes that are kept, and as much for the decoder.
    limits.max_alloc = Some(4 * PICTURE_MEMORY.max);
    reader.limits(limits);
    let broken = |error: ImageError| (Code::Degenerate, format!("the picture cannot be decoded: {error}"));
    reader.into_decoder().map_err(broken)
}

/// How large a picture is.
struct Size {
    width: u32,
    height: u32,
    /// Whether it has 16 bits for a channel.
    is_wide: bool,
}

impl Size {
    /// Checks that a picture may be so large, and takes its bytes from those that are left.
    fn check(self, file: &[u8], meaning: Meaning, left: &mut u64, files: &dyn Files) -> Result<(), Failure> {
        let Self { width, height, is_wide } = self;
        if width == 0 || height == 0 {
            return Err((Code::Degenerate, format!("the picture of {width} x {height} pixels has none")));
        }
        if u64::from(width.max(height)) > PICTURE_SIDE.max {
            let (name, max) = (PICTURE_SIDE.name, PICTURE_SIDE.max);
            let detail = format!("a side of {width} x {height} pixels is over the limit of {max} ({name})");
            return Err((Code::Limit, detail));
        }
        // Heights in colors become numbers.
        let bytes = Mipmap::bytes_for(width, height, !is_wide && meaning != Meaning::Height);
        if bytes > *left {
            let (name, max) = (PICTURE_MEMORY.name, PICTURE_MEMORY.max);
            let detail = format!(
                "with these {width} x {height} pixels the scene's pictures take more than the limit of {max} bytes ({name})"
            );
            return Err((Code::Limit, detail));
        }
        let decoding = u64::from(width) * u64::from(height) * if is_wide { 2 * DECODING } else { DECODING };
        if !files.has_room(file.len() as u64 + bytes + decoding) {
            return Err((Code::Limit, "there is no memory for the picture".into()));
        }
        // Also those of a picture that turns out to be broken, since they take as long.
        *left -= bytes;
        Ok(())
    }
}

/// A picture of high dynamic range. Its numbers below 0, which some programs write for colors that no screen has, are 0.
fn radiance(image: &Rgb32FImage) -> Result<Mipmap, Failure> {
    let (width, height) = image.dimensions();
    if let Some((x, y, _)) = image.enumerate_pixels().find(|(_, _, pixel)| pixel.0.iter().any(|c| !is_radiance(*c))) {
        let detail = format!("the picture has a pixel at {x}, {y} that is no light: not a number up to {BRIGHTEST:e}");
        return Err((Code::OutOfRange, detail));
    }
    let texels = image.pixels().map_while(|pixel| unless_stopping(pixel.0.map(|channel| channel.max(0.0)))).collect();
    unless_cancelled().map_err(|_| (Code::Cancelled, String::new()))?;
    Ok(Mipmap::new(width, height, texels))
}

/// The brightest pixel that a picture may have; the sun has 10^9 candela per square metre.
const BRIGHTEST: f32 = 1e9;

fn is_radiance(channel: f32) -> bool {
    channel.is_finite() && channel <= BRIGHTEST
}

/// Bytes that cannot be read any more once the work is cancelled, so that decoders stop.
struct Interruptible<'a>(Cursor<&'a [u8]>);

impl Read for Interruptible<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        control::checkpoint(16).map_err(|Cancelled| io::Error::other("cancelled"))?;
        self.0.read(buffer)
    }
}

impl BufRead for Interruptible<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        control::checkpoint(16).map_err(|Cancelled| io::Error::other("cancelled"))?;
        // In portions, or all would be decoded after one look.
        self.0.fill_buf().map(|rest| &rest[..rest.len().min(PORTION)])
    }
    fn consume(&mut self, amount: usize) {
        self.0.consume(amount);
    }
}

impl Seek for Interruptible<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}

/// The value of a code, of which `most` is the largest.
fn value(meaning: Meaning, code: u16, most: u16) -> f32 {
    let (code, middle, most) = (f64::from(code), f64::from(most / 2), f64::from(most));
    let value = match meaning {
        Meaning::Color | Meaning::Radiance => math::srgb_to_linear(code / most),
        Meaning::Height | Meaning::Data | Meaning::Alpha | Meaning::Mask(_) => code / most,
        // An even number of codes has none in the middle: 128 stands for 0, and both 0 and 1 for -1.
        Meaning::Normal => ((code - (middle + 1.0)) / middle).max(-1.0),
    };
    value as f32
}

/// The texel, or the end of all if the work is cancelled.
fn unless_stopping(texel: [f32; 3]) -> Option<[f32; 3]> {
    (!control::step(1)).then_some(texel)
}

fn texel(meaning: Meaning, [r, g, b]: [f32; 3]) -> [f32; 3] {
    match meaning {
        Meaning::Height if r != g || g != b => [(r + g + b) / 3.0; 3],
        _ => [r, g, b],
    }
}
