//! Materials, lights and media: pure functions over lanes, without access to the scene.

pub mod bright_directions;
pub mod emitters;
mod environment_pyramid;
pub mod fog;
pub mod light;
pub mod lobe_highlights;
pub mod lobes;
pub mod material;
pub mod media;
pub mod microfacet;
pub mod optics;
pub mod pbr;
pub mod phong;
pub mod spectrum;
mod split_sum;
pub mod surroundings;
pub mod texture;
