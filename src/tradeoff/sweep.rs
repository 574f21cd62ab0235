//! The settings that a trade-off compares, and the measurements of each.

use super::left_out::LeftOut;
use crate::metrics::Difference;
use crate::scene::description::{DEFAULT_MAX_DEPTH, Precision};
use crate::trace::counts::RayCounts;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt;

/// Settings that trade accuracy for time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "TradeoffSettings")]
pub struct Settings {
    /// Longest chain of rays; the primary ray counts 1. None: without end, which is what requests get that ask for a proof
    /// and name no `max_depth`.
    pub max_depth: Option<u32>,
    /// Weight below which a ray is not followed.
    pub min_weight: f64,
    /// In place of `min_weight`: each pixel's rays are followed until it is proved to be at most this many codes off the
    /// picture of `max_depth`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_codes: Option<u8>,
    /// Rays for each pixel.
    pub samples: u32,
    /// Whether pixels that differ from a neighbour get 4 to 16 samples.
    pub antialias: bool,
    /// Floating-point format.
    pub precision: Precision,
}

/// What is varied while the rest stays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sweep {
    /// Nothing: the settings the scene itself asks for.
    AsAsked,
    /// `max_depth`.
    Depth,
    /// `min_weight`, at a depth of at least 100.
    Weight,
    /// `max_codes`.
    Proved,
    /// `samples`.
    Samples,
    /// `antialias`.
    Antialias,
}

/// Settings and what they were found to cost and to miss.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "TradeoffPoint")]
pub struct Point {
    /// The settings.
    pub settings: Settings,
    /// Which sweeps it belongs to.
    pub sweeps: Vec<Sweep>,
    /// Milliseconds of tracing; none if it was not measured in the time there was.
    pub time: Option<Times>,
    /// Rays by kind.
    pub rays: Option<RayCounts>,
    /// Errors found against references.
    pub measured: Errors,
    /// The bound proved for truncation, in 8-bit codes, if there is one: where the settings have `max_codes`, compared with
    /// recursion to their `max_depth`, elsewhere with recursion without end.
    pub proved_codes: Option<u8>,
}

/// Errors of one picture, kept apart by where they come from. None: there was no reference to measure against.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
#[schemars(rename = "MeasuredErrors")]
pub struct Errors {
    /// Of ending the recursion, and of rounding: against the same samples followed as far as the reference's.
    pub truncation: Option<Difference>,
    /// Of too few samples: of the reference with the same samples against that with 64.
    pub sampling: Option<Difference>,
    /// Of both: against the reference with 64 samples.
    pub total: Option<Difference>,
}

/// Repeated times of the same work, in milliseconds.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "RepeatedTimes")]
pub struct Times {
    /// Half of the repeats are not longer; of an even number the mean of the two in the middle.
    pub median_ms: f64,
    /// The shortest.
    pub min_ms: f64,
    /// The longest.
    pub max_ms: f64,
    /// How many there were.
    pub repeats: usize,
}

impl Times {
    /// None of no repeats.
    pub fn of(repeats: &[f64]) -> Option<Self> {
        let mut sorted = repeats.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (first, last) = (*sorted.first()?, *sorted.last()?);
        let middle = sorted.len() / 2;
        let median_ms =
            if sorted.len() % 2 == 1 { sorted[middle] } else { 0.5 * (sorted[middle - 1] + sorted[middle]) };
        Some(Self { median_ms, min_ms: first, max_ms: last, repeats: sorted.len() })
    }
}

/// Samples of the picture that sampling is measured against.
pub const REFERENCE_SAMPLES: u32 = 64;
/// Depths 3, 5, 10 and 100, which show most of the trade-off, and some between.
const DEPTHS: [u32; 6] = [2, 3, 5, 10, 20, 100];
const DOUBLE_DEPTHS: [u32; 4] = [3, 5, 10, 100];
/// Contribution cut-offs; 1/255 is POV-Ray's.
const WEIGHTS: [f64; 7] = [0.1, 0.03, 1.0 / 255.0, 1e-3, 3e-4, 1e-4, 1e-5];
const DOUBLE_WEIGHTS: [f64; 2] = [1e-2, 1e-5];
const SAMPLES: [u32; 4] = [1, 4, 16, REFERENCE_SAMPLES];

