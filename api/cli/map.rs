//! `strahl map`: what is proved of each pixel, or the rays, time or depth of each, as a picture.

use super::failure::Failure;
use super::scene_args::{SceneArgs, SettingsArgs};
use super::session::Session;
use super::values::word;
use super::{output, progress};
use crate::service::pictures::map::{self, COARSEST, MapFormat};
use clap::Args;
use std::path::{Path, PathBuf};
use strahl::enum_names::choice;
use strahl::inspect::maps::MapKind;

/// `strahl map`.
#[derive(Debug, Args)]
pub(super) struct MapArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// What the map shows.
    #[arg(long, value_parser = word::<MapKind>())]
    of: MapKind,
    /// File to write: .png has colors and a scale, .pfm and .exr the numbers [default: the scene's name with -map.png].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Trace one pixel for each block of so many across and down.
    #[arg(long, value_name = "PIXELS", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=i64::from(COARSEST)))]
    step: u32,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Draws the map.
pub(super) fn run(args: &MapArgs) -> Result<(), Failure> {
    let file_name = output::file_of(args.output.as_deref(), &args.scene.scene, "-map.png");
    let format = format(&file_name)?;
    output::check_folder(&file_name)?;
    let mut session = Session::start(&args.scene, &args.settings)?;
    session.cancel_on_ctrl_c()?;
    let ready = session.prepare()?;
    session.file.inputs.check_outputs([file_name.as_path()])?;
    output::warn(&session.file.name, &ready.scene.warnings);
    let file = || map::draw(&ready.scene, args.step, args.of, format, &session.workers, &session.control);
    let file = progress::while_showing(&session.control, file)?;
    output::write(&file_name, &file)?;
    output::tell(args.output.as_deref(), &file_name);
    Ok(())
}

fn format(path: &Path) -> Result<MapFormat, Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    choice(&extension)
        .ok_or_else(|| Failure::Usage(format!("{} names no format of maps: use .png, .pfm or .exr", path.display())))
}
