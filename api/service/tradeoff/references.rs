//! The reference pictures.

use super::bench::{LEAST_SLACK_MS, TradeoffBench};
use strahl::metrics::{Difference, Image8};
use strahl::render::Cancelled;
use strahl::scene::description::Precision;
use strahl::tradeoff::page::Thumbnails;
use strahl::tradeoff::sweep::{REFERENCE_SAMPLES, Settings};
use strahl::tradeoff::{Errors, Finer, Reference};

/// Depth of references, unless the scene asks for more.
const DEPTH: u32 = 1000;
/// Weights below which references do not follow rays, the least first that they take.
const WEIGHTS: [f64; 6] = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 0.0];
/// The smallest weight of the settings. References go further if they can.
const FINEST: f64 = 1e-5;
/// Better references leave time for smaller pictures only, so they take at most as long as this many rounds.
const MOST_ROUNDS: f64 = 1.0;

/// Where samples lie: their number, and whether edges get more.
pub(super) type Positions = (u32, bool);

/// All sampling patterns of some settings, the fewest samples first.
pub(super) fn positions(settings: &[Settings]) -> Vec<Positions> {
    let mut all: Vec<_> = settings.iter().map(Settings::positions).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// How far references follow rays.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    settings: Settings,
    /// What following still lighter rays changes.
    finer: Option<Finer>,
}

impl Reach {
    /// Those that come into question where there is little time, the best first.
    pub(super) fn all(asked: Settings, proved_depth: Option<u32>) -> Vec<Self> {
        let double = Settings { precision: Precision::Double, ..asked };
        let deep =
            |max_depth, min_weight| Settings { max_depth: Some(max_depth), min_weight, max_codes: None, ..double };
        let depth = asked.max_depth.unwrap_or(0).max(DEPTH);
        let mut all = vec![deep(depth, WEIGHTS[0].min(asked.min_weight))];
        if asked.min_weight < WEIGHTS[0] || depth > DEPTH {
            all.push(deep(DEPTH, WEIGHTS[0]));
        }
        // A proof that is held against a picture of less depth says nothing about deeper ones.
        if proved_depth.is_none() {
            all.push(Settings { max_codes: Some(1), max_depth: None, ..double });
        }
        all.into_iter().map(|settings| Self { settings, finer: None }).collect()
    }

    /// The settings of a reference.
    pub(super) fn with(&self, (samples, antialias): Positions) -> Settings {
        Settings { samples, antialias, ..self.settings }
    }

    /// The smallest weight that there is time for until `end`, given the milliseconds of all references and of a round of all
    /// settings, and what one more changes. One sample in the middle of each pixel tells it.
    pub(super) fn finest(
        self,
        bench: &mut TradeoffBench<'_>,
        (all_ms, round_ms): (f64, f64),
        end: f64,
    ) -> Result<Self, Cancelled> {
        if self.settings.max_codes.is_some() {
            return Ok(self);
        }
        let mut best = self;
        // The picture before, and the time of the first.
        let mut before: Option<(Image8, f64)> = None;
        let mut patience_ms = all_ms + bench.slack_ms();
        for min_weight in WEIGHTS.into_iter().filter(|weight| *weight <= self.settings.min_weight) {
            let reach = Self { settings: Settings { min_weight, ..self.settings }, finer: None };
            let Some(picture) = bench.render_within(reach.with((1, false)), patience_ms, end)? else { break };
            let codes = Image8::from(&picture.film);
            let (first_ms, change) = before.as_ref().map_or((picture.trace_ms, None), |(before, first_ms)| {
                (*first_ms, Some(Finer { min_weight, max_codes: largest_difference(before, &codes) }))
            });
            // What is beyond the time only says what it would change. Where that is nothing, it need not be followed.
            // Milliseconds say little on a machine that does something else.
            let is_dear = picture.trace_ms / first_ms.max(1.0) * all_ms > MOST_ROUNDS * round_ms + LEAST_SLACK_MS;
            let is_same = min_weight < FINEST && change.is_some_and(|change| change.max_codes == 0);
            if change.is_some() && (is_dear || is_same) {
                best.finer = change;
                break;
            }
            patience_ms = 20.0 * picture.trace_ms + bench.slack_ms();
            (best, before) = (reach, Some((codes, first_ms)));
        }
        Ok(best)
    }

