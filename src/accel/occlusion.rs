//! What lies between a point and a light: shadow rays.

use super::bounds::Reciprocal;
use super::build::MAX_DEPTH;
use super::geometry::{Geometry, Item, Shape};
use super::single::{Prepared, alone, attenuate_alone};
use super::traverse::{Course, intersect_item};
use crate::lanes::{Lanes, Mask, Real, V3, lanes_of};
use crate::ray::Rays;
use crate::shape::Shear;
use std::cmp::Ordering;

/// What a surface does to a shadow ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blockers {
    /// It blocks.
    Opaque,
    /// It attenuates by its transmission, once for each time it is crossed.
    Transmissive,
}

/// How much of each colour passes along each active ray between `t_min` and `t_max`.
///
/// The order of factors decides the last bit of a product, and the order of traversal depends on the other rays and on
/// the scene's order. So the factors are gathered, and multiplied by size.
#[inline(always)]
pub fn transmittance<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    root: usize,
    blockers: Blockers,
    mut rays: Rays<L>,
    course: Course,
) -> V3<L> {
    let mut passage = Passage { blocked: 0, crossings: Vec::new() };
    let cast = rays.active.bits();
    if course == Course::Apart && L::COUNT > 1 && geometries[root].is_deep() {
        let mut waiting = Vec::with_capacity(64);
        let prepared = Prepared::new(s, &geometries[root], &rays);
        for lane in lanes_of(cast) {
            let (ray, bit) = (alone(s, &rays, lane), 1 << lane);
            let prepared = prepared.alone(s, lane);
            if attenuate_alone(s, geometries, root, blockers, ray, &prepared, bit, &mut passage, &mut waiting) {
                passage.blocked |= bit;
            }
        }
    } else {
        attenuate(s, geometries, root, blockers, &mut rays, &mut passage);
    }
    let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
    // Equal factors have no order: most scenes have one kind of glass.
    if passage.crossings.windows(2).any(|pair| pair[0].1 != pair[1].1) {
        passage.crossings.sort_by(|(_, f), (_, g)| by_size(f, g));
    }
    let mut passed = V3 { x: one, y: one, z: one };
    for (lanes, factor) in passage.crossings {
        passed = V3::select(L::mask(s, lanes), passed.times(V3::splat(s, factor)), passed);
    }
    V3::select(L::mask(s, passage.blocked & cast), V3 { x: zero, y: zero, z: zero }, passed)
}

/// Some order of colours that does not depend on where they come from.
fn by_size<R: Real>(a: &[R; 3], b: &[R; 3]) -> Ordering {
    a.map(Real::to_f64).partial_cmp(&b.map(Real::to_f64)).unwrap_or(Ordering::Equal)
}

/// What shadow rays have met so far.
pub(super) struct Passage<R> {
    /// Lanes that something opaque blocks.
    pub(super) blocked: u32,
    /// Lanes that have crossed a surface, and its transmission.
    pub(super) crossings: Vec<(u32, [R; 3])>,
}

/// Gathers what the surfaces of one geometry let through, and switches off the lanes that are blocked.
fn attenuate<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    geometry: usize,
    blockers: Blockers,
    rays: &mut Rays<L>,
    passage: &mut Passage<L::Real>,
) {
    L::vectorize(
        s,
        #[inline(always)]
        || attenuate_in(s, geometries, geometry, blockers, rays, passage),
    );
}

