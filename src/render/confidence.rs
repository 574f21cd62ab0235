//! Confidence: how far more samples would likely change a picture, estimated from its samples.

use super::statistical_sampling::Reached;
use serde::{Deserialize, Serialize};

/// The estimates from the samples of a picture.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Sampling {
    /// Histogram of the widths of the pixels' intervals.
    pub widths: Histogram,
    /// How many samples the pixels got, where each gets as many as it asks for.
    pub reached: Reached,
}

impl std::ops::AddAssign<&Self> for Sampling {
    fn add_assign(&mut self, other: &Self) {
        self.widths.add(&other.widths);
        self.reached = self.reached + other.reached;
    }
}

/// Counts of pixels by the width of their interval in 8-bit codes. Empty where there is no estimate: for pixels of one
/// sample that were not compared with their neighbours.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Histogram {
    pixels: Vec<u64>,
}

impl Histogram {
    pub(super) fn of(widths: &[u8]) -> Self {
        if widths.is_empty() {
            return Self::default();
        }
        let mut pixels = vec![0; 256];
        for width in widths {
            pixels[usize::from(*width)] += 1;
        }
        Self { pixels }
    }

    fn add(&mut self, other: &Self) {
        self.pixels.resize(self.pixels.len().max(other.pixels.len()), 0);
        for (sum, more) in self.pixels.iter_mut().zip(&other.pixels) {
            *sum += more;
        }
    }

    /// Pixels in it.
    pub fn pixels(&self) -> u64 {
        self.pixels.iter().sum()
    }

    /// The quantile: the least width in codes that a share of the pixels does not exceed; none if there are no pixels.
    pub fn at_share(&self, share: f64) -> Option<u8> {
        let wanted = self.pixels() as f64 * share;
        let mut seen = 0;
        let reaches = |count: &u64| {
            seen += count;
            seen > 0 && seen as f64 >= wanted
        };
        self.pixels.iter().position(reaches).map(|width| width as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_pixels_have_their_widths() {
        assert_eq!(Histogram::default().at_share(0.95), None);
        let mut histogram = Histogram::of(&[3; 95]);
        histogram.add(&Histogram::of(&[9; 5]));
        assert_eq!((histogram.pixels(), histogram.at_share(0.95), histogram.at_share(0.96)), (100, Some(3), Some(9)));
        assert_eq!((histogram.at_share(0.0), histogram.at_share(1.0)), (Some(3), Some(9)));
    }
}
