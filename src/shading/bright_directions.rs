//! Directions of an environment map, chosen in proportion to its light: a row of a grid, then a cell of it, then a point of the cell
//! (Pharr, Jakob and Humphreys, Physically Based Rendering, 12.5). The cells of a row have the same solid angle.

use super::texture::environment::Environment;
use crate::lanes::{V3, angle};
use crate::math;
use std::f64::consts::PI;

/// Largest grid. Lights that are smaller than its cells are met less often, but still far more often than by chance.
const MOST: [usize; 2] = [512, 256];

/// The choice of a direction.
#[derive(Debug)]
pub struct BrightDirections {
    environment: Environment,
    columns: usize,
    /// Height of the upper edge of each row, and of the lower edge of the last.
    heights: Vec<f64>,
    /// The share of the light above each row, and all of it.
    above: Vec<f64>,
    /// In each row, the share of its light before each column, and all of it.
    before: Vec<f64>,
}

/// A direction that was chosen.
#[derive(Debug, Clone, Copy)]
pub struct ChosenDirection {
    /// Unit.
    pub dir: [f64; 3],
    /// How likely it was, by solid angle.
    pub density: f64,
    /// The radiance that comes from there.
    pub radiance: [f64; 3],
}

impl BrightDirections {
    /// Those of an environment map that is not black.
    pub fn new(environment: &Environment) -> Self {
        let size = environment.mipmap.size();
        let columns = (size[0] as usize).clamp(1, MOST[0]);
        let rows = (size[1] as usize).clamp(1, MOST[1]);
        let light = environment.mipmap.means(columns, rows, |_| 1.0);
        let light: Vec<f64> = light.into_iter().map(|channels| channels.iter().sum()).collect();
        let heights: Vec<f64> = (0..=rows).map(|row| math::sin_cos((0.5 - row as f64 / rows as f64) * PI).0).collect();
        let mut before = Vec::with_capacity(rows * (columns + 1));
        let mut above = vec![0.0];
        let mut all = 0.0;
        for row in 0..rows {
            let cells = &light[row * columns..(row + 1) * columns];
            let sum: f64 = cells.iter().sum();
            let mut so_far = 0.0;
            before.push(0.0);
            for (column, cell) in cells.iter().enumerate() {
                so_far += cell;
                let even = (column + 1) as f64 / columns as f64;
                before.push(if column + 1 == columns {
                    1.0
                } else if sum > 0.0 {
                    so_far / sum
                } else {
                    even
                });
            }
            all += sum * (heights[row] - heights[row + 1]);
            above.push(all);
        }
        above.iter_mut().for_each(|share| *share /= all);
        Self { environment: environment.clone(), columns, heights, above, before }
    }

    /// The brightest of them.
    pub fn most(&self) -> [f64; 3] {
        self.environment.mipmap.brightest().map(|channel| channel * self.environment.intensity)
    }

    /// Bytes of memory it takes beside its environment.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.heights[..]) + size_of_val(&self.above[..]) + size_of_val(&self.before[..])
    }

    /// The direction for a point of the unit square.
    pub fn choose(&self, [a, b]: [f64; 2]) -> ChosenDirection {
        let row = cell(&self.above, a);
        let cells = self.cells(row);
        let column = cell(cells, b);
        let within = |sums: &[f64], i: usize, x: f64| ((x - sums[i]) / (sums[i + 1] - sums[i])).clamp(0.0, 1.0);
        let (down, along) = (within(&self.above, row, a), within(cells, column, b));
        let up = self.heights[row] + (self.heights[row + 1] - self.heights[row]) * down;
        let u = (column as f64 + along) / self.columns as f64;
        let (east, north) = math::sin_cos((u - 0.5 - self.environment.turn) * 2.0 * PI);
        let flat = (1.0 - up * up).max(0.0).sqrt();
        let dir = V3 { x: flat * east, y: up, z: -flat * north };
        let V3 { x, y, z } = self.environment.radiance((), dir, 0.0, 1);
        ChosenDirection { dir: [dir.x, dir.y, dir.z], density: self.density_of(row, column), radiance: [x, y, z] }
    }

    /// How likely a unit direction is, by solid angle.
    pub fn density(&self, [x, y, z]: [f64; 3]) -> f64 {
        let rows = self.heights.len() - 1;
        let longitude = angle((), x, -z) / (2.0 * PI) + self.environment.turn;
        let latitude = angle((), y, math::hypot(x, z)) / PI;
        let u = 0.5 + longitude;
        let row = ((0.5 - latitude) * rows as f64).max(0.0) as usize;
        let column = ((u - u.floor()) * self.columns as f64) as usize;
        self.density_of(row.min(rows - 1), column.min(self.columns - 1))
    }

    fn density_of(&self, row: usize, column: usize) -> f64 {
        let cells = self.cells(row);
        let share = (self.above[row + 1] - self.above[row]) * (cells[column + 1] - cells[column]);
        let angle = 2.0 * PI / self.columns as f64 * (self.heights[row] - self.heights[row + 1]);
        share / angle
    }

    fn cells(&self, row: usize) -> &[f64] {
        &self.before[row * (self.columns + 1)..(row + 1) * (self.columns + 1)]
    }
}

