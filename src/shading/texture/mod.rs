//! Textures: colours, bumps and surroundings that depend on the place, f64 for one ray at a time.

pub mod bump;
pub mod checker;
pub mod environment;
pub mod image;
pub mod mipmap;
pub mod noise;
pub mod pattern;
pub mod uv;
