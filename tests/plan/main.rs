//! The plan: what `strahl explain` says is true of the picture.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail loudly and say what it measured")]

#[path = "../common/mod.rs"]
mod common;
mod depth;
mod estimates;
