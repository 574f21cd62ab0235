//! How bright anything in a scene can be: what a ray that is not followed could have added at most.

use schemars::JsonSchema;
use serde::Serialize;

/// An upper bound on the radiance of any ray, for each channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Ceiling {
    /// By the rays that a chain may still have, the ray itself included; the last entry is for as many and more.
    /// [`NO_BOUND`] where nothing bounds it.
    levels: Vec<[f64; 3]>,
    /// What it is about.
    pub reach: Reach,
}

/// What pictures are held against, and why.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Reach {
    /// Longest chain of rays of that picture; none for recursion without end.
    pub max_depth: Option<u32>,
    /// The largest radiance of a ray that may go on for all of it. None where nothing bounds it.
    pub ceiling: Option<[f64; 3]>,
    /// What decides that, in a sentence.
    pub why: String,
    /// JSON pointers of what the sentence is about.
    pub because: Vec<String>,
}

/// Factor on ceilings, for the roundings of the kernel: those of a highlight's power above all.
const SLACK: f64 = 1.002;

/// What stands for infinity: a weight of 0 times it is 0, not NaN.
const NO_BOUND: f64 = 1e28;

impl Ceiling {
    /// The same for all rays.
    pub fn endless(radiance: [f64; 3], why: String, because: Vec<String>) -> Self {
        let radiance = radiance.map(|c| c * SLACK);
        Self { levels: vec![radiance], reach: Reach { max_depth: None, ceiling: Some(radiance), why, because } }
    }

    /// By the number of rays in a chain, entry 0 being that of no ray.
    pub fn by_depth(levels: Vec<[f64; 3]>, max_depth: u32, why: String, because: Vec<String>) -> Self {
        let levels: Vec<[f64; 3]> = levels.into_iter().map(|level| level.map(|c| c * SLACK)).collect();
        let ceiling = levels.last().copied().filter(|level| level.iter().all(|c| c.is_finite()));
        let levels = levels.into_iter().map(|level| level.map(|c| c.min(NO_BOUND))).collect();
        Self { levels, reach: Reach { max_depth: Some(max_depth), ceiling, why, because } }
    }

    /// The ceiling of a ray that begins a chain of at most `rays`.
    pub fn of(&self, rays: u32) -> [f64; 3] {
        self.levels[(rays as usize).min(self.levels.len() - 1)]
    }
}
