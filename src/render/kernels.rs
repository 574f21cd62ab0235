//! The instances of the kernel: each variant for each format and instruction set.
//!
//! Each instance is a function of its own, and each format and instruction set is a module of its own: the compiler takes
//! time that is quadratic in the size of a function, and compiles one module on one core. Below AVX2 one lane does for all
//! variants: sixteen lanes in the registers of SSE2 were half of all machine code, for processors before 2013.

use super::packets::{KernelFormat, TraceJob, Traced, trace_with};
use crate::lanes::Lanes;
use crate::scene::world::World;
use crate::shading::media::Medium;
use crate::trace::pixel::{Samples, eye_media};
use crate::trace::variants::{Filtered, General, KernelVariant, Local, Variant, Whitted};
use fearless_simd::{Level, f32x16, f64x8};

/// A module for one format and instruction set. Its `trace` takes the instance for the job's variant, or the general one.
macro_rules! instances {
    ($module:ident, $real:ty, $lanes:ty, $($variant:ident)*) => {
        pub(super) mod $module {
            use super::super::*;

            type Simd = <$lanes as Lanes>::Simd;

            pub(in super::super) fn trace(
                s: Simd,
                job: &TraceJob<'_, $real>,
                at: &[[u32; 2]],
                samples: Samples,
                out: &mut Traced,
            ) {
                match job.kernel {
                    $(KernelVariant::$variant => run::<$variant>(s, job, at, samples, out),)*
                    _ => run::<General>(s, job, at, samples, out),
                }
            }

            #[inline(never)]
            fn run<V: Variant>(s: Simd, job: &TraceJob<'_, $real>, at: &[[u32; 2]], samples: Samples, out: &mut Traced) {
                <$lanes as Lanes>::vectorize(
                    s,
                    #[inline(always)]
                    || trace_with::<$lanes, V>(s, job, at, samples, out),
                );
            }
        }
    };
}

macro_rules! format {
    ($format:ident, $real:ident, $lanes:ident) => {
        mod $format {
            #[cfg(target_arch = "x86_64")]
            instances!(avx512, $real, $lanes<fearless_simd::x86::Avx512>, Local Whitted Filtered);
            #[cfg(target_arch = "x86_64")]
            instances!(avx2, $real, $lanes<fearless_simd::x86::Avx2>, Local Whitted Filtered);
            #[cfg(target_arch = "aarch64")]
            instances!(neon, $real, $lanes<fearless_simd::aarch64::Neon>, Local Whitted Filtered);
            instances!(one_lane, $real, $real,);
        }

        impl KernelFormat for $real {
            fn trace(level: Level, job: &TraceJob<'_, Self>, at: &[[u32; 2]], samples: Samples, out: &mut Traced) {
                let _entered = job.control.enter();
                #[cfg(target_arch = "x86_64")]
                if let Some(s) = level.as_avx512() {
                    return $format::avx512::trace(s, job, at, samples, out);
                } else if let Some(s) = level.as_avx2() {
                    return $format::avx2::trace(s, job, at, samples, out);
                }
                #[cfg(target_arch = "aarch64")]
                if let Some(s) = level.as_neon() {
                    return $format::neon::trace(s, job, at, samples, out);
                }
                let _ = level;
                $format::one_lane::trace((), job, at, samples, out);
            }
            fn eye_media(world: &World<Self>) -> Vec<Medium<Self>> {
                eye_media::<Self>((), world)
            }
        }
    };
}

format!(single, f32, f32x16);
format!(double, f64, f64x8);
