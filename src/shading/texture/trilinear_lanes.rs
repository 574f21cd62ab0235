//! Trilinear lookups of many lanes in a mipmap at once: between the two nearest levels of each lane, bilinear in each.
//!
//! Only the texels are fetched lane by lane, since lanes need others. The slow twin is `trilinear.rs`.

use super::lookup::{Sampler, Wrap};
use super::mipmap::{Level, Mipmap, Texels, decoded};
use crate::lanes::{Double, MAX_LANES, Mask, V3, lanes_of};

/// The levels in which lanes look up texels.
pub(super) struct TrilinearLanes<'a, W: Double> {
    mipmap: &'a Mipmap,
    wrap: [Wrap; 2],
    fine: Levels<W>,
    coarse: Levels<W>,
    /// The way from the fine level to the coarse one.
    part: W,
    /// Lanes between two levels.
    between: u32,
    /// Lanes whose texels are squares.
    squares: W::Mask,
}

/// A level for each lane, and its size.
struct Levels<W> {
    index: [usize; MAX_LANES],
    width: W,
    height: W,
}

impl<'a, W: Double> TrilinearLanes<'a, W> {
    /// `level` is between 0 and the last.
    #[inline(always)]
    pub(super) fn new(
        s: W::Simd,
        mipmap: &'a Mipmap,
        level: W,
        Sampler { wrap, nearest }: Sampler,
        lanes: u32,
    ) -> Self {
        let (zero, whole) = (W::lit(s, 0.0), level.floor());
        let part = level - whole;
        let last = mipmap.levels.len() - 1;
        let (mut fine, mut coarse) = ([0; MAX_LANES], [0; MAX_LANES]);
        let mut has_next = 0;
        for lane in lanes_of(lanes) {
            fine[lane] = (whole.lane(lane) as usize).min(last);
            coarse[lane] = (fine[lane] + 1).min(last);
            has_next |= u32::from(coarse[lane] > fine[lane]) << lane;
        }
        let squares = W::mask(s, if nearest { lanes } else { 0 }) & level.eq(zero);
        let between = part.gt(zero).bits() & has_next;
        let (fine, coarse) = (Levels::new(s, mipmap, fine, lanes), Levels::new(s, mipmap, coarse, between));
        Self { mipmap, wrap, fine, coarse, part, between, squares }
    }

    /// What some lanes see at (u, v); the others see nothing.
    #[inline(always)]
    pub(super) fn at(&self, s: W::Simd, uv: [W; 2], lanes: u32) -> V3<W> {
        let zero = W::lit(s, 0.0);
        let fine = self.bilinear(s, &self.fine, uv, self.squares, lanes);
        let between = self.between & lanes;
        let seen = if between == 0 {
            fine
        } else {
            let coarse = self.bilinear(s, &self.coarse, uv, W::mask(s, 0), between);
            V3::select(W::mask(s, between), mix(s, fine, coarse, self.part), fine)
        };
        V3::select(W::mask(s, lanes), seen, V3 { x: zero, y: zero, z: zero })
    }

    /// The mean of as many lookups as `taps` says for each lane, side by side along `way`, whose middle is at (u, v).
    #[inline(always)]
    pub(super) fn mean(&self, s: W::Simd, [u, v]: [W; 2], way: [W; 2], taps: W, lanes: u32) -> V3<W> {
        let (zero, half) = (W::lit(s, 0.0), W::lit(s, 0.5));
        let mut sum = V3 { x: zero, y: zero, z: zero };
        let mut tap = zero;
        loop {
            let active = tap.lt(taps).bits() & lanes;
            if active == 0 {
                return sum;
            }
            let along = (tap + half) / taps - half;
            let V3 { x, y, z } = self.at(s, [u + way[0] * along, v + way[1] * along], active);
            let share = V3 { x: x / taps, y: y / taps, z: z / taps };
            // `taps` may be NaN in lanes that are not active.
            sum = V3::select(W::mask(s, active), sum + share, sum);
            tap = tap + W::lit(s, 1.0);
        }
    }

