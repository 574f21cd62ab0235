//! Geometries: items in one coordinate system, and the hierarchy over them.
//!
//! A scene is a graph of [`Geometry`]: the root, and one for each group or definition, placed by [`Instance`] items.
//! Instances are never expanded. Each primitive of the expanded scene still has a number, its *expanded index*: the sum of
//! the offsets along its path. It fits in 64 bits because `compile` limits the count.

use super::bounds::Bounds;
use super::build::{Bvh, BvhKind};
use super::build_primitive::BuildPrimitive;
use super::extent::Extent;
use super::item::{Attributes, Item, Mesh, Primitive, Shape};
use super::numbering::Numbering;
use super::triangle_runs;
use super::wide_bvh::{WideBvh, WideNode, wholeness};
use crate::control;
use crate::lanes::Real;
use crate::shape::{Frustum, Torus};
use glam::DVec3;
use rayon::prelude::*;
use std::iter::repeat_n;
use std::mem::size_of;
use std::sync::Arc;

/// Bytes that a small allocation takes beside its own: the allocator's, and what is lost to rounding.
pub(crate) const ALLOCATION: usize = 24;

/// Items in one coordinate system.
#[derive(Debug, Clone)]
pub struct Geometry<R> {
    /// The items, in the scene's order.
    pub items: Vec<Item<R>>,
    /// Indices of items without bounds (planes, and instances that contain some).
    pub(super) unbounded: Arc<[u32]>,
    /// Item and face of each bounded primitive, in the order of the hierarchy's leaves.
    pub(super) primitives: Arc<[Primitive]>,
    /// The hierarchy over them, if there are any.
    pub(super) wide: Option<Arc<WideBvh<R>>>,
    /// Whether it is one bounded body that is one primitive.
    lone: bool,
    /// Around everything bounded.
    pub extent: Extent,
    /// Number of primitives when expanded.
    pub expanded: u64,
}

impl<R: Real> Geometry<R> {
    /// Builds the hierarchy over items. `extents` has the extent of each, `None` for an item without bounds; those of meshes
    /// are not used.
    pub fn new(items: Vec<Item<R>>, extents: &[Option<Extent>], kind: BvhKind) -> Self {
        let mut unbounded = Vec::new();
        let most = |item: &Item<R>| if let Shape::Mesh(mesh) = &item.shape { mesh.faces.len() } else { 1 };
        let count = items.iter().map(most).sum();
        let mut numbering = Numbering::with_room(count);
        let mut build: Vec<BuildPrimitive<R>> = Vec::with_capacity(items.len());
        let longest = triangle_runs::longest::<R>(count, kind);
        let mut bounds = Bounds::EMPTY;
        for (index, (item, extent)) in items.iter().zip(extents).enumerate() {
            let index = index as u32;
            if let Shape::Mesh(mesh) = &item.shape {
                let first = numbering.add(index, mesh.faces.len() as u32);
                bounds = bounds.union(triangle_runs::push(&mut build, mesh, first, longest));
            } else if let Some(extent) = extent {
                if extent.radius >= 0.0 {
                    let tight = extent.tight_box();
                    build.push(BuildPrimitive::new(&tight.narrowed(), numbering.add(index, 1), 1));
                    bounds = bounds.union(tight);
                }
            } else {
                unbounded.push(index);
            }
        }

        let first = |run: &BuildPrimitive<R>| numbering.find(run.indices().start);
        let wholeness = |runs: &[BuildPrimitive<R>]| wholeness(&items, runs, |run| first(run).item);
        let bvh = Bvh::build(&mut build, kind, &wholeness);
        // Made where it stays: a list that became one of several owners would be copied.
        let count = build.iter().map(|run| run.count() as usize).sum();
        let mut owned: Arc<[Primitive]> = repeat_n(Primitive { item: 0, face: 0 }, count).collect();
        let primitives = Arc::make_mut(&mut owned);
        let mut rest = &mut *primitives;
        for run in &build {
            let (own, behind) = rest.split_at_mut(run.count() as usize);
            let Primitive { item, face } = first(run);
            own.iter_mut().zip(face..).for_each(|(place, face)| *place = Primitive { item, face });
            rest = behind;
        }
        drop((build, numbering));
        let extent = extent_of(&items, extents, bounds);
        let expanded = items.last().map_or(0, |last| last.offset + last.expanded);
        let wide = match kind {
            _ if primitives.is_empty() => None,
            // A cancelled hierarchy is not used.
            _ if control::is_stopping() => None,
            BvhKind::Flat => Some(WideBvh::flat(bvh.nodes[0].slab, primitives.len()).into()),
            BvhKind::Sah | BvhKind::Median => Some(WideBvh::new(&bvh, &items, primitives).into()),
        };
        drop(bvh);
        let lone = kind != BvhKind::Flat
            && unbounded.is_empty()
            && matches!(&primitives[..], [only] if !matches!(items[only.item as usize].shape, Shape::Mesh(_) | Shape::Instance(_)));
        Self { unbounded: unbounded.into(), wide, primitives: owned, lone, extent, expanded, items }
    }

