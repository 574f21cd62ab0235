//! The `strahl` command.

mod cli;
mod http;
mod service;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
