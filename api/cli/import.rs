//! `strahl import`: a Neutral File Format file into scene JSON.

use super::ImportArgs;
use super::failure::Failure;
use super::output;
use super::scene_file;
use strahl::scene::import::nff::{NffOptions, read_nff};

/// Imports.
pub(super) fn run(args: &ImportArgs) -> Result<(), Failure> {
    output::check_folder(&args.output)?;
    let (name, bytes) = scene_file::read(&args.file)?;
    let options = NffOptions { two_sided: args.two_sided, spd_counts: args.spd_counts };
    let description = read_nff(&bytes, options).map_err(|problems| Failure::Scene { name, problems })?;
    output::write(&args.output, &output::pretty(&description)?)
}