    #[inline(always)]
    fn bilinear(&self, s: W::Simd, levels: &Levels<W>, [u, v]: [W; 2], squares: W::Mask, lanes: u32) -> V3<W> {
        let [across, down] = [
            Neighbours::new(s, u, levels.width, self.wrap[0], squares),
            Neighbours::new(s, W::lit(s, 1.0) - v, levels.height, self.wrap[1], squares),
        ];
        let upper = down.first * levels.width;
        let lower = down.second * levels.width;
        let places = [
            (upper + across.first).indices(),
            (upper + across.second).indices(),
            (lower + across.first).indices(),
            (lower + across.second).indices(),
        ];
        // Loops, since closures would be compiled for other instructions.
        let mut texels = [[[0.0_f32; MAX_LANES]; 3]; 4];
        for lane in lanes_of(lanes) {
            match &self.mipmap.levels[levels.index[lane]].texels {
                Texels::Numbers(numbers) => {
                    for corner in 0..4 {
                        let [r, g, b] = numbers[places[corner][lane]];
                        let texel = &mut texels[corner];
                        (texel[0][lane], texel[1][lane], texel[2][lane]) = (r, g, b);
                    }
                }
                Texels::Codes(codes, values) => {
                    let (codes, _) = codes.as_chunks();
                    for corner in 0..4 {
                        let [r, g, b] = decoded(codes[places[corner][lane]], values);
                        let texel = &mut texels[corner];
                        (texel[0][lane], texel[1][lane], texel[2][lane]) = (r, g, b);
                    }
                }
            }
        }
        let above = mix(s, loaded(s, &texels[0]), loaded(s, &texels[1]), across.part);
        let below = mix(s, loaded(s, &texels[2]), loaded(s, &texels[3]), across.part);
        mix(s, above, below, down.part)
    }
}

impl<W: Double> Levels<W> {
    #[inline(always)]
    fn new(s: W::Simd, mipmap: &Mipmap, index: [usize; MAX_LANES], lanes: u32) -> Self {
        let (mut widths, mut heights) = ([1.0; MAX_LANES], [1.0; MAX_LANES]);
        for lane in lanes_of(lanes) {
            let Level { width, height, .. } = mipmap.levels[index[lane]];
            (widths[lane], heights[lane]) = (width as f64, height as f64);
        }
        Self { index, width: W::load(s, &widths), height: W::load(s, &heights) }
    }
}

/// The two texels whose centres enclose a place in a row, and how far it lies from the first to the second.
struct Neighbours<W> {
    first: W,
    second: W,
    part: W,
}

impl<W: Double> Neighbours<W> {
    /// For places from 0 to 1, in rows of `count` texels.
    #[inline(always)]
    fn new(s: W::Simd, place: W, count: W, wrap: Wrap, squares: W::Mask) -> Self {
        let lit = |x: f64| W::lit(s, x);
        let (zero, one) = (lit(0.0), lit(1.0));
        let inside = match wrap {
            Wrap::Repeat => place - place.floor(),
            // What is no number stays none.
            Wrap::Clamp => W::select(place.lt(zero), zero, W::select(place.gt(one), one, place)),
            // From 0 to 1 and back; no number is 0.
            Wrap::Mirror => (one - (place - lit(2.0) * (place * lit(0.5)).floor() - one).abs()).max(zero),
        };
        let x = inside * count - lit(0.5);
        let whole = x.floor();
        // From -1 to the last one; where there is no number, 0.
        let (below, last) = (W::select(whole.eq(whole), whole, zero), count - one);
        let (first, second) = match wrap {
            Wrap::Repeat => (W::select(below.lt(zero), last, below), W::select(below.lt(last), below + one, zero)),
            // Beyond an edge its mirror image begins with the same texel.
            Wrap::Clamp | Wrap::Mirror => (below.max(zero), (below + one).min(last)),
        };
        let part = x - whole;
        let side = W::select(part.lt(lit(0.5)), zero, one);
        Self { first, second, part: W::select(squares, side, part) }
    }
}

#[inline(always)]
fn loaded<W: Double>(s: W::Simd, texels: &[[f32; MAX_LANES]; 3]) -> V3<W> {
    let mut wide = [[0.0; MAX_LANES]; 3];
    for c in 0..3 {
        for lane in 0..MAX_LANES {
            wide[c][lane] = f64::from(texels[c][lane]);
        }
    }
    V3 { x: W::load(s, &wide[0]), y: W::load(s, &wide[1]), z: W::load(s, &wide[2]) }
}

