//! `strahl tradeoff`: what accuracy costs in time, as a page and as JSON.

use super::TradeoffArgs;
use super::failure::Failure;
use super::scene_file::Source;
use super::workers::start_workers;
use super::{interrupt, output, progress};
use crate::service::tradeoff::{Outcome, Stopped, measure};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use strahl::accuracy::page::page;
use strahl::accuracy::plot::plot;
use strahl::accuracy::tradeoff::Source as ErrorSource;
use strahl::accuracy::tradeoff::{Cost, Tradeoff};
use strahl::render::Control;

/// Measures.
pub(super) fn run(args: &TradeoffArgs) -> Result<(), Failure> {
    let drawing = is_drawing(&args.output)?;
    let json = args.json.as_deref();
    if json.is_some_and(output::is_standard) && output::is_standard(&args.output) {
        return Err(Failure::Usage("the page and --json cannot both go to standard output".into()));
    }
    for path in [Some(args.output.as_path()), json].into_iter().flatten() {
        output::check_folder(path)?;
    }
    let control = Arc::new(Control::default());
    let workers = start_workers(args.settings.threads, &control)?;
    interrupt::cancel_on_ctrl_c(&control)?;

    let started = Instant::now();
    let source = Source::read(&args.scene)?;
    let loaded = workers.work(|| source.load(&args.settings.overrides()))??;
    let seconds = args.seconds.as_secs_f64();
    let work = || measure(loaded, source.files(), started, seconds, &workers, &control);
    let Outcome { tradeoff, thumbnails } =
        progress::while_showing(&control, work).map_err(|stopped| match stopped {
            Stopped::Cancelled => Failure::Interrupted,
            Stopped::Refused(problems) => Failure::Scene { name: source.name.clone(), problems },
        })?;

    let file = if drawing { error_against_time(&tradeoff) } else { page(&tradeoff, &thumbnails) };
    output::write(&args.output, file.as_bytes())?;
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

/// The drawing of the error that settings of the recursion make: the plane this renderer can say most about.
fn error_against_time(tradeoff: &Tradeoff) -> String {
    let wanted =
        |front: &&strahl::accuracy::tradeoff::Front| (front.error, front.cost) == (ErrorSource::Truncation, Cost::Time);
    tradeoff.fronts.iter().find(wanted).map(|front| plot(&tradeoff.points, front, true)).unwrap_or_default() + "\n"
}
