//! The same targets without a fuzzer: seeds, and a fixed number of changes of them.
//!
//! `FUZZ_CASES=1000000 cargo test --release --bin strahl fuzz` tries more of them.

use super::TARGETS;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::{env, fs};

/// Numbers that programs count wrongly around.
const NUMBERS: [&str; 14] = [
    "0",
    "-1",
    "1e999",
    "-0",
    "1e-320",
    "0.5",
    "255",
    "256",
    "4294967295",
    "4294967296",
    "18446744073709551616",
    "9007199254740993",
    "NaN",
    "1e15",
];

/// SplitMix64: the same numbers everywhere.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below another, which is not 0.
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    /// Where words begin and end, which is where mistakes are made, and any other place now and then.
    fn place(&mut self, bytes: &[u8]) -> usize {
        let at = self.below(bytes.len() + 1);
        if self.below(8) == 0 {
            return at;
        }
        let is_word = |byte: &u8| byte.is_ascii_alphanumeric();
        let border = |i: &usize| *i == 0 || is_word(&bytes[*i - 1]) != bytes.get(*i).is_some_and(is_word);
        (at..=bytes.len()).find(border).unwrap_or(at)
    }

    /// Something between two places.
    fn range(&mut self, bytes: &[u8]) -> std::ops::Range<usize> {
        let [a, b] = [(); 2].map(|()| self.place(bytes));
        a.min(b)..a.max(b)
    }

    /// One change, for which another seed may lend something.
    fn change(&mut self, bytes: &mut Vec<u8>, other: &[u8]) {
        let at = self.place(bytes);
        let word =
            at + bytes[at..].iter().take_while(|byte| byte.is_ascii_alphanumeric() || b"._-+".contains(byte)).count();
        match self.below(7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << self.below(8),
            1 => drop(bytes.drain(self.range(bytes))),
            2 => {
                let copy = bytes[self.range(bytes)].to_vec();
                bytes.splice(at..at, copy);
            }
            3 => drop(bytes.splice(at..word, NUMBERS[self.below(NUMBERS.len())].bytes())),
            4 => drop(bytes.splice(at..word, other[self.range(other)].iter().copied())),
            5 => bytes.insert(at, self.next() as u8),
            _ => {
                // A word in the place of another.
                let from = self.place(bytes);
                let copy: Vec<_> = bytes[from..].iter().copied().take_while(u8::is_ascii_alphanumeric).collect();
                bytes.splice(at..word, copy);
            }
        }
    }
}

/// The seeds of a target, small ones, in an order that is the same everywhere.
fn seeds(target: &str) -> Vec<Vec<u8>> {
    let others = match target {
        "scene" => Some("scenes"),
        "nff" => Some("tests/inputs/nff"),
        _ => None,
    };
    let mut files = files(Path::new(&format!("fuzz/seeds/{target}")));
    files.extend(others.into_iter().flat_map(|folder| self::files(Path::new(folder))));
    files.sort();
    files.iter().map(|file| fs::read(file).unwrap()).filter(|bytes| bytes.len() < 4_000).collect()
}

/// All files in a folder of the repository.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)).unwrap();
    let inside = |path: PathBuf| if path.is_dir() { files(&path) } else { vec![path] };
    entries.flat_map(|entry| inside(entry.unwrap().path())).collect()
}

/// Tries all seeds, and so many changes of them.
fn try_all(target: &str, cases: usize) {
    let (_, run) = TARGETS.iter().find(|(name, _)| *name == target).unwrap();
    let cases = env::var("FUZZ_CASES").map_or(cases, |cases| cases.parse().unwrap());
    let seeds = seeds(target);
    let mut chance = Chance(0);
    for case in 0..seeds.len() + cases {
        let mut bytes = seeds[case % seeds.len()].clone();
        if case >= seeds.len() {
            for _ in 0..=chance.below(4) {
                let other = &seeds[chance.below(seeds.len())];
                chance.change(&mut bytes, other);
            }
        }
        let passed = catch_unwind(AssertUnwindSafe(|| run(&bytes)));
        assert!(passed.is_ok(), "case {case} of {target} fails: b\"{}\"", bytes.escape_ascii());
    }
}

#[test]
fn any_scene_is_refused_or_rendered() {
    try_all("scene", 50_000);
}

#[test]
fn any_nff_is_refused_or_rendered() {
    try_all("nff", 20_000);
}

#[test]
fn any_sequence_is_refused_or_rendered() {
    try_all("sequence", 20_000);
}

#[test]
fn any_model_is_refused_or_rendered() {
    for format in ["gltf", "obj", "stl", "ply", "parts"] {
        try_all(format, 2_000);
    }
}

#[test]
fn any_accept_header_has_an_answer() {
    try_all("accept", 20_000);
}

#[test]
fn any_iiif_path_has_an_answer_and_its_canonical_address_has_the_same() {
    try_all("iiif", 50_000);
}

#[test]
fn any_event_id_has_an_answer() {
    try_all("events", 20_000);
}

#[test]
fn any_key_file_is_understood_or_refused() {
    try_all("keys", 50_000);
}

#[test]
fn no_folder_gives_a_wrong_picture() {
    try_all("data", 150);
}

/// A program is built of the same parts by `cargo fuzz`.
#[test]
fn fuzzers_have_the_dependencies_of_the_program() {
    let manifest = |path: &str| fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap();
    let program = manifest("Cargo.toml");
    let (_, dependencies) = program.split_once("[dependencies]\n").unwrap();
    let (dependencies, _) = dependencies.split_once("\n[").unwrap();
    assert!(manifest("fuzz/Cargo.toml").contains(dependencies), "copy [dependencies] into fuzz/Cargo.toml");
}
