//! A finished tile as bytes: in the file of a job's tiles, and on its way from the node that has rendered it.
//!
//! A tile is written as its number, its cost as JSON, its pixels as linear floats, their alpha if the background is
//! transparent, the bounds of pixels that lack light, and a hash of all that and of whose tile it is.

use crate::service::scenes::ids::renderer;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::io::{self, Read};
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
/// Bytes of the bound of a pixel that lacks light: where it is, its highest value, and its least alpha.
const LACKING: usize = 24;

/// A finished tile.
#[derive(Debug)]
pub(crate) struct Tile {
    /// Its number.
    pub(crate) number: u32,
    /// Its pixels, and what they took.
    pub(crate) picture: Picture,
}

/// Cost of a tile, and how its light becomes colors.
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

/// Whose tiles: it begins every hash, so that a tile of another job, or of another version of the renderer, is none of this
/// picture.
#[derive(Debug, Clone)]
pub(crate) struct Owner(String);

impl Owner {
    /// A job, with this version of the renderer.
    pub(crate) fn of(job: &str) -> Self {
        Self(format!("{job} {}\n", renderer()))
    }

    fn hash(&self, tile: &[u8]) -> [u8; DIGEST] {
        let hash = Sha256::new().chain_update(&self.0).chain_update(tile).finalize();
        std::array::from_fn(|i| hash[i])
    }

    /// A tile as bytes.
    pub(crate) fn write(&self, Tile { number, picture }: &Tile) -> io::Result<Vec<u8>> {
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
        for BoundedPixel { at, highest, least_alpha } in bounded.iter() {
            bytes.extend(at.iter().flat_map(|coordinate| coordinate.to_le_bytes()));
            bytes.extend(highest.iter().chain([least_alpha]).flat_map(|channel| channel.to_le_bytes()));
        }
        let digest = self.hash(&bytes);
        bytes.extend(digest);
        Ok(bytes)
    }

    /// The next tile of a picture of some size, and its bytes. None at the end of the intact tiles. `region` gives the region of a
    /// tile by its number, if there is such a tile.
    pub(crate) fn read(
        &self,
        from: &mut impl Read,
        [full_width, full_height]: [u32; 2],
        region: impl Fn(u32) -> Option<Region>,
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
        if self.hash(contents) != *digest {
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
        let lack = |words: &[u32]| BoundedPixel {
            at: [words[0], words[1]],
            highest: color(&words[2..]),
            least_alpha: f32::from_bits(words[5]),
        };
        let bounded = words(bounded).chunks_exact(6).map(lack).collect();
        let rays = RayCounts { camera_hits, deepest, ..rays };
        let picture = Picture { film, bounded, sampling, rays, refined, trace_ms, refine_ms, ..Picture::default() };
        Ok(Some((Tile { number, picture }, bytes.len())))
    }
}

/// Whether two tiles show the same. What they took differs from node to node.
pub(crate) fn show_the_same(one: &[u8], other: &[u8]) -> bool {
    fn shown(tile: &[u8]) -> Option<&[u8]> {
        let took = words(tile.get(4..8)?)[0] as usize;
        tile.get(HEAD + took..tile.len().checked_sub(DIGEST)?)
    }
    shown(one).is_some_and(|one| Some(one) == shown(other))
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

    fn tile(trace_ms: f64, light: f32) -> Vec<u8> {
        let region = Region { x: 2, y: 1, width: 3, height: 1 };
        let film = Film { region, full_width: 6, full_height: 4, pixels: vec![[light; 3]; 3], ..Film::default() };
        let picture = Picture { film, trace_ms, ..Picture::default() };
        Owner::of("job").write(&Tile { number: 5, picture }).unwrap()
    }

    #[test]
    fn a_tile_of_another_job_is_none() {
        let region = |number| (number == 5).then_some(Region { x: 2, y: 1, width: 3, height: 1 });
        let read = |owner: &str, bytes: &[u8]| Owner::of(owner).read(&mut &*bytes, [6, 4], region).unwrap();
        let bytes = tile(0.5, 0.25);
        let (found, length) = read("job", &bytes).unwrap();
        assert_eq!((found.number, found.picture.film.pixels[2], length), (5, [0.25; 3], bytes.len()));
        assert!(read("other", &bytes).is_none() && read("job", &bytes[..bytes.len() - 1]).is_none());
    }

    #[test]
    fn time_does_not_count_when_tiles_are_compared() {
        assert!(show_the_same(&tile(0.5, 0.25), &tile(1234.5, 0.25)));
        assert!(!show_the_same(&tile(0.5, 0.25), &tile(0.5, 0.250_000_03)));
        assert!(!show_the_same(&tile(0.5, 0.25), b"") && !show_the_same(b"", b""));
    }
}
