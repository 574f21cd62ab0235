//! What must hold for machine code, since nothing else would notice it.
//!
//! - No operation over lanes has become a call. A function that is not inlined into its kernel is compiled for the baseline
//!   instruction set, is 3 to 19 times slower, and gives correct results.
//! - No function is huge. The compiler's time for one grows with the square of its size: six kernels in one function of a
//!   megabyte once took 10 minutes and 4.5 GB.

use std::path::Path;

/// What `fearless_simd` calls the body of each operation; it is a function of its own only where inlining failed.
const OPERATION: &str = "__fearless_simd_kernel";
/// What the kernels themselves are called.
const KERNEL: &str = "vectorize_avx";
/// What this test program calls its own functions.
const OWN: &str = "8renderer";
/// Bytes that a function may have: compiling takes time that is quadratic in them.
const LARGEST: usize = 60_000;
/// Incremental builds inline a little more.
const LARGEST_INCREMENTAL: usize = 64 << 10;

struct Function {
    /// As the linker knows it.
    name: String,
    /// Bytes of machine code.
    bytes: usize,
}

/// The functions in the symbol table of a program: a little-endian ELF file of 64 bits.
fn functions(program: &Path) -> Vec<Function> {
    struct Section {
        kind: usize,
        offset: usize,
        bytes: usize,
        link: usize,
    }
    let file = std::fs::read(program).unwrap();
    assert_eq!(file[..6], *b"\x7fELF\x02\x01", "{} is no ELF file of this kind", program.display());
    let number =
        |at: usize, bytes: usize| file[at..at + bytes].iter().rev().fold(0, |n, byte| n << 8 | usize::from(*byte));
    let headers = number(0x28, 8);
    let section = |index: usize| {
        let at = headers + 64 * index;
        Section {
            kind: number(at + 4, 4),
            offset: number(at + 24, 8),
            bytes: number(at + 32, 8),
            link: number(at + 40, 4),
        }
    };
    const SYMBOLS: usize = 2;
    let symbols = (0..number(0x3c, 2)).map(section).find(|section| section.kind == SYMBOLS);
    let symbols = symbols.unwrap_or_else(|| panic!("{} has lost its symbols", program.display()));
    let names = section(symbols.link).offset;
    const FUNCTION: usize = 2;
    (symbols.offset..symbols.offset + symbols.bytes)
        .step_by(24)
        .filter(|at| number(at + 4, 1) & 15 == FUNCTION)
        .map(|at| {
            let name = &file[names + number(at, 4)..];
            let end = name.iter().position(|byte| *byte == 0).unwrap();
            Function { name: String::from_utf8_lossy(&name[..end]).into_owned(), bytes: number(at + 16, 8) }
        })
        .collect()
}

#[test]
#[cfg_attr(
    any(debug_assertions, not(all(target_arch = "x86_64", target_os = "linux"))),
    ignore = "reads optimised ELF"
)]
fn every_operation_over_lanes_is_part_of_its_kernel() {
    let functions = functions(Path::new(env!("CARGO_BIN_EXE_strahl")));
    assert!(functions.iter().any(|f| f.name.contains(KERNEL)), "there is no kernel, so this test sees nothing");
    let called: Vec<&str> = functions.iter().map(|f| f.name.as_str()).filter(|name| name.contains(OPERATION)).collect();
    assert!(
        called.is_empty(),
        "some function or closure over lanes lacks #[inline(always)]; `objdump -dC target/release/strahl` says which ones \
         call these:\n{}",
        called.join("\n")
    );
}

/// All functions of the library are in this test program. Its own may be without optimisation.
#[test]
#[cfg_attr(
    any(debug_assertions, not(all(target_arch = "x86_64", target_os = "linux"))),
    ignore = "reads optimised ELF"
)]
fn no_function_is_so_large_that_compiling_it_takes_minutes() {
    let mut functions = functions(&std::env::current_exe().unwrap());
    assert!(functions.iter().any(|f| f.name.contains(KERNEL)), "there is no kernel, so this test sees nothing");
    let incremental = std::env::var("CARGO_INCREMENTAL").is_ok_and(|value| value != "0");
    let largest = if incremental { LARGEST_INCREMENTAL } else { LARGEST };
    functions.retain(|f| f.bytes > largest && !f.name.contains(OWN));
    functions.sort_by_key(|f| std::cmp::Reverse(f.bytes));
    let list: Vec<String> = functions.iter().map(|f| format!("{:>8} bytes: {}", f.bytes, f.name)).collect();
    assert!(
        list.is_empty(),
        "larger than {largest} bytes; move rare parts into functions of their own:\n{}",
        list.join("\n")
    );
}

/// Functions of the platform's libm whose last bits differ between platforms. The four that crates for picture files take.
const OF_PICTURE_FILES: [&str; 4] = ["cosf", "logf", "pow", "powf"];

#[test]
#[cfg_attr(not(all(target_arch = "x86_64", target_os = "linux")), ignore = "reads ELF")]
fn no_pixel_depends_on_the_platforms_functions() {
    let inexact: Vec<String> = [
        "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "cos", "cosh", "exp", "exp10", "exp2",
        "expm1", "hypot", "lgamma", "log", "log10", "log1p", "log2", "pow", "sin", "sincos", "sinh", "tan", "tanh",
        "tgamma", // And what rounds once where all else rounds twice.
        "fma",
    ]
    .iter()
    .flat_map(|name| ["", "f"].map(|kind| format!("{name}{kind}")))
    .collect();
    let functions = functions(Path::new(env!("CARGO_BIN_EXE_strahl")));
    let plain = |function: &Function| function.name.split('@').next().unwrap_or_default().to_owned();
    let called: Vec<String> = functions.iter().map(plain).filter(|name| inexact.contains(name)).collect();
    assert!(called.iter().any(|name| name == "powf"), "crates for picture files call it; this test sees nothing");
    let ours: Vec<&String> = called.iter().filter(|name| !OF_PICTURE_FILES.contains(&name.as_str())).collect();
    assert!(ours.is_empty(), "use `math` instead of the platform's {ours:?}");
}
