//! Lookups in mipmaps: between two levels, and with several samples along a footprint that is longer than wide (Heckbert 1989).
//!
//! Levels and footprints are computed for all lanes at once. Few lanes are looked up one by one (`trilinear.rs`), with the channels
//! side by side, many together (`trilinear_lanes.rs`). Both give the same numbers to the bit.

use super::mipmap::Mipmap;
use super::trilinear_lanes::TrilinearLanes;
use crate::lanes::{Double, MAX_LANES, Mask, V3, lanes_of, log2};

/// What lies beyond the edges of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wrap {
    /// The picture again.
    Repeat,
    /// Its last texel.
    Clamp,
    /// The picture again, every other time mirrored.
    Mirror,
}

/// How a picture is looked up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampler {
    /// What lies beyond its edges, across and along.
    pub wrap: [Wrap; 2],
    /// Whether enlarged texels are squares. Otherwise there is a smooth way from one to the next.
    pub nearest: bool,
}

impl From<[Wrap; 2]> for Sampler {
    fn from(wrap: [Wrap; 2]) -> Self {
        Self { wrap, nearest: false }
    }
}

/// More texels than any picture has across.
const WIDEST: f64 = 1e18;
/// Most samples along a footprint; longer footprints are blurred.
const MAX_TAPS: f64 = 16.0;
/// Up to so many lanes are looked up one by one.
const FEW: u32 = 2;

impl Mipmap {
    /// The levels whose texels are `texels` wide, as numbers between 0 and the last.
    #[inline(always)]
    pub fn levels<W: Double>(&self, s: W::Simd, texels: W) -> W {
        let last = (self.levels.len() - 1) as f64;
        let one = W::lit(s, 1.0);
        // No number is level 0.
        let wide = W::select(texels.gt(one), texels, one).min(W::lit(s, WIDEST));
        log2(s, wide).min(W::lit(s, last))
    }

    /// Between the two nearest levels, bilinear in each, at (u, v) in a picture whose lower left corner is (0, 0) and
    /// whose upper right corner is (1, 1).
    #[inline(always)]
    pub fn at<W: Double>(&self, s: W::Simd, uv: [W; 2], level: W, sampler: Sampler, lanes: u32) -> V3<W> {
        let [seen] = self.at_each(s, [uv], level, sampler, lanes);
        seen
    }

    /// [`Self::at`] several places.
    #[inline(always)]
    pub fn at_each<W: Double, const N: usize>(
        &self,
        s: W::Simd,
        places: [[W; 2]; N],
        level: W,
        sampler: Sampler,
        lanes: u32,
    ) -> [V3<W>; N] {
        let mut all = [V3::splat(s, [0.0; 3]); N];
        if lanes.count_ones() > FEW {
            let levels = TrilinearLanes::new(s, self, level, sampler, lanes);
            for (seen, uv) in all.iter_mut().zip(places) {
                *seen = levels.at(s, uv, lanes);
            }
            return all;
        }
        for (seen, [u, v]) in all.iter_mut().zip(places) {
            let mut channels = [[0.0; MAX_LANES]; 3];
            for lane in lanes_of(lanes) {
                let [r, g, b, _] = self.trilinear([u.lane(lane), v.lane(lane)], level.lane(lane), sampler);
                (channels[0][lane], channels[1][lane], channels[2][lane]) = (r, g, b);
            }
            *seen = V3 { x: W::load(s, &channels[0]), y: W::load(s, &channels[1]), z: W::load(s, &channels[2]) };
        }
        all
    }

    /// The means over footprints around (u, v), given by their two axes, from side to side.
    #[inline(always)]
    pub fn average<W: Double>(&self, s: W::Simd, uv: [W; 2], axes: [[W; 2]; 2], sampler: Sampler, lanes: u32) -> V3<W> {
        let ([u, v], axes) = within_edges(s, uv, axes, sampler.wrap);
        let (one, most) = (W::lit(s, 1.0), W::lit(s, MAX_TAPS));
        let [a, b] = [self.texels_along(s, axes[0]), self.texels_along(s, axes[1])];
        let first = a.gt(b);
        let (long, short) = (W::select(first, a, b), W::select(first, b, a));
        let longer = [W::select(first, axes[0][0], axes[1][0]), W::select(first, axes[0][1], axes[1][1])];
        // Rounded up; NaN is no lookup.
        let taps = -(-(long / short.max(one))).floor();
        let taps = W::select(taps.lt(one), one, W::select(taps.gt(most), most, taps));
        let level = self.levels(s, short.max(long / most));
        if lanes.count_ones() > FEW {
            return TrilinearLanes::new(s, self, level, sampler, lanes).mean(s, [u, v], longer, taps, lanes);
        }
        let mut seen = [[0.0; MAX_LANES]; 3];
        for lane in lanes_of(lanes) {
            let (uv, longer) = ([u.lane(lane), v.lane(lane)], [longer[0].lane(lane), longer[1].lane(lane)]);
            let (taps, level) = (taps.lane(lane), level.lane(lane));
            let mut sum = [0.0; 4];
            for tap in 0..taps as u32 {
                let along = (f64::from(tap) + 0.5) / taps - 0.5;
                let texel = self.trilinear([uv[0] + longer[0] * along, uv[1] + longer[1] * along], level, sampler);
                for i in 0..4 {
                    sum[i] += texel[i] / taps;
                }
            }
            (seen[0][lane], seen[1][lane], seen[2][lane]) = (sum[0], sum[1], sum[2]);
        }
        V3 { x: W::load(s, &seen[0]), y: W::load(s, &seen[1]), z: W::load(s, &seen[2]) }
    }

