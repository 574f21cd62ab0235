//! What rays meet: items in one coordinate system, and the hierarchy over them.
//!
//! A scene is a graph of [`Geometry`]: the root, and one for each group or definition, placed by [`Instance`] items.
//! Nothing is ever expanded. Each primitive of the expanded scene still has a number, its *expanded index*: the sum of
//! the offsets along its path. It fits in 64 bits because `compile` limits the count.

use super::bounds::Bounds;
use super::build::{Bvh, BvhKind};
use super::motion::Motion;
use super::part::Part;
use super::wide::Wide;
use crate::lanes::Real;
use crate::math::{exponent, scale_by_power};
use crate::shape::{Cuboid, Disc, Frustum, Plane, Sides, Sphere, Torus};
use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;

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
    /// Whether its surface might touch another one.
    pub may_touch: bool,
    /// What it encloses, in its own coordinates; infinite for half-spaces, 0 for sheets.
    pub volume: f64,
    /// Transmission of one crossing, for shadow rays; 0 blocks.
    pub transmission: [R; 3],
    /// Index of its source in the scene's table of names.
    pub source: u32,
    /// Expanded index of its first primitive within the geometry.
    pub offset: u64,
    /// Number of its primitives when expanded.
    pub expanded: u64,
}

impl<R: Real> Item<R> {
    /// Whether it transmits light in some channel; shadow rays pass it, attenuated, if the scene's shadows do that.
    pub fn lets_light_through(&self) -> bool {
        self.transmission.iter().any(|c| *c > R::from_f64(0.0))
    }

    /// Whether it is a placed geometry, not a body or surface.
    pub fn is_placed(&self) -> bool {
        matches!(self.shape, Shape::Instance(_))
    }

    /// Whether its facets stand for a curved surface, whose normals are interpolated.
    pub fn is_smooth(&self) -> bool {
        matches!(&self.shape, Shape::Mesh(mesh) if !mesh.normals.is_empty())
    }
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
    /// Texture coordinates of each vertex, or nothing; only where a texture asks for them.
    pub uvs: Vec<[R; 2]>,
}

impl<R: Real> Mesh<R> {
    /// The corners of a face.
    #[inline(always)]
    pub fn corners(&self, face: usize) -> [[R; 3]; 3] {
        self.faces[face].map(|i| self.vertices[i as usize])
    }

    /// [`Self::corners`] in 64 bits.
    fn points(&self, face: usize) -> [DVec3; 3] {
        self.corners(face).map(|corner| DVec3::from_array(corner.map(Real::to_f64)))
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
    /// A power of two by which directions are divided and ray parameters multiplied inside, so that directions keep a
    /// length around 1 at any scale and their squares neither vanish nor overflow. It changes no digit.
    pub unit: R,
    /// Ball around the placed geometry, if it has bounds: most rays that pass its box miss it.
    pub ball: Option<Ball<R>>,
    /// How it moves while the shutter is open.
    pub motion: Option<Box<Motion<R>>>,
}

impl<R: Real> Instance<R> {
    /// Places a geometry.
    pub fn new(geometry: u32, to_world: DAffine3) -> Self {
        let to_local = to_world.inverse();
        let columns = [to_local.x_axis, to_local.y_axis, to_local.z_axis];
        let longest = columns.iter().map(|column| column.length()).fold(f64::MIN_POSITIVE, f64::max);
        let unit = scale_by_power(1.0, exponent(longest).clamp(-100, 100));
        Self {
            geometry,
            to_world: Placement::new(to_world),
            to_local: Placement::new(to_local),
            unit: R::from_f64(unit),
            ball: None,
            motion: None,
        }
    }
}

/// A ball that holds something.
#[derive(Debug, Clone, Copy)]
pub struct Ball<R> {
    /// Centre.
    pub center: [R; 3],
    /// Radius.
    pub radius: R,
}

impl<R: Real> Ball<R> {
    /// The ball of an extent, larger by the roundings of its own numbers.
    pub fn new(extent: &Extent) -> Self {
        let size = extent.center.abs().max_element() + extent.radius;
        Self {
            center: extent.center.to_array().map(R::from_f64),
            radius: R::from_f64(extent.radius + 4.0 * R::ROUNDOFF * size),
        }
    }
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
    /// Factor on volumes.
    pub(super) fn volume_scale(&self) -> f64 {
        let [x, y, z] = self.columns.map(|column| DVec3::from_array(column.map(Real::to_f64)));
        x.cross(y).dot(z).abs()
    }

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
    /// Item and face of each bounded primitive, in the order of the hierarchy's leaves.
    pub(super) primitives: Vec<Primitive>,
    /// The hierarchy over them, if there are any.
    pub(super) wide: Option<Wide<R>>,
    /// Around everything bounded.
    pub extent: Extent,
    /// Number of primitives when expanded.
    pub expanded: u64,
}

/// Where something bounded lies: inside a box and inside a ball. Under rotations boxes around boxes grow with each level
/// of nesting; balls around balls do not.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    /// The box.
    pub bounds: Bounds,
    /// Centre of the ball.
    pub center: DVec3,
    /// Radius of the ball; negative if there is nothing inside.
    pub radius: f64,
}

impl Extent {
    /// The extent of nothing.
    pub const EMPTY: Self = Self { bounds: Bounds::EMPTY, center: DVec3::ZERO, radius: -1.0 };

    /// What is known of something inside a box.
    pub fn of_box(bounds: Bounds) -> Self {
        Self { bounds, center: bounds.center(), radius: 0.5 * (bounds.max - bounds.min).length() }
    }

