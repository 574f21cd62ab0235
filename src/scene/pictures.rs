//! The pictures of a scene's textures and environment: read, limited and decoded.
//!
//! Against decompression bombs, all limits are checked before the texels are decoded: the bytes of a picture, its sides,
//! and the pixels of all pictures together.

use super::description::{Description, Diffuse, ImageMap, Relief, TexelChannel, Textured};
use super::limits::{PICTURE_BYTES, PICTURE_PIXELS, PICTURE_SIDE};
use super::problem::{Code, Problem, Problems, push_token, quoted, unless_cancelled};
use crate::control::{self, Cancelled};
use crate::math;
use crate::shading::texture::mipmap::Mipmap;
use data_encoding::BASE64;
use image::{ColorType, DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits, Rgb32FImage};
use std::collections::HashMap;
use std::io::{self, BufRead, Cursor, Read, Seek, SeekFrom};
use std::sync::Arc;

/// Pictures that cannot be read, after which no others are looked at.
const BROKEN_PICTURES: usize = 10;

/// What loading a scene takes from outside: the files that it names, and memory.
pub trait Files: Sync {
    /// The bytes of a file; at most one more than [`PICTURE_BYTES`] are needed. An error is the end of a sentence that begins
    /// with the file's name.
    fn read(&self, name: &str) -> Result<Vec<u8>, String>;

    /// Whether there is memory for so many bytes more, asked before a picture is decoded. Without it the scene is not built.
    fn has_room(&self, _bytes: u64) -> bool {
        true
    }
}

/// No files: pictures have to be in the scene.
#[derive(Debug, Clone, Copy)]
pub struct NoFiles;

impl Files for NoFiles {
    fn read(&self, _: &str) -> Result<Vec<u8>, String> {
        Err("cannot be read: files are not read here. Put the picture into the scene as \"data:image/png;base64,...\""
            .into())
    }
}

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
}

/// The meaning of a picture that has a number in one of its channels.
pub(super) fn number_of(textured: &Textured<f64>) -> Meaning {
    if textured.channel == Some(TexelChannel::A) { Meaning::Alpha } else { Meaning::Data }
}

/// Decoded pictures, one for each source and meaning.
#[derive(Debug, Default)]
pub(super) struct Pictures<'a> {
    known: HashMap<(&'a str, Meaning), Arc<Mipmap>>,
    /// Whether any came from a file, whose content may change.
    pub(super) from_files: bool,
}

impl<'a> Pictures<'a> {
    /// Reads all pictures of a description.
    pub(super) fn read(description: &'a Description, files: &dyn Files) -> Result<Self, Problems> {
        let mut pictures = Self::default();
        let mut problems = Vec::new();
        let mut left = PICTURE_PIXELS.max;
        for (source, meaning, pointer) in wanted(description) {
            if pictures.known.contains_key(&(source, meaning)) {
                continue;
            }
            unless_cancelled()?;
            pictures.from_files |= !is_url(source);
            match bytes(source, files).and_then(|bytes| decode(&bytes, meaning, &mut left, files)) {
                Ok(mipmap) => {
                    pictures.known.insert((source, meaning), Arc::new(mipmap));
                }
                Err((code, detail)) => problems.push(Problem::new(pointer, code, detail)),
            }
            // Each takes as long as a picture that can be read.
            if problems.len() >= BROKEN_PICTURES {
                break;
            }
        }
        if problems.is_empty() { Ok(pictures) } else { Err(Problems(problems)) }
    }

    /// A picture that was read.
    pub(super) fn get(&self, source: &str, meaning: Meaning) -> Arc<Mipmap> {
        let known = self.known.get(&(source, meaning));
        Arc::clone(known.unwrap_or_else(|| unreachable!("all pictures have been read")))
    }

    /// Bytes they take.
    pub(super) fn bytes(&self) -> usize {
        self.known.values().map(|mipmap| mipmap.bytes()).sum()
    }
}

