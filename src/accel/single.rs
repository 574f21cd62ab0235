//! Rays that go their own ways: each lane of a packet descends alone, and tests as many boxes, spheres or triangles at once
//! as it has lanes.

use super::bounds::{Reciprocal, SLACK};
use super::geometry::{Geometry, Shape};
use super::occlusion::{Blockers, Passage, attenuate_item, most_crossings};
use super::traverse::{Skipped, intersect_item};
use super::wide::{Child, Kind, Leaf, Wide};
use crate::lanes::{Lanes, Mask, Real, V3, lanes_of};
use crate::ray::{Meeting, Rays, gamma};
use crate::shape::{Shear, intersect_sphere, intersect_triangle, sphere_crossings};

/// A bound on t, moved out by a factor above 1.
#[inline(always)]
fn widened<R: Real>(t: R, factor: R) -> R {
    if t < R::default() { t / factor } else { t * factor }
}

/// One lane's ray in all lanes.
#[inline(always)]
pub(super) fn alone<L: Lanes>(s: L::Simd, rays: &Rays<L>, lane: usize) -> Rays<L> {
    Rays {
        origin: V3::splat(s, rays.origin.lane(lane)),
        dir: V3::splat(s, rays.dir.lane(lane)),
        t_min: L::splat(s, rays.t_min.lane(lane)),
        t_max: L::splat(s, rays.t_max.lane(lane)),
        active: L::mask(s, lanes(L::COUNT as u32)),
    }
}

/// What boxes and triangles need of rays, for all rays of a packet at once: divisions are dear.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prepared<L: Lanes> {
    reciprocal: Reciprocal<L>,
    shear: Shear<L>,
}

impl<L: Lanes> Prepared<L> {
    /// Prepares rays for a geometry.
    #[inline(always)]
    pub(super) fn new(s: L::Simd, here: &Geometry<L::Real>, rays: &Rays<L>) -> Self {
        let shear = if here.has_meshes { Shear::new(s, rays) } else { Shear::unused(s, rays) };
        Self { reciprocal: Reciprocal::new(s, rays), shear }
    }

    /// One lane's ray, in all lanes.
    #[inline(always)]
    pub(super) fn alone(&self, s: L::Simd, lane: usize) -> Self {
        Self { reciprocal: self.reciprocal.alone(s, lane), shear: self.shear.alone(s, lane) }
    }
}

/// The first `count` lanes.
fn lanes(count: u32) -> u32 {
    ((1u64 << count) - 1) as u32
}

/// The nearest primitive of one ray so far.
pub(super) struct First<'a, R> {
    /// Its distance, or the end of the ray's range, in the units of the geometry that is being searched.
    pub(super) t: R,
    pub(super) found: bool,
    pub(super) expanded: u64,
    /// Which lane of the packet the ray comes from, and what it passes.
    pub(super) lane: usize,
    pub(super) skipped: Option<&'a Skipped>,
    /// Children still to visit, and where the ray enters them.
    pub(super) waiting: Vec<(Child, R)>,
}

impl<R: Real> First<'_, R> {
    /// Takes a primitive if it is nearer, or equally near and earlier in the scene.
    #[inline(always)]
    fn offer(&mut self, t: R, expanded: u64) {
        let nearer = t < self.t || (t == self.t && self.found && expanded < self.expanded);
        if nearer && !self.skipped.is_some_and(|skipped| skipped.has(self.lane, expanded)) {
            (self.t, self.found, self.expanded) = (t, true, expanded);
        }
    }
}

/// Finds the nearest primitive of one ray, which is in all lanes.
pub(super) fn closest_alone<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    geometry: usize,
    base: u64,
    ray: Rays<L>,
    prepared: &Prepared<L>,
    first: &mut First<'_, L::Real>,
) {
    L::vectorize(
        s,
        #[inline(always)]
        || closest_alone_in(s, geometries, geometry, base, ray, prepared, first),
    );
}

