//! `GET /v1/me`: who asks, and what it may do. `GET /v1/queue`: who waits for the renderer.

use crate::http::prelude::*;
use crate::service::scheduler::admission::Queue;
use axum::http::Extensions;
use std::time::Instant;

pub(super) fn routes() -> Vec<Route> {
    let about_me = "Whose key this is, what it may do, and what is left of its limits.";
    let about_queue = "How busy the renderer is: its threads, and who has it and waits for it.";
    vec![
        Route::get("/v1/me", me, ["me", "service", about_me]).answer(
            200,
            "The tenant",
            &[Content::json::<KeyInfo<'_>>()],
        ),
        Route::get("/v1/queue", queue, ["queue", "service", about_queue]).answer(
            200,
            "The queue",
            &[Content::json::<QueueStatus>()],
        ),
    ]
}

/// The tenant of a key.
#[derive(Debug, Serialize, JsonSchema)]
struct KeyInfo<'a> {
    /// Its name.
    tenant: &'a str,
    /// What the key may do.
    scopes: &'a [Scope],
    /// Whether the service asks for keys. Without them everybody is the same tenant.
    needs_keys: bool,
    /// The tenant's share of the renderer beside others.
    weight: u32,
    /// Waiting and running jobs that it may have.
    most_jobs: u32,
    /// Event streams that it may have open.
    most_streams: u32,
    /// Bytes of the assets that it has sent.
    asset_bytes: u64,
    /// What is left of the units of a minute. Null: unlimited.
    units: Option<RateLimitUnits>,
}

/// Units of cost: one for each request, and one for each million rays.
#[derive(Debug, Serialize, JsonSchema)]
struct RateLimitUnits {
    /// Units in a minute.
    per_minute: u32,
    /// Units that are left.
    left: u32,
    /// Seconds until all are there again.
    full_in_s: u32,
}

/// Who has the renderer and waits for it.
#[derive(Debug, Serialize, JsonSchema)]
struct QueueStatus {
    /// Threads of the renderer.
    threads: usize,
    /// Requests for pictures and answers.
    renders: QueueLane,
    /// Requests for tiles.
    tiles: QueueLane,
    /// Jobs.
    jobs: QueueLane,
    /// Seconds until a request that comes now should have its turn, at the pace of the last ones.
    seconds_ahead: u32,
}

/// A lane of the scheduler.
#[derive(Debug, Serialize, JsonSchema)]
struct QueueLane {
    /// How many are worked on, in turn.
    running: usize,
    /// How many wait.
    waiting: usize,
}

impl From<&Queue> for QueueLane {
    fn from(queue: &Queue) -> Self {
        Self { running: queue.running(), waiting: queue.waiting() }
    }
}

async fn me(State(app): State<App>, extensions: Extensions) -> Result<Response, Problem> {
    let tenant = Tenant::required(&extensions)?;
    let units = tenant.rate_limit.as_ref().map(|limit| {
        let left = limit.left(Instant::now());
        RateLimitUnits { per_minute: left.per_minute, left: left.units, full_in_s: left.full_in }
    });
    let me = KeyInfo {
        tenant: &tenant.name,
        scopes: &tenant.scopes,
        needs_keys: app.access.needs_keys(),
        weight: tenant.weight,
        most_jobs: tenant.quotas.jobs,
        most_streams: tenant.quotas.streams,
        asset_bytes: app.service.assets.bytes(&tenant.name)[0],
        units,
    };
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(me)).into_response())
}

async fn queue(State(app): State<App>, extensions: Extensions) -> Result<Response, Problem> {
    Tenant::required(&extensions)?;
    let service = &app.service;
    let (waiting, running) = service.jobs.counts();
    let is_idle = service.queue.running() + service.queue.waiting() == 0;
    let queued = QueueStatus {
        threads: service.pool.threads,
        renders: QueueLane::from(&service.queue),
        tiles: QueueLane::from(&service.tiles),
        jobs: QueueLane { running, waiting },
        seconds_ahead: if is_idle { 0 } else { service.queue.retry_after() },
    };
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(queued)).into_response())
}
