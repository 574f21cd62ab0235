//! Names of instruction sets.

use fearless_simd::Level;

/// The instruction set that kernels are run with at a level, by name.
pub fn instructions(level: Level) -> &'static str {
    #[cfg(target_arch = "x86_64")]
    match () {
        () if level.as_avx512().is_some() => "AVX-512",
        () if level.as_avx2().is_some() => "AVX2",
        () => "no SIMD",
    }
    #[cfg(target_arch = "aarch64")]
    if level.as_neon().is_some() {
        "NEON"
    } else {
        "no SIMD"
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    {
        let _ = level;
        "no SIMD"
    }
}
