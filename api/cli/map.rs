//! `strahl map`: what is proved of each pixel, or what each of them takes, as a picture.

use super::MapArgs;
use super::failure::Failure;
use super::scene_file::Source;
use super::workers::start_workers;
use super::{interrupt, output, progress};
use crate::service::pictures::map;
use crate::service::pictures::map::MapFormat;
use crate::service::scenes::prepared::Ready;
use std::path::Path;
use std::sync::Arc;
use strahl::film::Region;
use strahl::render::Control;

/// Draws the map.
pub(super) fn run(args: &MapArgs) -> Result<(), Failure> {
    let format = format(&args.output)?;
    output::check_folder(&args.output)?;
    let control = Arc::new(Control::default());
    let workers = start_workers(args.settings.threads, &control)?;
    interrupt::cancel_on_ctrl_c(&control)?;
    let source = Source::read(&args.scene)?;
    let ready = workers.work(|| source.load(&args.settings.overrides()).map(Ready::from))??;
    let region = Region::whole(ready.scene.width, ready.scene.height);
    let file = || map::draw(&ready.scene, region, args.of.into(), format, &workers, &control);
    let file = progress::while_showing(&control, file)?;
    output::write(&args.output, &file)
}

fn format(path: &Path) -> Result<MapFormat, Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let named = MapFormat::ALL.into_iter().find(|(name, _)| *name == extension);
    named
        .map(|(_, format)| format)
        .ok_or_else(|| Failure::Usage(format!("{} names no format of maps: use .png, .pfm or .exr", path.display())))
}
