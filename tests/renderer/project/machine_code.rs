//! No operation over lanes has become a call: a function that is not inlined into its kernel is compiled for the baseline
//! instruction set, is 3 to 19 times slower, and gives correct results, so that nothing else would notice.

/// What `fearless_simd` calls the body of each operation; it is a function of its own only where inlining failed.
const OPERATION: &[u8] = b"__fearless_simd_kernel";
/// What the kernels themselves are called.
const KERNEL: &[u8] = b"vectorize_avx";

fn contains(bytes: &[u8], name: &[u8]) -> bool {
    bytes.windows(name.len()).any(|window| window == name)
}

#[test]
#[cfg_attr(any(debug_assertions, not(target_arch = "x86_64")), ignore = "kernels are optimised in release only")]
fn every_operation_over_lanes_is_part_of_its_kernel() {
    let program = std::fs::read(env!("CARGO_BIN_EXE_strahl")).unwrap();
    assert!(contains(&program, KERNEL), "the program has lost its symbols, so this test sees nothing");
    assert!(
        !contains(&program, OPERATION),
        "some function or closure over lanes lacks #[inline(always)]; `nm -C target/release/strahl | grep \
         __fearless_simd_kernel` says which operations it calls, `objdump -d` from where"
    );
}
