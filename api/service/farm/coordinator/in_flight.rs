//! Pieces that are at the broker or on nodes, and the tiles that are missing of each.

use crate::service::farm::work::TilePlace;
use std::collections::{BTreeMap, HashMap};
use std::time::Instant;

/// The pieces, by number.
#[derive(Debug, Default)]
pub(super) struct InFlight {
    pub(super) pieces: BTreeMap<u64, InFlightPiece>,
    /// Missing tiles, and the pieces that they are in.
    holders: HashMap<u32, Vec<u64>>,
    /// Pixels of the missing tiles.
    pub(super) pixels: u64,
    count: u64,
}

/// A piece.
#[derive(Debug)]
pub(super) struct InFlightPiece {
    /// Tiles that are missing, in the order in which they are rendered.
    pub(super) tiles: Vec<TilePlace>,
    /// Milliseconds that were predicted for all of it.
    pub(super) predicted_ms: f64,
    /// The number of its message in the queue, once the broker has it.
    pub(super) sequence: Option<u64>,
    /// When a node began with it, last.
    pub(super) begun: Option<Instant>,
    /// The missing tile that nodes have begun with lately, and how often.
    pub(super) tried: (Option<u32>, i64),
    /// When it was made, or something was heard of it.
    pub(super) heard: Instant,
    /// When it was looked after.
    pub(super) looked: Instant,
    /// Whether its tiles were given to other nodes, too.
    pub(super) is_doubled: bool,
}

impl InFlight {
    /// A new piece; its number.
    pub(super) fn add(&mut self, tiles: Vec<TilePlace>, predicted_ms: f64) -> u64 {
        self.count += 1;
        let (number, now) = (self.count, Instant::now());
        for tile in &tiles {
            let holders = self.holders.entry(tile.0).or_default();
            self.pixels += if holders.is_empty() { tile.region().pixels() } else { 0 };
            holders.push(number);
        }
        let piece = InFlightPiece {
            tiles,
            predicted_ms,
            sequence: None,
            begun: None,
            tried: (None, 0),
            heard: now,
            looked: now,
            is_doubled: false,
        };
        self.pieces.insert(number, piece);
        number
    }

    /// Where a missing tile is.
    pub(super) fn place(&self, tile: u32) -> Option<TilePlace> {
        let piece = self.pieces.get(self.holders.get(&tile)?.first()?)?;
        piece.tiles.iter().find(|place| place.0 == tile).copied()
    }

    /// A tile is there. Pieces that lack none any more are returned.
    pub(super) fn finish(&mut self, tile: u32) -> Vec<InFlightPiece> {
        let mut done = Vec::new();
        self.pixels -= self.place(tile).map_or(0, |place| place.region().pixels());
        for number in self.holders.remove(&tile).unwrap_or_default() {
            let Some(piece) = self.pieces.get_mut(&number) else { continue };
            piece.tiles.retain(|place| place.0 != tile);
            piece.heard = Instant::now();
            if piece.tiles.is_empty() {
                done.extend(self.pieces.remove(&number));
            }
        }
        done
    }

    /// Forgets a piece, whose tiles are then in no other than those they are in besides; its tiles.
    pub(super) fn forget(&mut self, number: u64) -> Vec<TilePlace> {
        let Some(piece) = self.pieces.remove(&number) else { return Vec::new() };
        let mut orphans = Vec::new();
        for tile in piece.tiles {
            let holders = self.holders.entry(tile.0).or_default();
            holders.retain(|holder| *holder != number);
            if holders.is_empty() {
                self.holders.remove(&tile.0);
                self.pixels -= tile.region().pixels();
                orphans.push(tile);
            }
        }
        orphans
    }

    /// The piece whose message has a number in the queue.
    pub(super) fn of_sequence(&self, sequence: u64) -> Option<u64> {
        self.pieces.iter().find(|(_, piece)| piece.sequence == Some(sequence)).map(|(number, _)| *number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use strahl::film::Region;

    fn tiles(numbers: &[u32]) -> Vec<TilePlace> {
        let region = |number| Region { x: 8 * number, y: 0, width: 8, height: 8 };
        numbers.iter().map(|number| TilePlace::new(*number, region(*number))).collect()
    }

    #[test]
    fn a_tile_that_two_pieces_have_is_done_once_for_both() {
        let mut in_flight = InFlight::default();
        let first = in_flight.add(tiles(&[1, 2]), 10.0);
        let second = in_flight.add(tiles(&[2]), 5.0);
        assert_ne!(first, second);
        assert_eq!(in_flight.place(2).map(|place| place.0), Some(2));
        assert_eq!(in_flight.finish(2).len(), 1, "the second piece is done");
        assert_eq!((in_flight.pieces.len(), in_flight.pixels), (1, 64));
        assert!(in_flight.finish(2).is_empty() && in_flight.place(2).is_none(), "it comes again");
        assert_eq!(in_flight.finish(1).len(), 1);
        assert!(in_flight.pieces.is_empty() && in_flight.holders.is_empty() && in_flight.pixels == 0);
    }

    #[test]
    fn only_tiles_that_nobody_else_has_are_published_again() {
        let mut in_flight = InFlight::default();
        let first = in_flight.add(tiles(&[1, 2, 3]), 10.0);
        in_flight.add(tiles(&[2]), 5.0);
        assert_eq!(in_flight.forget(first), [tiles(&[1]), tiles(&[3])].concat());
        assert_eq!(in_flight.place(2).map(|place| place.0), Some(2));
        assert!(in_flight.forget(first).is_empty());
        assert_eq!(in_flight.pixels, 64);
    }
}
