//! A whole trade-off: its points, the fronts among them, and how all of it was measured.

use super::choices::Choices;
use super::pareto::{Compromise, front, knee};
use super::sweep::Point;
use crate::metrics::Difference;
use schemars::JsonSchema;
use serde::Serialize;

/// What was found out about one scene.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Tradeoff {
    /// The scene's name.
    pub scene: Option<String>,
    /// On what, when and how it was measured.
    pub circumstances: Circumstances,
    /// What the errors of `points` were measured against; none if there was no time for it.
    pub reference: Option<Reference>,
    /// Which setting to take, from about ten that somebody would choose from.
    pub choices: Choices,
    /// Many settings, the cheap ones first; those that the time did not suffice for have no `time`.
    pub points: Vec<Point>,
    /// The best compromises, for each kind of error and of cost.
    pub fronts: Vec<Front>,
    /// Advice on settings.
    pub advice: Vec<String>,
}

/// On what, when and how a trade-off was measured.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Circumstances {
    /// Version of the renderer.
    pub version: &'static str,
    /// Day it was measured on, by Coordinated Universal Time.
    pub date: String,
    /// Threads that rendered.
    pub threads: usize,
    /// Instruction set.
    pub instructions: &'static str,
    /// Width and height that the scene or the request asks for.
    pub asked_size: [u32; 2],
    /// Width and height of the pictures that were compared.
    pub size: [u32; 2],
    /// Seconds it might take.
    pub seconds: f64,
    /// Seconds it took.
    pub took_seconds: f64,
    /// What times are.
    pub times: &'static str,
}

/// What [`Circumstances::times`] says.
pub const HOW_TIMES_ARE_MEASURED: &str = "milliseconds of wall time spent tracing, without loading the scene or encoding the \
    picture; medians of repeats, one of all points after the other round by round, after a warm-up on a smaller picture";

/// The pictures that errors are measured against; they are traced in double precision.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "TradeoffReference")]
pub struct Reference {
    /// Longest chain of rays; none for recursion without end.
    pub max_depth: Option<u32>,
    /// Weight below which a ray is not followed; 0 follows all.
    pub min_weight: f64,
    /// In place of `min_weight`, where there was no time to follow all rays as far: the codes that the reference is proved to
    /// be off at most.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_codes: Option<u8>,
    /// Rays of its pictures that were dropped at the limit for one sample.
    pub dropped: u64,
    /// What following still lighter rays changes; none if all are followed, or if there was no time to see.
    pub finer: Option<Finer>,
}

impl Reference {
    /// Whether nothing is known that would change a code of it.
    pub fn is_exact(&self) -> bool {
        let is_deep = self.min_weight == 0.0 || self.finer.is_some_and(|finer| finer.max_codes == 0);
        self.max_codes.is_none() && self.dropped == 0 && is_deep
    }
}

/// How much a reference changes on the small picture of the warm-up when its rays are followed further.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "FinerReference")]
pub struct Finer {
    /// Weight below which a ray is not followed then.
    pub min_weight: f64,
    /// The largest change of any pixel, in 8-bit codes.
    pub max_codes: u8,
}

/// What a picture costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "TradeoffCost")]
#[serde(rename_all = "snake_case")]
pub enum Cost {
    /// Median milliseconds.
    Time,
    /// Rays of all kinds.
    Rays,
}

/// Where an error comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "ErrorSource")]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Ending the recursion, and rounding; of pictures with one sample in the middle of each pixel.
    Truncation,
    /// That and too few samples.
    Total,
}

/// The points that no other beats.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "TradeoffFront")]
pub struct Front {
    /// Which error: its root mean square in codes.
    pub error: Source,
    /// Which cost.
    pub cost: Cost,
    /// Indices of points by growing cost.
    pub points: Vec<usize>,
    /// The one of them after which more cost buys ever less.
    pub knee: Option<usize>,
}

impl Front {
    /// The front of one plane.
    pub fn of(points: &[Point], error: Source, cost: Cost) -> Self {
        let there: Vec<(usize, Compromise)> =
            points.iter().enumerate().filter_map(|(i, p)| Some((i, p.compromise(error, cost)?))).collect();
        let compromises: Vec<Compromise> = there.iter().map(|(_, c)| *c).collect();
        let best = front(&compromises);
        let along: Vec<Compromise> = best.iter().map(|&i| compromises[i]).collect();
        let knee = knee(&along).map(|i| there[best[i]].0);
        Self { error, cost, points: best.into_iter().map(|i| there[i].0).collect(), knee }
    }

    /// The fronts of all planes.
    pub fn all(points: &[Point]) -> Vec<Self> {
        let planes =
            [Source::Truncation, Source::Total].map(|error| [Cost::Time, Cost::Rays].map(|cost| (error, cost)));
        planes.as_flattened().iter().map(|&(error, cost)| Self::of(points, error, cost)).collect()
    }
}

impl Point {
    /// Its error of one kind; truncation only of one sample in the middle of each pixel.
    pub fn error(&self, source: Source) -> Option<&Difference> {
        match source {
            Source::Truncation if self.settings.positions() != (1, false) => None,
            Source::Truncation => self.measured.truncation.as_ref(),
            Source::Total => self.measured.total.as_ref(),
        }
    }

    /// What it costs.
    pub fn cost(&self, cost: Cost) -> Option<f64> {
        match cost {
            Cost::Time => self.time.as_ref().map(|time| time.median_ms),
            Cost::Rays => self.rays.map(|rays| rays.total() as f64),
        }
    }

    fn compromise(&self, source: Source, cost: Cost) -> Option<Compromise> {
        Some(Compromise { cost: self.cost(cost)?, error: self.error(source)?.rms_codes })
    }
}
