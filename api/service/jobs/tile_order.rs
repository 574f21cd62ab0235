//! The order of tiles: first those in regions that clients ask for, the latest region first, then from the centre outwards.

use strahl::film::Region;

/// Regions that are remembered.
pub(super) const REMEMBERED: usize = 64;

/// The tiles that have not been started.
#[derive(Debug)]
pub(super) struct TileOrder {
    /// All tiles by number.
    regions: Vec<Region>,
    /// Numbers of the tiles left, the farthest from the centre first.
    left: Vec<usize>,
    /// Their pixels.
    pixels_left: u64,
    /// Regions that clients ask for, the latest last.
    looks: Vec<Region>,
}

impl TileOrder {
    /// All tiles of a picture that are not done yet.
    pub(super) fn new(regions: Vec<Region>, picture: Region, is_done: impl Fn(usize) -> bool) -> Self {
        let mut left: Vec<usize> = (0..regions.len()).filter(|number| !is_done(*number)).collect();
        left.sort_by_key(|number| std::cmp::Reverse((distance(regions[*number], picture), *number)));
        let pixels_left = left.iter().map(|number| regions[*number].pixels()).sum();
        Self { regions, left, pixels_left, looks: Vec::new() }
    }

    /// A client asks for a region.
    pub(super) fn look(&mut self, region: Region) {
        self.looks.retain(|look| *look != region);
        if self.looks.len() == REMEMBERED {
            self.looks.remove(0);
        }
        self.looks.push(region);
    }

    /// Whether a client waits for a tile that has not been started.
    pub(super) fn is_looked_at(&self) -> bool {
        self.looks.iter().any(|look| self.left.iter().any(|number| overlap(self.regions[*number], *look)))
    }

    /// Pixels of the tiles that are left.
    pub(super) fn pixels_left(&self) -> u64 {
        self.pixels_left
    }

    /// Takes the next tile.
    pub(super) fn next(&mut self) -> Option<(usize, Region)> {
        let number = self.looked_at().or_else(|| self.left.pop())?;
        self.pixels_left -= self.regions[number].pixels();
        Some((number, self.regions[number]))
    }

    fn looked_at(&mut self) -> Option<usize> {
        while let Some(look) = self.looks.last().copied() {
            let seen = |number: &usize| overlap(self.regions[*number], look);
            let nearest = (0..self.left.len())
                .filter(|at| seen(&self.left[*at]))
                .min_by_key(|at| distance(self.regions[self.left[*at]], look));
            match nearest {
                Some(at) => return Some(self.left.remove(at)),
                None => self.looks.pop(),
            };
        }
        None
    }
}

/// Whether two regions overlap.
pub(super) fn overlap(a: Region, b: Region) -> bool {
    let sides = |a: u32, a_length: u32, b: u32, b_length: u32| a < b + b_length && b < a + a_length;
    sides(a.x, a.width, b.x, b.width) && sides(a.y, a.height, b.y, b.height)
}

/// Squared distance of the centres, in quarters of pixels.
fn distance(a: Region, b: Region) -> u64 {
    let apart = |a: u32, a_length: u32, b: u32, b_length: u32| {
        (u64::from(2 * a + a_length)).abs_diff(u64::from(2 * b + b_length)).pow(2)
    };
    apart(a.x, a.width, b.x, b.width) + apart(a.y, a.height, b.y, b.height)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(done: &[usize]) -> TileOrder {
        let picture = Region::whole(50, 50);
        TileOrder::new(picture.tiles(10).collect(), picture, |number| done.contains(&number))
    }

    #[test]
    fn from_the_centre_outwards_and_none_twice() {
        let mut order = order(&[7]);
        let all: Vec<usize> = std::iter::from_fn(|| order.next()).map(|(number, _)| number).collect();
        assert_eq!((all[0], all.len()), (12, 24));
        assert!([11, 13, 17].iter().all(|near| all[1..4].contains(near)), "{all:?}");
        assert!([0, 4, 20, 24].iter().all(|corner| all[20..].contains(corner)), "{all:?}");
    }

    #[test]
    fn who_looks_is_served_first_the_latest_before_all() {
        let mut order = order(&[]);
        order.look(Region { x: 0, y: 0, width: 15, height: 5 });
        order.look(Region { x: 45, y: 45, width: 5, height: 5 });
        let first: Vec<usize> = (0..4).filter_map(|_| order.next()).map(|(number, _)| number).collect();
        assert_eq!(first[0], 24);
        assert!(first[1..3].contains(&0) && first[1..3].contains(&1) && first[3] == 12, "{first:?}");
    }
}
