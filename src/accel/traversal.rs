//! Traversal of a node: which rays go on to which children.
//!
//! A node is tested in the cheapest of three ways: all its boxes against bounds on all rays, where the rays are coherent;
//! each box against all rays; or all boxes against each ray (not with one lane). So coherent rays cost little, and
//! incoherent ones cost no more than alone. The answer does not depend on the way.

use super::bounds::Reciprocal;
use super::geometry::Geometry;
use super::packet_bounds::PacketBounds;
use super::wide_bvh::{Child, WideNode};
use crate::lanes::{Lanes, MAX_LANES, Mask, Real, V3, lanes_of};
use crate::ray::Rays;
use crate::shape::Shear;
use smallvec::SmallVec;

/// With more items without bounds a search looks whether it is cancelled before it tests them all.
pub(super) const MANY: usize = 64;
/// For fewer rays, bounds on all of them do not pay.
const FEWEST_RAYS: u32 = 4;

/// A child still to visit.
#[derive(Debug, Clone, Copy)]
pub(super) struct StackEntry<R> {
    pub(super) child: Child,
    /// The rays that pass its box.
    pub(super) lanes: u32,
    /// A lower bound on where they enter it.
    pub(super) enter: R,
}

/// The children still to visit, the next one last.
pub(super) type Stack<R> = SmallVec<[StackEntry<R>; 64]>;

/// Whether the rays of a packet are coherent: camera rays and the shadow rays from what they hit are, others rarely. What
/// they hit does not depend on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Coherence {
    /// Most of them meet the same boxes.
    Coherent,
    /// They meet different boxes.
    Incoherent,
}

/// Rays, prepared for the boxes and triangles of one geometry.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prepared<L: Lanes> {
    pub(super) reciprocal: Reciprocal<L>,
    bounds: Option<PacketBounds<L::Real>>,
    /// All rays of the search.
    active: L::Mask,
    shear: Option<Shear<L>>,
}

impl<L: Lanes> Prepared<L> {
    /// Prepares rays for a geometry.
    #[inline(always)]
    pub(super) fn new(s: L::Simd, here: &Geometry<L::Real>, rays: &Rays<L>, coherence: Coherence) -> Self {
        let reciprocal = Reciprocal::new(s, rays);
        let many = L::COUNT > 1
            && coherence == Coherence::Coherent
            && here.wide.as_ref().is_some_and(|wide| wide.nodes.len() > 1);
        let bounds = if many { PacketBounds::new(s, rays, &reciprocal) } else { None };
        Self { reciprocal, bounds, active: rays.active, shear: None }
    }

    /// The shear of the rays, computed when they come to the first triangle.
    #[inline(always)]
    pub(super) fn shear(&mut self, s: L::Simd, rays: &Rays<L>) -> &Shear<L> {
        if self.shear.is_none() {
            self.shear = Some(Shear::new(s, &Rays { active: self.active, ..*rays }));
        }
        self.shear.as_ref().unwrap_or_else(|| unreachable!("it has just been made"))
    }

    /// Stacks the children of a node that some of the rays `lanes` pass, the nearest last.
    pub(super) fn open(
        &self,
        s: L::Simd,
        node: &WideNode<L::Real>,
        lanes: u32,
        rays: &Rays<L>,
        stack: &mut Stack<L::Real>,
    ) {
        L::vectorize(
            s,
            #[inline(always)]
            || self.open_in(s, node, lanes, rays, stack),
        );
    }

