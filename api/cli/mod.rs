//! The command line: one file for each command, with its flags and their help.

mod allocator;
mod assemble;
mod config;
mod config_file;
mod environment;
mod explain;
mod failure;
mod farm;
mod frame;
mod gallery;
mod healthcheck;
mod import;
mod interrupt;
mod key;
mod log;
mod map;
mod node;
mod openapi;
mod output;
mod places;
mod progress;
mod rays;
mod render;
mod scene_args;
mod scene_file;
mod scene_inputs;
mod schema;
mod sequence;
mod serve;
mod session;
mod tile;
mod tile_file;
mod tradeoff;
mod tree;
mod validate;
mod values;

use clap::{Parser, Subcommand};
use failure::Failure;
use std::process::ExitCode;

/// Renders JSON scenes with Whitted's ray tracing, and says what the picture cost.
#[derive(Debug, Parser)]
#[command(name = "strahl", version, max_term_width = 100, arg_required_else_help = true)]
#[command(after_help = "\
Examples:
  strahl render scene.json -o scene.png
  strahl render balls.nff.gz --width 1024 --height 1024 -o - --format png > balls.png
  strahl explain scene.json
  strahl serve --listen 127.0.0.1:8080

SCENE is a .json, .nff or .nff.gz file, a model (.glb, .gltf, .obj, .stl or .ply), or - for standard input.
Exit codes: 0 done, 1 bad input, 2 bad usage, 130 interrupted.")]
struct Cli {
    /// What to do.
    #[command(subcommand)]
    command: Command,
}

/// The commands of `strahl`.
#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene into a picture file.
    Render(render::RenderArgs),
    /// Find what single rays hit first: one JSON ray per line in, one JSON answer per line out.
    Rays(rays::RaysArgs),
    /// Show the tree of all rays of one pixel.
    Tree(tree::TreeArgs),
    /// Draw what is proved of each pixel, or how many rays, how much time or what depth each takes.
    Map(map::MapArgs),
    /// Show which effects a scene calls for, and why.
    Explain(explain::ExplainArgs),
    /// Measure the time and error of many settings, and write a page about them.
    Tradeoff(tradeoff::TradeoffArgs),
    /// Render many scenes into one page, each picture with its price and its bound.
    Gallery(gallery::GalleryArgs),
    /// Render one part of a picture, for a farm's manager.
    Tile(tile::TileArgs),
    /// Make a picture of the parts that `strahl tile` has rendered.
    Assemble(assemble::AssembleArgs),
    /// Render one frame of numbered scenes, for a farm's manager.
    Frame(frame::FrameArgs),
    /// Convert a model or a Neutral File Format file into scene JSON.
    Import(import::ImportArgs),
    /// Check a scene and report all its problems, without rendering it.
    Validate(validate::ValidateArgs),
    /// Print the JSON Schema of scenes.
    Schema,
    /// Print the service's contract as OpenAPI 3.1.
    Openapi,
    /// Make keys for the service.
    #[command(subcommand)]
    Key(key::KeyCommand),
    /// Check or show the configuration of the service.
    #[command(subcommand)]
    Config(config::ConfigCommand),
    /// What the operator of a farm needs.
    #[command(subcommand)]
    Farm(farm::FarmCommand),
    /// Serve renders over HTTP.
    Serve(Box<serve::ServeArgs>),
    /// Render for the services of a farm.
    Node(Box<node::NodeArgs>),
    /// Ask a running service whether it is alive; exit code 0 if it is.
    Healthcheck(healthcheck::HealthcheckArgs),
}

/// Reads the arguments, runs one command, and turns its failure into a message and an exit code.
pub(crate) fn main() -> ExitCode {
    let run = || run(Cli::parse_from(config_file::with_file(std::env::args_os().collect())?).command);
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.tell(),
    }
}

/// Runs a command.
fn run(command: Command) -> Result<(), Failure> {
    match command {
        Command::Render(args) => render::run(&args),
        Command::Rays(args) => rays::run(&args),
        Command::Tree(args) => tree::run(&args),
        Command::Map(args) => map::run(&args),
        Command::Explain(args) => explain::run(&args),
        Command::Tradeoff(args) => tradeoff::run(&args),
        Command::Gallery(args) => gallery::run(&args),
        Command::Tile(args) => tile::run(&args).map_err(Failure::of_task),
        Command::Assemble(args) => assemble::run(&args).map_err(Failure::of_task),
        Command::Frame(args) => frame::run(&args).map_err(Failure::of_task),
        Command::Import(args) => import::run(&args),
        Command::Validate(args) => validate::run(&args),
        Command::Schema => schema::run(),
        Command::Openapi => openapi::run(),
        Command::Config(command) => config::run(&command),
        Command::Key(command) => key::run(&command),
        Command::Farm(command) => farm::run(&command),
        Command::Serve(args) => serve::run(&args),
        Command::Node(args) => node::run(&args),
        Command::Healthcheck(args) => healthcheck::run(&args),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        Cli::command().debug_assert();
    }
}
