//! A small picture of all directions and ever smaller copies of it, for means over wide lobes. Each texel is the mean over its solid
//! angle, so that a sum over texels is an integral over directions. Plain means over the rows of an equirectangular picture would
//! count what is near the poles several times.

use super::texture::environment::{Environment, directions};
use super::texture::mipmap::Mipmap;
use crate::lanes::{Double, V3, angle, dispatch};
use crate::math::{self, Rgb};
use fearless_simd::{Level as Instructions, f64x8};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;

/// Rows of the largest copy, which has twice as many columns.
pub(super) const ROWS: u32 = 128;

/// The copies.
#[derive(Debug)]
pub(super) struct EnvironmentPyramid {
    levels: Vec<Level>,
}

/// Rows from top to bottom.
#[derive(Debug)]
struct Level {
    rows: usize,
    texels: Vec<Rgb>,
    /// Height of the band of each row, in proportion to the solid angle of its texels.
    bands: Vec<f64>,
}

impl EnvironmentPyramid {
    /// Copies of an environment map.
    pub(super) fn new(environment: &Environment) -> Self {
        let [width, height] = environment.mipmap.size().map(|size| size as u32);
        let (columns, rows) = (width.min(2 * ROWS), height.min(ROWS));
        let band = |row: usize| band(row, height as usize);
        let reduced = if (columns, rows) == (width, height) {
            environment.clone()
        } else {
            let texels = environment.mipmap.means(columns as usize, rows as usize, band);
            let texels = texels.into_iter().map(|texel| texel.map(|channel| channel as f32)).collect();
            Environment { mipmap: Arc::new(Mipmap::new(columns, rows, texels)), ..*environment }
        };
        let texels = dispatch!(Instructions::new(), looked_up::<f64x8, f64>(&reduced, &directions(ROWS)));
        let mut levels = vec![Level::new(ROWS as usize, texels)];
        while let Some(next) = levels.last().and_then(Level::halved) {
            levels.push(next);
        }
        Self { levels }
    }

    /// Bytes of memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(&level.texels[..]) + size_of_val(&level.bands[..])).sum()
    }

    /// Unit directions, how large the solid angles around them are, and the mean light of each.
    pub(super) fn parts(&self) -> impl Iterator<Item = (DVec3, f64, Rgb)> {
        let Level { texels, bands, .. } = &self.levels[0];
        let columns = 2 * ROWS as usize;
        let parts = directions(ROWS).into_iter().zip(texels).enumerate();
        parts.map(move |(i, (dir, light))| (dir, bands[i / columns] * 2.0 * PI / columns as f64, *light))
    }

    /// Means over about so many radians.
    pub(super) fn lobe(&self, spread: f64) -> Lobe<'_> {
        let finest = PI / f64::from(ROWS);
        let level = math::log2((spread / finest).max(1.0)).min((self.levels.len() - 1) as f64);
        let below = level.floor();
        let share = level - below;
        let next = (share > 0.0).then(|| &self.levels[below as usize + 1]);
        Lobe { spread, level: &self.levels[below as usize], next, share }
    }
}

/// How wide a mean is, and which copies it is taken from.
#[derive(Debug)]
pub(super) struct Lobe<'a> {
    spread: f64,
    level: &'a Level,
    /// The next smaller copy, and its share.
    next: Option<&'a Level>,
    share: f64,
}

impl Lobe<'_> {
    /// The mean light around a direction.
    pub(super) fn mean(&self, place: &Place) -> Rgb {
        let light = self.level.mean(place, self.spread);
        let Some(next) = self.next else { return light };
        light * (1.0 - self.share) + next.mean(place, self.spread) * self.share
    }
}

/// Where a unit direction is in pictures of any size.
pub(super) struct Place {
    /// From 0 to 1 around.
    turn: f64,
    /// From 0 to 1 down.
    height: f64,
    /// How far it is from the axis through the poles.
    flat: f64,
}

impl Place {
    /// Those of directions, the first one's first.
    #[inline(always)]
    pub(super) fn of<W: Double>(s: W::Simd, dir: V3<W>) -> impl Iterator<Item = Self> {
        let lit = |x: f64| W::lit(s, x);
        let flat = (dir.x * dir.x + dir.z * dir.z).sqrt();
        let turn = angle(s, dir.x, -dir.z) / lit(2.0 * PI) + lit(0.5);
        let height = lit(0.5) - angle(s, dir.y, flat) / lit(PI);
        (0..W::COUNT).map(move |i| Self { turn: turn.lane(i), height: height.lane(i), flat: flat.lane(i) })
    }
}

impl Level {
    fn new(rows: usize, texels: Vec<Rgb>) -> Self {
        Self { rows, texels, bands: (0..rows).map(|row| band(row, rows)).collect() }
    }

    fn columns(&self) -> usize {
        2 * self.rows
    }

    fn texel(&self, column: usize, row: usize) -> Rgb {
        self.texels[row * self.columns() + column]
    }

    /// The copy that is half as large in each direction.
    fn halved(&self) -> Option<Self> {
        let rows = self.rows / 2;
        let part = |i: usize| {
            let (column, row) = (2 * (i % (2 * rows)), 2 * (i / (2 * rows)));
            let [above, below] = [row, row + 1].map(|row| self.texel(column, row) + self.texel(column + 1, row));
            let [upper, lower] = [row, row + 1].map(|row| self.bands[row]);
            (above * upper + below * lower) * (0.5 / (upper + lower))
        };
        (rows > 0).then(|| Self::new(rows, (0..2 * rows * rows).map(part).collect()))
    }

