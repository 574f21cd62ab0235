//! Intersection of rays with each kind of shape, in the shape's own space.
//!
//! Each shape has one function `intersect`, which finds the nearest intersection inside the ray's range with its point,
//! error bound and normal. Spheres and triangles have two: one for the distance, which is all that traversal needs, and
//! one that computes the surface from what the first has found. [`ear_clipping`] cuts polygons into triangles.

mod cuboid;
mod disc;
pub mod ear_clipping;
mod frame;
mod frustum;
mod plane;
mod quartic;
mod sides;
mod sphere;
mod torus;
#[cfg(test)]
mod torus_test_twin;
mod triangle;

pub use cuboid::Cuboid;
pub use disc::Disc;
pub use frame::Frame;
pub use frustum::{FRUSTUM_NUMBERS, Frusta, Frustum, frusta_crossings, hit_frusta};
pub use plane::Plane;
pub use sides::Sides;
pub use sphere::{Sphere, hit_sphere, sphere_crossings, sphere_surface};
pub use torus::Torus;
pub use triangle::{Shear, hit_triangle, is_collapsed, triangle_surface};
