//! The `strahl` command: reads the arguments, runs one command, turns its failure into a message and an exit code.

mod blobs;
mod cli;
mod commands;
mod config;
mod data;
mod failure;
mod folder;
mod identity;
mod input;
mod jobs;
mod made;
mod map;
mod memory;
mod picture;
mod pieces;
mod rays;
mod ready;
mod recent;
mod report;
mod server;
mod tradeoff;
mod turns;
mod warnings;
mod workers;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let run = || commands::run(cli::Cli::parse_from(config::with_file(std::env::args_os().collect())?).command);
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.tell(),
    }
}
