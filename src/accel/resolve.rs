//! From the expanded index of a primitive to the surface that a ray hits there, in the coordinates of the scene.

use super::intersect::{intersect_item, splat_corners};
use super::item::{Mesh, Shape};
use super::owner::Owner;
use super::surface::Surface;
use crate::lanes::{Ids, Lanes, MAX_LANES, Real, V3, lanes_of};
use crate::ray::{Hit, Intersection, Rays};
use crate::shape::{Shear, Sides, hit_sphere, hit_triangle, sphere_surface, triangle_surface};

/// The surfaces that the `lanes` of `rays` (as they were cast) hit on the primitives `expanded` of one body, computed from
/// what traversal has found. Spheres inside instances, rare shapes, and everything of which nothing is known, are
/// intersected again.
#[inline(always)]
pub(crate) fn resolve<L: Lanes>(
    s: L::Simd,
    owner: &Owner<'_, L::Real>,
    expanded: L::Ids,
    lanes: u32,
    rays: &Rays<L>,
    known: Option<&Hit<L>>,
    time: Option<&L>,
) -> Surface<L> {
    // Down to the body's own coordinates ...
    let mut inner = *rays;
    for placed in &owner.instances {
        if let Shape::Instance(instance) = &placed.shape {
            inner = instance.rays_in(s, &inner, time);
        }
    }
    let outward = if owner.item.hollow { L::lit(s, -1.0) } else { L::lit(s, 1.0) };
    let mut smooth = false;
    let mut surface = match &owner.item.shape {
        Shape::Mesh(mesh) => {
            let faces = Faces::new(s, owner, mesh, expanded, lanes);
            let corners = faces.corners(s, &mesh.vertices);
            let hit = match known {
                Some(hit) => *hit,
                None => hit_triangle(s, corners, &inner, &Shear::new(s, &inner), owner.item.sides),
            };
            let intersection = triangle_surface(s, corners, &hit, &inner);
            let flat = Surface::flat(s, &intersection, outward, inner.dir);
            smooth = owner.item.is_smooth();
            if smooth { flat.curved(s, mesh, &faces, corners, &intersection, inner.dir) } else { flat }
        }
        Shape::Sphere(sphere) => {
            let (center, radius) = (V3::splat(s, sphere.center), L::splat(s, sphere.radius));
            let hit = match known {
                // Inside instances ray parameters have another unit.
                Some(hit) if owner.instances.is_empty() => *hit,
                _ => hit_sphere(s, center, radius, &inner, owner.item.sides),
            };
            Surface::flat(s, &sphere_surface(s, center, radius, &inner, &hit), outward, inner.dir)
        }
        _ => {
            let intersection = intersect_item(s, owner.item, 0, &inner);
            Surface::flat(s, &intersection, outward, inner.dir)
        }
    };
    // ... and back up, from the innermost placement out.
    for placed in owner.instances.iter().rev() {
        if let Shape::Instance(instance) = &placed.shape {
            surface = surface.placed(s, &instance.to_world, &instance.to_local, smooth);
            if let (Some(motion), Some(time)) = (&instance.motion, time) {
                surface = motion.forth(s, surface, *time);
            }
        }
    }
    surface
}

/// Spheres outside of instances, one for each lane.
#[derive(Debug)]
pub(crate) struct Spheres<R> {
    /// Lanes that have one.
    pub lanes: u32,
    hollow: u32,
    /// Coordinates of the centres, and radii.
    columns: [[R; MAX_LANES]; 4],
}

impl<R: Real> Spheres<R> {
    /// No lane has a sphere.
    #[inline(always)]
    pub(crate) fn none() -> Self {
        Self { lanes: 0, hollow: 0, columns: [[R::default(); MAX_LANES]; 4] }
    }

    /// Takes a sphere that some lanes have hit; returns false if it is another shape, or one-sided.
    #[inline(always)]
    pub(crate) fn take(&mut self, owner: &Owner<'_, R>, lanes: u32) -> bool {
        let Shape::Sphere(sphere) = &owner.item.shape else { return false };
        if !owner.instances.is_empty() || owner.item.sides != Sides::Both {
            return false;
        }
        let [x, y, z] = sphere.center;
        for lane in lanes_of(lanes) {
            for (column, number) in self.columns.iter_mut().zip([x, y, z, sphere.radius]) {
                column[lane] = number;
            }
        }
        self.lanes |= lanes;
        self.hollow |= if owner.item.hollow { lanes } else { 0 };
        true
    }

