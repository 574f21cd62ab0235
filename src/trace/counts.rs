//! How many rays were traced, by kind.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rays by kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[expect(missing_docs, reason = "the names say it")]
pub struct RayCounts {
    pub camera: u64,
    pub shadow: u64,
    pub reflected: u64,
    pub transmitted: u64,
    /// Rays from diffuse surfaces, for color bleeding.
    pub gathered: u64,
    /// Camera rays that hit something.
    #[serde(skip)]
    pub camera_hits: u64,
    /// Transmissions that total internal reflection turned into reflections.
    pub total_internal_reflections: u64,
    /// Shadow rays not traced because their light could not add a quarter of `min_weight` to the pixel.
    pub shadow_skipped: u64,
    /// Rays not followed because a sample reached the limit `rays_per_sample`.
    pub dropped: u64,
    /// Rays in the longest chain that was followed.
    #[serde(skip)]
    pub deepest: u32,
}

impl RayCounts {
    /// All rays that were traced.
    pub fn total(&self) -> u64 {
        self.camera + self.shadow + self.reflected + self.transmitted + self.gathered
    }
}

impl std::ops::Add for RayCounts {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self {
            camera: self.camera + o.camera,
            shadow: self.shadow + o.shadow,
            reflected: self.reflected + o.reflected,
            transmitted: self.transmitted + o.transmitted,
            gathered: self.gathered + o.gathered,
            camera_hits: self.camera_hits + o.camera_hits,
            total_internal_reflections: self.total_internal_reflections + o.total_internal_reflections,
            shadow_skipped: self.shadow_skipped + o.shadow_skipped,
            dropped: self.dropped + o.dropped,
            deepest: self.deepest.max(o.deepest),
        }
    }
}
