//! The finished tiles of a job on disk, so that none is rendered twice. Each is appended to one file when it is done.
//!
//! A tile is written as its number, its cost as JSON, its pixels as linear floats, their alpha if the background is
//! transparent, the bounds of pixels that lack light, and a hash of all that and of whose tile it is. A tile that a crash has left half-written at the end of the file is cut off.

use crate::service::scenes::ids::renderer;
use crate::service::storage::disk::DiskFile;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::io::{self, BufReader, Read};
use std::path::Path;
use strahl::bound::BoundedPixel;
use strahl::film::{Display, Film, Region};
use strahl::render::{Picture, RayCounts, Refined, Sampling};

/// Bytes of the hash.
const DIGEST: usize = 16;
/// Bytes of the header: number of the tile, bytes of the JSON, number of pixels that lack light, number of alphas.
const HEAD: usize = 16;
/// Most bytes of the JSON.
const MOST: usize = 16_384;
/// Bytes of a pixel.
const PIXEL: usize = 12;
/// Bytes of an alpha.
const ALPHA: usize = 4;
/// Bytes of the bound of a pixel that lacks light: where it is, and its highest value.
const LACKING: usize = 20;

/// A finished tile.
#[derive(Debug)]
pub(super) struct Tile {
    /// Its number.
    pub(super) number: u32,
    /// Its pixels, and what they took.
    pub(super) picture: Picture,
}

/// Cost of a tile, and how its light becomes colours.
#[derive(Debug, Serialize, Deserialize)]
struct TileCost {
    rays: RayCounts,
    camera_hits: u64,
    deepest: u32,
    refined: Refined,
    sampling: Sampling,
    trace_ms: f64,
    refine_ms: f64,
    display: Display,
}

/// The file of tiles.
#[derive(Debug)]
pub(super) struct Tiles {
    file: DiskFile,
    /// Begins every hash: a tile of another job, or of another version of the renderer, is none of this picture.
    owner: String,
}

impl Tiles {
    /// Opens or makes the file for a job's picture of `size`, and calls `found` with each tile in it. `region` gives the region
    /// of a tile by its number, if there is such a tile.
    pub(super) fn open(
        path: &Path,
        job: &str,
        size: [u32; 2],
        region: impl Fn(u32) -> Option<Region>,
        mut found: impl FnMut(Tile),
    ) -> io::Result<Self> {
        let mut file = DiskFile::open(path)?;
        let owner = format!("{job} {}\n", renderer());
        let mut reader = BufReader::with_capacity(1 << 20, file.reader());
        let mut whole = 0;
        while let Some((tile, bytes)) = read(&mut reader, &owner, size, &region)? {
            found(tile);
            whole += bytes as u64;
        }
        drop(reader);
        let bytes = file.truncate(whole)?;
        if bytes > 0 {
            tracing::warn!(job, bytes, "the end of a job's tiles is damaged or incomplete and is rendered again");
        }
        Ok(Self { file, owner })
    }

    /// Appends a tile, which survives the process from then on.
    pub(super) fn add(&mut self, Tile { number, picture }: &Tile) -> io::Result<()> {
        let &Picture { ref film, ref bounded, ref sampling, rays, refined, trace_ms, refine_ms, .. } = picture;
        let took = serde_json::to_vec(&TileCost {
            rays,
            camera_hits: rays.camera_hits,
            deepest: rays.deepest,
            refined,
            sampling: sampling.clone(),
            trace_ms,
            refine_ms,
            display: film.display,
        })?;
        let mut bytes = Vec::with_capacity(
            HEAD + took.len() + film.pixels.len() * (PIXEL + ALPHA) + bounded.len() * LACKING + DIGEST,
        );
        bytes.extend(number.to_le_bytes());
        bytes.extend((took.len() as u32).to_le_bytes());
        bytes.extend((bounded.len() as u32).to_le_bytes());
        bytes.extend((film.alpha.len() as u32).to_le_bytes());
        bytes.extend(took);
        bytes.extend(film.pixels.as_flattened().iter().flat_map(|channel| channel.to_le_bytes()));
        bytes.extend(film.alpha.iter().flat_map(|alpha| alpha.to_le_bytes()));
        for BoundedPixel { at, highest } in bounded.iter() {
            bytes.extend(at.iter().flat_map(|coordinate| coordinate.to_le_bytes()));
            bytes.extend(highest.iter().flat_map(|channel| channel.to_le_bytes()));
        }
        let digest = hash(&self.owner, &bytes);
        bytes.extend(digest);
        self.file.append(&bytes)
    }
}

fn hash(owner: &str, tile: &[u8]) -> [u8; DIGEST] {
    let hash = Sha256::new().chain_update(owner).chain_update(tile).finalize();
    std::array::from_fn(|i| hash[i])
}

