//! Building the binary hierarchy from the top down, its upper levels on all threads.
//!
//! Boxes are in the kernel's format and already rounded outwards, so a union is exact: a node holds what its primitives'
//! boxes hold, in any order. A split depends on nothing but the primitives, so any number of threads builds the same tree.

use super::bounds::Slab;
use super::build_primitive::{Box4, BuildPrimitive, NodeBounds, centers};
use super::sah::{Binning, has_less_surface};
use crate::control;
use crate::lanes::Real;
use std::ops::Range;

/// Most primitives in a leaf.
const LEAF_SIZE: usize = 8;
/// Down to this depth the heuristic chooses; below it nodes are halved, so that the depth stays bounded.
const SAH_DEPTH: usize = 40;
/// Longest path, which bounds the stack of a search: [`SAH_DEPTH`], then at most 32 halvings of 2^32 primitives.
#[cfg(test)]
const MAX_DEPTH: usize = SAH_DEPTH + 33;

/// How nodes are split; pictures do not depend on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BvhKind {
    /// By the surface area heuristic.
    #[default]
    Sah,
    /// In the middle of the primitives, in their order along the widest axis.
    Median,
    /// Not at all: one leaf holds everything. Slow; tests compare the others with it.
    Flat,
}

/// A binary tree of boxes.
#[derive(Debug, Clone)]
pub struct Bvh<R> {
    pub(super) nodes: Vec<Node<R>>,
}

/// A node: inner with two children side by side, or a leaf.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Node<R> {
    pub(super) slab: Slab<R>,
    /// First child, or for a leaf the index of its first primitive.
    pub(super) first: u32,
    /// Primitives of a leaf, or for an inner node one of the [`Division`]s.
    count: i32,
}

/// What divides the primitives of an inner node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Division {
    Place = -1,
    Kind = -2,
}

impl<R> Node<R> {
    fn inner(slab: Slab<R>, first: usize, division: Division) -> Self {
        Self { slab, first: first as u32, count: division as i32 }
    }

    /// Whether it holds primitives.
    #[inline(always)]
    pub(super) fn is_leaf(&self) -> bool {
        self.count >= 0
    }

    /// Whether its children are of two kinds.
    #[inline(always)]
    pub(super) fn divides_kinds(&self) -> bool {
        self.count == Division::Kind as i32
    }

    /// Indices of a leaf's primitives.
    #[inline(always)]
    pub(super) fn places(&self) -> Range<usize> {
        self.first as usize..self.first as usize + self.count as usize
    }
}

impl<R: Real> Bvh<R> {
    /// Builds a hierarchy over primitives and sorts them into the order of its leaves. Primitives that are a leaf of the wide
    /// hierarchy stay together: no search sees the levels below it.
    pub(super) fn build(
        primitives: &mut [BuildPrimitive<R>],
        kind: BvhKind,
        wholeness: &(impl Fn(&[BuildPrimitive<R>]) -> Wholeness + Sync),
    ) -> Self {
        let mut nodes = Vec::new();
        if !primitives.is_empty() {
            let tree = tree(primitives, 0, NodeBounds::of(primitives), Rule { kind, wholeness }, 0);
            nodes.reserve_exact(tree.len());
            nodes.push(Node { slab: Box4::empty().slab(), first: 0, count: 0 });
            tree.lay_out(0, &mut nodes);
            count_primitives(&mut nodes, primitives);
        }
        Self { nodes }
    }
}

/// Where leaves hold runs of primitives, makes them hold the primitives.
fn count_primitives<R: Real>(nodes: &mut [Node<R>], runs: &[BuildPrimitive<R>]) {
    let mut starts = Vec::with_capacity(runs.len() + 1);
    starts.push(0);
    starts.extend(runs.iter().scan(0, |end, run| {
        *end += run.count();
        Some(*end)
    }));
    for node in nodes.iter_mut().filter(|node| node.is_leaf()) {
        let Range { start, end } = node.places();
        (node.first, node.count) = (starts[start], (starts[end] - starts[start]) as i32);
    }
}

/// What is split, and what is not.
#[derive(Debug, Clone, Copy)]
struct Rule<F> {
    kind: BvhKind,
    wholeness: F,
}

/// What some primitives together may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wholeness {
    /// A leaf, always.
    Whole,
    /// A leaf, or one for each of two kinds. Bit i says whether the one at i is of the kind of the first.
    Pair { first: u32 },
    /// A leaf, if they are few and the heuristic says so.
    Any,
    /// No leaf.
    Apart,
}

/// Fewer primitives are built by one thread.
const PARALLEL: usize = 8192;

