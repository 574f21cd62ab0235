//! From the number of a primitive to the surface a ray has met there, in the coordinates of the scene.

use super::geometry::{Geometry, Item, Mesh, Placement, Shape};
use super::traverse::intersect_called;
use crate::lanes::{Lanes, MAX_LANES, Real, V3};
use crate::ray::{Meeting, Rays, Wanted, gamma};
use crate::shape::{Shear, intersect_triangle};

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
    pub fn find(geometries: &'a [Geometry<R>], root: usize, expanded: u64) -> Self {
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

    /// Whether an expanded index belongs to this body.
    pub fn owns(&self, expanded: u64) -> bool {
        (self.body..self.body + self.item.expanded).contains(&expanded)
    }
}

/// The surfaces that `rays` (as they were cast) meet on the primitives `expanded` of one body.
pub fn resolve<L: Lanes>(
    s: L::Simd,
    owner: &Owner<'_, L::Real>,
    expanded: &[u64; MAX_LANES],
    rays: &Rays<L>,
) -> Surface<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || resolve_in(s, owner, expanded, rays),
    )
}

#[inline(always)]
fn resolve_in<L: Lanes>(
    s: L::Simd,
    owner: &Owner<'_, L::Real>,
    expanded: &[u64; MAX_LANES],
    rays: &Rays<L>,
) -> Surface<L> {
    // Down to the body's own coordinates ...
    let mut inner = *rays;
    for placed in &owner.instances {
        if let Shape::Instance(instance) = &placed.shape {
            inner = instance.rays_in(s, &inner);
        }
    }
    let meeting = meet(s, owner, expanded, &inner);
    let outward = if owner.item.hollow { L::lit(s, -1.0) } else { L::lit(s, 1.0) };
    // The tip of a cone has no normal; it faces its ray.
    let size = meeting.normal.abs();
    let measurable = (size.x + size.y + size.z).gt(L::lit(s, 0.0));
    let normal = V3::select(measurable, meeting.normal * outward, -inner.dir);
    let ng = unit(s, normal);
    let Smooth { ns, lift } = match &owner.item.shape {
        Shape::Mesh(mesh) if !mesh.normals.is_empty() => {
            interpolate(s, mesh, |lane| face_of(owner, expanded[lane]), &meeting, ng, inner.dir)
        }
        _ => Smooth { ns: ng, lift: V3::splat(s, [L::Real::from_f64(0.0); 3]) },
    };
    let (point, error) = (meeting.point, meeting.error);
    let mut surface = Surface { point, error, ng, ns, lift, local: point, met: meeting.hit };
    // ... and back up, from the innermost placement out.
    let smooth = matches!(&owner.item.shape, Shape::Mesh(mesh) if !mesh.normals.is_empty());
    for placed in owner.instances.iter().rev() {
        if let Shape::Instance(instance) = &placed.shape {
            surface = surface.placed(s, &instance.to_world, &instance.to_local, smooth);
        }
    }
    surface
}

/// Meets the same primitives again, now for point, error and normal.
#[inline(always)]
fn meet<L: Lanes>(s: L::Simd, owner: &Owner<'_, L::Real>, expanded: &[u64; MAX_LANES], rays: &Rays<L>) -> Meeting<L> {
    match &owner.item.shape {
        Shape::Mesh(mesh) => {
            let shear = Shear::new(s, rays);
            let corners = gather(s, |lane| mesh.corners(face_of(owner, expanded[lane])));
            intersect_triangle(s, corners, rays, &shear, owner.item.sides)
        }
        _ => intersect_called(s, owner.item, 0, rays, &Shear::unused(s, rays), Wanted::Surface),
    }
}

/// Three points for each lane.
#[inline(always)]
fn gather<L: Lanes>(s: L::Simd, points: impl Fn(usize) -> [[L::Real; 3]; 3]) -> [V3<L>; 3] {
    let mut columns = [[L::Real::default(); MAX_LANES]; 9];
    for lane in 0..L::COUNT {
        for (column, number) in columns.iter_mut().zip(points(lane).as_flattened()) {
            column[lane] = *number;
        }
    }
    [0, 3, 6].map(|k| V3 { x: L::load(s, &columns[k]), y: L::load(s, &columns[k + 1]), z: L::load(s, &columns[k + 2]) })
}

/// The face with an expanded index; the first one in lanes that belong to other bodies.
#[inline(always)]
fn face_of<R: Real>(owner: &Owner<'_, R>, expanded: u64) -> usize {
    if owner.owns(expanded) { (expanded - owner.body) as usize } else { 0 }
}

/// What interpolated normals make of a facet.
struct Smooth<L: Lanes> {
    ns: V3<L>,
    lift: V3<L>,
}

/// The shading normal on the side of `ng`, and the way from the facet to the surface whose tangent planes at the corners
/// are those of the normals: P' - P = sum b_k max(0, n_k.(v_k - P)) n_k, with the normals turned to the ray's side
/// (Hanika, Hacking the Shadow Terminator, Ray Tracing Gems II, ch. 4). Where the surface is hollow it is 0.
#[inline(always)]
fn interpolate<L: Lanes>(
    s: L::Simd,
    mesh: &Mesh<L::Real>,
    face: impl Fn(usize) -> usize,
    meeting: &Meeting<L>,
    ng: V3<L>,
    dir: V3<L>,
) -> Smooth<L> {
    let zero = L::lit(s, 0.0);
    let normals = gather::<L>(s, |lane| mesh.faces[face(lane)].map(|i| mesh.normals[i as usize]));
    let [b1, b2] = meeting.barycentric;
    let weights = [L::lit(s, 1.0) - b1 - b2, b1, b2];
    // Interpolated normals may cancel, and some files have them pointing inwards.
    let ns = normals[0] * weights[0] + normals[1] * weights[1] + normals[2] * weights[2];
    let length = ns.length();
    let unit = V3 { x: ns.x / length, y: ns.y / length, z: ns.z / length };
    let side = unit.dot(ng);
    let outward = V3::select(side.lt(zero), -unit, unit);
    let known = side.abs().gt(zero);

    let (inwards, behind) = (side.lt(zero), dir.dot(ng).gt(zero));
    let turned = (inwards & !behind) | (behind & !inwards);
    let turn = L::select(turned, L::lit(s, -1.0), L::lit(s, 1.0));
    let mut lift = V3 { x: zero, y: zero, z: zero };
    let corners = gather::<L>(s, |lane| mesh.corners(face(lane)));
    for ((normal, corner), weight) in normals.into_iter().zip(corners).zip(weights) {
        let normal = normal * turn;
        lift = lift + normal * (weight * normal.dot(corner - meeting.point).max(zero));
    }
    let none = V3 { x: zero, y: zero, z: zero };
    Smooth { ns: V3::select(known, outward, ng), lift: V3::select(known, lift, none) }
}

/// Unit vector of any vector but 0, without overflow or underflow in its square.
#[inline(always)]
fn unit<L: Lanes>(s: L::Simd, v: V3<L>) -> V3<L> {
    let a = v.abs();
    let scale = L::lit(s, 1.0) / a.x.max(a.y).max(a.z);
    (v * scale).normalized()
}

impl<L: Lanes> Surface<L> {
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
