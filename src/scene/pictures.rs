//! The pictures of a scene's textures and environment: read, limited and decoded.
//!
//! Against decompression bombs, all limits are checked before the texels are decoded: the bytes of a picture, its sides,
//! and the memory of all pictures together.

use super::Scene;
use super::description::{Description, Diffuse, ImageMap, PictureNames, Relief, TexelChannel, Textured};
use super::hashes::hash_of;
use super::limits::{PICTURE_BYTES, PICTURE_MEMORY, PICTURE_SIDE};
use super::problem::{Code, Problem, Problems, push_token, unless_cancelled};
use crate::control::{self, Cancelled};
use crate::math;
use crate::models::ktx2::{self, Ktx2};
use crate::models::{data_uri, jpeg};
use crate::shading::texture::mipmap::Mipmap;
use image::{
    ColorType, DynamicImage, GenericImageView, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits, Rgb32FImage,
    RgbaImage,
};
use std::collections::{HashMap, HashSet};
use std::io::{self, BufRead, Cursor, Read, Seek, SeekFrom};
use std::sync::Arc;

/// Pictures that cannot be read, after which no others are looked at.
const BROKEN_PICTURES: usize = 10;

/// What loading a scene takes from outside: the files that it names, and memory.
pub trait Files: Sync {
    /// The bytes of a file; at most one more than [`PICTURE_BYTES`] are needed. An error is the end of a sentence that begins
    /// with the file's name.
    fn read(&self, name: &str) -> Result<Vec<u8>, String>;

    /// Whether there is an asset of this SHA-256, which is then read under the name `sha256:` and its digits.
    fn has_asset(&self, _hash: &str) -> bool {
        false
    }

    /// A scene that is kept and may have the same objects, among them models. This one is then built as a variation of it.
    fn known(&self, _description: &Description) -> Option<Arc<dyn KnownScene>> {
        None
    }

    /// Whether there is memory for so many bytes more, asked before a picture is decoded. Without it the scene is not built.
    fn has_room(&self, _bytes: u64) -> bool {
        true
    }
}

/// A scene that somebody keeps, of which others may be variations.
pub trait KnownScene: Send + Sync {
    /// What it was built from, and the scene.
    fn kept(&self) -> Option<(&Description, &Scene)>;
}

/// No files: pictures have to be in the scene.
#[derive(Debug, Clone, Copy)]
pub struct NoFiles;