    /// How many texels steps in texture space cross.
    #[inline(always)]
    pub fn texels_along<W: Double>(&self, s: W::Simd, [u, v]: [W; 2]) -> W {
        let [width, height] = self.size();
        let (across, down) = (u * W::lit(s, width), v * W::lit(s, height));
        (across * across + down * down).sqrt()
    }
}

/// Footprints where edges are continued, as others inside of the picture: what lies beyond an edge is on it. They have the mean and the
/// variance of the places that the footprint sees.
#[inline(always)]
fn within_edges<W: Double>(
    s: W::Simd,
    mut uv: [W; 2],
    mut axes: [[W; 2]; 2],
    wrap: [Wrap; 2],
) -> ([W; 2], [[W; 2]; 2]) {
    let (zero, one) = (W::lit(s, 0.0), W::lit(s, 1.0));
    for i in 0..2 {
        let width = (axes[0][i].abs() + axes[1][i].abs()).min(W::lit(s, WIDEST));
        let half = width * W::lit(s, 0.5);
        let (start, end) = (uv[i] - half, uv[i] + half);
        let leaves = start.lt(zero) | end.gt(one);
        if wrap[i] != Wrap::Clamp || !leaves.any() {
            continue;
        }
        let width = width.max(W::lit(s, 1.0 / WIDEST));
        let (low, high) = (start.max(zero).min(one), end.max(zero).min(one));
        let inside = ((high - low) / width).min(one);
        let partly = W::select(end.gt(one), ((end - one) / width).min(one), zero);
        let above = W::select(start.lt(one), partly, one);
        let mean = inside * W::lit(s, 0.5) * (low + high) + above;
        let square = inside * (low * low + low * high + high * high) / W::lit(s, 3.0) + above;
        let spread = (W::lit(s, 12.0) * (square - mean * mean)).max(zero).sqrt();
        uv[i] = W::select(leaves, mean, uv[i]);
        for axis in &mut axes {
            axis[i] = W::select(leaves, axis[i] * (spread / width), axis[i]);
        }
    }
    (uv, axes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn average(mipmap: &Mipmap, uv: [f64; 2], axes: [[f64; 2]; 2], wrap: [Wrap; 2]) -> [f64; 3] {
        mipmap.average((), uv, axes, wrap.into(), 1).lane(0)
    }

    fn at(mipmap: &Mipmap, uv: [f64; 2], level: f64, wrap: [Wrap; 2]) -> [f64; 3] {
        mipmap.at((), uv, level, wrap.into(), 1).lane(0)
    }

    fn ramp(width: u32, height: u32) -> Mipmap {
        let texel = |i: u32| [(i % width) as f32, (i / width) as f32, 1.0];
        Mipmap::new(width, height, (0..width * height).map(texel).collect())
    }

    #[test]
    fn magnified_it_is_bilinear() {
        let mipmap = ramp(8, 4);
        let clamp = [Wrap::Clamp; 2];
        for (u, v) in [(0.3, 0.4), (0.5, 0.5), (0.1, 0.8)] {
            let small = [[0.01, 0.0], [0.0, 0.02]];
            let [x, y, one] = average(&mipmap, [u, v], small, clamp);
            assert!((x - (u * 8.0 - 0.5)).abs() < 1e-12 && (y - ((1.0 - v) * 4.0 - 0.5)).abs() < 1e-12 && one == 1.0);
        }
        assert_eq!(at(&mipmap, [-3.0, 9.0], 0.0, clamp), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn enlarged_texels_may_be_squares() {
        let mipmap = ramp(8, 4);
        let sampler = Sampler { wrap: [Wrap::Repeat; 2], nearest: true };
        let small = [[0.01, 0.0], [0.0, 0.02]];
        for (u, v) in [(0.001, 0.999), (0.3, 0.4), (0.124, 0.26), (0.126, 0.24), (0.999, 0.001), (1.3, -0.6)] {
            let [x, y, _] = mipmap.average((), [u, v], small, sampler, 1).lane(0);
            let expected = [(u * 8.0_f64).floor().rem_euclid(8.0), ((1.0 - v) * 4.0_f64).floor().rem_euclid(4.0)];
            assert_eq!([x, y], expected, "{u} {v}");
        }
        // Far away they are means, as all others.
        let large = [[0.5, 0.0], [0.0, 0.5]];
        let [mean, smooth] =
            [sampler, sampler.wrap.into()].map(|sampler| mipmap.average((), [0.3, 0.4], large, sampler, 1).lane(0));
        assert_eq!(mean, smooth);
    }

    /// The same texel by texel, from the definitions.
    fn slow_bilinear(mipmap: &Mipmap, [u, v]: [f64; 2], wrap: [Wrap; 2]) -> [f64; 3] {
        let level = &mipmap.levels[0];
        let axis = |place: f64, count: usize, wrap: Wrap| {
            let count = count as i64;
            let inside = if wrap == Wrap::Repeat { place - place.floor() } else { place.clamp(0.0, 1.0) };
            let x = inside * count as f64 - 0.5;
            let texel = |i: i64| if wrap == Wrap::Repeat { i.rem_euclid(count) } else { i.clamp(0, count - 1) };
            [(texel(x.floor() as i64), 1.0 - (x - x.floor())), (texel(x.floor() as i64 + 1), x - x.floor())]
        };
        let (columns, rows) = (axis(u, level.width, wrap[0]), axis(1.0 - v, level.height, wrap[1]));
        [0, 1, 2].map(|c| {
            let [above, below] = rows.map(|(y, _)| {
                let [left, right] = columns.map(|(x, part)| f64::from(level.texel(x as usize, y as usize)[c]) * part);
                left + right
            });
            above * rows[0].1 + below * rows[1].1
        })
    }

    #[test]
    fn looks_agree_with_the_slow_one_to_the_bit() {
        for (width, height) in [(1, 1), (1, 7), (2, 2), (5, 3), (16, 8)] {
            let mipmap = ramp(width, height);
            for wrap in [[Wrap::Repeat; 2], [Wrap::Clamp; 2], [Wrap::Clamp, Wrap::Repeat]] {
                let places = [-1e18, -7.3, -1.0, -1e-17, -0.0, 0.0, 1e-9, 0.1, 0.5, 0.999_999, 1.0, 1.7, 4e9, 1e300];
                for u in places {
                    for v in places {
                        let expected = slow_bilinear(&mipmap, [u, v], wrap);
                        assert_eq!(at(&mipmap, [u, v], 0.0, wrap), expected, "{width} x {height} {wrap:?} {u} {v}");
                    }
                }
            }
        }
    }

    #[test]
    fn seams_do_not_show() {
        let mipmap = ramp(8, 4);
        let repeat = [Wrap::Repeat; 2];
        for level in [0.0, 0.7, 2.0] {
            for x in [0.0, 1.0, -5.0] {
                let [left, right] = [x - 1e-9, x + 1e-9].map(|u| at(&mipmap, [u, 0.3], level, repeat)[0]);
                assert!((left - right).abs() < 1e-6, "{left} {right}");
            }
            let [here, there] = [0.25, 7.25].map(|u| at(&mipmap, [u, 0.3], level, repeat));
            assert_eq!(here, there);
        }
    }

    #[test]
    fn beyond_an_edge_that_is_continued_its_color_is_seen_from_any_distance() {
        // Left half 0, right half 1.
        let halves = Mipmap::new(64, 4, (0..256).map(|i| [f32::from(u8::from(i % 64 >= 32)); 3]).collect());
        let clamp = [Wrap::Clamp; 2];
        for (u, width, expected) in
            [(-9.0, 17.9, 0.0), (-1e12, 1.0, 0.0), (7.0, 11.9, 1.0), (1e18, 0.0, 1.0), (3.0, 1.0, 1.0)]
        {
            for axes in [[[width, 0.0], [0.0, 0.3]], [[0.0, 20.0], [width, 0.0]]] {
                let [seen, ..] = average(&halves, [u, 0.5], axes, clamp);
                assert!((seen - expected).abs() < 1e-6, "{u} {width}: {seen}");
            }
        }
        // Across the edges it is near the mean of many places.
        let mut most: f64 = 0.0;
        for i in 41..400 {
            let (u, width) = (f64::from(i % 41) * 0.1 - 1.5, f64::from(i / 41) * 0.7);
            let place = |k: u32| u + width * ((f64::from(k) + 0.5) / 2_000.0 - 0.5);
            let exact = (0..2_000).filter(|k| place(*k) >= 0.5).count() as f64 / 2_000.0;
            let [seen, ..] = average(&halves, [u, 0.5], [[width, 0.0], [0.0, 0.1]], clamp);
            most = most.max((seen - exact).abs());
        }
        assert!(most < 0.15, "{most}");
    }

    #[test]
    fn a_huge_footprint_sees_the_mean() {
        let mipmap = ramp(16, 16);
        let mean = average(&mipmap, [0.2, 0.7], [[30.0, 0.0], [0.0, 1e9]], [Wrap::Repeat; 2]);
        assert!(mean.iter().zip(mipmap.mean()).all(|(a, b)| (a - b).abs() < 1e-9));
    }
}
