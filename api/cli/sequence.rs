//! `strahl render --frames`: the frames of a sequence as files with numbers, or as one animation.

use super::failure::Failure;
use super::output;
use super::progress;
use super::session::Session;
use crate::service::pictures::render::{RenderSpec, Rendered, make};
use crate::service::pictures::report::Report;
use crate::service::scenes::prepared::PreparedScene;
use crate::service::sequences::shown::in_words;
use serde::Serialize;
use std::path::{Path, PathBuf};
use strahl::film::animation::{AnimationFormat, Timing};
use strahl::film::{FileFormat, Region};
use strahl::scene::compile::Original;
use strahl::scene::read::read_as;
use strahl::sequence::Sequence;
use strahl::tradeoff::duration;

/// Where the numbers are in the names of files.
const DIGIT: char = '#';

/// Where the frames go.
enum Target {
    /// Files, whose names have a number between these.
    Files { before: String, digits: usize, after: String },
    /// One file.
    Animation(AnimationFormat),
}

/// What all frames cost.
#[derive(Serialize)]
struct Reports<'a> {
    frames: &'a [Report],
}

/// The sequence that the command line names: a number of frames all around the scene, or a file.
pub(super) fn read(frames: &str) -> Result<Sequence, Failure> {
    let sequence = match frames.parse::<u32>() {
        Ok(count) => Sequence::turntable(count),
        Err(_) => {
            let text = std::fs::read(frames).map_err(|error| {
                let detail = "--frames is a number of frames around the scene, or a file with a sequence";
                Failure::Input(format!("{frames} cannot be read: {error}\n{detail}"))
            })?;
            read_as(&text, "sequence").map_err(|problems| Failure::Scene { name: frames.to_owned(), problems })?
        }
    };
    sequence.check().map_err(|problems| Failure::Scene { name: "--frames".into(), problems })?;
    Ok(sequence)
}

/// Whether a file is an animated GIF, whose frames are rendered as PNG: there are no GIFs of single pictures.
pub(super) fn is_gif(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(AnimationFormat::Gif.names().0))
        && !file.to_string_lossy().contains(DIGIT)
}

impl Target {
    fn of(file: &Path, format: FileFormat) -> Result<Self, Failure> {
        let name = file.to_string_lossy();
        if let Some(at) = name.find(DIGIT) {
            let digits = name[at..].chars().take_while(|letter| *letter == DIGIT).count();
            let (before, after) = (name[..at].to_owned(), name[at + digits..].to_owned());
            return Ok(Self::Files { before, digits, after });
        }
        match format {
            _ if is_gif(file) => Ok(Self::Animation(AnimationFormat::Gif)),
            FileFormat::Png8 | FileFormat::Png16 => Ok(Self::Animation(AnimationFormat::Apng)),
            FileFormat::WebP => Ok(Self::Animation(AnimationFormat::Webp)),
            FileFormat::Jpeg(_) | FileFormat::Exr | FileFormat::Pfm => Err(Failure::Usage(
                "frames in this format are files with numbers: give their name with #, as -o out-####.exr".into(),
            )),
        }
    }

    /// The file of a frame, if each has one.
    fn file(&self, number: u32) -> Option<PathBuf> {
        match self {
            Self::Files { before, digits, after } => Some(format!("{before}{number:0digits$}{after}").into()),
            Self::Animation(_) => None,
        }
    }
}

/// Renders all frames. All of them are checked before the first one is rendered.
pub(super) fn run(
    session: &Session,
    sequence: &Sequence,
    file: &Path,
    format: FileFormat,
    stats: Option<&Path>,
) -> Result<(), Failure> {
    let target = Target::of(file, format)?;
    let base = session.load()?;
    output::warn(&session.file.name, &base.scene.warnings);
    let original = Original { description: &base.description, scene: &base.scene };
    let first = [base.scene.width, base.scene.height];
    for frame in sequence.frames() {
        let scene = session.load_frame(frame, original)?.scene;
        if [scene.width, scene.height] != first {
            let detail = "all frames have the size of the scene: take image out of their patches";
            return Err(Failure::Input(format!("frame {} has another size; {detail}", frame.number)));
        }
    }
    // Each frame may name files of its own.
    let numbered: Vec<PathBuf> = sequence.frames().filter_map(|frame| target.file(frame.number)).collect();
    let single = numbered.is_empty().then_some(file);
    session.file.inputs.check_outputs(numbered.iter().map(PathBuf::as_path).chain(single).chain(stats))?;
    let mut files = Vec::new();
    let mut reports = Vec::new();
    let render = || {
        for frame in sequence.frames() {
            let loaded = session.load_frame(frame, original)?;
            let ready = session.workers.work(|| PreparedScene::without_id(loaded))?;
            let region = Region::whole(ready.scene.width, ready.scene.height);
            let shot = RenderSpec { note: true, ..RenderSpec::of(&ready.scene, region, format) };
            let (workers, control) = (&session.workers, &session.control);
            let Rendered { file, report, .. } =
                make(session.started, &ready, ready.loading, &shot, workers, control, None, None)?;
            match target.file(frame.number) {
                Some(path) => output::write(&path, &file)?,
                None => files.push(file),
            }
            reports.push(report);
        }
        Ok::<_, Failure>(())
    };
    progress::while_showing(&session.control, render)?;
    if let Target::Animation(animation) = target {
        let timing = Timing { rate: sequence.rate, loops: sequence.loops };
        let made = animation.join(&files, timing).map_err(|why| Failure::Input(in_words(why).into()))?;
        output::write(file, &made.file)?;
        if let Some(warning) = made.warning() {
            output::say(&format!("warning: {warning}"));
        }
    }
    if let Some(path) = stats {
        output::write(path, &output::pretty(&Reports { frames: &reports })?)?;
    }
    summarise(&reports, first);
    Ok(())
}

/// One line for people.
fn summarise(reports: &[Report], [width, height]: [u32; 2]) {
    let rays: u64 = reports.iter().map(|report| report.cost.rays.total()).sum();
    let trace_ms: f64 = reports.iter().map(|report| report.cost.phases_ms.trace).sum();
    // Where nothing is proved, the error may be any.
    let codes = |report: &Report| report.error.proved.proof.as_ref().map_or(u8::MAX, |proof| proof.max_codes);
    // Of equals, one that is compared with less.
    let worst =
        reports.iter().rev().max_by_key(|report| (codes(report), report.error.proved.reach.max_depth.is_some()));
    let bound =
        worst.map_or_else(String::new, |report| format!("; of the worst frame {}", report.error.proved.in_words()));
    let count = reports.len();
    output::say(&format!(
        "{count} frames of {width} x {height} pixels, {rays} rays, {} tracing{bound}",
        duration(trace_ms)
    ));
}
