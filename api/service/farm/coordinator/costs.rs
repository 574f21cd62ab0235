//! What tiles will cost, and how many of them make a piece: 0.2 to 2 seconds of one slot, less towards the end, so that no slot
//! works for long while the others have nothing left to do.

use crate::service::farm::names::Class;
use strahl::film::Region;

/// Longest piece, in milliseconds.
const LONGEST: f64 = 2_000.0;
/// Shortest piece of a job, and of what somebody waits for.
const SHORTEST: f64 = 200.0;
const SHORTEST_HI: f64 = 50.0;
/// Pieces for each slot that what is left is cut into.
const FOR_EACH_SLOT: f64 = 4.0;
/// Pixels of a piece: their results wait in memory.
const MOST_PIXELS: u64 = 1 << 20;
/// Weight of a finished tile in the estimate. Neighbours come one after the other, and cost about the same.
const WEIGHT: f64 = 0.1;
/// Weight of the estimate made before the first tile, in tiles.
const TRUST: f64 = 8.0;
/// Pieces of which is known how long they took.
const REMEMBERED: usize = 256;

/// What is known of costs.
#[derive(Debug)]
pub(super) struct Costs {
    /// Milliseconds of a pixel on one slot, of tiles finished lately.
    pixel_ms: f64,
    tiles: f64,
    /// Times of pieces divided by those predicted.
    ratios: Vec<f64>,
    next: usize,
}

impl Costs {
    /// An estimate for a pixel.
    pub(super) fn new(pixel_ms: f64) -> Self {
        Self { pixel_ms: pixel_ms.max(1e-9), tiles: 0.0, ratios: Vec::new(), next: 0 }
    }

    /// Milliseconds of some pixels.
    pub(super) fn of(&self, pixels: u64) -> f64 {
        self.pixel_ms * pixels as f64
    }

    /// A tile has taken some milliseconds.
    pub(super) fn learn(&mut self, region: Region, ms: f64) {
        self.tiles += 1.0;
        let weight = WEIGHT.max(1.0 / (TRUST + self.tiles));
        let pixel_ms = ms.max(1e-6) / region.pixels().max(1) as f64;
        self.pixel_ms += weight * (pixel_ms - self.pixel_ms);
    }

    /// A piece for which some milliseconds were predicted has taken others.
    pub(super) fn piece_took(&mut self, predicted: f64, took: f64) {
        let ratio = took / predicted.max(1.0);
        if self.ratios.len() < REMEMBERED {
            self.ratios.push(ratio);
        } else {
            self.ratios[self.next % REMEMBERED] = ratio;
        }
        self.next += 1;
    }

    /// How long 95 of 100 pieces take at most, divided by what was predicted; none before a few are done.
    pub(super) fn slow_ratio(&self) -> Option<f64> {
        let mut sorted = self.ratios.clone();
        sorted.sort_by(f64::total_cmp);
        (sorted.len() >= 4).then(|| sorted[(sorted.len() * 95 / 100).min(sorted.len() - 1)].max(1.0))
    }

    /// Milliseconds of the next piece, if so many pixels are left for so many slots.
    pub(super) fn target(&self, class: Class, left: u64, slots: u32) -> f64 {
        let shortest = if class == Class::Hi { SHORTEST_HI } else { SHORTEST };
        (self.of(left) / (FOR_EACH_SLOT * f64::from(slots.max(1)))).clamp(shortest, LONGEST)
    }

    /// Takes tiles for a piece of some milliseconds, at least one if there is one.
    pub(super) fn cut(&self, target: f64, mut next: impl FnMut() -> Option<(u32, Region)>) -> Vec<(u32, Region)> {
        let (mut tiles, mut pixels) = (Vec::new(), 0);
        while let Some((number, region)) = next() {
            pixels += region.pixels();
            tiles.push((number, region));
            // One more of the same size would be more than half a tile too much.
            let more = pixels + region.pixels() / 2;
            if self.of(more) > target || more > MOST_PIXELS {
                break;
            }
        }
        tiles
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tiles(count: u32) -> impl FnMut() -> Option<(u32, Region)> {
        let mut numbers = 0..count;
        move || numbers.next().map(|number| (number, Region { x: 64 * number, y: 0, width: 64, height: 64 }))
    }

    #[test]
    fn pieces_take_what_they_should() {
        // 41 ms for a tile.
        let costs = Costs::new(0.01);
        let of = |target| costs.cut(target, tiles(100)).len();
        assert_eq!([of(2_000.0), of(200.0), of(1.0)], [49, 5, 1]);
        assert_eq!(costs.cut(2_000.0, tiles(3)).len(), 3);
        assert_eq!(costs.cut(2_000.0, tiles(0)).len(), 0);
        // However cheap: a million pixels.
        assert_eq!(Costs::new(1e-9).cut(2_000.0, tiles(1_000)).len(), 256);
    }

    #[test]
    fn pieces_are_long_at_first_and_short_at_the_end() {
        let costs = Costs::new(0.01);
        let of = |left| costs.target(Class::Norm, left, 10);
        assert_eq!([of(100_000_000), of(2_000_000), of(10_000)], [2_000.0, 500.0, 200.0]);
        assert_eq!(costs.target(Class::Hi, 400_000, 4), 250.0);
    }

    #[test]
    fn what_was_measured_replaces_what_was_estimated() {
        let mut costs = Costs::new(1.0);
        let region = Region { x: 0, y: 0, width: 10, height: 10 };
        costs.learn(region, 10.0);
        assert!(costs.pixel_ms > 0.85, "one tile says little");
        (0..100).for_each(|_| costs.learn(region, 10.0));
        assert!((0.09..0.11).contains(&costs.pixel_ms), "{}", costs.pixel_ms);
    }

    #[test]
    fn slow_pieces_are_known_after_some() {
        let mut costs = Costs::new(1.0);
        (0..3).for_each(|_| costs.piece_took(100.0, 150.0));
        assert_eq!(costs.slow_ratio(), None);
        (0..17).for_each(|_| costs.piece_took(100.0, 150.0));
        costs.piece_took(100.0, 900.0);
        assert_eq!(costs.slow_ratio(), Some(1.5));
    }
}
