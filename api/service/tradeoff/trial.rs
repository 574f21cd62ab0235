//! The trial: all settings once on a small picture, as a warm-up and to choose the size of the picture and the depth of the
//! references.

use super::references::{positions, reference};
use super::stage::Stage;
use super::{ENDS, ROUNDS};
use crate::service::clock::milliseconds;
use std::time::Instant;
use strahl::metrics::Image8;
use strahl::render::Cancelled;
use strahl::tradeoff::Finer;
use strahl::tradeoff::sweep::{Point, Settings};

/// Pixels of the small picture.
const TRIAL_PIXELS: f64 = 2304.0;
/// Most pixels of the compared pictures.
const MOST_PIXELS: f64 = 1_048_576.0;
/// Share of the time that is planned for.
const PLANNED: f64 = 0.8;
/// Depth of references, unless the scene asks for more.
const DEPTH: u32 = 1000;
/// Weights below which references do not follow rays. The smallest that there is time for is taken, and one more is tried.
const WEIGHTS: [f64; 6] = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 0.0];
/// The smallest weight of the points. References go further if they can.
const FINEST: f64 = 1e-5;

/// What the small picture has told.
pub(super) struct Trial {
    pixels: f64,
    /// Seconds of one round, of comparing two pictures, and of all references.
    round: f64,
    comparison: f64,
    references: f64,
    /// Depth and weight of the references.
    pub(super) recursion: (u32, f64),
    /// What following lighter rays than those of the references changes.
    pub(super) finer: Option<Finer>,
}

impl Trial {
    pub(super) fn run(stage: &mut Stage<'_>, points: &[Point], asked: Settings) -> Result<Self, Cancelled> {
        let size = scaled([stage.single.width, stage.single.height], TRIAL_PIXELS);
        let pixels = f64::from(size[0]) * f64::from(size[1]);
        stage.resize(size);
        let mut trial = Self {
            pixels,
            round: 0.0,
            comparison: 0.0,
            references: 0.0,
            recursion: (DEPTH.max(asked.max_depth), WEIGHTS[0].min(asked.min_weight)),
            finer: None,
        };
        for point in points {
            // The other half of this part is for the references, without which no error is known.
            if let Some(picture) = stage.shoot(point.settings, 0.5 * ENDS[0])? {
                trial.round += picture.trace_ms / 1e3;
                if trial.comparison == 0.0 {
                    let codes = Image8::from(&picture.film);
                    let begun = Instant::now();
                    stage.compare(&codes, &codes);
                    trial.comparison = milliseconds(begun) / 1e3;
                }
            }
        }
        let samples: f64 =
            positions(points).iter().map(|&(n, smooth)| f64::from(n) + if smooth { 5.0 } else { 0.0 }).sum();
        // One after the other: weight, picture, seconds of all references.
        let mut steps: Vec<(f64, Image8, f64)> = Vec::new();
        let mut patience = f64::INFINITY;
        for min_weight in WEIGHTS.map(|weight| weight.min(asked.min_weight)) {
            if steps.last().is_some_and(|(before, ..)| *before == min_weight) {
                continue;
            }
            let end = ENDS[0].min((stage.elapsed() + patience) / stage.seconds);
            let settings = reference((trial.recursion.0, min_weight), (1, false));
            let Some(picture) = stage.shoot(settings, end)? else { break };
            let one = picture.trace_ms / 1e3;
            patience = 20.0 * one + 0.05;
            steps.push((min_weight, Image8::from(&picture.film), samples * one));
            // Better references leave time for smaller pictures only, so beyond the weights of the points they take at most as
            // long as two rounds. One more is tried, but not used.
            if min_weight < FINEST && samples * one > 2.0 * trial.round {
                break;
            }
        }
        // The last step says what following still lighter rays would change, unless there is nothing lighter.
        let beyond = steps.last().filter(|(weight, ..)| *weight > 0.0 && steps.len() > 1).cloned();
        if beyond.is_some() {
            steps.pop();
        }
        if let Some((weight, codes, all)) = steps.last() {
            (trial.recursion.1, trial.references) = (*weight, *all);
            trial.finer =
                beyond.map(|(min_weight, finer, _)| Finer { min_weight, max_codes: largest_difference(codes, &finer) });
        }
        Ok(trial)
    }

    /// The size of the pictures that there is time for, at most as asked.
    pub(super) fn size_for(&self, stage: &Stage<'_>, asked: [u32; 2], points: usize) -> [u32; 2] {
        let planned = ROUNDS[0] as f64 * self.round + self.references + 2.0 * points as f64 * self.comparison;
        let pixels = self.pixels * stage.left(PLANNED) / planned.max(1e-9);
        scaled(asked, pixels.clamp(self.pixels, MOST_PIXELS))
    }
}

/// A size of the same shape with about `pixels` pixels, but no larger than it was.
fn scaled([width, height]: [u32; 2], pixels: f64) -> [u32; 2] {
    let factor = (pixels / (f64::from(width) * f64::from(height))).sqrt().min(1.0);
    [width, height].map(|side| ((f64::from(side) * factor).round() as u32).max(1))
}

fn largest_difference(a: &Image8, b: &Image8) -> u8 {
    a.pixels.as_flattened().iter().zip(b.pixels.as_flattened()).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_keep_their_shape_and_never_grow() {
        assert_eq!(scaled([640, 400], 64_000.0), [320, 200]);
        assert_eq!(scaled([40, 30], 1e6), [40, 30]);
        assert_eq!(scaled([16_384, 1], 100.0), [1280, 1]);
    }
}