#[inline(always)]
fn attenuate_in<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    geometry: usize,
    blockers: Blockers,
    rays: &mut Rays<L>,
    passage: &mut Passage<L::Real>,
) {
    let here = &geometries[geometry];
    let shear = if here.has_meshes { Shear::new(s, rays) } else { Shear::unused(s, rays) };
    let reciprocal = Reciprocal::new(s, rays);

    for &index in &here.unbounded {
        visit_unbounded(s, geometries, &here.items[index as usize], blockers, rays, &shear, passage);
    }
    if here.bvh.nodes.is_empty() {
        return;
    }
    let mut stack = [0u32; MAX_DEPTH + 1];
    let mut height = 1;
    while height > 0 && rays.any() {
        height -= 1;
        let node = &here.bvh.nodes[stack[height] as usize];
        let inside = reciprocal.crosses(s, &node.slab, rays);
        if !inside.any() {
            continue;
        }
        if node.axis().is_some() {
            stack[height] = node.first + 1;
            stack[height + 1] = node.first;
            height += 2;
            continue;
        }
        let waiting = rays.active & !inside;
        rays.active = inside;
        for primitive in &here.primitives[node.places()] {
            let item = &here.items[primitive.item as usize];
            visit(s, geometries, item, primitive.face, blockers, rays, &shear, passage);
        }
        rays.active = rays.active | waiting;
    }
}

#[inline(always)]
fn visit<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    item: &Item<L::Real>,
    face: u32,
    blockers: Blockers,
    rays: &mut Rays<L>,
    shear: &Shear<L>,
    passage: &mut Passage<L::Real>,
) {
    if let Shape::Instance(instance) = &item.shape {
        let mut inner = instance.rays_in(s, rays);
        if inner.any() {
            let past = rays.active & !inner.active;
            attenuate(s, geometries, instance.geometry as usize, blockers, &mut inner, passage);
            rays.active = inner.active | past;
        }
        return;
    }
    let blocked = attenuate_item(s, item, face, blockers, rays, shear, passage);
    passage.blocked |= blocked.bits();
    rays.active = rays.active & !blocked;
}

/// Gathers what one primitive of an item that is no instance lets through; the lanes that it blocks.
#[inline(always)]
pub(super) fn attenuate_item<L: Lanes>(
    s: L::Simd,
    item: &Item<L::Real>,
    face: u32,
    blockers: Blockers,
    rays: &Rays<L>,
    shear: &Shear<L>,
    passage: &mut Passage<L::Real>,
) -> L::Mask {
    if blockers == Blockers::Opaque || !item.lets_light_through() {
        return intersect_item(s, item, face, rays, shear).hit;
    }
    attenuate_through(s, item, face, rays, shear, passage);
    L::mask(s, 0)
}

/// [`visit`] for items without bounds. Compiled once, since they are few.
fn visit_unbounded<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    item: &Item<L::Real>,
    blockers: Blockers,
    rays: &mut Rays<L>,
    shear: &Shear<L>,
    passage: &mut Passage<L::Real>,
) {
    L::vectorize(
        s,
        #[inline(always)]
        || visit(s, geometries, item, 0, blockers, rays, shear, passage),
    );
}

/// Gathers an item's transmission for each crossing of one of its primitives.
#[inline(always)]
fn attenuate_through<L: Lanes>(
    s: L::Simd,
    item: &Item<L::Real>,
    face: u32,
    rays: &Rays<L>,
    shear: &Shear<L>,
    passage: &mut Passage<L::Real>,
) {
    // Each search starts behind the last crossing.
    let mut search = *rays;
    for _ in 0..most_crossings(&item.shape) {
        let meeting = intersect_item(s, item, face, &search, shear);
        if !meeting.hit.any() {
            break;
        }
        passage.crossings.push((meeting.hit.bits(), item.transmission));
        search.active = meeting.hit;
        search.t_min = meeting.t;
    }
}

/// Most crossings of a ray with one primitive.
pub(super) fn most_crossings<R>(shape: &Shape<R>) -> usize {
    match shape {
        Shape::Plane(_) | Shape::Disc(_) | Shape::Mesh(_) => 1,
        Shape::Sphere(_) | Shape::Cuboid(_) | Shape::Frustum(_) => 2,
        Shape::Torus(_) => 4,
        Shape::Instance(_) => unreachable!("instances are descended into, not met"),
    }
}