    /// Its only body, if that is one primitive with bounds: then its hierarchy is a box around it, and rays that have come as
    /// far need not be prepared for that.
    #[inline(always)]
    pub(super) fn lone_body(&self) -> Option<&Item<R>> {
        self.lone.then(|| &self.items[self.primitives[0].item as usize])
    }

    /// The same bodies with other materials, in the hierarchy that there is. The items come back if they need another one.
    pub fn with_items(&self, items: Vec<Item<R>>) -> Result<Self, Vec<Item<R>>> {
        // Leaves know from which side their primitives can be hit.
        let fits = items.len() == self.items.len() && items.iter().zip(&self.items).all(|(a, b)| a.sides == b.sides);
        if !fits {
            return Err(items);
        }
        let (unbounded, primitives) = (Arc::clone(&self.unbounded), Arc::clone(&self.primitives));
        Ok(Self { items, unbounded, primitives, wide: self.wide.clone(), ..*self })
    }

    /// Whether it shares the hierarchy of another one.
    pub fn has_hierarchy_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.primitives, &other.primitives)
    }

    /// Whether something in it has no bounds.
    pub fn is_unbounded(&self) -> bool {
        !self.unbounded.is_empty()
    }

    /// Where its hierarchy is in memory: the same for all that share one.
    pub fn place(&self) -> usize {
        self.primitives.as_ptr() as usize
    }

    /// Bytes of its items with what they own, and of its hierarchy; almost exact.
    pub fn bytes(&self) -> usize {
        let of_items: usize = self.items.iter().map(|item| boxed(&item.shape)).sum();
        self.bytes_of_items() + of_items + self.bytes_of_hierarchy()
    }

    /// Bytes of what it does not share with another one that has the same bodies.
    pub fn bytes_beside(&self, other: &Self) -> usize {
        let is_shared = |item: &Item<R>, known: &Item<R>| match (&item.shape, &known.shape) {
            (Shape::Mesh(a), Shape::Mesh(b)) => Arc::ptr_eq(a, b),
            _ => false,
        };
        let own = self.items.iter().zip(&other.items).filter(|(item, known)| !is_shared(item, known));
        let hierarchy = if self.has_hierarchy_of(other) { 0 } else { self.bytes_of_hierarchy() };
        self.bytes_of_items() + own.map(|(item, _)| boxed(&item.shape)).sum::<usize>() + hierarchy
    }

    fn bytes_of_items(&self) -> usize {
        size_of::<Self>() + ALLOCATION + size_of_val(&self.items[..])
    }

    fn bytes_of_hierarchy(&self) -> usize {
        let wide = self.wide.as_ref().map_or(0, |wide| {
            wide.nodes.len() * size_of::<WideNode<R>>()
                + size_of_val(&wide.leaves[..])
                + wide.numbers.bytes(&wide.leaves)
        });
        let lists = size_of_val(&self.unbounded[..]) + self.primitives.len() * size_of::<Primitive>();
        lists + wide + 4 * ALLOCATION
    }

    /// The item that owns an expanded index of this geometry.
    pub(super) fn owner(&self, expanded: u64) -> &Item<R> {
        // Where every item has one primitive, the index is the item's; and often the last item has most primitives.
        for item in self.items.get(expanded as usize).into_iter().chain(self.items.last()) {
            if expanded.wrapping_sub(item.offset) < item.expanded {
                return item;
            }
        }
        let after = self.items.partition_point(|item| item.offset <= expanded);
        // Items without primitives share their offset with the next, so the owner is the last one at or below the index.
        &self.items[after - 1]
    }
}

