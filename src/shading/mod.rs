//! What surfaces do with light: pure functions over lanes, without access to the scene.

pub mod chart;
pub mod environment;
pub mod facet;
pub mod fog;
pub mod light;
pub mod material;
pub mod media;
pub mod noise;
pub mod optics;
pub mod pattern;
pub mod phong;
pub mod pyramid;
pub mod relief;
pub mod spectrum;
