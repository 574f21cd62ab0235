//! `strahl tradeoff`: what accuracy costs in time, as a page and as JSON.

use super::failure::Failure;
use super::scene_args::{SceneArgs, SettingsArgs};
use super::session::Session;
use super::{output, progress};
use crate::service::tradeoff::{Outcome, Stopped, measure};
use crate::service::values::seconds;
use clap::Args;
use std::path::{Path, PathBuf};
use std::time::Duration;
use strahl::tradeoff::Source as ErrorSource;
use strahl::tradeoff::page::page;
use strahl::tradeoff::plot::plot;
use strahl::tradeoff::{Cost, Tradeoff};

/// `strahl tradeoff`.
#[derive(Debug, Args)]
#[command(after_help = "\
The answer comes in a sentence on standard error: which setting to take, what it costs, what is lost. Pictures are scaled down so
that all settings can be compared in the time there is; the report says to what size.")]
pub(super) struct TradeoffArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Page with plots, table and pictures: .html, or .svg for the plot of error against time alone; - for the page on
    /// standard output [default: the scene's name with -tradeoff.html].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write all points as JSON, too. - is standard output.
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// Seconds that loading and measuring may take.
    #[arg(long, value_name = "SECONDS", default_value = "20", value_parser = seconds)]
    seconds: Duration,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Measures.
pub(super) fn run(args: &TradeoffArgs) -> Result<(), Failure> {
    let file_name = output::file_of(args.output.as_deref(), &args.scene.scene, "-tradeoff.html");
    let drawing = is_drawing(&file_name)?;
    let json = args.json.as_deref();
    output::check_both("page", &file_name, "--json", json)?;
    let session = Session::start(&args.scene, &args.settings)?;
    session.cancel_on_ctrl_c()?;
    let loaded = session.load()?;
    session.file.inputs.check_outputs([Some(file_name.as_path()), json].into_iter().flatten())?;
    output::warn(&session.file.name, &loaded.scene.warnings);
    let seconds = args.seconds.as_secs_f64();
    let work =
        || measure(loaded, &session.file.inputs, session.started, seconds, &session.workers, &session.control, &|_| ());
    let Outcome { tradeoff, thumbnails } =
        progress::while_telling(&session.control, "measuring", work).map_err(|stopped| match stopped {
            Stopped::Cancelled => Failure::Interrupted,
            Stopped::Refused(problems) => Failure::Scene { name: session.file.name.clone(), problems },
        })?;

    let file = if drawing { error_against_time(&tradeoff) } else { page(&tradeoff, &thumbnails) };
    output::write(&file_name, file.as_bytes())?;
    output::tell(args.output.as_deref(), &file_name);
    output::say(&tradeoff.choices.answer);
    if let Some(path) = json {
        output::write(path, &output::pretty(&tradeoff)?)?;
    }
    Ok(())
}

fn is_drawing(path: &Path) -> Result<bool, Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        "svg" => Ok(true),
        "html" | "htm" => Ok(false),
        _ if output::is_standard(path) => Ok(false),
        _ => Err(Failure::Usage(format!("{} names no format: use .html, or .svg for the plot alone", path.display()))),
    }
}

/// The plot of error against time for settings of the recursion.
fn error_against_time(tradeoff: &Tradeoff) -> String {
    let wanted = |front: &&strahl::tradeoff::Front| (front.error, front.cost) == (ErrorSource::Truncation, Cost::Time);
    tradeoff.fronts.iter().find(wanted).map(|front| plot(&tradeoff.points, front, true)).unwrap_or_default() + "\n"
}