/// A hierarchy as it is built.
enum Tree<R> {
    /// Nodes by one thread; the first is the root, whose index is 0.
    Small(Vec<Node<R>>),
    Large {
        slab: Slab<R>,
        division: Division,
        children: Box<[Self; 2]>,
    },
}

impl<R: Real> Tree<R> {
    /// Number of nodes.
    fn len(&self) -> usize {
        match self {
            Self::Small(nodes) => nodes.len(),
            Self::Large { children, .. } => 1 + children[0].len() + children[1].len(),
        }
    }

    /// Puts the root at index `root` of `nodes`, and all below it at the end.
    fn lay_out(self, root: usize, nodes: &mut Vec<Node<R>>) {
        match self {
            Self::Small(own) => {
                let behind = nodes.len() as u32 - 1;
                let mut moved = own
                    .iter()
                    .map(|node| Node { first: node.first + if node.count < 0 { behind } else { 0 }, ..*node });
                if let Some(top) = moved.next() {
                    nodes[root] = top;
                }
                nodes.extend(moved);
            }
            Self::Large { slab, division, children } => {
                let first = nodes.len();
                nodes[root] = Node::inner(slab, first, division);
                nodes.extend([nodes[root]; 2]);
                let [left, right] = *children;
                left.lay_out(first, nodes);
                right.lay_out(first + 1, nodes);
            }
        }
    }
}

/// The hierarchy over `primitives`, the first of which has the index `start` in the order of the leaves.
fn tree<R: Real>(
    primitives: &mut [BuildPrimitive<R>],
    start: usize,
    bounds: NodeBounds<R>,
    rule: Rule<&(impl Fn(&[BuildPrimitive<R>]) -> Wholeness + Sync)>,
    depth: usize,
) -> Tree<R> {
    if primitives.len() > PARALLEL
        && let Some(Split { division, middle, halves: [left, right] }) = split(primitives, &bounds, rule, depth)
    {
        let (before, behind) = primitives.split_at_mut(middle);
        let (left, right) = rayon::join(
            || tree(before, start, left, rule, depth + 1),
            || tree(behind, start + middle, right, rule, depth + 1),
        );
        return Tree::Large { slab: bounds.around.slab(), division, children: Box::new([left, right]) };
    }
    Tree::Small(nodes(primitives, start, bounds, rule, depth))
}

struct Task<R> {
    node: usize,
    range: Range<usize>,
    bounds: NodeBounds<R>,
    depth: usize,
}

/// [`tree`], by one thread.
fn nodes<R: Real>(
    primitives: &mut [BuildPrimitive<R>],
    start: usize,
    bounds: NodeBounds<R>,
    rule: Rule<&impl Fn(&[BuildPrimitive<R>]) -> Wholeness>,
    depth: usize,
) -> Vec<Node<R>> {
    let leaf = |bounds: &NodeBounds<R>, range: &Range<usize>| Node {
        slab: bounds.around.slab(),
        first: (start + range.start) as u32,
        count: range.len() as i32,
    };
    let all = 0..primitives.len();
    let mut nodes = Vec::with_capacity(1 + primitives.len() / 4);
    nodes.push(leaf(&bounds, &all));
    let mut tasks = vec![Task { node: 0, range: all, bounds, depth }];
    while let Some(Task { node, range, bounds, depth }) = tasks.pop() {
        let Some(Split { division, middle, halves }) = split(&mut primitives[range.clone()], &bounds, rule, depth)
        else {
            continue;
        };
        let first = nodes.len();
        nodes[node] = Node::inner(nodes[node].slab, first, division);
        let middle = range.start + middle;
        for (side, (range, bounds)) in [range.start..middle, middle..range.end].into_iter().zip(halves).enumerate() {
            nodes.push(leaf(&bounds, &range));
            if range.len() > 1 {
                tasks.push(Task { node: first + side, range, bounds, depth: depth + 1 });
            }
        }
    }
    nodes
}

struct Split<R> {
    division: Division,
    /// Number of primitives in the first half, and the bounds of both halves.
    middle: usize,
    halves: [NodeBounds<R>; 2],
}

