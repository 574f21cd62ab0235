//! Pictures of 8-bit codes, which metrics compare.

use crate::film::{Film, srgb};
use crate::math::srgb_to_linear;
use std::borrow::Cow;

/// sRGB codes of a picture, row by row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image8 {
    /// Pixels across.
    pub width: usize,
    /// Red, green and blue; over black where there is alpha.
    pub pixels: Vec<[u8; 3]>,
    /// Alpha of each pixel, or nothing: then all are opaque.
    pub alpha: Vec<u8>,
}

impl Image8 {
    /// A picture without alpha.
    pub fn opaque(width: usize, pixels: Vec<[u8; 3]>) -> Self {
        Self { width, pixels, alpha: Vec::new() }
    }

    /// From codes that are not multiplied by their alpha, as files have them.
    pub fn straight(width: usize, pixels: &[[u8; 4]]) -> Self {
        let codes = srgb::Codes8::get();
        let table = light_of_codes();
        let over = |[r, g, b, alpha]: &[u8; 4]| match alpha {
            255 => [*r, *g, *b],
            alpha => [r, g, b].map(|code| codes.code(table[usize::from(*code)] * f32::from(*alpha) / 255.0)),
        };
        let is_opaque = pixels.iter().all(|pixel| pixel[3] == 255);
        let alpha = if is_opaque { Vec::new() } else { pixels.iter().map(|pixel| pixel[3]).collect() };
        Self { width, pixels: pixels.iter().map(over).collect(), alpha }
    }

    /// Pixels down.
    pub fn height(&self) -> usize {
        self.pixels.len().checked_div(self.width).unwrap_or(0)
    }

    /// Alpha of a pixel.
    pub fn alpha_at(&self, pixel: usize) -> u8 {
        self.alpha.get(pixel).copied().unwrap_or(255)
    }

    /// By how many codes each pixel is off that of another picture of one size, channel by channel: each by at least as much as alpha.
    pub fn differences(&self, other: &Self) -> Vec<[u8; 3]> {
        let off = |i: usize| {
            let of_alpha = self.alpha_at(i).abs_diff(other.alpha_at(i));
            [0, 1, 2].map(|c| self.pixels[i][c].abs_diff(other.pixels[i][c]).max(of_alpha))
        };
        (0..self.pixels.len().min(other.pixels.len())).map(off).collect()
    }

    /// The picture over white.
    pub fn over_white(&self) -> Cow<'_, Self> {
        if self.alpha.is_empty() {
            return Cow::Borrowed(self);
        }
        let codes = srgb::Codes8::get();
        let table = light_of_codes();
        let over = |(pixel, alpha): (&[u8; 3], &u8)| {
            let passed = 1.0 - f32::from(*alpha) / 255.0;
            pixel.map(|code| codes.code((table[usize::from(code)] + passed).min(1.0)))
        };
        Cow::Owned(Self::opaque(self.width, self.pixels.iter().zip(&self.alpha).map(over).collect()))
    }
}

/// Linear light of each code.
fn light_of_codes() -> [f32; 256] {
    std::array::from_fn(|code| srgb_to_linear(code as f64 / 255.0) as f32)
}

/// Errors of pixels by a metric that sees no alpha: the larger of those over black and over white.
pub(super) fn over_both(a: &Image8, b: &Image8, metric: impl Fn(&Image8, &Image8) -> Vec<f64>) -> Vec<f64> {
    let mut errors = metric(a, b);
    if !(a.alpha.is_empty() && b.alpha.is_empty()) {
        let over_white = metric(&a.over_white(), &b.over_white());
        errors.iter_mut().zip(over_white).for_each(|(error, other)| *error = error.max(other));
    }
    errors
}

impl From<&Film> for Image8 {
    fn from(film: &Film) -> Self {
        let mut pixels = vec![[0; 3]; film.pixels.len()];
        srgb::Codes8::get().codes(film.shown().as_flattened(), pixels.as_flattened_mut());
        let alpha = film.codes_of_alpha();
        Self { width: film.region.width as usize, pixels, alpha }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_glass_is_seen_over_white() {
        let [half, clear] = [[0, 0, 0, 128], [0, 0, 0, 0]].map(|pixel| Image8::straight(1, &[pixel]));
        assert_eq!(half.pixels, clear.pixels);
        assert_eq!((half.alpha_at(0), clear.alpha_at(0)), (128, 0));
        assert_eq!(clear.over_white().pixels, [[255; 3]]);
        // Half of the light of white.
        assert_eq!(half.over_white().pixels, [[187; 3]]);
        let differ = |a: &Image8, b: &Image8| vec![f64::from(a.pixels[0][0].abs_diff(b.pixels[0][0]))];
        assert_eq!(over_both(&half, &clear, differ), [68.0]);
        assert_eq!(Image8::straight(1, &[[9, 8, 7, 255]]), Image8::opaque(1, vec![[9, 8, 7]]));
    }
}
