//! The nearest meeting of each ray of a packet.

use super::bounds::Reciprocal;
use super::build::MAX_DEPTH;
use super::geometry::{Ball, Geometry, Instance, Item, Placement, Shape};
use super::resolve::splat_corners;
use super::single::{First, Prepared, alone, closest_alone};
use crate::lanes::{Ids, Lanes, MAX_LANES, Mask, Real, V3, lanes_of};
use crate::ray::{Meeting, Rays, Wanted};
use crate::shape::{Shear, intersect_triangle};
use std::ops::Range;

/// The nearest primitive of each lane so far. Its distance is the rays' `t_max`.
#[derive(Debug, Clone, Copy)]
pub struct Nearest<'a, L: Lanes> {
    /// Lanes that have one.
    pub found: u32,
    /// Expanded index of the primitive.
    pub expanded: L::Ids,
    skipped: Option<&'a Skipped>,
}

impl<'a, L: Lanes> Nearest<'a, L> {
    /// No lane has a primitive yet.
    #[inline(always)]
    pub fn none(s: L::Simd) -> Self {
        Self { found: 0, expanded: L::Ids::splat(s, 0), skipped: None }
    }

    /// The same for rays that pass some bodies as if they were not there.
    #[inline(always)]
    pub fn without(s: L::Simd, skipped: &'a Skipped) -> Self {
        Self { skipped: Some(skipped), ..Self::none(s) }
    }

    /// Takes a primitive where it is nearer, or equally near and earlier in the scene; the latter makes the answer
    /// independent of the order of traversal.
    #[inline(always)]
    fn offer(&mut self, s: L::Simd, rays: &mut Rays<L>, hit: L::Mask, t: L, expanded: u64) {
        let mut nearer = (hit & t.lt(rays.t_max)).bits();
        let ties = (hit & t.eq(rays.t_max)).bits() & self.found;
        for lane in lanes_of(ties) {
            nearer |= u32::from(expanded < self.expanded.lane(lane)) << lane;
        }
        if let Some(skipped) = self.skipped {
            for lane in lanes_of(nearer) {
                nearer &= !(u32::from(skipped.has(lane, expanded)) << lane);
            }
        }
        if nearer != 0 {
            let nearer_mask = L::mask(s, nearer);
            rays.t_max = L::select(nearer_mask, t, rays.t_max);
            self.found |= nearer;
            self.expanded = L::Ids::select(nearer_mask, L::Ids::splat(s, expanded), self.expanded);
        }
    }
}

/// Bodies that each lane does not meet, as ranges of expanded indices.
#[derive(Debug, Clone)]
pub struct Skipped {
    /// One body of each lane, as its first index and the number of its primitives.
    pub first: [(u64, u64); MAX_LANES],
    /// Lanes and further bodies.
    pub more: Vec<(usize, Range<u64>)>,
}

impl Skipped {
    pub(super) fn has(&self, lane: usize, expanded: u64) -> bool {
        let (start, count) = self.first[lane];
        (start..start + count).contains(&expanded)
            || self.more.iter().any(|(other, body)| *other == lane && body.contains(&expanded))
    }
}

/// Whether the rays of a packet keep together: camera rays and the shadow rays from what they hit do, others rarely.
/// What they hit does not depend on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Course {
    /// They descend as a packet.
    Together,
    /// Each descends alone.
    Apart,
}

/// Finds the nearest primitive of each active ray in the scene whose root is `geometries[root]`. Shortens `t_max` to it.
#[inline(always)]
pub fn nearest_hit<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    root: usize,
    rays: &mut Rays<L>,
    nearest: &mut Nearest<'_, L>,
    course: Course,
) {
    if course == Course::Together || L::COUNT == 1 || !geometries[root].is_deep() {
        closest_hit(s, geometries, root, 0, rays, nearest);
        return;
    }
    let mut t = [L::Real::default(); MAX_LANES];
    let mut expanded = [0; MAX_LANES];
    let mut waiting = Vec::with_capacity(64);
    let prepared = Prepared::new(s, &geometries[root], rays);
    for lane in lanes_of(rays.active.bits()) {
        let ray = alone(s, rays, lane);
        let mut first =
            First { t: ray.t_max.lane(0), found: false, expanded: 0, lane, skipped: nearest.skipped, waiting };
        closest_alone(s, geometries, root, 0, ray, &prepared.alone(s, lane), &mut first);
        t[lane] = first.t;
        if first.found {
            nearest.found |= 1 << lane;
            expanded[lane] = first.expanded;
        }
        waiting = first.waiting;
    }
    rays.t_max = L::select(L::mask(s, nearest.found), L::load(s, &t), rays.t_max);
    nearest.expanded = L::Ids::from_fn(s, |lane| expanded[lane]);
}

