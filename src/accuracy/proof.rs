//! What is proved about a picture: how far recursion without end could be from it.

use crate::film::Region;
use crate::film::srgb::Codes8;
use crate::render::Picture;
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

/// One row's part of it.
#[derive(Clone, Copy, Default)]
struct Row {
    codes: u8,
    identical: u64,
    linear: [f32; 3],
    worst: Option<(u8, f32, [u32; 2])>,
}

impl Proof {
    /// The proof of a picture; each pixel says itself what it may be at most.
    pub fn of(picture: &Picture) -> Self {
        let Region { x, y, width, .. } = picture.film.region;
        let width = width as usize;
        let rows = picture.film.pixels.par_chunks(width).zip(picture.highest.par_chunks(width)).enumerate();
        let all = rows
            .map(|(row, (shown, highest))| {
                let mut all = Row::default();
                for (column, (shown, highest)) in shown.iter().zip(highest).enumerate() {
                    all.add([x + column as u32, y + row as u32], *shown, *highest);
                }
                all
            })
            .reduce(Row::default, Row::and);
        Self {
            max_codes: all.codes,
            identical_fraction: all.identical as f64 / picture.film.pixels.len() as f64,
            max_linear: all.linear.iter().all(|c| c.is_finite()).then_some(all.linear),
            worst_pixel: all.worst.map(|(.., at)| at),
        }
    }
}

impl Row {
    fn add(&mut self, at: [u32; 2], shown: [f32; 3], highest: [f32; 3]) {
        if shown == highest {
            self.identical += 1;
            return;
        }
        let table = Codes8::get();
        let mut codes = 0;
        let mut most: f32 = 0.0;
        for c in 0..3 {
            codes = codes.max(table.code(highest[c]).saturating_sub(table.code(shown[c])));
            let linear = (highest[c] - shown[c]).max(0.0);
            self.linear[c] = self.linear[c].max(linear);
            most = most.max(linear);
        }
        self.identical += u64::from(codes == 0);
        self.codes = self.codes.max(codes);
        self.worst = worse(self.worst, Some((codes, most, at)));
    }

    fn and(self, other: Self) -> Self {
        Self {
            codes: self.codes.max(other.codes),
            identical: self.identical + other.identical,
            linear: std::array::from_fn(|c| self.linear[c].max(other.linear[c])),
            worst: worse(self.worst, other.worst),
        }
    }
}

/// The worse of two pixels; of equal ones that further up and left, whatever thread it comes from.
fn worse(a: Option<(u8, f32, [u32; 2])>, b: Option<(u8, f32, [u32; 2])>) -> Option<(u8, f32, [u32; 2])> {
    let (Some((codes, most, [x, y])), Some((other_codes, other_most, [other_x, other_y]))) = (a, b) else {
        return a.or(b);
    };
    let order = other_codes.cmp(&codes).then(other_most.total_cmp(&most)).then((y, x).cmp(&(other_y, other_x)));
    if order.is_gt() { b } else { a }
}