    #[inline(always)]
    fn open_in(&self, s: L::Simd, node: &WideNode<L::Real>, lanes: u32, rays: &Rays<L>, stack: &mut Stack<L::Real>) {
        let top = stack.len();
        let (count, children) = (lanes.count_ones(), first(node.count));
        match &self.bounds {
            Some(bounds) if count >= FEWEST_RAYS => {
                let (inside, enter) = bounds.crosses::<L>(s, node);
                // Copies stay in registers: what is stacked is none of them.
                let (reciprocal, rays) = (self.reciprocal, *rays);
                for child in lanes_of(inside.bits() & children) {
                    let lanes = box_against_rays(s, &reciprocal, node, child, lanes, &rays).0.bits();
                    let enter = enter.lane(child);
                    add(stack, top, StackEntry { child: node.children[child], lanes, enter });
                }
            }
            _ if node.count <= count || L::COUNT == 1 => {
                for child in lanes_of(children) {
                    let (inside, enter) = box_against_rays(s, &self.reciprocal, node, child, lanes, rays);
                    let enter = L::select(inside, enter, L::lit(s, f64::INFINITY)).smallest();
                    add(stack, top, StackEntry { child: node.children[child], lanes: inside.bits(), enter });
                }
            }
            _ if count == 1 => {
                let (inside, enter) =
                    boxes_against_ray(s, &self.reciprocal, node, lanes.trailing_zeros() as usize, rays);
                for child in lanes_of(inside.bits()) {
                    add(stack, top, StackEntry { child: node.children[child], lanes, enter: enter.lane(child) });
                }
            }
            _ => {
                // Of each child, the lanes of the rays that pass it as a sum of powers of two, which is exact.
                let zero = L::lit(s, 0.0);
                let (mut met, mut least, mut any) = (zero, L::lit(s, f64::INFINITY), 0);
                for lane in lanes_of(lanes) {
                    let (inside, enter) = boxes_against_ray(s, &self.reciprocal, node, lane, rays);
                    any |= inside.bits();
                    met = met + L::select(inside, L::lit(s, f64::from(1u32 << lane)), zero);
                    least = L::select(inside & enter.lt(least), enter, least);
                }
                let (mut lanes, mut enter) = ([L::Real::default(); MAX_LANES], [L::Real::default(); MAX_LANES]);
                met.store(&mut lanes);
                least.store(&mut enter);
                for child in lanes_of(any) {
                    let lanes = lanes[child].to_f64() as u32;
                    add(stack, top, StackEntry { child: node.children[child], lanes, enter: enter[child] });
                }
            }
        }
    }
}

/// The rays of `lanes` that pass one child's box, and where they enter.
#[inline(always)]
fn box_against_rays<L: Lanes>(
    s: L::Simd,
    reciprocal: &Reciprocal<L>,
    node: &WideNode<L::Real>,
    child: usize,
    lanes: u32,
    rays: &Rays<L>,
) -> (L::Mask, L) {
    let corner = |at: &[[L::Real; MAX_LANES]; 3]| V3::splat(s, [at[0][child], at[1][child], at[2][child]]);
    let asked = Rays { active: L::mask(s, lanes), ..*rays };
    reciprocal.crosses_boxes(s, corner(&node.min), corner(&node.max), &asked)
}

/// The children whose boxes one ray passes, and where it enters them.
#[inline(always)]
fn boxes_against_ray<L: Lanes>(
    s: L::Simd,
    reciprocal: &Reciprocal<L>,
    node: &WideNode<L::Real>,
    lane: usize,
    rays: &Rays<L>,
) -> (L::Mask, L) {
    let ray = rays.alone(s, lane, first(node.count));
    let corner =
        |at: &[[L::Real; MAX_LANES]; 3]| V3 { x: L::load(s, &at[0]), y: L::load(s, &at[1]), z: L::load(s, &at[2]) };
    reciprocal.alone(s, lane).crosses_boxes(s, corner(&node.min), corner(&node.max), &ray)
}

/// Stacks a child that some rays pass, below nearer ones of the same node.
#[inline(always)]
fn add<R: Real>(stack: &mut Stack<R>, top: usize, waiting: StackEntry<R>) {
    if waiting.lanes == 0 {
        return;
    }
    let mut place = stack.len();
    stack.push(waiting);
    while place > top && stack[place - 1].enter < waiting.enter {
        stack[place] = stack[place - 1];
        place -= 1;
    }
    stack[place] = waiting;
}

/// The first `count` lanes.
pub(super) fn first(count: u32) -> u32 {
    ((1u64 << count) - 1) as u32
}
