//! Textures: colors, bumps and surroundings that depend on the place, in double precision.

pub mod bump;
pub mod checker;
pub mod environment;
pub mod image;
pub mod lookup;
pub mod mipmap;
pub mod noise;
pub mod pattern;
pub mod studio;
mod trilinear;
mod trilinear_lanes;
pub mod uv;