/// Reorders `primitives` into two halves; `None` for a leaf.
fn split<R: Real>(
    primitives: &mut [BuildPrimitive<R>],
    bounds: &NodeBounds<R>,
    Rule { kind, wholeness }: Rule<&impl Fn(&[BuildPrimitive<R>]) -> Wholeness>,
    depth: usize,
) -> Option<Split<R>> {
    // Once cancelled, what is left is one leaf.
    if control::step(1 + (primitives.len() / 64) as u32) {
        return None;
    }
    if primitives.len() <= 1 || kind == BvhKind::Flat {
        return None;
    }
    let wholeness = wholeness(primitives);
    if let (Wholeness::Pair { first }, BvhKind::Sah) = (wholeness, kind) {
        return split_kinds(primitives, bounds, first);
    }
    let count = || primitives.iter().map(BuildPrimitive::count).sum::<u32>() as usize;
    let may_be_leaf = primitives.len() <= LEAF_SIZE && count() <= LEAF_SIZE && wholeness != Wholeness::Apart;
    let is_leaf = matches!(wholeness, Wholeness::Whole | Wholeness::Pair { .. });
    if (may_be_leaf && kind == BvhKind::Median) || is_leaf {
        return None;
    }
    if kind == BvhKind::Sah && depth < SAH_DEPTH {
        let binning = Binning::new(&bounds.centers, primitives.len());
        let best = binning.best(primitives, &bounds.around);
        if may_be_leaf && best.is_none_or(|(plane, _)| plane.cost >= count() as f64) {
            return None;
        }
        if let Some((plane, [before, behind])) = best {
            let middle = partition(primitives, |_, primitive| binning.is_before(&plane, primitive));
            // In a pass of its own: where a primitive chose one of two boxes, they could not stay in registers.
            let (first, second) = primitives.split_at(middle);
            let halves = [
                NodeBounds { around: before, centers: centers(first) },
                NodeBounds { around: behind, centers: centers(second) },
            ];
            return Some(Split { division: Division::Place, middle, halves });
        }
    } else if may_be_leaf {
        return None;
    }
    let (_, [x, y, z, _]) = bounds.centers.sides();
    let axis = if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    };
    let middle = primitives.len() / 2;
    let key = |primitive: &BuildPrimitive<R>| (primitive.center()[axis].to_f64(), primitive.indices().start);
    primitives.select_nth_unstable_by(middle, |a, b| {
        let (a, b) = (key(a), key(b));
        a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
    });
    let (before, behind) = primitives.split_at(middle);
    Some(Split { division: Division::Place, middle, halves: [NodeBounds::of(before), NodeBounds::of(behind)] })
}

/// Splits primitives of two kinds that might be one leaf, if a ray that crosses their box will seldom cross both of theirs: a floor
/// has a flat one, which no ray that leaves it meets, and balls on it fill little of it. `first` has a bit for each, as
/// [`Wholeness::Pair`] does.
fn split_kinds<R: Real>(primitives: &mut [BuildPrimitive<R>], bounds: &NodeBounds<R>, first: u32) -> Option<Split<R>> {
    let of = |is_first: bool| {
        let of_kind = primitives.iter().enumerate().filter(|(i, _)| (first >> i & 1 == 1) == is_first);
        of_kind.fold(Box4::empty(), |around, (_, primitive)| around.union(primitive.0))
    };
    if !has_less_surface([of(true), of(false)], &bounds.around) {
        return None;
    }
    let middle = partition(primitives, |i, _| first >> i & 1 == 1);
    let (before, behind) = primitives.split_at(middle);
    Some(Split { division: Division::Kind, middle, halves: [NodeBounds::of(before), NodeBounds::of(behind)] })
}

/// Moves the primitives that are `first` to the front, and returns how many there are. It has no branch on a primitive, which no
/// processor could predict.
fn partition<R: Real>(
    primitives: &mut [BuildPrimitive<R>],
    first: impl Fn(usize, &BuildPrimitive<R>) -> bool,
) -> usize {
    let mut count = 0;
    for i in 0..primitives.len() {
        // What is swapped lies in front of it, so this one is still where it was.
        let is_first = first(i, &primitives[i]);
        primitives.swap(i, count);
        count += usize::from(is_first);
    }
    count
}

#[cfg(test)]
mod tests {
    use super::super::bounds::Bounds;
    use super::*;
    use glam::DVec3;

    fn cube(x: f64) -> Bounds {
        Bounds::around([DVec3::splat(x), DVec3::splat(x + 0.5)])
    }

    fn primitives(boxes: &[Bounds]) -> Vec<BuildPrimitive<f32>> {
        boxes.iter().zip(0..).map(|(b, i)| BuildPrimitive::new(&b.narrowed(), i, 1)).collect()
    }

    fn split_all(_: &[BuildPrimitive<f32>]) -> Wholeness {
        Wholeness::Any
    }

    fn few_are_whole(range: &[BuildPrimitive<f32>]) -> Wholeness {
        if range.len() <= 16 { Wholeness::Whole } else { Wholeness::Any }
    }

    fn depth(bvh: &Bvh<f32>, node: usize) -> usize {
        let node = &bvh.nodes[node];
        let first = node.first as usize;
        if node.is_leaf() { 1 } else { 1 + depth(bvh, first).max(depth(bvh, first + 1)) }
    }