/// The pictures of a description, with the JSON pointer of each.
fn wanted<'a>(description: &'a Description) -> Vec<(&'a str, Meaning, String)> {
    let mut wanted = Vec::new();
    if let Some(image) = description.environment.as_ref().and_then(|environment| environment.image.as_ref()) {
        wanted.push((image.as_str(), Meaning::Radiance, "/environment/image".to_owned()));
    }
    for (name, material) in description.materials.iter() {
        let at = |rest: &str| push_token("/materials", name) + rest;
        let mut map = |image: &'a ImageMap, meaning, pointer| wanted.push((image.source.as_str(), meaning, pointer));
        if let Some(image) = material.ambient.as_ref().and_then(Diffuse::image) {
            map(image, Meaning::Color, at("/ambient/image/source"));
        }
        if let Some(image) = material.diffuse.image() {
            map(image, Meaning::Color, at("/diffuse/image/source"));
        }
        if let Some(Relief::Image(image)) = material.bump.as_ref().map(|bump| &bump.texture) {
            map(image, Meaning::Height, at("/bump/texture/image/source"));
        }
        if let Some(normals) = &material.normal_map {
            map(&normals.image, Meaning::Normal, at("/normal_map/image/source"));
        }
        if let Some(pbr) = &material.pbr {
            let mut keep = |image: &'a str, meaning, key: &str| wanted.push((image, meaning, at(key)));
            for (key, channel) in pbr.colors() {
                if let Some(textured) = channel.textured() {
                    keep(&textured.image, Meaning::Color, &format!("/pbr/{key}/image"));
                }
            }
            let alpha = pbr.opacity.as_ref().map(|opacity| ("opacity/alpha", &opacity.alpha));
            let numbers = pbr.numbers().into_iter().chain(alpha);
            let numbers = numbers.filter_map(|(key, channel)| Some((key, channel.textured()?)));
            for (key, textured) in numbers.chain(pbr.occlusion.as_deref().map(|textured| ("occlusion", textured))) {
                keep(&textured.image, number_of(textured), &format!("/pbr/{key}/image"));
            }
            if let Some(normal) = &pbr.normal {
                keep(&normal.image, Meaning::Normal, "/pbr/normal/image");
            }
        }
    }
    wanted
}

/// Bytes of the names and contents of pictures in a description.
pub(super) fn source_bytes(description: &Description) -> u64 {
    wanted(description).iter().map(|(source, ..)| source.len() as u64).sum()
}

/// Bytes for each pixel while a picture is decoded: as the decoder gives it, as numbers, and in all its sizes.
const DECODING: u64 = 40;

/// Bytes that a decoder gets at a time.
const PORTION: usize = 1 << 14;

type Failure = (Code, String);

/// Whether a source is a URL, not the name of a file. (`C:` is a drive.)
fn is_url(source: &str) -> bool {
    let scheme = source.split(':').next().unwrap_or_default();
    scheme.len() > 1
        && scheme.len() < source.len()
        && scheme.bytes().all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b))
}

/// The bytes of a picture file.
fn bytes(source: &str, files: &dyn Files) -> Result<Vec<u8>, Failure> {
    let bytes = if source.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
        let Some((_, data)) = source.split_once(";base64,") else {
            return Err((Code::Unsupported, "must be written as \"data:image/png;base64,...\"".into()));
        };
        BASE64.decode(data.as_bytes()).map_err(|error| (Code::Degenerate, format!("is no base64: {error}")))?
    } else if is_url(source) {
        let detail = "pictures are never fetched: name a file, or write \"data:image/png;base64,...\"";
        return Err((Code::Unsupported, detail.into()));
    } else {
        files.read(source).map_err(|why| (Code::UnknownReference, format!("{} {why}", quoted(source))))?
    };
    if bytes.len() as u64 > PICTURE_BYTES.max {
        let detail =
            format!("the picture has more bytes than the limit of {} ({})", PICTURE_BYTES.max, PICTURE_BYTES.name);
        return Err((Code::Limit, detail));
    }
    Ok(bytes)
}