/// The extent of items, given the box around them all.
fn extent_of<R: Real>(items: &[Item<R>], extents: &[Option<Extent>], bounds: Bounds) -> Extent {
    if bounds == Bounds::EMPTY {
        return Extent::EMPTY;
    }
    let of_box = Extent::of_box(bounds);
    let reach = |(item, extent): (&Item<R>, &Option<Extent>)| match (&item.shape, extent) {
        // Also of vertices without a face, which no ray meets: the box is around those that it may.
        (Shape::Mesh(mesh), _) => {
            let reach = |p: &[R; 3]| DVec3::from_array(p.map(Real::to_f64)).distance_squared(of_box.center);
            mesh.vertices.par_iter().map(reach).reduce(|| 0.0, f64::max).sqrt()
        }
        (_, Some(extent)) => extent.center.distance(of_box.center) + extent.radius,
        (_, None) => 0.0,
    };
    let radius = items.iter().zip(extents).map(reach).fold(0.0, f64::max);
    Extent { radius: radius.min(of_box.radius), ..of_box }
}

/// Bytes that a shape owns beside itself.
fn boxed<R>(shape: &Shape<R>) -> usize {
    match shape {
        Shape::Mesh(mesh) => {
            let Mesh { vertices, faces, normals, uvs, attributes } = &**mesh;
            let more = attributes.as_ref().map_or([0; 4], |more| {
                let Attributes { uvs, colors, tangents } = &**more;
                [size_of_val(&**more), size_of_val(&uvs[..]), size_of_val(&colors[..]), size_of_val(&tangents[..])]
            });
            let lists =
                [size_of_val(&vertices[..]), size_of_val(&faces[..]), size_of_val(&normals[..]), size_of_val(&uvs[..])];
            let own = 2 * ALLOCATION + size_of::<Mesh<R>>() + size_of_val(&**faces);
            own + lists.iter().chain(&more).filter(|bytes| **bytes > 0).map(|bytes| ALLOCATION + bytes).sum::<usize>()
        }
        Shape::Frustum(_) => ALLOCATION + size_of::<Frustum<R>>(),
        Shape::Torus(_) => ALLOCATION + size_of::<Torus<R>>(),
        Shape::Instance(instance) => {
            let motion = instance.motion.as_ref().map_or(0, |motion| ALLOCATION + size_of_val(&**motion));
            ALLOCATION + size_of_val(&**instance) + motion
        }
        Shape::Sphere(_) | Shape::Plane(_) | Shape::Disc(_) | Shape::Cuboid(_) => 0,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::build::Wholeness;
    use super::super::wide_bvh::Leaf;
    use super::*;
    use crate::math::sin_cos;
    use crate::shape::{Sides, Sphere};
    use glam::DVec3;

    fn bytes<T>(vec: &Vec<T>) -> usize {
        vec.capacity() * size_of::<T>()
    }

    /// A smooth, bumpy sheet of 2 n^2 triangles.
    pub(in super::super) fn sheet(n: u32) -> Item<f32> {
        let point = |i: u32| [i % (n + 1), i / (n + 1)].map(|k| k as f32 / n as f32);
        let wave = |x: f32| sin_cos(f64::from(x)).0 as f32;
        let vertices: Vec<[f32; 3]> =
            (0..(n + 1) * (n + 1)).map(point).map(|[x, y]| [x, y, 0.1 * wave(20.0 * x) * wave(30.0 * y)]).collect();
        let square = |i: u32| {
            let a = i / n * (n + 1) + i % n;
            [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
        };
        let normals = vec![[0.0, 0.0, 1.0]; vertices.len()];
        Item {
            shape: Shape::Mesh(Arc::new(Mesh {
                vertices,
                faces: Arc::new((0..n * n).flat_map(square).collect()),
                normals,
                uvs: Vec::new(),
                attributes: None,
            })),
            material: 0,
            sides: Sides::Both,
            hollow: false,
            closed: true,
            may_touch: false,
            has_holes: false,
            volume: 0.0,
            transmission: [0.0; 3],
            source: 0,
            offset: 0,
            expanded: u64::from(2 * n * n),
        }
    }

    #[test]
    fn a_triangle_takes_at_most_100_bytes() {
        let geometry = Geometry::new(vec![sheet(224)], &[None], BvhKind::Sah);
        let Shape::Mesh(mesh) = &geometry.items[0].shape else { panic!("the sheet is a mesh") };
        let wide = geometry.wide.as_ref().expect("so many triangles have one");
        let mesh_bytes = bytes(&mesh.vertices) + mesh.faces.len() * size_of::<[u32; 3]>() + bytes(&mesh.normals);
        let primitives = size_of_val(&geometry.primitives[..]);
        let parts = [mesh_bytes, primitives, bytes(&wide.nodes), bytes(&wide.leaves), wide.numbers.bytes(&wide.leaves)];
        let each = parts.map(|bytes| bytes as f64 / mesh.faces.len() as f64);
        assert!(each.iter().sum::<f64>() <= 100.0, "bytes for each triangle: {each:?}");
    }

    pub(in super::super) fn ball(i: u32) -> Item<f32> {
        let center = [i as f32, (i * 7 % 11) as f32, 0.5];
        Item { shape: Shape::Sphere(Sphere { center, radius: 0.3 }), expanded: 1, ..sheet(1) }
    }

    /// The slow twin splits all the same what is one leaf of the wide hierarchy.
    #[test]
    fn levels_below_the_leaves_change_nothing() {
        for items in [vec![sheet(40)], (0..60).map(ball).collect(), vec![sheet(9), ball(3), sheet(2), ball(0)]] {
            let boxes = |item: &Item<f32>| -> Vec<Bounds> {
                match &item.shape {
                    Shape::Mesh(mesh) => (0..mesh.faces.len()).map(|face| Bounds::around(mesh.points(face))).collect(),
                    Shape::Sphere(ball) => {
                        vec![Bounds::around([DVec3::from_array(ball.center.map(f64::from))]).grown(0.3)]
                    }
                    _ => vec![],
                }
            };
            let extents: Vec<_> = items.iter().map(|item| Some(Extent::of_box(boxes(item)[0]))).collect();
            let geometry = Geometry::new(items.clone(), &extents, BvhKind::Sah);

            let of = |(item, index): (&Item<f32>, u32)| -> Vec<(Bounds, Primitive)> {
                boxes(item).into_iter().zip(0..).map(|(b, face)| (b, Primitive { item: index, face })).collect()
            };
            let all: Vec<(Bounds, Primitive)> = items.iter().zip(0..).flat_map(of).collect();
            let mut build: Vec<_> =
                all.iter().zip(0..).map(|((b, _), index)| BuildPrimitive::new(&b.narrowed(), index, 1)).collect();
            let wholeness =
                |runs: &[BuildPrimitive<f32>]| match wholeness(&items, runs, |run| all[run.indices().start].1.item) {
                    Wholeness::Whole => Wholeness::Any,
                    other => other,
                };
            let bvh = Bvh::build(&mut build, BvhKind::Sah, &wholeness);
            let mut primitives: Vec<_> = build.iter().map(|primitive| all[primitive.indices().start].1).collect();
            let twin = WideBvh::new(&bvh, &items, &mut primitives);

            let nodes = |wide: &WideBvh<f32>| -> Vec<_> {
                wide.nodes.iter().map(|node| (node.min, node.max, node.children, node.count)).collect()
            };
            let leaves = |wide: &WideBvh<f32>, primitives: &[Primitive]| -> Vec<_> {
                let sorted = |leaf: &Leaf| {
                    let mut held: Vec<_> = primitives[leaf.places()].iter().map(|p| (p.item, p.face)).collect();
                    held.sort_unstable();
                    (leaf.kind, held)
                };
                wide.leaves.iter().map(sorted).collect()
            };
            let wide = geometry.wide.as_ref().unwrap();
            assert_eq!(nodes(wide), nodes(&twin));
            assert_eq!(leaves(wide, &geometry.primitives), leaves(&twin, &primitives));
        }
    }
}
