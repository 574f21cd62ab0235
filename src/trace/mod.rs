//! Whitted's recursion, L = L_Phong + r_s L_s + r_t L_t (CACM 23(6), 1980), as a loop over an explicit stack.

mod attenuation;
pub(crate) mod certificate;
mod colored_shadows;
mod cones;
pub mod control;
pub mod counts;
pub mod enclosing;
mod fresnel;
mod gather;
pub mod hits;
pub mod interface;
pub mod kernel;
pub mod lighting;
pub mod observer;
pub mod pixel;
pub mod sampling;
pub mod secondary;
mod texturing;
mod touching;
pub mod variants;
mod waves;
