//! `strahl import`: a Neutral File Format file into scene JSON.

use super::failure::Failure;
use super::output;
use super::scene_file;
use clap::Args;
use std::path::PathBuf;
use strahl::scene::nff::{NffOptions, read_nff};
use strahl::scene::problem::{Code, Problem, Problems};
use strahl::scene::recognise::{Recognised, recognise};

/// `strahl import`.
#[derive(Debug, Args)]
pub(super) struct ImportArgs {
    /// Neutral File Format file (.nff or .nff.gz), or - for standard input.
    file: String,
    /// Where the scene JSON goes.
    #[arg(short, long, value_name = "FILE.json", default_value = "-")]
    output: PathBuf,
    /// See opaque surfaces from behind, too.
    #[arg(long)]
    two_sided: bool,
    /// Follow the counting rules of the Standard Procedural Databases: 513 x 513 corner rays, depth 5.
    #[arg(long)]
    spd_counts: bool,
}

/// Imports.
pub(super) fn run(args: &ImportArgs) -> Result<(), Failure> {
    output::check_folder(&args.output)?;
    let (name, bytes) = scene_file::read(&args.file)?;
    if recognise(&bytes) == Recognised::Json {
        let what = "this is scene JSON already: there is nothing to import";
        let problem = Problem::new("", Code::OtherFormat, what);
        return Err(Failure::Scene { name, problems: Problems::one(problem) });
    }
    let options = NffOptions { two_sided: args.two_sided, spd_counts: args.spd_counts };
    let description = read_nff(&bytes, options).map_err(|problems| Failure::Scene { name, problems })?;
    output::write(&args.output, &output::pretty(&description)?)
}
