//! Environment map: surroundings infinitely far away, from an equirectangular picture.

use super::mipmap::{Mipmap, Wrap};
use crate::math;
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
    /// Factor on its colours.
    pub intensity: f64,
}

impl Environment {
    /// The radiance in a unit direction, over a footprint of `spread` radians. Towards the poles texels become narrow; the
    /// footprint is measured by their height, as that of a panorama's pixel is.
    pub fn radiance(&self, dir: DVec3, spread: f64) -> [f64; 3] {
        let longitude = math::atan2(dir.x, -dir.z) / (2.0 * PI) + self.turn;
        let latitude = math::atan2(dir.y, (dir.x * dir.x + dir.z * dir.z).sqrt()) / PI;
        let level = self.mipmap.level(spread / PI * self.mipmap.size()[1]);
        let seen = self.mipmap.at([0.5 + longitude, 0.5 + latitude], level, [Wrap::Repeat, Wrap::Clamp]);
        seen.map(|channel| channel * self.intensity)
    }
}
