//! From the number of a primitive to the surface a ray has met there, in the coordinates of the scene.

use super::geometry::{Geometry, Item, Mesh, Placement, Shape};
use super::primitive::intersect_item;
use crate::lanes::{Ids, Lanes, MAX_LANES, Mask, Real, V3, lanes_of};
use crate::ray::{Meeting, Place, Rays, Wanted, gamma};
use crate::shape::{Shear, Sides, place_on_sphere, place_on_triangle, sphere_surface, triangle_surface};

/// A surface under each ray.
#[derive(Debug, Clone, Copy)]
pub struct Surface<L: Lanes> {
    /// The point, on the surface as exactly as the format allows.
    pub point: V3<L>,
    /// Bound on the error of each of its coordinates.
    pub error: V3<L>,
    /// Geometric normal: unit, pointing out of the body's material.
    pub ng: V3<L>,
    /// Shading normal: unit, on the same side as `ng`.
    pub ns: V3<L>,
    /// From the point to the curved surface that interpolated normals pretend, on the side the ray comes from.
    pub lift: V3<L>,
    /// The point in the coordinates in which the body is written.
    pub local: V3<L>,
    /// Lanes whose ray does meet the body; the rest holds nothing.
    pub met: L::Mask,
}

/// The body that owns a primitive, and where it stands in the expanded scene.
#[derive(Debug)]
pub struct Owner<'a, R> {
    /// The item.
    pub item: &'a Item<R>,
    /// Expanded index of its first primitive: the identity of the placed body.
    pub body: u64,
    /// The placed geometries around it, outermost first.
    pub instances: Vec<&'a Item<R>>,
}

impl<'a, R: Real> Owner<'a, R> {
    /// Finds the owner of an expanded index.
    #[inline(always)]
    pub fn find(geometries: &'a [Geometry<R>], root: usize, expanded: u64) -> Self {
        let item = geometries[root].owner(expanded);
        match &item.shape {
            Shape::Instance(_) => Self::find_placed(geometries, root, expanded),
            _ => Self { item, body: item.offset, instances: Vec::new() },
        }
    }

    fn find_placed(geometries: &'a [Geometry<R>], root: usize, expanded: u64) -> Self {
        let mut geometry = &geometries[root];
        let mut base = 0;
        let mut instances = Vec::new();
        loop {
            let item = geometry.owner(expanded - base);
            base += item.offset;
            match &item.shape {
                Shape::Instance(instance) => {
                    instances.push(item);
                    geometry = &geometries[instance.geometry as usize];
                }
                _ => return Self { item, body: base, instances },
            }
        }
    }

    /// What the placed body encloses.
    pub fn volume(&self) -> f64 {
        let scale = |item: &&Item<R>| match &item.shape {
            Shape::Instance(instance) => instance.to_world.volume_scale(),
            _ => 1.0,
        };
        self.item.volume * self.instances.iter().map(scale).product::<f64>()
    }

    /// The lanes of `among` that have met this body.
    #[inline(always)]
    pub fn lanes<L: Lanes<Real = R>>(&self, s: L::Simd, expanded: L::Ids, among: u32) -> u32 {
        let first = L::Ids::splat(s, self.body);
        let own = if self.item.expanded == 1 {
            expanded.eq(first)
        } else {
            expanded.ge(first) & !expanded.ge(L::Ids::splat(s, self.body + self.item.expanded))
        };
        own.bits() & among
    }
}

