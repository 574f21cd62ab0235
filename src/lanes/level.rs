//! Names of instruction sets.

use fearless_simd::Level;

/// The instruction set that kernels are run with at a level, by name.
pub fn instructions(level: Level) -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if level.as_avx512().is_some() {
            "AVX-512"
        } else if level.as_avx2().is_some() {
            "AVX2"
        } else {
            "SSE2"
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        if format!("{level:?}").starts_with("Neon") { "NEON" } else { "no SIMD" }
    }
}
