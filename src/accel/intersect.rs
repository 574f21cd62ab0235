//! Intersection of rays with one primitive of any kind.

use super::item::{Item, Shape};
use crate::lanes::{Lanes, V3};
use crate::ray::{Hit, Intersection, Rays};
use crate::shape::{Frusta, Shear, Sphere, hit_frusta, hit_sphere, hit_triangle, triangle_surface};

/// Intersection of rays with one primitive of an item that is not an instance. Not inlined: a copy of every shape in each
/// caller would cost compile time and gain nothing.
pub(super) fn intersect_item<L: Lanes>(s: L::Simd, item: &Item<L::Real>, face: u32, rays: &Rays<L>) -> Intersection<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || match &item.shape {
            Shape::Sphere(sphere) => sphere.intersect(s, rays, item.sides),
            Shape::Mesh(mesh) => {
                let corners = splat_corners(s, &mesh.vertices, mesh.faces[face as usize]);
                let hit = hit_triangle(s, corners, rays, &Shear::new(s, rays), item.sides);
                triangle_surface(s, corners, &hit, rays)
            }
            Shape::Plane(plane) => plane.intersect(s, rays, item.sides),
            Shape::Disc(disc) => disc.intersect(s, rays, item.sides),
            Shape::Cuboid(cuboid) => cuboid.intersect(s, rays, item.sides),
            Shape::Frustum(frustum) => frustum.intersect(s, rays, item.sides),
            Shape::Torus(torus) => torus.intersect(s, rays, item.sides),
            Shape::Instance(_) => unreachable!("instances are descended into, not met"),
        },
    )
}

/// The same without the surface, which the compiler leaves out.
pub(super) fn hit_item<L: Lanes>(s: L::Simd, item: &Item<L::Real>, face: u32, rays: &Rays<L>) -> Hit<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || match &item.shape {
            Shape::Sphere(Sphere { center, radius }) => {
                hit_sphere(s, V3::splat(s, *center), L::splat(s, *radius), rays, item.sides)
            }
            Shape::Mesh(mesh) => {
                let corners = splat_corners(s, &mesh.vertices, mesh.faces[face as usize]);
                hit_triangle(s, corners, rays, &Shear::new(s, rays), item.sides)
            }
            Shape::Plane(plane) => plane.intersect(s, rays, item.sides).hit,
            Shape::Disc(disc) => disc.intersect(s, rays, item.sides).hit,
            Shape::Cuboid(cuboid) => cuboid.intersect(s, rays, item.sides).hit,
            Shape::Frustum(frustum) => hit_frusta(s, &Frusta::splat(s, frustum), frustum.capped, rays, item.sides),
            Shape::Torus(torus) => torus.intersect(s, rays, item.sides).hit,
            Shape::Instance(_) => unreachable!("instances are descended into, not met"),
        },
    )
}

/// The data of the three vertices of one face, in all lanes.
#[inline(always)]
pub(super) fn splat_corners<L: Lanes>(s: L::Simd, points: &[[L::Real; 3]], [a, b, c]: [u32; 3]) -> [V3<L>; 3] {
    [V3::splat(s, points[a as usize]), V3::splat(s, points[b as usize]), V3::splat(s, points[c as usize])]
}
