//! Measures a trade-off within a time limit: first all settings once on a small picture, as a warm-up and to choose the size of
//! the picture, then references, then all settings round by round on that picture.

mod references;
mod stage;
mod trial;

use crate::service::clock::milliseconds;
use crate::service::scheduler::pool::Workers;
use references::References;
use stage::Stage;
use std::time::{Instant, SystemTime};
use strahl::lanes::instructions;
use strahl::metrics::Image8;
use strahl::render::{Cancelled, Control, RenderOptions};
use strahl::scene::{Files, Loaded, Problems};
use strahl::tradeoff::advice;
use strahl::tradeoff::page::Thumbnails;
use strahl::tradeoff::sweep::{Times, points};
use strahl::tradeoff::{Circumstances, Front, HOW_TIMES_ARE_MEASURED, Reference, Tradeoff};
use trial::Trial;

/// Rounds for which the size of the picture is chosen, and most rounds.
const ROUNDS: [usize; 2] = [3, 9];
/// Shares of the time at which the small picture, the references and all rendering end.
const ENDS: [f64; 3] = [0.3, 0.65, 0.95];

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

/// Measures what accuracy costs for a scene, in about `seconds` from `started`.
pub(crate) fn measure(
    loaded: Loaded,
    files: &dyn Files,
    started: Instant,
    seconds: f64,
    workers: &Workers,
    control: &Control,
) -> Result<Outcome, Stopped> {
    control.set_progress(0, (seconds * 1e3) as u64);
    let name = loaded.description.name.clone();
    let (mut stage, asked) = Stage::set(loaded, files, started, seconds, workers, control)?;
    let asked_size = [stage.single.width, stage.single.height];
    let mut points = points(asked);

    let trial = Trial::run(&mut stage, &points, asked)?;
    let size = trial.size_for(&stage, asked_size, points.len());
    stage.resize(size);

    let (references, dropped) = References::trace(&mut stage, &points, trial.recursion)?;
    let mut thumbnails = vec![None; points.len()];
    let mut times = vec![Vec::new(); points.len()];
    for round in 0..ROUNDS[1] {
        for (i, point) in points.iter_mut().enumerate() {
            // Once a point's time is known, it is only rendered if there is time to finish it.
            let longest = times[i].iter().copied().fold(0.0, f64::max);
            if round > 0 && (times[i].is_empty() || stage.left(ENDS[2]) < 1.2 * longest / 1e3) {
                continue;
            }
            let Some(picture) = stage.shoot(point.settings, ENDS[2])? else { continue };
            times[i].push(picture.trace_ms);
            if round == 0 {
                point.rays = Some(picture.rays);
                // The same bounds for all points: those against recursion without end, which the references come near to.
                let endless = stage.single.ceiling().reach.max_depth.is_none();
                let proof = endless.then(|| stage.workers.work(|| picture.proof())).transpose()?;
                point.proved_codes = proof.filter(|p| p.max_linear.is_some()).map(|p| p.max_codes);
                let codes = Image8::from(&picture.film);
                point.measured = references.errors(&stage, point.settings, &codes);
                thumbnails[i] = Some(references.thumbnails(point.settings, &codes));
            }
        }
    }
    for (point, times) in points.iter_mut().zip(&times) {
        point.time = Times::of(times);
    }

    let fronts = Front::all(&points);
    let circumstances = Circumstances {
        version: env!("CARGO_PKG_VERSION"),
        date: today(),
        threads: workers.threads(),
        instructions: instructions(RenderOptions::default().level),
        asked_size,
        size,
        seconds,
        took_seconds: milliseconds(started) / 1e3,
        times: HOW_TIMES_ARE_MEASURED,
    };
    let (max_depth, min_weight) = trial.recursion;
    let reference = Reference { max_depth, min_weight, dropped, finer: trial.finer };
    let advice = advice(&points, &fronts);
    Ok(Outcome { tradeoff: Tradeoff { scene: name, circumstances, reference, points, fronts, advice }, thumbnails })
}

/// The date by Coordinated Universal Time, as YYYY-MM-DD.
fn today() -> String {
    let mut date = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    date.truncate("YYYY-MM-DD".len());
    date
}
