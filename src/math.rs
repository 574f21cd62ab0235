//! Vectors, colours and the few functions of the reals that must give the same bits on every machine.
//!
//! Descriptions and everything computed once per scene use f64 ([`glam::DVec3`]); the tracing kernel has its own
//! vectors over [`lanes`](crate::lanes). Transcendental functions come from the pure-Rust `libm`, not from the
//! platform.

/// A linear colour or radiance; each channel at least 0.
pub type Rgb = glam::DVec3;

/// sRGB transfer function (IEC 61966-2-1): encoded value in [0, 1] to linear light in [0, 1].
pub fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// Inverse of [`srgb_to_linear`].
pub fn linear_to_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 }
}

/// Sine and cosine of an angle in radians.
pub fn sin_cos(angle: f64) -> (f64, f64) {
    libm::sincos(angle)
}

/// Tangent of an angle in radians.
pub fn tan(angle: f64) -> f64 {
    libm::tan(angle)
}

/// Arc tangent in radians.
pub fn atan(x: f64) -> f64 {
    libm::atan(x)
}

/// Arc cosine in radians, of a value in [-1, 1].
pub fn acos(x: f64) -> f64 {
    libm::acos(x)
}

/// x^y.
pub fn pow(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// e^x.
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// Binary logarithm of a number above 0.
pub fn log2(x: f64) -> f64 {
    libm::log2(x)
}

/// Arc sine in radians, of a value in [-1, 1].
pub fn asin(x: f64) -> f64 {
    libm::asin(x)
}

/// The whole number e with 2^e <= |x| < 2^(e+1), for finite x other than 0.
pub fn exponent(x: f64) -> i32 {
    libm::ilogb(x)
}

/// x 2^e, rounded once.
pub fn scale_by_power(x: f64, e: i32) -> f64 {
    libm::scalbn(x, e)
}

/// Angle of the point (x, y) in radians, in (-pi, pi].
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}