/// The cell in which a share lies, given the sums before each cell and all; never one that has nothing, unless all have.
fn cell(sums: &[f64], share: f64) -> usize {
    sums.partition_point(|sum| *sum <= share).clamp(1, sums.len() - 1) - 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::texture::mipmap::Mipmap;
    use std::sync::Arc;

    fn sun(turn: f64) -> Environment {
        let texel = |i: u32| if i == 5 * 32 + 9 { [900.0; 3] } else { [0.1, 0.2, 0.3 + 0.01 * (i % 32) as f32] };
        let mipmap = Mipmap::new(32, 16, (0..512).map(texel).collect());
        Environment { mipmap: Arc::new(mipmap), turn, intensity: 2.0 }
    }

    #[test]
    fn a_direction_is_as_likely_as_is_said_of_it_and_all_are_one() {
        for turn in [0.0, 0.3, -0.8] {
            let choice = BrightDirections::new(&sun(turn));
            for i in 0..1000 {
                let share = |k: u32| (f64::from(i * k % 1000) + 0.5) / 1000.0;
                let chosen = choice.choose([share(1), share(37)]);
                let again = choice.density(chosen.dir);
                assert!((again / chosen.density - 1.0).abs() < 1e-9, "{chosen:?} {again}");
            }
            let (mut sum, step) = (0.0, 2.0 / 4000.0 * PI / 160.0);
            for i in 0..4000 {
                for k in 0..320 {
                    let up = (f64::from(i) + 0.5) / 2000.0 - 1.0;
                    let (east, north) = math::sin_cos((f64::from(k) + 0.5) / 160.0 * PI);
                    let flat = (1.0 - up * up).sqrt();
                    sum += choice.density([flat * east, up, flat * north]) * step;
                }
            }
            assert!((sum - 1.0).abs() < 0.01, "{sum}");
        }
    }

    /// The mean of radiance over density is the light of all directions, whatever the grid is.
    #[test]
    fn the_light_of_all_directions_is_kept() {
        let choice = BrightDirections::new(&sun(0.1));
        let n = 200;
        let mut light = 0.0;
        for i in 0..n * n {
            let chosen =
                choice.choose([(f64::from(i % n) + 0.5) / f64::from(n), (f64::from(i / n) + 0.5) / f64::from(n)]);
            light += chosen.radiance[0] / chosen.density / f64::from(n * n);
        }
        let (mut expected, step) = (0.0, 2.0 / 400.0 * PI / 400.0);
        for i in 0..400 {
            for k in 0..800 {
                let up = (f64::from(i) + 0.5) / 200.0 - 1.0;
                let (east, north) = math::sin_cos((f64::from(k) + 0.5) / 400.0 * PI);
                let flat = (1.0 - up * up).sqrt();
                let dir = V3 { x: flat * east, y: up, z: flat * north };
                expected += choice.environment.radiance((), dir, 0.0, 1).x * step;
            }
        }
        assert!((light / expected - 1.0).abs() < 0.02, "{light} for {expected}");
    }
}
