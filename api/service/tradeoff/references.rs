//! The reference pictures.

use super::ENDS;
use super::stage::Stage;
use strahl::metrics::Difference;
use strahl::metrics::Image8;
use strahl::render::Cancelled;
use strahl::scene::description::Precision;
use strahl::tradeoff::Errors;
use strahl::tradeoff::page::Thumbnails;
use strahl::tradeoff::sweep::{Point, REFERENCE_SAMPLES, Settings};

/// All sampling patterns of some points, the fewest samples first.
pub(super) fn positions(points: &[Point]) -> Vec<(u32, bool)> {
    let mut all: Vec<_> = points.iter().map(|point| point.settings.positions()).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The settings of a reference.
pub(super) fn reference((max_depth, min_weight): (u32, f64), (samples, antialias): (u32, bool)) -> Settings {
    Settings { max_depth, min_weight, max_codes: None, samples, antialias, precision: Precision::Double }
}

/// Pictures in double precision with recursion as deep as possible, one for each sampling pattern.
pub(super) struct References {
    /// Their depth and weight.
    recursion: (u32, f64),
    by_positions: Vec<((u32, bool), Image8)>,
    /// Sampling error of each of them.
    sampling: Vec<Option<Difference>>,
}

impl References {
    /// Traces as many as there is time for, and counts the rays that were dropped.
    pub(super) fn trace(
        stage: &mut Stage<'_>,
        points: &[Point],
        recursion: (u32, f64),
    ) -> Result<(Self, u64), Cancelled> {
        let (mut by_positions, mut dropped) = (Vec::new(), 0);
        for positions in positions(points) {
            if let Some(picture) = stage.shoot(reference(recursion, positions), ENDS[1])? {
                dropped += picture.rays.dropped;
                by_positions.push((positions, Image8::from(&picture.film)));
            }
        }
        let mut references = Self { recursion, by_positions, sampling: Vec::new() };
        let sampling = |(_, codes): &(_, Image8)| references.best().and_then(|best| stage.compare(best, codes));
        references.sampling = references.by_positions.iter().map(sampling).collect();
        Ok((references, dropped))
    }

    fn place(&self, positions: (u32, bool)) -> Option<usize> {
        self.by_positions.iter().position(|(known, _)| *known == positions)
    }

    fn same(&self, settings: Settings) -> Option<&Image8> {
        self.place(settings.positions()).map(|i| &self.by_positions[i].1)
    }

    fn best(&self) -> Option<&Image8> {
        self.place((REFERENCE_SAMPLES, false)).map(|i| &self.by_positions[i].1)
    }

    /// Errors of a picture. A picture that follows rays further than its reference has no error of truncation.
    pub(super) fn errors(&self, stage: &Stage<'_>, settings: Settings, picture: &Image8) -> Errors {
        let (depth, weight) = self.recursion;
        let comparable = settings.max_codes.is_some() || settings.max_depth <= depth && settings.min_weight >= weight;
        Errors {
            truncation: self.same(settings).filter(|_| comparable).and_then(|same| stage.compare(same, picture)),
            sampling: self.place(settings.positions()).and_then(|i| self.sampling[i]),
            total: self.best().and_then(|best| stage.compare(best, picture)),
        }
    }

    pub(super) fn thumbnails(&self, settings: Settings, picture: &Image8) -> Thumbnails {
        Thumbnails {
            picture: picture.thumbnail(),
            truncation: self.same(settings).map(|same| picture.difference(same)),
            total: self.best().map(|best| picture.difference(best)),
        }
    }
}
