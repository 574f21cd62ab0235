//! Tiles of a picture, and the order of their pixels.

use crate::film::Region;
use rayon::prelude::*;

/// A tile and its rows in the picture, or none where nothing is kept of its pixels.
pub(super) struct Tile<'a, T> {
    region: Region,
    rows: Vec<&'a mut [T]>,
}

/// Edge of the block of pixels that share a packet, so that its rays are coherent: 4 x 4 are 16 lanes.
pub(crate) const BLOCK: u32 = 4;

impl<T: Copy> Tile<'_, T> {
    /// Its pixels, block by block.
    pub(super) fn blocks(&self) -> Vec<[u32; 2]> {
        let mut at = Vec::with_capacity(self.region.pixels() as usize);
        for block in self.region.tiles(BLOCK) {
            for y in block.y..block.y + block.height {
                at.extend((block.x..block.x + block.width).map(|x| [x, y]));
            }
        }
        at
    }

    /// Stores pixels that are in the order of [`Self::blocks`].
    pub(super) fn put(&mut self, mut pixels: &[T]) {
        for block in self.region.tiles(BLOCK) {
            let (left, top) = ((block.x - self.region.x) as usize, (block.y - self.region.y) as usize);
            for row in self.rows.iter_mut().skip(top).take(block.height as usize) {
                let (part, rest) = pixels.split_at(block.width as usize);
                row[left..left + part.len()].copy_from_slice(part);
                pixels = rest;
            }
        }
    }
}

/// Edge of the tiles of a region: one asked for, or a smaller one, so that each of some threads has a few. Tiles of a job may be as
/// small as one of these, where pixels are dear.
pub(super) fn edge_of_tiles(region: Region, edge: u32, threads: usize) -> u32 {
    let wanted = if threads > 1 { 4 * threads as u64 } else { 1 };
    let count = |edge: u32| u64::from(region.width.div_ceil(edge)) * u64::from(region.height.div_ceil(edge));
    let halves = std::iter::successors(Some(edge), |edge| Some(edge / 2)).take_while(|edge| *edge > BLOCK);
    halves.clone().find(|edge| count(*edge) >= wanted).or(halves.last()).unwrap_or(edge)
}

/// Cuts what is kept of the pixels of a region into tiles.
pub(super) fn split<T>(region: Region, edge: u32, pixels: &mut [T]) -> Vec<Tile<'_, T>> {
    let mut tiles: Vec<Tile<'_, T>> = region.tiles(edge).map(|region| Tile { region, rows: Vec::new() }).collect();
    let across = region.width.div_ceil(edge) as usize;
    for (y, row) in pixels.chunks_mut(region.width as usize).enumerate() {
        let first = y / edge as usize * across;
        for (tile, part) in tiles[first..first + across].iter_mut().zip(row.chunks_mut(edge as usize)) {
            tile.rows.push(part);
        }
    }
    tiles
}

/// Edge of the tiles of [`near`].
const NEAR: u32 = 16;

/// The wanted pixels of a region, tile by tile and block by block, so that those of a packet are near each other.
pub(super) fn near(region: Region, wanted: impl Fn([u32; 2]) -> bool + Sync) -> Vec<[u32; 2]> {
    near_with(region, |at| wanted(at).then_some(at))
}

/// What there is of the pixels of a region, in the same order.
pub(super) fn near_with<T: Send>(region: Region, of: impl Fn([u32; 2]) -> Option<T> + Sync) -> Vec<T> {
    let tiles: Vec<Region> = region.tiles(NEAR).collect();
    let of_tile = |tile: &Region| -> Vec<T> { tile.tiles(BLOCK).flat_map(Region::iter).filter_map(&of).collect() };
    tiles.par_iter().flat_map_iter(of_tile).collect()
}
