//! Mipmaps: a picture and ever smaller copies of it in linear light (Williams, Pyramidal Parametrics, 1983). A lookup
//! interpolates between two levels, and takes several samples along a footprint that is longer than wide (Heckbert 1989).
//!
//! Levels and footprints are computed for all lanes at once. Texels are fetched lane by lane, with the channels side by side,
//! since lanes need others.
//!
//! Pictures of 8 bits are kept as their codes, with a table of what they stand for: 7 bytes for a texel with all levels in place of
//! 16, and the same numbers to the bit. Smaller copies are numbers: rounded to codes they would change pictures.

use crate::lanes::{Double, MAX_LANES, Mask, V3, lanes_of};
use crate::math;

/// A picture and its smaller copies.
#[derive(Debug)]
pub struct Mipmap {
    levels: Vec<Level>,
    /// The smallest and the largest of each channel.
    extremes: [[f32; 3]; 2],
}

/// Rows from top to bottom.
#[derive(Debug)]
struct Level {
    width: usize,
    height: usize,
    texels: Texels,
}

/// What is kept of a level.
#[derive(Debug)]
enum Texels {
    Numbers(Vec<[f32; 3]>),
    /// Three codes for each texel, and what they stand for.
    Codes(Vec<u8>, Box<[f32; 256]>),
}

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

/// Most samples along a footprint; longer footprints are blurred.
const MOST_LOOKS: f64 = 16.0;

impl Mipmap {
    /// The mipmap over `width * height` texels, at least one, row by row from the top.
    pub fn new(width: u32, height: u32, texels: Vec<[f32; 3]>) -> Self {
        Self::over(width, height, Texels::Numbers(texels))
    }

    /// The same over codes, three for each texel, and what each of them stands for.
    pub fn of_codes(width: u32, height: u32, codes: Vec<u8>, values: [f32; 256]) -> Self {
        Self::over(width, height, Texels::Codes(codes, Box::new(values)))
    }

    fn over(width: u32, height: u32, texels: Texels) -> Self {
        let extremes = extremes(&texels);
        let mut mipmap =
            Self { levels: vec![Level { width: width as usize, height: height as usize, texels }], extremes };
        while let Some(next) = mipmap.halved() {
            mipmap.levels.push(next);
        }
        mipmap
    }

    /// Bytes of memory it takes.
    pub fn bytes(&self) -> usize {
        let of = |level: &Level| match &level.texels {
            Texels::Numbers(texels) => size_of_val(&texels[..]),
            Texels::Codes(codes, values) => codes.len() + size_of_val(&values[..]),
        };
        self.levels.iter().map(of).sum()
    }

    /// Bytes that one takes, its largest size as codes or as numbers.
    pub fn bytes_for(width: u32, height: u32, is_coded: bool) -> u64 {
        let (mut width, mut height) = (u64::from(width), u64::from(height));
        let mut bytes = if is_coded { 3 * width * height + 1_024 } else { 12 * width * height };
        while width * height > 1 {
            (width, height) = ((width / 2).max(1), (height / 2).max(1));
            bytes += 12 * width * height;
        }
        bytes
    }

    /// Texels across and down.
    pub fn size(&self) -> [f64; 2] {
        [self.levels[0].width as f64, self.levels[0].height as f64]
    }

    /// Its texel, if all are the same.
    pub fn uniform(&self) -> Option<[f64; 3]> {
        let [least, most] = self.extremes;
        (least == most).then(|| least.map(f64::from))
    }

    /// The largest of each channel over all texels.
    pub fn brightest(&self) -> [f64; 3] {
        self.extremes[1].map(|channel| f64::from(channel.max(0.0)))
    }

    /// The smallest of each channel over all texels.
    pub fn darkest(&self) -> [f64; 3] {
        self.extremes[0].map(f64::from)
    }

