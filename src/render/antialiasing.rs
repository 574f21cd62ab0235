//! Antialiasing: pixels that differ from a neighbour get more samples, the more they differ.
//!
//! Along an edge between two colors, r codes apart, the mean of n evenly spread samples is off by about r n^-3/4. So the same
//! number of samples for all would leave most error where contrast is high, and waste samples where it is low.

use super::contrast::CONTRAST;
use super::packets::{KernelFormat, Traced};
use super::renderer::Renderer;
use crate::control::Cancelled;
use crate::scene::effects::REFINED_SAMPLES;

/// Samples of pixels with some contrast to a neighbour, and the contrast from which on pixels get more. With these numbers the
/// pictures of the repository take the fewest samples for the same error.
const LEVELS: [(u32, u8); 3] = [(4, 24), (8, 40), (REFINED_SAMPLES, u8::MAX)];

/// A pixel that differs from a neighbour.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Uneven {
    pub(crate) at: [u32; 2],
    /// The largest difference from a neighbour, in codes.
    pub(crate) contrast: u8,
}

/// Samples of a pixel of such a contrast where all have `samples`.
pub(crate) fn refined_samples(contrast: u8, samples: u32) -> u32 {
    if contrast < CONTRAST {
        return samples;
    }
    let level = LEVELS.iter().find(|(refined, below)| *refined > samples && contrast < *below);
    level.map_or(REFINED_SAMPLES, |(refined, _)| *refined)
}

impl<R: KernelFormat> Renderer<'_, R> {
    /// Refines pixels. Results are in the order of the pixels.
    pub(super) fn refine(&self, pixels: &[Uneven]) -> Result<Traced, Cancelled> {
        let mut all = Traced { pixels: vec![[0.0; 3]; pixels.len()], ..Traced::default() };
        all.widths = vec![0; pixels.len()];
        all.alpha = vec![0.0; if self.job.world.transparent { pixels.len() } else { 0 }];
        for (samples, _) in LEVELS {
            let of_level = |index: &usize| refined_samples(pixels[*index].contrast, self.scene.samples) == samples;
            let indices: Vec<usize> = (0..pixels.len()).filter(of_level).collect();
            let at: Vec<[u32; 2]> = indices.iter().map(|index| pixels[*index].at).collect();
            let mut level = self.list(&at, samples)?;
            indices.iter().zip(level.widths.drain(..)).for_each(|(index, width)| all.widths[*index] = width);
            all.put(indices.iter().copied(), level);
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_contrast_is_more_samples() {
        for samples in 1..16 {
            assert_eq!(refined_samples(CONTRAST - 1, samples), samples);
            let each: Vec<u32> = (CONTRAST..=u8::MAX).map(|contrast| refined_samples(contrast, samples)).collect();
            assert!(each.is_sorted() && each[0] > samples && each.ends_with(&[REFINED_SAMPLES]), "{samples}: {each:?}");
        }
    }
}