/// The points of a trade-off around the settings that a scene asks for, the cheap ones first; those themselves only if its mode is
/// not left out. Proofs are held against recursion to `proved_depth`, none being without end.
///
/// Recursion is swept with one sample in the middle of each pixel, since its error is that of the same samples.
pub fn points(asked: Settings, left_out: LeftOut, proved_depth: Option<u32>) -> Vec<Point> {
    let fixed = asked.fixed();
    let base = Settings { samples: 1, antialias: false, precision: Precision::Single, ..fixed };
    let deep = base.deep();
    let double = |settings| Settings { precision: Precision::Double, ..settings };
    let depth = |max_depth| Settings { max_depth: Some(max_depth), ..base };
    let weight = |min_weight| Settings { min_weight, ..deep };
    let proved = |codes| base.proved(codes, proved_depth);
    let samples = |samples| Settings { samples, ..base };
    let smooth = |samples| Settings { samples, antialias: true, ..base };
    let all = (!left_out.has_mode())
        .then_some((Sweep::AsAsked, asked))
        .into_iter()
        .chain(DEPTHS.map(|n| (Sweep::Depth, depth(n))))
        .chain(DOUBLE_DEPTHS.map(|n| (Sweep::Depth, double(depth(n)))))
        .chain(WEIGHTS.map(|w| (Sweep::Weight, weight(w))))
        .chain(DOUBLE_WEIGHTS.map(|w| (Sweep::Weight, double(weight(w)))))
        .chain([2, 1, 0].map(|codes| (Sweep::Proved, proved(codes))))
        .chain([1, 0].map(|codes| (Sweep::Proved, double(proved(codes)))))
        .chain(SAMPLES.map(|n| (Sweep::Samples, samples(n))))
        .chain([1, 16].map(|n| (Sweep::Samples, double(samples(n)))))
        .chain([1, 4].map(|n| (Sweep::Antialias, smooth(n))))
        .chain([(Sweep::Antialias, double(smooth(1)))]);
    let mut points: Vec<Point> = Vec::new();
    for (sweep, settings) in all {
        match points.iter_mut().find(|point| point.settings == settings) {
            Some(point) if point.sweeps.contains(&sweep) => {}
            Some(point) => point.sweeps.push(sweep),
            None => points.push(Point {
                settings,
                sweeps: vec![sweep],
                time: None,
                rays: None,
                measured: Errors::default(),
                proved_codes: None,
            }),
        }
    }
    points.sort_by(|a, b| a.settings.effort().total_cmp(&b.settings.effort()));
    points
}

impl Settings {
    /// The same with `max_depth` and `min_weight` in place of a proof.
    pub(super) fn fixed(self) -> Self {
        let max_depth = Some(self.max_depth.unwrap_or(DEFAULT_MAX_DEPTH));
        Self { max_depth, max_codes: None, ..self }
    }

    /// The same with chains so long that only their weight ends them.
    pub(super) fn deep(self) -> Self {
        Self { max_depth: self.max_depth.map(|depth| depth.max(100)), ..self }
    }

    /// The same proved to some codes, compared with recursion to a depth.
    pub(super) fn proved(self, codes: u8, max_depth: Option<u32>) -> Self {
        Self { max_codes: Some(codes), max_depth, ..self }
    }

    /// A number that grows with the time they take, to sort cheap ones first.
    fn effort(&self) -> f64 {
        let samples = f64::from(self.samples) + if self.antialias { 4.0 } else { 0.0 };
        let depth = f64::from(self.max_depth.unwrap_or(100).min(100));
        let lightest = 1.0 - 0.1 * libm::log10(self.min_weight.max(1e-9));
        let double = if self.precision == Precision::Double { 1.6 } else { 1.0 };
        samples * libm::log(1.0 + depth) * lightest * double
    }

    /// Where its samples lie. Pictures with the same samples differ only by recursion and rounding.
    pub fn positions(&self) -> (u32, bool) {
        (self.samples, self.antialias && self.samples < crate::scene::effects::REFINED_SAMPLES)
    }

