//! Bounding volume hierarchies: what a ray hits, without testing every primitive.

mod bounds;
mod build;
mod build_primitive;
mod extent;
mod geometry;
mod intersect;
mod item;
mod least_distance;
mod motion;
mod nearest_hit;
mod occlusion;
mod overlap;
mod owner;
mod packet_bounds;
mod placement;
mod resolve;
mod sah;
mod surface;
mod traversal;
mod wide_bvh;

pub use bounds::Bounds;
pub use build::{Bvh, BvhKind};
pub use extent::{Ball, Extent};
pub(crate) use geometry::ALLOCATION;
pub use geometry::Geometry;
pub use item::{Instance, Item, Mesh, Shape};
pub use least_distance::least_distances;
pub use motion::Motion;
pub use nearest_hit::{Nearest, Skipped, nearest_hit};
pub use occlusion::{Blockers, transmittance};
pub use overlap::overlap;
pub use owner::Owner;
pub use placement::Placement;
pub use resolve::{Spheres, resolve};
pub use surface::Surface;
pub use traversal::Coherence;
