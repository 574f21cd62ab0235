//! Shadow rays: how much light passes between two points.

use super::crossings::Crossings;
use super::geometry::Geometry;
use super::intersect::hit_item;
use super::item::{Item, Shape};
use super::leaf_numbers::Row;
use super::traversal::{Coherence, MANY, Prepared, Stack, StackEntry, first};
use super::wide_bvh::{Kind, Leaf, WideBvh};
use crate::control;
use crate::lanes::{Lanes, Mask, Real, V3, lanes_of};
use crate::ray::Rays;
use crate::shape::{Frusta, Sides, frusta_crossings, hit_frusta, hit_triangle, sphere_crossings};

/// What a surface does to a shadow ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blockers {
    /// It blocks.
    Opaque,
    /// It blocks, unless it may be only partly there, which is asked later.
    Holed,
    /// It attenuates by its transmission, once for each time it is crossed; what may be only partly there is asked later.
    Transmissive,
}

impl Blockers {
    /// Whether no light passes an item.
    #[inline(always)]
    fn stop_at<R: Real>(self, item: &Item<R>) -> bool {
        match self {
            Self::Opaque => true,
            Self::Holed => !item.has_holes,
            Self::Transmissive => !item.has_holes && !item.lets_light_through(),
        }
    }
}

/// How much of each color passes along each active ray between `t_min` and `t_max`.
#[inline(always)]
pub(crate) fn transmittance<L: Lanes>(
    s: L::Simd,
    geometries: &[Geometry<L::Real>],
    root: usize,
    blockers: Blockers,
    mut rays: Rays<L>,
    coherence: Coherence,
    time: Option<&L>,
) -> V3<L> {
    let cast = rays.active.bits();
    let mut passage =
        ShadowSearch { geometries, blockers, coherence, time, crossings: Crossings::new(), stack: Stack::new() };
    passage.attenuate(s, root, &mut rays);
    let blocked = cast & !rays.active.bits();
    V3::select(L::mask(s, blocked), V3::splat(s, [L::Real::from_f64(0.0); 3]), passage.crossings.product(s))
}

/// Shadow rays on their way.
struct ShadowSearch<'a, L: Lanes> {
    geometries: &'a [Geometry<L::Real>],
    blockers: Blockers,
    coherence: Coherence,
    /// When the rays are cast, if anything moves.
    time: Option<&'a L>,
    crossings: Crossings<L::Real>,
    stack: Stack<L::Real>,
}

