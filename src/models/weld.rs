//! Points that were meant to be one: programs compute both ends of a seam, and get nearly the same place twice.

use super::geometry::Geometry;
use crate::control;
use glam::DVec3;
use hashbrown::HashMap;
use smallvec::SmallVec;

/// How far apart such points are at most along each axis, as a part of the largest extent.
const NEAR: f64 = 1e-6;
/// Cells are so many times as wide, so that most points have to look into one.
const CELL: f64 = 4.0;

impl Geometry {
    /// The points, each at the place of the first one that is near.
    pub(crate) fn welded(&self) -> Vec<[f64; 3]> {
        let points = self.positions.iter().copied().map(DVec3::from_array);
        let low = points.clone().fold(DVec3::INFINITY, DVec3::min);
        let high = points.clone().fold(DVec3::NEG_INFINITY, DVec3::max);
        let near = (high - low).max_element() * NEAR;
        if near.is_nan() || near <= 0.0 {
            return self.positions.clone();
        }
        // Points of a cell are no nearer to each other than that, so it has at most 5^3 of them.
        let mut cells: HashMap<[i32; 3], SmallVec<[DVec3; 1]>> = HashMap::new();
        let place_of = |point: DVec3| {
            if control::step(1) {
                return point.to_array();
            }
            let at = (point - low) / (near * CELL);
            let inside = at - at.floor();
            let own = at.floor().to_array().map(|x| x as i32);
            // The cell beside, along each axis on which its border is near.
            let beside = inside.to_array().map(|x| match x * CELL {
                x if x < 1.0 => -1,
                x if x > CELL - 1.0 => 1,
                _ => 0,
            });
            for corner in 0..8 {
                let steps: [i32; 3] =
                    std::array::from_fn(|axis| if corner >> axis & 1 == 1 { beside[axis] } else { 0 });
                // Where no border is near, that cell has been looked into.
                if (0..3).any(|axis| corner >> axis & 1 == 1 && beside[axis] == 0) {
                    continue;
                }
                let cell: [i32; 3] = std::array::from_fn(|axis| own[axis] + steps[axis]);
                let is_near = |known: &&DVec3| (**known - point).abs().max_element() <= near;
                if let Some(known) = cells.get(&cell).and_then(|known| known.iter().find(is_near)) {
                    return known.to_array();
                }
            }
            cells.entry(own).or_default().push(point);
            point.to_array()
        };
        points.map(place_of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_nearly_one_place_becomes_one() {
        let positions = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.5, 0.25],
            [-2.4e-16, 0.0, 0.0],
            [1.0, 0.5 - 9e-7, 0.25 + 9e-7],
            [1.0, 0.5 - 3e-6, 0.25],
            [0.0, 0.0, 0.0],
        ];
        let welded = Geometry { positions: positions.clone(), ..Geometry::default() }.welded();
        assert_eq!(welded, [positions[0], positions[1], positions[0], positions[1], positions[4], positions[0]]);
        // Wherever borders of cells lie.
        for step in 0..200 {
            let x = 0.3 + f64::from(step) * 1e-7;
            let positions = vec![[0.0; 3], [1.0; 3], [x; 3], [x + 9e-7, x - 9e-7, x]];
            let welded = Geometry { positions, ..Geometry::default() }.welded();
            assert_eq!(welded[3], [x; 3], "{step}");
        }
    }

    #[test]
    fn points_at_one_place_and_none_stay() {
        for positions in [vec![], vec![[3.0; 3]; 4]] {
            assert_eq!(Geometry { positions: positions.clone(), ..Geometry::default() }.welded(), positions);
        }
    }
}
