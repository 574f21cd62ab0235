//! One trilinear lookup in a mipmap, for one lane: between the two nearest levels, bilinear in each.

use super::lookup::{Sampler, Wrap};
use super::mipmap::{Level, Mipmap, Texels, decoded};

impl Mipmap {
    /// One lookup for one lane; the fourth channel is nothing.
    #[inline(always)]
    pub(super) fn trilinear(&self, uv: [f64; 2], level: f64, sampler: Sampler) -> [f64; 4] {
        let whole = level.floor();
        let below = (whole as usize).min(self.levels.len() - 1);
        let part = level - whole;
        let fine = self.bilinear(below, uv, Sampler { nearest: sampler.nearest && level == 0.0, ..sampler });
        if below + 1 < self.levels.len() && part > 0.0 {
            mix(fine, self.bilinear(below + 1, uv, sampler.wrap.into()), part)
        } else {
            fine
        }
    }

    #[inline(always)]
    fn bilinear(&self, level: usize, [u, v]: [f64; 2], Sampler { wrap, nearest }: Sampler) -> [f64; 4] {
        let Level { width, height, .. } = self.levels[level];
        let (left, right, across) = neighbours(u, width, wrap[0]);
        let (upper, lower, down) = neighbours(1.0 - v, height, wrap[1]);
        let (across, down) = if nearest { (side(across), side(down)) } else { (across, down) };
        let Level { texels, .. } = &self.levels[level];
        // Each kind to its end, or the kernel waits for texels on the stack.
        match texels {
            Texels::Numbers(texels) => {
                let at = |x: usize, y: usize| wide(texels[y * width + x]);
                let above = mix(at(left, upper), at(right, upper), across);
                mix(above, mix(at(left, lower), at(right, lower), across), down)
            }
            Texels::Codes(codes, values) => {
                let (codes, _) = codes.as_chunks();
                let at = |x: usize, y: usize| wide(decoded(codes[y * width + x], values));
                let above = mix(at(left, upper), at(right, upper), across);
                mix(above, mix(at(left, lower), at(right, lower), across), down)
            }
        }
    }
}

#[inline(always)]
fn wide([r, g, b]: [f32; 3]) -> [f64; 4] {
    [f64::from(r), f64::from(g), f64::from(b), 0.0]
}

/// The two texels whose centres enclose a place in a row, 0 to 1, and how far it lies from the first to the second.
#[inline(always)]
fn neighbours(place: f64, count: usize, wrap: Wrap) -> (usize, usize, f64) {
    let inside = match wrap {
        Wrap::Repeat => place - place.floor(),
        Wrap::Clamp => place.clamp(0.0, 1.0),
        // From 0 to 1 and back; no number is 0.
        Wrap::Mirror => (1.0 - (place - 2.0 * (place * 0.5).floor() - 1.0).abs()).max(0.0),
    };
    let x = inside * count as f64 - 0.5;
    let first = x.floor();
    // From -1 to the last one.
    let (below, last) = (first as i32, count as i32 - 1);
    let (left, right) = match wrap {
        Wrap::Repeat => (if below < 0 { last } else { below }, if below < last { below + 1 } else { 0 }),
        // Beyond an edge its mirror image begins with the same texel.
        Wrap::Clamp | Wrap::Mirror => (below.max(0), (below + 1).min(last)),
    };
    (left as usize, right as usize, x - first)
}

/// The nearer end of a way: 0 or 1.
#[inline(always)]
fn side(part: f64) -> f64 {
    if part < 0.5 { 0.0 } else { 1.0 }
}

/// From `a` to `b`.
#[inline(always)]
fn mix(a: [f64; 4], b: [f64; 4], part: f64) -> [f64; 4] {
    let mut mixed = [0.0; 4];
    for i in 0..4 {
        mixed[i] = a[i] * (1.0 - part) + b[i] * part;
    }
    mixed
}