    fn shapes() -> [Vec<Bounds>; 5] {
        let spread = (0..1000).map(|i| cube(f64::from(i % 37) * 1.3)).collect();
        let same = (0..100_000).map(|_| cube(1.0)).collect();
        let powers = (0..200).map(|i| cube(2f64.powi(i - 100))).collect();
        [vec![], vec![cube(0.0)], spread, same, powers]
    }

    #[test]
    fn holds_every_primitive_once_whatever_the_input() {
        for boxes in shapes() {
            for kind in [BvhKind::Sah, BvhKind::Median, BvhKind::Flat] {
                let mut primitives = primitives(&boxes);
                let bvh = Bvh::build(&mut primitives, kind, &split_all);
                let mut places: Vec<usize> =
                    bvh.nodes.iter().filter(|node| node.is_leaf()).flat_map(Node::places).collect();
                places.sort_unstable();
                assert!(places.into_iter().eq(0..boxes.len()));
                primitives.sort_unstable_by_key(|primitive| primitive.indices().start);
                assert!(primitives.iter().flat_map(BuildPrimitive::indices).eq(0..boxes.len()));
                if !boxes.is_empty() {
                    assert!(depth(&bvh, 0) <= MAX_DEPTH);
                }
            }
        }
    }

    #[test]
    fn any_number_of_threads_builds_the_same() {
        let boxes: Vec<Bounds> = (0..50_000).map(|i| cube(f64::from(i * 7919 % 50_021).sqrt())).collect();
        let built = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut primitives = primitives(&boxes);
            let bvh = pool.install(|| Bvh::build(&mut primitives, BvhKind::Sah, &split_all));
            (bvh.nodes, primitives)
        };
        let (nodes, order) = built(1);
        assert!(built(4) == (nodes, order));
    }

    #[test]
    fn what_is_a_leaf_stays_together() {
        let boxes: Vec<Bounds> = (0..1000).map(|i| cube(f64::from(i % 37) * 1.3)).collect();
        let (mut whole, mut split) = (primitives(&boxes), primitives(&boxes));
        let whole = Bvh::build(&mut whole, BvhKind::Sah, &few_are_whole);
        let split = Bvh::build(&mut split, BvhKind::Sah, &split_all);
        let leaves = |bvh: &Bvh<f32>| bvh.nodes.iter().filter(|node| node.is_leaf()).count();
        assert!(2 * leaves(&whole) <= leaves(&split), "{} {}", leaves(&whole), leaves(&split));
        // Above them nothing changes.
        assert!(whole.nodes.iter().all(|node| split.nodes.iter().any(|other| other.slab == node.slab)));
    }

    /// Balls that stand apart on a floor have a box of their own; those that fill the box of both do not.
    #[test]
    fn kinds_are_divided_where_their_boxes_have_less_surface() {
        let floor = Bounds::around([DVec3::ZERO, DVec3::new(20.0, 0.0, 20.0)]);
        for (ball, divided) in [(cube(1.0), true), (Bounds::around([DVec3::ZERO, DVec3::splat(20.0)]), false)] {
            let mut primitives = primitives(&[floor, ball, floor, ball]);
            let wholeness = |range: &[BuildPrimitive<f32>]| match range.len() {
                4 => Wholeness::Pair { first: 0b0101 },
                _ => Wholeness::Whole,
            };
            let bvh = Bvh::build(&mut primitives, BvhKind::Sah, &wholeness);
            assert_eq!(bvh.nodes.iter().filter(|node| node.is_leaf()).count(), if divided { 2 } else { 1 });
            assert_eq!(bvh.nodes[0].divides_kinds(), divided);
            let mut first: Vec<usize> = primitives[..2].iter().flat_map(BuildPrimitive::indices).collect();
            first.sort_unstable();
            assert_eq!(first, if divided { [0, 2] } else { [0, 1] });
        }
    }

    #[test]
    fn a_node_is_around_what_is_below_it() {
        for boxes in shapes() {
            let mut primitives = primitives(&boxes);
            let bvh = Bvh::build(&mut primitives, BvhKind::Sah, &split_all);
            for node in &bvh.nodes {
                let below = match node.is_leaf() {
                    true => primitives[node.places()]
                        .iter()
                        .fold(Box4::empty(), |around, primitive| around.union(primitive.0))
                        .slab(),
                    false => {
                        let [a, b] = [0, 1].map(|side| bvh.nodes[node.first as usize + side].slab);
                        Slab {
                            min: std::array::from_fn(|i| a.min[i].min(b.min[i])),
                            max: std::array::from_fn(|i| a.max[i].max(b.max[i])),
                        }
                    }
                };
                assert_eq!(node.slab, below);
            }
        }
    }
}
