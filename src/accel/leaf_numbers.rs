//! Numbers of the spheres, triangles and frusta in the leaves of a wide hierarchy. Those of a leaf lie side by side, so a ray
//! that comes to it waits for few places of memory: first the first number of all its primitives, then the second.
//!
//! Those of a large hierarchy are looked up when a ray comes near: of a large model a picture sees about half.

use super::geometry::{ALLOCATION, Geometry};
use super::item::{Item, Primitive, Shape};
use super::wide_bvh::{Kind, Leaf, WideBvh};
use crate::lanes::{Lanes, MAX_LANES, Real, V3};
use crate::shape::{FRUSTUM_NUMBERS, Frusta};
use std::sync::OnceLock;

/// Leaves whose numbers are looked up together.
const GROUP: usize = 64;
/// Hierarchies of fewer leaves have all numbers at once.
const MANY: usize = 1 << 14;

/// The numbers of all leaves: one more for each lane behind them, so that whole bundles can be loaded at the end.
#[derive(Debug, Clone)]
pub(super) enum LeafNumbers<R> {
    Ready(Box<[R]>),
    /// Those of [`GROUP`] leaves each.
    OnDemand(Box<[OnceLock<Box<[R]>>]>),
}

/// The numbers of one leaf.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<'a, R> {
    numbers: &'a [R],
    /// Number of primitives.
    count: usize,
}

impl Leaf {
    /// From one number of a primitive to the next. Frusta have so many that it pays to know it beforehand.
    fn stride(&self) -> usize {
        if let Kind::Frusta { .. } = self.kind { MAX_LANES } else { self.count as usize }
    }

    /// How many numbers its primitives have.
    fn numbers(&self) -> usize {
        let each = match self.kind {
            Kind::Spheres(_) => 4,
            Kind::Triangles(_) => 9,
            Kind::Frusta { .. } => FRUSTUM_NUMBERS,
            Kind::Mixed => 0,
        };
        each * self.stride()
    }
}

impl<R: Real> LeafNumbers<R> {
    /// Those of primitives in the order of the leaves. Tells each leaf where its own begin.
    pub(super) fn new(leaves: &mut [Leaf], items: &[Item<R>], primitives: &[Primitive]) -> Self {
        if leaves.len() < MANY { Self::ready(leaves, items, primitives) } else { Self::on_demand(leaves) }
    }

    /// All at once: the slow twin of [`Self::on_demand`].
    fn ready(leaves: &mut [Leaf], items: &[Item<R>], primitives: &[Primitive]) -> Self {
        lay_out(leaves);
        Self::Ready(look_up(leaves, items, primitives))
    }

    fn on_demand(leaves: &mut [Leaf]) -> Self {
        leaves.chunks_mut(GROUP).for_each(lay_out);
        Self::OnDemand(leaves.chunks(GROUP).map(|_| OnceLock::new()).collect())
    }

    /// Bytes, once all are looked up.
    pub(super) fn bytes(&self, leaves: &[Leaf]) -> usize {
        match self {
            Self::Ready(numbers) => size_of_val(&numbers[..]),
            Self::OnDemand(groups) => {
                let of_groups: usize =
                    leaves.chunks(GROUP).map(|leaves| ALLOCATION + size_of::<R>() * len(leaves)).sum();
                size_of_val(&groups[..]) + of_groups
            }
        }
    }
}

impl<R: Real> WideBvh<R> {
    /// The numbers of a leaf, which is at an index.
    #[inline(always)]
    pub(super) fn row(&self, leaf: &Leaf, index: usize, geometry: &Geometry<R>) -> Row<'_, R> {
        let numbers = match &self.numbers {
            LeafNumbers::Ready(numbers) => numbers,
            LeafNumbers::OnDemand(groups) => self.group(groups, index, geometry),
        };
        Row { numbers: &numbers[leaf.row as usize..], count: leaf.count as usize }
    }

    /// The numbers of a leaf's group. Not inlined, so that small hierarchies pay nothing.
    #[inline(never)]
    fn group<'a>(&self, groups: &'a [OnceLock<Box<[R]>>], index: usize, geometry: &Geometry<R>) -> &'a [R] {
        groups[index / GROUP].get_or_init(|| {
            let start = index - index % GROUP;
            let leaves = &self.leaves[start..self.leaves.len().min(start + GROUP)];
            look_up(leaves, &geometry.items, &geometry.primitives)
        })
    }
}

