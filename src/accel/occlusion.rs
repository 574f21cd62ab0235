//! What lies between a point and a light: shadow rays.

use super::bounds::Reciprocal;
use super::build::MAX_DEPTH;
use super::geometry::{Geometry, Item, Shape};
use super::traverse::{intersect_called, intersect_item};
use crate::lanes::{Lanes, Mask, Real, V3};
use crate::ray::Rays;
use crate::shape::Shear;

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
/// One traversal in a fixed order, whatever the rays, because the order of factors decides the last bit of a product.
pub fn transmittance<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    root: usize,
    blockers: Blockers,
    mut rays: Rays<L>,
) -> V3<L> {
    let one = L::lit(s, 1.0);
    let mut passed = V3 { x: one, y: one, z: one };
    attenuate(s, geometries, root, blockers, &mut rays, &mut passed);
    passed
}

/// Multiplies `passed` by what the surfaces of one geometry let through and switches off the lanes that are dark.
fn attenuate<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    geometry: usize,
    blockers: Blockers,
    rays: &mut Rays<L>,
    passed: &mut V3<L>,
) {
    L::vectorize(
        s,
        #[inline(always)]
        || attenuate_in(s, geometries, geometry, blockers, rays, passed),
    );
}

#[inline(always)]
fn attenuate_in<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    geometry: usize,
    blockers: Blockers,
    rays: &mut Rays<L>,
    passed: &mut V3<L>,
) {
    let here = &geometries[geometry];
    let shear = if here.has_meshes { Shear::new(s, rays) } else { Shear::unused(s, rays) };
    let reciprocal = Reciprocal::new(s, rays);

    for &index in &here.unbounded {
        visit_unbounded(s, geometries, &here.items[index as usize], blockers, rays, &shear, passed);
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
        if node.count == 0 {
            stack[height] = node.first + 1;
            stack[height + 1] = node.first;
            height += 2;
            continue;
        }
        let waiting = rays.active & !inside;
        rays.active = inside;
        for &place in &here.bvh.order[node.first as usize..(node.first + node.count) as usize] {
            let primitive = here.primitives[place as usize];
            let item = &here.items[primitive.item as usize];
            visit(s, geometries, item, primitive.face, blockers, rays, &shear, passed);
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
    passed: &mut V3<L>,
) {
    if let Shape::Instance(instance) = &item.shape {
        let mut inner = instance.rays_in(s, rays);
        if inner.any() {
            let past = rays.active & !inner.active;
            attenuate(s, geometries, instance.geometry as usize, blockers, &mut inner, passed);
            rays.active = inner.active | past;
        }
        return;
    }
    let zero = L::lit(s, 0.0);
    let nothing = V3 { x: zero, y: zero, z: zero };
    let clear = item.transmission.map(|c| c > L::Real::from_f64(0.0)).contains(&true);
    if blockers == Blockers::Opaque || !clear {
        let hit = intersect_item(s, item, face, rays, shear).hit;
        *passed = V3::select(hit, nothing, *passed);
        rays.active = rays.active & !hit;
        return;
    }
    attenuate_through(s, item, face, rays, shear, passed);
}

/// [`visit`] for items without bounds. Compiled once, since they are few.
fn visit_unbounded<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    item: &Item<L::Real>,
    blockers: Blockers,
    rays: &mut Rays<L>,
    shear: &Shear<L>,
    passed: &mut V3<L>,
) {
    L::vectorize(
        s,
        #[inline(always)]
        || visit(s, geometries, item, 0, blockers, rays, shear, passed),
    );
}

/// Multiplies `passed` by an item's transmission for each crossing of one of its primitives.
#[inline(always)]
fn attenuate_through<L: Lanes>(
    s: L::Simd,
    item: &Item<L::Real>,
    face: u32,
    rays: &mut Rays<L>,
    shear: &Shear<L>,
    passed: &mut V3<L>,
) {
    let zero = L::lit(s, 0.0);
    // A ray may cross a body up to four times (torus); each search starts behind the last crossing.
    let filter = V3::splat(s, item.transmission);
    let mut search = *rays;
    for _ in 0..MAX_CROSSINGS {
        let meeting = intersect_called(s, item, face, &search, shear);
        if !meeting.hit.any() {
            break;
        }
        *passed = V3::select(meeting.hit, passed.times(filter), *passed);
        search.active = meeting.hit;
        search.t_min = meeting.t;
    }
    let dark = passed.x.le(zero) & passed.y.le(zero) & passed.z.le(zero);
    rays.active = rays.active & !dark;
}

/// Most crossings of a ray with one primitive.
const MAX_CROSSINGS: usize = 4;