/// Finds the nearest primitive of each active ray in `geometries[geometry]`, whose expanded indices start at `base`.
/// Shortens `t_max` to it.
fn closest_hit<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    geometry: usize,
    base: u64,
    rays: &mut Rays<L>,
    nearest: &mut Nearest<'_, L>,
) {
    L::vectorize(
        s,
        #[inline(always)]
        || closest_in(s, geometries, geometry, base, rays, nearest),
    );
}

#[inline(always)]
fn closest_in<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    geometry: usize,
    base: u64,
    rays: &mut Rays<L>,
    nearest: &mut Nearest<'_, L>,
) {
    let here = &geometries[geometry];
    let shear = if here.has_meshes { Shear::new(s, rays) } else { Shear::unused(s, rays) };
    let reciprocal = Reciprocal::new(s, rays);
    let active = rays.active;

    for &index in &here.unbounded {
        visit_unbounded(s, geometries, &here.items[index as usize], base, rays, &shear, nearest);
    }
    if here.bvh.nodes.is_empty() {
        return;
    }
    let nodes = &here.bvh.nodes;
    let mut stack = [0u32; MAX_DEPTH + 1];
    let mut height = 1;
    while height > 0 {
        height -= 1;
        let node = &nodes[stack[height] as usize];
        let inside = reciprocal.crosses(s, &node.slab, rays);
        let bits = inside.bits();
        if bits == 0 {
            continue;
        }
        if let Some(axis) = node.axis() {
            // The child nearer to the first ray goes on top.
            let lane = bits.trailing_zeros() as usize;
            let dir = [rays.dir.x, rays.dir.y, rays.dir.z][axis].lane(lane);
            let backwards = u32::from(dir < L::Real::from_f64(0.0));
            stack[height] = node.first + 1 - backwards;
            stack[height + 1] = node.first + backwards;
            height += 2;
            continue;
        }
        rays.active = inside;
        for primitive in &here.primitives[node.places()] {
            let item = &here.items[primitive.item as usize];
            visit(s, geometries, item, primitive.face, base, rays, &shear, nearest);
        }
        rays.active = active;
    }
}

/// Tests one primitive, or descends into an instance.
#[inline(always)]
fn visit<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    item: &Item<L::Real>,
    face: u32,
    base: u64,
    rays: &mut Rays<L>,
    shear: &Shear<L>,
    nearest: &mut Nearest<'_, L>,
) {
    let first = base + item.offset;
    if let Shape::Instance(instance) = &item.shape {
        let mut inner = instance.rays_in(s, rays);
        if !inner.any() {
            return;
        }
        closest_hit(s, geometries, instance.geometry as usize, first, &mut inner, nearest);
        rays.t_max = inner.t_max / L::splat(s, instance.unit);
        return;
    }
    // Ties are for `offer` to settle, so the range is closed at its far end here.
    let closed = Rays { t_max: rays.t_max * L::lit(s, 1.0 + 4.0 * L::Real::ROUNDOFF), ..*rays };
    let meeting = intersect_item(s, item, face, &closed, shear);
    nearest.offer(s, rays, meeting.hit, meeting.t, first + u64::from(face));
}

/// [`visit`] for items without bounds: planes, and instances that hold some. Compiled once, since they are few.
fn visit_unbounded<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    item: &Item<L::Real>,
    base: u64,
    rays: &mut Rays<L>,
    shear: &Shear<L>,
    nearest: &mut Nearest<'_, L>,
) {
    L::vectorize(
        s,
        #[inline(always)]
        || visit(s, geometries, item, 0, base, rays, shear, nearest),
    );
}

