//! `strahl render`: a scene into a picture file.

use super::failure::Failure;
use super::scene_args::{PictureArgs, SceneArgs, SettingsArgs};
use super::session::{Session, region_of};
use super::values::word;
use super::{output, progress, sequence};
use crate::service::pictures::render::{self, RenderSpec, Rendered};
use crate::service::pictures::report::Report;
use clap::Args;
use std::path::{Path, PathBuf};
use strahl::film::{FileFormat, PictureFormat};
use strahl::render::Layers;
use strahl::tradeoff::duration;

/// `strahl render`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  strahl render scenes/whitted/whitted.json                  the picture is whitted.png
  strahl render scene.json -o small.jpg --width 480 --height 270
  strahl render scene.json -o exact.png --accuracy proved:0  no 8-bit code is off, where that can be proved
  strahl render scene.json -o quick.png --accuracy time:200  the best picture in 200 ms
  strahl render scene.json -o linear.exr --stats cost.json   linear floats, and what the picture cost
  strahl render scene.json -o layers.exr --layers distance,normal,object  in one file, for compositing
  strahl render scene.json --layers distance,share:/objects/2  in scene.distance.png and scene.share.png
  strahl render scene.json --frames 36 -o around.webp          36 frames around the scene, as an animation
  strahl render scene.json --frames flight.json -o f-####.exr  the frames of a sequence, f-0000.exr and so on
  strahl render - -o - --format png < scene.json > scene.png")]
pub(super) struct RenderArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Picture file: .png, .jpg, .webp, or .exr or .pfm for linear floats; - for standard output, which needs --format
    /// [default: the scene's name with .png].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Format of the picture [default: by file name].
    #[arg(long, value_parser = word::<PictureFormat>())]
    format: Option<PictureFormat>,
    /// Bits per channel of a PNG: 8 or 16 [default: 8].
    #[arg(long, value_parser = bits)]
    bits: Option<u8>,
    /// Quality of a JPEG, 1 to 100 [default: 90].
    #[arg(long, value_name = "QUALITY", value_parser = clap::value_parser!(u8).range(1..=100))]
    quality: Option<u8>,
    /// Layers beside the colors, with commas between: distance, position, normal, albedo, object, material, and
    /// share:/objects/3 of one object. An EXR holds all of them; of a PNG each is a file of its own, as picture.normal.png.
    #[arg(long, value_name = "LAYERS")]
    layers: Option<Layers>,
    /// Render frames: a number of them all around the scene, or a file with a sequence. Into files with numbers for #, or into
    /// one animation, .png, .webp or .gif.
    #[arg(long, value_name = "COUNT|FILE.json", conflicts_with_all = ["layers", "region"])]
    frames: Option<String>,
    #[command(flatten)]
    settings: SettingsArgs,
    #[command(flatten)]
    picture: PictureArgs,
}

/// Renders.
pub(super) fn run(args: &RenderArgs) -> Result<(), Failure> {
    let ending = format!(".{}", args.format.unwrap_or(PictureFormat::Png).names().0);
    let file_name = output::file_of(args.output.as_deref(), &args.scene.scene, &ending);
    let format = file_format(args, &file_name)?;
    let layers = args.layers.unwrap_or_default();
    check_layers(layers, format, &file_name)?;
    let stats = args.picture.stats.as_deref();
    output::check_both("picture", &file_name, "--stats", stats)?;

    let frames = args.frames.as_deref().map(sequence::read).transpose()?;
    let mut session = Session::start(&args.scene, &args.settings)?;
    session.cancel_on_ctrl_c()?;
    if let Some(frames) = frames {
        args.frames.iter().for_each(|file| session.file.inputs.note(Path::new(file)));
        let frames = session.go_around(frames);
        sequence::run(&session, &frames, &file_name, format, stats)?;
        output::tell(args.output.as_deref(), &file_name);
        return Ok(());
    }
    let ready = session.prepare()?;
    output::warn(&session.file.name, &ready.scene.warnings);
    let region = region_of(&ready.scene, args.picture.region)?;
    layers.check(&ready.scene).map_err(|wrong| Failure::Usage(format!("--layers {wrong}")))?;
    let of_layer = |layer: &str| file_name.with_extension(format!("{layer}.png"));
    let more = if format == FileFormat::Exr { Layers::default() } else { layers };
    let more: Vec<PathBuf> = more.kinds().map(|kind| of_layer(&kind.name())).collect();
    let outputs = [Some(file_name.as_path()), stats].into_iter().flatten();
    session.file.inputs.check_outputs(outputs.chain(more.iter().map(PathBuf::as_path)))?;
    let shot =
        RenderSpec { layers, note: true, predict: stats.is_some(), ..RenderSpec::of(&ready.scene, region, format) };
    let make =
        || render::make(session.started, &ready, ready.loading, &shot, &session.workers, &session.control, None, None);
    let Rendered { file, report, layers } = progress::while_showing(&session.control, make)?;

    output::write(&file_name, &file)?;
    output::tell(args.output.as_deref(), &file_name);
    for (layer, file) in layers {
        let path = of_layer(&layer);
        output::write(&path, &file)?;
        output::tell(None, &path);
    }
    if let Some(path) = stats {
        output::write(path, &output::pretty(&report)?)?;
    }
    if let Some(shortfall) = &report.error.proved.shortfall {
        output::say(&format!("warning: {shortfall}"));
    }
    summarise(&report);
    Ok(())
}

fn file_format(args: &RenderArgs, file_name: &Path) -> Result<FileFormat, Failure> {
    let format = match args.format {
        Some(format) => format,
        None if output::is_standard(file_name) => {
            return Err(Failure::Usage(
                "a picture on standard output needs --format png, jpg, webp, exr or pfm".into(),
            ));
        }
        None if args.frames.is_some() && sequence::is_gif(file_name) => PictureFormat::Png,
        None => PictureFormat::by_file(file_name).ok_or_else(|| {
            let name = file_name.display();
            Failure::Usage(format!("{name} names no format: use .png, .jpg, .webp, .exr or .pfm, or give --format"))
        })?,
    };
    format.with(args.bits, args.quality).map_err(|wrong| {
        let wrong = wrong.iter().map(|wrong| format!("--{} {}", wrong.parameter, wrong.why));
        Failure::Usage(wrong.collect::<Vec<_>>().join("\n"))
    })
}

/// Fails if a picture has no place for its layers.
fn check_layers(layers: Layers, format: FileFormat, file_name: &Path) -> Result<(), Failure> {
    let is_png = matches!(format, FileFormat::Png8 | FileFormat::Png16);
    match format {
        _ if layers.is_empty() => Ok(()),
        FileFormat::Exr => Ok(()),
        _ if is_png && !output::is_standard(file_name) => Ok(()),
        _ if is_png => {
            Err(Failure::Usage("on standard output only EXR has room for --layers: add --format exr".into()))
        }
        _ => Err(Failure::Usage("--layers need a picture in .exr, or in .png with a file for each layer".into())),
    }
}

fn bits(text: &str) -> Result<u8, &'static str> {
    text.parse().ok().filter(|bits| matches!(bits, 8 | 16)).ok_or("expected 8 or 16")
}

/// One line for people, on standard error as the picture may be on the other; programs ask for `--stats`.
fn summarise(report: &Report) {
    let region = report.replay.region;
    output::say(&format!(
        "{} x {} pixels, {} rays, {} ({} tracing); {}",
        region.width,
        region.height,
        report.cost.rays.total(),
        duration(report.cost.wall_ms),
        duration(report.cost.phases_ms.trace),
        report.error.in_words()
    ));
}
