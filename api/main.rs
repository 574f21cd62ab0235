//! The `strahl` command.

mod cli;
#[cfg(test)]
#[path = "../fuzz/src/targets/mod.rs"]
mod fuzz;
mod http;
mod service;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