    /// The mean light of the cells of a grid, no finer than the texels, of a picture that repeats across: the sum of the channels, row
    /// by row from the top. Between texels lookups are linear, so an eighth of each texel lies in each of its neighbours.
    pub fn light(&self, columns: usize, rows: usize) -> Vec<f64> {
        let Level { width, height, .. } = &self.levels[0];
        let sum = |texel: [f32; 3]| texel.iter().map(|channel| f64::from(*channel)).sum::<f64>();
        let bright: Vec<f64> = (0..width * height).map(|at| sum(self.texel(0, at % width, at / width))).collect();
        let spread = |before: f64, here: f64, after: f64| 0.125 * before + 0.75 * here + 0.125 * after;
        let across = |x: usize, y: usize| {
            let at = |x: usize| bright[y * width + x % width];
            spread(at(x + width - 1), at(x), at(x + 1))
        };
        let (mut sums, mut counts) = (vec![0.0; columns * rows], vec![0_u32; columns * rows]);
        for y in 0..*height {
            let (above, below) = (y.saturating_sub(1), (y + 1).min(height - 1));
            for x in 0..*width {
                let cell = y * rows / height * columns + x * columns / width;
                sums[cell] += spread(across(x, above), across(x, y), across(x, below));
                counts[cell] += 1;
            }
        }
        sums.iter().zip(counts).map(|(sum, count)| sum / f64::from(count.max(1))).collect()
    }

    /// The mean of all texels.
    pub fn mean(&self) -> [f64; 3] {
        self.texel(self.levels.len() - 1, 0, 0).map(f64::from)
    }

    fn texel(&self, level: usize, x: usize, y: usize) -> [f32; 3] {
        self.levels[level].texel(x, y)
    }

    /// The copy of the last level that is half as large in each direction, at least one texel. Texels are means over equal
    /// parts, so the mean of all stays.
    fn halved(&self) -> Option<Level> {
        let last = self.levels.len() - 1;
        let Level { width: columns, height: rows, .. } = &self.levels[last];
        if columns * rows == 1 {
            return None;
        }
        let (width, height) = ((columns / 2).max(1), (rows / 2).max(1));
        let (columns, rows) = (shares(*columns, width), shares(*rows, height));
        let mut texels = Vec::with_capacity(width * height);
        for row in &rows {
            for column in &columns {
                let mut sum = [0.0; 3];
                for &(y, down) in row {
                    for &(x, across) in column {
                        let texel = self.texel(last, x, y);
                        for (sum, texel) in sum.iter_mut().zip(texel) {
                            *sum += f64::from(texel) * (down * across);
                        }
                    }
                }
                texels.push(sum.map(|x| x as f32));
            }
        }
        Some(Level { width, height, texels: Texels::Numbers(texels) })
    }

    /// The levels whose texels are `texels` wide, as numbers between 0 and the last.
    #[inline(always)]
    pub fn levels<W: Double>(&self, s: W::Simd, texels: W, lanes: u32) -> W {
        let last = (self.levels.len() - 1) as f64;
        let wide = texels.gt(W::lit(s, 1.0)).bits() & lanes;
        let mut levels = [0.0; MAX_LANES];
        for lane in lanes_of(wide) {
            levels[lane] = math::log2(texels.lane(lane)).min(last);
        }
        W::load(s, &levels)
    }

    /// Between the two nearest levels, bilinear in each, at (u, v) in a picture whose lower left corner is (0, 0) and
    /// whose upper right corner is (1, 1).
    #[inline(always)]
    pub fn at<W: Double>(&self, s: W::Simd, [u, v]: [W; 2], level: W, sampler: Sampler, lanes: u32) -> V3<W> {
        let mut seen = [[0.0; MAX_LANES]; 3];
        for lane in lanes_of(lanes) {
            let [r, g, b, _] = self.look([u.lane(lane), v.lane(lane)], level.lane(lane), sampler);
            (seen[0][lane], seen[1][lane], seen[2][lane]) = (r, g, b);
        }
        V3 { x: W::load(s, &seen[0]), y: W::load(s, &seen[1]), z: W::load(s, &seen[2]) }
    }