/// The surfaces that the `lanes` of `rays` (as they were cast) meet on the primitives `expanded` of one body, at the places
/// that are known from traversal. Spheres inside instances, rare shapes, and everything where no place is known, are met
/// again.
#[inline(always)]
pub fn resolve<L: Lanes>(
    s: L::Simd,
    owner: &Owner<'_, L::Real>,
    expanded: L::Ids,
    lanes: u32,
    rays: &Rays<L>,
    known: Option<&Place<L>>,
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
            let place = match known {
                Some(place) => *place,
                None => place_on_triangle(s, corners, &inner, &Shear::new(s, &inner), owner.item.sides),
            };
            let meeting = triangle_surface(s, corners, &place, inner.dir);
            let flat = Surface::flat(s, &meeting, outward, inner.dir);
            smooth = owner.item.is_smooth();
            if smooth { flat.curved(s, mesh, &faces, corners, &meeting, inner.dir) } else { flat }
        }
        Shape::Sphere(sphere) => {
            let (center, radius) = (V3::splat(s, sphere.center), L::splat(s, sphere.radius));
            let place = match known {
                // Ray parameters are others inside instances.
                Some(place) if owner.instances.is_empty() => *place,
                _ => place_on_sphere(s, center, radius, &inner, owner.item.sides),
            };
            Surface::flat(s, &sphere_surface(s, center, radius, &inner, &place), outward, inner.dir)
        }
        _ => {
            let meeting = intersect_item(s, owner.item, 0, &inner, Wanted::Surface);
            Surface::flat(s, &meeting, outward, inner.dir)
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

/// Spheres that are no part of anything placed, one for each lane.
#[derive(Debug)]
pub struct Spheres<R> {
    /// Lanes that have one.
    pub lanes: u32,
    hollow: u32,
    /// Coordinates of the centres, and radii.
    columns: [[R; MAX_LANES]; 4],
}

impl<R: Real> Spheres<R> {
    /// No lane has a sphere.
    #[inline(always)]
    pub fn none() -> Self {
        Self { lanes: 0, hollow: 0, columns: [[R::default(); MAX_LANES]; 4] }
    }

    /// Takes a sphere that some lanes have met; not if it is something else, or one-sided.
    #[inline(always)]
    pub fn take(&mut self, owner: &Owner<'_, R>, lanes: u32) -> bool {
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
    pub fn resolve<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>, known: Option<&Place<L>>) -> Surface<L> {
        let [x, y, z, radius] = &self.columns;
        let (center, radius) = (V3 { x: L::load(s, x), y: L::load(s, y), z: L::load(s, z) }, L::load(s, radius));
        let place = match known {
            Some(place) => *place,
            None => {
                let asked = Rays { active: L::mask(s, self.lanes), ..*rays };
                place_on_sphere(s, center, radius, &asked, Sides::Both)
            }
        };
        let meeting = sphere_surface(s, center, radius, rays, &place);
        let outward = L::select(L::mask(s, self.hollow), L::lit(s, -1.0), L::lit(s, 1.0));
        Surface::flat(s, &meeting, outward, rays.dir)
    }
}

/// A face of a mesh for each lane.
enum Faces<L: Lanes> {
    /// Most packets see no more of large triangles.
    One([u32; 3]),
    /// Lanes of the mask have met the second face, others the first.
    Two(L::Mask, [[u32; 3]; 2]),
    Many([[u32; 3]; MAX_LANES]),
}

impl<L: Lanes> Faces<L> {
    /// The faces that some lanes have met.
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

    /// What belongs to their three vertices.
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

/// What belongs to the vertices of one face, in all lanes.
#[inline(always)]
pub(super) fn splat_corners<L: Lanes>(s: L::Simd, points: &[[L::Real; 3]], [a, b, c]: [u32; 3]) -> [V3<L>; 3] {
    [V3::splat(s, points[a as usize]), V3::splat(s, points[b as usize]), V3::splat(s, points[c as usize])]
}

/// Unit vector of any vector but 0, without overflow or underflow in its square.
#[inline(always)]
fn unit<L: Lanes>(s: L::Simd, v: V3<L>) -> V3<L> {
    let a = v.abs();
    let exponent = a.x.max(a.y).max(a.z).exponent();
    (v * (-exponent.min(L::lit(s, L::Real::LOWEST))).power_of_two()).normalized(s)
}

impl<L: Lanes> Surface<L> {
    /// The surface at a meeting, in the body's coordinates. `outward` is -1 for bodies turned inside out.
    #[inline(always)]
    fn flat(s: L::Simd, meeting: &Meeting<L>, outward: L, dir: V3<L>) -> Self {
        // The tip of a cone has no normal; it faces its ray.
        let ng = if meeting.normalized {
            meeting.normal * outward
        } else {
            let size = meeting.normal.abs();
            let measurable = (size.x + size.y + size.z).gt(L::lit(s, 0.0));
            unit(s, V3::select(measurable, meeting.normal * outward, -dir))
        };
        let lift = V3::splat(s, [L::Real::from_f64(0.0); 3]);
        let (point, error) = (meeting.point, meeting.error);
        Self { point, error, ng, ns: ng, lift, local: point, met: meeting.place.hit }
    }

    /// The same with interpolated normals: the shading normal on the side of `ng`, and the way from the facet to the
    /// surface whose tangent planes at the corners are those of the normals,
    /// P' - P = sum b_k max(0, n_k.(v_k - P)) n_k, with the normals turned to the ray's side (Hanika, Hacking the Shadow
    /// Terminator, Ray Tracing Gems II, ch. 4). Where the surface is hollow it is 0.
    #[inline(always)]
    fn curved(
        self,
        s: L::Simd,
        mesh: &Mesh<L::Real>,
        faces: &Faces<L>,
        corners: [V3<L>; 3],
        meeting: &Meeting<L>,
        dir: V3<L>,
    ) -> Self {
        let zero = L::lit(s, 0.0);
        let normals = faces.corners(s, &mesh.normals);
        let [_, b1, b2] = meeting.place.weights;
        let weights = [L::lit(s, 1.0) - b1 - b2, b1, b2];
        // Interpolated normals may cancel, and some files have them pointing inwards.
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
            lift = lift + normal * (weight * normal.dot(corner - meeting.point).max(zero));
        }
        Self { ns: V3::select(known, outward, self.ng), lift: V3::select(known, lift, self.lift), ..self }
    }

    /// `a` where the mask is true, `b` elsewhere.
    #[inline(always)]
    pub fn select(mask: L::Mask, a: Self, b: Self) -> Self {
        Self {
            point: V3::select(mask, a.point, b.point),
            error: V3::select(mask, a.error, b.error),
            ng: V3::select(mask, a.ng, b.ng),
            ns: V3::select(mask, a.ns, b.ns),
            lift: V3::select(mask, a.lift, b.lift),
            local: V3::select(mask, a.local, b.local),
            met: (mask & a.met) | (!mask & b.met),
        }
    }

    /// The surface in the coordinates around a placed geometry. The error grows by the roundings of this map, and by
    /// those of mapping the origin of the next ray back (Wächter and Binder's and NVIDIA's bounds, with
    /// gamma(3)(|M||p| + |t|) each way).
    #[inline(always)]
    fn placed(self, s: L::Simd, to_world: &Placement<L::Real>, to_local: &Placement<L::Real>, smooth: bool) -> Self {
        let point = to_world.point(s, self.point);
        let step = L::lit(s, gamma::<L::Real>(4.0));
        let moved = to_world.spread(s, self.point.abs()) + V3::<L>::splat(s, to_world.translation).abs();
        let returned = to_local.spread(s, point.abs()) + V3::<L>::splat(s, to_local.translation).abs();
        let ng = unit(s, to_local.transposed(s, self.ng));
        Self {
            point,
            error: to_world.spread(s, self.error + returned * step) + moved * step,
            ng,
            ns: if smooth { unit(s, to_local.transposed(s, self.ns)) } else { ng },
            lift: if smooth { to_world.vector(s, self.lift) } else { self.lift },
            local: self.local,
            met: self.met,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_survives_extremes() {
        for size in [1e-38f32, 1e-20, 1.0, 1e20, 1e38] {
            let v = unit((), V3 { x: size, y: 0.0, z: -size });
            assert!((v.dot(v) - 1.0).abs() < 1e-6, "{size}");
        }
    }
}
