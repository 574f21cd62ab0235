//! Environment map: surroundings infinitely far away, from an equirectangular picture.

use super::lookup::Wrap;
use super::mipmap::Mipmap;
use crate::lanes::{Double, V3, angle};
use crate::math::{Rgb, sin_cos};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;

/// A picture of all directions.
#[derive(Debug, Clone)]
pub struct Environment {
    /// Its texels.
    pub mipmap: Arc<Mipmap>,
    /// How far it is turned around the y axis, in turns, counter-clockwise seen from above.
    pub turn: f64,
    /// Factor on its colors.
    pub intensity: f64,
}

impl Environment {
    /// The radiance in unit directions, over footprints of `spread` radians. Towards the poles texels become narrow; the
    /// footprint is measured by their height, as that of a panorama's pixel is.
    #[inline(always)]
    pub fn radiance<W: Double>(&self, s: W::Simd, dir: V3<W>, spread: W, lanes: u32) -> V3<W> {
        let lit = |x: f64| W::lit(s, x);
        let longitude = angle(s, dir.x, -dir.z) / lit(2.0 * PI) + lit(self.turn);
        let latitude = angle(s, dir.y, (dir.x * dir.x + dir.z * dir.z).sqrt()) / lit(PI);
        let level = self.mipmap.levels(s, spread / lit(PI) * lit(self.mipmap.size()[1]));
        let uv = [lit(0.5) + longitude, lit(0.5) + latitude];
        self.mipmap.at(s, uv, level, [Wrap::Repeat, Wrap::Clamp].into(), lanes) * lit(self.intensity)
    }
}

/// The directions to the middles of the texels of an environment map of so many rows and twice as many columns, row by row.
pub fn directions(rows: u32) -> Vec<DVec3> {
    let columns = 2 * rows;
    let share = |i: u32, of: u32| (f64::from(i) + 0.5) / f64::from(of);
    let around: Vec<_> = (0..columns).map(|column| sin_cos((share(column, columns) - 0.5) * 2.0 * PI)).collect();
    let of_row = |row| {
        let (up, flat) = sin_cos((0.5 - share(row, rows)) * PI);
        around.iter().map(move |(east, north)| DVec3::new(flat * east, up, -flat * north))
    };
    (0..rows).flat_map(of_row).collect()
}

/// A clear sky over ground of one color, as a picture of one column.
pub fn clear_sky(zenith: Rgb, horizon: Rgb, ground: Rgb) -> Mipmap {
    // A row is less than a fifth of a degree, so the horizon is sharp.
    const ROWS: u32 = 1024;
    let color = |row: u32| {
        // In right angles, from 1 straight above to -1 straight below.
        let elevation = 1.0 - 2.0 * (f64::from(row) + 0.5) / f64::from(ROWS);
        if elevation < 0.0 {
            return ground;
        }
        // Air is thin overhead and thick along the horizon, so most of the change is there.
        let low = 1.0 - elevation;
        zenith + (horizon - zenith) * (low * low * low)
    };
    Mipmap::new(1, ROWS, (0..ROWS).map(|row| color(row).to_array().map(|channel| channel as f32)).collect())
}
