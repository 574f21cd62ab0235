//! Times of rays by kind, from blocks of pixels that were timed as a whole, since a timer for each ray would take longer than
//! the ray.

use crate::trace::counts::RayCounts;

/// Kinds of rays, by the names of [`RayCounts`].
pub const KINDS: [&str; 5] = ["camera", "shadow", "reflected", "transmitted", "gathered"];

/// Counts in the order of [`KINDS`].
pub fn by_kind(rays: &RayCounts) -> [f64; KINDS.len()] {
    [rays.camera, rays.shadow, rays.reflected, rays.transmitted, rays.gathered].map(|n| n as f64)
}

/// Nanoseconds that rays take on one thread, shading included.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RayTimes {
    /// In the order of [`KINDS`].
    pub nanoseconds: [f64; KINDS.len()],
}

/// Weight of the prior that all rays take the same time.
const PRIOR: f64 = 0.01;
/// Rounds of descent. Few unknowns need few.
const ROUNDS: usize = 100;
/// A block whose rays took this many times as long as those of most blocks was interrupted.
const INTERRUPTED: f64 = 4.0;

impl RayTimes {
    /// Fits times of the kinds to blocks' counts and nanoseconds: least squares with a weak prior, since kinds that always
    /// come together cannot be told apart, no time below a tenth of the mean, and all of the time accounted for.
    pub fn fit(blocks: &[(RayCounts, f64)]) -> Self {
        let mut paces: Vec<f64> = blocks.iter().map(|(rays, time)| time / rays.total().max(1) as f64).collect();
        paces.sort_unstable_by(f64::total_cmp);
        let Some(median) = paces.get(paces.len() / 2) else { return Self::default() };
        let blocks: Vec<([f64; KINDS.len()], f64)> = blocks
            .iter()
            .map(|(rays, time)| (by_kind(rays), time.min(INTERRUPTED * median * rays.total().max(1) as f64)))
            .collect();
        let rays: f64 = blocks.iter().flat_map(|(counts, _)| counts).sum();
        let time: f64 = blocks.iter().map(|(_, time)| time).sum();
        let mean = time / rays.max(1.0);
        // Normal equations, solved by descent along one kind after the other.
        let (mut counts_by_counts, mut counts_by_time) = ([[0.0; KINDS.len()]; KINDS.len()], [0.0; KINDS.len()]);
        for (counts, time) in &blocks {
            for (i, row) in counts_by_counts.iter_mut().enumerate() {
                counts_by_time[i] += counts[i] * time;
                row.iter_mut().zip(counts).for_each(|(sum, n)| *sum += counts[i] * n);
            }
        }
        let mut fitted = [mean; KINDS.len()];
        for _ in 0..ROUNDS {
            for (i, row) in counts_by_counts.iter().enumerate().filter(|(i, row)| row[*i] > 0.0) {
                let others: f64 = (0..KINDS.len()).filter(|k| *k != i).map(|k| row[k] * fitted[k]).sum();
                let wanted = (counts_by_time[i] - others + PRIOR * row[i] * mean) / (row[i] * (1.0 + PRIOR));
                fitted[i] = wanted.max(0.1 * mean);
            }
        }
        let accounted: f64 = blocks.iter().flat_map(|(counts, _)| counts.iter().zip(fitted)).map(|(n, t)| n * t).sum();
        let scale = if accounted > 0.0 { time / accounted } else { 1.0 };
        Self { nanoseconds: fitted.map(|t| t * scale) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_that_explain_every_block_are_found() {
        let truth = [50.0, 20.0, 90.0, 150.0, 70.0];
        let block = |i: u64| {
            let rays = RayCounts {
                camera: 16,
                shadow: i * 7 % 33,
                reflected: i * 5 % 17,
                transmitted: i * 11 % 23,
                gathered: i * 3 % 19,
                ..RayCounts::default()
            };
            (rays, by_kind(&rays).iter().zip(truth).map(|(n, t)| n * t).sum())
        };
        let blocks: Vec<(RayCounts, f64)> = (0..400).map(block).collect();
        let found = RayTimes::fit(&blocks).nanoseconds;
        let near = found.iter().zip(truth).all(|(a, b): (&f64, f64)| (a - b).abs() < 0.15 * b);
        assert!(near, "{found:?}");
    }

    #[test]
    fn kinds_that_come_together_share_their_time() {
        let rays = RayCounts { camera: 16, shadow: 16, ..RayCounts::default() };
        let found = RayTimes::fit(&[(rays, 3200.0); 10]).nanoseconds;
        assert!((found[0] - 100.0).abs() < 1.0 && (found[1] - 100.0).abs() < 1.0, "{found:?}");
    }
}