    /// Box around everything in both box and ball.
    fn tight_box(&self) -> Bounds {
        let ball = Bounds::around([self.center]).grown(self.radius);
        Bounds { min: self.bounds.min.max(ball.min), max: self.bounds.max.min(ball.max) }
    }

    /// The extent of items, given the box around them all.
    fn around<R: Real>(items: &[Item<R>], extents: &[Option<Self>], bounds: Bounds) -> Self {
        if bounds == Bounds::EMPTY {
            return Self::EMPTY;
        }
        let of_box = Self::of_box(bounds);
        let reach = |(item, extent): (&Item<R>, &Option<Self>)| match (&item.shape, extent) {
            (Shape::Mesh(mesh), _) => {
                let reach =
                    |face| mesh.points(face).map(|p| p.distance_squared(of_box.center)).into_iter().fold(0.0, f64::max);
                (0..mesh.faces.len()).into_par_iter().map(reach).reduce(|| 0.0, f64::max).sqrt()
            }
            (_, Some(extent)) => extent.center.distance(of_box.center) + extent.radius,
            (_, None) => 0.0,
        };
        let radius = items.iter().zip(extents).map(reach).fold(0.0, f64::max);
        Self { radius: radius.min(of_box.radius), ..of_box }
    }
}

/// A bounded primitive: an item, and for meshes one of its faces.
#[derive(Debug, Clone, Copy)]
pub(super) struct Primitive {
    pub(super) item: u32,
    pub(super) face: u32,
}

impl<R: Real> Geometry<R> {
    /// Builds the hierarchy over items. `extents` says where they lie, `None` for an item without bounds; those of
    /// meshes do not matter.
    pub fn new(items: Vec<Item<R>>, extents: &[Option<Extent>], kind: BvhKind) -> Self {
        let mut unbounded = Vec::new();
        let mut sources = Vec::new();
        let mut parts: Vec<Part<R>> = Vec::new();
        let mut bounds = Bounds::EMPTY;
        for (index, (item, extent)) in items.iter().zip(extents).enumerate() {
            let item_index = index as u32;
            if let Shape::Mesh(mesh) = &item.shape {
                let first = parts.len() as u32;
                let faces = 0..mesh.faces.len() as u32;
                let boxes = faces.clone().into_par_iter().map(|face| Bounds::around(mesh.points(face as usize)));
                parts.par_extend(
                    boxes.clone().zip(faces.clone()).map(|(b, face)| Part::new(&b.narrowed(), first + face)),
                );
                bounds = bounds.union(boxes.reduce(|| Bounds::EMPTY, Bounds::union));
                sources.extend(faces.map(|face| Primitive { item: item_index, face }));
            } else if let Some(extent) = extent {
                if extent.radius >= 0.0 {
                    let tight = extent.tight_box();
                    parts.push(Part::new(&tight.narrowed(), parts.len() as u32));
                    bounds = bounds.union(tight);
                    sources.push(Primitive { item: item_index, face: 0 });
                }
            } else {
                unbounded.push(item_index);
            }
        }

        let bvh = Bvh::build(&mut parts, kind);
        let primitives: Vec<Primitive> = parts.par_iter().map(|part| sources[part.index() as usize]).collect();
        drop((parts, sources));
        let extent = Extent::around(&items, extents, bounds);
        let expanded = items.last().map_or(0, |last| last.offset + last.expanded);
        let wide = match kind {
            _ if primitives.is_empty() => None,
            BvhKind::Flat => Some(Wide::flat(bvh.nodes[0].slab, primitives.len())),
            BvhKind::Sah | BvhKind::Median => Some(Wide::new(&bvh, &items, &primitives)),
        };
        Self { unbounded, wide, primitives, extent, expanded, items }
    }

    /// Whether something in it has no bounds.
    pub fn is_unbounded(&self) -> bool {
        !self.unbounded.is_empty()
    }

    /// The item that owns an expanded index of this geometry.
    pub(super) fn owner(&self, expanded: u64) -> &Item<R> {
        // Where every item has one primitive, the index names the item; and often the last one has most.
        for item in self.items.get(expanded as usize).into_iter().chain(self.items.last()) {
            if expanded.wrapping_sub(item.offset) < item.expanded {
                return item;
            }
        }
        let after = self.items.partition_point(|item| item.offset <= expanded);
        // Items without primitives share their offset with the next, so the last one at or below owns the index.
        &self.items[after - 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sin_cos;
    use std::mem::size_of;

    fn bytes<T>(vec: &Vec<T>) -> usize {
        vec.capacity() * size_of::<T>()
    }

    /// A smooth, bumpy sheet of 2 n^2 triangles.
    fn sheet(n: u32) -> Item<f32> {
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
            shape: Shape::Mesh(Mesh {
                vertices,
                faces: (0..n * n).flat_map(square).collect::<Vec<_>>(),
                normals,
                uvs: Vec::new(),
            }),
            material: 0,
            sides: Sides::Both,
            hollow: false,
            closed: true,
            may_touch: false,
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
        let columns: usize = wide.columns.iter().map(bytes).sum();
        let parts = [mesh_bytes, bytes(&geometry.primitives), bytes(&wide.nodes), bytes(&wide.leaves), columns];
        let each = parts.map(|bytes| bytes as f64 / mesh.faces.len() as f64);
        assert!(each.iter().sum::<f64>() <= 100.0, "bytes for each triangle: {each:?}");
    }
}