    fn mean(&self, Place { turn, height, flat }: &Place, spread: f64) -> Rgb {
        let down = (height * self.rows as f64 - 0.5).clamp(0.0, (self.rows - 1) as f64);
        let row = down as usize;
        let share = down - row as f64;
        let next = (row + 1).min(self.rows - 1);
        // Towards the poles texels become narrow.
        let width = spread / (2.0 * PI * flat.max(1e-9)) * self.columns() as f64;
        self.across(row, *turn, width) * (1.0 - share) + self.across(next, *turn, width) * share
    }

    /// The mean over so many texels of a row.
    fn across(&self, row: usize, turn: f64, width: f64) -> Rgb {
        let columns = self.columns();
        // The number of columns is a power of two.
        let at = |column: i64| self.texel(column as usize & (columns - 1), row);
        let middle = turn * columns as f64;
        if width < 2.0 {
            let place = middle - 0.5;
            let left = place as i64 - i64::from(place < 0.0);
            let share = place - left as f64;
            return at(left) * (1.0 - share) + at(left + 1) * share;
        }
        let count = (width as i64).min(columns as i64);
        let first = (middle - 0.5 * count as f64).round() as i64;
        (first..first + count).map(at).fold(Rgb::ZERO, |sum, texel| sum + texel) * (1.0 / count as f64)
    }
}

/// An environment's radiance in some directions.
fn looked_up<W: Double>(s: W::Simd, environment: &Environment, directions: &[DVec3]) -> Vec<Rgb> {
    let mut texels = Vec::with_capacity(directions.len());
    W::vectorize(
        s,
        #[inline(always)]
        || {
            for some in directions.chunks(W::COUNT) {
                let lanes = ((1u64 << some.len()) - 1) as u32;
                let V3 { x, y, z } = environment.radiance(s, beside(s, some), W::lit(s, 0.0), lanes);
                texels.extend((0..some.len()).map(|lane| Rgb::new(x.lane(lane), y.lane(lane), z.lane(lane))));
            }
        },
    );
    texels
}

/// At most as many vectors as there are lanes; those beyond are the last one.
#[inline(always)]
pub(super) fn beside<W: Double>(s: W::Simd, vectors: &[DVec3]) -> V3<W> {
    let of = |lane: usize| vectors[lane.min(vectors.len() - 1)];
    V3 { x: W::from_fn(s, |lane| of(lane).x), y: W::from_fn(s, |lane| of(lane).y), z: W::from_fn(s, |lane| of(lane).z) }
}

/// How high the band of a row is on the unit sphere: its share of all directions, times 2.
fn band(row: usize, rows: usize) -> f64 {
    let step = PI / rows as f64;
    // sin(a + h) - sin(a - h) = 2 cos(a) sin(h), with a the elevation of its middle.
    2.0 * math::sin_cos((row as f64 + 0.5) * step).0 * math::sin_cos(0.5 * step).0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lamp of so many rows around the zenith, of radiance 1.
    fn lamp(rows: u32, height: u32) -> Environment {
        let texel = |i: u32| [if i / (2 * height) < rows { 1.0 } else { 0.0 }; 3];
        let texels = (0..2 * height * height).map(texel).collect();
        Environment { mipmap: Arc::new(Mipmap::new(2 * height, height, texels)), turn: 0.125, intensity: 2.0 }
    }

    #[test]
    fn sums_are_integrals_also_at_the_poles() {
        for (rows, height) in [(3, 40), (3, 200), (10, 200), (4, 128), (3, 1_000)] {
            let pyramid = EnvironmentPyramid::new(&lamp(rows, height));
            let all: f64 = pyramid.parts().map(|(_, angle, light)| angle * light.x).sum();
            let cap = 2.0 * 2.0 * PI * (1.0 - math::sin_cos(f64::from(rows) / f64::from(height) * PI).1);
            // The edge of the lamp is linear over a texel.
            assert!((all / cap - 1.0).abs() < 0.08, "{rows} of {height}: {all} for {cap}");
            for (i, level) in pyramid.levels.iter().enumerate() {
                let texels = level.texels.iter().enumerate();
                let sum: f64 = texels.map(|(i, light)| light.x * level.bands[i / level.columns()]).sum();
                let same = sum * 2.0 * PI / level.columns() as f64;
                assert!((same / all - 1.0).abs() < 1e-9, "level {i}: {same} for {all}");
            }
        }
    }

    fn place(dir: DVec3) -> Place {
        Place::of::<f64>((), V3 { x: dir.x, y: dir.y, z: dir.z }).next().unwrap()
    }

    /// Means over lobes, added up over all directions, are the light of all directions.
    #[test]
    fn lookups_neither_add_nor_lose_light() {
        for rows in [1, 3, 12] {
            let pyramid = EnvironmentPyramid::new(&lamp(rows, 256));
            let all: f64 = pyramid.parts().map(|(_, angle, light)| angle * light.x).sum();
            for spread in [0.01, 0.05, 0.11, 0.3, 0.7] {
                let lobe = pyramid.lobe(spread);
                let seen: f64 = pyramid.parts().map(|(dir, angle, _)| angle * lobe.mean(&place(dir)).x).sum();
                assert!((seen / all - 1.0).abs() < 0.2, "{rows} rows, {spread}: {seen} for {all}");
            }
        }
    }
}
