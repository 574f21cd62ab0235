//! `GET /livez`, `GET /readyz`: whether the service is alive, and whether it accepts work.

use crate::http::prelude::*;

pub(super) fn routes() -> Vec<Route> {
    vec![
        Route::get("/livez", livez, ["livez", "service", "Whether the process answers."]).answer(
            200,
            "It does",
            &[Content::text("text/plain")],
        ),
        Route::get(
            "/readyz",
            readyz,
            [
                "readyz",
                "service",
                "Whether the service takes work. A busy service is ready; one that is about to stop is not, nor one with a \
                 render that does not stop, nor one that cannot write the records or files of jobs.",
            ],
        )
        .answer(200, "It takes work", &[Content::json::<Readiness>()])
        .answer(503, "It takes none, for the reason that `status` says", &[Content::json::<Readiness>()]),
    ]
}

/// Whether the service takes work, and how much it has.
#[derive(Debug, Serialize, JsonSchema)]
struct Readiness {
    /// `ready`, `draining`, `stalled` (a render does not notice that it was paused or cancelled) or `unwritable` (the disk does
    /// not take the records of jobs, or the folders of their files are gone).
    status: &'static str,
    /// Requests under way.
    running: usize,
    /// Requests that wait.
    waiting: usize,
    /// Jobs.
    jobs: JobCounts,
}

/// How many jobs there are.
#[derive(Debug, Serialize, JsonSchema)]
struct JobCounts {
    /// Jobs that wait.
    waiting: usize,
    /// Jobs that are rendered.
    running: usize,
}

const NO_STORE: [(header::HeaderName, &str); 1] = [(header::CACHE_CONTROL, "no-store")];

pub(super) async fn livez() -> impl IntoResponse {
    (NO_STORE, "alive\n")
}

pub(super) async fn readyz(State(app): State<App>) -> impl IntoResponse {
    let (code, status) = match () {
        () if app.drain.has_begun() => (StatusCode::SERVICE_UNAVAILABLE, "draining"),
        () if app.service.pool.scheduler.is_stalled() => (StatusCode::SERVICE_UNAVAILABLE, "stalled"),
        () if app.service.jobs.is_unwritable() => (StatusCode::SERVICE_UNAVAILABLE, "unwritable"),
        () => (StatusCode::OK, "ready"),
    };
    let (waiting, running) = app.service.jobs.counts();
    let jobs = JobCounts { waiting, running };
    let (queue, tiles) = (&app.service.queue, &app.service.tiles);
    let (running, waiting) = (queue.running() + tiles.running(), queue.waiting() + tiles.waiting());
    (code, NO_STORE, Json(Readiness { status, running, waiting, jobs }))
}