impl<R: Real> Row<'_, R> {
    /// Centre and radius of one sphere, in all lanes.
    #[inline(always)]
    pub(super) fn sphere<L: Lanes<Real = R>>(&self, s: L::Simd, place: usize) -> (V3<L>, L) {
        let [x, y, z, radius] = self.one(s, place);
        (V3 { x, y, z }, radius)
    }

    /// The spheres, one in each lane.
    #[inline(always)]
    pub(super) fn spheres<L: Lanes<Real = R>>(&self, s: L::Simd) -> (V3<L>, L) {
        let [x, y, z, radius] = self.all(s);
        (V3 { x, y, z }, radius)
    }

    /// The corners of one triangle, in all lanes.
    #[inline(always)]
    pub(super) fn triangle<L: Lanes<Real = R>>(&self, s: L::Simd, place: usize) -> [V3<L>; 3] {
        corners(self.one(s, place))
    }

    /// The corners of the triangles, one in each lane.
    #[inline(always)]
    pub(super) fn triangles<L: Lanes<Real = R>>(&self, s: L::Simd) -> [V3<L>; 3] {
        corners(self.all(s))
    }

    /// One frustum, in all lanes.
    #[inline(always)]
    pub(super) fn frustum<L: Lanes<Real = R>>(&self, s: L::Simd, place: usize) -> Frusta<L> {
        let mut numbers = [L::lit(s, 0.0); FRUSTUM_NUMBERS];
        for (number, column) in numbers.iter_mut().zip(self.columns()) {
            *number = L::splat(s, column[place]);
        }
        Frusta::of(numbers)
    }

    /// The frusta, one in each lane.
    #[inline(always)]
    pub(super) fn frusta<L: Lanes<Real = R>>(&self, s: L::Simd) -> Frusta<L> {
        let mut numbers = [L::lit(s, 0.0); FRUSTUM_NUMBERS];
        for (number, column) in numbers.iter_mut().zip(self.columns()) {
            *number = L::load(s, column);
        }
        Frusta::of(numbers)
    }

    /// The numbers of frusta, of which all leaves have room for as many.
    #[inline(always)]
    fn columns(&self) -> &[[R; MAX_LANES]; FRUSTUM_NUMBERS] {
        self.numbers.as_chunks().0.first_chunk().expect("frusta have so many")
    }

    /// The numbers of one primitive, in all lanes.
    #[inline(always)]
    fn one<L: Lanes<Real = R>, const N: usize>(&self, s: L::Simd, place: usize) -> [L; N] {
        let mut numbers = [L::lit(s, 0.0); N];
        for (i, number) in numbers.iter_mut().enumerate() {
            *number = L::splat(s, self.numbers[i * self.count + place]);
        }
        numbers
    }

    /// The numbers of the primitives, one in each lane; what is in the lanes beyond them means nothing.
    #[inline(always)]
    fn all<L: Lanes<Real = R>, const N: usize>(&self, s: L::Simd) -> [L; N] {
        let mut numbers = [L::lit(s, 0.0); N];
        for (i, number) in numbers.iter_mut().enumerate() {
            *number = L::load(s, &self.numbers[i * self.count..]);
        }
        numbers
    }
}

/// Three corners of nine coordinates.
#[inline(always)]
fn corners<L: Lanes>([ax, ay, az, bx, by, bz, cx, cy, cz]: [L; 9]) -> [V3<L>; 3] {
    [V3 { x: ax, y: ay, z: az }, V3 { x: bx, y: by, z: bz }, V3 { x: cx, y: cy, z: cz }]
}

/// Tells leaves where their numbers begin in a list of their own.
fn lay_out(leaves: &mut [Leaf]) {
    let mut end = 0;
    for leaf in leaves {
        leaf.row = end;
        end += leaf.numbers() as u32;
    }
}

