//! From a loaded scene to a picture file and its cost report.

use crate::pieces::render_in_pieces;
use crate::ready::{Loading, Ready};
use crate::report::{Cost, ErrorBounds, Phases, Replay, Report};
use crate::workers::Workers;
use std::time::Instant;
use strahl::camera::Window;
use strahl::film::{Codes, FileFormat, Film, Look, Region};
use strahl::render::{Cancelled, Control};
use strahl::scene::Scene;

/// A picture file and what it cost.
#[derive(Debug)]
pub(crate) struct Finished {
    /// The bytes of the file.
    pub(crate) file: Vec<u8>,
    /// What it cost.
    pub(crate) report: Report,
}

/// What is made of a scene.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shot {
    /// How large the picture is, and what it shows.
    pub(crate) window: Window,
    /// The part of it that is rendered; it must fit the window.
    pub(crate) region: Region,
    /// What is done to its codes, for formats of 8 bits.
    pub(crate) look: Look,
    /// The format of the file.
    pub(crate) format: FileFormat,
}

impl Shot {
    /// A part of the scene's own picture.
    pub(crate) fn of(scene: &Scene, region: Region, format: FileFormat) -> Self {
        Self { window: Window::whole(scene.width, scene.height), region, look: Look::default(), format }
    }
}

/// Renders a picture and encodes it. `started` is when work on the scene's bytes began,
/// `loading` what that took.
pub(crate) fn make(
    started: Instant,
    ready: &Ready,
    loading: Loading,
    shot: &Shot,
    workers: &Workers,
    control: &Control,
) -> Result<Finished, Cancelled> {
    let scene = &ready.scene;
    let &Shot { window, region, look, format } = shot;
    // The codes are made in the last turn on the pool; the file takes one thread, while the pool goes on.
    let code = |film: &Film| {
        let coding = Instant::now();
        (Codes::new(film, format).seen(look), milliseconds(coding))
    };
    let (picture, (codes, coding_ms)) = render_in_pieces(scene, &window, region, workers, control, code)?;
    let writing = Instant::now();
    let file = codes.file(&picture.film, format);
    let phases = Phases {
        parse: loading.parse,
        plan: loading.plan,
        bvh: loading.bvh,
        trace: picture.trace_ms,
        png: coding_ms + milliseconds(writing),
    };
    let cost = Cost {
        wall_ms: milliseconds(started),
        phases_ms: phases,
        rays: picture.rays,
        camera_hits: picture.rays.camera_hits,
        refined: picture.refined,
        threads: workers.threads(),
    };
    let replay = Replay {
        version: env!("CARGO_PKG_VERSION"),
        image: [window.width, window.height],
        region,
        render: ready.render,
        two_sided: ready.two_sided,
        spd_counts: ready.spd_counts,
    };
    Ok(Finished { file, report: Report { plan: ready.plan.clone(), cost, error: ErrorBounds::default(), replay } })
}

/// Milliseconds since an instant.
pub(crate) fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
