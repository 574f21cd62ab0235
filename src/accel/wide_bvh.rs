//! The wide hierarchy: each node has one box for each lane, and each leaf one sphere or triangle for each lane. So one ray
//! is tested against all of them at once, or all rays of a packet against one.
//!
//! It is made from the binary hierarchy by leaving out most of its levels (Wald, Benthin, Boulos, Getting Rid of Packets,
//! 2008).

use super::bounds::Slab;
use super::build::{Bvh, Node, Wholeness};
use super::build_primitive::BuildPrimitive;
use super::item::{Item, Primitive, Shape};
use super::leaf_numbers::LeafNumbers;
use crate::lanes::{MAX_LANES, Real};
use crate::shape::Sides;
use rayon::prelude::*;
use std::ops::Range;

/// A hierarchy over the primitives of a binary one, in the order of its leaves.
#[derive(Debug, Clone)]
pub(super) struct WideBvh<R> {
    pub(super) nodes: Vec<WideNode<R>>,
    pub(super) leaves: Vec<Leaf>,
    pub(super) root: Child,
    /// Coordinates of what is in the leaves.
    pub(super) numbers: LeafNumbers<R>,
}

/// The boxes of a node's children, axis by axis.
#[derive(Debug, Clone)]
pub(super) struct WideNode<R> {
    pub(super) min: [[R; MAX_LANES]; 3],
    pub(super) max: [[R; MAX_LANES]; 3],
    pub(super) children: [Child; MAX_LANES],
    pub(super) count: u32,
}

/// A node or a leaf: the index of either, doubled, plus 1 for leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Child(u32);

impl Child {
    fn node(index: usize) -> Self {
        Self(index as u32 * 2)
    }

    fn leaf(index: usize) -> Self {
        Self(index as u32 * 2 + 1)
    }

    /// Index of a node, or else of a leaf.
    pub(super) fn index(self) -> Result<usize, usize> {
        let index = (self.0 / 2) as usize;
        if self.0.is_multiple_of(2) { Ok(index) } else { Err(index) }
    }
}

/// Primitives at `start` and after in the order of the leaves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leaf {
    pub(super) start: u32,
    pub(super) count: u32,
    /// Where its numbers begin, among those of its group in large hierarchies.
    pub(super) row: u32,
    pub(super) kind: Kind,
    /// Whether the next leaf has the same box: what is of several kinds is one leaf for each.
    pub(super) more: bool,
}

impl Leaf {
    pub(super) fn places(&self) -> Range<usize> {
        self.start as usize..(self.start + self.count) as usize
    }
}

/// What a leaf holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    Spheres(Sides),
    Triangles(Sides),
    Frusta {
        sides: Sides,
        capped: bool,
    },
    /// Anything, tested one by one.
    Mixed,
}

impl<R: Real> WideBvh<R> {
    /// Everything in one leaf, tested one by one. Slow; tests compare the others with it.
    pub(super) fn flat(slab: Slab<R>, count: usize) -> Self {
        let leaf = Leaf { start: 0, count: count as u32, row: 0, kind: Kind::Mixed, more: false };
        let mut wide = Self {
            nodes: Vec::new(),
            leaves: vec![leaf],
            root: Child::leaf(0),
            numbers: LeafNumbers::Ready(Box::default()),
        };
        wide.wrap(slab);
        wide
    }

    /// Puts a node around a root that is a leaf, so that no primitive is tested against a ray that misses the box around it.
    /// Triangles that are tiny for their distance rely on that.
    fn wrap(&mut self, slab: Slab<R>) {
        if self.root.index().is_ok() {
            return;
        }
        let mut node = WideNode::waiting(1);
        for axis in 0..3 {
            (node.min[axis][0], node.max[axis][0]) = (slab.min[axis], slab.max[axis]);
        }
        node.children[0] = self.root;
        self.nodes.push(node);
        self.root = Child::node(self.nodes.len() - 1);
    }

    /// The leaves that have the box of the one at `first`: one for each kind in it.
    pub(super) fn leaves_of_box(&self, first: usize) -> &[Leaf] {
        let more = self.leaves[first..].iter().take_while(|leaf| leaf.more).count();
        &self.leaves[first..=first + more]
    }

