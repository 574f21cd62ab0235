//! `strahl render`: a scene into a picture file.

use super::failure::Failure;
use super::scene_file::Source;
use super::workers::{region_of, start_workers};
use super::{PictureFormat, RenderArgs};
use super::{interrupt, output, progress};
use crate::http::extract::accept::QUALITY;
use crate::service::pictures::render;
use crate::service::pictures::render::{Finished, Shot};
use crate::service::pictures::report::Report;
use crate::service::scenes::prepared::Ready;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;
use strahl::film::FileFormat;
use strahl::render::Control;
use strahl::scene::Problem;

/// Renders.
pub(super) fn run(args: &RenderArgs) -> Result<(), Failure> {
    let format = file_format(args)?;
    let stats = args.picture.stats.as_deref();
    if stats.is_some_and(output::is_standard) && output::is_standard(&args.output) {
        return Err(Failure::Usage("the picture and --stats cannot both go to standard output".into()));
    }
    for path in [Some(args.output.as_path()), stats].into_iter().flatten() {
        output::check_folder(path)?;
    }

    let control = Arc::new(Control::default());
    let workers = start_workers(args.settings.threads, &control)?;
    interrupt::cancel_on_ctrl_c(&control)?;

    let started = Instant::now();
    let source = Source::read(&args.scene)?;
    let ready = workers.work(|| source.load(&args.settings.overrides()).map(Ready::from))??;
    if control.cancelled.load(Ordering::Relaxed) {
        return Err(Failure::Interrupted);
    }
    warn(&source.name, &ready.scene.warnings);
    let region = region_of(&ready.scene, args.picture.region)?;
    let shot = Shot { note: true, predict: stats.is_some(), ..Shot::of(&ready.scene, region, format) };
    let make = || render::make(started, &ready, ready.loading, &shot, &workers, &control);
    let Finished { file, report } = progress::while_showing(&control, make)?;

    output::write(&args.output, &file)?;
    if let Some(path) = stats {
        output::write(path, &output::pretty(&report)?)?;
    }
    summarise(&report);
    Ok(())
}

fn file_format(args: &RenderArgs) -> Result<FileFormat, Failure> {
    let format = match args.format {
        Some(format) => format,
        None if output::is_standard(&args.output) => {
            return Err(Failure::Usage(
                "a picture on standard output needs --format png, jpg, webp, exr or pfm".into(),
            ));
        }
        None => by_name(&args.output)?,
    };
    if args.quality.is_some() && format != PictureFormat::Jpg {
        return Err(Failure::Usage("--quality is for JPEG; the other formats lose nothing".into()));
    }
    match (format, args.bits.as_str()) {
        (PictureFormat::Png, "16") => Ok(FileFormat::Png16),
        (PictureFormat::Png, _) => Ok(FileFormat::Png8),
        (_, "16") => {
            Err(Failure::Usage("--bits is for PNG; EXR and PFM hold 32-bit floats, JPEG and WebP 8 bits".into()))
        }
        (PictureFormat::Jpg, _) => Ok(FileFormat::Jpeg(args.quality.unwrap_or(QUALITY))),
        (PictureFormat::Webp, _) => Ok(FileFormat::WebP),
        (PictureFormat::Exr, _) => Ok(FileFormat::Exr),
        (PictureFormat::Pfm, _) => Ok(FileFormat::Pfm),
    }
}

fn by_name(path: &Path) -> Result<PictureFormat, Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        "png" => Ok(PictureFormat::Png),
        "jpg" | "jpeg" => Ok(PictureFormat::Jpg),
        "webp" => Ok(PictureFormat::Webp),
        "exr" => Ok(PictureFormat::Exr),
        "pfm" => Ok(PictureFormat::Pfm),
        _ => {
            let name = path.display();
            Err(Failure::Usage(format!(
                "{name} names no format: use .png, .jpg, .webp, .exr or .pfm, or give --format"
            )))
        }
    }
}

/// Warnings are no errors: the picture comes all the same.
fn warn(name: &str, warnings: &[Problem]) {
    let mut err = io::stderr().lock();
    for warning in warnings {
        // The picture matters more than what is said about it.
        let _ = writeln!(err, "warning: {name}: {warning}");
    }
}

/// One line for people; programs ask for `--stats`.
fn summarise(report: &Report) {
    let mut err = io::stderr().lock();
    if err.is_terminal() {
        let rays = report.cost.rays;
        let all = rays.total();
        let seconds = report.cost.wall_ms / 1e3;
        let _ = writeln!(
            err,
            "{} x {} pixels, {all} rays, {seconds:.2} s ({:.2} s tracing)",
            report.replay.region.width,
            report.replay.region.height,
            report.cost.phases_ms.trace / 1e3
        );
    }
}