#[inline(always)]
fn closest_alone_in<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    geometry: usize,
    base: u64,
    mut ray: Rays<L>,
    Prepared { reciprocal, shear }: &Prepared<L>,
    first: &mut First<'_, L::Real>,
) {
    let here = &geometries[geometry];
    for &index in &here.unbounded {
        visit(s, geometries, here, index, 0, base, &mut ray, shear, first);
    }
    let Some(wide) = &here.wide else {
        for primitive in &here.primitives {
            visit(s, geometries, here, primitive.item, primitive.face, base, &mut ray, shear, first);
        }
        return;
    };
    let widen = L::Real::from_f64(1.0 + gamma::<L::Real>(SLACK));
    let floor = first.waiting.len();
    first.waiting.push((wide.root, ray.t_min.lane(0)));
    while first.waiting.len() > floor {
        let Some((child, enter)) = first.waiting.pop() else { break };
        if enter > widened(first.t, widen) {
            continue;
        }
        match child.index() {
            Ok(node) => {
                let node = &wide.nodes[node];
                ray.active = L::mask(s, lanes(node.count));
                let (inside, enter) = reciprocal.crosses_boxes(s, boxes(s, &node.min), boxes(s, &node.max), &ray);
                let top = first.waiting.len();
                for lane in lanes_of(inside.bits()) {
                    // Nearer children go on top.
                    let entry = (node.children[lane], enter.lane(lane));
                    let mut place = first.waiting.len();
                    first.waiting.push(entry);
                    while place > top && first.waiting[place - 1].1 < entry.1 {
                        first.waiting[place] = first.waiting[place - 1];
                        place -= 1;
                    }
                    first.waiting[place] = entry;
                }
            }
            Err(leaf) => {
                let leaf = &wide.leaves[leaf];
                if leaf.kind == Kind::Mixed {
                    for primitive in &here.primitives[leaf.places()] {
                        visit(s, geometries, here, primitive.item, primitive.face, base, &mut ray, shear, first);
                    }
                    continue;
                }
                let closed = Rays { t_max: ray.t_max * L::lit(s, 1.0 + 4.0 * L::Real::ROUNDOFF), ..ray };
                let meeting = meet_leaf(s, wide, leaf, closed, shear);
                for lane in lanes_of(meeting.hit.bits()) {
                    let t = meeting.t.lane(lane);
                    if t <= first.t {
                        let primitive = here.primitives[leaf.start as usize + lane];
                        let item = &here.items[primitive.item as usize];
                        first.offer(t, base + item.offset + u64::from(primitive.face));
                    }
                }
                ray.t_max = L::splat(s, first.t);
            }
        }
    }
}

/// A node's lower or upper corners.
#[inline(always)]
fn boxes<L: Lanes>(s: L::Simd, corners: &[[L::Real; crate::lanes::MAX_LANES]; 3]) -> V3<L> {
    V3 { x: L::load(s, &corners[0]), y: L::load(s, &corners[1]), z: L::load(s, &corners[2]) }
}

/// A ray against all spheres or triangles of a leaf.
#[inline(always)]
fn meet_leaf<L: Lanes>(
    s: L::Simd,
    wide: &Wide<L::Real>,
    leaf: &Leaf,
    mut ray: Rays<L>,
    shear: &Shear<L>,
) -> Meeting<L> {
    ray.active = L::mask(s, lanes(leaf.count));
    let column = |k: usize| L::load(s, &wide.columns[k][leaf.start as usize..]);
    let point = |k: usize| V3 { x: column(k), y: column(k + 1), z: column(k + 2) };
    match leaf.kind {
        Kind::Spheres(sides) => intersect_sphere(s, point(0), column(3), &ray, sides),
        Kind::Triangles(sides) => intersect_triangle(s, [point(0), point(3), point(6)], &ray, shear, sides),
        Kind::Mixed => Meeting::nowhere(s, &ray),
    }
}

/// Tests one primitive, or descends into an instance.
#[inline(always)]
fn visit<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    here: &Geometry<L::Real>,
    item: u32,
    face: u32,
    base: u64,
    ray: &mut Rays<L>,
    shear: &Shear<L>,
    first: &mut First<'_, L::Real>,
) {
    let item = &here.items[item as usize];
    ray.active = L::mask(s, 1);
    if let Shape::Instance(instance) = &item.shape {
        let inner = instance.rays_in(s, ray);
        if inner.any() {
            first.t = inner.t_max.lane(0);
            let prepared = Prepared::new(s, &geometries[instance.geometry as usize], &inner);
            closest_alone(s, geometries, instance.geometry as usize, base + item.offset, inner, &prepared, first);
            first.t = first.t / instance.unit;
            ray.t_max = L::splat(s, first.t);
        }
        return;
    }
    let closed = Rays { t_max: ray.t_max * L::lit(s, 1.0 + 4.0 * L::Real::ROUNDOFF), ..*ray };
    let meeting = intersect_item(s, item, face, &closed, shear);
    if meeting.hit.any() {
        first.offer(meeting.t.lane(0), base + item.offset + u64::from(face));
        ray.t_max = L::splat(s, first.t);
    }
}

/// Gathers what the surfaces of a geometry let through of one ray, which is in all lanes; whether it is blocked.
/// `bit` is its lane in the packet.
pub(super) fn attenuate_alone<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    geometry: usize,
    blockers: Blockers,
    ray: Rays<L>,
    prepared: &Prepared<L>,
    bit: u32,
    passage: &mut Passage<L::Real>,
    waiting: &mut Vec<Child>,
) -> bool {
    L::vectorize(
        s,
        #[inline(always)]
        || attenuate_alone_in(s, geometries, geometry, blockers, ray, prepared, bit, passage, waiting),
    )
}

