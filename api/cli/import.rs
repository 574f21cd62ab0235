//! `strahl import`: a model, or a Neutral File Format file, into scene JSON.

use super::failure::Failure;
use super::output;
use super::scene_args::{OverrideArgs, SceneArgs};
use super::scene_file::SceneFile;
use clap::Args;
use std::path::PathBuf;
use strahl::scene::nff::read_nff;
use strahl::scene::problem::{Code, Problem, Problems};
use strahl::scene::recognise::{Recognised, recognise};
use strahl::scene::{Description, Format, model};

/// `strahl import`.
#[derive(Debug, Args)]
pub(super) struct ImportArgs {
    #[command(flatten)]
    file: SceneArgs,
    /// Where the scene JSON goes.
    #[arg(short, long, value_name = "FILE.json", default_value = "-")]
    output: PathBuf,
    #[command(flatten)]
    settings: OverrideArgs,
}

/// Imports.
pub(super) fn run(args: &ImportArgs) -> Result<(), Failure> {
    output::check_folder(&args.output)?;
    let file = SceneFile::read(&args.file)?;
    let description = read(args, &file).map_err(|problems| Failure::Scene { name: file.name.clone(), problems })?;
    file.inputs.check_outputs([args.output.as_path()])?;
    output::write(&args.output, &output::pretty(&description)?)
}

fn read(args: &ImportArgs, file: &SceneFile) -> Result<Description, Problems> {
    let overrides = args.settings.overrides();
    let mut imported = match file.format.model().or_else(|| file.hidden_model()) {
        Some(kind) => model::import(kind, &file.bytes, &overrides, &file.inputs)?,
        None if file.format == Format::Parts => model::import_parts(&file.bytes, &overrides, &file.inputs)?,
        None if file.format == Format::Nff && recognise(&file.bytes) != Recognised::Json => {
            let mut description = read_nff(&file.bytes, overrides.nff)?;
            overrides.apply(&mut description);
            return Ok(description);
        }
        None => {
            if let Some(problem) = recognise(&file.bytes).refused_as(Format::Json) {
                return Err(Problems::one(problem));
            }
            let what = "this is scene JSON already: there is nothing to import";
            return Err(Problems::one(Problem::new("", Code::OtherFormat, what)));
        }
    };
    overrides.apply(&mut imported.description);
    let fidelity = imported.description.render.fidelity;
    for warning in imported.description.import_warnings.iter().filter(|warning| warning.holds_for(fidelity)) {
        output::say(&format!("warning: {}: {}", file.name, warning.detail));
    }
    Ok(imported.description)
}