/// Distance of one primitive of an item that is no instance. The common shapes become part of the caller.
#[inline(always)]
pub(super) fn intersect_item<L: Lanes>(
    s: L::Simd,
    item: &Item<L::Real>,
    face: u32,
    rays: &Rays<L>,
    shear: &Shear<L>,
) -> Meeting<L> {
    match &item.shape {
        Shape::Sphere(sphere) => sphere.intersect(s, rays, item.sides),
        Shape::Mesh(mesh) => {
            intersect_triangle(s, splat_corners(s, &mesh.vertices, mesh.faces[face as usize]), rays, shear, item.sides)
        }
        _ => intersect_called(s, item, face, rays, shear, Wanted::Distance),
    }
}

/// [`intersect_item`] as a function of its own: a copy of each shape in every caller would only cost compile time.
pub(super) fn intersect_called<L: Lanes>(
    s: L::Simd,
    item: &Item<L::Real>,
    face: u32,
    rays: &Rays<L>,
    shear: &Shear<L>,
    wanted: Wanted,
) -> Meeting<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || match &item.shape {
            Shape::Sphere(sphere) => sphere.intersect(s, rays, item.sides),
            Shape::Mesh(mesh) => {
                intersect_triangle(s, splat_corners(s, &mesh.vertices, mesh.faces[face as usize]), rays, shear, item.sides)
            }
            Shape::Plane(plane) => plane.intersect(s, rays, item.sides),
            Shape::Disc(disc) => disc.intersect(s, rays, item.sides),
            Shape::Cuboid(cuboid) => cuboid.intersect(s, rays, item.sides),
            Shape::Frustum(frustum) => frustum.intersect(s, rays, item.sides, wanted),
            Shape::Torus(torus) => torus.intersect(s, rays, item.sides),
            Shape::Instance(_) => unreachable!("instances are descended into, not met"),
        },
    )
}

impl<R: Real> Placement<R> {
    #[inline(always)]
    fn columns<L: Lanes<Real = R>>(&self, s: L::Simd) -> [V3<L>; 3] {
        let [x, y, z] = self.columns;
        [V3::splat(s, x), V3::splat(s, y), V3::splat(s, z)]
    }

    /// The image of a point.
    #[inline(always)]
    pub(super) fn point<L: Lanes<Real = R>>(&self, s: L::Simd, p: V3<L>) -> V3<L> {
        V3::splat(s, self.translation) + self.vector(s, p)
    }

    /// The image of a direction.
    #[inline(always)]
    pub(super) fn vector<L: Lanes<Real = R>>(&self, s: L::Simd, d: V3<L>) -> V3<L> {
        let [x, y, z] = self.columns(s);
        x * d.x + y * d.y + z * d.z
    }

    /// The transposed linear part, applied to a normal.
    #[inline(always)]
    pub(super) fn transposed<L: Lanes<Real = R>>(&self, s: L::Simd, n: V3<L>) -> V3<L> {
        let [x, y, z] = self.columns::<L>(s);
        V3 { x: x.dot(n), y: y.dot(n), z: z.dot(n) }
    }

    /// The image of a box of errors: absolute values throughout.
    #[inline(always)]
    pub(super) fn spread<L: Lanes<Real = R>>(&self, s: L::Simd, e: V3<L>) -> V3<L> {
        let [x, y, z] = self.columns::<L>(s);
        x.abs() * e.x + y.abs() * e.y + z.abs() * e.z
    }
}

impl<R: Real> Instance<R> {
    /// Rays in the coordinates of the instance's geometry, without those that pass by; t is multiplied by the unit.
    #[inline(always)]
    pub(super) fn rays_in<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>) -> Rays<L> {
        let active = match &self.ball {
            Some(ball) => rays.active & ball.near(s, rays),
            None => rays.active,
        };
        let unit = L::splat(s, self.unit);
        Rays {
            origin: self.to_local.point(s, rays.origin),
            dir: self.to_local.vector(s, rays.dir) * (L::lit(s, 1.0) / unit),
            t_min: rays.t_min * unit,
            t_max: rays.t_max * unit,
            active,
        }
    }
}

impl<R: Real> Ball<R> {
    /// The lanes whose line passes the ball: |(o - c) x d| <= r |d|, where each side may be off by roundings of |o - c|.
    #[inline(always)]
    fn near<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>) -> L::Mask {
        let f = rays.origin - V3::splat(s, self.center);
        let across = f.cross(rays.dir);
        let reach = L::splat(s, self.radius) + f.length() * L::lit(s, 16.0 * R::ROUNDOFF);
        across.dot(across).le(reach * reach * rays.dir.dot(rays.dir))
    }
}
