//! Whitted's recursion, L = L_Phong + r_s L_s + r_t L_t (CACM 23(6), 1980), as a loop over an explicit stack.

mod attenuation;
mod certificate;
mod coincident;
mod color_bleeding;
mod colored_shadows;
pub mod counts;
mod deferred;
pub mod eye_media;
mod fresnel;
pub mod hits;
pub mod interface;
pub mod kernel;
pub mod lighting;
pub mod observer;
pub mod pixel;
mod ray_cones;
pub mod ray_packet;
mod ray_stack;
pub mod sampling;
pub mod secondary;
mod texturing;
pub mod variants;
mod wavelengths;
