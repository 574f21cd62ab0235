//! What rays meet: items in one coordinate system, and the hierarchy over them.
//!
//! A scene is a graph of [`Geometry`]: the root, and one for each group or definition, placed by [`Instance`] items.
//! Nothing is ever expanded. Each primitive of the expanded scene still has a number, its *expanded index*: the sum of
//! the offsets along its path. It fits in 64 bits because `compile` limits the count.

use super::bounds::Bounds;
use super::build::{Bvh, BvhKind};
use crate::lanes::Real;
use crate::shape::{Cuboid, Disc, Frustum, Plane, Sides, Sphere, Torus};
use glam::{DAffine3, DMat3, DVec3};

/// One thing in a geometry: a body, a surface or a placed geometry.
#[derive(Debug, Clone)]
pub struct Item<R> {
    /// Its geometry.
    pub shape: Shape<R>,
    /// Index of its material.
    pub material: u32,
    /// Sides that rays can meet.
    pub sides: Sides,
    /// Whether the body is turned inside out.
    pub hollow: bool,
    /// Whether it encloses a region that light is refracted into.
    pub closed: bool,
    /// Transmission of one crossing, for shadow rays; 0 blocks.
    pub transmission: [R; 3],
    /// Index of its source in the scene's table of names.
    pub source: u32,
    /// Expanded index of its first primitive within the geometry.
    pub offset: u64,
    /// Number of its primitives when expanded.
    pub expanded: u64,
}

/// Kinds of items.
#[derive(Debug, Clone)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Shape<R> {
    Sphere(Sphere<R>),
    Plane(Plane<R>),
    Disc(Disc<R>),
    Cuboid(Cuboid<R>),
    Frustum(Box<Frustum<R>>),
    Torus(Box<Torus<R>>),
    Mesh(Mesh<R>),
    Instance(Box<Instance<R>>),
}

/// Triangles over shared vertices.
#[derive(Debug, Clone)]
pub struct Mesh<R> {
    /// Points.
    pub vertices: Vec<[R; 3]>,
    /// Three vertices each, counter-clockwise from the front.
    pub faces: Vec<[u32; 3]>,
    /// A shading normal for each vertex, or nothing.
    pub normals: Vec<[R; 3]>,
}

impl<R: Real> Mesh<R> {
    /// The corners of a face.
    #[inline(always)]
    pub fn corners(&self, face: usize) -> [[R; 3]; 3] {
        self.faces[face].map(|i| self.vertices[i as usize])
    }
}

/// A geometry, placed.
#[derive(Debug, Clone)]
pub struct Instance<R> {
    /// Index of the geometry.
    pub geometry: u32,
    /// From the geometry's coordinates to those around it.
    pub to_world: Placement<R>,
    /// The inverse.
    pub to_local: Placement<R>,
}

/// An affine map: columns of the linear part, and the image of the origin.
#[derive(Debug, Clone, Copy)]
pub struct Placement<R> {
    /// Columns of the 3 x 3 part.
    pub columns: [[R; 3]; 3],
    /// Translation.
    pub translation: [R; 3],
}

impl<R: Real> Placement<R> {
    /// The map in this format.
    pub fn new(map: DAffine3) -> Self {
        let narrow = |v: DVec3| v.to_array().map(R::from_f64);
        let DMat3 { x_axis, y_axis, z_axis } = map.matrix3;
        Self { columns: [narrow(x_axis), narrow(y_axis), narrow(z_axis)], translation: narrow(map.translation) }
    }
}

/// Items in one coordinate system.
#[derive(Debug, Clone)]
pub struct Geometry<R> {
    /// The items, in the scene's order.
    pub items: Vec<Item<R>>,
    /// Indices of items without bounds (planes, and instances that contain some).
    pub(super) unbounded: Vec<u32>,
    /// Item and face of each bounded primitive.
    pub(super) primitives: Vec<Primitive>,
    pub(super) bvh: Bvh<R>,
    /// Box around everything bounded, padded as the hierarchy's own boxes are.
    pub bounds: Bounds,
    /// Number of primitives when expanded.
    pub expanded: u64,
}

/// A bounded primitive: an item, and for meshes one of its faces.
#[derive(Debug, Clone, Copy)]
pub(super) struct Primitive {
    pub(super) item: u32,
    pub(super) face: u32,
}

impl<R: Real> Geometry<R> {
    /// Builds the hierarchy over items. `extents` are their boxes, `None` for an item without bounds; those of meshes
    /// do not matter.
    pub fn new(items: Vec<Item<R>>, extents: &[Option<Bounds>], kind: BvhKind) -> Self {
        let mut unbounded = Vec::new();
        let mut primitives = Vec::new();
        let mut boxes = Vec::new();
        for (index, (item, extent)) in items.iter().zip(extents).enumerate() {
            let index = index as u32;
            if let Shape::Mesh(mesh) = &item.shape {
                for face in 0..mesh.faces.len() {
                    primitives.push(Primitive { item: index, face: face as u32 });
                    boxes.push(Bounds::around(mesh.corners(face).map(|v| DVec3::from_array(v.map(Real::to_f64)))));
                }
            } else if let Some(bounds) = *extent {
                if bounds.min.x <= bounds.max.x {
                    primitives.push(Primitive { item: index, face: 0 });
                    boxes.push(bounds);
                }
            } else {
                unbounded.push(index);
            }
        }
        let bounds = boxes.iter().fold(Bounds::EMPTY, |a, b| a.union(*b));
        let expanded = items.last().map_or(0, |last| last.offset + last.expanded);
        Self { unbounded, bvh: Bvh::build(&boxes, kind), primitives, bounds, expanded, items }
    }

    /// Whether something in it has no bounds.
    pub fn is_unbounded(&self) -> bool {
        !self.unbounded.is_empty()
    }

    /// The item that owns an expanded index of this geometry.
    pub(super) fn owner(&self, expanded: u64) -> &Item<R> {
        let after = self.items.partition_point(|item| item.offset <= expanded);
        // Items without primitives share their offset with the next, so the last one at or below owns the index.
        &self.items[after - 1]
    }
}