    /// The means over footprints around (u, v), given by their two axes, from side to side.
    #[inline(always)]
    pub fn average<W: Double>(
        &self,
        s: W::Simd,
        [u, v]: [W; 2],
        axes: [[W; 2]; 2],
        sampler: Sampler,
        lanes: u32,
    ) -> V3<W> {
        let (one, most) = (W::lit(s, 1.0), W::lit(s, MOST_LOOKS));
        let [a, b] = [self.texels_along(s, axes[0]), self.texels_along(s, axes[1])];
        let first = a.gt(b);
        let (long, short) = (W::select(first, a, b), W::select(first, b, a));
        let longer = [W::select(first, axes[0][0], axes[1][0]), W::select(first, axes[0][1], axes[1][1])];
        // Rounded up; no number is no look.
        let looks = -(-(long / short.max(one))).floor();
        let looks = W::select(looks.lt(one), one, W::select(looks.gt(most), most, looks));
        let level = self.levels(s, short.max(long / most), lanes);
        let mut seen = [[0.0; MAX_LANES]; 3];
        for lane in lanes_of(lanes) {
            let (uv, longer) = ([u.lane(lane), v.lane(lane)], [longer[0].lane(lane), longer[1].lane(lane)]);
            let (looks, level) = (looks.lane(lane), level.lane(lane));
            let mut sum = [0.0; 4];
            for look in 0..looks as u32 {
                let along = (f64::from(look) + 0.5) / looks - 0.5;
                let texel = self.look([uv[0] + longer[0] * along, uv[1] + longer[1] * along], level, sampler);
                for i in 0..4 {
                    sum[i] += texel[i] / looks;
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

    /// One look for one lane; the fourth channel is nothing.
    #[inline(always)]
    fn look(&self, uv: [f64; 2], level: f64, sampler: Sampler) -> [f64; 4] {
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
                let at = |x: usize, y: usize| wide(decoded(codes, values, y * width + x));
                let above = mix(at(left, upper), at(right, upper), across);
                mix(above, mix(at(left, lower), at(right, lower), across), down)
            }
        }
    }
}

impl Level {
    fn texel(&self, x: usize, y: usize) -> [f32; 3] {
        let i = y * self.width + x;
        match &self.texels {
            Texels::Numbers(texels) => texels[i],
            Texels::Codes(codes, values) => decoded(codes, values, i),
        }
    }
}

/// The smallest and the largest of each channel.
fn extremes(texels: &Texels) -> [[f32; 3]; 2] {
    let mut extremes = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    let mut note = |texel: [f32; 3]| {
        for c in 0..3 {
            extremes[0][c] = extremes[0][c].min(texel[c]);
            extremes[1][c] = extremes[1][c].max(texel[c]);
        }
    };
    match texels {
        Texels::Numbers(texels) => texels.iter().for_each(|texel| note(*texel)),
        Texels::Codes(codes, values) => {
            // Codes that are there, so that values are looked up once.
            let mut is_there = [[false; 256]; 3];
            for texel in codes.as_chunks::<3>().0 {
                for c in 0..3 {
                    is_there[c][usize::from(texel[c])] = true;
                }
            }
            for code in 0..256 {
                for c in (0..3).filter(|c| is_there[*c][code]) {
                    extremes[0][c] = extremes[0][c].min(values[code]);
                    extremes[1][c] = extremes[1][c].max(values[code]);
                }
            }
        }
    }
    extremes
}

/// What the codes of a texel stand for.
#[inline(always)]
fn decoded(codes: &[u8], values: &[f32; 256], i: usize) -> [f32; 3] {
    let [r, g, b] = [codes[3 * i], codes[3 * i + 1], codes[3 * i + 2]];
    [values[usize::from(r)], values[usize::from(g)], values[usize::from(b)]]
}

#[inline(always)]
fn wide([r, g, b]: [f32; 3]) -> [f64; 4] {
    [f64::from(r), f64::from(g), f64::from(b), 0.0]
}

/// For each of `fewer` equal parts of a row of `many` texels: the texels it covers, and their shares in it.
fn shares(many: usize, fewer: usize) -> Vec<Vec<(usize, f64)>> {
    // In units of 1/fewer of a texel all borders are whole numbers.
    let part = |i: usize| {
        let (from, to) = (i * many, (i + 1) * many);
        let cover = |texel: usize| to.min((texel + 1) * fewer) - from.max(texel * fewer);
        (from / fewer..to.div_ceil(fewer)).map(|texel| (texel, cover(texel) as f64 / many as f64)).collect()
    };
    (0..fewer).map(part).collect()
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
    fn every_level_has_the_mean_of_the_picture() {
        for (width, height) in [(1, 1), (2, 1), (7, 5), (64, 64), (13, 1), (100, 3)] {
            let mipmap = ramp(width, height);
            let expected = [f64::from(width - 1) / 2.0, f64::from(height - 1) / 2.0, 1.0];
            for (index, level) in mipmap.levels.iter().enumerate() {
                for channel in 0..3 {
                    let texels = (0..level.height).flat_map(|y| (0..level.width).map(move |x| (x, y)));
                    let sum: f64 = texels.map(|(x, y)| f64::from(mipmap.texel(index, x, y)[channel])).sum();
                    let mean = sum / (level.width * level.height) as f64;
                    assert!((mean - expected[channel]).abs() < 1e-4, "{width} x {height}: {mean}");
                }
            }
            let last = &mipmap.levels[mipmap.levels.len() - 1];
            assert_eq!((last.width, last.height), (1, 1));
        }
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

    /// Codes take a quarter of the memory, and give the same numbers on every level.
    #[test]
    fn codes_are_the_numbers_that_they_stand_for_to_the_bit() {
        let values: [f32; 256] = std::array::from_fn(|code| math::srgb_to_linear(code as f64 / 255.0) as f32);
        for (width, height) in [(1, 1), (2, 2), (2, 1), (64, 32), (13, 8), (31, 17), (100, 6), (256, 256)] {
            let codes: Vec<u8> = (0..3 * u64::from(width * height)).map(|i| (i * i / 7 % 256) as u8).collect();
            let numbers = codes.chunks(3).map(|texel| [0, 1, 2].map(|c| values[usize::from(texel[c])])).collect();
            let (coded, numbers) =
                (Mipmap::of_codes(width, height, codes, values), Mipmap::new(width, height, numbers));
            assert_eq!((coded.uniform(), coded.mean()), (numbers.uniform(), numbers.mean()));
            assert_eq!((coded.brightest(), coded.darkest()), (numbers.brightest(), numbers.darkest()));
            for (level, kept) in numbers.levels.iter().enumerate() {
                for (x, y) in (0..kept.height).flat_map(|y| (0..kept.width).map(move |x| (x, y))) {
                    assert_eq!(
                        coded.texel(level, x, y),
                        kept.texel(x, y),
                        "{width} x {height}, level {level}, {x} {y}"
                    );
                }
            }
            for (mipmap, is_coded) in [(&coded, true), (&numbers, false)] {
                assert_eq!(mipmap.bytes() as u64, Mipmap::bytes_for(width, height, is_coded), "{width} x {height}");
            }
        }
        // With all levels, and the table of 1 KiB.
        let texels = 1 << 24;
        assert_eq!(Mipmap::bytes_for(4_096, 4_096, true), 7 * texels - 4 + 1_024);
        assert_eq!(Mipmap::bytes_for(4_096, 4_096, false), 16 * texels - 4);
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
    fn a_huge_footprint_sees_the_mean() {
        let mipmap = ramp(16, 16);
        let mean = average(&mipmap, [0.2, 0.7], [[30.0, 0.0], [0.0, 1e9]], [Wrap::Repeat; 2]);
        assert!(mean.iter().zip(mipmap.mean()).all(|(a, b)| (a - b).abs() < 1e-9));
    }
}
