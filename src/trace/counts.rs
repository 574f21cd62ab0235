//! How many rays were traced, by kind.

use crate::lanes::{MAX_LANES, lanes_of};
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
    /// Rays from diffuse surfaces, for color bleeding and global illumination.
    pub gathered: u64,
    /// Camera rays that hit something.
    #[serde(skip)]
    pub camera_hits: u64,
    /// Transmissions that total internal reflection turned into reflections.
    pub total_internal_reflections: u64,
    /// Shadow rays not traced, since their light could add less than the pruning rule asks for: a quarter of `min_weight`, or what the
    /// proof can spare.
    pub shadow_skipped: u64,
    /// Rays not followed because a sample reached the limit `rays_per_sample`, or a pixel the limit of its proof.
    pub dropped: u64,
    /// Pixels whose proof was given up, once for each time that they were traced.
    #[serde(skip)]
    pub given_up: u64,
    /// Rays in the longest chain that was followed.
    #[serde(skip)]
    pub deepest: u32,
}

/// The rays of each sample of a batch.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct LaneCounts {
    /// Rays of all kinds.
    pub(crate) rays: [u32; MAX_LANES],
    /// Rays in the longest chain that was followed.
    pub(crate) deepest: [u32; MAX_LANES],
}

impl LaneCounts {
    /// Adds a ray to some samples, the last of a chain of `depth`.
    #[cold]
    #[inline(never)]
    pub(super) fn add(&mut self, samples: u32, depth: u32) {
        for sample in lanes_of(samples) {
            self.rays[sample] += 1;
            self.deepest[sample] = self.deepest[sample].max(depth);
        }
    }
}

impl LaneCounts {
    /// Adds the counts of samples to those of their owners.
    pub(crate) fn add_all(&mut self, samples: &Self, owners: impl Iterator<Item = usize>) {
        for (sample, owner) in owners.enumerate() {
            self.rays[owner] += samples.rays[sample];
            self.deepest[owner] = self.deepest[owner].max(samples.deepest[sample]);
        }
    }
}

impl RayCounts {
    /// So many times as many.
    pub(crate) fn times(self, factor: f64) -> Self {
        let times = |count: u64| (count as f64 * factor).round() as u64;
        Self {
            camera: times(self.camera),
            shadow: times(self.shadow),
            reflected: times(self.reflected),
            transmitted: times(self.transmitted),
            gathered: times(self.gathered),
            camera_hits: times(self.camera_hits),
            total_internal_reflections: times(self.total_internal_reflections),
            shadow_skipped: times(self.shadow_skipped),
            dropped: times(self.dropped),
            ..self
        }
    }

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
            given_up: self.given_up + o.given_up,
            deepest: self.deepest.max(o.deepest),
        }
    }
}
