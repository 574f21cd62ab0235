//! Footprints of rays: the sections of their cones with the surfaces they hit.
//!
//! A cone of width w meets a plane in an ellipse: w across, and w / cos along the ray (Akenine-Moeller et al., Improved Shader and
//! Texture Level of Detail Using Ray Cones, JCGT 10(1), 2021). With the normal n and the part d of the direction in the plane, its extent
//! along an axis is w sqrt((d_axis / cos)^2 + 1 - n_axis^2).

use super::hits::Hits;
use super::ray_packet::RayPacket;
use crate::accel::Shape;
use crate::lanes::{Ids, Lanes, Real, V3};
use crate::scene::world::World;
use glam::{DMat3, DVec3};

/// Smallest cosine for the length of a footprint.
const LEAST_COSINE: f64 = 1e-4;

/// Extents of the footprints along the axes of the bodies' own coordinates; `widths` are those of the cones.
#[inline(never)]
pub(super) fn footprints<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    rays: &RayPacket<L>,
    widths: L,
    hits: &Hits<L>,
) -> V3<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || {
            let (n, dir) = (hits.ng, rays.dir);
            let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
            let cosine = -dir.dot(n);
            let along = (dir + n * cosine) * (one / cosine.max(L::lit(s, LEAST_COSINE)));
            let extents = V3 {
                x: widths * (along.x * along.x + (one - n.x * n.x).max(zero)).sqrt(),
                y: widths * (along.y * along.y + (one - n.y * n.y).max(zero)).sqrt(),
                z: widths * (along.z * along.z + (one - n.z * n.z).max(zero)).sqrt(),
            };
            if world.usage.placed { of_placed(s, world, along, widths, hits, extents) } else { extents }
        },
    )
}

/// The same where bodies have coordinates of their own: along the rows of the matrix that leads there.
#[inline(always)]
fn of_placed<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    along: V3<L>,
    widths: L,
    hits: &Hits<L>,
    mut extents: V3<L>,
) -> V3<L> {
    let mut left = hits.found;
    while left != 0 {
        let owner = world.owner(hits.expanded.lane(left.trailing_zeros() as usize));
        let same = owner.lanes::<L>(s, hits.expanded, left);
        left &= !same;
        if owner.instances.is_empty() {
            continue;
        }
        let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| owner.direction_into_object(axis));
        let rows = [0, 1, 2].map(|row| DVec3::new(columns[0][row], columns[1][row], columns[2][row]));
        let own = V3 {
            x: extent(s, rows[0], along, hits.ng, widths),
            y: extent(s, rows[1], along, hits.ng, widths),
            z: extent(s, rows[2], along, hits.ng, widths),
        };
        extents = V3::select(L::mask(s, same), own, extents);
    }
    extents
}

/// The extent along a row of that matrix.
#[inline(always)]
fn extent<L: Lanes>(s: L::Simd, row: DVec3, along: V3<L>, n: V3<L>, widths: L) -> L {
    let axis = V3::<L>::splat(s, row.to_array().map(L::Real::from_f64));
    let (along, n) = (axis.dot(along), axis.dot(n));
    widths * (along * along + (L::lit(s, row.length_squared()) - n * n).max(L::lit(s, 0.0))).sqrt()
}

/// How much the normal turns on a unit of length, on average over both directions of the surface: above 0 where the side that
/// the ray comes from is convex.
#[inline(never)]
pub(super) fn curvatures<L: Lanes>(s: L::Simd, world: &World<L::Real>, hits: &Hits<L>, lanes: u32) -> L {
    L::vectorize(
        s,
        #[inline(always)]
        || {
            let mut all = L::lit(s, 0.0);
            let mut left = lanes;
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                let owner = world.owner(hits.expanded.lane(lane));
                let same = if owner.item.is_smooth() {
                    // Those on the same face.
                    hits.expanded.same_as_first(s, left).1
                } else {
                    owner.lanes::<L>(s, hits.expanded, left)
                };
                left &= !same;
                let mut curvature = of_shape(&owner.item.shape, (hits.expanded.lane(lane) - owner.body) as usize);
                if curvature == 0.0 {
                    continue;
                }
                let mut scale = L::lit(s, 1.0);
                if !owner.instances.is_empty() {
                    // A placed body is smaller where a unit of the scene is more than one of its own. Areas across a normal grow
                    // by the length of the cofactor matrix times it.
                    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| owner.direction_into_object(axis));
                    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
                    // Relative to the largest, they neither vanish nor overflow in single precision.
                    let largest = cofactors.to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
                    curvature *= largest.sqrt();
                    let columns = (cofactors * (1.0 / largest)).to_cols_array_2d();
                    scale = hits.ng.turned(s, columns.map(|column| column.map(L::Real::from_f64))).length().sqrt();
                }
                all = L::select(L::mask(s, same), L::lit(s, curvature) * scale, all);
            }
            L::select(L::mask(s, hits.entering ^ hits.hollow), all, -all)
        },
    )
}

/// The mean curvature of a shape where it has been hit, seen from outside.
fn of_shape<R: Real>(shape: &Shape<R>, face: usize) -> f64 {
    match shape {
        Shape::Sphere(sphere) => 1.0 / sphere.radius.to_f64(),
        Shape::Frustum(frustum) => 1.0 / (frustum.base_radius + frustum.top_radius).to_f64(),
        Shape::Torus(torus) => 0.5 / torus.minor_radius.to_f64(),
        Shape::Mesh(mesh) if !mesh.normals.is_empty() => {
            let point = |p: [R; 3]| DVec3::new(p[0].to_f64(), p[1].to_f64(), p[2].to_f64());
            let corner = |i: u32| (point(mesh.vertices[i as usize]), point(mesh.normals[i as usize]));
            let turn = |(p, n): (DVec3, DVec3), (q, m): (DVec3, DVec3)| (m - n).dot(q - p) / (q - p).length_squared();
            let [i, j, k] = mesh.faces[face];
            let (a, b, c) = (corner(i), corner(j), corner(k));
            let mean = (turn(a, b) + turn(b, c) + turn(c, a)) / 3.0;
            if mean.is_finite() { mean } else { 0.0 }
        }
        _ => 0.0,
    }
}
