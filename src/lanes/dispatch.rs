//! Choosing the instruction set at run time, once per tile.

/// Runs `$body` with the best instructions of a level, `$s` being their proof. On x86-64 there are three copies of the
/// kernel, AVX-512, AVX2 and SSE2: one for SSE4.2 would cost a quarter of the build time, for processors before 2013.
#[cfg(target_arch = "x86_64")]
macro_rules! dispatch {
    ($level:expr, $s:ident => $body:expr) => {{
        use fearless_simd::Simd;
        if let Some($s) = $level.as_avx512() {
            $s.vectorize(
                #[inline(always)]
                || $body,
            )
        } else if let Some($s) = $level.as_avx2() {
            $s.vectorize(
                #[inline(always)]
                || $body,
            )
        } else if let Some($s) = $level.as_sse2() {
            $s.vectorize(
                #[inline(always)]
                || $body,
            )
        } else {
            unreachable!("every x86-64 processor has SSE2")
        }
    }};
}
#[cfg(not(target_arch = "x86_64"))]
macro_rules! dispatch {
    ($level:expr, $s:ident => $body:expr) => {
        fearless_simd::dispatch!($level, $s => $body)
    };
}
pub(crate) use dispatch;
