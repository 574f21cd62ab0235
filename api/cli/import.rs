//! `strahl import`: a model, or a Neutral File Format file, into scene JSON.

use super::failure::Failure;
use super::output;
use super::scene_args::{ModelArgs, SceneArgs};
use super::scene_file::SceneFile;
use super::values::word;
use clap::Args;
use std::path::PathBuf;
use strahl::scene::description::Fidelity;
use strahl::scene::nff::{NffOptions, read_nff};
use strahl::scene::problem::{Code, Problem, Problems};
use strahl::scene::recognise::{Recognised, recognise};
use strahl::scene::{Description, Format, Overrides, model};

/// `strahl import`.
#[derive(Debug, Args)]
pub(super) struct ImportArgs {
    #[command(flatten)]
    file: SceneArgs,
    /// Where the scene JSON goes.
    #[arg(short, long, value_name = "FILE.json", default_value = "-")]
    output: PathBuf,
    /// See opaque surfaces from behind, too (NFF only).
    #[arg(long)]
    two_sided: bool,
    /// Follow the counting rules of the Standard Procedural Databases: 513 x 513 corner rays, depth 5 (NFF only).
    #[arg(long)]
    spd_counts: bool,
    /// How light gets from everywhere to surfaces: fast, or faithful, by rays, with a soft key light [default: fast].
    #[arg(long, value_name = "FIDELITY", value_parser = word::<Fidelity>(), hide_possible_values = true)]
    fidelity: Option<Fidelity>,
    #[command(flatten)]
    model: ModelArgs,
}

/// Imports.
pub(super) fn run(args: &ImportArgs) -> Result<(), Failure> {
    output::check_folder(&args.output)?;
    let file = SceneFile::read(&args.file)?;
    let description = read(args, &file).map_err(|problems| Failure::Scene { name: file.name.clone(), problems })?;
    output::write(&args.output, &output::pretty(&description)?)
}

fn read(args: &ImportArgs, file: &SceneFile) -> Result<Description, Problems> {
    let overrides = Overrides { model: args.model.options(), fidelity: args.fidelity, ..Overrides::default() };
    let mut imported = match file.format.model().or_else(|| file.hidden_model()) {
        Some(kind) => model::import(kind, &file.bytes, &overrides, file.files())?,
        None if file.format == Format::Parts => model::import_parts(&file.bytes, &overrides)?,
        None if file.format == Format::Nff && recognise(&file.bytes) != Recognised::Json => {
            return read_nff(&file.bytes, NffOptions { two_sided: args.two_sided, spd_counts: args.spd_counts });
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
