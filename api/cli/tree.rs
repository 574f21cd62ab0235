//! `strahl tree`: every ray behind one pixel.

use super::failure::Failure;
use super::output;
use super::scene_file::Source;
use super::workers::start_workers;
use super::{TreeArgs, TreeFormat};
use std::sync::Arc;
use strahl::inspect::tree::trace_pixel;
use strahl::scene::Scene;

/// Shows the tree.
pub(super) fn run(args: &TreeArgs) -> Result<(), Failure> {
    let workers = start_workers(args.settings.threads, &Arc::default())?;
    let source = Source::read(&args.scene)?;
    let loaded = workers.work(|| source.load(&args.settings.overrides()))??;
    let Scene { width, height, .. } = loaded.scene;
    let [x, y] = args.pixel;
    if x >= width || y >= height {
        let what = format!("--pixel {x},{y} does not lie inside the picture of {width} x {height} pixels");
        return Err(Failure::Usage(what));
    }
    let tree = workers.work(|| trace_pixel(&loaded.scene, x, y))?;
    match args.format {
        TreeFormat::Json => output::print(&output::pretty(&tree)?),
        TreeFormat::Dot => output::print(tree.to_dot().as_bytes()),
        TreeFormat::Svg => output::print(tree.to_svg().as_bytes()),
    }
}
