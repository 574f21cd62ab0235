//! The finished tiles of a job on disk, so that none is rendered twice: one file, to which each is added when it is done.
//!
//! A tile is its number, its rays, its pixels as linear floats, and a hash of all that. What a kill has left half-written
//! at the end is cut off.

use sha2::{Digest, Sha256};
use std::fs::{File, OpenOptions};
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

/// Bytes of the hash.
const DIGEST: usize = 16;
/// Bytes before the pixels: number and rays.
const HEAD: usize = 12;
/// Bytes of a pixel.
const PIXEL: usize = 12;

/// A finished tile.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tile {
    /// Which one.
    pub(super) number: u32,
    /// Rays it took.
    pub(super) rays: u64,
    /// Its pixels, row by row.
    pub(super) pixels: Vec<[f32; 3]>,
}

/// The file.
#[derive(Debug)]
pub(super) struct Tiles(File);

impl Tiles {
    /// Opens the file, or makes it, and hands over what is there; `pixels` says how many a tile has, none that there is no
    /// such tile.
    pub(super) fn open(
        path: &Path,
        pixels: impl Fn(u32) -> Option<usize>,
        mut found: impl FnMut(Tile),
    ) -> io::Result<Self> {
        let file = OpenOptions::new().read(true).append(true).create(true).open(path)?;
        let mut reader = BufReader::with_capacity(1 << 20, &file);
        let mut whole = 0;
        while let Some((tile, bytes)) = read(&mut reader, &pixels)? {
            found(tile);
            whole += bytes as u64;
        }
        drop(reader);
        file.set_len(whole)?;
        Ok(Self(file))
    }

    /// Adds a tile; it outlives the process from then on.
    pub(super) fn add(&mut self, tile: &Tile) -> io::Result<()> {
        let mut bytes = Vec::with_capacity(HEAD + tile.pixels.len() * PIXEL + DIGEST);
        bytes.extend(tile.number.to_le_bytes());
        bytes.extend(tile.rays.to_le_bytes());
        for channel in tile.pixels.as_flattened() {
            bytes.extend(channel.to_le_bytes());
        }
        let digest = Sha256::digest(&bytes);
        bytes.extend(&digest[..DIGEST]);
        self.0.write_all(&bytes)
    }
}

/// The next tile and its bytes in the file; none at the end of what is whole.
fn read(from: &mut impl Read, pixels: &impl Fn(u32) -> Option<usize>) -> io::Result<Option<(Tile, usize)>> {
    let mut bytes = vec![0; HEAD];
    if !fill(from, &mut bytes)? {
        return Ok(None);
    }
    let (number, rays) = bytes.split_at(4);
    let number = u32::from_le_bytes(number.try_into().unwrap_or_default());
    let rays = u64::from_le_bytes(rays.try_into().unwrap_or_default());
    let Some(count) = pixels(number) else { return Ok(None) };
    bytes.resize(HEAD + count * PIXEL + DIGEST, 0);
    if !fill(from, &mut bytes[HEAD..])? {
        return Ok(None);
    }
    let (contents, digest) = bytes.split_at(bytes.len() - DIGEST);
    if Sha256::digest(contents)[..DIGEST] != *digest {
        return Ok(None);
    }
    let channel = |at: usize| contents[at..at + 4].try_into().map_or(0.0, f32::from_le_bytes);
    let pixel = |i: usize| std::array::from_fn(|c| channel(HEAD + i * PIXEL + c * 4));
    Ok(Some((Tile { number, rays, pixels: (0..count).map(pixel).collect() }, bytes.len())))
}

/// Whether there was enough to fill it.
fn fill(from: &mut impl Read, into: &mut [u8]) -> io::Result<bool> {
    match from.read_exact(into) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(number: u32) -> Tile {
        Tile { number, rays: 7 + u64::from(number), pixels: vec![[0.1, 1e-30, number as f32]; 6] }
    }

    fn open(path: &Path) -> (Tiles, Vec<Tile>) {
        let mut found = Vec::new();
        let tiles = Tiles::open(path, |number| (number < 4).then_some(6), |tile| found.push(tile)).unwrap();
        (tiles, found)
    }

    #[test]
    fn whole_tiles_are_found_again_and_half_ones_are_cut_off() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tiles");
        let (mut tiles, found) = open(&path);
        assert!(found.is_empty());
        for number in [2, 0] {
            tiles.add(&tile(number)).unwrap();
        }
        let whole = std::fs::metadata(&path).unwrap().len();
        tiles.add(&tile(1)).unwrap();
        drop(tiles);
        File::options().write(true).open(&path).unwrap().set_len(whole + 20).unwrap();
        let (mut tiles, found) = open(&path);
        assert_eq!(found, [tile(2), tile(0)]);
        tiles.add(&tile(3)).unwrap();
        assert_eq!(open(&path).1, [tile(2), tile(0), tile(3)]);
    }

    #[test]
    fn spoilt_tiles_end_what_is_believed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tiles");
        let (mut tiles, _) = open(&path);
        for number in 0..3 {
            tiles.add(&tile(number)).unwrap();
        }
        let mut bytes = std::fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(open(&path).1, [tile(0)]);
    }
}
