//! The hierarchy for single rays: nodes of as many boxes, and leaves of as many spheres or triangles, as the format has
//! lanes, so that one ray is tested against all of them at once.
//!
//! It is the binary hierarchy with most of its levels left out (Wald, Benthin, Boulos, Getting Rid of Packets, 2008).
//! Boxes and primitives are those of the binary one, and the formulas the same with the roles of ray and primitive
//! exchanged, so both find the same hits to the bit.

use super::build::{Bvh, Node};
use super::geometry::{Item, Primitive, Shape};
use crate::lanes::{MAX_LANES, Real};
use crate::shape::Sides;

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
        let kinds: Vec<Kind> = bvh.order.iter().map(|&i| kind(&items[primitives[i as usize].item as usize])).collect();
        let mut wide = Self {
            nodes: Vec::new(),
            leaves: Vec::new(),
            root: Child(0),
            columns: columns(bvh, items, primitives, &kinds),
        };
        let spans = spans(bvh);
        let collapse = Collapse { bvh, kinds: &kinds, spans: &spans };
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

/// First place and number of the primitives below each binary node. Children stand behind their parents.
fn spans<R>(bvh: &Bvh<R>) -> Vec<(u32, u32)> {
    let mut spans = vec![(0, 0); bvh.nodes.len()];
    for (index, node) in bvh.nodes.iter().enumerate().rev() {
        spans[index] = if node.count > 0 {
            (node.first, node.count)
        } else {
            let [a, b]: [(u32, u32); 2] = [spans[node.first as usize], spans[node.first as usize + 1]];
            (a.0.min(b.0), a.1 + b.1)
        };
    }
    spans
}

struct Collapse<'a, R> {
    bvh: &'a Bvh<R>,
    kinds: &'a [Kind],
    spans: &'a [(u32, u32)],
}

impl<R: Real> Collapse<'_, R> {
    /// The leaf for a binary node, if it is one or fits into the lanes.
    fn leaf(&self, binary: usize) -> Option<Leaf> {
        let (start, count) = self.spans[binary];
        let kinds = &self.kinds[start as usize..(start + count) as usize];
        let same = kinds.iter().all(|kind| *kind == kinds[0]) && kinds[0] != Kind::Mixed;
        if same && count as usize <= R::LANES {
            return Some(Leaf { start, count, kind: kinds[0] });
        }
        (self.bvh.nodes[binary].count > 0).then_some(Leaf { start, count, kind: Kind::Mixed })
    }

    /// The descendants of a binary node that become the children of one node: the largest is opened as long as there is
    /// room.
    fn opened(&self, binary: usize) -> Vec<usize> {
        let first = |node: &Node<R>| [node.first as usize, node.first as usize + 1];
        let mut children = first(&self.bvh.nodes[binary]).to_vec();
        while children.len() < R::LANES {
            let area = |child: &usize| self.bvh.nodes[*child].slab.half_area();
            let inner = (0..children.len()).filter(|&i| self.leaf(children[i]).is_none());
            let Some(largest) = inner.max_by(|&a, &b| area(&children[a]).total_cmp(&area(&children[b]))) else { break };
            let [a, b] = first(&self.bvh.nodes[children[largest]]);
            children[largest] = a;
            children.push(b);
        }
        children
    }
}

/// The columns of [`Wide`]; as many more numbers as there are lanes, so that whole bundles can be loaded at the end.
fn columns<R: Real>(bvh: &Bvh<R>, items: &[Item<R>], primitives: &[Primitive], kinds: &[Kind]) -> Vec<Vec<R>> {
    let count = if kinds.iter().any(|kind| matches!(kind, Kind::Triangles(_))) {
        9
    } else if kinds.iter().any(|kind| matches!(kind, Kind::Spheres(_))) {
        4
    } else {
        0
    };
    let mut columns: Vec<Vec<R>> = (0..count).map(|_| vec![R::default(); kinds.len() + MAX_LANES]).collect();
    for (place, &index) in bvh.order.iter().enumerate() {
        let primitive = primitives[index as usize];
        match &items[primitive.item as usize].shape {
            Shape::Sphere(sphere) => {
                let [x, y, z] = sphere.center;
                for (column, number) in columns.iter_mut().zip([x, y, z, sphere.radius]) {
                    column[place] = number;
                }
            }
            Shape::Mesh(mesh) => {
                let corners = mesh.corners(primitive.face as usize);
                for (column, number) in columns.iter_mut().zip(corners.as_flattened()) {
                    column[place] = *number;
                }
            }
            _ => {}
        }
    }
    columns
}