    /// From a binary hierarchy that is not empty. Sorts the primitives of each leaf by their kinds.
    pub(super) fn new(bvh: &Bvh<R>, items: &[Item<R>], primitives: &mut [Primitive]) -> Self {
        let below = below(bvh, items, primitives);
        sort_leaves(items, &below, primitives);
        let mut wide =
            Self { nodes: Vec::new(), leaves: Vec::new(), root: Child(0), numbers: LeafNumbers::Ready(Box::default()) };
        let collapse = Collapse { bvh, below: &below, items, primitives };
        wide.root = wide.child(&collapse, 0);
        let mut next = 0;
        // Until a node is filled, its `count` is the index of its binary node.
        while next < wide.nodes.len() {
            let binary = wide.nodes[next].count as usize;
            let children = collapse.opened(binary);
            let (zero, mut node) = (R::default(), wide.nodes[next].clone());
            for axis in 0..3 {
                node.min[axis] = [zero; MAX_LANES];
                node.max[axis] = [zero; MAX_LANES];
                for (lane, &child) in children.iter().enumerate() {
                    node.min[axis][lane] = bvh.nodes[child].slab.min[axis];
                    node.max[axis][lane] = bvh.nodes[child].slab.max[axis];
                }
            }
            node.count = children.len() as u32;
            for (lane, &child) in children.iter().enumerate() {
                node.children[lane] = wide.child(&collapse, child);
            }
            wide.nodes[next] = node;
            next += 1;
        }
        wide.wrap(bvh.nodes[0].slab);
        wide.nodes.shrink_to_fit();
        wide.leaves.shrink_to_fit();
        wide.numbers = LeafNumbers::new(&mut wide.leaves, items, primitives);
        wide
    }

    /// The leaf, or the node to be filled, that a binary node becomes.
    fn child(&mut self, collapse: &Collapse<'_, R>, binary: usize) -> Child {
        if let Some(leaf) = collapse.leaf(binary) {
            let first = self.leaves.len();
            self.push_leaves(leaf, collapse.items, collapse.primitives);
            return Child::leaf(first);
        }
        self.nodes.push(WideNode::waiting(binary as u32));
        Child::node(self.nodes.len() - 1)
    }

    /// Adds one leaf for each kind in a leaf of the binary hierarchy.
    fn push_leaves(&mut self, below: &Below, items: &[Item<R>], primitives: &[Primitive]) {
        let of = |primitive: &Primitive| kind_of(&items[primitive.item as usize]);
        let (mut start, is_pure) = (below.start, below.kinds.0.count_ones() == 1);
        for same in primitives[below.places()].chunk_by(|a, b| is_pure || of(a) == of(b)) {
            // A cancelled hierarchy may have more in a leaf than lanes.
            for part in same.chunks(R::LANES) {
                let (kind, count) = (of(&part[0]), part.len() as u32);
                self.leaves.push(Leaf { start, count, row: 0, kind, more: true });
                start += count;
            }
        }
        if let Some(last) = self.leaves.last_mut() {
            last.more = false;
        }
    }
}

/// Sorts the primitives of each leaf by their kinds.
fn sort_leaves<R: Real>(items: &[Item<R>], below: &[Below], primitives: &mut [Primitive]) {
    for below in below.iter().filter(|below| below.leaves == 1 && below.kinds.0.count_ones() > 1) {
        primitives[below.places()].sort_by_key(|primitive| kind_of(&items[primitive.item as usize]));
    }
}

impl<R: Real> WideNode<R> {
    /// A node without children yet.
    fn waiting(count: u32) -> Self {
        let none = [[R::default(); MAX_LANES]; 3];
        Self { min: none, max: none, children: [Child(0); MAX_LANES], count }
    }
}

/// What some primitives may be together. Few of at most two kinds are tested as quickly as one. Each placed geometry has a box of
/// its own: to enter it costs more than a node.
pub(super) fn wholeness<R: Real>(
    items: &[Item<R>],
    runs: &[BuildPrimitive<R>],
    item_of: impl Fn(&BuildPrimitive<R>) -> u32,
) -> Wholeness {
    let count = || runs.iter().map(BuildPrimitive::count).sum::<u32>();
    if runs.len() > R::LANES || count() > R::LANES as u32 {
        return Wholeness::Any;
    }
    let (mut kinds, mut instances) = (Kinds::default(), false);
    let (mut known, mut first) = (None, 0);
    for (place, run) in runs.iter().enumerate() {
        let item = &items[item_of(run) as usize];
        let kind = kind_of(item);
        first |= u32::from(*known.get_or_insert(kind) == kind) << place;
        kinds = kinds.with(Kinds::of(kind));
        instances |= matches!(item.shape, Shape::Instance(_));
    }
    match () {
        () if kinds.are_whole() && kinds.0.count_ones() > 1 => Wholeness::Pair { first },
        () if kinds.are_whole() => Wholeness::Whole,
        () if instances && runs.len() > 1 => Wholeness::Apart,
        () => Wholeness::Any,
    }
}

fn kind_of<R>(item: &Item<R>) -> Kind {
    match &item.shape {
        Shape::Sphere(_) => Kind::Spheres(item.sides),
        Shape::Mesh(_) => Kind::Triangles(item.sides),
        Shape::Frustum(frustum) => Kind::Frusta { sides: item.sides, capped: frustum.capped },
        _ => Kind::Mixed,
    }
}

