//! The proof of a picture: how far it is at most from the picture of recursion without end.

use super::{BoundedPixel, BoundedPixels};
use crate::film::Film;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

/// Why the proof of a pixel is given up.
pub const GIVEN_UP: &str = "glass and mirrors pass light on and on there and lose little of it, so too many rays would have to \
                            be followed. Materials that keep less, or `max_depth`, help";

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
    /// Pixels that may be off by more than 0, 1 and 2 codes.
    #[serde(skip)]
    pub beyond: [u64; 3],
}

/// A part of it.
#[derive(Clone, Copy, Default)]
struct Part {
    codes: u8,
    /// Pixels that may be off by more than 0, 1 and 2 codes.
    beyond: [u64; 3],
    linear: [f32; 3],
    worst: Option<(u8, f32, [u32; 2])>,
}

impl Proof {
    /// The proof of a picture, given the pixels that may lack light.
    pub fn of(film: &Film, bounded: &BoundedPixels) -> Self {
        let add = |part: Part, bounded: &BoundedPixel| part.add(film, bounded);
        let all =
            bounded.par_parts().map(|part| part.iter().fold(Part::default(), add)).reduce(Part::default, Part::and);
        Self {
            max_codes: all.codes,
            identical_fraction: 1.0 - all.beyond[0] as f64 / film.pixels.len() as f64,
            max_linear: all.linear.iter().all(|c| c.is_finite()).then_some(all.linear),
            worst_pixel: all.worst.map(|(.., at)| at),
            beyond: all.beyond,
        }
    }
}

impl Part {
    fn add(self, film: &Film, bounded: &BoundedPixel) -> Self {
        let (index, highest) = (film.region.index(bounded.at), bounded.highest);
        let shown = film.pixels[index];
        let codes = film.codes_off(index, highest, bounded.least_alpha).into_iter().fold(0, u8::max);
        let linear: [f32; 3] = std::array::from_fn(|c| (highest[c] - shown[c]).max(0.0));
        let most = linear.into_iter().fold(0.0, f32::max);
        self.and(Self {
            codes,
            beyond: [0, 1, 2].map(|most| u64::from(codes > most)),
            linear,
            worst: Some((codes, most, bounded.at)),
        })
    }

    fn and(self, other: Self) -> Self {
        Self {
            codes: self.codes.max(other.codes),
            beyond: std::array::from_fn(|most| self.beyond[most] + other.beyond[most]),
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
