//! What the frames of a sequence cost, and how far each may be from the exact picture.

use crate::service::pictures::file::PictureMeta;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use std::ops::Add;
use strahl::render::RayCounts;
use strahl::scene::Problem;

/// A finished frame.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct FrameReport {
    /// Its number, from 0.
    pub(crate) number: u32,
    /// Id of its picture, if it has one.
    pub(crate) image_id: Option<String>,
    /// Its path.
    pub(crate) path: String,
    /// All its rays.
    pub(crate) rays: u64,
    /// Milliseconds of tracing.
    pub(crate) trace_ms: f64,
    /// How many of 255 codes it is proved to be off at most. Null where there is no proof.
    pub(crate) proved_codes: Option<u8>,
    /// How many of 255 codes of sampling error are likely. Null where nothing is known of it.
    pub(crate) estimated_codes: Option<f64>,
    /// Warnings about its scene, which are told of all frames together.
    #[serde(skip)]
    pub(crate) warnings: Vec<Box<RawValue>>,
}

/// The whole sequence: sums, and the worst of all bounds.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub(crate) struct SequenceReport {
    /// Finished frames.
    pub(crate) frames: usize,
    /// All their rays.
    pub(crate) rays: u64,
    /// Rays that were predicted for all frames.
    pub(crate) predicted_rays: u64,
    /// Milliseconds of tracing.
    pub(crate) trace_ms: f64,
    /// Milliseconds that were predicted for all frames, on a machine that does nothing else.
    pub(crate) predicted_ms: f64,
    /// How many of 255 codes every frame is proved to be off at most. Null where one has no proof.
    pub(crate) proved_codes: Option<u8>,
    /// The largest sampling error of a frame that is likely, in codes. Null where one has no estimate.
    pub(crate) estimated_codes: Option<f64>,
    /// Warnings about the frames, each once.
    #[schemars(with = "Vec<Problem>")]
    pub(crate) warnings: Vec<Box<RawValue>>,
}

/// The parts of a frame's cost report that count here.
#[derive(Deserialize)]
struct Known {
    #[serde(default)]
    plan: Plan,
    cost: Cost,
    error: Bounds,
}

/// Warnings stay as they were written, perhaps by another version of the program.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Plan {
    warnings: Vec<Box<RawValue>>,
}

#[derive(Deserialize)]
struct Cost {
    rays: RayCounts,
    phases_ms: Phases,
}

#[derive(Deserialize)]
struct Phases {
    trace: f64,
}

#[derive(Deserialize)]
struct Bounds {
    proved: Proved,
    estimated: Option<Estimated>,
}

#[derive(Deserialize)]
struct Proved {
    max_codes: Option<u8>,
}

#[derive(Deserialize)]
struct Estimated {
    half_width_codes: f64,
}

impl FrameReport {
    /// What is known of a finished frame; none if another version of the program has rendered it.
    pub(crate) fn of(number: u32, path: String, meta: &PictureMeta) -> Option<Self> {
        let Known { plan, cost, error } = serde_json::from_str(meta.report.as_ref()?.get()).ok()?;
        Some(Self {
            number,
            image_id: meta.image.clone(),
            path,
            rays: cost.rays.total(),
            trace_ms: cost.phases_ms.trace,
            proved_codes: error.proved.max_codes,
            estimated_codes: error.estimated.map(|estimated| estimated.half_width_codes),
            warnings: plan.warnings,
        })
    }
}

impl SequenceReport {
    /// The report of all frames, by those of each and their warnings.
    pub(crate) fn of(
        frames: &[FrameReport],
        warnings: Vec<Box<RawValue>>,
        predicted_rays: u64,
        predicted_ms: f64,
    ) -> Self {
        let proved: Option<Vec<u8>> = frames.iter().map(|frame| frame.proved_codes).collect();
        let estimated: Option<Vec<f64>> = frames.iter().map(|frame| frame.estimated_codes).collect();
        Self {
            frames: frames.len(),
            rays: frames.iter().map(|frame| frame.rays).sum(),
            predicted_rays,
            // In Rust the sum of no numbers is -0.
            trace_ms: frames.iter().map(|frame| frame.trace_ms).fold(0.0, Add::add),
            predicted_ms,
            proved_codes: proved.and_then(|all| all.into_iter().max()),
            estimated_codes: estimated.and_then(|all| all.into_iter().reduce(f64::max)),
            warnings,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_frames_take_no_time() {
        let report = SequenceReport::of(&[], Vec::new(), 10, 1.0);
        assert_eq!(serde_json::to_value(report).unwrap()["trace_ms"].to_string(), "0.0");
    }
}
