//! The nearest hit of each ray of a packet.

use super::geometry::Geometry;
use super::intersect::hit_item;
use super::item::{Item, Shape};
use super::leaf_numbers::Row;
use super::traversal::{Coherence, MANY, Prepared, Stack, StackEntry, first};
use super::wide_bvh::{Kind, Leaf, WideBvh};
use crate::control;
use crate::lanes::{Ids, Lanes, MAX_LANES, Mask, Real, lanes_of};
use crate::ray::{Hit, Rays};
use crate::shape::{Sides, hit_frusta, hit_sphere, hit_triangle};
use std::ops::Range;

/// The nearest primitive of each lane so far. Its distance is the rays' `t_max`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nearest<'a, L: Lanes> {
    /// Lanes that have one.
    pub found: u32,
    /// Expanded index of the primitive.
    pub expanded: L::Ids,
    /// Barycentric weights of the hit on it, for triangles.
    pub weights: [L; 3],
    skipped: Option<&'a Skipped>,
}

impl<'a, L: Lanes> Nearest<'a, L> {
    /// No lane has a primitive yet.
    #[inline(always)]
    pub(crate) fn none(s: L::Simd) -> Self {
        let zero = L::lit(s, 0.0);
        Self { found: 0, expanded: L::Ids::splat(s, 0), weights: [zero, zero, zero], skipped: None }
    }

    /// The same for rays that skip some bodies.
    #[inline(always)]
    pub(crate) fn without(s: L::Simd, skipped: &'a Skipped) -> Self {
        Self { skipped: Some(skipped), ..Self::none(s) }
    }

    /// Takes a primitive where it is nearer, or equally near and earlier in the scene. So the answer does not depend on the
    /// order of traversal.
    #[inline(always)]
    fn offer(&mut self, s: L::Simd, rays: &mut Rays<L>, hit: &Hit<L>, expanded: u64) {
        let Hit { t, lanes, weights: [b0, b1, b2] } = *hit;
        let mut nearer = (lanes & t.lt(rays.t_max)).bits();
        let ties = (lanes & t.eq(rays.t_max)).bits() & self.found;
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
            let weights = &mut self.weights;
            weights[0] = L::select(nearer_mask, b0, weights[0]);
            weights[1] = L::select(nearer_mask, b1, weights[1]);
            weights[2] = L::select(nearer_mask, b2, weights[2]);
        }
    }

    /// The same for one lane's ray and several primitives, one for each lane of `hits`.
    #[inline(always)]
    fn offer_alone(
        &mut self,
        s: L::Simd,
        rays: &mut Rays<L>,
        lane: usize,
        hits: &Hit<L>,
        expanded: impl Fn(usize) -> u64,
    ) {
        let t_max = rays.t_max.lane(lane);
        let held = (self.found & (1 << lane) != 0).then(|| self.expanded.lane(lane));
        let found = match self.skipped {
            None => nearest_of(s, hits, t_max, held, expanded),
            Some(skipped) => nearest_unskipped(hits, t_max, held, expanded, |id| skipped.has(lane, id)),
        };
        if let Some((place, id)) = found {
            let mask = L::mask(s, 1 << lane);
            rays.t_max = L::select(mask, L::splat(s, hits.t.lane(place)), rays.t_max);
            self.found |= 1 << lane;
            self.expanded = L::Ids::select(mask, L::Ids::splat(s, id), self.expanded);
            for (held, weight) in self.weights.iter_mut().zip(hits.weights) {
                *held = L::select(mask, L::splat(s, weight.lane(place)), *held);
            }
        }
    }
}

/// The place and the expanded index of the nearest of one ray's hits, if that is nearer than `t_max`, or as near and earlier
/// in the scene than what the ray `held`. Expanded indices are far away in memory: only that of the nearest is looked up.
#[inline(always)]
fn nearest_of<L: Lanes>(
    s: L::Simd,
    hits: &Hit<L>,
    t_max: L::Real,
    held: Option<u64>,
    expanded: impl Fn(usize) -> u64,
) -> Option<(usize, u64)> {
    let lanes = hits.lanes.bits();
    // Most often it is one, and the smallest of all lanes takes long to know.
    if lanes.is_power_of_two() {
        let place = lanes.trailing_zeros() as usize;
        let t = hits.t.lane(place);
        if t > t_max {
            return None;
        }
        let id = expanded(place);
        return (t < t_max || held.is_some_and(|held| id < held)).then_some((place, id));
    }
    let best = L::select(hits.lanes, hits.t, L::lit(s, f64::INFINITY)).smallest();
    if best > t_max {
        return None;
    }
    let nearest = (hits.lanes & hits.t.eq(L::splat(s, best))).bits();
    let mut found: Option<(usize, u64)> = None;
    for place in lanes_of(nearest) {
        let id = expanded(place);
        if found.is_none_or(|(_, earlier)| id < earlier) {
            found = Some((place, id));
        }
    }
    found.filter(|(_, id)| best < t_max || held.is_some_and(|held| *id < held))
}

