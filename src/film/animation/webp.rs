//! Animated lossless WebP (RFC 9649): the `VP8L` chunks of the files, each in an `ANMF` chunk.

use super::{NoAnimation, Timing};

/// Flags of the whole file: it is an animation, and it may be transparent.
const ANIMATION: u8 = 0x02;
const ALPHA: u8 = 0x10;
/// Flag of a frame: it replaces the one before, instead of lying over it.
const REPLACES: u8 = 0x02;

/// The `VP8L` contents of a lossless WebP file.
fn lossless(file: &[u8]) -> Option<&[u8]> {
    let body = file.strip_prefix(b"RIFF")?.get(4..)?.strip_prefix(b"WEBP")?;
    let mut left = body;
    while let Some((head, rest)) = left.split_first_chunk::<8>() {
        let [kind, length] = [0, 4].map(|at| [head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let length = u32::from_le_bytes(length) as usize;
        let contents = rest.get(..length)?;
        if kind == *b"VP8L" {
            return Some(contents);
        }
        left = rest.get(length + length % 2..)?;
    }
    None
}

/// Width less 1, height less 1, and whether it may be transparent, of a lossless picture: after a byte of signature come 14
/// bits, 14 bits and one.
fn head(pixels: &[u8]) -> Option<(u32, u32, bool)> {
    let [0x2f, a, b, c, d, ..] = *pixels else { return None };
    let bits = u32::from_le_bytes([a, b, c, d]);
    Some((bits & 0x3fff, (bits >> 14) & 0x3fff, (bits >> 28) & 1 == 1))
}

pub(super) fn join(files: &[&[u8]], timing: Timing) -> Result<Vec<u8>, NoAnimation> {
    let frames: Option<Vec<_>> = files.iter().map(|file| lossless(file).and_then(|it| Some((it, head(it)?)))).collect();
    let frames = frames.filter(|frames| !frames.is_empty()).ok_or(NoAnimation::NoPicture)?;
    let (_, (width, height, _)) = frames[0];
    if frames.iter().any(|(_, (w, h, _))| (*w, *h) != (width, height)) {
        return Err(NoAnimation::Different);
    }
    let size = [&width.to_le_bytes()[..3], &height.to_le_bytes()[..3]].concat();
    let is_clear = frames.iter().any(|(_, (_, _, alpha))| *alpha);
    let mut out = Vec::with_capacity(files.iter().map(|file| file.len() + 32).sum::<usize>() + 64);
    out.extend(b"RIFF\0\0\0\0WEBP");
    put(&mut out, *b"VP8X", &[&[ANIMATION | if is_clear { ALPHA } else { 0 }, 0, 0, 0], &size]);
    put(&mut out, *b"ANIM", &[&[0; 4], &timing.loops.to_le_bytes()]);
    // Whole milliseconds, whose sum does not drift away from the rate.
    let begins = |frame: usize| (1_000.0 * frame as f64 / timing.rate).round() as u32;
    for (number, (pixels, _)) in frames.iter().enumerate() {
        let length = (begins(number + 1) - begins(number)).to_le_bytes();
        let mut inside = Vec::with_capacity(pixels.len() + 9);
        put(&mut inside, *b"VP8L", &[pixels]);
        put(&mut out, *b"ANMF", &[&[0; 6], &size, &length[..3], &[REPLACES], &inside]);
    }
    let length = u32::try_from(out.len() - 8).map_err(|_| NoAnimation::TooLarge)?;
    out[4..8].copy_from_slice(&length.to_le_bytes());
    Ok(out)
}

/// Writes a chunk whose contents are in parts, padded to an even length.
fn put(out: &mut Vec<u8>, kind: [u8; 4], parts: &[&[u8]]) {
    let length: usize = parts.iter().map(|part| part.len()).sum();
    out.extend(kind);
    out.extend((length as u32).to_le_bytes());
    parts.iter().for_each(|part| out.extend(*part));
    out.extend(&[0][..length % 2]);
}
