//! The finished tiles of a job on disk, so that none is rendered twice. Each is appended to one file when it is done. A tile that
//! a crash has left half-written at the end of the file is cut off.

use crate::service::pictures::tile_bytes::{Owner, Tile};
use crate::service::storage::disk::DiskFile;
use std::io::{self, BufReader};
use std::path::Path;
use strahl::film::Region;

/// The file of tiles.
#[derive(Debug)]
pub(super) struct Tiles {
    file: DiskFile,
    owner: Owner,
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
        let owner = Owner::of(job);
        let mut reader = BufReader::with_capacity(1 << 20, file.reader());
        let mut whole = 0;
        while let Some((tile, bytes)) = owner.read(&mut reader, size, &region)? {
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
    pub(super) fn add(&mut self, tile: &Tile) -> io::Result<()> {
        self.file.append(&self.owner.write(tile)?)
    }

    /// Gives the room of all tiles back.
    pub(super) fn clear(&mut self) -> io::Result<()> {
        self.file.truncate(0).map(drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use strahl::bound::BoundedPixel;
    use strahl::film::{Display, Film, ToneMapping};
    use strahl::render::{Picture, RayCounts, Refined};

    const SIZE: [u32; 2] = [6, 4];

    fn region(number: u32) -> Option<Region> {
        (number < 4).then_some(Region { x: 0, y: number, width: 6, height: 1 })
    }

    fn tile(number: u32) -> Tile {
        let black = crate::service::pictures::assembly::empty(SIZE, region(number).unwrap());
        let alpha = vec![0.25 * number as f32; if number == 2 { 6 } else { 0 }];
        let display = Display::new(f64::from(number) / 3.0, ToneMapping::Agx);
        let film = Film { pixels: vec![[0.1, 1e-30, number as f32]; 6], alpha, display, ..black.film.clone() };
        let rays = RayCounts { camera: 7 + u64::from(number), camera_hits: 5, deepest: 4, ..RayCounts::default() };
        let refined = Refined { pixels: 3, rays: RayCounts { shadow: 9, ..RayCounts::default() } };
        let bounded = [BoundedPixel { at: [5, number], highest: [0.2, 1e-29, f32::MAX], least_alpha: 0.125 }]
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
