//! The samples of one pixel alone: those that it has in a picture, whatever mode that is in.

use super::adaptive_sampling::runs;
use super::sample_sums::{PixelMean, PixelSums, SampleSums, trace_samples};
use super::statistical_sampling::batches;
use crate::lanes::Lanes;
use crate::scene::Scene;
use crate::scene::world::Pruning;
use crate::trace::counts::LaneCounts;
use crate::trace::hits::Hits;
use crate::trace::kernel::Tracer;
use crate::trace::observer::Observer;
use crate::trace::pixel::Samples;
use crate::trace::variants::Variant;

/// How the samples of a pixel belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Grouping {
    /// All of them.
    Whole,
    /// In the runs of sampling by doubling.
    Runs,
    /// In the batches of the statistical mode.
    Batches,
}

impl Grouping {
    /// That of a scene's picture.
    pub(crate) fn of(scene: &Scene) -> Self {
        match scene {
            Scene { statistical: Some(_), .. } => Self::Batches,
            Scene { adaptive: true, .. } => Self::Runs,
            _ => Self::Whole,
        }
    }

    fn parts(self, count: u32) -> Vec<Samples> {
        match self {
            Self::Whole => vec![Samples::of_picture(count)],
            Self::Runs => runs(count).collect(),
            Self::Batches => batches(count).collect(),
        }
    }
}

/// Traces the samples of one pixel, which it has in a picture.
pub(crate) fn trace_pixel_samples<L: Lanes, O: Observer<L>, V: Variant>(
    tracer: &mut Tracer<'_, L, O, V>,
    at: [u32; 2],
    count: u32,
    mut grouping: Grouping,
    hits: &mut Hits<L>,
) -> PixelMean {
    loop {
        let mut all = PixelSums::default();
        if O::WATCHING {
            tracer.observer().pixel();
        }
        for samples in grouping.parts(count) {
            let mut sums = SampleSums::new(samples, tracer.is_transparent());
            trace_samples(tracer, &[at], hits, &mut sums, &mut LaneCounts::default());
            all.append(&sums.pixel(0));
        }
        match tracer.pruning {
            // Runs are proved, each for itself, but not their mean.
            Pruning::Proved { max_codes }
                if grouping == Grouping::Runs
                    && all.is_unproved(tracer.display(), tracer.is_transparent(), max_codes) =>
            {
                grouping = Grouping::Whole;
            }
            _ => return all.mean(),
        }
    }
}
