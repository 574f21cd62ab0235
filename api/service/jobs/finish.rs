//! Encodes the finished picture of a job, its report and its preview: what the pool does first, and the file on one thread.

use super::canvas::Canvas;
use super::record::JobSpec;
use crate::service::clock::milliseconds;
use crate::service::pictures::file::{PictureFile, PictureMeta};
use crate::service::pictures::render::note;
use crate::service::pictures::report::{Cost, ErrorBounds, Phases, Replay, Report};
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scheduler::pool::Workers;
use std::time::Instant;
use strahl::film::{Codes, FileFormat, Film, encode};
use strahl::render::Cancelled;

/// The files of a finished job.
#[derive(Debug)]
pub(super) struct JobFiles {
    /// The picture and its cost report.
    pub(super) made: PictureFile,
    /// The preview, a PNG.
    pub(super) preview: Vec<u8>,
}

/// A picture that is rendered, as codes.
#[derive(Debug)]
pub(super) struct Coded {
    canvas: Canvas,
    codes: Codes,
    preview: Vec<u8>,
    report: Report,
    began: Instant,
}

/// Makes codes of a picture, and reports its cost. `preview` says which small picture of it is kept. `began` is when this
/// process began to work on it; times of tracing include those of earlier processes.
pub(super) fn code(
    canvas: Canvas,
    preview: impl FnOnce(&Canvas) -> Film + Send,
    ready: &PreparedScene,
    order: &JobSpec,
    workers: &Workers,
    began: Instant,
) -> Result<Coded, Cancelled> {
    let picture = &canvas.picture;
    let encoding = Instant::now();
    let (codes, preview, error) = workers.work(|| {
        let codes = Codes::new(&picture.film, order.output);
        (codes, encode(&preview(&canvas), FileFormat::Png8), ErrorBounds::about(picture, &ready.scene))
    })?;
    let replay = Replay::of(picture, ready);
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
    Ok(Coded { canvas, codes, preview, report, began })
}

impl Coded {
    /// All its rays.
    pub(super) fn rays(&self) -> u64 {
        self.canvas.picture.rays.total()
    }

    /// Its files.
    pub(super) fn files(self, order: &JobSpec, image: Option<String>, ready: &PreparedScene) -> JobFiles {
        let Self { canvas, codes, preview, mut report, began } = self;
        let writing = Instant::now();
        let note = note(&report.error, &report.replay);
        let file = codes.file_with(&canvas.picture.film, order.output, Some(&note));
        report.cost.phases_ms.png += milliseconds(writing);
        report.cost.wall_ms = milliseconds(began);
        let about = PictureMeta::new(image, &report, &ready.scene, true);
        JobFiles { made: PictureFile::new(file, about), preview }
    }
}