/// The same, one hit after the other, without those on bodies that the ray skips.
#[inline(always)]
fn nearest_unskipped<L: Lanes>(
    hits: &Hit<L>,
    t_max: L::Real,
    held: Option<u64>,
    expanded: impl Fn(usize) -> u64,
    skips: impl Fn(u64) -> bool,
) -> Option<(usize, u64)> {
    let (mut best, mut found) = (t_max, None);
    for place in lanes_of(hits.lanes.bits()) {
        let t = hits.t.lane(place);
        if t > best {
            continue;
        }
        let id = expanded(place);
        let held = found.map(|(_, id)| id).or(held);
        if (t < best || held.is_some_and(|held| id < held)) && !skips(id) {
            (best, found) = (t, Some((place, id)));
        }
    }
    found
}

/// Bodies that each lane skips, as ranges of expanded indices.
#[derive(Debug, Clone)]
pub(crate) struct Skipped {
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

/// Finds the nearest primitive of each active ray in the scene whose root is `geometries[root]`. Shortens `t_max` to it.
#[inline(always)]
pub(crate) fn nearest_hit<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    root: usize,
    rays: &mut Rays<L>,
    nearest: &mut Nearest<'_, L>,
    coherence: Coherence,
    time: Option<&L>,
) {
    let mut search = Search { geometries, coherence, time, nearest, stack: Stack::new() };
    search.closest(s, root, 0, rays);
}

struct Search<'a, 'b, L: Lanes> {
    geometries: &'a [Geometry<L::Real>],
    coherence: Coherence,
    /// When the rays are cast, if anything moves.
    time: Option<&'a L>,
    nearest: &'a mut Nearest<'b, L>,
    stack: Stack<L::Real>,
}

impl<L: Lanes> Search<'_, '_, L> {
    /// Finds the nearest primitive of each active ray in `geometries[geometry]`, whose expanded indices start at `base`.
    /// Shortens `t_max` to it.
    fn closest(&mut self, s: L::Simd, geometry: usize, base: u64, rays: &mut Rays<L>) {
        L::vectorize(
            s,
            #[inline(always)]
            || self.closest_in(s, geometry, base, rays),
        );
    }

    #[inline(always)]
    fn closest_in(&mut self, s: L::Simd, geometry: usize, base: u64, rays: &mut Rays<L>) {
        let here = &self.geometries[geometry];
        let mut prepared = Prepared::new(s, here, rays, self.coherence);
        if here.unbounded.len() > MANY && control::step(here.unbounded.len() as u32) {
            return;
        }
        for &index in &here.unbounded[..] {
            self.visit(s, &here.items[index as usize], 0, base, rays);
        }
        let Some(wide) = &here.wide else { return };
        let active = rays.active;
        let floor = self.stack.len();
        let enter = L::Real::from_f64(f64::NEG_INFINITY);
        self.stack.push(StackEntry { child: wide.root, lanes: active.bits(), enter });
        while self.stack.len() > floor {
            let Some(StackEntry { child, lanes, enter }) = self.stack.pop() else { break };
            let lanes = lanes & prepared.reciprocal.reaches(s, L::splat(s, enter), rays.t_max).bits();
            if lanes == 0 {
                continue;
            }
            match child.index() {
                Ok(node) => prepared.open(s, &wide.nodes[node], lanes, rays, &mut self.stack),
                Err(leaf) => {
                    if control::step(1) {
                        self.stack.truncate(floor);
                        break;
                    }
                    rays.active = L::mask(s, lanes);
                    let mut next = leaf;
                    loop {
                        let leaf = &wide.leaves[next];
                        self.intersect_leaf(s, here, wide, (leaf, next), base, rays, &mut prepared);
                        if !leaf.more {
                            break;
                        }
                        next += 1;
                    }
                }
            }
        }
        rays.active = active;
    }

