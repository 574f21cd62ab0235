//! Tests of the program as its users see it, on the command line and over HTTP: `cargo test --release --test service`.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod cli;
mod common;
mod documents;
mod first_hour;
mod http;
mod studio;
mod tasks;
mod tradeoff;
