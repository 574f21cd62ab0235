//! Vectors, colors and the few functions of the reals that must give the same bits on every machine.
//!
//! Descriptions and everything computed once per scene use f64 ([`glam::DVec3`]); the tracing kernel has its own
//! vectors over [`lanes`](crate::lanes). Transcendental functions come from the pure-Rust `libm`, not from the
//! platform.

/// The whole number e with 2^e <= |x| < 2^(e+1), for finite x other than 0.
pub use libm::ilogb as exponent;
/// x 2^e, rounded once.
pub use libm::scalbn as scale_by_power;
/// Sine and cosine of an angle in radians.
pub use libm::sincos as sin_cos;
pub use libm::{acos, asin, atan, atan2, exp, log2, pow, tan};

/// The length of (x, y), which is 0 or from 1e-150 to 1e150. The platform's differs between platforms.
pub fn hypot(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// A linear color or radiance; each channel at least 0.
pub type Rgb = glam::DVec3;

/// sRGB transfer function (IEC 61966-2-1): encoded value in [0, 1] to linear light in [0, 1].
pub fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { pow((encoded + 0.055) / 1.055, 2.4) }
}

/// Inverse of [`srgb_to_linear`].
pub fn linear_to_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * pow(linear, 1.0 / 2.4) - 0.055 }
}