/// A set of kinds, one bit for each.
#[derive(Debug, Clone, Copy, Default)]
struct Kinds(u32);

impl Kinds {
    const MIXED: u32 = 1;

    fn of(kind: Kind) -> Self {
        let bit = |first: u32, sides: Sides| 1 << (first + sides as u32);
        Self(match kind {
            Kind::Mixed => Self::MIXED,
            Kind::Spheres(sides) => bit(1, sides),
            Kind::Triangles(sides) => bit(4, sides),
            Kind::Frusta { sides, capped: false } => bit(7, sides),
            Kind::Frusta { sides, capped: true } => bit(10, sides),
        })
    }

    fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether a leaf of these is tested as a whole.
    fn are_whole(self) -> bool {
        self.0 & Self::MIXED == 0 && self.0.count_ones() <= 2
    }
}

/// What is below a binary node.
#[derive(Debug, Clone, Copy)]
struct Below {
    /// All primitives there, as their start and count.
    start: u32,
    count: u32,
    kinds: Kinds,
    /// Number of leaves.
    leaves: u32,
}

impl Below {
    fn inner(a: Self, b: Self, divides_kinds: bool, lanes: usize) -> Self {
        let (count, kinds) = (a.count + b.count, a.kinds.with(b.kinds));
        let fits = kinds.are_whole() && count as usize <= lanes && !divides_kinds;
        Self { start: a.start, count, kinds, leaves: if fits { 1 } else { a.leaves + b.leaves } }
    }

    fn places(&self) -> Range<usize> {
        self.start as usize..(self.start + self.count) as usize
    }
}

/// What is below each binary node. Children come behind their parents.
fn below<R: Real>(bvh: &Bvh<R>, items: &[Item<R>], primitives: &[Primitive]) -> Vec<Below> {
    let alone = |node: &Node<R>| {
        let places = node.places();
        let kind = |primitive: &Primitive| Kinds::of(kind_of(&items[primitive.item as usize]));
        let kinds = primitives[places.clone()].iter().map(kind).fold(Kinds::default(), Kinds::with);
        Below { start: places.start as u32, count: places.len() as u32, kinds, leaves: 1 }
    };
    let inner = Below { start: 0, count: 0, kinds: Kinds::default(), leaves: 0 };
    let each = bvh.nodes.par_iter().map(|node| if node.is_leaf() { alone(node) } else { inner });
    let mut below: Vec<Below> = each.collect();
    for (index, node) in bvh.nodes.iter().enumerate().rev() {
        if !node.is_leaf() {
            let first = node.first as usize;
            below[index] = Below::inner(below[first], below[first + 1], node.divides_kinds(), R::LANES);
        }
    }
    below
}

struct Collapse<'a, R> {
    bvh: &'a Bvh<R>,
    below: &'a [Below],
    items: &'a [Item<R>],
    primitives: &'a [Primitive],
}

impl<R: Real> Collapse<'_, R> {
    /// What is in the leaf that a binary node becomes.
    fn leaf(&self, binary: usize) -> Option<&Below> {
        let below = &self.below[binary];
        (below.leaves == 1).then_some(below)
    }

    /// The descendants of a binary node that become the children of one wide node: the largest is replaced by its children
    /// while there is room. A descendant whose children would all be leaves is replaced completely or not at all, so that
    /// nodes are well filled.
    fn opened(&self, binary: usize) -> Vec<usize> {
        let leaves = |child: usize| self.below[child].leaves as usize;
        let with_area = |child: usize| (self.bvh.nodes[child].slab.half_area(), child);
        let (mut children, mut open) = (Vec::with_capacity(R::LANES), Vec::with_capacity(R::LANES));
        children.push(with_area(binary));
        loop {
            let room = R::LANES - children.len();
            let fits = |child: usize| leaves(child) > 1 && (leaves(child) > R::LANES || leaves(child) - 1 <= room);
            let openable = (0..children.len()).filter(|&i| room > 0 && fits(children[i].1));
            let Some(largest) = openable.max_by(|&a, &b| children[a].0.total_cmp(&children[b].0)) else {
                return children.into_iter().map(|(_, child)| child).collect();
            };
            let (_, opened) = children.swap_remove(largest);
            let completely = leaves(opened) <= R::LANES;
            open.push(opened);
            while let Some(node) = open.pop() {
                let first = self.bvh.nodes[node].first as usize;
                for child in [first, first + 1] {
                    if completely && leaves(child) > 1 {
                        open.push(child);
                    } else {
                        children.push(with_area(child));
                    }
                }
            }
        }
    }
}