/// Decodes a picture, and subtracts its pixels from those that are `left`.
fn decode(bytes: &[u8], meaning: Meaning, left: &mut u64, files: &dyn Files) -> Result<Mipmap, Failure> {
    let broken = |error: ImageError| (Code::Degenerate, format!("the picture cannot be decoded: {error}"));
    let mut reader = ImageReader::new(Interruptible(Cursor::new(bytes)))
        .with_guessed_format()
        .map_err(|error| (Code::Degenerate, format!("the picture cannot be read: {error}")))?;
    match reader.format() {
        Some(ImageFormat::Png | ImageFormat::Jpeg) => {}
        Some(ImageFormat::Hdr | ImageFormat::OpenExr) if meaning == Meaning::Radiance => {}
        _ if meaning == Meaning::Radiance => {
            return Err((Code::Unsupported, "the picture is neither PNG, JPEG, Radiance HDR nor OpenEXR".into()));
        }
        _ => return Err((Code::Unsupported, "the picture is neither PNG nor JPEG".into())),
    }
    let mut limits = Limits::default();
    // At most four channels of 16 bits, and as much for the decoder.
    limits.max_alloc = Some(16 * PICTURE_PIXELS.max);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if u64::from(width.max(height)) > PICTURE_SIDE.max {
        let (name, max) = (PICTURE_SIDE.name, PICTURE_SIDE.max);
        return Err((Code::Limit, format!("a side of {width} x {height} pixels is over the limit of {max} ({name})")));
    }
    if pixels > *left {
        let (name, max) = (PICTURE_PIXELS.name, PICTURE_PIXELS.max);
        let detail =
            format!("with these {width} x {height} pixels the scene's pictures are over the limit of {max} ({name})");
        return Err((Code::Limit, detail));
    }
    if !files.has_room(bytes.len() as u64 + pixels * DECODING) {
        return Err((Code::Limit, "there is no memory for the picture".into()));
    }
    // Also those of a picture that turns out to be broken, since they take as long.
    *left -= pixels;
    let image = DynamicImage::from_decoder(decoder).map_err(broken)?;
    if matches!(image.color(), ColorType::Rgb32F | ColorType::Rgba32F) {
        return radiance(&image.into_rgb32f());
    }
    let wide = image.color().bytes_per_pixel() / image.color().channel_count() > 1;
    let most = if wide { u16::MAX } else { u8::MAX.into() };
    // A table of all values takes milliseconds for 16 bits, longer than a small picture.
    let table: Vec<f32> =
        if pixels < u64::from(most) { Vec::new() } else { (0..=most).map(|code| value(meaning, code, most)).collect() };
    let value = |code: u16| table.get(usize::from(code)).copied().unwrap_or_else(|| value(meaning, code, most));
    let texels = if meaning == Meaning::Alpha {
        let rgba = image.into_rgba16();
        rgba.pixels().map_while(|pixel| unless_stopping([f32::from(pixel.0[3]) / f32::from(u16::MAX); 3])).collect()
    } else if wide {
        let rgb = image.into_rgb16();
        rgb.pixels().map_while(|pixel| unless_stopping(texel(meaning, pixel.0.map(value)))).collect()
    } else {
        let rgb = image.into_rgb8();
        let value = |code: u8| value(code.into());
        rgb.pixels().map_while(|pixel| unless_stopping(texel(meaning, pixel.0.map(value)))).collect()
    };
    unless_cancelled().map_err(|_| (Code::Cancelled, String::new()))?;
    Ok(Mipmap::new(width, height, texels))
}

/// A picture of high dynamic range. Its numbers below 0, which some programs write for colours that no screen has, are 0.
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
        Meaning::Height | Meaning::Data | Meaning::Alpha => code / most,
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
