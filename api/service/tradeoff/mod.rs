//! Measures a trade-off within a time limit, in two parts: about ten settings to choose from, then many more on a smaller
//! picture. Each part begins with very small pictures and goes on to larger ones: references first, then all settings, at the
//! end round by round.

mod bench;
mod choices;
mod level;
pub(crate) mod progress;
mod references;

use crate::service::clock::milliseconds;
use crate::service::scheduler::pool::Workers;
use bench::TradeoffBench;
use level::MeasuredSize;
use progress::Watch;
use references::{Positions, positions};
use std::time::{Instant, SystemTime};
use strahl::lanes::instructions;
use strahl::render::{Cancelled, Control, RenderOptions};
use strahl::scene::{Files, Loaded, Problems};
use strahl::tradeoff::advice;
use strahl::tradeoff::page::Thumbnails;
use strahl::tradeoff::sweep::{Settings, Times, points};
use strahl::tradeoff::{Circumstances, Front, HOW_TIMES_ARE_MEASURED, Tradeoff};

/// Share of the time of a part at which rendering ends.
const END: f64 = 0.95;
/// Share of the time for the choices.
const CHOICES: f64 = 0.6;

/// What a part of a trade-off measures.
struct Part {
    /// The settings that the scene asks for.
    asked: Settings,
    asked_size: [u32; 2],
    /// Most pixels of its pictures.
    most_pixels: f64,
    /// Sampling patterns of the references.
    positions: Vec<Positions>,
    /// Most rounds.
    rounds: usize,
    /// Comparisons for each setting.
    comparisons: f64,
}

/// A measured trade-off.
#[derive(Debug)]
pub(crate) struct Outcome {
    /// The numbers.
    pub(crate) tradeoff: Tradeoff,
    /// The pictures of the points, where they were measured.
    pub(crate) thumbnails: Vec<Option<Thumbnails>>,
}

/// Why nothing was measured.
#[derive(Debug)]
pub(crate) enum Stopped {
    /// The request was cancelled.
    Cancelled,
    /// The scene cannot be built in the other precision.
    Refused(Problems),
}

impl From<Cancelled> for Stopped {
    fn from(Cancelled: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Measures what accuracy costs for a scene, in about `seconds` from `started`, and tells `watch` what it finds.
pub(crate) fn measure(
    loaded: Loaded,
    files: &dyn Files,
    started: Instant,
    seconds: f64,
    workers: &Workers,
    control: &Control,
    watch: Watch<'_>,
) -> Result<Outcome, Stopped> {
    control.set_progress(0, (seconds * 1e3) as u64);
    let load_ms = milliseconds(started);
    let name = loaded.description.name.clone();
    let (mut bench, asked) = TradeoffBench::build(loaded, files, started, CHOICES * seconds, workers, control, watch)?;
    let asked_size = [bench.single.width, bench.single.height];
    let choices = choices::measure(&mut bench, asked, load_ms)?;

    bench.begin_part("points", seconds - bench.elapsed());
    let mut points = points(asked, bench.left_out, bench.proved_depth());
    let settings: Vec<Settings> = points.iter().map(|point| point.settings).collect();
    let part = Part {
        asked,
        asked_size,
        most_pixels: 262_144.0,
        positions: positions(&settings),
        rounds: 9,
        comparisons: 2.0,
    };
    let level = MeasuredSize::largest(&mut bench, &settings, &part)?;
    let sampling = level.references.as_ref().map(|references| references.sampling(&bench)).unwrap_or_default();
    let mut thumbnails = vec![None; points.len()];
    for ((point, thumbnails), setting) in points.iter_mut().zip(&mut thumbnails).zip(&level.measured) {
        let Some(setting) = setting else { continue };
        (point.rays, point.proved_codes, point.time) =
            (Some(setting.rays), setting.proved_codes, Times::of(&setting.times));
        if let Some(references) = &level.references {
            point.measured = references.errors(&bench, point.settings, &setting.codes, &sampling);
            *thumbnails = Some(references.thumbnails(point.settings, &setting.codes));
        }
    }

    let fronts = Front::all(&points);
    let circumstances = Circumstances {
        version: env!("CARGO_PKG_VERSION"),
        date: today(),
        threads: workers.threads(),
        instructions: instructions(RenderOptions::default().level),
        asked_size,
        size: level.size,
        seconds,
        took_seconds: milliseconds(started) / 1e3,
        times: HOW_TIMES_ARE_MEASURED,
    };
    let reference = level.references.as_ref().map(|references| references.report());
    let advice = advice(&points, &fronts);
    let tradeoff = Tradeoff { scene: name, circumstances, reference, choices, points, fronts, advice };
    Ok(Outcome { tradeoff, thumbnails })
}

/// The date by Coordinated Universal Time, as YYYY-MM-DD.
fn today() -> String {
    let mut date = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    date.truncate("YYYY-MM-DD".len());
    date
}
