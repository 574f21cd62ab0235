//! The program as a library, for `cargo fuzz`: its modules, and the targets that call them.
#![allow(dead_code, unused_imports, reason = "the program has no library of its own, and a target uses parts of it")]

#[path = "../../api/http/mod.rs"]
mod http;
#[path = "../../api/service/mod.rs"]
mod service;
mod targets;

/// Gives bytes to a target.
pub fn run(target: &str, bytes: &[u8]) {
    let (_, run) = targets::TARGETS.iter().find(|(name, _)| *name == target).expect("a target");
    run(bytes);
}
