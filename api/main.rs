//! The `strahl` command: reads the arguments, runs one command, turns its failure into a message and an exit code.

mod blobs;
mod cli;
mod commands;
mod data;
mod failure;
mod folder;
mod identity;
mod input;
mod jobs;
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
mod workers;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    match commands::run(cli::Cli::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.tell(),
    }
}
