//! Renders a loaded scene into a picture file with its cost report.

use super::report::{Cost, ErrorBounds, Phases, Replay, Report};
use crate::service::clock::milliseconds;
use crate::service::scenes::prepared::{Loading, PreparedScene};
use crate::service::scheduler::pool::Workers;
use serde_json::json;
use std::time::{Duration, Instant};
use strahl::camera::Window;
use strahl::control::Stopwatch;
use strahl::film::{Adjustment, Codes, Display, FileFormat, Region, encode_exr_with};
use strahl::plan::pilot::Effort;
use strahl::render::{
    Cancelled, Control, Layers, Picture, Stop, Watcher, render_layers, render_watched, render_window,
};
use strahl::scene::Scene;
use strahl::scene::description::{Accuracy, Rays, Time};

/// Bytes of memory for each pixel of a picture that is made: as floats and as codes, what it lacks at most, and its file.
pub(crate) const PIXEL_BYTES: u64 = 44;
/// Likewise, if each pixel is traced alone.
pub(crate) const MEASURED_PIXEL_BYTES: u64 = 80;
/// Bytes of memory for a picture of any size.
pub(crate) const PICTURE_BYTES: u64 = 1 << 20;

/// A picture file and what it cost.
#[derive(Debug)]
pub(crate) struct Rendered {
    /// The bytes of the file.
    pub(crate) file: Vec<u8>,
    /// Its cost report.
    pub(crate) report: Report,
    /// The files of its layers by their names, where the picture's own has no place for them.
    pub(crate) layers: Vec<(String, Vec<u8>)>,
}

/// What is rendered of a scene, and how it is encoded.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RenderSpec {
    /// The size of the picture, and what it shows.
    pub(crate) window: Window,
    /// The part of it that is rendered, which must fit the window.
    pub(crate) region: Region,
    /// Mirroring, rotation and tone, for formats of 8 bits.
    pub(crate) adjustment: Adjustment,
    /// The format of the file.
    pub(crate) format: FileFormat,
    /// Layers beside the colors.
    pub(crate) layers: Layers,
    /// Whether the file contains a note on its error bounds and on how to render it again, if its format can hold one.
    pub(crate) note: bool,
    /// Whether the report contains an estimate made before the render.
    pub(crate) predict: bool,
    /// When a picture with a time limit was requested. Waiting is part of its time.
    pub(crate) asked: Option<Instant>,
}

impl RenderSpec {
    /// A part of the scene's own picture.
    pub(crate) fn of(scene: &Scene, region: Region, format: FileFormat) -> Self {
        let window = Window::whole(scene.width, scene.height);
        Self {
            window,
            region,
            adjustment: Adjustment::default(),
            format,
            layers: Layers::default(),
            note: false,
            predict: false,
            asked: None,
        }
    }
}

/// Has a picture rendered by others; none if they cannot.
pub(crate) type RemoteRender<'a> = &'a dyn Fn(&RenderSpec) -> Result<Option<Picture>, Cancelled>;

