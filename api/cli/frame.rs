//! `strahl frame`: one frame of a sequence, or of numbered scenes, for managers of farms that run one command for each frame.

use super::assemble::format_of;
use super::failure::Failure;
use super::places::{Places, StoreArgs, numbered};
use super::scene_args::{SceneArgs, SettingsArgs};
use super::session::Session;
use super::tile::EXIT_CODES;
use super::{output, progress};
use crate::service::pictures::render::{RenderSpec, make};
use clap::Args;
use std::path::Path;
use strahl::film::Region;
use strahl::scene::limits::SCENE_BYTES;
use strahl::scene::read::read_as;
use strahl::sequence::Sequence;
use strahl::tradeoff::duration;

/// Digits of a frame's number in names.
const DIGITS: usize = 4;

/// `strahl frame`.
#[derive(Debug, Args)]
#[command(after_help = format!("\
Examples:
  strahl frame shot.json --sequence turn.json --frame 12 -o 'out/{{frame}}.png'   frame 12 of a sequence, to out/0012.png
  strahl frame 'shot.{{frame}}.json' --frame 12 -o 'out/shot.{{frame}}.png'         shot.0012.json to out/shot.0012.png
  strahl frame 'store:shot/{{frame}}.json' -o 'store:out/{{frame}}.exr' --store s3://farm/renders   in an Indexed Job

{EXIT_CODES}"))]
pub(super) struct FrameArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The sequence: JSON as in "frames" of a job, a file or store:NAME. Without it the frame is a scene of its own.
    #[arg(long, value_name = "FILE.json")]
    sequence: Option<String>,
    /// Number of the frame, which stands for {frame} in the names of scene and picture, with four digits. The first one of a
    /// sequence is 0.
    #[arg(long, env = "JOB_COMPLETION_INDEX", value_name = "NUMBER")]
    frame: u32,
    /// Picture file, or store:NAME: .png, .jpg, .webp, .exr or .pfm.
    #[arg(short, long, value_name = "FILE")]
    output: String,
    /// Write the cost report as JSON: a file, or store:NAME.
    #[arg(long, value_name = "FILE.json")]
    stats: Option<String>,
    #[command(flatten)]
    store: StoreArgs,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Renders the frame.
pub(super) fn run(args: &FrameArgs) -> Result<(), Failure> {
    let named = |template: &str| numbered(template, "frame", args.frame, DIGITS);
    let scene = SceneArgs { scene: named(&args.scene.scene), input: args.scene.input };
    let (to, stats) = (named(&args.output), args.stats.as_deref().map(named));
    let format = format_of(&to)?;
    let all = [scene.scene.as_str(), &to].into_iter().chain(stats.as_deref()).chain(args.sequence.as_deref());
    let places = Places::open(&args.store, all)?;
    let sequence = args.sequence.as_deref().map(|name| read(&places, name, args.frame)).transpose()?;
    let mut session = Session::start_at(&scene, &args.settings, &places)?;
    session.cancel_on_ctrl_c()?;
    let sequence = sequence.map(|sequence| session.go_around(sequence));
    let ready = match &sequence {
        Some(sequence) => session.prepare_frame(sequence.frame(args.frame))?,
        None => session.prepare()?,
    };
    args.sequence.iter().for_each(|file| session.file.inputs.note(Path::new(file)));
    session.file.inputs.check_outputs([Some(&to), stats.as_ref()].into_iter().flatten().map(Path::new))?;
    output::warn(&session.file.name, &ready.scene.warnings);
    let whole = Region::whole(ready.scene.width, ready.scene.height);
    let shot = RenderSpec { note: true, ..RenderSpec::of(&ready.scene, whole, format) };
    let make = || make(session.started, &ready, ready.loading, &shot, &session.workers, &session.control, None, None);
    let made = progress::while_showing(&session.control, make)?;
    if let Some(stats) = stats {
        places.write(&stats, output::pretty(&made.report)?)?;
    }
    places.write(&to, made.file)?;
    let rays = made.report.cost.rays.total();
    output::say(&format!(
        "wrote {to}: {rays} rays, {}; {}",
        duration(made.report.cost.wall_ms),
        made.report.error.in_words()
    ));
    Ok(())
}

/// A sequence that has a frame of this number.
fn read(places: &Places, name: &str, number: u32) -> Result<Sequence, Failure> {
    let bytes = places.read(name, SCENE_BYTES.max)?;
    let wrong = |problems| Failure::Scene { name: name.to_owned(), problems };
    let sequence: Sequence = read_as(&bytes, "sequence").map_err(wrong)?;
    sequence.check().map_err(wrong)?;
    let count = sequence.count();
    if number >= count {
        return Err(Failure::Usage(format!("--frame {number} is none of the {count} frames from 0 to {}", count - 1)));
    }
    Ok(sequence)
}