#[inline(always)]
fn attenuate_alone_in<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    geometry: usize,
    blockers: Blockers,
    mut ray: Rays<L>,
    Prepared { reciprocal, shear }: &Prepared<L>,
    bit: u32,
    passage: &mut Passage<L::Real>,
    waiting: &mut Vec<Child>,
) -> bool {
    let here = &geometries[geometry];
    for &index in &here.unbounded {
        if passes(s, geometries, here, index, 0, blockers, &mut ray, shear, bit, passage, waiting) {
            return true;
        }
    }
    let Some(wide) = &here.wide else {
        for p in &here.primitives {
            if passes(s, geometries, here, p.item, p.face, blockers, &mut ray, shear, bit, passage, waiting) {
                return true;
            }
        }
        return false;
    };
    let floor = waiting.len();
    waiting.push(wide.root);
    while waiting.len() > floor {
        let Some(child) = waiting.pop() else { break };
        let blocked = match child.index() {
            Ok(node) => {
                let node = &wide.nodes[node];
                ray.active = L::mask(s, lanes(node.count));
                let (inside, _) = reciprocal.crosses_boxes(s, boxes(s, &node.min), boxes(s, &node.max), &ray);
                waiting.extend(lanes_of(inside.bits()).map(|lane| node.children[lane]));
                false
            }
            Err(leaf) => {
                let leaf = &wide.leaves[leaf];
                if leaf.kind == Kind::Mixed {
                    let mut blocked = false;
                    for p in &here.primitives[leaf.places()] {
                        blocked = blocked
                            || passes(
                                s, geometries, here, p.item, p.face, blockers, &mut ray, shear, bit, passage, waiting,
                            );
                    }
                    blocked
                } else {
                    crosses_leaf(s, here, wide, leaf, blockers, &ray, shear, bit, passage)
                }
            }
        };
        if blocked {
            waiting.truncate(floor);
            return true;
        }
    }
    false
}

/// Gathers the crossings of a leaf's spheres or triangles; whether one of them blocks.
#[inline(always)]
fn crosses_leaf<L: Lanes>(
    s: L::Simd,
    here: &Geometry<L::Real>,
    wide: &Wide<L::Real>,
    leaf: &Leaf,
    blockers: Blockers,
    ray: &Rays<L>,
    shear: &Shear<L>,
    bit: u32,
    passage: &mut Passage<L::Real>,
) -> bool {
    let item = |lane: usize| {
        let primitive = here.primitives[leaf.start as usize + lane];
        &here.items[primitive.item as usize]
    };
    if let Kind::Spheres(sides) = leaf.kind {
        let mut ray = *ray;
        ray.active = L::mask(s, lanes(leaf.count));
        let column = |k: usize| L::load(s, &wide.columns[k][leaf.start as usize..]);
        let center = V3 { x: column(0), y: column(1), z: column(2) };
        let crossed = sphere_crossings(s, center, column(3), &ray, sides);
        let met = (crossed[0] | crossed[1]).bits();
        if met != 0 && (blockers == Blockers::Opaque || lanes_of(met).any(|lane| !item(lane).lets_light_through())) {
            return true;
        }
        for mask in crossed {
            passage.crossings.extend(lanes_of(mask.bits()).map(|lane| (bit, item(lane).transmission)));
        }
        return false;
    }
    let mut search = *ray;
    let mut meeting = meet_leaf(s, wide, leaf, search, shear);
    let mut hit = meeting.hit.bits();
    if hit == 0 {
        return false;
    }
    if blockers == Blockers::Opaque || lanes_of(hit).any(|lane| !item(lane).lets_light_through()) {
        return true;
    }
    let mut crossings = most_crossings(&item(hit.trailing_zeros() as usize).shape);
    loop {
        passage.crossings.extend(lanes_of(hit).map(|lane| (bit, item(lane).transmission)));
        crossings -= 1;
        if crossings == 0 {
            return false;
        }
        search.t_min = L::select(meeting.hit, meeting.t, L::lit(s, f64::INFINITY));
        meeting = meet_leaf(s, wide, leaf, search, shear);
        hit = meeting.hit.bits();
        if hit == 0 {
            return false;
        }
    }
}

/// Gathers the crossings of one item's primitive, or descends into an instance; whether the ray is blocked.
#[inline(always)]
fn passes<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    here: &Geometry<L::Real>,
    item: u32,
    face: u32,
    blockers: Blockers,
    ray: &mut Rays<L>,
    shear: &Shear<L>,
    bit: u32,
    passage: &mut Passage<L::Real>,
    waiting: &mut Vec<Child>,
) -> bool {
    let item = &here.items[item as usize];
    ray.active = L::mask(s, 1);
    if let Shape::Instance(instance) = &item.shape {
        let inner = instance.rays_in(s, ray);
        if !inner.any() {
            return false;
        }
        let geometry = instance.geometry as usize;
        let prepared = Prepared::new(s, &geometries[geometry], &inner);
        return attenuate_alone(s, geometries, geometry, blockers, inner, &prepared, bit, passage, waiting);
    }
    let crossed = passage.crossings.len();
    let blocked = attenuate_item(s, item, face, blockers, ray, shear, passage);
    for crossing in &mut passage.crossings[crossed..] {
        crossing.0 = bit;
    }
    blocked.any()
}
