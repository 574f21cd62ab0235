//! The hierarchy for single rays: nodes of as many boxes, and leaves of as many spheres or triangles, as the format has
//! lanes, so that one ray is tested against all of them at once.
//!
//! It is the binary hierarchy with most of its levels left out (Wald, Benthin, Boulos, Getting Rid of Packets, 2008).
//! Boxes and primitives are those of the binary one, and the formulas the same with the roles of ray and primitive
//! exchanged, so both find the same hits to the bit.

use super::build::Bvh;
use super::geometry::{Item, Primitive, Shape};
use crate::lanes::{MAX_LANES, Real};
use crate::shape::{Sides, Sphere};
use rayon::prelude::*;
use std::ops::Range;

/// A hierarchy over the primitives of a binary one, in the order of its leaves.
#[derive(Debug, Clone)]
pub(super) struct Wide<R> {
    pub(super) nodes: Vec<WideNode<R>>,
    pub(super) leaves: Vec<Leaf>,
    pub(super) root: Child,
    /// Numbers of the spheres (centre, radius) and triangles (three corners), by place in the order of the leaves.
    pub(super) columns: Vec<Vec<R>>,
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
    pub(super) kind: Kind,
}

impl Leaf {
    pub(super) fn places(&self) -> Range<usize> {
        self.start as usize..(self.start + self.count) as usize
    }
}

/// What a leaf holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Spheres(Sides),
    Triangles(Sides),
    /// Anything, tested one by one.
    Mixed,
}

impl<R: Real> Wide<R> {
    /// Leaves out levels of a binary hierarchy that is not empty.
    pub(super) fn new(bvh: &Bvh<R>, items: &[Item<R>], primitives: &[Primitive]) -> Self {
        let columns = columns(items, primitives);
        let mut wide = Self { nodes: Vec::new(), leaves: Vec::new(), root: Child(0), columns };
        let kinds: Vec<Kind> = primitives.par_iter().map(|primitive| kind(&items[primitive.item as usize])).collect();
        let collapse = Collapse { bvh, kinds: &kinds };
        wide.root = wide.child(&collapse, 0);
        let mut next = 0;
        // Nodes wait with their binary node's index in place of the first child.
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
        wide.nodes.shrink_to_fit();
        wide.leaves.shrink_to_fit();
        wide
    }

    /// The leaf or the waiting node that a binary node becomes.
    fn child(&mut self, collapse: &Collapse<'_, R>, binary: usize) -> Child {
        if let Some(leaf) = collapse.leaf(binary) {
            self.leaves.push(leaf);
            return Child::leaf(self.leaves.len() - 1);
        }
        let none = [[R::default(); MAX_LANES]; 3];
        self.nodes.push(WideNode { min: none, max: none, children: [Child(0); MAX_LANES], count: binary as u32 });
        Child::node(self.nodes.len() - 1)
    }
}

fn kind<R>(item: &Item<R>) -> Kind {
    match &item.shape {
        Shape::Sphere(_) => Kind::Spheres(item.sides),
        Shape::Mesh(_) => Kind::Triangles(item.sides),
        _ => Kind::Mixed,
    }
}

struct Collapse<'a, R> {
    bvh: &'a Bvh<R>,
    kinds: &'a [Kind],
}

impl<R: Real> Collapse<'_, R> {
    fn children(&self, binary: usize) -> [usize; 2] {
        let first = self.bvh.nodes[binary].first as usize;
        [first, first + 1]
    }

    /// Places of the primitives below a binary node: from the first one of its first leaf to the last one of its last.
    fn places(&self, binary: usize) -> Range<usize> {
        let nodes = &self.bvh.nodes;
        let leaf = |side: usize| {
            let mut node = binary;
            while nodes[node].axis().is_some() {
                node = nodes[node].first as usize + side;
            }
            nodes[node].places()
        };
        leaf(0).start..leaf(1).end
    }

    /// The leaf for a binary node, if it is one or fits into the lanes.
    fn leaf(&self, binary: usize) -> Option<Leaf> {
        let places = self.places(binary);
        let (start, count) = (places.start as u32, places.len() as u32);
        if places.len() <= R::LANES {
            let kinds = &self.kinds[places];
            if kinds[0] != Kind::Mixed && kinds.iter().all(|kind| *kind == kinds[0]) {
                return Some(Leaf { start, count, kind: kinds[0] });
            }
        }
        self.bvh.nodes[binary].axis().is_none().then_some(Leaf { start, count, kind: Kind::Mixed })
    }

    /// The descendants of a binary node that become the children of one node: the largest is opened as long as there is
    /// room.
    fn opened(&self, binary: usize) -> Vec<usize> {
        // What cannot be opened has no area.
        let area = |child: usize| {
            if self.leaf(child).is_some() { -1.0 } else { self.bvh.nodes[child].slab.half_area() }
        };
        let mut children: Vec<(usize, f64)> = self.children(binary).map(|child| (child, area(child))).to_vec();
        while children.len() < R::LANES {
            let openable = (0..children.len()).filter(|&i| children[i].1 >= 0.0);
            let Some(largest) = openable.max_by(|&a, &b| children[a].1.total_cmp(&children[b].1)) else { break };
            let [a, b] = self.children(children[largest].0);
            children[largest] = (a, area(a));
            children.push((b, area(b)));
        }
        children.into_iter().map(|(child, _)| child).collect()
    }
}

/// Places of [`Wide::columns`] that one thread fills at a time.
const CHUNK: usize = 16_384;

/// The columns of [`Wide`]; as many more numbers as there are lanes, so that whole bundles can be loaded at the end.
fn columns<R: Real>(items: &[Item<R>], primitives: &[Primitive]) -> Vec<Vec<R>> {
    let has = |test: fn(&Shape<R>) -> bool| items.iter().any(|item| test(&item.shape));
    let count = match () {
        () if has(|shape| matches!(shape, Shape::Mesh(_))) => 9,
        () if has(|shape| matches!(shape, Shape::Sphere(_))) => 4,
        () => 0,
    };
    let mut columns: Vec<Vec<R>> = (0..count).map(|_| vec![R::default(); primitives.len() + MAX_LANES]).collect();
    let mut chunks: Vec<Vec<&mut [R]>> = primitives.chunks(CHUNK).map(|_| Vec::with_capacity(count)).collect();
    for column in &mut columns {
        for (chunk, numbers) in chunks.iter_mut().zip(column.chunks_mut(CHUNK)) {
            chunk.push(numbers);
        }
    }
    primitives.par_chunks(CHUNK).zip(chunks).for_each(|(primitives, mut columns)| {
        for (place, primitive) in primitives.iter().enumerate() {
            let mut fill = |numbers: &[R]| {
                for (column, number) in columns.iter_mut().zip(numbers) {
                    column[place] = *number;
                }
            };
            match &items[primitive.item as usize].shape {
                Shape::Sphere(Sphere { center: [x, y, z], radius, .. }) => fill(&[*x, *y, *z, *radius]),
                Shape::Mesh(mesh) => fill(mesh.corners(primitive.face as usize).as_flattened()),
                _ => {}
            }
        }
    });
    columns
}