/// From `a` to `b`.
#[inline(always)]
fn mix<W: Double>(s: W::Simd, a: V3<W>, b: V3<W>, part: W) -> V3<W> {
    a * (W::lit(s, 1.0) - part) + b * part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Lanes;
    use fearless_simd::{Level as Instructions, Simd, f64x8};
    use std::sync::Arc;

    const WRAPS: [[Wrap; 2]; 4] = [[Wrap::Repeat; 2], [Wrap::Clamp; 2], [Wrap::Mirror; 2], [Wrap::Clamp, Wrap::Repeat]];

    /// From 0 to 1.
    fn number(i: usize) -> f64 {
        (i * 7919 % 1009) as f64 / 1009.0
    }

    fn mipmaps() -> impl Iterator<Item = Arc<Mipmap>> {
        let values: [f32; 256] = std::array::from_fn(|code| number(code) as f32);
        [(1, 1), (2, 1), (5, 3), (16, 8), (33, 64)].into_iter().flat_map(move |(width, height)| {
            let count = width as usize * height as usize;
            let codes = (0..3 * count).map(|i| (i * i / 7 % 256) as u8).collect();
            let numbers = (0..count).map(|i| [i, 3 * i + 1, 5 * i + 2].map(|i| number(i) as f32)).collect();
            [Mipmap::of_codes(width, height, codes, values), Mipmap::new(width, height, numbers)].map(Arc::new)
        })
    }

    /// Places in the picture, at its edges, far beyond them, and no place.
    fn place(i: usize) -> f64 {
        const ODD: [f64; 13] =
            [f64::INFINITY, -1e18, -1.0, -1e-17, -0.0, 0.0, 1e-9, 0.5, 0.999_999, 1.0, 4e9, 1e300, f64::NAN];
        if i.is_multiple_of(3) { ODD[i / 3 % ODD.len()] } else { 5.0 * number(i) - 2.0 }
    }

    const ODD_STEPS: [f64; 3] = [f64::INFINITY, f64::NAN, 1e300];

    fn same(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()))
    }

    /// Compares lanes together with each lane alone.
    fn compare<S: Simd>(s: S) {
        let lanes = |first: usize, f: &dyn Fn(usize) -> f64| f64x8::<S>::from_fn(s, |lane| f(first + lane));
        let samplers = WRAPS.map(|wrap| [false, true].map(|nearest| Sampler { wrap, nearest }));
        for (mipmap, sampler) in
            mipmaps().flat_map(|m| samplers.as_flattened().iter().map(move |s| (Arc::clone(&m), *s)))
        {
            for first in (0..320).step_by(8) {
                let [u, v] = [lanes(first, &place), lanes(7 * first + 1, &place)];
                // Enlarged, made smaller, and along a way of many lookups.
                let size = [1e-3, 0.2, 3.0][first / 8 % 3];
                let step = |i: usize| if i.is_multiple_of(11) { ODD_STEPS[i % 3] } else { size * (number(i) - 0.3) };
                let axes = [1, 2].map(|axis| [3, 4].map(|i| lanes(first * axis + i, &step)));
                let last = (mipmap.levels.len() - 1) as f64;
                let level = lanes(first, &|i| if i.is_multiple_of(4) { last.min(1.0) } else { last * number(i) });
                for asked in [0xff, 0b1011_0101] {
                    let means = mipmap.average(s, [u, v], axes, sampler, asked);
                    let together = mipmap.at(s, [u, v], level, sampler, asked);
                    for lane in 0..8 {
                        let alone = [u.lane(lane), v.lane(lane)];
                        let of = axes.map(|axis| axis.map(|step| step.lane(lane)));
                        let (mean, alone_lookup) = match asked >> lane & 1 {
                            0 => ([0.0; 3], [0.0; 3]),
                            _ => (
                                mipmap.average((), alone, of, sampler, 1).lane(0),
                                mipmap.at((), alone, level.lane(lane), sampler, 1).lane(0),
                            ),
                        };
                        assert!(same(means.lane(lane), mean), "{sampler:?} {alone:?} {of:?}");
                        assert!(same(together.lane(lane), alone_lookup), "{sampler:?} {alone:?} {}", level.lane(lane));
                    }
                }
            }
        }
    }

    #[test]
    fn many_lanes_see_what_each_sees_alone() {
        let best = Instructions::new();
        fearless_simd::dispatch!(best, s => compare(s));
        #[cfg(target_arch = "x86_64")]
        if let Some(lower) = best.as_avx2() {
            fearless_simd::dispatch!(Instructions::Avx2(lower), s => compare(s));
        }
    }
}
