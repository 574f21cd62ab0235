//! The pixels of a picture that miss light, because rays were omitted, each with its upper bound.

use rayon::prelude::*;

/// A pixel that may miss light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundedPixel {
    /// Its column and row in the whole picture.
    pub at: [u32; 2],
    /// Its upper bound: the sum of what was traced, and the most that the omitted rays could add.
    pub highest: [f32; 3],
    /// The least alpha that it may have, where the background is transparent.
    pub least_alpha: f32,
}

/// All such pixels of a picture, in no particular order. There may be as many as pixels, so they stay in the parts in
/// which the tiles found them.
#[derive(Debug, Clone, Default)]
pub struct BoundedPixels {
    parts: Vec<Vec<BoundedPixel>>,
}

impl BoundedPixels {
    /// How many.
    pub fn len(&self) -> usize {
        self.parts.iter().map(Vec::len).sum()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.parts.iter().all(Vec::is_empty)
    }

    /// One after the other.
    pub fn iter(&self) -> impl Iterator<Item = &BoundedPixel> {
        self.parts.iter().flatten()
    }

    /// Part by part, on all threads.
    pub(crate) fn par_parts(&self) -> impl ParallelIterator<Item = &Vec<BoundedPixel>> {
        self.parts.par_iter()
    }

    /// Adds a part.
    pub(crate) fn add(&mut self, part: Vec<BoundedPixel>) {
        if !part.is_empty() {
            self.parts.push(part);
        }
    }

    /// Adds those of another part of the picture.
    pub fn append(&mut self, other: Self) {
        self.parts.extend(other.parts);
    }

    /// Keeps some of them.
    pub(crate) fn retain(&mut self, keep: impl Fn(&BoundedPixel) -> bool + Sync) {
        self.parts.par_iter_mut().for_each(|part| part.retain(&keep));
    }
}

impl FromIterator<BoundedPixel> for BoundedPixels {
    fn from_iter<I: IntoIterator<Item = BoundedPixel>>(pixels: I) -> Self {
        let mut all = Self::default();
        all.add(pixels.into_iter().collect());
        all
    }
}
