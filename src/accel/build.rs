//! Binary hierarchy by the surface area heuristic over 16 bins (Goldsmith and Salmon 1987; Wald 2007).

use super::bounds::{Bounds, Slab};
use crate::lanes::Real;

/// Most primitives in a leaf.
const LEAF_SIZE: usize = 4;
const BINS: usize = 16;
/// Below this depth the heuristic may choose; further down nodes are halved, so that depth stays bounded.
const SAH_DEPTH: usize = 40;
/// Longest path: [`SAH_DEPTH`] and then at most 32 halvings of 2^32 primitives.
pub(super) const MAX_DEPTH: usize = SAH_DEPTH + 33;
/// Cost of visiting a node relative to testing a primitive.
const NODE_COST: f64 = 1.0;

/// How nodes are split; pictures do not depend on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BvhKind {
    /// By the surface area heuristic.
    #[default]
    Sah,
    /// In the middle of the primitives, in their order along the widest axis.
    Median,
    /// Not at all: one leaf holds everything. The slow twin.
    Flat,
}

/// A binary tree of boxes.
#[derive(Debug, Clone)]
pub struct Bvh<R> {
    pub(super) nodes: Vec<Node<R>>,
    /// Primitives in the order of the leaves.
    pub(super) order: Vec<u32>,
}

/// A node: inner with two children side by side, or a leaf.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node<R> {
    pub(super) slab: Slab<R>,
    /// First child, or first place in `order`.
    pub(super) first: u32,
    /// Primitives of a leaf; 0 for an inner node.
    pub(super) count: u32,
    /// Axis along which the children lie apart.
    pub(super) axis: u8,
}

struct Task {
    node: usize,
    start: usize,
    end: usize,
    depth: usize,
}

impl<R: Real> Bvh<R> {
    /// Builds a hierarchy over boxes, which must be finite and not empty.
    pub fn build(bounds: &[Bounds], kind: BvhKind) -> Self {
        let mut order: Vec<u32> = (0..bounds.len() as u32).collect();
        let nodes = if bounds.is_empty() { Vec::new() } else { subtree(bounds, &mut order, 0, kind, 0) };
        Self { nodes, order }
    }
}

/// Parts with more primitives are built by two threads.
const PARALLEL: usize = 16_384;

/// The nodes over `part`, which stands at `start` in the order of the leaves; the first is their root.
fn subtree<R: Real>(bounds: &[Bounds], part: &mut [u32], start: usize, kind: BvhKind, depth: usize) -> Vec<Node<R>> {
    let mut nodes = Vec::with_capacity(if part.len() > PARALLEL { 1 } else { part.len() });
    let whole = |part: &[u32]| part.iter().fold(Bounds::EMPTY, |b, &i| b.union(bounds[i as usize]));
    let around = whole(part);
    nodes.push(Node { slab: around.narrowed(), first: start as u32, count: part.len() as u32, axis: 0 });
    if part.len() > PARALLEL
        && let Some((axis, middle)) = split(bounds, part, around, kind, depth)
    {
        let (left, right) = part.split_at_mut(middle);
        let (left, right) = rayon::join(
            || subtree::<R>(bounds, left, start, kind, depth + 1),
            || subtree::<R>(bounds, right, start + middle, kind, depth + 1),
        );
        nodes[0] = Node { first: 1, count: 0, axis, ..nodes[0] };
        // The two roots side by side, then what is below each.
        let (behind_left, behind_right) = (2, left.len() as u32 + 1);
        let moved =
            |node: &Node<R>, by: u32| if node.count == 0 { Node { first: node.first + by, ..*node } } else { *node };
        nodes.reserve(left.len() + right.len());
        nodes.extend([moved(&left[0], behind_left), moved(&right[0], behind_right)]);
        nodes.extend(left[1..].iter().map(|node| moved(node, behind_left)));
        nodes.extend(right[1..].iter().map(|node| moved(node, behind_right)));
        return nodes;
    }
    let mut tasks = vec![Task { node: 0, start: 0, end: part.len(), depth }];
    while let Some(Task { node, start: from, end, depth }) = tasks.pop() {
        let part = &mut part[from..end];
        let around = whole(part);
        nodes[node].slab = around.narrowed();
        match split(bounds, part, around, kind, depth) {
            Some((axis, middle)) => {
                let first = nodes.len();
                nodes[node] = Node { first: first as u32, count: 0, axis, ..nodes[node] };
                nodes.extend([nodes[node], nodes[node]]);
                let middle = from + middle;
                tasks.push(Task { node: first, start: from, end: middle, depth: depth + 1 });
                tasks.push(Task { node: first + 1, start: middle, end, depth: depth + 1 });
            }
            None => {
                // Within a leaf the scene's own order decides ties.
                part.sort_unstable();
                let first = (start + from) as u32;
                nodes[node] = Node { first, count: (end - from) as u32, axis: 0, ..nodes[node] };
            }
        }
    }
    nodes
}

