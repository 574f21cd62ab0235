//! The command line: every command, every flag, and their help.

mod keys;
mod scenes;
mod serve;
mod settings;
mod values;

pub(crate) use keys::{KeyCommand, NewKeyArgs};
pub(crate) use scenes::*;
pub(crate) use serve::{ConfigCommand, HealthcheckArgs, LogFormat, ServeArgs};
pub(crate) use settings::SceneArgs;
pub(crate) use values::{ACCURACY, accuracy, precision, quality, weight};

use clap::{Parser, Subcommand};

/// Renders JSON scenes with Whitted's ray tracing, and says what the picture cost.
#[derive(Debug, Parser)]
#[command(name = "strahl", version, max_term_width = 100, arg_required_else_help = true)]
#[command(after_help = "\
Examples:
  strahl render scene.json -o scene.png
  strahl render balls.nff.gz --width 1024 --height 1024 -o - --format png > balls.png
  strahl explain scene.json
  strahl serve --listen 127.0.0.1:8080

SCENE is a .json, .nff or .nff.gz file, or - for standard input.
Exit codes: 0 done, 1 bad input, 2 bad usage, 130 interrupted.")]
pub(crate) struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// Everything `strahl` can do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene into a picture file.
    Render(RenderArgs),
    /// Follow single rays to their first hit: one JSON ray per line in, one JSON answer per line out.
    Rays(RaysArgs),
    /// Show the tree of rays behind one pixel.
    Tree(TreeArgs),
    /// Draw what is proved of each pixel, or what each of them takes.
    Map(MapArgs),
    /// Show which effects a scene calls for, and why.
    Explain(ExplainArgs),
    /// Measure what accuracy costs in time: many settings, their errors and times, on one page.
    Tradeoff(TradeoffArgs),
    /// Turn a Neutral File Format file into scene JSON.
    Import(ImportArgs),
    /// Check a scene and report all its problems, without rendering it.
    Validate(ValidateArgs),
    /// Print the JSON Schema of scenes.
    Schema,
    /// Print the service's contract as OpenAPI 3.1.
    Openapi,
    /// Make keys for the service.
    #[command(subcommand)]
    Key(KeyCommand),
    /// Check or show the configuration of the service.
    #[command(subcommand)]
    Config(ConfigCommand),
    /// Serve renders over HTTP.
    Serve(Box<ServeArgs>),
    /// Ask a running service whether it is alive; exit code 0 if it is.
    Healthcheck(HealthcheckArgs),
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