impl Files for NoFiles {
    fn read(&self, _: &str) -> Result<Vec<u8>, String> {
        Err("cannot be read: files are not read here. Send it as an asset, and name it \"sha256:...\"; or with its model, as \
             another part of a multipart/form-data body; or put a picture into the scene as \"data:image/png;base64,...\""
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

/// What a picture is of: its source, and the meaning of its numbers.
type Key<'a> = (&'a str, Meaning);

/// The pictures that a scene was built with, as its description names them.
pub(super) type Decoded<'a> = Vec<(Key<'a>, Arc<Mipmap>)>;

/// Decoded pictures, one for each source and meaning.
#[derive(Debug, Default)]
pub(super) struct Pictures {
    /// As the description names them.
    all: Vec<Arc<Mipmap>>,
    /// By where the source is in memory: it may be a whole picture, and is asked for often.
    places: HashMap<(usize, usize, Meaning), Arc<Mipmap>>,
    /// Whether any came from a file, whose content may change.
    pub(super) from_files: bool,
}

/// Where a source is in memory.
fn place((source, meaning): Key<'_>) -> (usize, usize, Meaning) {
    (source.as_ptr() as usize, source.len(), meaning)
}

impl Pictures {
    /// Reads all pictures of a description that are not `known`.
    pub(super) fn read(description: &Description, files: &dyn Files, known: Decoded<'_>) -> Result<Self, Problems> {
        let mut pictures = Self::default();
        let mut problems = Vec::new();
        let mut left = PICTURE_MEMORY.max;
        let mut counted = HashSet::new();
        let mut decoded: HashMap<Key<'_>, Arc<Mipmap>> = HashMap::new();
        let mut others: Option<HashMap<Key<'_>, Arc<Mipmap>>> = None;
        for (i, (source, meaning, pointer)) in wanted(description).into_iter().enumerate() {
            unless_cancelled()?;
            let key = (source, meaning);
            pictures.from_files |= !is_url(source);
            // Mostly it is in the same place as in the other scene.
            let before = known.get(i).filter(|(other, _)| *other == key).map(|(_, mipmap)| Arc::clone(mipmap));
            let before = before.filter(|_| is_url(source)).or_else(|| {
                let of_others = || known.iter().filter(|((source, _), _)| is_url(source)).cloned().collect();
                let others = if known.is_empty() { None } else { Some(others.get_or_insert_with(of_others)) };
                others.and_then(|others| others.get(&key)).or_else(|| decoded.get(&key)).map(Arc::clone)
            });
            if let Some(mipmap) = before {
                if counted.insert(Arc::as_ptr(&mipmap) as usize) {
                    left = left.saturating_sub(mipmap.bytes() as u64);
                }
                pictures.keep(key, mipmap);
                continue;
            }
            match bytes(source, files).and_then(|bytes| decode(&bytes, meaning, &mut left, files)) {
                Ok(mipmap) => {
                    let mipmap = Arc::new(mipmap);
                    counted.insert(Arc::as_ptr(&mipmap) as usize);
                    decoded.insert(key, Arc::clone(&mipmap));
                    pictures.keep(key, mipmap);
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

    fn keep(&mut self, key: Key<'_>, mipmap: Arc<Mipmap>) {
        self.places.insert(place(key), Arc::clone(&mipmap));
        self.all.push(mipmap);
    }

    /// A picture that was read, by the source in the description that it was read for.
    pub(super) fn get(&self, source: &str, meaning: Meaning) -> Arc<Mipmap> {
        let known = self.places.get(&place((source, meaning)));
        Arc::clone(known.unwrap_or_else(|| unreachable!("all pictures have been read")))
    }

    /// All of them, as the description names them.
    pub(super) fn all(&self) -> &[Arc<Mipmap>] {
        &self.all
    }
}

/// Bytes of pictures, each counted once, without those that are among `others`.
pub(super) fn bytes_of(pictures: &[Arc<Mipmap>], others: &[Arc<Mipmap>]) -> usize {
    let place = |mipmap: &Arc<Mipmap>| Arc::as_ptr(mipmap) as usize;
    let mut counted: HashSet<usize> = others.iter().map(place).collect();
    pictures.iter().filter(|mipmap| counted.insert(place(mipmap))).map(|mipmap| mipmap.bytes()).sum()
}

/// The pictures that a scene was built with.
pub(super) fn known<'a>(description: &'a Description, pictures: &[Arc<Mipmap>]) -> Decoded<'a> {
    let keys = wanted(description).into_iter().map(|(source, meaning, _)| (source, meaning));
    keys.zip(pictures.iter().map(Arc::clone)).collect()
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
            for (key, map) in pbr.normals() {
                if let Some(map) = map {
                    keep(&map.image, Meaning::Normal, &format!("/pbr/{key}/image"));
                }
            }
        }
    }
    wanted
}

/// The sources of the pictures of a description, with the JSON pointer of each.
pub(super) fn sources(description: &Description) -> impl Iterator<Item = (&str, String)> {
    wanted(description).into_iter().map(|(source, _, pointer)| (source, pointer))
}

/// Problems with pictures of models, with what their files call them: in place of the pointers, or of models that a scene places
/// in the sentences.
pub(super) fn named(description: &Description, names: &PictureNames, problems: Problems, is_placed: bool) -> Problems {
    if names.is_empty() {
        return problems;
    }
    let sources: HashMap<String, &str> = sources(description).map(|(source, pointer)| (pointer, source)).collect();
    let one = |problem: Problem| {
        let name = sources.get(&problem.pointer).and_then(|source| names.get(source));
        let Some(name) = name else { return problem };
        let detail = &problem.detail;
        match (is_placed, name.starts_with('/')) {
            (true, _) => Problem { detail: format!("in the model: {name}: {detail}"), ..problem },
            (false, true) => Problem { pointer: name.to_owned(), ..problem },
            (false, false) => Problem { pointer: String::new(), detail: format!("{name}: {detail}"), ..problem },
        }
    };
    // A picture with two meanings is one picture of the model.
    Problems(problems.0.into_iter().map(one).collect()).each_once()
}

/// Bytes of the names and contents of pictures in a description.
pub(super) fn source_bytes(description: &Description) -> u64 {
    wanted(description).iter().map(|(source, ..)| source.len() as u64).sum()
}

/// Bytes for each pixel of 8 bits while a picture is decoded: as the decoder gives it, and as three channels.
const DECODING: u64 = 8;

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
    let bytes = if let Some(bytes) = data_uri::decoded(source) {
        bytes.map_err(|why| (Code::Degenerate, why))?
    } else if is_url(source) && hash_of(source).is_none() {
        let detail = "pictures are never fetched: name a file, or write \"data:image/png;base64,...\"";
        return Err((Code::Unsupported, detail.into()));
    } else {
        files.read(source).map_err(|why| Problem::unread(source, &why))?
    };
    if bytes.len() as u64 > PICTURE_BYTES.max {
        let detail =
            format!("the picture has more bytes than the limit of {} ({})", PICTURE_BYTES.max, PICTURE_BYTES.name);
        return Err((Code::Limit, detail));
    }
    Ok(bytes)
}

/// Decodes a picture, and subtracts its bytes from those that are `left`.
fn decode(bytes: &[u8], meaning: Meaning, left: &mut u64, files: &dyn Files) -> Result<Mipmap, Failure> {
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
    let texels = if meaning == Meaning::Alpha {
        let rgba = image.into_rgba16();
        rgba.pixels().map_while(|pixel| unless_stopping([value(pixel.0[3]); 3])).collect()
    } else {
        let rgb = image.into_rgb16();
        rgb.pixels().map_while(|pixel| unless_stopping(texel(meaning, pixel.0.map(value)))).collect()
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
