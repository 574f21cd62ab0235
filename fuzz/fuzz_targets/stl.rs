#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| strahl_fuzz::run("stl", bytes));
