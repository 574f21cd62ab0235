//! Sequences of frames, as the service has them: their text beside the scene's, their price from a few frames, and the files
//! that show all of them.

pub(crate) mod price;
pub(crate) mod report;
pub(crate) mod shown;
pub(crate) mod text;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strahl::film::animation::Timing;
use strahl::sequence::Sequence;

/// What is known of a job's frames without its sequence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "JobFrames")]
pub(crate) struct Frames {
    /// How many there are.
    pub(crate) count: u32,
    /// How many are finished.
    pub(crate) done: u32,
    /// Frames a second of animations.
    pub(crate) rate: f64,
    /// How often animations are shown; 0: again and again.
    pub(crate) loops: u16,
}

impl Frames {
    /// Those of a sequence, none of which is finished.
    pub(crate) fn of(sequence: &Sequence) -> Self {
        Self { count: sequence.count(), done: 0, rate: sequence.rate, loops: sequence.loops }
    }

    /// How they are shown.
    pub(crate) fn timing(&self) -> Timing {
        Timing { rate: self.rate, loops: self.loops }
    }
}