    /// The surfaces that rays meet on them.
    #[inline(always)]
    pub(crate) fn resolve<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>, known: Option<&Hit<L>>) -> Surface<L> {
        let [x, y, z, radius] = &self.columns;
        let (center, radius) = (V3 { x: L::load(s, x), y: L::load(s, y), z: L::load(s, z) }, L::load(s, radius));
        let hit = match known {
            Some(hit) => *hit,
            None => {
                let asked = Rays { active: L::mask(s, self.lanes), ..*rays };
                hit_sphere(s, center, radius, &asked, Sides::Both)
            }
        };
        let intersection = sphere_surface(s, center, radius, rays, &hit);
        let outward = L::select(L::mask(s, self.hollow), L::lit(s, -1.0), L::lit(s, 1.0));
        Surface::flat(s, &intersection, outward, rays.dir)
    }
}

/// A face of a mesh for each lane.
enum Faces<L: Lanes> {
    /// The same in all lanes: most packets on large triangles.
    One([u32; 3]),
    /// Lanes of the mask have hit the second face, others the first.
    Two(L::Mask, [[u32; 3]; 2]),
    Many([[u32; 3]; MAX_LANES]),
}

impl<L: Lanes> Faces<L> {
    /// The faces that some lanes have hit.
    #[inline(always)]
    fn new(s: L::Simd, owner: &Owner<'_, L::Real>, mesh: &Mesh<L::Real>, expanded: L::Ids, lanes: u32) -> Self {
        let face = |id: u64| mesh.faces[(id - owner.body) as usize];
        let (first, same) = expanded.same_as_first(s, lanes);
        let others = lanes & !same;
        if others == 0 {
            return Self::One(face(first));
        }
        let (second, same) = expanded.same_as_first(s, others);
        if others == same {
            return Self::Two(L::mask(s, others), [face(first), face(second)]);
        }
        let mut faces = [face(first); MAX_LANES];
        for lane in lanes_of(others) {
            faces[lane] = face(expanded.lane(lane));
        }
        Self::Many(faces)
    }

    /// The data of their three vertices.
    #[inline(always)]
    fn corners(&self, s: L::Simd, points: &[[L::Real; 3]]) -> [V3<L>; 3] {
        match self {
            Self::One(face) => splat_corners(s, points, *face),
            Self::Two(second, faces) => {
                let ([a, b, c], [d, e, f]) = (splat_corners(s, points, faces[0]), splat_corners(s, points, faces[1]));
                [V3::select(*second, d, a), V3::select(*second, e, b), V3::select(*second, f, c)]
            }
            Self::Many(faces) => {
                let mut columns = [[L::Real::default(); MAX_LANES]; 9];
                for lane in 0..L::COUNT {
                    for (corner, &index) in faces[lane].iter().enumerate() {
                        let [x, y, z] = points[index as usize];
                        columns[3 * corner][lane] = x;
                        columns[3 * corner + 1][lane] = y;
                        columns[3 * corner + 2][lane] = z;
                    }
                }
                let column = |k: usize| L::load(s, &columns[k]);
                let corner = |k: usize| V3 { x: column(k), y: column(k + 1), z: column(k + 2) };
                [corner(0), corner(3), corner(6)]
            }
        }
    }
}

impl<L: Lanes> Surface<L> {
    /// The same with interpolated normals: the shading normal on the side of `ng`, and the vector from the facet to the
    /// curved surface whose tangent planes at the corners belong to the normals,
    /// P' - P = sum b_k max(0, n_k.(v_k - P)) n_k, with the normals turned to the ray's side (Hanika, Hacking the Shadow
    /// Terminator, Ray Tracing Gems II, ch. 4). Where the surface is concave the vector is 0.
    #[inline(always)]
    fn curved(
        self,
        s: L::Simd,
        mesh: &Mesh<L::Real>,
        faces: &Faces<L>,
        corners: [V3<L>; 3],
        intersection: &Intersection<L>,
        dir: V3<L>,
    ) -> Self {
        let zero = L::lit(s, 0.0);
        let normals = faces.corners(s, &mesh.normals);
        let [_, b1, b2] = intersection.hit.weights;
        let weights = [L::lit(s, 1.0) - b1 - b2, b1, b2];
        // Interpolated normals may cancel, and in some files they point inwards.
        let ns = normals[0] * weights[0] + normals[1] * weights[1] + normals[2] * weights[2];
        let unit = ns.normalized(s);
        let side = unit.dot(self.ng);
        let outward = V3::select(side.lt(zero), -unit, unit);
        let known = side.abs().gt(zero);

        let (inwards, behind) = (side.lt(zero), dir.dot(self.ng).gt(zero));
        let turned = (inwards & !behind) | (behind & !inwards);
        let turn = L::select(turned, L::lit(s, -1.0), L::lit(s, 1.0));
        let mut lift = V3 { x: zero, y: zero, z: zero };
        for ((normal, corner), weight) in normals.into_iter().zip(corners).zip(weights) {
            let normal = normal * turn;
            lift = lift + normal * (weight * normal.dot(corner - intersection.point).max(zero));
        }
        Self { ns: V3::select(known, outward, self.ng), lift: V3::select(known, lift, self.lift), ..self }
    }
}
