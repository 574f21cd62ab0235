//! The `strahl` command: reads the arguments, runs one command, turns its failure into a message and an exit code.

mod cli;
mod commands;
mod config;
mod failure;
mod http;
mod input;
mod service;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let run = || commands::run(cli::Cli::parse_from(config::with_file(std::env::args_os().collect())?).command);
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.tell(),
    }
}
