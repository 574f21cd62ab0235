//! `strahl tree`: every ray behind one pixel.

use super::failure::Failure;
use super::output;
use super::scene_args::{SceneArgs, SettingsArgs};
use super::session::Session;
use super::values::{pixel, word};
use clap::Args;
use strahl::inspect::TreeFormat;
use strahl::inspect::tree::trace_pixel;
use strahl::scene::Scene;

/// `strahl tree`.
#[derive(Debug, Args)]
pub(super) struct TreeArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Column and row of the pixel, from 0 at the upper left.
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pixel: [u32; 2],
    /// How to show the tree.
    #[arg(long, default_value = "json", value_parser = word::<TreeFormat>())]
    format: TreeFormat,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Shows the tree.
pub(super) fn run(args: &TreeArgs) -> Result<(), Failure> {
    let session = Session::start(&args.scene, &args.settings)?;
    let scene = session.load()?.scene;
    let Scene { width, height, .. } = scene;
    let [x, y] = args.pixel;
    if x >= width || y >= height {
        let what = format!("--pixel {x},{y} does not lie inside the picture of {width} x {height} pixels");
        return Err(Failure::Usage(what));
    }
    let tree = session.workers.work(|| trace_pixel(&scene, x, y))?;
    match args.format {
        TreeFormat::Json => output::print(&output::pretty(&tree)?),
        format => output::print(tree.parts(format).collect::<String>().as_bytes()),
    }
}