impl<L: Lanes> ShadowSearch<'_, L> {
    /// Collects the factors of the surfaces of one geometry, and switches off the lanes that are blocked.
    fn attenuate(&mut self, s: L::Simd, geometry: usize, rays: &mut Rays<L>) {
        L::vectorize(
            s,
            #[inline(always)]
            || self.attenuate_in(s, geometry, rays),
        );
    }

    #[inline(always)]
    fn attenuate_in(&mut self, s: L::Simd, geometry: usize, rays: &mut Rays<L>) {
        let here = &self.geometries[geometry];
        let mut prepared = Prepared::new(s, here, rays, self.coherence);
        if here.unbounded.len() > MANY && control::step(here.unbounded.len() as u32) {
            return;
        }
        for &index in &here.unbounded[..] {
            self.visit(s, &here.items[index as usize], 0, rays);
        }
        let Some(wide) = &here.wide else { return };
        let floor = self.stack.len();
        let enter = L::Real::from_f64(f64::NEG_INFINITY);
        self.stack.push(StackEntry { child: wide.root, lanes: rays.active.bits(), enter });
        while self.stack.len() > floor {
            let Some(StackEntry { child, lanes, .. }) = self.stack.pop() else { break };
            let lanes = lanes & rays.active.bits();
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
                    let waiting = rays.active & !L::mask(s, lanes);
                    rays.active = L::mask(s, lanes);
                    let mut next = leaf;
                    loop {
                        let leaf = &wide.leaves[next];
                        self.intersect_leaf(s, here, wide, (leaf, next), rays, &mut prepared);
                        if !leaf.more {
                            break;
                        }
                        next += 1;
                    }
                    rays.active = rays.active | waiting;
                    if !rays.any() {
                        self.stack.truncate(floor);
                    }
                }
            }
        }
    }

    /// Tests the active rays against a leaf: each primitive against all rays, or each ray against all primitives.
    #[inline(always)]
    fn intersect_leaf(
        &mut self,
        s: L::Simd,
        here: &Geometry<L::Real>,
        wide: &WideBvh<L::Real>,
        (leaf, index): (&Leaf, usize),
        rays: &mut Rays<L>,
        prepared: &mut Prepared<L>,
    ) {
        if leaf.kind == Kind::Mixed {
            for primitive in &here.primitives[leaf.places()] {
                self.visit(s, &here.items[primitive.item as usize], primitive.face, rays);
            }
            return;
        }
        let row = wide.row(leaf, index, here);
        if let Kind::Frusta { sides, capped } = leaf.kind {
            self.intersect_frusta(s, here, leaf, &row, (sides, capped), rays);
            return;
        }
        let (lanes, start, none) = (rays.active.bits(), leaf.start as usize, L::mask(s, 0));
        let each_alone = leaf.count <= lanes.count_ones() || L::COUNT == 1;
        match leaf.kind {
            Kind::Spheres(sides) if each_alone => {
                for place in 0..leaf.count as usize {
                    let (center, radius) = row.sphere(s, place);
                    self.cross_one(here, start + place, sphere_crossings(s, center, radius, rays, sides), rays);
                }
            }
            Kind::Triangles(sides) if each_alone => {
                for place in 0..leaf.count as usize {
                    let hit = hit_triangle(s, row.triangle(s, place), rays, prepared.shear(s, rays), sides);
                    self.cross_one(here, start + place, [hit.lanes, none], rays);
                }
            }
            Kind::Spheres(sides) => {
                let (center, radius) = row.spheres(s);
                for lane in lanes_of(lanes) {
                    let ray = rays.alone(s, lane, first(leaf.count));
                    self.cross_some(s, here, start, sphere_crossings(s, center, radius, &ray, sides), lane, rays);
                }
            }
            Kind::Triangles(sides) => {
                let corners = row.triangles(s);
                for lane in lanes_of(lanes) {
                    let ray = rays.alone(s, lane, first(leaf.count));
                    let hit = hit_triangle(s, corners, &ray, &prepared.shear(s, rays).alone(s, lane), sides);
                    self.cross_some(s, here, start, [hit.lanes, none], lane, rays);
                }
            }
            Kind::Frusta { .. } | Kind::Mixed => {}
        }
    }

    /// The same for frusta. Not inlined, so that scenes without them pay nothing.
    fn intersect_frusta(
        &mut self,
        s: L::Simd,
        here: &Geometry<L::Real>,
        leaf: &Leaf,
        row: &Row<'_, L::Real>,
        how: (Sides, bool),
        rays: &mut Rays<L>,
    ) {
        L::vectorize(
            s,
            #[inline(always)]
            || {
                let lanes = rays.active.bits();
                let start = leaf.start as usize;
                if leaf.count <= lanes.count_ones() || L::COUNT == 1 {
                    for place in 0..leaf.count as usize {
                        let crossed = self.crossings_of(s, &row.frustum(s, place), how, rays);
                        self.cross_one(here, start + place, crossed, rays);
                    }
                    return;
                }
                let frusta = row.frusta(s);
                for lane in lanes_of(lanes) {
                    let ray = rays.alone(s, lane, first(leaf.count));
                    let crossed = self.crossings_of(s, &frusta, how, &ray);
                    self.cross_some(s, here, start, crossed, lane, rays);
                }
            },
        );
    }

    /// The lanes that cross frusta, and those that do so a second time.
    #[inline(always)]
    fn crossings_of(
        &self,
        s: L::Simd,
        frusta: &Frusta<L>,
        (sides, capped): (Sides, bool),
        rays: &Rays<L>,
    ) -> [L::Mask; 2] {
        match self.blockers {
            Blockers::Opaque => [hit_frusta(s, frusta, capped, rays, sides).lanes, L::mask(s, 0)],
            Blockers::Holed | Blockers::Transmissive => frusta_crossings(s, frusta, capped, rays, sides),
        }
    }

    /// Takes from rays what a primitive keeps of them. `crossed` has the lanes that cross it, and those that do so a second time.
    #[inline(always)]
    fn cross_one(&mut self, here: &Geometry<L::Real>, place: usize, crossed: [L::Mask; 2], rays: &mut Rays<L>) {
        let met = crossed[0] | crossed[1];
        if !met.any() {
            return;
        }
        let item = &here.items[here.primitives[place].item as usize];
        if self.blockers.stop_at(item) {
            rays.active = rays.active & !met;
            return;
        }
        for lanes in crossed.map(Mask::bits) {
            if lanes != 0 {
                self.crossings.push(lanes, item.passed());
            }
        }
    }

    /// The same of one ray and all primitives of a leaf.
    #[inline(always)]
    fn cross_some(
        &mut self,
        s: L::Simd,
        here: &Geometry<L::Real>,
        start: usize,
        crossed: [L::Mask; 2],
        lane: usize,
        rays: &mut Rays<L>,
    ) {
        let met = (crossed[0] | crossed[1]).bits();
        if met == 0 {
            return;
        }
        let item = |place: usize| &here.items[here.primitives[start + place].item as usize];
        if self.blockers == Blockers::Opaque || lanes_of(met).any(|place| self.blockers.stop_at(item(place))) {
            rays.active = rays.active & !L::mask(s, 1 << lane);
            return;
        }
        for mask in crossed {
            for place in lanes_of(mask.bits()) {
                self.crossings.push(1 << lane, item(place).passed());
            }
        }
    }

    /// Tests one primitive of any kind, or descends into an instance. Not inlined: few scenes hold many of these.
    fn visit(&mut self, s: L::Simd, item: &Item<L::Real>, face: u32, rays: &mut Rays<L>) {
        L::vectorize(
            s,
            #[inline(always)]
            || self.visit_in(s, item, face, rays),
        );
    }

    #[inline(always)]
    fn visit_in(&mut self, s: L::Simd, item: &Item<L::Real>, face: u32, rays: &mut Rays<L>) {
        if let Shape::Instance(instance) = &item.shape {
            if control::step(1) {
                return;
            }
            let mut inner = instance.rays_in(s, rays, self.time);
            if inner.any() {
                let past = rays.active & !inner.active;
                match self.geometries[instance.geometry as usize].lone_body() {
                    Some(item) => self.pass(s, item, 0, &mut inner),
                    None => self.attenuate(s, instance.geometry as usize, &mut inner),
                }
                rays.active = inner.active | past;
            }
            return;
        }
        self.pass(s, item, face, rays);
    }

    /// Tests one primitive.
    #[inline(always)]
    fn pass(&mut self, s: L::Simd, item: &Item<L::Real>, face: u32, rays: &mut Rays<L>) {
        if self.blockers.stop_at(item) {
            rays.active = rays.active & !hit_item(s, item, face, rays).lanes;
            return;
        }
        // Each search starts behind the last crossing.
        let mut search = *rays;
        for _ in 0..most_crossings(&item.shape) {
            let hit = hit_item(s, item, face, &search);
            if !hit.lanes.any() {
                break;
            }
            self.crossings.push(hit.lanes.bits(), item.passed());
            search.active = hit.lanes;
            search.t_min = hit.t;
        }
    }
}

/// Most crossings of a ray with one primitive.
fn most_crossings<R>(shape: &Shape<R>) -> usize {
    match shape {
        Shape::Plane(_) | Shape::Disc(_) | Shape::Mesh(_) => 1,
        Shape::Sphere(_) | Shape::Cuboid(_) | Shape::Frustum(_) => 2,
        Shape::Torus(_) => 4,
        Shape::Instance(_) => unreachable!("instances are descended into, not met"),
    }
}