/// Reorders `part` into two halves and returns the axis between them and the length of the first; `None` for a leaf.
fn split(bounds: &[Bounds], part: &mut [u32], whole: Bounds, kind: BvhKind, depth: usize) -> Option<(u8, usize)> {
    if part.len() <= 1 || kind == BvhKind::Flat {
        return None;
    }
    let centers = Bounds::around(part.iter().map(|&i| bounds[i as usize].center()));
    let extent = centers.max - centers.min;
    let widest = if extent.x >= extent.y && extent.x >= extent.z {
        0
    } else if extent.y >= extent.z {
        1
    } else {
        2
    };
    let chosen = if kind == BvhKind::Sah && depth < SAH_DEPTH {
        match best_plane(bounds, part, whole, centers) {
            Plane::Leaf if part.len() <= LEAF_SIZE => return None,
            Plane::Leaf => None,
            Plane::Split { axis, bin } => {
                let middle = partition(part, |&i| bin_of(bounds[i as usize].center()[axis], axis, centers) <= bin);
                Some((axis as u8, middle))
            }
        }
    } else if part.len() <= LEAF_SIZE {
        return None;
    } else {
        None
    };
    chosen.or_else(|| {
        let middle = part.len() / 2;
        let key = |i: &u32| bounds[*i as usize].center()[widest];
        part.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        Some((widest as u8, middle))
    })
}

enum Plane {
    Leaf,
    Split { axis: usize, bin: usize },
}

fn bin_of(center: f64, axis: usize, centers: Bounds) -> usize {
    let (low, high) = (centers.min[axis], centers.max[axis]);
    (((center - low) / (high - low) * BINS as f64) as usize).min(BINS - 1)
}

fn best_plane(bounds: &[Bounds], part: &[u32], whole: Bounds, centers: Bounds) -> Plane {
    let area = whole.half_area();
    // A leaf as large as allowed must beat a split; a larger one is no choice.
    let mut best_cost = if part.len() <= LEAF_SIZE { part.len() as f64 * area } else { f64::INFINITY };
    let mut best = Plane::Leaf;
    for axis in 0..3 {
        if centers.max[axis] <= centers.min[axis] {
            continue;
        }
        let mut bins = [(Bounds::EMPTY, 0usize); BINS];
        for &i in part {
            let bin = &mut bins[bin_of(bounds[i as usize].center()[axis], axis, centers)];
            *bin = (bin.0.union(bounds[i as usize]), bin.1 + 1);
        }
        let mut right = [(0.0, 0usize); BINS];
        let (mut around, mut count) = (Bounds::EMPTY, 0);
        for i in (1..BINS).rev() {
            around = around.union(bins[i].0);
            count += bins[i].1;
            right[i] = (around.half_area(), count);
        }
        let (mut around, mut count) = (Bounds::EMPTY, 0);
        for bin in 0..BINS - 1 {
            around = around.union(bins[bin].0);
            count += bins[bin].1;
            let (right_area, right_count) = right[bin + 1];
            if count == 0 || right_count == 0 {
                continue;
            }
            let cost = NODE_COST * area + around.half_area() * count as f64 + right_area * right_count as f64;
            if cost < best_cost {
                best_cost = cost;
                best = Plane::Split { axis, bin };
            }
        }
    }
    best
}

/// Moves the elements that satisfy `first` to the front and returns how many there are.
fn partition(part: &mut [u32], first: impl Fn(&u32) -> bool) -> usize {
    let mut count = 0;
    for i in 0..part.len() {
        if first(&part[i]) {
            part.swap(i, count);
            count += 1;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn cube(x: f64) -> Bounds {
        Bounds::around([DVec3::splat(x), DVec3::splat(x + 0.5)])
    }

    fn depth(bvh: &Bvh<f32>, node: usize) -> usize {
        let Node { first, count, .. } = bvh.nodes[node];
        if count > 0 { 1 } else { 1 + depth(bvh, first as usize).max(depth(bvh, first as usize + 1)) }
    }

    #[test]
    fn holds_every_primitive_once_whatever_the_input() {
        let spread: Vec<Bounds> = (0..1000).map(|i| cube(f64::from(i % 37) * 1.3)).collect();
        let same: Vec<Bounds> = (0..100_000).map(|_| cube(1.0)).collect();
        let powers: Vec<Bounds> = (0..200).map(|i| cube(2f64.powi(i - 100))).collect();
        for boxes in [vec![], vec![cube(0.0)], spread, same, powers] {
            for kind in [BvhKind::Sah, BvhKind::Median, BvhKind::Flat] {
                let bvh = Bvh::<f32>::build(&boxes, kind);
                let mut order = bvh.order.clone();
                order.sort_unstable();
                assert!(order.iter().copied().eq(0..boxes.len() as u32));
                if !boxes.is_empty() {
                    assert!(depth(&bvh, 0) <= MAX_DEPTH);
                }
            }
        }
    }
}
