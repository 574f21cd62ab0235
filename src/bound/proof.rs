//! The proof of a picture: how far it is at most from the picture of recursion without end.

use super::{BoundedPixel, BoundedPixels};
use crate::film::Film;
use crate::film::srgb::Codes8;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

/// Bounds on what ending the recursion has changed, for the same samples; rounding of the sums is in them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Proof {
    /// Most 8-bit codes that any channel of any pixel is off.
    pub max_codes: u8,
    /// Share of pixels that are the same in an 8-bit PNG.
    pub identical_fraction: f64,
    /// Most linear light that each channel of any pixel lacks; none where nothing bounds it.
    pub max_linear: Option<[f32; 3]>,
    /// Column and row of the pixel that may be off by most codes, and of those by most light; none if none is off.
    pub worst_pixel: Option<[u32; 2]>,
}

/// A part of it.
#[derive(Clone, Copy, Default)]
struct Part {
    codes: u8,
    /// Pixels that are not proved to be the same.
    open: u64,
    linear: [f32; 3],
    worst: Option<(u8, f32, [u32; 2])>,
}

impl Proof {
    /// The proof of a picture, given the pixels that may lack light.
    pub fn of(film: &Film, bounded: &BoundedPixels) -> Self {
        let Film { region, pixels, .. } = film;
        let add = |part: Part, bounded: &BoundedPixel| part.add(pixels[region.index(bounded.at)], bounded);
        let all =
            bounded.par_parts().map(|part| part.iter().fold(Part::default(), add)).reduce(Part::default, Part::and);
        Self {
            max_codes: all.codes,
            identical_fraction: 1.0 - all.open as f64 / pixels.len() as f64,
            max_linear: all.linear.iter().all(|c| c.is_finite()).then_some(all.linear),
            worst_pixel: all.worst.map(|(.., at)| at),
        }
    }
}

impl Part {
    fn add(self, shown: [f32; 3], bounded: &BoundedPixel) -> Self {
        let (table, highest) = (Codes8::get(), bounded.highest);
        let codes = (0..3).map(|c| table.code(highest[c]).saturating_sub(table.code(shown[c]))).fold(0, u8::max);
        let linear: [f32; 3] = std::array::from_fn(|c| (highest[c] - shown[c]).max(0.0));
        let most = linear.into_iter().fold(0.0, f32::max);
        self.and(Self { codes, open: u64::from(codes > 0), linear, worst: Some((codes, most, bounded.at)) })
    }

    fn and(self, other: Self) -> Self {
        Self {
            codes: self.codes.max(other.codes),
            open: self.open + other.open,
            linear: std::array::from_fn(|c| self.linear[c].max(other.linear[c])),
            worst: worse(self.worst, other.worst),
        }
    }
}

/// The worse of two pixels. Of equal ones it is the upper left one, so the order of threads does not matter.
fn worse(a: Option<(u8, f32, [u32; 2])>, b: Option<(u8, f32, [u32; 2])>) -> Option<(u8, f32, [u32; 2])> {
    let (Some((codes, most, [x, y])), Some((other_codes, other_most, [other_x, other_y]))) = (a, b) else {
        return a.or(b);
    };
    let order = other_codes.cmp(&codes).then(other_most.total_cmp(&most)).then((y, x).cmp(&(other_y, other_x)));
    if order.is_gt() { b } else { a }
}
