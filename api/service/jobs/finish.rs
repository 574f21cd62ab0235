//! From a finished canvas to the picture's file, what is said about it, and the small picture.

use super::canvas::Canvas;
use super::record::Order;
use crate::service::pictures::file::{About, Made};
use crate::service::pictures::render::{milliseconds, note};
use crate::service::pictures::report::{Cost, ErrorBounds, Phases, Replay, Report};
use crate::service::scenes::prepared::Ready;
use crate::service::scheduler::pool::Workers;
use std::time::Instant;
use strahl::film::{Codes, FileFormat, encode};
use strahl::render::Cancelled;

/// The files of a job.
#[derive(Debug)]
pub(super) struct Finished {
    /// The picture and its cost report.
    pub(super) made: Made,
    /// The small picture, a PNG.
    pub(super) preview: Vec<u8>,
}

/// Encodes the picture and says what it cost. `began` is when this process began to work on it; times of tracing are those
/// of all processes.
pub(super) fn finish(
    canvas: &Canvas,
    ready: &Ready,
    order: &Order,
    image: Option<String>,
    workers: &Workers,
    began: Instant,
) -> Result<Finished, Cancelled> {
    let picture = canvas.picture();
    let encoding = Instant::now();
    let (codes, preview, error) = workers.work(|| {
        let codes = Codes::new(&picture.film, order.output);
        (codes, encode(canvas.preview(), FileFormat::Png8), ErrorBounds::about(picture, &ready.scene))
    })?;
    let replay = Replay::of(picture, ready);
    let file = codes.file_with(&picture.film, order.output, Some(&note(&error, &replay)));
    let phases = Phases {
        parse: ready.loading.parse,
        plan: ready.loading.plan,
        bvh: ready.loading.bvh,
        trace: picture.trace_ms,
        refine: picture.refine_ms,
        png: milliseconds(encoding),
    };
    let cost = Cost::of(picture, phases, None, began, workers);
    let report = Report { plan: ready.plan.clone(), cost, error, replay };
    let about = About::new(image, &report, &ready.scene, true);
    Ok(Finished { made: Made::new(file, about), preview })
}