/// Length of the list of numbers of some leaves.
fn len(leaves: &[Leaf]) -> usize {
    leaves.iter().map(Leaf::numbers).sum::<usize>() + MAX_LANES
}

/// The numbers of some leaves. All faces first, then their corners: a short loop waits for many places of memory at once.
fn look_up<R: Real>(leaves: &[Leaf], items: &[Item<R>], primitives: &[Primitive]) -> Box<[R]> {
    let mut numbers = vec![R::default(); len(leaves)];
    let mut faces = Vec::with_capacity(GROUP * R::LANES);
    for leaves in leaves.chunks(GROUP) {
        faces.clear();
        for leaf in leaves {
            faces.extend(primitives[leaf.places()].iter().map(|primitive| face_of(primitive, items)));
        }
        let mut faces = &faces[..];
        for leaf in leaves {
            let own;
            (own, faces) = faces.split_at(leaf.count as usize);
            let row = &mut numbers[leaf.row as usize..];
            for (place, (primitive, face)) in primitives[leaf.places()].iter().zip(own).enumerate() {
                put(row, leaf.stride(), place, &items[primitive.item as usize].shape, face);
            }
        }
    }
    numbers.into()
}

/// The corners of a face, as indices of its mesh; nothing for other bodies.
#[inline(always)]
fn face_of<R>(primitive: &Primitive, items: &[Item<R>]) -> [u32; 3] {
    match &items[primitive.item as usize].shape {
        Shape::Mesh(mesh) => mesh.faces[primitive.face as usize],
        _ => [0; 3],
    }
}

/// Puts the numbers of one primitive into the row of its leaf.
#[inline(always)]
fn put<R: Real>(row: &mut [R], stride: usize, place: usize, shape: &Shape<R>, face: &[u32; 3]) {
    let mut put = |first: usize, numbers: &[R]| {
        for (i, number) in numbers.iter().enumerate() {
            row[(first + i) * stride + place] = *number;
        }
    };
    match shape {
        Shape::Sphere(sphere) => {
            put(0, &sphere.center);
            put(3, &[sphere.radius]);
        }
        Shape::Mesh(mesh) => {
            for (corner, vertex) in face.iter().enumerate() {
                put(3 * corner, &mesh.vertices[*vertex as usize]);
            }
        }
        Shape::Frustum(frustum) => put(0, &frustum.numbers()),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::super::bounds::Bounds;
    use super::super::build::BvhKind;
    use super::super::extent::Extent;
    use super::super::geometry::tests::{ball, sheet};
    use super::*;
    use glam::DVec3;
    use std::sync::Arc;

    #[test]
    fn numbers_on_demand_are_those_of_all_at_once() {
        let items: Vec<_> = [sheet(100), sheet(3)].into_iter().chain((0..400).map(ball)).collect();
        let extent = |item: &Item<f32>| match &item.shape {
            Shape::Sphere(ball) => {
                let center = DVec3::from_array(ball.center.map(f64::from));
                Some(Extent::of_box(Bounds::around([center]).grown(0.3)))
            }
            _ => None,
        };
        let extents: Vec<_> = items.iter().map(extent).collect();
        let mut geometry = Geometry::new(items, &extents, BvhKind::Sah);
        let ready = geometry.wide.clone().expect("there are bodies");
        assert!(matches!(ready.numbers, LeafNumbers::Ready(_)) && ready.leaves.len() > 3 * GROUP);
        let mut on_demand = WideBvh::clone(&ready);
        on_demand.numbers = LeafNumbers::on_demand(&mut on_demand.leaves);
        geometry.wide = Some(Arc::new(on_demand));
        let on_demand = geometry.wide.as_ref().expect("it was put there");
        for index in (0..ready.leaves.len()).rev() {
            let expected = ready.row(&ready.leaves[index], index, &geometry);
            let row = on_demand.row(&on_demand.leaves[index], index, &geometry);
            let count = ready.leaves[index].numbers();
            assert_eq!(row.numbers[..count], expected.numbers[..count], "leaf {index}");
            assert!(row.numbers.len() >= count + MAX_LANES, "a bundle can be loaded at its end");
        }
    }
}