    /// Tests the active rays against a leaf: each primitive against all rays, or each ray against all primitives.
    #[inline(always)]
    fn intersect_leaf(
        &mut self,
        s: L::Simd,
        here: &Geometry<L::Real>,
        wide: &WideBvh<L::Real>,
        (leaf, index): (&Leaf, usize),
        base: u64,
        rays: &mut Rays<L>,
        prepared: &mut Prepared<L>,
    ) {
        if leaf.kind == Kind::Mixed {
            let active = rays.active;
            for primitive in &here.primitives[leaf.places()] {
                self.visit(s, &here.items[primitive.item as usize], primitive.face, base, rays);
                rays.active = active;
            }
            return;
        }
        if let Kind::Frusta { sides, capped } = leaf.kind {
            self.intersect_frusta(s, here, leaf, &wide.row(leaf, index, here), (sides, capped), base, rays);
            return;
        }
        let row = wide.row(leaf, index, here);
        let start = leaf.start as usize;
        let expanded = |place: usize| {
            let primitive = here.primitives[start + place];
            base + here.items[primitive.item as usize].offset + u64::from(primitive.face)
        };
        let lanes = rays.active.bits();
        let each_alone = leaf.count <= lanes.count_ones() || L::COUNT == 1;
        match leaf.kind {
            Kind::Spheres(sides) if each_alone => {
                for place in 0..leaf.count as usize {
                    let (center, radius) = row.sphere(s, place);
                    let found = hit_sphere(s, center, radius, &closed(s, rays), sides);
                    if found.lanes.any() {
                        self.nearest.offer(s, rays, &found, expanded(place));
                    }
                }
            }
            Kind::Triangles(sides) if each_alone => {
                for place in 0..leaf.count as usize {
                    let triangle = row.triangle(s, place);
                    let found = hit_triangle(s, triangle, &closed(s, rays), prepared.shear(s, rays), sides);
                    if found.lanes.any() {
                        self.nearest.offer(s, rays, &found, expanded(place));
                    }
                }
            }
            Kind::Spheres(sides) => {
                let (center, radius) = row.spheres(s);
                for lane in lanes_of(lanes) {
                    let ray = closed(s, rays).alone(s, lane, first(leaf.count));
                    let found = hit_sphere(s, center, radius, &ray, sides);
                    if found.lanes.any() {
                        self.nearest.offer_alone(s, rays, lane, &found, expanded);
                    }
                }
            }
            Kind::Triangles(sides) => {
                let triangles = row.triangles(s);
                for lane in lanes_of(lanes) {
                    let ray = closed(s, rays).alone(s, lane, first(leaf.count));
                    let found = hit_triangle(s, triangles, &ray, &prepared.shear(s, rays).alone(s, lane), sides);
                    if found.lanes.any() {
                        self.nearest.offer_alone(s, rays, lane, &found, expanded);
                    }
                }
            }
            Kind::Frusta { .. } | Kind::Mixed => {}
        }
    }

    /// The same for frusta. Not inlined: scenes without them would take up to 2.7 % more instructions.
    fn intersect_frusta(
        &mut self,
        s: L::Simd,
        here: &Geometry<L::Real>,
        leaf: &Leaf,
        row: &Row<'_, L::Real>,
        (sides, capped): (Sides, bool),
        base: u64,
        rays: &mut Rays<L>,
    ) {
        L::vectorize(
            s,
            #[inline(always)]
            || self.intersect_frusta_in(s, here, leaf, row, (sides, capped), base, rays),
        );
    }

    #[inline(always)]
    fn intersect_frusta_in(
        &mut self,
        s: L::Simd,
        here: &Geometry<L::Real>,
        leaf: &Leaf,
        row: &Row<'_, L::Real>,
        (sides, capped): (Sides, bool),
        base: u64,
        rays: &mut Rays<L>,
    ) {
        let start = leaf.start as usize;
        let expanded = |place: usize| base + here.items[here.primitives[start + place].item as usize].offset;
        let lanes = rays.active.bits();
        if leaf.count <= lanes.count_ones() || L::COUNT == 1 {
            for place in 0..leaf.count as usize {
                let hit = hit_frusta(s, &row.frustum(s, place), capped, &closed(s, rays), sides);
                if hit.lanes.any() {
                    self.nearest.offer(s, rays, &hit, expanded(place));
                }
            }
            return;
        }
        let frusta = row.frusta(s);
        for lane in lanes_of(lanes) {
            let ray = closed(s, rays).alone(s, lane, first(leaf.count));
            let hits = hit_frusta(s, &frusta, capped, &ray, sides);
            if hits.lanes.any() {
                self.nearest.offer_alone(s, rays, lane, &hits, expanded);
            }
        }
    }

    /// Tests one primitive of any kind, or descends into an instance. Not inlined: few scenes hold many of these.
    fn visit(&mut self, s: L::Simd, item: &Item<L::Real>, face: u32, base: u64, rays: &mut Rays<L>) {
        L::vectorize(
            s,
            #[inline(always)]
            || self.visit_in(s, item, face, base, rays),
        );
    }

    #[inline(always)]
    fn visit_in(&mut self, s: L::Simd, item: &Item<L::Real>, face: u32, base: u64, rays: &mut Rays<L>) {
        let first = base + item.offset;
        if let Shape::Instance(instance) = &item.shape {
            if control::step(1) {
                return;
            }
            let mut inner = instance.rays_in(s, rays, self.time);
            if inner.any() {
                match self.geometries[instance.geometry as usize].lone_body() {
                    Some(body) => self.meet(s, body, 0, first + body.offset, &mut inner),
                    None => self.closest(s, instance.geometry as usize, first, &mut inner),
                }
                rays.t_max = inner.t_max / L::splat(s, instance.unit);
            }
            return;
        }
        self.meet(s, item, face, first + u64::from(face), rays);
    }

    /// Tests one primitive.
    #[inline(always)]
    fn meet(&mut self, s: L::Simd, item: &Item<L::Real>, face: u32, expanded: u64, rays: &mut Rays<L>) {
        let hit = hit_item(s, item, face, &closed(s, rays));
        self.nearest.offer(s, rays, &hit, expanded);
    }
}

/// The range is closed at its far end: [`Nearest::offer`] decides between equal distances.
#[inline(always)]
fn closed<L: Lanes>(s: L::Simd, rays: &Rays<L>) -> Rays<L> {
    Rays { t_max: rays.t_max * L::lit(s, 1.0 + 4.0 * L::Real::ROUNDOFF), ..*rays }
}
