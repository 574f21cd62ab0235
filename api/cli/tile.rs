//! `strahl tile`: one part of a scene's picture, for managers of farms that run one command many times. `strahl assemble` makes
//! the picture of all parts.

use super::failure::Failure;
use super::places::{Places, StoreArgs, numbered};
use super::scene_args::{SceneArgs, SettingsArgs};
use super::session::Session;
use super::tile_file::{Cut, TileFile};
use super::{output, progress};
use clap::Args;
use std::path::Path;
use strahl::render::render;
use strahl::tradeoff::duration;

/// What is told of exit codes in the help of commands for managers.
pub(super) const EXIT_CODES: &str = "\
Exit codes: 0 done; to be given up: 2 bad usage, 65 bad scene or tile, 66 no such input, 73 the output cannot be written; to be
tried again: 75 the store or the disk does not answer, 130 interrupted, 137 and 143 killed.";

/// `strahl tile`.
#[derive(Debug, Args)]
#[command(after_help = format!("\
Examples:
  strahl tile shot.json --of 16 --index 3 -o tiles/shot.{{index}}.tile
  strahl tile store:shot.json --of 4x4 -o store:tiles/{{index}}.tile --store s3://farm/renders   in a Kubernetes Indexed Job
  strahl assemble shot.json tiles/shot.{{index}}.tile --of 16 -o shot.png

{EXIT_CODES}"))]
pub(super) struct TileArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Parts of the picture: 16 bands, or columns and rows as 4x4.
    #[arg(long, value_name = "PARTS")]
    of: Cut,
    /// Which part.
    #[arg(long, env = "JOB_COMPLETION_INDEX", value_name = "NUMBER")]
    index: u32,
    /// Number of the first part: 1 for managers that count from 1.
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    first: u32,
    /// File of the part, or store:NAME. {index} in it is the number of the part.
    #[arg(short, long, value_name = "FILE")]
    output: String,
    #[command(flatten)]
    store: StoreArgs,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Renders the part.
pub(super) fn run(args: &TileArgs) -> Result<(), Failure> {
    let part = args.of.part(args.index, args.first)?;
    let to = numbered(&args.output, "index", args.index, 1);
    let places = Places::open(&args.store, [args.scene.scene.as_str(), &to])?;
    let mut session = Session::start_at(&args.scene, &args.settings, &places)?;
    session.cancel_on_ctrl_c()?;
    session.file.inputs.hash_contents();
    let ready = session.prepare_with_id()?;
    output::warn(&session.file.name, &ready.scene.warnings);
    session.file.inputs.check_outputs([Path::new(&to)])?;
    let tile = TileFile::of(&ready, &session.file.inputs, args.of)?;
    let region = args.of.region(part, [ready.scene.width, ready.scene.height])?;
    let trace = || session.workers.work(|| render(&ready.scene, region, &session.control));
    let picture = progress::while_showing(&session.control, trace)??;
    let (rays, ms) = (picture.rays.total(), picture.trace_ms);
    places.write(&to, tile.write(part, picture)?)?;
    output::say(&format!(
        "wrote {to}: part {} of {}, {} x {} pixels, {rays} rays, {}",
        args.index,
        args.of,
        region.width,
        region.height,
        duration(ms)
    ));
    Ok(())
}
