//! Bounding volume hierarchies: what a ray meets, without asking everything.

mod bounds;
mod build;
mod geometry;
mod memory;
mod occlusion;
mod resolve;
mod single;
mod traverse;
mod wide;

pub use bounds::Bounds;
pub use build::{Bvh, BvhKind};
pub use geometry::{Ball, Extent, Geometry, Instance, Item, Mesh, Placement, Shape};
pub use occlusion::{Blockers, transmittance};
pub use resolve::{Owner, Surface, resolve};
pub use traverse::{Course, Nearest, Skipped, nearest_hit};
