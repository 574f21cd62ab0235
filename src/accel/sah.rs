//! Where to split a node: the surface area heuristic over bins of centres (Goldsmith and Salmon 1987; Wald 2007), on all
//! three axes in one pass.

use super::build_primitive::{Box4, BuildPrimitive};
use crate::lanes::Real;
use rayon::prelude::*;

/// Most bins on an axis.
const BINS: usize = 16;
/// One bin is added to the fewest for each of these.
const PRIMITIVES_PER_BIN: usize = 20;
const FEWEST_BINS: usize = 4;
/// Cost of visiting a node relative to testing a primitive.
const NODE_COST: f64 = 2.0;
/// From this number of primitives on, two halves of a node are counted in turn.
const INTERLEAVED: usize = 512;
/// From this number of primitives on, a node is split along the axis on which their centres lie farthest apart: another one is
/// seldom better there, and three take three times as long.
const ONE_AXIS: usize = 8192;
/// Larger nodes are counted by several threads.
const CHUNK: usize = 32_768;

/// How the centres of a node's primitives are divided into bins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Binning<R> {
    bins: usize,
    low: [R; 4],
    /// Bins for each unit of length; 0 along axes that are not considered, or on which the centres do not differ.
    scale: [R; 4],
    /// The only axis that is considered.
    only: Option<usize>,
}

/// The best of the planes between bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plane {
    axis: usize,
    /// Bins in front of it.
    bins: usize,
    /// Expected cost of a ray that crosses the node, where testing one primitive costs 1.
    pub(super) cost: f64,
}

impl<R: Real> Binning<R> {
    pub(super) fn new(centers: &Box4<R>, primitives: usize) -> Self {
        let bins = (FEWEST_BINS + primitives / PRIMITIVES_PER_BIN).min(BINS);
        let (low, extent) = centers.sides();
        let zero = R::default();
        // A little below the whole number of bins, so that rounding never leads beyond the last.
        let end = R::from_f64(bins as f64 * (1.0 - 8.0 * R::ROUNDOFF));
        let widest = (1..3).fold(0, |a, b| if extent[b] > extent[a] { b } else { a });
        let only = (primitives >= ONE_AXIS).then_some(widest);
        let is_considered = |i: usize| i < 3 && extent[i] > zero && only.is_none_or(|only| only == i);
        let scale = |i: usize| if is_considered(i) { end / extent[i] } else { zero };
        Self { bins, low, scale: std::array::from_fn(scale), only }
    }

    /// The bin of a primitive on each axis.
    #[inline(always)]
    fn bins_of(&self, primitive: &BuildPrimitive<R>) -> [usize; 4] {
        let center = primitive.center();
        let place: [R; 4] = std::array::from_fn(|i| self.place(center[i], i));
        place.map(R::nearest_of_16)
    }

    /// The bin of a primitive on one axis.
    #[inline(always)]
    fn bin_on(&self, axis: usize, primitive: &BuildPrimitive<R>) -> usize {
        self.place(primitive.center_on(axis), axis).nearest_of_16()
    }

    /// The position of a centre in units of bins, from the middle of the first one; 0 where a centre overflows.
    #[inline(always)]
    fn place(&self, center: R, axis: usize) -> R {
        let place = (center - self.low[axis]) * self.scale[axis] - R::from_f64(0.5);
        let first = R::default();
        if place > first { place } else { first }
    }

    /// Whether a primitive is in front of a plane. It agrees with [`Self::bins_of`].
    #[inline(always)]
    pub(super) fn is_before(&self, plane: &Plane, primitive: &BuildPrimitive<R>) -> bool {
        self.bin_on(plane.axis, primitive) < plane.bins
    }

    /// The cheapest plane with primitives on both sides.
    pub(super) fn best(&self, primitives: &[BuildPrimitive<R>], around: &Box4<R>) -> Option<(Plane, [Box4<R>; 2])> {
        let bins = if primitives.len() > CHUNK { self.count_in_parallel(primitives) } else { self.count(primitives) };
        let unit = unit_in(around);
        let whole = half_area(around, unit).to_f64();
        let planes = (0..3).filter_map(|axis| self.best_on(axis, &bins, unit, whole));
        let plane = planes.reduce(|a, b| if b.cost < a.cost { b } else { a })?;
        let (before, behind) = bins.boxes[plane.axis].split_at(plane.bins);
        let around = |boxes: &[Box4<R>]| boxes.iter().fold(Box4::empty(), |a, b| a.union(*b));
        Some((plane, [around(before), around(behind)]))
    }

    fn best_on(&self, axis: usize, bins: &Bins<R>, unit: R, whole: f64) -> Option<Plane> {
        if self.scale[axis] == R::default() {
            return None;
        }
        let mut behind = [(0.0, 0); BINS];
        let (mut around, mut count) = (Box4::empty(), 0);
        for bin in (1..self.bins).rev() {
            around = around.union(bins.boxes[axis][bin]);
            count += bins.counts[axis][bin];
            behind[bin - 1] = (half_area(&around, unit).to_f64() * f64::from(count), count);
        }
        let mut best: Option<Plane> = None;
        let (mut around, mut count) = (Box4::empty(), 0);
        for bin in 0..self.bins - 1 {
            around = around.union(bins.boxes[axis][bin]);
            count += bins.counts[axis][bin];
            let (cost_behind, count_behind) = behind[bin];
            if count > 0 && count_behind > 0 {
                let primitives = half_area(&around, unit).to_f64() * f64::from(count) + cost_behind;
                let cost = NODE_COST + primitives / whole;
                if cost < best.map_or(f64::INFINITY, |best| best.cost) {
                    best = Some(Plane { axis, bins: bin + 1, cost });
                }
            }
        }
        best
    }

