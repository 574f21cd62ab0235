//! Where a pilot samples the picture: the region is cut into cells, each with one block of pixels at a random place.

use crate::film::Region;
use crate::render::BLOCK;

/// The cells of a region, one block in each.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cells {
    region: Region,
    /// Blocks across and down the region.
    pub(super) blocks: [u32; 2],
    /// Cells across and down.
    cells: [u32; 2],
}

impl Cells {
    /// About `wanted` cells, but no more than there are blocks.
    pub(super) fn new(region: Region, wanted: f64) -> Self {
        let blocks = [region.width.div_ceil(BLOCK), region.height.div_ceil(BLOCK)];
        let across = (wanted * f64::from(blocks[0]) / f64::from(blocks[1])).sqrt().round();
        let columns = (across as u32).clamp(1, blocks[0]);
        let rows = ((wanted / f64::from(columns)).round() as u32).clamp(1, blocks[1]);
        Self { region, blocks, cells: [columns, rows] }
    }

    pub(super) fn count(&self) -> u32 {
        self.cells[0] * self.cells[1]
    }

    /// The k-th cell to visit. Steps are near the golden section of the count, so that any run of them is spread evenly.
    pub(super) fn visited(&self, k: u32) -> u32 {
        let count = self.count();
        let golden = (f64::from(count) * 0.618_033_988_749_894_9) as u32;
        let common = |mut a: u32, mut b: u32| {
            while b != 0 {
                (a, b) = (b, a % b);
            }
            a
        };
        let step = (golden.max(1)..).find(|step| common(*step, count) == 1).unwrap_or(1);
        ((u64::from(k) * u64::from(step)) % u64::from(count)) as u32
    }

    /// The block of a cell. Cells are counted along rows, back and forth.
    pub(super) fn block(&self, cell: u32) -> Region {
        let [columns, rows] = self.cells;
        let row = cell / columns;
        let along = cell % columns;
        let column = if row.is_multiple_of(2) { along } else { columns - 1 - along };
        let hash = cell.wrapping_mul(0x9e37_79b9).rotate_left(15).wrapping_mul(0x85eb_ca6b);
        let inside = |index: u32, cells: u32, blocks: u32, random: u32| {
            let [first, end] = [index, index + 1].map(|i| (u64::from(i) * u64::from(blocks) / u64::from(cells)) as u32);
            first + random % (end - first)
        };
        let x = inside(column, columns, self.blocks[0], hash >> 16) * BLOCK;
        let y = inside(row, rows, self.blocks[1], hash & 0xffff) * BLOCK;
        if self.cells == self.blocks {
            // Each pixel once.
            return Region {
                x: self.region.x + x,
                y: self.region.y + y,
                width: BLOCK.min(self.region.width - x),
                height: BLOCK.min(self.region.height - y),
            };
        }
        // Blocks at the end of a row or a column are whole if the region is large enough.
        let from = |at: u32, length: u32| at.min(length.saturating_sub(BLOCK));
        Region {
            x: self.region.x + from(x, self.region.width),
            y: self.region.y + from(y, self.region.height),
            width: BLOCK.min(self.region.width),
            height: BLOCK.min(self.region.height),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_is_visited_once_and_gives_a_block_of_the_region() {
        for (width, height) in [(1, 1), (3, 200), (960, 540), (240, 135), (4_000, 3)] {
            let region = Region { x: 5, y: 7, width, height };
            let cells = Cells::new(region, 1_024.0);
            let mut visited: Vec<u32> = (0..cells.count()).map(|k| cells.visited(k)).collect();
            let mut blocks: Vec<(u32, u32)> = visited
                .iter()
                .map(|cell| cells.block(*cell))
                .inspect(|b| {
                    assert!(b.x >= 5 && b.y >= 7 && b.x + b.width <= 5 + width && b.y + b.height <= 7 + height)
                })
                .map(|b| (b.x, b.y))
                .collect();
            visited.sort_unstable();
            assert!(visited.iter().copied().eq(0..cells.count()), "{width} x {height}");
            blocks.sort_unstable();
            blocks.dedup();
            assert_eq!(blocks.len() as u32, cells.count(), "{width} x {height}");
        }
    }
}
