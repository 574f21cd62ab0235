//! A finished picture, and its cost.

use super::confidence::Sampling;
use super::progressive::Progress;
use crate::bound::{BoundedPixels, Proof};
use crate::film::Film;
use crate::trace::counts::RayCounts;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A finished render.
#[derive(Debug, Default)]
pub struct Picture {
    /// The pixels.
    pub film: Film,
    /// The pixels that may miss light. All others are exact: those of the same samples with recursion without end, or to
    /// [`Reach::max_depth`](crate::bound::ceiling::Reach::max_depth).
    pub bounded: BoundedPixels,
    /// How far more samples would likely change it, estimated from its samples.
    pub sampling: Sampling,
    /// The rays that were traced.
    pub rays: RayCounts,
    /// What antialiasing added.
    pub refined: Refined,
    /// The cost of each pixel, in no particular order, from [`render_measured`](super::render_measured). A refined pixel
    /// comes twice.
    pub costs: Vec<PixelCost>,
    /// The progress of a picture that was stopped.
    pub progress: Option<Progress>,
    /// Milliseconds of wall time spent tracing.
    pub trace_ms: f64,
    /// Those of them that antialiasing took.
    pub refine_ms: f64,
}

impl Picture {
    /// The proof about it.
    pub fn proof(&self) -> Proof {
        Proof::of(&self.film, &self.bounded)
    }

    /// The upper bound of each pixel for recursion without end, row by row.
    pub fn highest(&self) -> Vec<[f32; 3]> {
        let mut highest = self.film.pixels.clone();
        for bounded in self.bounded.iter() {
            highest[self.film.region.index(bounded.at)] = bounded.highest;
        }
        highest
    }
}

/// What antialiasing added to the base samples of all pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Refined {
    /// Pixels that got more samples.
    pub pixels: u64,
    /// The rays of those samples.
    pub rays: RayCounts,
}

/// The cost of one pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelCost {
    /// Its column and row in the whole picture.
    pub at: [u32; 2],
    /// Its samples.
    pub samples: u32,
    /// Rays of all kinds.
    pub rays: u64,
    /// Processor time of the up to 16 pixels that were traced with it, by its share of their rays. 0 if not asked for.
    pub nanoseconds: u64,
    /// Longest chain of rays that were followed.
    pub deepest: u32,
}

impl PixelCost {
    /// What both took for the same pixel.
    pub(super) fn and(self, other: &Self) -> Self {
        Self {
            samples: self.samples + other.samples,
            rays: self.rays + other.rays,
            nanoseconds: self.nanoseconds + other.nanoseconds,
            deepest: self.deepest.max(other.deepest),
            ..self
        }
    }
}
