//! Choosing the instruction set at run time.

/// Calls a function `f::<Bundle, Real>(...)`, which is generic over lanes, with the widest bundle that a level has
/// instructions for, or with one lane below AVX2. The proof of the instructions becomes its first argument.
macro_rules! dispatch {
    ($level:expr, $f:ident::<$wide:ident, $one:ident>($($argument:expr),*)) => {{
        let level = $level;
        #[cfg(target_arch = "x86_64")]
        match (level.as_avx512(), level.as_avx2()) {
            (Some(s), _) => $f::<$wide<_>>(s, $($argument),*),
            (None, Some(s)) => $f::<$wide<_>>(s, $($argument),*),
            (None, None) => $f::<$one>((), $($argument),*),
        }
        #[cfg(target_arch = "aarch64")]
        match level.as_neon() {
            Some(s) => $f::<$wide<_>>(s, $($argument),*),
            None => $f::<$one>((), $($argument),*),
        }
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        {
            let _ = level;
            $f::<$one>((), $($argument),*)
        }
    }};
}
pub(crate) use dispatch;