    fn count(&self, primitives: &[BuildPrimitive<R>]) -> Bins<R> {
        match self.only {
            Some(axis) => {
                count_by(primitives, |bins, primitive| bins.add_on(axis, primitive, self.bin_on(axis, primitive)))
            }
            None => count_by(primitives, |bins, primitive| bins.add(primitive, self.bins_of(primitive))),
        }
    }

    /// [`Self::count`] on all threads. Unions and counts are exact, so the order of chunks does not matter.
    fn count_in_parallel(&self, primitives: &[BuildPrimitive<R>]) -> Bins<R> {
        primitives.par_chunks(CHUNK).map(|chunk| self.count(chunk)).reduce(|| self.count(&[]), |a, b| a.merged(&b))
    }
}

/// What is in the bins, each primitive of which is added by `add`.
#[inline(always)]
fn count_by<R: Real>(primitives: &[BuildPrimitive<R>], add: impl Fn(&mut Bins<R>, &BuildPrimitive<R>)) -> Bins<R> {
    let empty = || Bins { boxes: [[Box4::empty(); BINS]; 3], counts: [[0; BINS]; 3] };
    let mut bins = empty();
    if primitives.len() < INTERLEAVED {
        primitives.iter().for_each(|primitive| add(&mut bins, primitive));
        return bins;
    }
    // Neighbours are often in one bin, which then waits for itself; so two halves take turns, each with its own bins.
    let mut others = empty();
    let (front, back) = primitives.split_at(primitives.len() / 2);
    for (a, b) in front.iter().zip(back) {
        add(&mut bins, a);
        add(&mut others, b);
    }
    back[front.len()..].iter().for_each(|primitive| add(&mut bins, primitive));
    bins.merged(&others)
}

/// 1 over the longest side of a box: areas of its parts relative to that neither vanish nor overflow, at any scale.
fn unit_in<R: Real>(around: &Box4<R>) -> R {
    let (_, [x, y, z, _]) = around.sides();
    let longest = [y, z].into_iter().fold(x, |a, b| if b > a { b } else { a });
    R::from_f64(1.0) / longest
}

/// Half the surface area of a box that is not empty, with lengths multiplied by `unit`.
#[inline(always)]
fn half_area<R: Real>(around: &Box4<R>, unit: R) -> R {
    let (_, [x, y, z, _]) = around.sides();
    let (x, y, z) = (x * unit, y * unit, z * unit);
    x * y + y * z + z * x
}

/// Whether two boxes have less surface together than the box around them.
pub(super) fn has_less_surface<R: Real>(boxes: [Box4<R>; 2], around: &Box4<R>) -> bool {
    let unit = unit_in(around);
    let [a, b] = boxes.map(|part| half_area(&part, unit));
    a + b < half_area(around, unit)
}

/// What is in the bins of each axis.
#[derive(Debug, Clone, PartialEq)]
struct Bins<R> {
    boxes: [[Box4<R>; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl<R: Real> Bins<R> {
    #[inline(always)]
    fn add(&mut self, primitive: &BuildPrimitive<R>, bins: [usize; 4]) {
        for axis in 0..3 {
            self.add_on(axis, primitive, bins[axis]);
        }
    }

    #[inline(always)]
    fn add_on(&mut self, axis: usize, primitive: &BuildPrimitive<R>, bin: usize) {
        let around = &mut self.boxes[axis][bin];
        *around = around.union(primitive.0);
        self.counts[axis][bin] += primitive.count();
    }

    fn merged(mut self, other: &Self) -> Self {
        for axis in 0..3 {
            for bin in 0..BINS {
                let around = &mut self.boxes[axis][bin];
                *around = around.union(other.boxes[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::super::bounds::Bounds;
    use super::super::build_primitive::NodeBounds;
    use super::*;
    use glam::DVec3;

    fn primitives(count: u32) -> Vec<BuildPrimitive<f32>> {
        let corner = |i: u32| DVec3::new(crate::math::sin_cos(f64::from(i) * 0.7).0, f64::from(i * 31 % 97), 5.0);
        (0..count)
            .map(|i| BuildPrimitive::new(&Bounds::around([corner(i), corner(i) + 0.01]).narrowed(), i, 1))
            .collect()
    }

    #[test]
    fn chunks_count_what_one_pass_counts() {
        let primitives = primitives(3 * CHUNK as u32 + 7);
        let binning = Binning::new(&NodeBounds::of(&primitives).centers, primitives.len());
        assert!(binning.count(&primitives) == binning.count_in_parallel(&primitives));
    }

    #[test]
    fn a_plane_lies_between_the_bins() {
        for count in [5, 100, 5000] {
            let primitives = primitives(count);
            let binning = Binning::new(&NodeBounds::of(&primitives).centers, primitives.len());
            for axis in 0..2 {
                for bins in 1..binning.bins {
                    let plane = Plane { axis, bins, cost: 0.0 };
                    for primitive in &primitives {
                        let bin = binning.bins_of(primitive)[axis];
                        assert_eq!(binning.is_before(&plane, primitive), bin < bins);
                        assert!(bin < binning.bins);
                    }
                }
            }
        }
    }
}
