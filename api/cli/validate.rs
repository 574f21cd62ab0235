//! `strahl validate`: all problems of a scene, without rendering it.

use super::failure::Failure;
use super::output;
use super::scene_args::SceneArgs;
use super::scene_file::SceneFile;
use clap::{Args, ValueEnum};
use serde_json::json;
use std::fmt::Write;
use strahl::scene::{Overrides, Problem};

/// `strahl validate`.
#[derive(Debug, Args)]
pub(super) struct ValidateArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// How to report.
    #[arg(long, default_value = "text")]
    format: ReportFormat,
}

/// Names of report formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ReportFormat {
    /// For people.
    Text,
    /// For programs.
    Json,
}

/// Validates.
pub(super) fn run(args: &ValidateArgs) -> Result<(), Failure> {
    let source = SceneFile::read(&args.scene)?;
    let checked = source.load(&Overrides::default());
    match args.format {
        ReportFormat::Text => output::print_text(&text(&source.name, &checked?.scene.warnings)),
        ReportFormat::Json => {
            let report = match &checked {
                Ok(loaded) => json!({ "valid": true, "warnings": loaded.scene.warnings }),
                Err(Failure::Scene { problems, .. }) => {
                    let (errors, more) = problems.reported();
                    json!({ "valid": false, "errors": errors, "more": more })
                }
                Err(_) => return checked.map(drop),
            };
            output::print(&output::pretty(&report)?)?;
            checked.map(drop)
        }
    }
}

fn text(name: &str, warnings: &[Problem]) -> String {
    let mut text = format!("{name} is valid\n");
    for warning in warnings {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "  warning: {warning}");
    }
    text
}
