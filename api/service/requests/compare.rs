//! Comparing two pictures: as their 8-bit codes, as people see them, and as light.

use super::Service;
use crate::service::error::Error;
use crate::service::pictures::file::PictureFile;
use crate::service::scheduler::admission::Work;
use crate::service::scheduler::task::Task;
use image::{ImageFormat, load_from_memory_with_format};
use std::sync::Arc;
use strahl::film::encode::png_of;
use strahl::film::{FileFormat, Film, Region, encode, encode_gray};
use strahl::metrics::{CodeErrors, Image8, Spread, ciede2000, code_errors, flip, flip_map};
use strahl::render::Cancelled;

/// Most pixels of pictures that are compared as people see them, which takes a thousand times as long as comparing codes.
pub(crate) const SEEN_PIXELS: u64 = 1 << 22;
/// Bytes of memory for each pixel of two pictures that are compared.
const CODES_BYTES: u64 = 48;
/// Likewise as people see them.
const SEEN_BYTES: u64 = 400;

/// How far two pictures are from each other.
#[derive(Debug)]
pub(crate) struct Compared {
    /// In codes.
    pub(crate) codes: CodeErrors,
    /// FLIP and CIEDE2000, of pictures that are not too large.
    pub(crate) seen: Option<[Spread; 2]>,
}

/// What is drawn of the difference of two pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Drawn {
    /// Codes, times a gain, as a PNG.
    Codes(u32),
    /// The second less the first, as light, in a PFM.
    Light,
    /// FLIP in a grey PFM.
    Flip,
}

impl Drawn {
    /// The format that it is made from.
    pub(crate) fn source(self) -> FileFormat {
        if self == Self::Light { FileFormat::Pfm } else { FileFormat::Png8 }
    }
}

impl Service {
    /// Refuses pictures that cannot be compared, by their pixels across and down, before they are rendered. Returns those of both.
    pub(crate) fn check_comparison(&self, [a, b]: [[u32; 2]; 2], drawn: Option<Drawn>) -> Result<[u32; 2], Error> {
        if a != b {
            return Err(Error::OutOfRange(format!(
                "the pictures have {} x {} and {} x {} pixels: only pictures of one size can be compared",
                a[0], a[1], b[0], b[1]
            )));
        }
        if drawn == Some(Drawn::Flip) && pixels(a) > SEEN_PIXELS {
            let detail = format!("FLIP is of at most {SEEN_PIXELS} pixels (flip_pixels): ask for smaller pictures");
            return Err(Error::Limit { name: "flip_pixels", max: SEEN_PIXELS, detail });
        }
        self.memory.check(bytes(a, drawn))?;
        Ok(a)
    }

    /// Compares two PNG files of 8 bits and of one size.
    pub(crate) async fn compare(
        &self,
        task: Task,
        files: [Arc<PictureFile>; 2],
        size: [u32; 2],
    ) -> Result<Compared, Error> {
        let memory = self.memory.clone();
        let compare = move |work: &Work| -> Result<Compared, Error> {
            let mut share = memory.share(0);
            share.grow(bytes(size, None))?;
            work.workers.work(|| {
                let [a, b] = [decoded(&files[0])?, decoded(&files[1])?];
                let seen = (pixels(size) <= SEEN_PIXELS).then(|| [flip(&a, &b), ciede2000(&a, &b)]);
                unless_cancelled()?;
                Ok(Compared { codes: code_errors(&a, &b), seen })
            })?
        };
        Ok(self.run(task, compare).await?.value)
    }

    /// Draws the difference of two files of one size, and of the format that is needed for it.
    pub(crate) async fn draw_difference(
        &self,
        task: Task,
        files: [Arc<PictureFile>; 2],
        size: [u32; 2],
        drawn: Drawn,
    ) -> Result<Vec<u8>, Error> {
        let memory = self.memory.clone();
        let draw = move |work: &Work| -> Result<Vec<u8>, Error> {
            let mut share = memory.share(0);
            share.grow(bytes(size, Some(drawn)))?;
            work.workers.work(|| draw(&files, size, drawn))?
        };
        Ok(self.run(task, draw).await?.value)
    }
}

