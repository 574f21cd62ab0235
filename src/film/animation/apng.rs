//! Animated PNG: the chunks of the first file, and the pixels of the others in chunks of their own.

use super::{NoAnimation, Timing};
use flate2::Crc;

const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Type and contents of a chunk.
type Chunk<'a> = ([u8; 4], &'a [u8]);

/// The chunks of a file, up to its end.
struct Chunks<'a>(&'a [u8]);

impl<'a> Iterator for Chunks<'a> {
    type Item = Chunk<'a>;

    fn next(&mut self) -> Option<Self::Item> {
        let (head, rest) = self.0.split_first_chunk::<8>()?;
        let [length, kind] = [0, 4].map(|at| [head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let (contents, rest) = rest.split_at_checked(u32::from_be_bytes(length) as usize)?;
        self.0 = rest.get(4..)?;
        Some((kind, contents))
    }
}

fn chunks(file: &[u8]) -> Result<Vec<Chunk<'_>>, NoAnimation> {
    let chunks: Vec<_> = Chunks(file.strip_prefix(SIGNATURE).ok_or(NoAnimation::NoPicture)?).collect();
    let is_whole = chunks.first().is_some_and(|(kind, head)| kind == b"IHDR" && head.len() == 13)
        && chunks.last().is_some_and(|(kind, _)| kind == b"IEND");
    if is_whole { Ok(chunks) } else { Err(NoAnimation::NoPicture) }
}

pub(super) fn join(files: &[&[u8]], timing: Timing) -> Result<Vec<u8>, NoAnimation> {
    let first = chunks(files.first().ok_or(NoAnimation::NoPicture)?)?;
    let head = first[0].1;
    let mut out = Vec::with_capacity(files.iter().map(|file| file.len() + 64).sum());
    out.extend(SIGNATURE);
    put(&mut out, *b"IHDR", &[head]);
    let count = u32::try_from(files.len()).map_err(|_| NoAnimation::TooLarge)?;
    put(&mut out, *b"acTL", &[&count.to_be_bytes(), &u32::from(timing.loops).to_be_bytes()]);
    // What the file says of its colors. Texts are about the first frame alone.
    for (kind, contents) in first[1..].iter().take_while(|(kind, _)| kind != b"IDAT") {
        if !matches!(kind, b"iTXt" | b"tEXt" | b"zTXt") {
            put(&mut out, *kind, &[contents]);
        }
    }
    let mut numbers = (0_u32..).map(u32::to_be_bytes);
    let mut number = || numbers.next().unwrap_or_default();
    // Hundredths of frames a second: 24 is 100 / 2400 s.
    let denominator = (100.0 * timing.rate).round() as u16;
    for (frame, file) in files.iter().enumerate() {
        let chunks = chunks(file)?;
        if chunks[0].1 != head {
            return Err(NoAnimation::Different);
        }
        let place = [0; 8];
        // The frame replaces all of the one before.
        let ends = [0, 0];
        let time = [100_u16, denominator].map(u16::to_be_bytes);
        put(&mut out, *b"fcTL", &[&number(), &head[..8], &place, time.as_flattened(), &ends]);
        for (_, pixels) in chunks.iter().filter(|(kind, _)| kind == b"IDAT") {
            match frame {
                0 => put(&mut out, *b"IDAT", &[pixels]),
                _ => put(&mut out, *b"fdAT", &[&number(), pixels]),
            }
        }
    }
    put(&mut out, *b"IEND", &[]);
    Ok(out)
}

/// Writes a chunk whose contents are in parts.
fn put(out: &mut Vec<u8>, kind: [u8; 4], parts: &[&[u8]]) {
    let length: usize = parts.iter().map(|part| part.len()).sum();
    out.extend((length as u32).to_be_bytes());
    let start = out.len();
    out.extend(kind);
    parts.iter().for_each(|part| out.extend(*part));
    let mut check = Crc::new();
    check.update(&out[start..]);
    out.extend(check.sum().to_be_bytes());
}