/// Renders a picture and encodes it. `started` is when work on the scene's bytes began, `loading` is what that took. A picture
/// that a time or a number of rays ends is shown to `watcher` meanwhile.
pub(crate) fn make(
    started: Instant,
    ready: &PreparedScene,
    loading: Loading,
    spec: &RenderSpec,
    workers: &Workers,
    control: &Control,
    watcher: Option<Watcher<'_>>,
    remote: Option<RemoteRender<'_>>,
) -> Result<Rendered, Cancelled> {
    let scene = &ready.scene;
    let &RenderSpec { window, region, adjustment, format, layers, note: has_note, predict, asked } = spec;
    let mut plan = ready.outline.plan(scene);
    if predict && !matches!(ready.render.accuracy(), Accuracy::Time(_)) {
        workers.work(|| plan.estimate(scene, region, control, Effort::BESIDE))??;
    }
    // The codes are made on the pool; the file takes one thread, while the pool goes on.
    let finish = |picture: &Picture| {
        let coding = Stopwatch::start();
        let codes = Codes::new(&picture.film, format).adjusted(adjustment);
        (codes, ErrorBounds::about(picture, scene), coding.milliseconds())
    };
    let began = asked.unwrap_or(started);
    let (mut picture, (codes, error, coding_ms)) = match remote.map_or(Ok(None), |render| render(spec))? {
        Some(picture) => {
            let finished = workers.work(|| finish(&picture))?;
            (picture, finished)
        }
        None => trace(ready, &window, region, format, began, workers, control, watcher, finish)?,
    };
    let replay = Replay::of(&picture, ready);
    let mut made = Vec::new();
    if !layers.is_empty() {
        let trace = || {
            let tracing = Stopwatch::start();
            let layers = render_layers(scene, &window, region, control, layers);
            layers.map(|(layers, rays)| (layers, rays, tracing.milliseconds()))
        };
        let (layers, rays, ms) = workers.work(trace)??;
        (made, picture.rays) = (layers, picture.rays + rays);
        picture.trace_ms += ms;
    }
    let writing = Instant::now();
    let (file, layers) = if format == FileFormat::Exr && !made.is_empty() {
        (encode_exr_with(&picture.film, made.into_iter().map(|(_, layer)| layer).collect()), Vec::new())
    } else {
        let note = has_note.then(|| note(&error, &replay));
        let layers = made.iter().map(|(kind, layer)| (kind.name(), layer.png(region, format)));
        (codes.file_with(&picture.film, format, note.as_deref()), layers.collect())
    };
    if control.is_cancelled() {
        // The file may be cut short.
        return Err(Cancelled);
    }
    let phases = Phases {
        parse: loading.parse,
        plan: loading.plan,
        bvh: loading.bvh,
        trace: picture.trace_ms,
        refine: picture.refine_ms,
        png: coding_ms + milliseconds(writing),
    };
    let cost = Cost::of(&picture, phases, plan.estimate, started, workers);
    Ok(Rendered { file, report: Report { plan, cost, error, replay }, layers })
}

/// Traces a region of a window as the scene's accuracy asks. A picture in a time ends so that its file is ready in that
/// time since `began`. Such a picture, and one of so many rays, are shown to `watcher` meanwhile. `finish` is done on the pool,
/// right after it.
pub(crate) fn trace<T: Send>(
    ready: &PreparedScene,
    window: &Window,
    region: Region,
    format: FileFormat,
    began: Instant,
    workers: &Workers,
    control: &Control,
    watcher: Option<Watcher<'_>>,
    finish: impl FnOnce(&Picture) -> T + Send,
) -> Result<(Picture, T), Cancelled> {
    let scene = &ready.scene;
    let finished = |picture: Result<Picture, Cancelled>| {
        let picture = picture?;
        let finished = finish(&picture);
        Ok((picture, finished))
    };
    let until = |stop: Stop| render_watched(scene, window, region, control, stop, watcher);
    match ready.render.accuracy() {
        Accuracy::Time(Time { ms }) => {
            let tracing = (ms - file_ms(region, format, scene.display(), workers.threads())).max(0.0);
            let end = began + Duration::from_secs_f64(tracing / 1e3);
            workers.work_until(end, || finished(until(Stop::At(end))))
        }
        Accuracy::Rays(Rays { count }) => workers.work(|| finished(until(Stop::Rays(count)))),
        Accuracy::Fixed(_) | Accuracy::Proved(_) | Accuracy::Statistical(_) => {
            workers.work(|| finished(render_window(scene, window, region, control)))
        }
    }?
}

/// The note in a picture file: all of the cost report that depends on neither the machine nor the time, since the same
/// request gives the same bytes everywhere.
pub(crate) fn note(error: &ErrorBounds, replay: &Replay) -> String {
    json!({ "error": error, "replay": replay }).to_string()
}

/// Upper estimate of the milliseconds from the last ray to the end of the file: filling in and judging the pixels of a region
/// on all threads, and writing the file on one.
fn file_ms(region: Region, format: FileFormat, display: &Display, threads: usize) -> f64 {
    let file = match format {
        FileFormat::Png8 => 25.0,
        _ => 100.0,
    };
    // Its pixels go through the tone curve for the last look at the picture and for the file.
    let shared = 30.0 + 2.0 * display.nanoseconds();
    1.5 + region.pixels() as f64 * (file + shared / threads as f64) * 1e-6
}