    /// What it is, for the report.
    pub(super) fn report(&self, dropped: u64) -> Reference {
        let Settings { max_depth, min_weight, max_codes, .. } = self.settings;
        Reference { max_depth, min_weight, max_codes, dropped, finer: self.finer }
    }
}

fn largest_difference(a: &Image8, b: &Image8) -> u8 {
    a.differences(b).into_iter().flatten().max().unwrap_or(0)
}

/// Pictures in double precision with recursion as deep as possible, one for each sampling pattern.
pub(super) struct References {
    pub(super) reach: Reach,
    by_positions: Vec<(Positions, Image8)>,
    /// Rays that were dropped at the limit for one sample.
    dropped: u64,
    /// Milliseconds of all.
    pub(super) all_ms: f64,
}

impl References {
    /// Traces those that are done before a share of the time has passed. None if none is.
    pub(super) fn trace(
        bench: &mut TradeoffBench<'_>,
        all: &[Positions],
        reach: Reach,
        most_ms: f64,
        end: f64,
    ) -> Result<Option<Self>, Cancelled> {
        let mut references = Self { reach, by_positions: Vec::new(), dropped: 0, all_ms: 0.0 };
        for &positions in all {
            let left_ms = most_ms - references.all_ms;
            let Some(picture) = bench.render_within(reach.with(positions), left_ms, end)? else { break };
            references.all_ms += picture.trace_ms;
            references.dropped += picture.rays.dropped;
            references.by_positions.push((positions, Image8::from(&picture.film)));
        }
        Ok((!references.by_positions.is_empty()).then_some(references))
    }

    /// The sampling patterns that there was time for.
    pub(super) fn positions(&self) -> Vec<Positions> {
        self.by_positions.iter().map(|(positions, _)| *positions).collect()
    }

    pub(super) fn report(&self) -> Reference {
        self.reach.report(self.dropped)
    }

    /// The picture with the fewest samples.
    pub(super) fn first(&self) -> Option<&Image8> {
        self.by_positions.first().map(|(_, codes)| codes)
    }

    pub(super) fn of(&self, positions: Positions) -> Option<&Image8> {
        self.by_positions.iter().find(|(known, _)| *known == positions).map(|(_, codes)| codes)
    }

    fn best(&self) -> Option<&Image8> {
        self.of((REFERENCE_SAMPLES, false))
    }

    /// Sampling errors of the patterns.
    pub(super) fn sampling(&self, bench: &TradeoffBench<'_>) -> Vec<(Positions, Option<Difference>)> {
        let error = |codes: &Image8| self.best().and_then(|best| bench.compare(best, codes));
        self.by_positions.iter().map(|(positions, codes)| (*positions, error(codes))).collect()
    }

    /// Errors of a picture. A picture that follows rays further than its reference has no error of truncation.
    pub(super) fn errors(
        &self,
        bench: &TradeoffBench<'_>,
        settings: Settings,
        picture: &Image8,
        sampling: &[(Positions, Option<Difference>)],
    ) -> Errors {
        let own = self.reach.settings;
        let is_further = settings.max_depth > own.max_depth || settings.min_weight < own.min_weight;
        let comparable = settings.max_codes.is_some() || own.max_codes.is_some() || !is_further;
        let positions = settings.positions();
        Errors {
            truncation: self.of(positions).filter(|_| comparable).and_then(|same| bench.compare(same, picture)),
            sampling: sampling.iter().find(|(known, _)| *known == positions).and_then(|(_, error)| *error),
            total: self.best().and_then(|best| bench.compare(best, picture)),
        }
    }

    pub(super) fn thumbnails(&self, settings: Settings, picture: &Image8) -> Thumbnails {
        Thumbnails {
            picture: picture.thumbnail(),
            truncation: self.of(settings.positions()).map(|same| picture.difference(same)),
            total: self.best().map(|best| picture.difference(best)),
        }
    }
}
