//! Bounding volume hierarchies: what a ray meets, without asking everything.

mod beam;
mod bins;
mod bounds;
mod build;
mod descent;
mod geometry;
mod memory;
mod motion;
mod nearness;
mod occlusion;
mod part;
mod placement;
mod primitive;
mod resolve;
mod traverse;
mod wide;

pub use bounds::Bounds;
pub use build::{Bvh, BvhKind};
pub use descent::Course;
pub use geometry::{Ball, Extent, Geometry, Instance, Item, Mesh, Placement, Shape};
pub use motion::Motion;
pub use nearness::nearness;
pub use occlusion::{Blockers, transmittance};
pub use resolve::{Owner, Spheres, Surface, resolve};
pub use traverse::{Nearest, Skipped, nearest_hit};
