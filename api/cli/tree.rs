//! `strahl tree`: every ray behind one pixel, as data, as a drawing, or drawn into the picture.

use super::failure::Failure;
use super::output;
use super::scene_args::{SceneArgs, SettingsArgs};
use super::session::Session;
use super::values::{pixel, word};
use crate::service::pictures::overlay::{self, OverlaySpec};
use crate::service::values::point;
use clap::{ArgAction, Args};
use strahl::inspect::TreeFormat;
use strahl::inspect::tree::trace_pixel_while;
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
    /// Draw the rays into the picture: the same as --format overlay.
    #[arg(long, conflicts_with = "format")]
    overlay: bool,
    /// Eye of another camera that sees the overlay's rays, with an angle of view of 45 degrees.
    #[arg(long, value_name = "X,Y,Z", value_parser = point, requires = "to", allow_hyphen_values = true)]
    from: Option<[f64; 3]>,
    /// What that camera looks at.
    #[arg(long, value_name = "X,Y,Z", value_parser = point, requires = "from", allow_hyphen_values = true)]
    to: Option<[f64; 3]>,
    /// Whether an overlay has the rendered picture: true or false.
    #[arg(long, value_name = "BOOL", action = ArgAction::Set, default_value_t = true)]
    picture: bool,
    /// Draw the rays of all samples, not of the first one alone.
    #[arg(long)]
    all_samples: bool,
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
    let format = if args.overlay { TreeFormat::Overlay } else { args.format };
    let seen_from = args.from.zip(args.to).map(<[_; 2]>::from);
    if format != TreeFormat::Overlay && (seen_from.is_some() || !args.picture) {
        return Err(Failure::Usage("--from, --to and --picture are for --overlay".to_owned()));
    }
    output::warn(&session.file.name, &scene.warnings);
    session.cancel_on_ctrl_c()?;
    let tree = session.workers.work(|| trace_pixel_while(&scene, x, y, &session.control))??;
    match format {
        TreeFormat::Json => output::print(&output::pretty(&tree)?),
        TreeFormat::Overlay => {
            let other = seen_from.map(|view| session.load_seen_from(view)).transpose()?;
            let other = other.as_ref().map(|loaded| &loaded.scene);
            let spec = OverlaySpec { seen_from, picture: args.picture, all_samples: args.all_samples };
            output::print(overlay::draw(tree, &scene, other, spec, &session.workers, &session.control)?.as_bytes())
        }
        format => output::print(tree.parts(format, args.all_samples).collect::<String>().as_bytes()),
    }
}
