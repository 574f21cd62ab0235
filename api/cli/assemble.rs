//! `strahl assemble`: the picture of a scene out of the parts that `strahl tile` has rendered, to the bytes that `strahl render`
//! writes.

use super::failure::Failure;
use super::output;
use super::places::{Places, StoreArgs, numbered};
use super::scene_args::{SceneArgs, SettingsArgs};
use super::session::Session;
use super::tile::EXIT_CODES;
use super::tile_file::{Cut, TileFile};
use crate::service::clock::milliseconds;
use crate::service::pictures::assembly::{empty, join};
use crate::service::pictures::render::note;
use crate::service::pictures::report::{Cost, ErrorBounds, Phases, Replay, Report};
use clap::Args;
use std::path::Path;
use std::time::Instant;
use strahl::film::{Codes, FileFormat, PictureFormat, Region};

/// Bytes of a pixel in the file of a part, at most.
const PIXEL_BYTES: u64 = 36;
/// Bytes of such a file beside its pixels.
const FILE_BYTES: u64 = 64 << 10;

/// `strahl assemble`.
#[derive(Debug, Args)]
#[command(after_help = format!("\
Example: strahl assemble shot.json tiles/shot.{{index}}.tile --of 16 -o shot.png

Give the scene and the settings that the parts were rendered with.
{EXIT_CODES}"))]
pub(super) struct AssembleArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Files of the parts, or store:NAME; {index} is the number of a part.
    tiles: String,
    /// Parts of the picture, as for `strahl tile`.
    #[arg(long, value_name = "PARTS")]
    of: Cut,
    /// Number of the first part.
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    first: u32,
    /// Picture file, or store:NAME: .png, .jpg, .webp, .exr or .pfm.
    #[arg(short, long, value_name = "FILE")]
    output: String,
    /// Write the cost report of all parts as JSON: a file, or store:NAME.
    #[arg(long, value_name = "FILE.json")]
    stats: Option<String>,
    #[command(flatten)]
    store: StoreArgs,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Joins all parts.
pub(super) fn run(args: &AssembleArgs) -> Result<(), Failure> {
    let began = Instant::now();
    let format = format_of(&args.output)?;
    if !args.tiles.contains("{index}") {
        return Err(Failure::Usage(format!(
            "{} names one file: write {{index}} for the number of the part",
            args.tiles
        )));
    }
    let all = [args.scene.scene.as_str(), &args.tiles, &args.output];
    let places = Places::open(&args.store, all.into_iter().chain(args.stats.as_deref()))?;
    let mut session = Session::start_at(&args.scene, &args.settings, &places)?;
    session.cancel_on_ctrl_c()?;
    session.file.inputs.hash_contents();
    let ready = session.prepare_with_id()?;
    let file = TileFile::of(&ready, &session.file.inputs, args.of)?;
    let size = [ready.scene.width, ready.scene.height];
    let mut picture = empty(size, Region::whole(size[0], size[1]));
    for part in 0..args.of.parts() {
        let from = numbered(&args.tiles, "index", args.first + part, 1);
        let most = args.of.region(part, size)?.pixels() * PIXEL_BYTES + FILE_BYTES;
        join(&mut picture, &file.read(&from, part, &places.read(&from, most)?)?);
        session.file.inputs.note(Path::new(&from));
        session.check()?;
    }
    session
        .file
        .inputs
        .check_outputs([Some(&args.output), args.stats.as_ref()].into_iter().flatten().map(Path::new))?;
    let encoding = Instant::now();
    let (codes, error) =
        session.workers.work(|| (Codes::new(&picture.film, format), ErrorBounds::about(&picture, &ready.scene)))?;
    let replay = Replay::of(&picture, &ready);
    let bytes = codes.file_with(&picture.film, format, Some(&note(&error, &replay)));
    session.check()?;
    let phases = Phases {
        parse: ready.loading.parse,
        plan: ready.loading.plan,
        bvh: ready.loading.bvh,
        trace: picture.trace_ms,
        refine: picture.refine_ms,
        png: milliseconds(encoding),
    };
    let words = error.in_words();
    if let Some(stats) = &args.stats {
        let cost = Cost::of(&picture, phases, None, began, &session.workers);
        let report = Report { plan: ready.outline.plan(&ready.scene), cost, error, replay };
        places.write(stats, output::pretty(&report)?)?;
    }
    places.write(&args.output, bytes)?;
    output::say(&format!(
        "wrote {}: {} x {} pixels of {} parts, {} rays; {words}",
        args.output,
        size[0],
        size[1],
        args.of.parts(),
        picture.rays.total()
    ));
    Ok(())
}

/// The format that a picture's file is named by.
pub(super) fn format_of(output: &str) -> Result<FileFormat, Failure> {
    let format = PictureFormat::by_file(Path::new(output)).and_then(|format| format.with(None, None).ok());
    format.ok_or_else(|| Failure::Usage(format!("{output} names no format: use .png, .jpg, .webp, .exr or .pfm")))
}