fn pixels([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}

/// Bytes of memory that comparing two pictures takes, or drawing their difference.
fn bytes(size: [u32; 2], drawn: Option<Drawn>) -> u64 {
    let pixels = pixels(size);
    let is_seen = drawn.map_or(pixels <= SEEN_PIXELS, |drawn| drawn == Drawn::Flip);
    pixels * if is_seen { SEEN_BYTES } else { CODES_BYTES }
}

fn draw(files: &[Arc<PictureFile>; 2], [width, height]: [u32; 2], drawn: Drawn) -> Result<Vec<u8>, Error> {
    let region = Region::whole(width, height);
    let film = |pixels| Film { region, full_width: width, full_height: height, pixels, ..Film::default() };
    match drawn {
        Drawn::Light => {
            let [a, b] = [floats(&files[0])?, floats(&files[1])?];
            let difference: Vec<[f32; 3]> =
                a.iter().zip(&b).map(|(a, b)| std::array::from_fn(|c| b[c] - a[c])).collect();
            Ok(encode(&film(difference), FileFormat::Pfm))
        }
        Drawn::Flip => {
            let [a, b] = [decoded(&files[0])?, decoded(&files[1])?];
            let values: Vec<f32> = flip_map(&a, &b).into_iter().map(|value| value as f32).collect();
            unless_cancelled()?;
            Ok(encode_gray(width, height, &values))
        }
        Drawn::Codes(gain) => {
            let [a, b] = [decoded(&files[0])?, decoded(&files[1])?];
            let shown = |off: u8| (u32::from(off) * gain).min(255) as u8;
            let codes: Vec<u8> = a.differences(&b).into_iter().flatten().map(shown).collect();
            Ok(png_of(width, height, &codes))
        }
    }
}

/// Pixels across and down of a file.
pub(crate) fn size_of(file: &PictureFile) -> Result<[u32; 2], Error> {
    let number =
        |at: usize| file.bytes.get(at..at + 4).map(|four| u32::from_be_bytes([four[0], four[1], four[2], four[3]]));
    // The header of a PNG is its first chunk.
    let of_png = || Some([number(16)?, number(20)?]);
    let size = if file.bytes.starts_with(b"PF\n") { pfm(file).map(|(size, _)| size) } else { of_png() };
    size.ok_or(Error::Internal("a picture cannot be read"))
}

fn unless_cancelled() -> Result<(), Error> {
    strahl::control::look_now().map_err(|Cancelled| Error::Cancelled)
}

/// The codes of a PNG file that we have written.
fn decoded(file: &PictureFile) -> Result<Image8, Error> {
    let picture = load_from_memory_with_format(&file.bytes, ImageFormat::Png);
    let picture = picture.map_err(|_| Error::Internal("a picture cannot be read"))?.into_rgba8();
    unless_cancelled()?;
    let width = picture.width() as usize;
    Ok(Image8::straight(width, picture.as_raw().as_chunks::<4>().0))
}

/// Size and numbers of a PFM file that we have written.
fn pfm(file: &PictureFile) -> Option<([u32; 2], &[u8])> {
    let mut lines = file.bytes.splitn(4, |byte| *byte == b'\n').skip(1);
    let size = std::str::from_utf8(lines.next()?).ok()?;
    let (width, height) = size.split_once(' ')?;
    Some(([width.parse().ok()?, height.parse().ok()?], lines.nth(1)?))
}

/// The pixels of a PFM file, from the top.
fn floats(file: &PictureFile) -> Result<Vec<[f32; 3]>, Error> {
    let ([width, _], numbers) = pfm(file).ok_or(Error::Internal("a picture cannot be read"))?;
    let number = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let pixel = |bytes: &[u8]| [number(bytes), number(&bytes[4..]), number(&bytes[8..])];
    let rows = numbers.chunks_exact(12 * width as usize).rev();
    Ok(rows.flat_map(|row| row.chunks_exact(12).map(pixel)).collect())
}