    /// A short name within a sweep.
    pub fn label(&self, sweep: Sweep) -> String {
        let mut label = match sweep {
            Sweep::AsAsked => "as asked".to_owned(),
            Sweep::Depth => format!("depth {}", self.max_depth.unwrap_or_default()),
            Sweep::Weight => format!("weight {}", brief(self.min_weight)),
            Sweep::Proved => format!("proved {}", self.max_codes.unwrap_or_default()),
            Sweep::Samples | Sweep::Antialias => plural(self.samples),
        };
        if sweep == Sweep::Antialias {
            label.push_str(" + AA");
        }
        if self.precision == Precision::Double && sweep != Sweep::AsAsked {
            label.push_str(" double");
        }
        label
    }
}

impl fmt::Display for Settings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { max_depth, min_weight, max_codes, samples, antialias, precision } = *self;
        let antialias = if antialias { ", antialiased" } else { "" };
        let precision = if precision == Precision::Double { "double" } else { "single" };
        if let Some(depth) = max_depth {
            write!(f, "depth {depth}, ")?;
        }
        match max_codes {
            Some(1) => f.write_str("proved to 1 code, ")?,
            Some(codes) => write!(f, "proved to {codes} codes, ")?,
            None => write!(f, "weight {}, ", brief(min_weight))?,
        }
        write!(f, "{}{antialias}, {precision}", plural(samples))
    }
}

impl Point {
    /// Its short name.
    pub fn label(&self) -> String {
        self.settings.label(self.sweeps.first().copied().unwrap_or(Sweep::AsAsked))
    }
}

fn plural(samples: u32) -> String {
    if samples == 1 { "1 sample".to_owned() } else { format!("{samples} samples") }
}

/// A cut-off in few characters.
pub(super) fn brief(weight: f64) -> String {
    if weight == 1.0 / 255.0 {
        "1/255".to_owned()
    } else if weight == 0.0 || weight >= 1e-3 {
        format!("{weight}")
    } else {
        format!("{weight:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Image8;

    #[test]
    fn there_are_24_points_whatever_a_scene_asks_for_and_none_twice() {
        for max_depth in [1, 5, 10, 100, 3000].map(Some) {
            for min_weight in [0.0, 1e-3, 0.5] {
                for (samples, antialias) in [(1, true), (1, false), (64, true), (7, false)] {
                    let asked = Settings {
                        max_depth,
                        min_weight,
                        max_codes: None,
                        samples,
                        antialias,
                        precision: Precision::Single,
                    };
                    let points = points(asked, LeftOut::default(), None);
                    assert!(points.len() >= 24, "{asked}: {}", points.len());
                    assert!(points.iter().any(|p| p.settings == asked && p.sweeps.contains(&Sweep::AsAsked)));
                    for (i, point) in points.iter().enumerate() {
                        assert!(points[..i].iter().all(|other| other.settings != point.settings), "{point:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_mode_that_chooses_samples_is_no_point() {
        let asked = Settings {
            max_depth: None,
            min_weight: 1e-3,
            max_codes: Some(1),
            samples: 7,
            antialias: true,
            precision: Precision::Single,
        };
        for (mode, is_point) in
            [("proved:1", true), ("statistical:2", false), ("time:200", false), ("rays:1000", false)]
        {
            let points = points(asked, LeftOut::of(mode.parse().unwrap(), false), None);
            assert!(points.len() >= 24, "{mode}: {}", points.len());
            assert_eq!(points.iter().any(|point| point.sweeps.contains(&Sweep::AsAsked)), is_point, "{mode}");
        }
    }

    #[test]
    fn times_have_a_middle() {
        assert_eq!(Times::of(&[]), None);
        let times = Times::of(&[3.0, 1.0, 2.0, 10.0]).unwrap();
        assert_eq!((times.median_ms, times.min_ms, times.max_ms, times.repeats), (2.5, 1.0, 10.0, 4));
        assert_eq!(Times::of(&[3.0, 1.0, 2.0]).unwrap().median_ms, 2.0);
    }

    #[test]
    fn the_same_picture_differs_by_nothing() {
        let a = Image8::opaque(2, vec![[10, 20, 30], [0, 255, 0]]);
        let same = Difference::of(&a, &a);
        assert_eq!((same.codes.error.max, same.rms_codes, same.flip.max, same.ciede2000.max), (0.0, 0.0, 0.0, 0.0));
        let b = Image8::opaque(2, vec![[10, 23, 30], [0, 255, 0]]);
        assert!((Difference::of(&a, &b).rms_codes - 1.5f64.sqrt()).abs() < 1e-12);
    }
}
