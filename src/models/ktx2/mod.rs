//! KTX 2.0 with textures of Basis Universal, as KHR_texture_basisu allows: ETC1S with BasisLZ, and UASTC with or without
//! Zstandard. Only the largest level is unpacked, to eight bits of red, green, blue and alpha.

mod bits;
mod etc1s;
mod huffman;
mod patterns;
mod uastc;

use etc1s::Codebooks;
use ruzstd::decoding::StreamingDecoder;
use std::io::Read;

/// How files begin.
pub const MAGIC: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";
/// Bytes before the index of levels.
const HEADER: usize = 80;
/// Color models of the data format descriptor (Khronos Data Format Specification 1.3).
const ETC1S: u8 = 163;
const UASTC: u8 = 166;
/// The channel of opacity in a sample of ETC1S.
const OPACITY: u8 = 15;
/// Bytes of a block of UASTC.
const BLOCK: usize = 16;

/// Why a picture cannot be read: the end of a sentence that begins with it.
type Failure = String;

/// A picture whose header has been read.
#[derive(Debug)]
pub struct Ktx2<'a> {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    form: Form<'a>,
}

/// How the largest level is written.
#[derive(Debug)]
enum Form<'a> {
    Etc1s { level: &'a [u8], shared: &'a [u8], levels: usize, has_opacity: bool },
    Uastc { level: &'a [u8], is_packed: bool },
}

/// Numbers at offsets, with the lowest byte first.
fn word(bytes: &[u8], at: usize) -> Result<u32, Failure> {
    let word = bytes.get(at..).and_then(|rest| rest.first_chunk());
    word.map(|word| u32::from_le_bytes(*word)).ok_or_else(|| "ends too early".to_owned())
}

/// A part of the file, whose offset and length are words of so many bytes.
fn part(bytes: &[u8], at: usize, size: usize) -> Result<&[u8], Failure> {
    let number = |at: usize| -> Result<u64, Failure> {
        let high = if size == 8 { word(bytes, at + 4)? } else { 0 };
        Ok(u64::from(high) << 32 | u64::from(word(bytes, at)?))
    };
    let (start, length) = (number(at)?, number(at + size)?);
    let end = start.checked_add(length).filter(|end| *end <= bytes.len() as u64);
    let end = end.ok_or_else(|| format!("has no {length} bytes at {start}"))?;
    Ok(&bytes[start as usize..end as usize])
}

impl<'a> Ktx2<'a> {
    /// Reads the header; nothing is unpacked.
    pub fn read(bytes: &'a [u8]) -> Result<Self, Failure> {
        if !bytes.starts_with(MAGIC) {
            return Err("is no KTX 2.0".into());
        }
        let header = |index: usize| word(bytes, MAGIC.len() + 4 * index);
        let [format, width, height] = [header(0)?, header(2)?, header(3)?];
        let [depth, layers, faces] = [header(4)?, header(5)?, header(6)?];
        if width == 0 || height == 0 || depth > 1 || layers > 1 || faces != 1 {
            return Err("is no single picture of two dimensions".into());
        }
        let (levels, scheme) = (header(7)?.max(1) as usize, header(8)?);
        if levels > 32 {
            return Err(format!("has {levels} levels"));
        }
        let descriptor = part(bytes, 48, 4)?;
        let model = *descriptor.get(12).ok_or("has no data format descriptor")?;
        let level = part(bytes, HEADER, 8)?;
        let form = match (format, model, scheme) {
            (0, ETC1S, 1) => {
                // Of the second sample, if there is one.
                let channel = descriptor.get(28 + 16 + 3).map(|channel| channel & 15);
                if channel.is_some_and(|channel| channel != OPACITY) {
                    return Err("has two channels, and RGB or RGBA are read".into());
                }
                let shared = part(bytes, 64, 8)?;
                Form::Etc1s { level, shared, levels, has_opacity: channel.is_some() }
            }
            (0, UASTC, 0 | 2) => Form::Uastc { level, is_packed: scheme == 2 },
            _ => {
                return Err(format!(
                    "has the format {format}, the color model {model} and the supercompression {scheme}, and Basis \
                     Universal is read: ETC1S with BasisLZ, UASTC with or without Zstandard"
                ));
            }
        };
        Ok(Self { width, height, form })
    }

    /// Unpacks all pixels, row by row from the top. The caller has checked that there may be so many.
    pub fn decode(&self) -> Result<Vec<[u8; 4]>, Failure> {
        let mut pixels = Pixels::new(self.width, self.height);
        match &self.form {
            Form::Etc1s { level, shared, levels, has_opacity } => {
                let codebooks = Codebooks::read(shared, *levels)?;
                codebooks.color(level, &mut pixels)?;
                if *has_opacity {
                    codebooks.opacity(level, &mut pixels)?;
                }
            }
            Form::Uastc { level, is_packed: false } => uastc::decode(&mut &level[..], &mut pixels)?,
            Form::Uastc { level, is_packed: true } => {
                let unpacked = StreamingDecoder::new(&level[..]);
                let mut unpacked = unpacked.map_err(|error| format!("is no Zstandard: {error}"))?;
                uastc::decode(&mut unpacked, &mut pixels)?;
            }
        }
        Ok(pixels.pixels)
    }
}

/// Pixels that are set in blocks of 4 x 4.
struct Pixels {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 4]>,
}

impl Pixels {
    fn new(width: u32, height: u32) -> Self {
        let (width, height) = (width as usize, height as usize);
        // Of zeros, pages are taken when they are written: a file may claim more pixels than it has.
        Self { width, height, pixels: vec![[0; 4]; width * height] }
    }

    /// Blocks across and down.
    fn blocks(&self) -> [usize; 2] {
        [self.width.div_ceil(4), self.height.div_ceil(4)]
    }

    /// Changes the pixels of a block that are in the picture; they are numbered row by row.
    fn change(&mut self, [x, y]: [usize; 2], mut change: impl FnMut(usize, &mut [u8; 4])) {
        for down in 0..4.min(self.height - 4 * y) {
            let start = (4 * y + down) * self.width + 4 * x;
            for across in 0..4.min(self.width - 4 * x) {
                change(4 * down + across, &mut self.pixels[start + across]);
            }
        }
    }
}

/// Fills a row of blocks of UASTC.
fn fill(from: &mut dyn Read, blocks: &mut [u8]) -> Result<(), Failure> {
    from.read_exact(blocks).map_err(|error| format!("cannot be unpacked: {error}"))
}