/// The next tile and its bytes in the file. None at the end of the intact tiles.
fn read(
    from: &mut impl Read,
    owner: &str,
    [full_width, full_height]: [u32; 2],
    region: &impl Fn(u32) -> Option<Region>,
) -> io::Result<Option<(Tile, usize)>> {
    let mut bytes = vec![0; HEAD];
    if !fill(from, &mut bytes)? {
        return Ok(None);
    }
    let [number, took, bounded, alpha] = words(&bytes)[..] else { return Ok(None) };
    let (took, bounded, alpha) = (took as usize, bounded as usize, alpha as usize);
    let Some(region) = region(number) else { return Ok(None) };
    let count = region.pixels() as usize;
    if took > MOST || bounded > count || (alpha != 0 && alpha != count) {
        return Ok(None);
    }
    bytes.resize(HEAD + took + count * PIXEL + alpha * ALPHA + bounded * LACKING + DIGEST, 0);
    if !fill(from, &mut bytes[HEAD..])? {
        return Ok(None);
    }
    let (contents, digest) = bytes.split_at(bytes.len() - DIGEST);
    if hash(owner, contents) != *digest {
        return Ok(None);
    }
    let (took, pixels) = contents[HEAD..].split_at(took);
    let (pixels, alpha_and_bounded) = pixels.split_at(count * PIXEL);
    let (alpha, bounded) = alpha_and_bounded.split_at(alpha * ALPHA);
    // Another version of the program may have written it.
    let Ok(TileCost { rays, camera_hits, deepest, refined, sampling, trace_ms, refine_ms, display }) =
        serde_json::from_slice(took)
    else {
        return Ok(None);
    };
    let color = |words: &[u32]| std::array::from_fn(|c| f32::from_bits(words[c]));
    let pixels = words(pixels).chunks_exact(3).map(color).collect();
    let alpha = words(alpha).into_iter().map(f32::from_bits).collect();
    let film = Film { region, full_width, full_height, pixels, alpha, display };
    let lack = |words: &[u32]| BoundedPixel { at: [words[0], words[1]], highest: color(&words[2..]) };
    let bounded = words(bounded).chunks_exact(5).map(lack).collect();
    let rays = RayCounts { camera_hits, deepest, ..rays };
    let picture = Picture { film, bounded, sampling, rays, refined, trace_ms, refine_ms, ..Picture::default() };
    Ok(Some((Tile { number, picture }, bytes.len())))
}

/// Bytes as numbers of 32 bits.
fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|bytes| bytes.try_into().map_or(0, u32::from_le_bytes)).collect()
}

/// Fills a buffer; false at the end of the file.
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
    use strahl::film::ToneMapping;

    const SIZE: [u32; 2] = [6, 4];

    fn region(number: u32) -> Option<Region> {
        (number < 4).then_some(Region { x: 0, y: number, width: 6, height: 1 })
    }

    fn tile(number: u32) -> Tile {
        let black = crate::service::jobs::canvas::empty(SIZE, region(number).unwrap());
        let alpha = vec![0.25 * number as f32; if number == 2 { 6 } else { 0 }];
        let display = Display::new(f64::from(number) / 3.0, ToneMapping::Agx);
        let film = Film { pixels: vec![[0.1, 1e-30, number as f32]; 6], alpha, display, ..black.film.clone() };
        let rays = RayCounts { camera: 7 + u64::from(number), camera_hits: 5, deepest: 4, ..RayCounts::default() };
        let refined = Refined { pixels: 3, rays: RayCounts { shadow: 9, ..RayCounts::default() } };
        let bounded = [BoundedPixel { at: [5, number], highest: [0.2, 1e-29, f32::MAX] }]
            .repeat(number as usize)
            .into_iter()
            .collect();
        Tile { number, picture: Picture { film, bounded, rays, refined, trace_ms: 0.1, refine_ms: 0.05, ..black } }
    }

    fn open(path: &Path) -> (Tiles, Vec<Tile>) {
        let mut found = Vec::new();
        let tiles = Tiles::open(path, "job", SIZE, region, |tile| found.push(tile)).unwrap();
        (tiles, found)
    }

    /// That these tiles were found, with all that is known of them.
    fn assert_found(found: &[Tile], numbers: &[u32]) {
        let all = |tiles: &[Tile]| format!("{tiles:?}");
        assert_eq!(all(found), all(&numbers.iter().map(|number| tile(*number)).collect::<Vec<_>>()));
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
        std::fs::File::options().write(true).open(&path).unwrap().set_len(whole + 20).unwrap();
        let (mut tiles, found) = open(&path);
        assert_found(&found, &[2, 0]);
        tiles.add(&tile(3)).unwrap();
        assert_found(&open(&path).1, &[2, 0, 3]);
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
        assert_found(&open(&path).1, &[0]);
    }
}
