//! `strahl map`: what is proved of each pixel, or what each of them takes, as a picture.

use super::failure::Failure;
use super::scene_args::{SceneArgs, SettingsArgs};
use super::session::Session;
use super::values::word;
use super::{output, progress};
use crate::service::pictures::map::{self, MapFormat};
use clap::Args;
use std::path::{Path, PathBuf};
use strahl::film::Region;
use strahl::inspect::maps::MapKind;
use strahl::words::choice;

/// `strahl map`.
#[derive(Debug, Args)]
pub(super) struct MapArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// What the map shows.
    #[arg(long, value_parser = word::<MapKind>())]
    of: MapKind,
    /// File to write: .png has colors and a scale, .pfm and .exr the numbers.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Draws the map.
pub(super) fn run(args: &MapArgs) -> Result<(), Failure> {
    let format = format(&args.output)?;
    output::check_folder(&args.output)?;
    let session = Session::start(&args.scene, &args.settings)?;
    session.cancel_on_ctrl_c()?;
    let ready = session.prepare()?;
    let region = Region::whole(ready.scene.width, ready.scene.height);
    let file = || map::draw(&ready.scene, region, args.of, format, &session.workers, &session.control);
    let file = progress::while_showing(&session.control, file)?;
    output::write(&args.output, &file)
}

fn format(path: &Path) -> Result<MapFormat, Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    choice(&extension)
        .ok_or_else(|| Failure::Usage(format!("{} names no format of maps: use .png, .pfm or .exr", path.display())))
}
