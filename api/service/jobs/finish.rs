//! Encodes the finished picture of a job, its report and its preview.

use super::canvas::Canvas;
use super::record::JobSpec;
use crate::service::clock::milliseconds;
use crate::service::pictures::file::{PictureFile, PictureMeta};
use crate::service::pictures::render::note;
use crate::service::pictures::report::{Cost, ErrorBounds, Phases, Replay, Report};
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scheduler::pool::Workers;
use std::time::Instant;
use strahl::film::{Codes, FileFormat, encode};
use strahl::render::Cancelled;

/// The files of a finished job.
#[derive(Debug)]
pub(super) struct JobFiles {
    /// The picture and its cost report.
    pub(super) made: PictureFile,
    /// The preview, a PNG.
    pub(super) preview: Vec<u8>,
}

/// Encodes the picture and reports its cost. `began` is when this process began to work on it; times of tracing include
/// those of earlier processes.
pub(super) fn finish(
    canvas: &Canvas,
    ready: &PreparedScene,
    order: &JobSpec,
    image: Option<String>,
    workers: &Workers,
    began: Instant,
) -> Result<JobFiles, Cancelled> {
    let picture = &canvas.picture;
    let encoding = Instant::now();
    let (codes, preview, error) = workers.work(|| {
        let codes = Codes::new(&picture.film, order.output);
        (codes, encode(&canvas.preview, FileFormat::Png8), ErrorBounds::about(picture, &ready.scene))
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
    let report = Report { plan: ready.outline.plan(&ready.scene), cost, error, replay };
    let about = PictureMeta::new(image, &report, &ready.scene, true);
    Ok(JobFiles { made: PictureFile::new(file, about), preview })
}
